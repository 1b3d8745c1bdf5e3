"""Parser of unit texts such as "N s/m", "kg·mm²" or "N/(m/s)"; texts are never evaluated."""

import re
from functools import lru_cache

from rsc.errors import MEANT, nearest
from rsc.units.table import AMBIGUOUS, ONE, TOGETHER, UNITS, Unit, known

_SIGNS = str.maketrans({"µ": "u", "μ": "u", "−": "-", "·": "*", "⋅": "*", "\xa0": " ", "\u2009": " ", "\u202f": " "})
_RAISED = str.maketrans("⁻¹²³⁴", "-1234")
_NAME = r"[A-Za-z][A-Za-z_]*|[°%]"
_TOKEN = re.compile(rf"\s*(?:(?P<name>{_NAME})(?:(?:\^|\*\*)?(?P<power>-?\d))?(?![\d^])|(?P<one>1)(?=\s*/)|(?P<sign>[*./()-]))")
_DEEPEST = 3


class UnitError(ValueError):
    """A text that is not a unit; the message is a hint and may be empty."""


@lru_cache(maxsize=512)
def unit_of(text: str) -> Unit:
    """The Unit of a text. A division sign applies to the next factor only: "N/m s" is N s/m.

    Raises
    ------
    UnitError
        An unknown or ambiguous name, or not a unit at all.
    """
    plain = re.sub("⁻?[¹²³⁴]", lambda raised: "^" + raised[0].translate(_RAISED), text.translate(_SIGNS)).strip()
    tokens: list[tuple[str, int]] = []
    place = 0
    while place < len(plain):
        match = _TOKEN.match(plain, place)
        if match is None:
            raise UnitError("")
        tokens.append((match["name"] or match["one"] or match["sign"], int(match["power"] or 1)))
        place = match.end()
    if tokens and tokens[0][0] == "/":  # "3000/min"
        tokens.insert(0, ("1", 1))
    unit, remaining = _product(tokens, 0)
    if remaining or not tokens:
        raise UnitError("")
    return unit


def _product(tokens: list[tuple[str, int]], depth: int) -> tuple[Unit, list[tuple[str, int]]]:
    """The Unit of a product up to the end or a closing parenthesis, and the remaining tokens."""
    unit, sign, due = ONE, 1, True  # due: a factor must follow
    while tokens and tokens[0] != (")", 1):
        word, power = tokens[0]
        if word in ("*", ".", "-", "/", "per"):
            if due:
                raise UnitError("")
            sign, due, tokens = (-1 if word in ("/", "per") else 1), True, tokens[1:]
            continue
        if word == "(":
            if depth == _DEEPEST:
                raise UnitError("")
            factor, tokens = _product(tokens[1:], depth + 1)
            if not tokens:
                raise UnitError("")
        elif word == "1":
            factor = ONE
        else:
            factor, power = _factor(word, power)
        unit, sign, due, tokens = unit.times(factor, sign * power), 1, False, tokens[1:]
    if due:
        raise UnitError("")
    return unit, tokens


def _factor(name: str, power: int) -> tuple[Unit, int]:
    """The Unit of one name, and its power; in names written together the power belongs to the last one: "kgm2" is kg m^2."""
    if name in TOGETHER:
        first, _, last = TOGETHER[name].rpartition(" ")
        return unit_of(first).times(UNITS[last], power), 1
    if name in AMBIGUOUS:
        raise UnitError(f'"{name}" can mean several things: write {AMBIGUOUS[name]}')
    same = [other for other in (*UNITS, *TOGETHER) if other.casefold() == name.casefold()]
    unit = known(name) if name in UNITS or not same else None
    if unit is None:
        close = f'{MEANT} "{same[0]}"?' if same else nearest(name, [other for other in UNITS if len(other) > 2])
        raise UnitError(f'unknown unit "{name}"' + (f", {close}" if close.startswith(MEANT) else ""))
    return unit, power
