"""Steps that end on contact switches: whether a step left its contact state, and the length of the next attempt.

The force is continuous at every switch, so a step that ends a time tau after one has used a force in error by at most Delta F,
which leaves a velocity error of Delta F tau/(2 m), quadratic in tau. The step is accepted if that error is below `switch_tol` in
the error norm; otherwise it is repeated so as to end just beyond the switch as located on its dense output.
"""

import math
from typing import NamedTuple

from rsc.kernel import springs
from rsc.kernel.clock import contact_turn, speeds_after
from rsc.kernel.contact import (
    CLIPPED,
    CLOSING,
    OPEN,
    Deflection,
    DeflectionRates,
    Kinematics,
    classify,
    exit_margin,
    law_of,
    normal_force,
    pressing,
    pressing_slope,
    switch_values,
)
from rsc.kernel.contact_forces import kinematics_at
from rsc.kernel.dense import dense_of, interpolate
from rsc.kernel.race import on_surface, reach_of, surface_of
from rsc.kernel.simd import vec
from rsc.kernel.simd.hints import aligned_stack
from rsc.kernel.simd.jit import compiled, inlined
from rsc.kernel.simd.static import static
from rsc.kernel.step import pair_square
from rsc.kernel.turn import TWO_PI
from rsc.kernel.weights import by_series

EPS = 2.220446049250313e-16
LOOKS, PARABOLAS = 6, 3


class Path(NamedTuple):
    """An attempted step with the data for dense output."""

    step: object
    clock: object
    h: float


@inlined
def kinematics_inside(con, path, dense, theta):
    """((x, v), kinematics of one contact) inside an attempted step with dense output `dense`."""
    x, v = interpolate(dense, theta)
    return (x, v), kinematics_at(con, x, v, contact_turn(con, path.clock, theta * path.h, (x, v)))


@inlined
def _acceleration(con, kin, a, speeds):
    """d'' (a pair), m/s^2, for accelerations `a`; speeds = rotor speed (Hz) and its rate (Hz/s)."""
    place = kin.place
    d_y, d_z = vec.pair_sum(vec.product(con.contact_row, a))
    if con.has_ring:
        omega, omega_dot = TWO_PI * speeds[0], TWO_PI * speeds[1]
        d_y = d_y - omega * omega * place.ring_y - omega_dot * place.ring_z
        d_z = d_z - omega * omega * place.ring_z + omega_dot * place.ring_y
    return d_y, d_z


@inlined
def _rate_slope(con, kin, a, speeds):
    """p'', m/s^2; see `_acceleration`."""
    place, tangential = kin.place, kin.motion.tangential
    d_y, d_z = _acceleration(con, kin, a, speeds)
    return (place.d_y * d_y + place.d_z * d_z + tangential * tangential) * place.inverse


@inlined
def _slopes(con, kin, a, speeds):
    """(p'', v_rel'), m/s^2; see `_acceleration`."""
    place, motion = kin.place, kin.motion
    d_y, d_z = _acceleration(con, kin, a, speeds)
    along = place.d_y * d_y + place.d_z * d_z + motion.tangential * motion.tangential
    across = place.d_y * d_z - place.d_z * d_y - motion.tangential * motion.rate
    slope = on_surface(TWO_PI * speeds[1] * con.surfaces.radius + across * place.inverse, surface_of(con, a))
    return along * place.inverse, slope


@inlined
def slope_of_rate(con, law, kin, a, clock):
    """p'' at the end of a step, for `may_leave_inside`; 0 if there is no damper that could switch."""
    if not (law.spring.k > 0.0 and con.surfaces.damping > 0.0):
        return 0.0
    return _rate_slope(con, kin, a, (clock.speed, clock.speed_rate))


@inlined
def _along_tangents(kin, slopes, tau):
    """Linear extrapolation by a time tau of the kinematics that switches depend on; slopes = (p'', v_rel')."""
    place, motion = kin.place, kin.motion
    p, rate, slip = place.penetration + tau * motion.rate, motion.rate + tau * slopes[0], motion.slip + tau * slopes[1]
    deflection = Deflection(place.d_y, place.d_z, place.inverse, place.distance, p, place.ring_y, place.ring_z)
    return Kinematics(deflection, DeflectionRates(rate, motion.along, motion.cross, motion.tangential, slip, motion.speed))


