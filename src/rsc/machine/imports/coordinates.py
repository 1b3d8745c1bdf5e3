"""The coordinate table: node and direction of each row of the matrices."""

import itertools
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, nearest, one_line
from rsc.files.content import content_of
from rsc.files.csv_lines import csv_lines
from rsc.machine.formats.entries import MOST_COORDINATES

PLANE = ("x", "y", "rx", "ry")  # directions that form complex coordinates
_OTHER = ("other", "z", "rz")
_COLUMNS = ("node", "direction", "name", "position")
_MOST_BYTES = 2**26
# meaning of directions 1 to 6 of a label, by rotor axis; permuted such that the axes stay right-handed
_OF_LABELS = {
    "z": ("x", "y", "other", "rx", "ry", "other"),
    "x": ("other", "x", "y", "other", "rx", "ry"),
    "y": ("y", "other", "x", "ry", "other", "rx"),
}


@dataclass(frozen=True)
class Coordinates:
    """Node and direction of every row, in the order of the rows.

    Directions: x and y across the rotor axis, with rotation from x to y; rx and ry the rotations about them, so that small slopes
    along the axis are x' = ry and y' = -rx; everything else is "other".
    """

    node: NDArray[np.int64]  # (n,)
    direction: NDArray[np.str_]  # (n,) of PLANE or "other"
    names: dict[str, int] = field(default_factory=dict)  # node by its name
    position: dict[int, float] = field(default_factory=dict)  # m along the axis, by node, where known

    def __len__(self) -> int:
        return len(self.node)

    def taken(self, rows: NDArray[np.int64]) -> "Coordinates":
        """The coordinates of some rows."""
        return Coordinates(self.node[rows], self.direction[rows], self.names, self.position)


def read_table(path: str | os.PathLike[str]) -> Coordinates:
    """Read a coordinate table: comma- or semicolon-separated values with a header line.

    Columns: node (an integer), direction (x, y, rx, ry; z, rz and other count as "other"), and optionally name (of the node) and
    position (of the node along the axis, m). One line per row of the matrices, in their order.

    Raises
    ------
    DataError
        Not readable, an unknown column or direction, a duplicate coordinate, a name for two nodes, two positions of one node.
    """
    return _table(one_line(path), *rows_of(path, _COLUMNS, ("node", "direction"), "a coordinate table"))


def rows_of(path: Any, known: Sequence[str] | None, needed: Sequence[str], what: str) -> tuple[list[str], list[tuple[int,
list[str]]]]:
    """(column names, [(line number, cells)]) of a text of comma- or semicolon-separated values; known: allowed column names, or
    None if the caller checks them (their case is then kept).

    Raises
    ------
    DataError
        Not readable, empty, an unknown column, a missing required column, too many rows.
    """
    content = content_of(path, _MOST_BYTES)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise DataError(one_line(path), "not a text of comma-separated values") from None
    numbered = csv_lines(path, text, ";" if ";" in text.partition("\n")[0] else ",")
    filled = ((number, line) for number, line in numbered if any(cell.strip() for cell in line))
    lines = list(itertools.islice(filled, MOST_COORDINATES + 2))
    if not lines:
        raise DataError(one_line(path), what.replace("a ", "an empty ", 1))
    columns = [cell.strip() if known is None else cell.strip().lower() for cell in lines[0][1]]
    for column in columns:
        if known is not None and column not in known:
            raise DataError(one_line(path), f"column {one_line(column)[:40]!r}: must be one of {', '.join(known)}")
    if len(set(columns)) < len(columns) or not set(needed) <= set(columns):
        raise DataError(one_line(path), f"must have the columns {' and '.join(needed)}, each column once")
    if len(lines) - 1 > MOST_COORDINATES:
        raise DataError(one_line(path), f"has more than {MOST_COORDINATES} rows")
    return columns, lines[1:]


def cells_of(file: str, where: str, columns: Sequence[str], line: Sequence[str]) -> dict[str, str]:
    """The cells of a row by column name."""
    if len(line) != len(columns):
        raise DataError(file, f"{where}: has {len(line)} values for {len(columns)} columns")
    return dict(zip(columns, (cell.strip() for cell in line), strict=True))


def _table(file: str, columns: Sequence[str], lines: Sequence[tuple[int, list[str]]]) -> Coordinates:
    nodes, directions = [], []
    names: dict[str, int] = {}
    positions: dict[int, float] = {}
    for number, line in lines:
        where = f"line {number}"
        cells = cells_of(file, where, columns, line)
        node = number_in(file, where, "node", cells["node"], int)
        direction = cells["direction"].lower()
        if direction not in PLANE + _OTHER:
            raise DataError(file, f"{where}: direction {one_line(direction)[:40]!r}: must be x, y, rx, ry or other")
        nodes.append(node)
        directions.append(direction if direction in PLANE else "other")
        name = cells.get("name", "")
        if name and names.setdefault(name, node) != node:
            raise DataError(file, f"{where}: the name {one_line(name)[:40]!r} is used for nodes {names[name]} and {node}")
        if cells.get("position"):
            place = number_in(file, where, "position", cells["position"], float)
            if positions.setdefault(node, place) != place:
                raise DataError(file, f"{where}: node {node} has the positions {positions[node]:g} and {place:g}")
    if not nodes:
        raise DataError(file, "a coordinate table without rows")
    table = Coordinates(np.array(nodes, np.int64), np.array(directions), names, positions)
    _refuse_twice(file, table)
    return table


def number_in(file: str, where: str, column: str, cell: str, kind: Any) -> Any:
    """The number in a cell, of magnitude below 2^40."""
    try:
        value = kind(cell)
    except ValueError:
        value = None
    if value is None or not -(2**40) < value < 2**40:  # NaN fails as well
        raise DataError(file, f"{where}: {column} {one_line(cell)[:40]!r}: must be a {'whole ' if kind is int else ''}number")
    return value


def _refuse_twice(file: str, table: Coordinates) -> None:
    seen = set()
    for place in zip(table.node.tolist(), table.direction.tolist(), strict=True):
        if place[1] != "other" and place in seen:
            raise DataError(file, f"direction {place[1]} of node {place[0]} occurs twice")
        seen.add(place)


def from_labels(labels: NDArray[np.int64], axis: str = "z", source: str = "labels") -> Coordinates:
    """Coordinates from the labels in a matrix file.

    Parameters
    ----------
    labels : (n, 2) int array
        Node and direction, 1 to 3 along and 4 to 6 about the axes of the model; 0 (a scalar point) and above 6 are "other".
    axis : str
        Rotor axis: "x", "y" or "z"; the lateral directions are then y and z, z and x, or x and y.
    source : str
        Name for messages.

    Raises
    ------
    DataError
        An invalid axis, or a duplicate coordinate.
    """
    if axis not in _OF_LABELS:
        raise DataError(source, f"axis {axis!r}: must be x, y or z ({nearest(axis, tuple(_OF_LABELS))})")
    known: Sequence[str] = ("other", *_OF_LABELS[axis], "other")
    direction = np.array(known)[np.clip(labels[:, 1], 0, 7)]
    table = Coordinates(labels[:, 0].astype(np.int64), direction)
    _refuse_twice(source, table)
    return table
