"""The pseudolinear contact: its kinematics (4)-(7), its modes, the force inside a mode (10), (11) and when a mode is left."""

import math
from typing import NamedTuple

from rsc.kernel.jit import inlined

# normal modes: no contact; pressing (no damper); separating (damper acts); separating and clipped at zero force
OPEN, CLOSING, OPENING, CLIPPED = range(4)
# friction modes: sliding with full mu forward or backward, or inside the regularised range around zero slip
BACKWARD, CREEPING, FORWARD = -1, 0, 1


class Law(NamedTuple):
    """The force inside one mode, without branches: F_N = k p + b p', mu sigma = mu + mu_slope v_rel."""

    k: float  # N/m
    b: float  # N s/m
    mu: float
    mu_slope: float  # s/m


class Kinematics(NamedTuple):
    """Contact deflection d and its rates."""

    d_y: float  # m
    d_z: float
    inverse: float  # 1/|d|
    distance: float  # |d|
    penetration: float  # p = |d| - gap
    rate: float  # p'
    tangential: float  # Im(d' conj d)/|d|
    slip: float  # v_rel = Omega d_R/2 + tangential
    speed: float  # |d'_y| + |d'_z|, a scale for rates


@inlined
def kinematics(con, d, d_dot, turn):
    """Kinematics from the sums over the coordinates, d and d_dot (pairs), and the rotation `turn`."""
    ring_y = turn.cos * con.ring_y - turn.sin * con.ring_z
    ring_z = turn.cos * con.ring_z + turn.sin * con.ring_y
    d_y, d_z = d[0] + ring_y, d[1] + ring_z
    v_y, v_z = d_dot[0] - turn.omega * ring_z, d_dot[1] + turn.omega * ring_y
    distance = math.sqrt(d_y * d_y + d_z * d_z)
    # the direction is undefined at d = 0; there is no contact there (gap > 0), so any finite number serves
    inverse = 1.0 / distance if distance > 0.0 else 0.0
    tangential = (d_y * v_z - d_z * v_y) * inverse
    return Kinematics(
        d_y,
        d_z,
        inverse,
        distance,
        distance - con.gap,
        (d_y * v_y + d_z * v_z) * inverse,
        tangential,
        turn.omega * con.radius + tangential,
        abs(v_y) + abs(v_z),
    )


@inlined
def classify(con, kin):
    """The mode (normal, friction) that belongs to a state, by the signs alone."""
    if not kin.penetration > 0.0:
        normal = OPEN
    elif con.b_c == 0.0 or kin.rate >= 0.0:
        normal = CLOSING
    elif con.k_c * kin.penetration + con.b_c * kin.rate >= 0.0:
        normal = OPENING
    else:
        normal = CLIPPED
    if con.radius == 0.0 or kin.slip >= con.slip_velocity:
        friction = FORWARD
    elif kin.slip <= -con.slip_velocity:
        friction = BACKWARD
    else:
        friction = CREEPING
    return normal, friction


@inlined
def law_of(con, normal, friction):
    """Constants of the force inside a mode."""
    pressed = normal == CLOSING or normal == OPENING
    k = con.k_c if pressed else 0.0
    b = con.b_c if normal == OPENING else 0.0
    if friction == CREEPING:
        return Law(k, b, 0.0, con.friction / con.slip_velocity)
    return Law(k, b, con.friction * friction, 0.0)


@inlined
def normal_force(law, kin):
    """F_N inside a mode, N."""
    return law.k * kin.penetration + law.b * kin.rate


@inlined
def exit_margin(con, normal, friction, kin):
    """Dimensionless distance to the nearest switch out of a mode: positive inside, negative beyond."""
    opening = -kin.penetration / kin.distance if kin.distance > 0.0 else 1.0
    if normal == OPEN:
        return opening
    receding = -kin.rate / kin.speed if kin.speed > 0.0 else 0.0
    force = con.k_c * kin.penetration + con.b_c * kin.rate
    force_scale = con.k_c * kin.distance + con.b_c * kin.speed
    if normal == CLIPPED:
        return min(-opening, -force / force_scale)
    if normal == OPENING:
        margin = min(receding, force / force_scale)
    else:
        margin = -opening if con.b_c == 0.0 else -receding
    if con.radius > 0.0:
        margin = min(margin, _friction_margin(con, friction, kin))
    return margin


@inlined
def _friction_margin(con, friction, kin):
    scale = kin.speed + con.slip_velocity
    if friction == CREEPING:
        return (con.slip_velocity - abs(kin.slip)) / scale
    return (friction * kin.slip - con.slip_velocity) / scale
