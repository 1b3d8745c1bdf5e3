"""Quantities that belong together in a range, list or table: none may be read in a unit that was not meant.

Within one text, a unit that occurs once, at the end of a list or at either end of a range, applies to all numbers. Mixing plain
numbers with quantities in a unit other than that of plain numbers is refused.
"""

import re
from collections.abc import Iterable, Sequence

from rsc.units import QuantityError, factor, unit_behind


def spread(parts: Sequence[str], ends: bool = False) -> list[str]:
    """Apply a unit that occurs only once to all parts of a list; ends: for a range, where it may also be at the first part.

    Raises
    ------
    QuantityError
        Some parts have a unit and others none.
    """
    units = [unit_behind(part) for part in parts]
    bare = [part for part, unit in zip(parts, units, strict=True) if not unit and _is_number(part)]
    if not any(units) or not any(map(float, bare)):
        return list(parts)
    if sum(map(bool, units)) > 1 or not (units[-1] or ends):
        raise QuantityError("numbers that all have a unit, or only the last one", f'"{bare[0]}" has none')
    unit = next(filter(None, units))
    return [f"{part.strip()} {unit}" if part in bare else part for part in parts]


def refuse_mixed(raws: Iterable[object], dimension: str) -> None:
    """QuantityError if some values are plain numbers and another has a unit different from that of plain numbers."""
    raws = list(raws)
    other = next((raw for raw in raws if isinstance(raw, str) and has_other_unit(raw, dimension)), None)
    numbers = (raw for raw in raws if not isinstance(raw, str) or _is_number(raw))
    bare = next((raw for raw in numbers if float(raw)), None)  # type: ignore[arg-type]
    if other is not None and bare is not None:
        raise QuantityError(f"numbers that all have a unit, like {other!r}", f"{bare} has none")


def has_other_unit(text: str, dimension: str) -> bool:
    """Whether a text has a unit other than that of plain numbers."""
    unit = unit_behind(text)
    return bool(unit) and factor(unit, dimension) != 1


def _is_number(text: str) -> bool:
    return re.fullmatch(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*", text, re.ASCII) is not None
