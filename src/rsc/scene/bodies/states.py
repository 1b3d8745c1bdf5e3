"""First-order states of a body: `states`, matrices of any kind, and `magnetic_bearings`, the commonest of them."""

import math
from collections.abc import Sequence as Sequence_
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.scene.bodies.off import OFF, OFF_MEANING, off_time
from rsc.scene.keys.keys import RawTable, declare, known_keys
from rsc.scene.keys.nested import Inner
from rsc.scene.keys.readers import MAX_COORDINATES, Integer, Later, Listed, Number, Sequence, as_list

Row = NDArray[np.float64]  # (n,) of a displacement in the coordinates of a body
ENTRIES = Sequence(Sequence(Number("dimensionless")))
_PARTS = ("displacement", "velocity", "force")
MAX_STATES = 100
PULLS = "positive gains pull the rotor back to the centre"


@dataclass(frozen=True, kw_only=True)
class States:
    """First-order states z of the body, alike in both directions: z' = Az z + Bz r + Bv r', with the force Lz z on r."""

    matrix: tuple = declare(ENTRIES, meaning="Az, p x p for p states.")
    displacement: tuple | None = declare(ENTRIES, None, meaning="Bz, p x N: what the displacements do to the states.")
    velocity: tuple | None = declare(ENTRIES, None, meaning="Bv, p x N: what the velocities do to the states.")
    force: tuple = declare(ENTRIES, meaning="Lz, N x p: force of the states on the coordinates, N (N m on tilts).")


@dataclass(frozen=True, kw_only=True)
class MagneticBearing:
    """A magnetic bearing with its controller: the force k_s x - u at its actuator, which moves by x, with a' = nf (s - a), q' = s
    and u' = w_a (K_p s + K_i q + K_d nf (s - a) - u) from the displacement s at its sensor, s = x where both are at one place."""

    negative_stiffness: float = declare(
        Number("stiffness", low=0.0), 0.0, meaning="k_s > 0: the magnet pulls by k_s x away from the centre."
    )
    proportional: float = declare(Number("stiffness", low=0.0, hint=PULLS), meaning="Gain K_p of the displacement.")
    integral: float = declare(Number("integral gain", low=0.0), 0.0, meaning="Gain K_i of its integral.")
    derivative: float = declare(Number("damping", low=0.0, hint=PULLS), 0.0, meaning="Gain K_d of its filtered derivative.")
    derivative_filter: float | None = declare(
        Number("rate", above=0.0), None, meaning="Corner nf of the filter of the derivative; required with a derivative."
    )
    amplifier: float = declare(Number("frequency", above=0.0), meaning="Corner frequency w_a/2 pi of amplifier and coil.")
    off: float | None = declare(OFF, None, meaning=OFF_MEANING)


class StateMatrices(NamedTuple):
    """Az (p, p), Bz and Bv (p, n), Lz (n, p) of first-order states, and the stiffness (n, n) that belongs to them, N/m."""

    matrix: NDArray[np.float64]
    displacement: NDArray[np.float64]
    velocity: NDArray[np.float64]
    force: NDArray[np.float64]
    stiffness: NDArray[np.float64]


STATES = Inner(States)
STATES_MEANING = "First-order states: controllers, lags, viscoelastic supports (below)."
NUMBERS = ", ".join(known_keys(MagneticBearing))
BEARINGS = Later(
    f"a list of [coordinate, {{{NUMBERS}}}]", (Sequence(Listed((Integer(0, MAX_COORDINATES), Inner(MagneticBearing)))),)
)
BEARINGS_MEANING = "Magnetic bearings with their controllers, as [coordinate, table of numbers] (below)."


@dataclass(frozen=True, kw_only=True)
class HasStates:
    """Keys of the bodies that may have first-order states."""

    states: States | None = declare(STATES, None, meaning=STATES_MEANING)  # noqa: RUF009 (it is a field)
    magnetic_bearings: tuple | None = declare(BEARINGS, None, meaning=BEARINGS_MEANING)

    @property
    def at_end(self) -> Any:
        """The body without the magnetic bearings that are switched off."""
        staying = tuple(item for item in self.magnetic_bearings or () if item[-1].off is None)
        return replace(self, magnetic_bearings=staying or None)


