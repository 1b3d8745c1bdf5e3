"""Quantities with units: a number in SI, or a text such as "0.2 mm", to one float.

Nothing is ever evaluated: a text is a decimal number followed by unit names, `*`, `/`, spaces and integer
powers. pint looks up the unit names; it takes half a second to load, so it waits for the first text.
"""

import math
import numbers
import re
from decimal import Decimal
from functools import lru_cache

from rsc.errors import RscError

# dimension -> (unit of the number as shown to the user, the same unit for pint, a text that is right)
DIMENSIONS = {
    "length": ("m", "m", "0.2 mm"),
    "mass": ("kg", "kg", "250 g"),
    "unbalance": ("kg m", "kg*m", "20 g*mm"),
    "density": ("kg/m^3", "kg/m^3", "7850 kg/m^3"),
    "modulus": ("Pa", "Pa", "210 GPa"),
    "inertia": ("kg m^2", "kg*m^2", "3 g*m^2"),
    "stiffness": ("N/m", "N/m", "2 kN/m"),
    "tilt stiffness": ("N m/rad", "N*m", "2 kN*m/rad"),
    "cross stiffness": ("N/rad", "N", "2 kN/rad"),
    "damping": ("N s/m", "N*s/m", "30 N*s/m"),
    "tilt damping": ("N m s/rad", "N*m*s", "3 N*m*s/rad"),
    "cross damping": ("N s/rad", "N*s", "3 N*s/rad"),
    "frequency": ("Hz", "turn/s", "3000 rpm"),
    "rate": ("1/s", "1/s", "2 1/s"),
    "time": ("s", "s", "10 ms"),
    "velocity": ("m/s", "m/s", "5 mm/s"),
    "angular velocity": ("rad/s", "rad/s", "5 deg/s"),
    "acceleration": ("m/s^2", "m/s^2", "981 cm/s^2"),
    "force": ("N", "N", "2 kN"),
    "impulse": ("N s", "N*s", "2 kg*m/s"),
    "torque": ("N m", "N*m", "2 kN*m"),
    "angle": ("rad", "rad", "5 deg"),
    "angle in degrees": ("deg", "deg", "0.5 rad"),
    "voltage": ("V", "V", "5 V"),
    "sensitivity": ("V/m", "V/m", "7.87 V/mm"),
    "dimensionless": ("1", "dimensionless", "5 percent"),
}
SMALLEST, LARGEST = 1e-100, 1e100  # magnitudes outside cannot be squared or multiplied safely

_MAX_LENGTH = 100
GRADE = r"G ?(\d+(?:\.\d+)?)"  # of ISO 21940, in mm/s
_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?"
_FACTOR = r"[A-Za-zµμ°%Ω][A-Za-z_µμ]*(?:(?:\^|\*\*)-?\d)?"
_TEXT = re.compile(
    rf"(?P<number>{_NUMBER})\s*(?P<unit>(?:1\s*/\s*)?{_FACTOR}(?:\s*[*/]\s*{_FACTOR}|\s+{_FACTOR})*)",
    re.ASCII,
)
_STEP = re.compile(rf"(?P<operator>[*/]|\s)?\s*(?P<factor>{_FACTOR}|1)")


class QuantityError(RscError, ValueError):
    """A number or text that is not a quantity of the wanted dimension.

    Parameters
    ----------
    wanted : str
        What is allowed, to be read after "must be".
    hint : str
        One short piece of advice; may be empty.
    """

    _made_of = ("wanted", "hint")

    def __init__(self, wanted, hint=""):
        self.wanted, self.hint = wanted, hint
        super().__init__(f"must be {wanted}" + (f" ({hint})" if hint else ""))


