"""Quantities: SI numbers and texts with units."""

import math
import subprocess
import sys

import pytest

from rsc.units import DIMENSIONS, QuantityError, quantity


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
        ("20 degC", "length", "another kind"),
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
    quantity(DIMENSIONS[dimension][2], dimension)


def test_plain_numbers_do_not_load_pint():
    code = (
        "import sys; from rsc.units import quantity; import rsc.scene; quantity(1.0, 'length'); "
        "assert 'pint' not in sys.modules; "
        "quantity('1 mm', 'length'); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