def read_states(table: RawTable, values: Any, body: Any) -> None:
    """Check `states` and read `magnetic_bearings` of a body, in place; body: the same without them.

    Raises
    ------
    SceneError
        StateMatrices of other shapes, an incomplete bearing, or a bearing at a tilt or where coefficients follow the speed.
    """
    if values["states"] is not None:
        refuse_shapes(table, values["states"], dict.fromkeys(("sensors", "actuators"), body.n_coordinates))
    raw = values["magnetic_bearings"]
    made = () if raw is None else _bearings(table, raw, body)
    values["magnetic_bearings"], bearings = made or None, [item[0] for item in made]
    refuse_many(table, [item[-1] for item in made])
    for i, (place, *_) in enumerate(values.get("supports_by_speed") or ()):
        acting = values["states"] is not None and any(values["states"].force[place])
        if acting or place in bearings:
            hint = "put one of them at another coordinate, or write the support as states"
            table.refuse(f"supports_by_speed[{i}][0]", place, "a coordinate without first-order states", hint)


def refuse_shapes(table: RawTable, states: Any, sizes: dict[str, int]) -> None:
    """SceneError unless the matrices fit each other and the numbers of "sensors" and "actuators": those of the coordinates where
    the states act on coordinates."""
    p = len(states.matrix)
    if not 0 < p <= MAX_STATES:
        table.refuse("states.matrix", _plain(states.matrix), f"a matrix of 1 to {MAX_STATES} rows")
    sensed, moved = sizes["sensors"], sizes["actuators"]
    wanted = {"matrix": (p, p), "displacement": (p, sensed), "velocity": (p, sensed), "force": (moved, p)}
    for name, (rows, columns) in wanted.items():
        matrix = getattr(states, name)
        if matrix is not None and (len(matrix) != rows or any(len(row) != columns for row in matrix)):
            numbers = f"{sensed} sensors, {moved} actuators" if hasattr(states, "sensors") else f"{moved} coordinates"
            hint = f"{p} states, as states.matrix has rows, and {numbers}"
            table.refuse(f"states.{name}", _plain(matrix), f"a {rows} x {columns} matrix as nested lists", hint)
    if states.displacement is None and states.velocity is None:
        table.refuse("states.displacement", None, "given, or states.velocity", "nothing drives the states")


def refuse_many(table: RawTable, bearings: Sequence_[MagneticBearing]) -> None:
    """SceneError for magnetic bearings with more states together than a body may have."""
    count, one = 0, np.ones(1)
    for bearing in bearings:
        count += len(of_bearing(bearing, one, one).matrix)
    if count > MAX_STATES:
        table.refuse("magnetic_bearings", count, f"bearings with at most {MAX_STATES} states together")


def _plain(matrix: Any) -> list[list[float]]:
    return [list(row) for row in matrix]


def _bearings(table: RawTable, raw: Any, body: Any) -> tuple[Any, ...]:
    """((coordinate, MagneticBearing), ...), of a reduced rotor ((actuator row, sensor row, MagneticBearing), ...)."""
    items = as_list(raw)
    if items is None:
        table.refuse("magnetic_bearings", raw, BEARINGS.wanted)
    return tuple(_bearing(table, f"magnetic_bearings[{i}]", item, body) for i, item in enumerate(items))


def _bearing(table: RawTable, key: str, item: Any, body: Any) -> tuple[Any, ...]:
    parts, places = as_list(item), ("actuator row", "sensor row") if body.model == "reduced" else ("coordinate",)
    if parts is None or len(parts) != len(places) + 1:
        table.refuse(key, item, f"[{', '.join(places)}, {{{NUMBERS}}}]")
    if len(places) == 1:
        place = Integer(0, body.n_coordinates - 1).read(table, f"{key}[0]", parts[0])
        if place in body.tilts:
            table.refuse(f"{key}[0]", place, "a displacement", f"coordinate {place} is a tilt")
        return place, _own_bearing(table, key, parts[1])
    rows = [Sequence(Number("dimensionless")).read(table, f"{key}[{i}]", part) for i, part in enumerate(parts[:2])]
    for i, row in enumerate(rows):
        if len(row) != body.n_coordinates:
            table.refuse(f"{key}[{i}]", list(row), f"a row of {body.n_coordinates} numbers")
    return *rows, _own_bearing(table, key, parts[2])


