"""Coefficients of a bearing over the rotor speed, from a CSV file with units in its header."""

import re

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, one_line
from rsc.machine.imports.coordinates import cells_of, number_in, rows_of
from rsc.machine.model.following import MOST_KNOTS
from rsc.units import QuantityError, quantity

# column -> index among the eight coefficients
_PLACES = {f"{letter}_{pair}": 4 * k + i for k, letter in enumerate("kc") for i, pair in enumerate(("yy", "yz", "zy", "zz"))}
_OTHER_AXES = str.maketrans("xy", "yz")  # of programs whose shafts lie along z
_DIMENSION = {"k": "stiffness", "c": "damping"}
_EXAMPLE = "speed [rpm], k_yy [N/m], k_zz [N/m], c_yy [N s/m], c_zz [N s/m]"
_COLUMN = re.compile(r"\s*(\w+)\s*[\[(]\s*(.+?)\s*[\])]\s*")


def read_bearing_table(path: object) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Speeds (k,) in Hz and coefficients (k, 8) in N/m and N s/m.

    The header names the columns with their units, as in ``speed [rpm], k_yy [N/m], k_zz [N/m], c_yy [N s/m], c_zz [N s/m]``;
    cross-coupled ones, k_yz, k_zy, c_yz and c_zy, are 0 if absent. A file with k_xx is that of a program whose directions are x
    and y: these become y and z.

    Raises
    ------
    DataError
        Not readable, a column without unit or of unknown kind, not a number, speeds that do not increase, fewer than two rows.
    """
    file = one_line(path)
    heads, lines = rows_of(path, None, (), "a table of bearing coefficients")
    columns = _in_y_and_z(file, [_column(file, head) for head in heads])
    names = [name for name, _ in columns]
    if "speed" not in names or not {"k_yy", "k_zz"} <= set(names) or len(set(names)) < len(names):
        raise DataError(file, f"must have the columns speed, k_yy and k_zz (or k_xx and k_yy), each column once: {_EXAMPLE}")
    speeds: list[float] = []
    rows = []
    for number, line in lines:
        where, eight = f"line {number}", np.zeros(8)
        cells = cells_of(file, where, heads, line)
        numbers = [number_in(file, where, head, cells[head], float) for head in heads]
        values = {name: factor * value for (name, factor), value in zip(columns, numbers, strict=True)}
        speed = values.pop("speed")
        if speeds and not speed > speeds[-1]:
            raise DataError(file, f"{where}: the speed must exceed that of the previous row")
        for name, value in values.items():
            eight[_PLACES[name]] = value
        speeds.append(speed)
        rows.append(eight)
    if not 2 <= len(speeds) <= MOST_KNOTS:
        raise DataError(file, f"has {len(speeds)} rows of coefficients: must be 2 to {MOST_KNOTS}")
    return np.array(speeds), np.array(rows)


def _in_y_and_z(file: str, columns: list[tuple[str, float]]) -> list[tuple[str, float]]:
    """The columns with the directions y and z, of a file that may have x and y."""
    pairs = "".join(name[2:] for name, _ in columns if name != "speed")
    if "x" in pairs and "z" in pairs:
        raise DataError(file, f"has columns of x and of z: the directions are y and z (or all x and y): {_EXAMPLE}")
    return [(name if name == "speed" or "x" not in pairs else name.translate(_OTHER_AXES), factor) for name, factor in columns]


def _column(file: str, head: str) -> tuple[str, float]:
    """Name of a column and the factor from its unit to SI (Hz)."""
    match = _COLUMN.fullmatch(head)
    if match is None:
        raise DataError(file, f"column {one_line(head)[:40]!r} must have its unit: {_EXAMPLE}")
    name, unit = re.sub(r"^([kc])([xyz]{2})$", r"\1_\2", match[1].lower()), match[2]
    if name != "speed" and name not in _PLACES and name.translate(_OTHER_AXES) not in _PLACES:
        raise DataError(file, f"column {one_line(head)[:40]!r} must be speed or one of {', '.join(_PLACES)}")
    try:
        return name, quantity(f"1 {unit}", "frequency" if name == "speed" else _DIMENSION[name[0]])
    except QuantityError as error:
        raise DataError(file, f"column {one_line(head)[:40]!r}: its unit {error}") from None
