"""Quantities with units: converts a number in SI, or a text such as "0.2 mm", to one float.

Texts are never evaluated: a decimal number is followed by unit names (`rsc.units.table`) with powers and product signs
(`rsc.units.unit_text`). For several quantities in one range or list see `rsc.units.together`.
"""

import math
import numbers
import re
from fractions import Fraction
from functools import lru_cache

from rsc.errors import RscError
from rsc.units.table import ALONE, Unit
from rsc.units.unit_text import UnitError, unit_of

# dimension -> (unit of a plain number, example of a valid text)
DIMENSIONS = {
    "length": ("m", "0.2 mm"),
    "mass": ("kg", "250 g"),
    "unbalance": ("kg m", "20 g mm"),
    "density": ("kg/m^3", "7850 kg/m^3"),
    "modulus": ("Pa", "210 GPa"),
    "inertia": ("kg m^2", "3 g m^2"),
    "stiffness": ("N/m", "2 kN/m"),
    "tilt stiffness": ("N m/rad", "2 kN m/rad"),
    "cross stiffness": ("N/rad", "2 kN/rad"),
    "damping": ("N s/m", "30 N s/m"),
    "integral gain": ("N/(m s)", "1 MN/(m s)"),
    "tilt damping": ("N m s/rad", "3 N m s/rad"),
    "cross damping": ("N s/rad", "3 N s/rad"),
    "frequency": ("Hz", "3000 rpm"),
    "rate": ("1/s", "2 1/s"),
    "time": ("s", "10 ms"),
    "velocity": ("m/s", "5 mm/s"),
    "angular velocity": ("rad/s", "5 deg/s"),
    "acceleration": ("m/s^2", "981 cm/s^2"),
    "force": ("N", "2 kN"),
    "impulse": ("N s", "2 kg m/s"),
    "torque": ("N m", "2 kN m"),
    "angle": ("rad", "5 deg"),
    "angle in degrees": ("deg", "0.5 rad"),
    "voltage": ("V", "5 V"),
    "sensitivity": ("V/m", "7.87 V/mm"),
    "dimensionless": ("1", "5 percent"),
}
SMALLEST, LARGEST = 1e-100, 1e100  # outside, squares and products may overflow or underflow

_MAX_LENGTH = 100
GRADE = r"G ?(\d+(?:\.\d+)?)(?: at (.+))?"  # balance grade of ISO 21940, in mm/s, and the speed for which it is meant
_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?"
_TEXT = re.compile(rf"(?P<number>{_NUMBER})\s*(?P<unit>[^\s\d,.+-].*|1\s*/.*)", re.ASCII | re.DOTALL)
_FREE_OF_ANGLE = ("torque", "tilt stiffness", "tilt damping", "cross stiffness", "cross damping")

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

    def __init__(self, wanted: str, hint: str = "") -> None:
        self.wanted, self.hint = wanted, hint
        super().__init__(f"must be {wanted}" + (f" ({hint})" if hint else ""))


