"""Quantities: SI numbers and texts with units."""

import math
import subprocess
import sys

import pytest

from rsc.units import DIMENSIONS, QuantityError, quantity
from rsc.units.table import AMBIGUOUS, GROUPS, TOGETHER
from rsc.units.together import refuse_mixed, spread
from rsc.units.unit_text import unit_of


@pytest.mark.parametrize(
    ("value", "dimension", "expected"),
    [
        (1e-3, "length", 1e-3),
        (3, "mass", 3.0),
        ("0.2 mm", "length", 2e-4),
        ("0.3mm", "length", 3e-4),
        ("-5 um", "length", -5e-6),
        ("5 µm", "length", 5e-6),
        ("250 g", "mass", 0.25),
        ("2 kN/m", "stiffness", 2000.0),
        ("1 N/mm", "stiffness", 1000.0),
        ("3 N*s/m", "damping", 3.0),
        ("3 N s/m", "damping", 3.0),
        ("3 kg/s", "damping", 3.0),
        ("3 g*m^2", "inertia", 3e-3),
        ("3 g*m**2", "inertia", 3e-3),
        ("981 cm/s^2", "acceleration", 9.81),
        ("5 m*s^-2", "acceleration", 5.0),
        ("10 ms", "time", 0.01),
        ("2 min", "time", 120.0),
        ("5 mm/s", "velocity", 5e-3),
        ("2 1/s", "rate", 2.0),
        ("5 percent", "dimensionless", 0.05),
        ("180 deg", "angle", math.pi),
        ("0.5 turn", "angle in degrees", 180.0),
        ("90 deg", "angle in degrees", 90.0),
        ("1 kN*m/rad", "tilt stiffness", 1000.0),
        ("1 kN*m", "tilt stiffness", 1000.0),
    ],
)
def test_quantity_in_si_rounded_once(value, dimension, expected):
    assert quantity(value, dimension) == expected
    assert type(quantity(value, dimension)) is float


COUNTED = ["50 Hz", "0.05 kHz", "3000 rpm", "50 turn/s", "3000 revolution/minute", "3000 1/min", "3000 min^-1"]


@pytest.mark.parametrize("text", COUNTED)
def test_a_frequency_counts_turns(text):
    assert quantity(text, "frequency") == 50.0


def test_angular_speed_is_divided_by_two_pi():
    assert quantity("314.159265358979 rad/s", "frequency") == pytest.approx(50.0, rel=1e-14)
    assert quantity("-360 deg/s", "frequency") == -1.0


@pytest.mark.parametrize(
    ("value", "dimension", "part"),
    [
        ("1,5e-3", "length", "comma"),
        ("1,5 mm", "length", "comma"),
        ("0x10", "length", "a number in m"),
        ("5", "length", "without quotes"),
        ("", "length", "a number in m"),
        ("mm", "length", "a number in m"),
        ("1 + 1 mm", "length", "a number in m"),
        ("(2) mm", "length", "a number in m"),
        ("2**3 mm", "length", "a number in m"),
        ("1 m*__import__('os')", "length", "a number in m"),
        ("nan mm", "length", "a number in m"),
        ("1e9999 m", "length", "a number in m"),
        ("1e300 m", "length", "magnitude"),
        ("1 " + "m*" * 60 + "m", "length", "too long"),
        ("5 foo", "length", 'unknown unit "foo"'),
        ("5 kg", "length", "another kind"),
        ("5 m^2", "length", "another kind"),
        ("20 degC", "length", "unknown unit"),
        ("2 1/s", "frequency", "Hz, rpm or rad/s"),
        ("5 percent", "angle", "another kind"),
        ("5 deg", "dimensionless", "another kind"),
        (True, "length", "a number in m"),
        (None, "length", "a number in m"),
        ([1.0], "length", "a number in m"),
        (1 + 0j, "length", "a number in m"),
        (math.nan, "length", "finite"),
        (math.inf, "length", "finite"),
        (10**400, "length", "too large"),
        (1e-320, "mass", "magnitude"),
        (1e101, "mass", "magnitude"),
    ],
)
def test_what_is_no_quantity_is_refused(value, dimension, part):
    with pytest.raises(QuantityError) as caught:
        quantity(value, dimension)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("dimension", list(DIMENSIONS))