def _own_bearing(table: RawTable, key: str, raw: Any) -> MagneticBearing:
    bearing = Inner(MagneticBearing).read(table, key, raw)
    return checked(table.within(key, raw), bearing)


def checked(table: RawTable, bearing: MagneticBearing) -> MagneticBearing:
    """A magnetic bearing from its own table; SceneError for one that cannot be built, or a time at which it cannot be switched
    off."""
    if bearing.derivative and bearing.derivative_filter is None:
        table.refuse("derivative_filter", None, "given with a derivative", "an exact derivative cannot be built")
    off_time(table, "off", bearing.off)
    return bearing


def matrices_of(body: Any, until: float = 0.0) -> StateMatrices | None:
    """The first-order states of a body: those of `states`, then of every magnetic bearing a, q (if K_d, K_i are not 0) and u;
    None without. until: without bearings that are switched off before this time in s."""
    return together([made for made, off in _parts(body) if off is None or off >= until])


def together(parts: Sequence_[StateMatrices]) -> StateMatrices | None:
    """The states of several parts as those of one; None without any."""
    if not parts:
        return None
    matrix, displacement, velocity, force, stiffness = zip(*parts, strict=True)
    return StateMatrices(
        scipy.linalg.block_diag(*matrix), np.vstack(displacement), np.vstack(velocity), np.hstack(force), sum(stiffness)
    )


def numbers_of(body: Any, until: float) -> NDArray[np.intp]:
    """The numbers that the states of `matrices_of(body, until)` have among all states of the body."""
    staying = [np.full(len(made.matrix), off is None or off >= until) for made, off in _parts(body)]
    return np.flatnonzero(np.concatenate([np.zeros(0, bool), *staying]))


def _parts(body: Any) -> list[tuple[StateMatrices, float | None]]:
    """The first-order states of every part of a body, each with the time at which it is switched off."""
    n, states = body.n_coordinates, body.states
    parts: list[tuple[StateMatrices, float | None]] = [] if states is None else [(_of_states(states, n), None)]
    for *places, bearing in body.magnetic_bearings or ():
        rows = [np.array(place) if isinstance(place, tuple) else np.eye(n)[place] for place in places]
        parts.append((of_bearing(bearing, rows[0], rows[-1]), bearing.off))
    return parts


def squared(row: Row) -> Any:
    """(n, n) row^T row, sparse for many coordinates."""
    if len(row) <= MAX_COORDINATES:
        return np.outer(row, row)
    column = scipy.sparse.csc_array(row[:, None])
    return column @ column.T


def _of_states(states: States, n: int) -> StateMatrices:
    none = np.zeros((len(states.matrix), n))
    sensed, moved = (none if part is None else np.array(part) for part in (states.displacement, states.velocity))
    return StateMatrices(np.array(states.matrix), sensed, moved, np.array(states.force), np.zeros((n, n)))


def of_bearing(bearing: MagneticBearing, actuator: Row, sensor: Row) -> StateMatrices:
    """The StateMatrices of one magnetic bearing with the states a, q and u, or fewer; rows (n,) of the displacements at its
    actuator and at its sensor."""
    corner, lag = bearing.derivative_filter or 0.0, 2.0 * math.pi * bearing.amplifier
    by_a = -bearing.derivative * corner
    gains = np.array([by_a, bearing.integral])
    matrix = np.array([[-corner, 0.0, 0.0], [0.0, 0.0, 0.0], [lag * by_a, lag * bearing.integral, -lag]])
    sensed = np.array([corner, 1.0, lag * (bearing.proportional - by_a)])
    kept = np.flatnonzero([*gains, 1.0])
    force = np.zeros((len(actuator), 3))
    force[:, 2] = -actuator
    displacement = np.outer(sensed, sensor)[kept]
    stiffness = -bearing.negative_stiffness * squared(actuator)
    return StateMatrices(matrix[np.ix_(kept, kept)], displacement, np.zeros_like(displacement), force[:, kept], stiffness)
