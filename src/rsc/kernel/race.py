"""An inner race: the stator's surface at a contact that turns, as that of a bearing in which a dropped rotor lies.

    J omega' = mu sigma F_N R - drag omega,   v_rel = Omega d_R/2 - omega R + Im(d' conj d)/|d|,   R = d_R/2 + gap

The rotor's surface lies at d_R/2 from its centre, that of the race at R from the stator's. The surface's way and its speed
omega R are a coordinate of the kernel behind those of the bodies, `SIZE` times. Its drag stands in the model's damping like
that of every other coordinate; its way, which nobody asks for, counts from the step's start.
"""

from typing import NamedTuple

import numpy as np

from rsc.kernel.questions import is_none
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import unrolled
from rsc.kernel.turn import TWO_PI

# of the state for a way of 1 m: a power of two, so that no bit is lost, and so small that nothing takes it for a motion
SIZE = 2.0**-20


class RaceData(NamedTuple):
    """A race in a Model."""

    row: np.ndarray  # (2n,) 1/SIZE in the place of its surface, else 0
    per_mass: float  # 1/kg, R^2/J times SIZE^2
    radius: float  # m, R
    place: int  # of its surface among the numbers of a state


class Race(NamedTuple):
    """A race in Constants."""

    row: object
    per_mass: float
    radius: float
    place: int


@unrolled
def race_of(data, width):
    """The Race of a RaceData, () of ()."""
    if not len(data):
        return lambda data, width: ()
    return lambda data, width: Race(vec.load(data.row, width), data.per_mass, data.radius, data.place)


def has_race(contact):
    """Whether ContactConstants, a type, have a race."""
    return len(contact[contact.fields.index("race")]) > 0


@unrolled
def surface_of(contact, v):
    """omega R, m/s, of velocities, of accelerations its rate; () without a race."""
    if not has_race(contact):
        return lambda contact, v: ()
    return lambda contact, v: vec.pair_sum(vec.product(contact.race.row, v))[0]


@unrolled
def on_surface(slip, surface):
    """The slip on a surface that moves with `surface_of`."""
    return (lambda slip, surface: slip) if is_none(surface) else (lambda slip, surface: slip - surface)


@unrolled
def torque_of(contact, force):
    """What friction, mu sigma F_N, turns: () without a race."""
    return (lambda contact, force: force) if has_race(contact) else (lambda contact, force: ())


@unrolled
def with_race(contact, force, a):
    """Accelerations with that of a race by a `torque_of`."""
    if not has_race(contact):
        return lambda contact, force, a: a
    return lambda contact, force, a: vec.fma(force * contact.race.per_mass, contact.race.row, a)


@unrolled
def reach_of(contact):
    """Squares of the accelerations by a force of 1 N at a contact, along it or by friction, 1/kg^2."""
    if not has_race(contact):
        return lambda contact: contact.force_row * contact.force_row

    def reach(contact):
        race = contact.race.per_mass * contact.race.row
        return vec.fma(race, race, contact.force_row * contact.force_row)

    return reach


@unrolled
def without_ways(contacts, x):
    """Coordinates where a step starts: the ways of surfaces count from there."""
    if not len(contacts):
        return lambda contacts, x: x
    if not has_race(contacts[0]):
        return lambda contacts, x: without_ways(contacts[1:], x)
    return lambda contacts, x: without_ways(contacts[1:], x - SIZE * (contacts[0].race.row * x))


@unrolled
def mark_races(contacts, base, row, v):
    """Write the speeds of races, Hz, of a sample in the places of their ways."""
    if not len(contacts):
        return lambda contacts, base, row, v: None
    if not has_race(contacts[0]):
        return lambda contacts, base, row, v: mark_races(contacts[1:], base, row, v)

    def mark(contacts, base, row, v):
        own = contacts[0]
        vec.store_number(base, row + own.race.place, surface_of(own, v) / (TWO_PI * own.race.radius))
        mark_races(contacts[1:], base, row, v)

    return mark
