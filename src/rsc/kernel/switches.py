"""Steps that end on the switches of the contact: whether a step left its contact state, and how long the next attempt should be.

The force is continuous over every switch, so a step that ends a time tau behind one has used a force that is wrong by at most
Delta F there and leaves an error of the velocity of Delta F tau/(2 m), quadratic in tau. The step is taken when that stays below
`switch_tol` in the measure of the error norm; else it is repeated to end just behind the root on its own interpolant.
"""

import math
from typing import NamedTuple

from rsc.kernel.clock import contact_turn
from rsc.kernel.contact import CLIPPED, CLOSING, OPEN, OPENING, classify, exit_margin, law_of, normal_force
from rsc.kernel.dense import dense_of, interpolate
from rsc.kernel.rhs import contact_kinematics
from rsc.kernel.simd import vec
from rsc.kernel.simd.hints import aligned_stack
from rsc.kernel.simd.jit import compiled, inlined
from rsc.kernel.step import pair_square
from rsc.kernel.turn import TWO_PI

EPS = 2.220446049250313e-16
LOOKS, HALVINGS = 6, 10


class Path(NamedTuple):
    """An attempted step with all that the motion inside it needs."""

    step: object
    clock: object
    h: float


@inlined
def kinematics_inside(con, path, dense, theta):
    """((x, v), contact kinematics) inside an attempted step whose polynomials are `dense`."""
    x, v = interpolate(dense, theta)
    return (x, v), contact_kinematics(con, x, v, contact_turn(con, path.clock, theta * path.h))


@inlined
def may_touch_inside(normal, kin, kin_new, h):
    """Could the gap close and open again inside a step that starts and ends open (or the reverse, pressed)?"""
    p, p_new = kin.place.penetration, kin_new.place.penetration
    reach = h * max(abs(kin.motion.rate), abs(kin_new.motion.rate))
    if normal == OPEN:
        return max(p, p_new) + reach > 0.0
    return kin.motion.rate < 0.0 and kin_new.motion.rate > 0.0 and min(p, p_new) - reach < 0.0


@inlined
def _rate_slope(con, kin, a, speeds):
    """p'', m/s^2, where the accelerations are `a` and the rotor turns at speeds = (Hz, Hz/s)."""
    place, tangential = kin.place, kin.motion.tangential
    d_y, d_z = vec.pair_sum(vec.product(con.contact_row, a))
    if con.has_ring:
        omega, omega_dot = TWO_PI * speeds[0], TWO_PI * speeds[1]
        d_y = d_y - omega * omega * place.ring_y - omega_dot * place.ring_z
        d_z = d_z - omega * omega * place.ring_z + omega_dot * place.ring_y
    return (place.d_y * d_y + place.d_z * d_z + tangential * tangential) * place.inverse


@inlined
def slope_of_rate(con, law, kin, a, clock):
    """p'' at a step's end, for `rate_dips`; 0 where no damper could switch."""
    if not (law.k > 0.0 and con.b_c > 0.0):
        return 0.0
    return _rate_slope(con, kin, a, (clock.speed, clock.speed_rate))


@inlined
def rate_dips(sign, start, new, h):
    """Whether sign p', positive at both ends of a step, may be negative between: its tangents at the ends meet below zero."""
    slope, slope_new = sign * start.rate_slope, sign * new.rate_slope
    # a convex function lies above its tangents, and so above the point where they meet
    meet_below = sign * (new.kin.motion.rate * slope - start.kin.motion.rate * slope_new) > h * slope * slope_new
    return (slope < 0.0) & (slope_new > 0.0) & meet_below


@inlined
def may_turn_inside(con, normal, start, new, h):
    """Could a contact with a damper leave its state by the sign of p' and come back inside a step that keeps it at both ends?"""
    if con.b_c == 0.0 or normal in (OPEN, CLIPPED):
        return False
    return rate_dips(1.0 if normal == CLOSING else -1.0, start, new, h)