def test_the_example_in_every_message_is_right(dimension):
    quantity(DIMENSIONS[dimension][1], dimension)


def test_only_spelled_out_units_load_pint():
    """It takes half a second: most of the time of a short command."""
    code = (
        "import sys; from rsc.units import DIMENSIONS, quantity; import rsc.scene; quantity(1.0, 'length'); "
        "[quantity(text, dimension) for dimension, (_, text) in DIMENSIONS.items()]; quantity('10 mil', 'length'); "
        "assert 'pint' not in sys.modules; "
        "quantity('1 furlong', 'length'); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


# as engineers write them -> SI, by hand from the definitions: 1 in = 25.4 mm, 1 lb = 0.45359237 kg, g_n = 9.80665 m/s^2
LB, IN, G = 0.45359237, 0.0254, 9.80665
LBF = LB * G
WRITTEN = {
    "length": {
        "0.25 mm": 2.5e-4, "250 um": 2.5e-4, "250 µm": 2.5e-4, "250 \N{GREEK SMALL LETTER MU}m": 2.5e-4, "25 micron": 2.5e-5,
        "10 mil": 2.54e-4, "0.8 mils": 2.032e-5, "5 thou": 1.27e-4, "3 in": 3 * IN, "3 inches": 3 * IN, "1 ft": 12 * IN,
        "400 uin": 1.016e-5, "2 millimeter": 2e-3, "1.5e-1mm": 1.5e-4, "\N{MINUS SIGN}5 um": -5e-6, "7\N{NO-BREAK SPACE}mm": 7e-3,
    },
    "mass": {"12 kg": 12.0, "12 kilograms": 12.0, "500 grams": 0.5, "3 pounds": 3 * LB, "2 tonne": 2000.0,
             "250 g": 0.25, "1.2 t": 1200.0, "30 lb": 30 * LB, "30 lbm": 30 * LB, "8 oz": LB / 2,
             "1 lbf s^2/in": LBF / IN, "2 lbf-s^2/in": 2 * LBF / IN, "1 slug": LBF / (12 * IN), "1 kN s²/m": 1000.0},
    "unbalance": {"20 g mm": 2e-5, "20 g*mm": 2e-5, "20 g·mm": 2e-5, "20 gmm": 2e-5, "20 g-mm": 2e-5, "1 oz in": LB / 16 * IN,
                  "1 oz-in": LB / 16 * IN, "1 ozin": LB / 16 * IN, "3 kg mm": 3e-3, "3 kgm": 3.0, "5 g cm": 5e-5, "5 g.mm": 5e-6},
    "inertia": {"0.15 kg m^2": 0.15, "0.15 kg*m**2": 0.15, "0.15 kgm2": 0.15, "0.15 kg m²": 0.15, "150 kg cm2": 0.015,
                "2 lb in^2": 2 * LB * IN**2, "2 lb-in2": 2 * LB * IN**2, "3 lbf in s^2": 3 * LBF * IN},
    "stiffness": {"50 kN/mm": 5e7, "50 N/um": 5e7, "50 N/µm": 5e7, "5 MN/m": 5e6, "1e5 lbf/in": 1e5 * LBF / IN,
                  "5 kgf/mm": 5e3 * G,
                  "2 kip/in": 2e3 * LBF / IN, "3 lbf/mil": 3e3 * LBF / IN, "5 psi in": 5 * LBF / IN, "1e7 N m^-1": 1e7,
                  "1e7 N m⁻¹": 1e7},
    "damping": {"30 N s/m": 30.0, "30 N*s/m": 30.0, "30 Ns/m": 30.0, "30 N·s/m": 30.0, "30 N-s/m": 30.0, "30 N/(m/s)": 30.0,
                "0.03 N s/mm": 30.0, "5 lbf s/in": 5 * LBF / IN, "5 lbf-s/in": 5 * LBF / IN, "5 lbfs/in": 5 * LBF / IN,
                "3 kNs/m": 3000.0, "30 N/m s": 30.0},
    "frequency": {"2600 rpm": 2600 / 60, "2600 RPM": 2600 / 60, "2600 cpm": 2600 / 60, "2600 CPM": 2600 / 60,
                  "2600 U/min": 2600 / 60,
                  "2600 1/min": 2600 / 60, "2600/min": 2600 / 60, "2600 min-1": 2600 / 60, "2600 min^-1": 2600 / 60,
                  "2600 min⁻¹": 2600 / 60, "2600 r/min": 2600 / 60, "2600 rev/min": 2600 / 60, "2.6 krpm": 2600 / 60,
                  "2600 Upm": 2600 / 60,
                  "43 Hz": 43.0, "0.5 kHz": 500.0, "43 rev/s": 43.0, "43 cps": 43.0, "100 rad/s": 100 / (2 * math.pi),
                  "2600 revolutions per minute": 2600 / 60},
    "torque": {"40 N m": 40.0, "40 Nm": 40.0, "40 N·m": 40.0, "0.04 kNm": 40.0, "40 N-m": 40.0, "3 lbf in": 3 * LBF * IN,
               "3 lbf-ft": 36 * LBF * IN, "500 Nmm": 0.5},
    "tilt damping": {"3 N m s/rad": 3.0, "3 Nms/rad": 3.0, "3 N m/(rad/s)": 3.0, "3 N m s": 3.0},
    "acceleration": {"9.81 m/s^2": 9.81, "9.81 m/s2": 9.81, "9.81 m/s/s": 9.81, "1 g": G, "32 ft/s^2": 384 * IN},
    "sensitivity": {"7.87 V/mm": 7870.0, "200 mV/mil": 0.2 / (IN / 1000), "8 mV/um": 8000.0, "7.87 mV/µm": 7870.0,
                    "200 mV/thou": 0.2e3 / IN},
    "time": {"4 s": 4.0, "10 ms": 0.01, "200 us": 2e-4, "2 min": 120.0, "5 sec": 5.0},
    "velocity": {"5 mm/s": 5e-3, "0.2 in/s": 0.2 * IN, "0.2 ips": 0.2 * IN},
    "force": {"2 kN": 2000.0, "500 lbf": 500 * LBF, "10 kgf": 10 * G, "3 daN": 30.0, "2 newton": 2.0, "2 kilonewtons": 2000.0,
              "2 pound_force": 2 * LBF},
    "voltage": {"5 V": 5.0, "5 volt": 5.0, "5 volts": 5.0, "5 mV": 5e-3, "5 millivolt": 5e-3, "2 kV": 2000.0},
    "density": {"7850 kg/m^3": 7850.0, "7.85 g/cm3": 7850.0, "7.85 kg/dm^3": 7850.0, "0.284 lb/in^3": 0.284 * LB / IN**3,
                "7850 kilogram per meter^3": 7850.0},
    "modulus": {"210 GPa": 2.1e11, "210e3 MPa": 2.1e11, "210000 N/mm2": 2.1e11, "30e6 psi": 30e6 * LBF / IN**2,
                "210 gigapascal": 2.1e11},
    "impulse": {"2 N s": 2.0, "2 Ns": 2.0, "2 kg m/s": 2.0, "2 lbf s": 2 * LBF, "2 newton second": 2.0},
    "dimensionless": {"5 %": 0.05, "5 percent": 0.05, "0.5 mm/m": 5e-4},
    "angle in degrees": {"30 deg": 30.0, "30°": 30.0, "0.25 turn": 90.0},
}  # fmt: skip
# what could be meant otherwise than it would be read -> what the refusal says
TRAPS = {
    "length": {"0.3 MM": '"mm"', "0.3 Mm": '"mm"', "10 u": '"um"', "10 mu": '"um"', "0,25 mm": "comma", "0.5 in.": "no point",
               "4 mils pk-pk": "half of peak to peak", "100 um pp": "half of peak to peak", "2 mil rms": "without such a word",
               "1/16 in": "decimal", "1 1/2 in": "decimal", "5 pp": "peak", "5 point": "several things", "6.3 mm/s": '"G 6.3"',
               "3 min": "another kind", "10 p": "unknown unit"},
    "mass": {"2 ton": "short_ton", "5 Kg": '"kg"', "5 gm": '"g"', "5 gr": '"grain"', "30 lbf": "lb for lbf",
             "10 kgf": "kg for kgf", "5 u": "um"},
    "unbalance": {"5 g": "another kind", "3 ozf in": "lb for lbf"},
    "stiffness": {"5 lb/in": "lbf for lb", "5 kg/mm": "kgf for kg", "5 KN/m": '"kN"', "5·10⁶ N/m": "1.2e7", "10⁶ N/m": "1.2e7",
                  "1.2x10^7 N/m": "1.2e7", "2 mm/N": "another kind", "5 N/m/s": "another kind"},
    "damping": {"5 lb s/in": "lbf for lb", "5 N/m": "another kind"},
    "frequency": {"1,500 rpm": "thousands", "3.000 U/min": "thousands", "50 hz": '"Hz"', "50 HZ": '"Hz"', "100 1/s": "rad/s",
                  "100 rps": '"rev/s" or "rad/s"', "50 MS": '"ms"', "1 500 rpm": "", "3k rpm": "", "50 rpm/s": "another kind"},
    "torque": {"40 kg cm": "kgf for kg", "3 in-lb": "lbf for lb"},
    "angle": {"10 mil": "another kind"},
    "voltage": {"5 Volt": '"volt"', "5 v": '"V"', "5 vdc": "unknown unit", "5 A": "unknown unit"},
    "force": {"5 lb": "lbf for lb", "5 kg": "kgf for kg", "5 KN": '"kN"', "5 kilogram": "kgf for kg", "5 n": '"N"'},
    "velocity": {"5 c": "unknown unit", "5 kt": "unknown unit"},
    "rate": {"2 Hz": "count turns", "2 rpm": "count turns"},
    "acceleration": {"1 G": '"g"'},
}  # fmt: skip


def test_a_hundred_quantities_as_engineers_write_them_are_read_rightly():
    read = {(text, dimension): expected for dimension, texts in WRITTEN.items() for text, expected in texts.items()}
    assert len(read) > 100
    for (text, dimension), expected in read.items():
        assert quantity(text, dimension) == pytest.approx(expected, rel=1e-15), text


@pytest.mark.parametrize(("text", "dimension", "words"), [(t, d, w) for d, texts in TRAPS.items() for t, w in texts.items()])
def test_what_could_be_meant_otherwise_is_refused_with_what_to_write(text, dimension, words):
    with pytest.raises(QuantityError) as caught:
        quantity(text, dimension)
    assert words in str(caught.value)


def test_no_name_of_a_unit_stands_for_two():
    names = [name for _, named in GROUPS.values() for names in named for name in names.split()]
    assert len(names) == len(set(names))
    assert not set(names) & {*TOGETHER, *AMBIGUOUS}
    assert all(unit_of(text) for text in TOGETHER.values())


@pytest.mark.parametrize(
    ("parts", "ends", "expected"),
    [
        (["600", "6000 rpm"], True, ["600 rpm", "6000 rpm"]),
        (["600 rpm", "6000"], True, ["600 rpm", "6000 rpm"]),
        (["0", "6000 rpm"], True, ["0", "6000 rpm"]),
        (["10 Hz", "6000 rpm"], True, ["10 Hz", "6000 rpm"]),
        (["1", "2"], True, ["1", "2"]),
        (["0.1", " 0.2", "0.3 mm"], False, ["0.1 mm", "0.2 mm", "0.3 mm"]),
        (["backward", "50 Hz"], False, ["backward", "50 Hz"]),
    ],
)
def test_a_unit_that_stands_once_holds_for_all(parts, ends, expected):
    assert spread(parts, ends) == expected


@pytest.mark.parametrize("parts", [["1 mm", "2", "3"], ["1", "2 mm", "3"], ["1", "2 mm", "3 mm"], ["1 mm", "2"]])
def test_a_number_without_a_unit_in_a_list_of_others_is_refused(parts):
    with pytest.raises(QuantityError, match="has none"):
        spread(parts)


def test_a_plain_number_beside_a_quantity_in_another_unit_is_refused():
    refuse_mixed([50.0, "60 Hz", 0, "1.0"], "frequency")
    refuse_mixed([0.0, "6000 rpm", "0"], "frequency")
    with pytest.raises(QuantityError, match=r"50\.0 has none"):
        refuse_mixed([50.0, "6000 rpm"], "frequency")
    with pytest.raises(QuantityError, match="600 has none"):
        refuse_mixed(["600", "6000 rpm"], "frequency")