@inlined
def may_leave_inside(con, normal, kins, slopes, h):
    """Whether a contact may leave its normal state and return within a step that starts and ends in it; slopes: p'' at both ends.

    An open contact may if the largest rate at the ends could bridge the gap; a closed one if a tangent at one end leaves the
    state before mid-step: otherwise no convex function and no cubic does. True also where only `search` can decide.
    """
    half, (kin, kin_new) = 0.5 * h, kins
    p, p_new, rate, rate_new = kin.place.penetration, kin_new.place.penetration, kin.motion.rate, kin_new.motion.rate
    if normal == OPEN:
        return max(p, p_new) + h * max(abs(rate), abs(rate_new)) > 0.0
    if normal == CLIPPED or con.surfaces.radius > 0.0:
        return True
    if con.surfaces.damping == 0.0:
        return min(p + half * rate, p_new - half * rate_new) < 0.0
    after, before = rate + half * slopes[0], rate_new - half * slopes[1]
    if normal == CLOSING:
        return min(after, before) < 0.0
    force = min(pressing(con, p + half * rate, after), pressing(con, p_new - half * rate_new, before))
    return max(after, before) > 0.0 or force < 0.0


@static
def _first_slope(slopes, method):
    """h times the accelerations at the start of an attempted step."""
    return slopes.v[1] if by_series(method) else slopes[0]


@inlined
def _hidden(con, contact, path, kins, method):
    """For each of the `switch_values`, whether it may turn negative inside a step of a closed contact that ends with it positive,
    with an error of the force larger than a switch may leave."""
    (kin, kin_new), h, clock = kins, path.h, path.clock
    end = switch_values(con, contact[0], contact[1], kin_new)
    slopes = _slopes(con, kin, (1.0 / h) * _first_slope(path.step.slopes, method), (clock.speed, clock.speed_rate))
    slopes_new = _slopes(con, kin_new, path.step.a, speeds_after(con, clock, h, path.step.v, path.step.a))
    after, before = _along_tangents(kin, slopes, 0.5 * h), _along_tangents(kin_new, slopes_new, -0.5 * h)
    a, b = switch_values(con, contact[0], contact[1], after), switch_values(con, contact[0], contact[1], before)
    first, second = end[0] >= 0.0 and min(a[0], b[0]) < 0.0, end[1] >= 0.0 and min(a[1], b[1]) < 0.0
    third = end[2] >= 0.0 and min(a[2], b[2]) < 0.0
    if first or second or third:
        # a convex function lies above its tangents, so these bound how far beyond it can be
        force = max(_wrong_force(con, contact, after), _wrong_force(con, contact, before))
        if _defect2(con, force, h, path.step.v) > con.switch_tol * con.switch_tol:
            return first, second, third
    return False, False, False


@inlined
def _extremum_between(con, path, dense, bracket, rates):
    """theta where p' changes sign, by the Illinois method on the dense output."""
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
    """(theta of the first maximum of p that lies outside the contact state, kinematics there); theta = 0 if there is none. `kin`:
    kinematics at the start.

    p' is sampled at several points: in a long step a contact may recede, touch and recede again.
    """
    before, rate_before = 0.0, kin.motion.rate
    for k in range(1, LOOKS + 1):
        theta = k / LOOKS
        rate = kinematics_inside(con, path, dense, theta)[1].motion.rate
        if rate_before > 0.0 and rate < 0.0:
            far = _extremum_between(con, path, dense, (before, theta), (rate_before, rate))
            kin_far = kinematics_inside(con, path, dense, far)[1]
            if exit_margin(con, contact[0], contact[1], kin_far) < 0.0:
                return far, kin_far
        before, rate_before = theta, rate
    return 0.0, kin


@inlined
def _values_inside(con, contact, path, dense, theta):
    return switch_values(con, contact[0], contact[1], kinematics_inside(con, path, dense, theta)[1])


