"""Commented template scenes, one per rotor model (`rsc new MODEL`), and those of machines described by stations."""

from rsc.errors import SceneError, nearest, shown
from rsc.scene.files.machine_templates import MACHINES, machine_template

_LAVAL = '''\
# A Laval rotor in an elastically held ring. Plain numbers are SI, frequencies and rotor speeds Hz; any quantity may be
# a text with a unit instead: "0.2 mm", "3000 rpm", "2 kN/m".
title = "Laval rotor in a light stator"

[rotor]
model = "laval"
mass = 1.0
frequency = 30.0                # or stiffness
damping_ratio = 0.02            # or damping in N s/m
eccentricity = "0.05 mm"        # or a balance grade, "G 6.3", or [amount, angle in degrees]
# gravity = 9.81                # weight along -z; or load = [[f_y, f_z]] in N

[stator]
model = "laval"                 # or "rigid" (no other keys), "chain", "matrices"
mass = 0.25
frequency = 150.0
damping_ratio = 0.1
'''

_DISK = '''\
# One disk with gyroscopics on a flexible shaft: displacement (coordinate 0) and tilt (coordinate 1). Plain numbers are
# SI, frequencies and rotor speeds Hz; any quantity may be a text with a unit instead: "0.2 mm", "3000 rpm".
title = "Disk with gyroscopics in a light stator"

[rotor]
model = "disk"
mass = 1.0
diametral_inertia = 0.010       # kg m^2
polar_inertia = 0.016
stiffness = [[70e3, -3200.0], [-3200.0, 1300.0]]   # N/m, N/rad; N/rad, N m/rad
damping_ratio = 0.005           # in every mode at standstill; or damping = 2 x 2 matrix
eccentricity = "0.05 mm"        # or a balance grade, "G 6.3", or [amount, angle in degrees]
# angular_eccentricity = "0.01 deg"
# gravity = 9.81                # weight along -z; or load = [[f_y, f_z], [m_y, m_z]]

[stator]
model = "laval"                 # or "rigid" (no other keys), "chain", "matrices"
mass = 0.1
stiffness = 42e3
damping = 24.0
'''

_CHAIN = '''\
# Disks in a row between two walls, in a stator that is also a row of masses. Plain numbers are SI, frequencies and
# rotor speeds Hz; any quantity may be a text with a unit instead: "0.2 mm", "3000 rpm", "2 kN/m".
title = "Three disks in a chain, contact at the middle one"

[rotor]
model = "chain"
masses = [1.0, 1.5, 1.0]
stiffnesses = ["100 kN/m", "100 kN/m", "100 kN/m", "100 kN/m"]   # wall-1, 1-2, 2-3, 3-wall; 0 for a free end
damping_ratio = 0.01            # in every mode; or dampings (like stiffnesses), or rayleigh = [alpha, beta]
eccentricity = "0.05 mm"        # one for all, or a list with one per mass
# gravity = 9.81                # weight along -z; or load = [[f_y, f_z], ...] in N per mass

[stator]
model = "chain"                 # or "rigid" (no other keys), "laval", "matrices"
masses = [0.3, 0.2]
stiffnesses = ["600 kN/m", "600 kN/m", 0.0]
damping_ratio = 0.1
'''

_MATRICES = '''\
# Any rotor and stator, given by their matrices in SI (a tilt coordinate is an angle in rad). A matrix is a nested list
# or a file in the folder of the scene: "machine.npz" or "machine.mat" (array named like the key), "mass.mtx" (Matrix Market).
title = "Rotor and stator given by matrices"

[rotor]
model = "matrices"
mass = [[1.0, 0.0], [0.0, 2.3]]
stiffness = [[18.0e3, -16.0e3], [-16.0e3, 25.0e3]]
rayleigh = [0.0, 9.5e-5]        # alpha in 1/s, beta in s; or damping = matrix, or damping_ratio
# gyroscopic = [[0.0, 0.0], [0.0, 0.1]]            # real symmetric: polar inertias on tilt coordinates
# tilt_coordinates = [1]        # these coordinates are angles
eccentricity = [5e-5, 5e-5]     # per coordinate, each a number or [amount, angle in degrees]
# gravity = 9.81                # weight along -z; or load = [[f_y, f_z], ...] per coordinate

[stator]
model = "matrices"              # or "rigid" (no other keys), "laval", "chain"
mass = [[0.1, 0.0], [0.0, 3.0]]
stiffness = [[58e3, -58e3], [-58e3, 110e3]]
rayleigh = [0.0, 5.5e-4]
'''

