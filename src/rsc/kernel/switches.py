"""Steps that end on the switches of the contact: whether a step left its mode, and how long the next attempt should be.

The force is continuous over every switch, so a step that ends a time tau behind one has used a force that is wrong by at most
Delta F there and leaves an error of the velocity of Delta F tau/(2 m), quadratic in tau. The step is taken when that stays below
`switch_tol` in the measure of the error norm; else it is repeated to end just behind the root on its own interpolant.
"""

import math
from typing import NamedTuple

from rsc.kernel import vec
from rsc.kernel.clock import contact_turn
from rsc.kernel.contact import CLIPPED, OPEN, classify, exit_margin, law_of, normal_force
from rsc.kernel.dopri5 import interpolate, pair_square
from rsc.kernel.jit import compiled, inlined
from rsc.kernel.rhs import contact_kinematics

EPS = 2.220446049250313e-16


class Path(NamedTuple):
    """An attempted step with all that the motion inside it needs."""

    step: object
    clock: object
    h: float


@inlined
def kinematics_inside(con, path, theta):
    """(x, contact kinematics) inside an attempted step."""
    x, v = interpolate(path.step, theta)
    return x, contact_kinematics(con, x, v, contact_turn(con, path.clock, theta * path.h))


@inlined
def may_touch_inside(normal, kin, kin_new, h):
    """Could the gap close and open again inside a step that starts and ends open (or the reverse, pressed)?"""
    rate, rate_new = kin.motion.rate, kin_new.motion.rate
    p, p_new = kin.place.penetration, kin_new.place.penetration
    if normal == OPEN:
        return rate > 0.0 and rate_new < 0.0 and max(p, p_new) + h * max(rate, -rate_new) > 0.0
    return rate < 0.0 and rate_new > 0.0 and min(p, p_new) - h * max(-rate, rate_new) < 0.0


@inlined
def _extremum_inside(con, mode, path, rates):
    """(theta where the gap's rate changes sign inside a step, the kinematics there), by Illinois on the interpolant."""
    a, b = 0.0, 1.0
    f_a, f_b = rates
    theta = 0.5
    for _ in range(20):
        theta = a + (b - a) * f_a / (f_a - f_b)
        rate = kinematics_inside(con, path, theta)[1].motion.rate
        if abs(rate) <= 1e-9 * (abs(rates[0]) + abs(rates[1])):
            break
        if (rate > 0.0) == (f_a > 0.0):
            a, f_a, f_b = theta, rate, 0.5 * f_b
        else:
            b, f_b, f_a = theta, rate, 0.5 * f_a
    return theta, kinematics_inside(con, path, theta)[1]


@inlined
def _root_inside(con, mode, path, g_near, far, g_far):
    """theta of the switch on the interpolant, by Illinois between 0 (margin g_near >= 0) and far (g_far < 0)."""
    near, side = 0.0, 0
    theta = far
    for _ in range(40):
        theta = near + (far - near) * g_near / (g_near - g_far)
        g = exit_margin(con, mode[0], mode[1], kinematics_inside(con, path, theta)[1])
        if g == 0.0 or far - near <= 8.0 * EPS:
            break
        if g > 0.0:
            step = theta - near
            near, g_near = theta, g
            g_far = 0.5 * g_far if side == 1 else g_far
            side = 1
        else:
            step = far - theta
            far, g_far = theta, g
            g_near = 0.5 * g_near if side == -1 else g_near
            side = -1
        if step <= 1e-9 and abs(g) <= 1e-12:
            break
    return theta


@inlined
def _defect2(con, force, tau, v):
    """Square of the velocity's error that a wrong force leaves in a time tau, in the measure of the error norm without rtol."""
    reach = con.force_row * con.force_row / (con.scale_v + pair_square(v))
    impulse = force * tau
    return impulse * impulse * vec.largest(reach)


@inlined
def _wrong_force(con, mode, kin):
    """Difference of the force in a mode and in the one the state belongs to, N; the spring's for a release, which has none
    (so that the times of contact and what the spring loses are as exact as the motion)."""
    if mode[0] == CLIPPED:
        return con.k_c * abs(kin.place.penetration)
    law = law_of(con, mode[0], mode[1])
    mode_true = classify(con, kin)
    law_true = law_of(con, mode_true[0], mode_true[1])
    normal, true = normal_force(law, kin), normal_force(law_true, kin)
    slip = kin.motion.slip
    across = normal * (law.mu + law.mu_slope * slip) - true * (law_true.mu + law_true.mu_slope * slip)
    return math.sqrt((normal - true) * (normal - true) + across * across)


@compiled
def search(con, mode, path, kin, kin_new):
    """Length of the step to try instead of an attempted one that left its mode or may have; 0 to take it as it is."""
    h, tol2 = path.h, con.switch_tol * con.switch_tol
    g_end = exit_margin(con, mode[0], mode[1], kin_new)
    g_near = max(exit_margin(con, mode[0], mode[1], kin), 0.0)
    if g_end < 0.0:
        theta = _root_inside(con, mode, path, g_near, 1.0, g_end)
        tau = (1.0 - theta) * h
        defect2 = _defect2(con, 0.5 * _wrong_force(con, mode, kin_new), tau, path.step.v)
        if defect2 <= tol2:
            return 0.0
        # a tenth of what is allowed behind the switch, so that the new step's own switch is not missed by rounding
        behind = min(tau * math.sqrt(0.1 * con.switch_tol / math.sqrt(defect2)), 0.1 * tau)
    else:
        theta_far, kin_far = _extremum_inside(con, mode, path, (kin.motion.rate, kin_new.motion.rate))
        g_far = exit_margin(con, mode[0], mode[1], kin_far)
        if not g_far < 0.0:
            return 0.0
        theta = _root_inside(con, mode, path, g_near, theta_far, g_far)
        tau = (theta_far - theta) * h
        if _defect2(con, 2.0 * con.k_c * abs(kin_far.place.penetration), tau, path.step.v) <= tol2:
            return 0.0
        behind = 0.1 * tau
    least = 16.0 * EPS * (path.clock.hi + h)
    h_new = theta * h + max(behind, least)
    return h_new if h_new < h else 0.0