@inlined
def _lowest_near(con, contact, path, dense, i, theta, values):
    """theta of a negative minimum of switch value number i near `theta`, where `values` are its values there and at the
    neighbours 1/LOOKS away; 0 if there is none. By parabolas, each a quarter as wide as the one before."""
    (before, middle, after), width = values, 1.0 / LOOKS
    for _ in range(PARABOLAS):
        bend, across = before - 2.0 * middle + after, before - after
        # the error of a parabola is below a quarter of its bend; if its vertex is outside, the minimum is elsewhere
        if not bend > 0.0 or abs(across) > 2.0 * bend or middle - 0.125 * across * across / bend > 0.25 * bend:
            return 0.0
        theta, width = theta + 0.5 * width * across / bend, 0.25 * width
        width = min(width, theta, 1.0 - theta)
        before = _values_inside(con, contact, path, dense, theta - width)[i]
        middle = _values_inside(con, contact, path, dense, theta)[i]
        after = _values_inside(con, contact, path, dense, theta + width)[i]
    return theta if middle < 0.0 else 0.0


@inlined
def _dip_inside(con, contact, path, dense, kins, hidden):
    """(theta of the first negative minimum of a switch value that may dip (`hidden`) inside a step, kinematics there); theta = 0
    if there is none."""
    before = switch_values(con, contact[0], contact[1], kins[0])
    middle = _values_inside(con, contact, path, dense, 1.0 / LOOKS)
    for k in range(1, LOOKS):
        after = _values_inside(con, contact, path, dense, (k + 1.0) / LOOKS)
        for i in range(3):
            if hidden[i]:
                theta = _lowest_near(con, contact, path, dense, i, k / LOOKS, (before[i], middle[i], after[i]))
                if theta > 0.0:
                    return theta, kinematics_inside(con, path, dense, theta)[1]
        before, middle = middle, after
    return 0.0, kins[0]


@inlined
def _root_inside(con, contact, path, dense, far, margins, g_tol):
    """theta of the switch on the dense output, by Anderson-Bjorck between 0 (margin g_near >= 0) and far (g_far < 0)."""
    g_near, g_far = margins
    near, side = 0.0, 0
    theta = far
    for _ in range(40):
        # a contact state begins on a switch, where its margin is zero: it rises before it falls
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
    """Square of the velocity error left by a force error acting for a time tau, in the error norm without rtol."""
    reach = reach_of(con) / (con.scale_v + pair_square(v))
    impulse = force * tau
    return impulse * impulse * vec.largest(reach)


@inlined
def _wrong_force(con, contact, kin):
    """Difference in N between the force in a contact state and in the state that `kin` belongs to. For a release, where it is
    zero, the spring force instead (which makes contact times and spring losses as accurate as the motion)."""
    if contact[0] == CLIPPED:
        return springs.switch(con.surfaces.spring, abs(kin.place.penetration))
    law = law_of(con, contact[0], contact[1])
    contact_true = classify(con, kin)
    law_true = law_of(con, contact_true[0], contact_true[1])
    normal, true = normal_force(law, kin), normal_force(law_true, kin)
    slip = kin.motion.slip
    across = normal * (law.mu + law.mu_slope * slip) - true * (law_true.mu + law_true.mu_slope * slip)
    return math.sqrt((normal - true) * (normal - true) + across * across)


@inlined
def _far_side(con, contact, path, dense, kins, hidden):
    """(theta of a point outside the contact state, kinematics there): end of the step or inside it; theta = 0 if none."""
    kin, kin_new = kins
    beyond = exit_margin(con, contact[0], contact[1], kin_new) < 0.0
    theta, kin_far = 0.0, kin
    # an open contact that ends closed but receding has turned round inside, and its force at the end may be clipped to zero
    if contact[0] == OPEN and (not beyond or kin_new.motion.rate < 0.0):
        theta, kin_far = _touch_inside(con, contact, path, dense, kin)
    elif hidden[0] or hidden[1] or hidden[2]:
        theta, kin_far = _dip_inside(con, contact, path, dense, kins, hidden)
    if theta == 0.0 and beyond:
        return 1.0, kin_new
    return theta, kin_far


@inlined
def _time_beyond(value, slope):
    """Longest time that a quantity, negative at the end of a step with the given slope, may have been negative."""
    if value >= 0.0:
        return 0.0
    # a parabola that was zero before has its root at most twice as far away as its tangent
    return 2.0 * value / slope if slope < 0.0 else math.inf


