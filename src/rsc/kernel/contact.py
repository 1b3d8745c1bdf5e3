"""The pseudolinear contact: its kinematics (4)-(7), its states, the force inside a state (10), (11) and when it is left."""

import math
from typing import NamedTuple

from rsc.kernel import springs
from rsc.kernel.race import on_surface
from rsc.kernel.simd.hints import branched
from rsc.kernel.simd.jit import anywhere, inlined

# normal states: no contact; pressing (no damper); separating (damper acts); separating and clipped at zero force
OPEN, CLOSING, OPENING, CLIPPED = range(4)
# friction states: sliding with full mu forward or backward, or inside the regularised range around zero slip
BACKWARD, CREEPING, FORWARD = -1, 0, 1


class Surfaces(NamedTuple):
    """Constants of the surfaces that touch."""

    spring: object  # of one of the kinds in springs.py
    damping: float  # N s/m, b_C
    friction: float  # mu
    radius: float  # m, d_R/2; 0 = one-sided friction law
    slip_velocity: float  # m/s, half-width of the Coulomb regularisation


class StateLaw(NamedTuple):
    """The force inside one contact state, without branches: F_N = F(p) + b p', mu sigma = mu + mu_slope v_rel."""

    spring: object  # F(p), of a kind in springs.py
    b: float  # N s/m
    mu: float
    mu_slope: float  # s/m


class Deflection(NamedTuple):
    """Contact deflection d."""

    d_y: float  # m
    d_z: float
    inverse: float  # 1/|d|
    distance: float  # |d|, m
    penetration: float  # p = |d| - gap
    ring_y: float  # m, eccentricity of the contact ring as turned
    ring_z: float


class DeflectionRates(NamedTuple):
    """Rates of the contact deflection, m/s."""

    rate: float  # p'
    along: float  # Re(d' conj d), m^2/s
    cross: float  # Im(d' conj d), m^2/s
    tangential: float  # Im(d' conj d)/|d|
    slip: float  # v_rel = Omega d_R/2 + tangential, less what the stator's surface moves
    speed: float  # |d'_y| + |d'_z|, a scale for rates


class Kinematics(NamedTuple):
    """Contact deflection and its rates."""

    place: Deflection
    motion: DeflectionRates