_CONTACT = '''
[contact]
{coordinates}gap = "1 mm"
friction = {friction}
stiffness = {stiffness}
damping_ratio = 0.05            # of the reduced mass at the contact; or damping in N s/m
diameter = "{diameter}"              # of the rotor at the contact; without it friction is one-sided and never reverses
# ring_eccentricity = "0.01 mm" # of the contact ring; or [amount, angle in degrees]

[drive]
speed = {speed}            # one number: constant; two: linear run-up or run-down
duration = "{duration}"               # or, instead of both, schedule = [[0, 20], [30, 100], [40, 100]]

[start]
{start}

[solver]
rtol = 1e-6

[output]
rate = 2000                     # samples per second
'''

_STARTS = {
    "whirl": """# does a whirl persist? Start on a predicted one; whether the rotor gets there: rsc new {model} --start rest
whirl = "backward"              # or its frequency in Hz; or rotor = [[y, z], ...]""",
    "rest": """# does the rotor get into a whirl? Start from rest; whether a whirl persists: rsc new {model}
rest = true                     # or running = true (the steady motion without contact)
# impulse = ["1 N s", "0 N s"]    # an impulse on the rotor at the contact""",
}
_PLACES = "rotor_coordinate = {0}            # counted from 0\nstator_coordinate = {0}\n"
_TEMPLATES = {
    "laval": (_LAVAL, {"friction": 0.2, "stiffness": "3.5e6", "speed": "[20.0, 100.0]", "duration": "30 s"}),
    "disk": (_DISK, {"friction": 0.32, "stiffness": "1.2e7", "speed": "[20.0, 150.0]", "duration": "60 s"}),
    "chain": (_CHAIN, {"friction": 0.2, "stiffness": "1.0e7", "speed": "[20.0, 100.0]", "duration": "30 s"}),
    "matrices": (_MATRICES, {"friction": 0.19, "stiffness": "1.8e6", "speed": "[5.0, 50.0]", "duration": "60 s"}),
}
_CONTACT_AT = {"chain": _PLACES.format(1), "matrices": _PLACES.format(0)}
_DIAMETER = {"laval": "40 mm", "disk": "40 mm", "chain": "40 mm", "matrices": "80 mm"}
MODELS = tuple(_TEMPLATES)
STARTS = tuple(_STARTS)
ABOUT = {
    "laval": "One disk on a massless shaft in an elastic ring.",
    "disk": "One disk with gyroscopics on a flexible shaft.",
    "chain": "Disks in a row.",
    "matrices": "Any rotor and stator, by their matrices.",
} | MACHINES


def template(model: str, start: str | None = None) -> str:
    """Return the text of a commented template scene.

    Parameters
    ----------
    model : str
        One of `ABOUT`: a model, "laval", "disk", "chain" or "matrices", or one of `MACHINES`.
    start : str, optional
        One of `STARTS`: "whirl" (does a whirl persist?), the default of models, or "rest" (does the rotor get into a whirl?).

    Returns
    -------
    str
        TOML of a valid scene.

    Raises
    ------
    SceneError
        Unknown model or start.
    """
    start = start or ("rest" if model in MACHINES else "whirl")
    for name, value, known in (("model", model, tuple(ABOUT)), ("start", start, STARTS)):
        if not isinstance(value, str) or value not in known:
            raise SceneError("<template>", name, shown(value), "one of " + ", ".join(known), nearest(value, known))
    if model in MACHINES:
        return machine_template(model, _STARTS[start].format(model=model))
    bodies, values = _TEMPLATES[model]
    more = {"coordinates": _CONTACT_AT.get(model, ""), "diameter": _DIAMETER[model], "start": _STARTS[start].format(model=model)}
    return bodies + _CONTACT.format(**values, **more)
