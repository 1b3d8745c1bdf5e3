"""Bearings and seals whose coefficients depend on the rotor speed or on the frequency of the vibration, from tables by node."""

import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, one_line
from rsc.machine.imports.bearings import Bearing, with_bearings
from rsc.machine.imports.coordinates import cells_of, number_in, rows_of
from rsc.machine.imports.rational import SupportStates, fit_states
from rsc.machine.model.following import over_speed
from rsc.machine.model.model import FiniteElementModel

_STIFFNESS, _DAMPING = (tuple(f"{letter}_{pair}" for pair in ("xx", "xy", "yx", "yy")) for letter in "kc")
_HZ, _RPM = "hz", "rpm"
_COLUMNS = ("node", _HZ, _RPM, *_STIFFNESS, *_DAMPING)
Coefficients = tuple[int | str, NDArray[np.float64], NDArray[np.float64]]  # node, (k,) speeds in Hz, (k, 8) coefficients


_ALIKE = 0.01  # share of the largest coefficient by which the directions may differ, and that may couple them
SPEED, FREQUENCY = "rotor speed", "vibration frequency"


def read_supports(path: str | os.PathLike[str], over: str = SPEED) -> list[Coefficients]:
    """Read a table of supports: comma- or semicolon-separated values with a header line.

    Columns: node (number or name), hz or rpm (rotor speed, or what else they are `over`), k_xx, k_yy in N/m, c_xx, c_yy in
    N s/m; k_xy, k_yx, c_xy, c_yx if not 0. The rows of a node are in the order of increasing speed, at least two.

    Raises
    ------
    DataError
        Not readable, an unknown column, not a number, a node with a single row or with speeds that do not increase.
    """
    file = one_line(path)
    columns, lines = rows_of(path, _COLUMNS, ("node", "k_xx", "k_yy"), "a table of supports")
    if (_HZ in columns) == (_RPM in columns):
        raise DataError(file, f"must have one column for the {over}, hz or rpm")
    rows: dict[str, list[list[float]]] = {}
    for number, line in lines:
        where = f"line {number}"
        cells = cells_of(file, where, columns, line)
        node = cells.pop("node")
        values = {column: number_in(file, where, column, cell, float) for column, cell in cells.items()}
        speed = values[_HZ] if _HZ in values else values[_RPM] / 60.0
        known = rows.setdefault(node, [])
        if known and not speed > known[-1][0]:
            raise DataError(file, f"{where}: the {over} must exceed that of the previous row of node {one_line(node)[:40]}")
        known.append([speed, *(values.get(column, 0.0) for column in (*_STIFFNESS, *_DAMPING))])
    for node, known in rows.items():
        if len(known) < 2:
            raise DataError(file, f"node {one_line(node)[:40]} has one row: coefficients over the {over} need at least two")
    if not rows:
        raise DataError(file, "a table of supports without rows")
    return [(node, np.array(known)[:, 0], np.array(known)[:, 1:]) for node, known in rows.items()]


def with_supports(model: FiniteElementModel, supports: Sequence[Coefficients], required: bool = True) -> FiniteElementModel:
    """The model with these supports: knots at all their speeds; each support is constant outside its speed range. required:
    whether they must hold it.

    Raises
    ------
    DataError
        No such node; more than `MOST_KNOTS` speeds; at one of them rigid-body motions or an indefinite stiffness remain.
    """
    made = []
    for speed in np.unique(np.concatenate([speeds for _, speeds, _ in supports])).tolist():
        bearings = []
        for node, speeds, coefficients in supports:
            at = [float(np.interp(speed, speeds, column)) for column in coefficients.T]
            bearings.append(Bearing(node, (at[0], at[1], at[2], at[3]), (at[4], at[5], at[6], at[7])))
        try:
            made.append(replace(with_bearings(model, bearings, required), speed=speed))
        except DataError as error:
            raise DataError(model.source, f"with the supports at {speed:g} Hz: {error.problem}") from None
    return replace(over_speed(made), free=any(one.free for one in made))


def read_by_frequency(path: str | os.PathLike[str]) -> list[tuple[str, SupportStates]]:
    """Read a table of supports over the frequency of the vibration, each fitted by first-order states (`fit_states`).

    Columns as for `read_supports`; hz or rpm is the size of the frequency, forward or backward.

    Raises
    ------
    DataError
        As `read_supports` and `fit_states`; a support whose directions differ or are coupled by more than 1 %.
    """
    made = []
    for node, frequency, coefficients in read_supports(path, FREQUENCY):
        name, each = one_line(node)[:40], coefficients.reshape(-1, 2, 4)
        for xx, xy, yx, yy in each.transpose(1, 2, 0):
            if max(np.abs(part).max() for part in (xx - yy, xy, yx)) > _ALIKE * np.abs(xx).max():
                problem = "its directions differ or are coupled; first-order states are alike in both and do not couple them"
                raise DataError(one_line(path), f"node {name}: {problem}")
        mean = 0.5 * (each[:, :, 0] + each[:, :, 3])
        try:
            made.append((str(node), fit_states(frequency, mean[:, 0], mean[:, 1])))
        except DataError as error:
            raise DataError(one_line(path), f"node {name}: {error.problem}") from None
    return made