@inlined
def _longest_tau(con, contact, path, kin):
    """Upper bound of the time since the switch at the end of a step outside its contact state, from its slopes; inf if
    unknown."""
    if contact[0] == CLIPPED or con.surfaces.radius > 0.0:
        return math.inf
    p, rate = kin.place.penetration, kin.motion.rate
    if contact[0] == OPEN:
        return _time_beyond(-p, -rate)
    speeds = speeds_after(con, path.clock, path.h, path.step.v, path.step.a)
    slope = _rate_slope(con, kin, path.step.a, speeds)
    if contact[0] == CLOSING:
        tau = _time_beyond(p, rate)
        return tau if con.surfaces.damping == 0.0 else max(tau, _time_beyond(rate, slope))
    force = _time_beyond(pressing(con, p, rate), pressing_slope(con, p, rate, slope))
    return max(_time_beyond(-rate, -slope), force)


@compiled
def _shorter(con, contact, path, dense, beyond, g_near):
    """Length of a step that ends just beyond the switch that precedes beyond = (theta, kinematics) outside the contact state; 0
    if the error is so small that the step need not be repeated."""
    aligned_stack()
    (theta_far, kin_far), h = beyond, path.h
    g_far = exit_margin(con, contact[0], contact[1], kin_far)
    # mean force of a linear rise to the end, or a generous one for a rise and fall around an extremum
    force = (0.5 if theta_far == 1.0 else 2.0) * _wrong_force(con, contact, kin_far)
    # a thousandth of the smallest fraction of the time beyond the switch that the new step may end after it
    g_tol = 1e-3 * abs(g_far) * math.sqrt(min(0.1 * con.switch_tol / math.sqrt(_defect2(con, force, h, path.step.v)), 0.01))
    theta = _root_inside(con, contact, path, dense, theta_far, (g_near, g_far), g_tol)
    tau = (theta_far - theta) * h
    defect2 = _defect2(con, force, tau, path.step.v)
    if defect2 <= con.switch_tol * con.switch_tol:
        return 0.0
    overshoot = 0.1 * tau
    if theta_far == 1.0:
        # aim a tenth of the allowed time beyond the switch, so that rounding does not leave the new step short of it
        overshoot = min(tau * math.sqrt(0.1 * con.switch_tol / math.sqrt(defect2)), overshoot)
    h_new = theta * h + max(overshoot, 16.0 * EPS * (path.clock.hi + h))
    return h_new if h_new < h else 0.0


@compiled
def search(con, contact, path, kins, method):
    """Length for repeating an attempted step that left its contact state or may have; 0 to accept the step."""
    aligned_stack()
    kin, kin_new = kins
    beyond, met, hidden = exit_margin(con, contact[0], contact[1], kin_new) < 0.0, False, (False, False, False)
    if beyond:
        # a step made to end just beyond the switch needs no second search
        tau = _longest_tau(con, contact, path, kin_new)
        met = _defect2(con, 0.5 * _wrong_force(con, contact, kin_new), tau, path.step.v) <= con.switch_tol * con.switch_tol
    if contact[0] != OPEN and not (beyond and contact[0] == CLOSING and con.surfaces.radius == 0.0):
        hidden = _hidden(con, contact, path, kins, method)
    if (met or (contact[0] != OPEN and not beyond)) and not (hidden[0] or hidden[1] or hidden[2]):
        return 0.0
    dense = dense_of(path, method)
    g_near = max(exit_margin(con, contact[0], contact[1], kin), 0.0)
    theta_far, kin_far = _far_side(con, contact, path, dense, kins, hidden)
    if theta_far == 0.0 or (met and theta_far == 1.0):
        return 0.0
    h_new = _shorter(con, contact, path, dense, (theta_far, kin_far), g_near)
    if h_new == 0.0 and beyond and not met and contact[0] != OPEN and theta_far < 1.0:
        # the hidden excursion inside may stay, but not the switch at the end
        h_new = _shorter(con, contact, path, dense, (1.0, kin_new), g_near)
    return h_new
