"""Aligned text of tables, and their columns in the units that are chosen."""

import re

from rsc.show.words.units import column

_UNIT = re.compile(r"(?:^| )(Hz|N|N s|N m|N/m|N s/m|W|m/s|mm|m|kg|kg m\^2|J)$")  # of SI, at the end of a header
_NUMBER = re.compile(r"[+-]?\d+(?:\.\d*)?(?:e[+-]?\d+)?")
LEAST_DIGITS = 4


class Exact(str):
    """The text of a cell with the numbers (tuple of float) in it as they were before rounding, for other units."""

    numbers: tuple[float, ...] = ()


def exact(text, *numbers):
    """An `Exact`."""
    cell = Exact(text)
    cell.numbers = numbers
    return cell


def table(header, rows):
    """Aligned text of a table; rows hold strings, the last column is read from the left."""
    header, rows = in_units(header, rows)
    widths = [max(len(cell) for cell in column) for column in zip(header, *rows, strict=True)]
    lines = []
    for row in (header, *rows):
        numbers = [cell.rjust(w) for cell, w in zip(row[:-1], widths, strict=False)]
        lines.append("  ".join([*numbers, row[-1]]).rstrip())
    return "\n".join([lines[0], "-" * (sum(widths[:-1]) + 2 * len(widths) + 12), *lines[1:]])


def in_units(header, rows):
    """A header and rows of texts whose columns with a unit of SI at the end of their header are in the units that are chosen;
    a column that then is there twice is left out."""
    units = [_UNIT.search(cell) for cell in header]
    columns = [column(unit[1]) if unit else (1.0, "") for unit in units]
    if all(factor == 1.0 for factor, _ in columns):
        return header, rows
    kept = [i for i, cell in enumerate(header) if cell != "rpm" or ("rpm" not in [name for _, name in columns])]
    names = [cell[: unit.start(1)] + name if unit else cell for cell, unit, (_, name) in zip(header, units, columns, strict=True)]
    shown = [[_scaled(row[i], columns[i][0]) for i in kept] for row in rows]
    return tuple(names[i] for i in kept), shown


def _scaled(cell, factor):
    """A cell whose numbers are other ones by a factor, with as many digits."""
    if factor == 1.0:
        return cell
    known = iter(getattr(cell, "numbers", ()))

    def scaled(match):
        digits = len(re.sub(r"e.*|\D", "", match[0]).lstrip("0"))
        value, sign = factor * next(known, float(match[0])), "+" if match[0][0] == "+" else ""
        digits = max(digits, LEAST_DIGITS)
        return f"{value:{sign}.0f}" if 10.0 ** (digits - 1) <= abs(value) < 1e9 else f"{value:{sign}.{digits}g}"

    return _NUMBER.sub(scaled, cell)
