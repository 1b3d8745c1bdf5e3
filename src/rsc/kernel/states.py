"""First-order states, of magnetic bearings, controllers, filters and viscoelastic supports.

    z' = Az z + Bz r + Bv r',    force Lz z + F r on the coordinates r of the bodies

The kernel integrates x'' = a(x, x'): z is the velocity of one more coordinate for each state, after those of the bodies. The
coordinate itself, the integral of z, acts on nothing; it is counted from the start of each step, and a sample has z in its place.
Every state is scaled so small (`simulation.states`) that nothing takes it for a displacement.
"""

from typing import NamedTuple

import numpy as np

from rsc.kernel.questions import has_states, is_none
from rsc.kernel.simd import vec
from rsc.kernel.simd.static import static


class StateData(NamedTuple):
    """First-order states of a Model."""

    # (intervals, 2, n, 2n) matrices on v and on x, column by column: rates of the states, and accelerations of the bodies
    columns: np.ndarray
    interval: np.ndarray  # (k,) index of these matrices after each corner of the schedule
    mark: np.ndarray  # (2n,) 1 at states, else 0
    weight: np.ndarray  # (2n,) kg, modal masses of the bodies, 0 at states


class PackedStates(NamedTuple):
    """First-order states in Constants."""

    mark: object
    weight: object


class StateForces(NamedTuple):
    """What the states add to accelerations, and its power on the bodies in W, both times field.time."""

    change: object
    power: float


@static
def states_of(data, width):
    """The PackedStates of a StateData; () for ()."""
    if is_none(data):
        return ()
    return PackedStates(vec.load(data.mark, width), vec.load(data.weight, width))


@static
def matrices_of(data):
    """(address of the interval of each corner, bytes of a matrix, address of the matrices) of a StateData; () for ()."""
    if is_none(data):
        return ()
    size = 8 * data.columns.shape[2] * data.columns.shape[3]
    return vec.address(data.interval), size, vec.address(data.columns)


@static
def matrices_in(matrices, i):
    """(address of the matrix on v, of that on x) after corner i of the schedule; () without states."""
    if is_none(matrices):
        return ()
    base = matrices[2] + 2 * matrices[1] * int(vec.number_at(matrices[0], i))
    return base, base + matrices[1]


@static
def controlled(con, field, x, v):
    """The StateForces in a state (x, v); () without states."""
    if not has_states(con):
        return ()
    change = field.time * (vec.times_columns(field.states[0], v) + vec.times_columns(field.states[1], x))
    y, z = vec.pair_sum(vec.product(con.states.weight * v, change))
    return StateForces(change, y + z)


@static
def with_control(part, a):
    """Add a StateForces to accelerations."""
    return a if is_none(part) else a + part.change


@static
def fed_by_control(part, weight, total):
    """total + weight * power; () without states."""
    return () if is_none(part) else vec.fma(weight, part.power, total)


@static
def without_integrals(con, x):
    """Coordinates with the integrals of the states reset to zero, as a step starts."""
    return x - con.states.mark * x if has_states(con) else x


@static
def as_sampled(con, x, v):
    """Coordinates with the states in place of their integrals."""
    return vec.fma(con.states.mark, v - x, x) if has_states(con) else x