@inlined
def _extremum_between(con, path, dense, bracket, rates):
    """theta where the gap's rate changes sign, by Illinois on the interpolant."""
    a, b = bracket
    f_a, f_b = rates
    theta = a
    for _ in range(20):
        theta = a + (b - a) * f_a / (f_a - f_b)
        rate = kinematics_inside(con, path, dense, theta)[1].motion.rate
        if abs(rate) <= 1e-9 * (abs(rates[0]) + abs(rates[1])):
            break
        if (rate > 0.0) == (f_a > 0.0):
            a, f_a, f_b = theta, rate, 0.5 * f_b
        else:
            b, f_b, f_a = theta, rate, 0.5 * f_a
    return theta


@inlined
def _touch_inside(con, contact, path, dense, kin):
    """(theta of the first extremum of the gap beyond a contact state that begins with `kin`, kinematics there); theta 0 for none.

    The rate is looked at in several places: a long step may recede, touch and recede again.
    """
    sign = 1.0 if contact[0] == OPEN else -1.0
    before, rate_before = 0.0, kin.motion.rate
    for k in range(1, LOOKS + 1):
        theta = k / LOOKS
        rate = kinematics_inside(con, path, dense, theta)[1].motion.rate
        if sign * rate_before > 0.0 and sign * rate < 0.0:
            far = _extremum_between(con, path, dense, (before, theta), (rate_before, rate))
            kin_far = kinematics_inside(con, path, dense, far)[1]
            if exit_margin(con, contact[0], contact[1], kin_far) < 0.0:
                return far, kin_far
        before, rate_before = theta, rate
    return 0.0, kin


@inlined
def _dip_inside(con, contact, path, dense, kin):
    """(theta where the exit margin is negative inside a step that begins with `kin`, the kinematics there); theta 0 for nowhere.

    Looked at in several places, then at ever shorter distances on both sides of the lowest.
    """
    best, far, least, shift = 0.0, kin, 2.0, 1.0 / LOOKS
    for i in range(LOOKS - 1 + 2 * HALVINGS):
        theta = (i + 1.0) / LOOKS
        if i >= LOOKS - 1:
            shift = -shift if (i - LOOKS) % 2 == 0 else 0.5 * abs(shift)
            theta = best + shift
        kin_there = kinematics_inside(con, path, dense, theta)[1]
        margin = exit_margin(con, contact[0], contact[1], kin_there)
        if margin < least:
            best, far, least = theta, kin_there, margin
        if margin < 0.0:
            return best, far
    return 0.0, kin


@inlined
def _root_inside(con, contact, path, dense, far, margins, g_tol):
    """theta of the switch on the interpolant, by Anderson and Bjorck between 0 (margin g_near >= 0) and far (g_far < 0)."""
    g_near, g_far = margins
    near, side = 0.0, 0
    theta = far
    for _ in range(40):
        # a contact state begins at its own switch: from there the margin rises before it falls
        begins = near == 0.0 and g_near < -0.1 * g_far
        theta = 0.5 * far if begins else near + (far - near) * g_near / (g_near - g_far)
        g = exit_margin(con, contact[0], contact[1], kinematics_inside(con, path, dense, theta)[1])
        if -g_tol <= g <= min(g_tol, g_near) or far - near <= 8.0 * EPS:
            break
        if g > 0.0:
            share = 1.0 - g / g_near
            near, g_near = theta, g
            if side == 1:
                g_far *= share if share > 0.0 else 0.5
            side = 1
        else:
            share = 1.0 - g / g_far
            far, g_far = theta, g
            if side == -1 and not begins:
                g_near *= share if share > 0.0 else 0.5
            side = -1
    return theta


@inlined
def _defect2(con, force, tau, v):
    """Square of the velocity's error that a wrong force leaves in a time tau, in the measure of the error norm without rtol."""
    reach = con.force_row * con.force_row / (con.scale_v + pair_square(v))
    impulse = force * tau
    return impulse * impulse * vec.largest(reach)


@inlined
def _wrong_force(con, contact, kin):
    """Difference of the force in a contact state and in the one that `kin` belongs to, N; the spring's for a release, which has
    none (so that the times of contact and what the spring loses are as exact as the motion)."""
    if contact[0] == CLIPPED:
        return con.k_c * abs(kin.place.penetration)
    law = law_of(con, contact[0], contact[1])
    contact_true = classify(con, kin)
    law_true = law_of(con, contact_true[0], contact_true[1])
    normal, true = normal_force(law, kin), normal_force(law_true, kin)
    slip = kin.motion.slip
    across = normal * (law.mu + law.mu_slope * slip) - true * (law_true.mu + law_true.mu_slope * slip)
    return math.sqrt((normal - true) * (normal - true) + across * across)


