"""An inner race: a stator surface that can rotate, like that of a backup bearing into which a rotor was dropped.

    J omega' = mu sigma F_N R - drag omega,   v_rel = Omega d_R/2 - omega R + Im(d' conj d)/|d|,   R = d_R/2 + gap

The rotor surface has the radius d_R/2 about the rotor's centre, the race R about the stator's. The distance travelled by the race
surface and its velocity omega R form a coordinate of the kernel after those of the bodies, scaled by `SIZE`. Its drag is part of
the model's damping; the distance, which no result uses, is counted from the start of each step.
"""

from typing import NamedTuple

import numpy as np

from rsc.kernel.questions import has_race, is_none
from rsc.kernel.simd import vec
from rsc.kernel.simd.static import static
from rsc.kernel.turn import TWO_PI

# state per metre travelled: a power of two, which loses no bits, and too small to count as a displacement anywhere
SIZE = 2.0**-20


class RaceData(NamedTuple):
    """A race in a Model."""

    row: np.ndarray  # (2n,) 1/SIZE at the race coordinate, else 0
    per_mass: float  # 1/kg, R^2/J times SIZE^2
    radius: float  # m, R
    place: int  # index of the race coordinate in a state vector


class Race(NamedTuple):
    """A race in Constants."""

    row: object
    per_mass: float
    radius: float
    place: int


@static
def race_of(data, width):
    """The Race of a RaceData; () for ()."""
    return () if is_none(data) else Race(vec.load(data.row, width), data.per_mass, data.radius, data.place)


@static
def surface_of(contact, v):
    """omega R in m/s from velocities, its rate from accelerations; () without a race."""
    return vec.pair_sum(vec.product(contact.race.row, v))[0] if has_race(contact) else ()


@static
def on_surface(slip, surface):
    """Slip velocity relative to a surface that moves with `surface_of`."""
    return slip if is_none(surface) else slip - surface


@static
def torque_of(contact, force):
    """The friction force mu sigma F_N that drives the race; () without a race."""
    return force if has_race(contact) else ()


@static
def with_race(contact, force, a):
    """Add the acceleration of the race by `torque_of` to accelerations."""
    return vec.fma(force * contact.race.per_mass, contact.race.row, a) if has_race(contact) else a


@static
def reach_of(contact):
    """Squared accelerations per newton of contact force, normal or frictional, 1/kg^2."""
    square = contact.force_row * contact.force_row
    if has_race(contact):
        race = contact.race.per_mass * contact.race.row
        return vec.fma(race, race, square)
    return square


@static
def without_ways(contacts, x):
    """Coordinates with the distances travelled by races reset to zero, as a step starts."""
    return x if is_none(contacts) else without_ways(contacts[1:], _without_way(contacts[0], x))


@static
def _without_way(contact, x):
    return x - SIZE * (contact.race.row * x) if has_race(contact) else x


@static
def mark_races(contacts, base, row, v):
    """Write the speeds of races, Hz, into a sample in place of the distances travelled."""
    if is_none(contacts):
        return
    _mark_race(contacts[0], base, row, v)
    mark_races(contacts[1:], base, row, v)


@static
def _mark_race(contact, base, row, v):
    if not has_race(contact):
        return
    vec.store_number(base, row + contact.race.place, surface_of(contact, v) / (TWO_PI * contact.race.radius))