def quantity(value: object, dimension: str) -> float:
    """Return a quantity as one float in SI (frequencies and rotor speeds in Hz).

    Parameters
    ----------
    value : float, int or str
        A finite number in the SI unit of `dimension`, or a number with a unit: "0.2 mm", "3000 rpm". A text
        is converted in decimal arithmetic and rounded once, so "0.2 mm" is exactly 0.0002.
    dimension : str
        A key of `DIMENSIONS`.

    Returns
    -------
    float
        The quantity in the unit `DIMENSIONS[dimension][0]`.

    Raises
    ------
    QuantityError
        Not a number (bool, nan, inf, an expression), a wrong or unknown unit, or a nonzero magnitude outside
        `SMALLEST` to `LARGEST`.
    """
    if isinstance(value, str):
        number = _from_text(value, dimension)
    elif isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise QuantityError(_wanted(dimension))
    else:
        try:
            number = float(value)
        except OverflowError:
            raise QuantityError(_wanted(dimension), "the number is too large") from None
    if not math.isfinite(number):
        raise QuantityError(f"a finite number, {_wanted(dimension)}")
    if number != 0.0 and not SMALLEST <= abs(number) <= LARGEST:
        raise QuantityError(f"0 or a number of magnitude {SMALLEST:g} to {LARGEST:g}")
    return number


def eccentricity_of_grade(text: str, speed: float) -> float | None:
    """Distance e in m of the centre of mass that a balance grade of ISO 21940 allows at a speed in Hz, from a text such as
    "G 6.3": e Omega in mm/s; None of another text, and of a rotor that does not turn."""
    grade = re.fullmatch(GRADE, text.strip())
    return 1e-3 * float(grade[1]) / (2.0 * math.pi * abs(speed)) if grade and speed else None


def _wanted(dimension):
    unit, _, example = DIMENSIONS[dimension]
    if dimension == "dimensionless":
        return "a number"
    return f"a number in {unit}, or a text with a unit such as \"{example}\""


def _from_text(text, dimension):
    """The SI number of a text; refuses everything but a decimal number with a unit."""
    match = _TEXT.fullmatch(text.strip()) if len(text) <= _MAX_LENGTH else None
    if match is None:
        raise QuantityError(_wanted(dimension), _form_hint(text))
    factor = _factor(match["unit"], dimension)
    return float(Decimal(match["number"]) * factor)


def _form_hint(text):
    if len(text) > _MAX_LENGTH:
        return "the text is too long"
    if re.fullmatch(r"\s*[+-]?\d+,\d.*", text):
        return "write the decimal point as a point, not a comma"
    if re.fullmatch(rf"\s*{_NUMBER}\s*", text):
        return "write a plain number without quotes, or add a unit"
    return ""


@lru_cache(maxsize=256)
def _factor(unit_text, dimension):
    """Decimal factor from a unit to the SI unit of a dimension."""
    unit = _unit(unit_text, dimension)
    factor, root = _registry().get_root_units(unit)
    target_text = DIMENSIONS[dimension][1]
    if dimension == "frequency" and ("hertz" in str(unit) or str(unit) == "1 / minute") and "radian" not in str(root):
        # pint takes Hz for 1/s = rad/s; here a frequency counts turns. 1/min is how speeds are written on machines, but a bare
        # 1/s could mean either
        target_text = "1/s"
    target_factor, target_root = _registry().get_root_units(_registry().parse_units(target_text))
    if _powers(root, dimension) != _powers(target_root, dimension):
        hint = "Hz, rpm or rad/s" if dimension == "frequency" else f"\"{unit_text}\" is another kind of unit"
        raise QuantityError(_wanted(dimension), hint)
    return Decimal(factor) / Decimal(target_factor)


def _powers(root, dimension):
    """Base units with their powers; the radian counts only where an angle is meant."""
    powers = {name: int(power) for name, power in root._units.items()}
    if dimension.startswith(("tilt", "cross")) or dimension == "torque":
        powers.pop("radian", None)
    return powers


def _unit(unit_text, dimension):
    """The pint unit of a checked unit text, put together name by name (pint parses single names only)."""
    import pint

    unit = _registry().parse_units("dimensionless")
    for step in _STEP.finditer(unit_text):
        if step["factor"] == "1":
            continue
        name, _, power = step["factor"].replace("**", "^").partition("^")
        try:
            part = _registry().parse_units(name) ** int(power or 1)
        except (pint.errors.PintError, AttributeError, ValueError, TypeError):
            raise QuantityError(_wanted(dimension), f"unknown unit \"{name}\"") from None
        unit = unit / part if step["operator"] == "/" else unit * part
    return unit


@lru_cache(maxsize=1)
def _registry():
    """The unit registry, made once; decimal, so that metric prefixes and 1 rpm = 1/60 Hz are exact."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)