@inlined
def _far_side(con, contact, path, dense, kins, g_end):
    """(theta of a place beyond the contact state, kinematics there): the step's end or an extremum inside; theta 0 for none."""
    kin, kin_new = kins
    # an open contact that ends pressed but receding has turned inside, and at its end the force may be clipped to nothing
    turned = contact[0] == OPEN and kin_new.motion.rate < 0.0
    if g_end < 0.0 and not turned:
        return 1.0, kin_new
    theta, kin_far = _touch_inside(con, contact, path, dense, kin)
    if theta == 0.0 and contact[0] in (CLOSING, OPENING):
        theta, kin_far = _dip_inside(con, contact, path, dense, kin)
    if theta == 0.0 and g_end < 0.0:
        return 1.0, kin_new
    return theta, kin_far


@inlined
def _time_beyond(value, slope):
    """Longest time for which a quantity may have been negative that is so at a step's end, where its slope is given."""
    if value >= 0.0:
        return 0.0
    # a parabola that was zero before is zero at the latest at its vertex, twice as far as its tangent is
    return 2.0 * value / slope if slope < 0.0 else math.inf


@inlined
def _longest_tau(con, contact, path, kin):
    """A time within which a step that ends beyond its contact state met the switch, by the slopes at its end; inf if unknown."""
    if contact[0] == CLIPPED or con.radius > 0.0:
        return math.inf
    p, rate = kin.place.penetration, kin.motion.rate
    if contact[0] == OPEN:
        return _time_beyond(-p, -rate)
    slope = _rate_slope(con, kin, path.step.a, (path.clock.speed + path.clock.speed_rate * path.h, path.clock.speed_rate))
    if contact[0] == CLOSING:
        tau = _time_beyond(p, rate)
        return tau if con.b_c == 0.0 else max(tau, _time_beyond(rate, slope))
    return max(_time_beyond(-rate, -slope), _time_beyond(con.k_c * p + con.b_c * rate, con.k_c * rate + con.b_c * slope))


@compiled
def search(con, contact, path, kins, method):
    """Length of the step to try instead of an attempted one that left its contact state or may have; 0 to take it as it is."""
    aligned_stack()
    h, tol2 = path.h, con.switch_tol * con.switch_tol
    kin, kin_new = kins
    g_end = exit_margin(con, contact[0], contact[1], kin_new)
    if g_end < 0.0:
        # a step that was made to end just behind the switch needs no second search
        tau = _longest_tau(con, contact, path, kin_new)
        if _defect2(con, 0.5 * _wrong_force(con, contact, kin_new), tau, path.step.v) <= tol2:
            return 0.0
    dense = dense_of(path, method)
    g_near = max(exit_margin(con, contact[0], contact[1], kin), 0.0)
    theta_far, kin_far = _far_side(con, contact, path, dense, kins, g_end)
    if theta_far == 0.0:
        return 0.0
    g_far = exit_margin(con, contact[0], contact[1], kin_far)
    # the mean force of a rise to the end, or of a rise and fall around an extremum with some to spare
    force = (0.5 if theta_far == 1.0 else 2.0) * _wrong_force(con, contact, kin_far)
    # smallest share of the time beyond the switch that a new step may end behind it, times a thousandth
    g_tol = 1e-3 * abs(g_far) * math.sqrt(min(0.1 * con.switch_tol / math.sqrt(_defect2(con, force, h, path.step.v)), 0.01))
    theta = _root_inside(con, contact, path, dense, theta_far, (g_near, g_far), g_tol)
    tau = (theta_far - theta) * h
    defect2 = _defect2(con, force, tau, path.step.v)
    if defect2 <= tol2:
        return 0.0
    behind = 0.1 * tau
    if theta_far == 1.0:
        # a tenth of what is allowed behind the switch, so that the new step's own switch is not missed by rounding
        behind = min(tau * math.sqrt(0.1 * con.switch_tol / math.sqrt(defect2)), behind)
    h_new = theta * h + max(behind, 16.0 * EPS * (path.clock.hi + h))
    return h_new if h_new < h else 0.0
