"""Commented scenes of typical machines, described by stations (`rsc new pump` etc.), not of any manufacturer.

(guess): of a typical size, to be replaced. Balance grades are those of ISO 21940-11 for such rotors; for friction and contact
stiffness see docs/users/numbers.md.
"""

_HEAD = """\
# {about}
# Positions are measured from the left end of the shaft. (guess): typical of such machines, replace by your own numbers. A
# quantity is a number in SI (speeds in Hz) or a text with a unit. First `rsc modes` (are the modes where you expect them?),
# then `rsc predict` and `rsc check`.
title = "{title}"

[rotor]
model = "shaft"
"""
_PUMP = """\
material = "steel"              # EN 1993-1-1: 210 GPa, 0.3; EN 1991-1-1: 7850 kg/m^3
sections = [                    # (guess) all
  {length = "110 mm", diameter = "42 mm"},                      # coupling end
  {length = "260 mm", diameter = "55 mm"},                      # between the bearings
  {length = "120 mm", diameter = "48 mm"},                      # shaft seal
  {name = "impeller seat", length = "70 mm", diameter = "38 mm"},
]
disks = [
  {name = "coupling", at = "30 mm", diameter = "130 mm", width = "60 mm"},      # (guess), inertias from the shape
  # (guess)
  {name = "impeller", at = "520 mm", mass = "9.5 kg", polar_inertia = "0.11 kg m^2", diametral_inertia = "0.062 kg m^2"},
]
bearings = [                    # ball bearings (guess)
  {name = "drive_end", at = "135 mm", stiffness = "1.2e8 N/m", damping = "800 N s/m"},
  {name = "pump_end", at = "350 mm", stiffness = "1.5e8 N/m", damping = "800 N s/m"},
  {name = "wear_ring_fluid", at = "535 mm", stiffness = [2e6, 6e5, -6e5, 2e6], damping = "3e3 N s/m"},  # [yy, yz, zy, zz] (guess)
]
unbalance = "G 6.3"             # ISO 21940-11: pumps
gravity = 9.81
"""
_PUMP_OTHERS = """\
[stator]                        # casing with its wear ring
model = "laval"
mass = "25 kg"                  # (guess)
frequency = "140 Hz"            # (guess)
damping_ratio = 0.04            # (guess)

[contact]                       # front wear ring
at = "535 mm"
diameter = "120 mm"             # (guess)
gap = "0.2 mm"                  # (guess) radial
friction = 0.15                 # (guess) wet
stiffness = "5e7 N/m"           # (guess)
damping_ratio = 0.05            # (guess)

[[clearance]]
name = "shaft_seal"
at = "430 mm"
gap = "0.4 mm"                  # (guess)

[drive]
speed = "2980 rpm"              # two poles at 50 Hz, with slip
duration = "1 s"
"""
_FAN = """\
material = "steel"              # EN 1993-1-1: 210 GPa, 0.3; EN 1991-1-1: 7850 kg/m^3
sections = [                    # (guess) all
  {length = "200 mm", diameter = "80 mm"},
  {length = "900 mm", diameter = "110 mm"},
  {name = "hub", length = "250 mm", diameter = "95 mm"},
]
disks = [
  {name = "coupling", at = "60 mm", diameter = "250 mm", width = "90 mm"},      # (guess), inertias from the shape
  {name = "wheel", at = "1250 mm", mass = "180 kg", polar_inertia = "26 kg m^2", diametral_inertia = "15 kg m^2"},  # (guess)
]
bearings = [                    # roller bearings on a steel frame (guess)
  {name = "drive_end", at = "260 mm", stiffness = ["6e7 N/m", 0, 0, "9e7 N/m"], damping = "4e3 N s/m"},
  {name = "fan_end", at = "1020 mm", stiffness = ["6e7 N/m", 0, 0, "9e7 N/m"], damping = "4e3 N s/m"},
]
unbalance = "G 6.3"             # ISO 21940-11: fans
gravity = 9.81
"""
_FAN_OTHERS = """\
[stator]                        # inlet cone
model = "laval"
mass = "30 kg"                  # (guess)
frequency = "45 Hz"             # (guess) sheet metal
damping_ratio = 0.02            # (guess)

[contact]                       # wheel against inlet cone
at = "wheel"
diameter = "700 mm"             # (guess)
gap = "3 mm"                    # (guess)
friction = 0.3                  # (guess) dry
stiffness = "5e6 N/m"           # (guess) sheet metal
damping_ratio = 0.05            # (guess)

[drive]
speed = "990 rpm"               # six poles at 50 Hz, with slip
duration = "2 s"
"""
_COMPRESSOR = """\
material = "steel"              # EN 1993-1-1: 210 GPa, 0.3; EN 1991-1-1: 7850 kg/m^3
sections = [                    # (guess) all
  {length = "150 mm", diameter = "70 mm"},
  {name = "left_journal", length = "120 mm", diameter = "90 mm"},
  {name = "stages", length = "800 mm", diameter = "120 mm"},
  {name = "right_journal", length = "120 mm", diameter = "90 mm"},
  {length = "90 mm", diameter = "80 mm"},
]
sleeves = [{at = "300 mm", length = "720 mm", diameter = "140 mm"}]             # spacers between the impellers (guess)
disks = [                       # impellers (guess)
  {name = "coupling", at = "40 mm", diameter = "180 mm", width = "50 mm"},
  {name = "stage_1", at = "400 mm", mass = "14 kg", polar_inertia = "0.26 kg m^2", diametral_inertia = "0.15 kg m^2"},
  {name = "stage_2", at = "530 mm", mass = "13 kg", polar_inertia = "0.24 kg m^2", diametral_inertia = "0.14 kg m^2"},
  {name = "stage_3", at = "660 mm", mass = "13 kg", polar_inertia = "0.24 kg m^2", diametral_inertia = "0.14 kg m^2"},
  {name = "stage_4", at = "790 mm", mass = "12 kg", polar_inertia = "0.21 kg m^2", diametral_inertia = "0.12 kg m^2"},
  {name = "thrust_collar", at = "1230 mm", diameter = "220 mm", width = "30 mm"},
]
bearings = [                    # tilting pads: no cross-coupling (guess); over the speed: {at = ..., table = "bearing.csv"}
  {name = "left", at = {section = "left_journal", left = "60 mm"}, stiffness = [6e7, 0, 0, 9e7], damping = "1e5 N s/m"},
  {name = "right", at = {section = "right_journal", right = "60 mm"}, stiffness = [6e7, 0, 0, 9e7], damping = "1e5 N s/m"},
  {name = "balance_piston", at = "950 mm", stiffness = [4e6, 5e6, -5e6, 4e6], damping = "6e3 N s/m"},   # a seal (guess)
]
unbalance = "G 2.5"             # ISO 21940-11: compressors
gravity = 9.81
"""
_COMPRESSOR_OTHERS = """\
[stator]                        # diaphragms with their labyrinths
model = "laval"
mass = "60 kg"                  # (guess)
frequency = "300 Hz"            # (guess)
damping_ratio = 0.05            # (guess)

[contact]                       # balance piston
at = "950 mm"
gap = "0.2 mm"                  # (guess) radial
friction = 0.2                  # (guess)
stiffness = "8e7 N/m"           # (guess)
damping_ratio = 0.05            # (guess)

[[clearance]]                   # impeller eye of the first stage; as a second [[contact]] it would touch
name = "impeller_eye"
at = "stage_1"
gap = "0.3 mm"                  # (guess)

[[clearance]]
name = "left_oil_seal"
at = {section = "left_journal", right = "10 mm"}
gap = "0.15 mm"                 # (guess)

[drive]
speed = "9000 rpm"              # (guess)
duration = "0.2 s"
"""
_TURBOCHARGER = """\
material = "steel"              # EN 1993-1-1: 210 GPa, 0.3; EN 1991-1-1: 7850 kg/m^3
sections = [                    # (guess) all
  {length = "30 mm", diameter = "6 mm"},                        # under the compressor wheel
  {length = "70 mm", diameter = "9 mm"},                        # between the wheels, with both bearings
  {length = "12 mm", diameter = ["9 mm", "16 mm"]},             # root of the turbine wheel
]
disks = [                       # (guess)
  {name = "compressor_wheel", at = "14 mm", mass = "70 g", polar_inertia = "2.2e-5 kg m^2", diametral_inertia = "1.6e-5 kg m^2"},
  {name = "turbine_wheel", at = "110 mm", mass = "160 g", polar_inertia = "4.5e-5 kg m^2", diametral_inertia = "3.5e-5 kg m^2"},
]
bearings = [                    # floating rings: oil films with cross-coupling (guess)
  {name = "compressor_side", at = "45 mm", stiffness = [1e6, 1e5, -1e5, 1e6], damping = "120 N s/m"},
  {name = "turbine_side", at = "85 mm", stiffness = [1e6, 1e5, -1e5, 1e6], damping = "120 N s/m"},
]
unbalance = [                   # (guess)
  {at = "compressor_wheel", amount = "0.1 g mm", angle = "0 deg"},
  {at = "turbine_wheel", amount = "0.2 g mm", angle = "90 deg"},
]
"""
_TURBOCHARGER_OTHERS = """\
[stator]                        # contour ring of the compressor
model = "laval"
mass = "0.4 kg"                 # (guess)
frequency = "900 Hz"            # (guess)
damping_ratio = 0.03            # (guess)

[contact]                       # blade tips of the compressor wheel
at = "compressor_wheel"
diameter = "48 mm"              # (guess)
gap = "0.2 mm"                  # (guess)
friction = 0.2                  # (guess) against an abradable lining
stiffness = "2e6 N/m"           # (guess)
damping_ratio = 0.1             # (guess)

[[clearance]]
name = "turbine_tips"
at = "turbine_wheel"
gap = "0.35 mm"                 # (guess)

[drive]
speed = "90000 rpm"             # (guess)
duration = "50 ms"
"""
_GENERATOR = """\
material = "steel"              # EN 1993-1-1: 210 GPa, 0.3; EN 1991-1-1: 7850 kg/m^3
sections = [                    # (guess) all
  {length = "350 mm", diameter = "200 mm"},
  {name = "left_journal", length = "250 mm", diameter = "250 mm"},
  {length = "300 mm", diameter = "320 mm"},
  {name = "core", length = "1400 mm", diameter = "450 mm"},
  {length = "300 mm", diameter = "320 mm"},
  {name = "right_journal", length = "250 mm", diameter = "250 mm"},
]
sleeves = [                     # pole body and winding: mass, and a tenth of the stiffness of steel (guess)
  {at = "900 mm", length = "1400 mm", diameter = "900 mm", material = {density = "6500 kg/m^3", youngs_modulus = "21 GPa"}},
]
disks = [
  {name = "coupling", at = "80 mm", diameter = "600 mm", width = "120 mm"},     # (guess)
  {name = "fan", at = "2450 mm", diameter = "800 mm", width = "20 mm"},         # (guess)
]
bearings = [                    # journal bearings at their speed: [yy, yz, zy, zz] (guess)
  {name = "left", at = "475 mm", stiffness = [6e8, 2e8, -7e8, 1.2e9], damping = [4e6, -6e5, -6e5, 8e6]},
  {name = "right", at = "2725 mm", stiffness = [6e8, 2e8, -7e8, 1.2e9], damping = [4e6, -6e5, -6e5, 8e6]},
]
unbalance = "G 2.5"             # ISO 21940-11: electric machines above 950 rpm
gravity = 9.81
"""
_GENERATOR_OTHERS = """\
[stator]                        # housing with the ring of its seal
model = "laval"
mass = "400 kg"                 # (guess)
frequency = "60 Hz"             # (guess)
damping_ratio = 0.04            # (guess)

[contact]                       # oil seal at the left bearing
at = {section = "left_journal", right = "10 mm"}
gap = "0.3 mm"                  # (guess)
friction = 0.15                 # (guess) brass, oily
stiffness = "1e8 N/m"           # (guess)
damping_ratio = 0.05            # (guess)

[[clearance]]
name = "air_gap"
at = {section = "core", left = "700 mm"}
gap = "6 mm"                    # (guess)

[drive]
speed = "1500 rpm"              # four poles at 50 Hz
duration = "1 s"
"""
_RIG = """\
material = "steel"              # EN 1993-1-1: 210 GPa, 0.3; EN 1991-1-1: 7850 kg/m^3
sections = [{length = "560 mm", diameter = "10 mm"}]                            # (guess) a silver steel rod
disks = [
  {name = "left_disk", at = "200 mm", diameter = "75 mm", width = "25 mm"},     # (guess), inertias from the shape
  {name = "right_disk", at = "360 mm", diameter = "75 mm", width = "25 mm"},    # (guess)
]
bearings = [                    # sintered bushings in stiff blocks (guess)
  {name = "motor_side", at = "40 mm", stiffness = "1e7 N/m", damping = "100 N s/m"},
  {name = "free_side", at = "520 mm", stiffness = "1e7 N/m", damping = "100 N s/m"},
]
shaft_damping = "5e-6 s"        # internal (guess)
rayleigh = [4.0, 0.0]           # air and bushings, 1/s and s (guess)
unbalance = [{at = "left_disk", amount = "30 g mm"}]                            # a screw in the disk (guess)
gravity = 9.81
"""
_RIG_OTHERS = """\
[stator]                        # a bronze ring on four springs
model = "laval"
mass = "0.6 kg"                 # (guess)
frequency = "60 Hz"             # (guess)
damping_ratio = 0.05            # (guess)

[contact]
at = "280 mm"                   # between the disks
gap = "0.5 mm"                  # (guess)
friction = 0.2                  # (guess) steel on bronze, dry
stiffness = "2e6 N/m"           # (guess)
damping_ratio = 0.05            # (guess)

[drive]
speed = ["10 rpm", "3000 rpm"]  # a run-up
duration = "10 s"
"""
_END = """
[start]
{start}

[output]
rate = {rate}                     # samples per second
"""
_MACHINES = {
    "pump": ("An end-suction pump with an overhung impeller: contact at the wear ring.", "Pump", _PUMP, _PUMP_OTHERS, 4000),
    "fan": ("A fan with an overhung wheel on a soft frame: contact at the inlet cone.", "Fan", _FAN, _FAN_OTHERS, 2000),
    "compressor": (
        "A compressor of four stages between bearings: contact at the balance piston.", "Compressor",
        _COMPRESSOR, _COMPRESSOR_OTHERS, 20000,
    ),
    "turbocharger": (
        "A turbocharger on floating rings: contact at the compressor wheel.", "Turbocharger",
        _TURBOCHARGER, _TURBOCHARGER_OTHERS, 100000,
    ),
    "generator": (
        "A generator with four poles on journal bearings: contact at an oil seal.", "Generator",
        _GENERATOR, _GENERATOR_OTHERS, 2000,
    ),
    "rig": ("A laboratory rig: two disks on a thin shaft in a ring on springs.", "Laboratory rig", _RIG, _RIG_OTHERS, 5000),
}  # fmt: skip
MACHINES = {name: about for name, (about, *_) in _MACHINES.items()}


def machine_template(machine: str, start: str) -> str:
    """The text of one of `MACHINES`; start: the lines of its [start]."""
    about, title, rotor, others, rate = _MACHINES[machine]
    return _HEAD.format(about=about, title=title) + rotor + "\n" + others + _END.format(start=start, rate=rate)
