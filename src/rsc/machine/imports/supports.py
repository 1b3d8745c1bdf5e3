"""Bearings and seals of a model whose coefficients follow the rotor speed, from a table: those at a node at some speeds."""

import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, one_line
from rsc.machine.imports.bearings import Bearing, with_bearings
from rsc.machine.imports.coordinates import cells_of, number_in, rows_of
from rsc.machine.model.following import over_speed
from rsc.machine.model.model import FiniteElementModel

_STIFFNESS, _DAMPING = (tuple(f"{letter}_{pair}" for pair in ("xx", "xy", "yx", "yy")) for letter in "kc")
_HZ, _RPM = "hz", "rpm"
_COLUMNS = ("node", _HZ, _RPM, *_STIFFNESS, *_DAMPING)
Coefficients = tuple[int | str, NDArray[np.float64], NDArray[np.float64]]  # node, (k,) speeds in Hz, (k, 8) coefficients


def read_supports(path: str | os.PathLike[str]) -> list[Coefficients]:
    """Read a table of supports: comma or semicolon separated values with a line of column names.

    Columns: node (number or name), hz or rpm (the rotor speed), k_xx, k_yy in N/m, c_xx, c_yy in N s/m; k_xy, k_yx, c_xy, c_yx
    where they are not 0. The rows of a node stand in the order of their speeds; two at least.

    Raises
    ------
    DataError
        Not readable, another column, no number, a node with one row, or with speeds that do not rise.
    """
    file = one_line(path)
    columns, lines = rows_of(path, _COLUMNS, ("node", "k_xx", "k_yy"), "a table of supports")
    if (_HZ in columns) == (_RPM in columns):
        raise DataError(file, "must have one column for the rotor speed, hz or rpm")
    rows: dict[str, list[list[float]]] = {}
    for number, line in lines:
        where = f"line {number}"
        cells = cells_of(file, where, columns, line)
        node = cells.pop("node")
        values = {column: number_in(file, where, column, cell, float) for column, cell in cells.items()}
        speed = values[_HZ] if _HZ in values else values[_RPM] / 60.0
        own = rows.setdefault(node, [])
        if own and not speed > own[-1][0]:
            raise DataError(file, f"{where}: the rotor speed must be more than in the row before of node {one_line(node)[:40]}")
        own.append([speed, *(values.get(column, 0.0) for column in (*_STIFFNESS, *_DAMPING))])
    for node, own in rows.items():
        if len(own) < 2:
            raise DataError(file, f"node {one_line(node)[:40]} has one row: coefficients that follow the speed need two at least")
    if not rows:
        raise DataError(file, "a table of supports without rows")
    return [(node, np.array(own)[:, 0], np.array(own)[:, 1:]) for node, own in rows.items()]


def with_supports(model: FiniteElementModel, supports: Sequence[Coefficients]) -> FiniteElementModel:
    """The model with these supports: knots at all their speeds; each is constant beyond its own rows.

    Raises
    ------
    DataError
        No such node; more than `MOST_KNOTS` speeds; a model that moves freely or is indefinite with the supports at one of them.
    """
    made = []
    for speed in np.unique(np.concatenate([speeds for _, speeds, _ in supports])).tolist():
        bearings = []
        for node, speeds, coefficients in supports:
            own = [float(np.interp(speed, speeds, column)) for column in coefficients.T]
            bearings.append(Bearing(node, (own[0], own[1], own[2], own[3]), (own[4], own[5], own[6], own[7])))
        try:
            made.append(replace(with_bearings(model, bearings), speed=speed))
        except DataError as error:
            raise DataError(model.source, f"with the supports at {speed:g} Hz: {error.problem}") from None
    return over_speed(made)