def quantity(value: object, dimension: str) -> float:
    """Return a quantity as one float in SI (frequencies and rotor speeds in Hz).

    Parameters
    ----------
    value : float, int or str
        A finite number in the SI unit of `dimension`, or a text with a unit: "0.2 mm", "3000 rpm". A text
        is converted in exact arithmetic and rounded once, so "0.2 mm" is exactly 0.0002.
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
    """Eccentricity e in m permitted by a balance grade of ISO 21940 at a speed in Hz, from a text such as "G 6.3", where e Omega
    is 6.3 mm/s, or "G 6.3 at 3000 rpm", which names its own speed; None for any other text and for a rotor that does not turn."""
    grade = re.fullmatch(GRADE, text.strip())
    if grade is None:
        return None
    if grade[2] is not None:
        try:
            speed = quantity(grade[2], "frequency")
        except QuantityError:
            return None
    return 1e-3 * float(grade[1]) / (2.0 * math.pi * abs(speed)) if speed else None


def unit_behind(text: str) -> str:
    """The text after a decimal number, taken as its unit; "" if there is none."""
    match = _TEXT.fullmatch(text.strip()) if len(text) <= _MAX_LENGTH else None
    return match["unit"] if match else ""


def _wanted(dimension: str) -> str:
    unit, example = DIMENSIONS[dimension]
    if dimension == "dimensionless":
        return "a number"
    return f"a number in {unit}, or a text with a unit such as \"{example}\""


def _from_text(text: str, dimension: str) -> float:
    """The value in SI of a decimal number with a unit; QuantityError for any other text."""
    plain = text.strip().replace("\N{MINUS SIGN}", "-", 1)
    match = _TEXT.fullmatch(plain) if len(text) <= _MAX_LENGTH else None
    hint = _form_hint(text, plain)
    if match is None or hint:
        raise QuantityError(_wanted(dimension), hint)
    exact = Fraction(match["number"]) * factor(match["unit"], dimension)
    try:
        number = float(exact)
    except OverflowError:
        raise QuantityError(_wanted(dimension), "the number is too large") from None
    return number if number or not exact else SMALLEST / 2.0  # underflow: out of range, not zero


@lru_cache(maxsize=512)
def factor(unit_text: str, dimension: str) -> Fraction:
    """Exact conversion factor of a unit to SI (frequencies: to Hz).

    Raises
    ------
    QuantityError
        Not a unit of this dimension.
    """
    try:
        unit = ALONE.get((unit_text, dimension)) or unit_of(unit_text)
    except UnitError as error:
        raise QuantityError(_wanted(dimension), str(error)) from None
    target = _target(dimension)
    if dimension == "frequency" and unit == unit_of("1/min"):  # speeds on rating plates; a bare 1/s is ambiguous and refused
        unit = unit_of("rpm")
    if _powers(unit, dimension) != _powers(target, dimension):
        raise QuantityError(_wanted(dimension), _other_kind(unit_text, unit, target))
    return unit.factor / target.factor


def _target(dimension: str) -> Unit:
    unit = DIMENSIONS[dimension][0]
    return unit_of("%/%" if unit == "1" else unit)


def _powers(unit: Unit, dimension: str) -> tuple[int, ...]:
    """Powers of the base units; the radian is ignored for `_FREE_OF_ANGLE`."""
    return unit.powers[:-1] if dimension in _FREE_OF_ANGLE else unit.powers


def _form_hint(text: str, plain: str) -> str:
    """Hint for a text that is not a number with a unit or could be misread as another number; "" if it is fine."""
    if len(text) > _MAX_LENGTH:
        return "the text is too long"
    if re.match(r"[+-]?\d{1,3}(,\d{3})+(?![\d,])", plain):
        return "write thousands without a comma and the decimal point as a point"
    if re.match(r"[+-]?\d+,\d", plain):
        return "write the decimal point as a point, not a comma"
    if re.match(r"[+-]?\d{1,3}\.\d{3}\s*(U/min|Upm)", plain):  # in German the point separates thousands
        return "write thousands without a point; for a decimal fraction use another number of digits, or rpm"
    if re.fullmatch(_NUMBER, plain):
        return "write a plain number without quotes, or add a unit"
    if re.search(r"(?i)\b(pp|p-p|pk-pk|pkpk|pk|peak|rms|0-p)\b", plain):
        return "give the zero-to-peak amplitude, half of peak to peak, without such a word"
    if plain.endswith("."):
        return "no point after the unit"
    if re.match(r"\d+\s*/\s*\d|\d+\s+\d+\s*/\s*\d", plain):
        return "write a fraction as a decimal number"
    if re.match(r"\S+\s*[xX×·*]\s*10|\d+[⁰¹²³⁴-⁹]", plain):
        return "write powers of ten as in 1.2e7"
    return ""


def _other_kind(unit_text: str, unit: Unit, target: Unit) -> str:
    """Hint for a unit of the wrong dimension."""
    missing = tuple(wanted - power for wanted, power in zip(target.powers, unit.powers, strict=True))
    if target == unit_of("Hz") or target == unit_of("rad/s"):
        return "Hz, rpm or rad/s" if missing == (0, 0, 0, 0, 1) else f"Hz, rpm or rad/s; \"{unit_text}\" is another kind of unit"
    if target == unit_of("1/s"):
        return "1/s, 1/min; Hz and rpm count turns" if missing == (0, 0, 0, 0, -1) else f"\"{unit_text}\" is another kind of unit"
    if missing == (0, 1, -2, 0, 0):
        return f"\"{unit_text}\" contains a mass instead of a force: use lbf for lb, kgf for kg"
    if missing == (0, -1, 2, 0, 0):
        return f"\"{unit_text}\" contains a force instead of a mass: use lb for lbf, kg for kgf"
    if missing == (0, 0, 1, 0, 0) and target == unit_of("m"):
        return f"\"{unit_text}\" is a velocity; a balance grade is written \"G 6.3\""
    return f"\"{unit_text}\" is another kind of unit"