@inlined
def no_place():
    """A Deflection where nobody asks for it."""
    return Deflection(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@inlined
def direction(con, d, turn):
    """Deflection from the sum over the coordinates d (a pair) and the rotation; 1/|d| of d = 0 is NaN."""
    d_y, d_z = d
    ring_y, ring_z = 0.0, 0.0
    if con.has_ring:
        ring_y = turn.cos * con.ring_y - turn.sin * con.ring_z
        ring_z = turn.cos * con.ring_z + turn.sin * con.ring_y
        d_y, d_z = d_y + ring_y, d_z + ring_z
    if con.has_offset:
        d_y, d_z = d_y - con.offset_y, d_z - con.offset_z
    square = d_y * d_y + d_z * d_z
    distance = math.sqrt(square)
    # root and division at once, not one after the other
    inverse = distance * (1.0 / square)
    return Deflection(d_y, d_z, inverse, distance, distance - con.gap, ring_y, ring_z)


@inlined
def motion(con, d_dot, surface, place, turn):
    """DeflectionRates from the sum over the coordinates d' (a pair) and a race's `surface_of`."""
    v_y, v_z = d_dot
    if con.has_ring:
        v_y, v_z = v_y - turn.omega * place.ring_z, v_z + turn.omega * branched(place.ring_y)
    # the products first: 1/|d| is known long before the velocity, and the force waits for them
    cross = place.d_y * v_z - place.d_z * v_y
    tangential = cross * place.inverse
    along = place.d_y * v_y + place.d_z * v_z
    rate = along * place.inverse
    slip = on_surface(turn.omega * con.surfaces.radius + tangential, surface)
    return DeflectionRates(rate, along, cross, tangential, slip, abs(v_y) + abs(v_z))


@inlined
def place_anyhow(con, d, turn):
    """Deflection with a finite 1/|d| also of d = 0: there is no contact there (gap > 0), so any number serves."""
    p = direction(con, d, turn)
    inverse = p.inverse if p.distance > 0.0 else 0.0
    return Deflection(p.d_y, p.d_z, inverse, p.distance, p.penetration, p.ring_y, p.ring_z)


@inlined
def kinematics(con, d, d_dot, surface, turn):
    """Kinematics from the sums over the coordinates, d and d' (pairs), a race's `surface_of`, and the rotation."""
    place = place_anyhow(con, d, turn)
    return Kinematics(place, motion(con, d_dot, surface, place, turn))


@inlined
def classify(con, kin):
    """The contact state (normal, friction) to which coordinates belong, by the signs alone."""
    p, rate, slip = kin.place.penetration, kin.motion.rate, kin.motion.slip
    if not p > 0.0:
        normal = OPEN
    elif con.surfaces.damping == 0.0 or rate >= 0.0:
        normal = CLOSING
    elif pressing(con, p, rate) >= 0.0:
        normal = OPENING
    else:
        normal = CLIPPED
    # without a diameter nobody knows the slip: the one-sided law slides forward always (12)
    if con.surfaces.radius == 0.0 or slip >= con.surfaces.slip_velocity:
        friction = FORWARD
    elif slip <= -con.surfaces.slip_velocity:
        friction = BACKWARD
    else:
        friction = CREEPING
    return normal, friction


@inlined
def law_of(con, normal, friction):
    """Constants of the force inside a contact state."""
    pressed = normal in (CLOSING, OPENING)
    spring = springs.times(con.surfaces.spring, 1.0 if pressed else 0.0)
    b = con.surfaces.damping if normal == OPENING else 0.0
    if friction == CREEPING:  # mu v_rel/v_s, which meets -mu and mu at the ends of the range: the force is continuous
        return StateLaw(spring, b, 0.0, con.surfaces.friction / con.surfaces.slip_velocity)
    return StateLaw(spring, b, con.surfaces.friction * friction, 0.0)


@anywhere
def pressing(con, p, rate):
    """F_N of spring and damper, N, at a penetration and its rate."""
    return springs.switch(con.surfaces.spring, p) + con.surfaces.damping * rate


@inlined
def pressing_slope(con, p, rate, rate_slope):
    """Slope of `pressing` by time, N/s, where p'' is `rate_slope`."""
    return springs.slope(con.surfaces.spring, p) * rate + con.surfaces.damping * rate_slope


def limits_of(surfaces):
    """(stiffness, N/m, damping, N s/m) of a pressed contact that limit stable steps."""
    return springs.limit(surfaces.spring), surfaces.damping


@inlined
def normal_force(law, kin):
    """F_N inside a contact state, N."""
    return springs.switch(law.spring, kin.place.penetration) + law.b * kin.motion.rate


@inlined
def stays(con, normal, friction, kin):
    """Whether coordinates still belong to a contact state: exit_margin(...) >= 0, by the signs alone."""
    p, rate = kin.place.penetration, kin.motion.rate
    if normal == OPEN:
        return p <= 0.0
    if normal == CLIPPED:
        return p >= 0.0 and pressing(con, p, rate) <= 0.0
    if normal == OPENING:
        inside = rate <= 0.0 and pressing(con, p, rate) >= 0.0
    else:
        # p as well: a rate that is wrong by its tolerance may hide a slow release, and the spring would pull
        inside = p >= 0.0 and (con.surfaces.damping == 0.0 or rate >= 0.0)
    if con.surfaces.radius > 0.0:
        inside = inside and _friction_margin(con, friction, kin.motion) >= 0.0
    return inside


@inlined
def switch_values(con, normal, friction, kin):
    """What the switches out of a contact state watch, each positive inside and negative beyond: penetration or its rate, m or
    m/s, force, N, and slip, m/s; infinite where there is no such switch."""
    p, rate = kin.place.penetration, kin.motion.rate
    force = pressing(con, p, rate)
    if normal == OPEN:
        return -p, math.inf, math.inf
    if normal == CLIPPED:
        return p, -force, math.inf
    slip = _friction_reserve(con, friction, kin.motion) if con.surfaces.radius > 0.0 else math.inf
    if normal == OPENING:
        return -rate, force, slip
    return (p if con.surfaces.damping == 0.0 else rate), math.inf, slip


@inlined
def exit_margin(con, normal, friction, kin):
    """Dimensionless distance to the nearest switch out of a contact state: positive inside, negative beyond."""
    place, motion = kin.place, kin.motion
    # made dimensionless by scales of the motion itself, since a root is looked for where the margin is zero to rounding
    opening = -place.penetration * place.inverse if place.distance > 0.0 else 1.0
    if normal == OPEN:
        return opening
    receding = -motion.rate / motion.speed if motion.speed > 0.0 else 0.0
    force = pressing(con, place.penetration, motion.rate)
    force_scale = con.surfaces.spring.k * place.distance + con.surfaces.damping * motion.speed
    if normal == CLIPPED:
        return min(-opening, -force / force_scale)
    if normal == OPENING:
        margin = min(receding, force / force_scale)
    elif con.surfaces.damping == 0.0:
        margin = -opening
    else:
        margin = min(-opening, -receding)
    if con.surfaces.radius > 0.0:
        margin = min(margin, _friction_margin(con, friction, motion))
    return margin


@inlined
def _friction_margin(con, friction, motion):
    return _friction_reserve(con, friction, motion) / (motion.speed + con.surfaces.slip_velocity)


@inlined
def _friction_reserve(con, friction, motion):
    """How far the slip is inside a friction state, m/s."""
    if friction == CREEPING:
        return con.surfaces.slip_velocity - abs(motion.slip)
    return friction * motion.slip - con.surfaces.slip_velocity
