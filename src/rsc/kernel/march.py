"""Many steps: error control, steps that end on the switches of the contact, output between steps, statuses.

Saving, chunks and checkpoints never change a step: samples are interpolated inside accepted steps, and `Work` holds all
that the next step depends on.
"""

from typing import NamedTuple

from rsc.kernel import vec
from rsc.kernel.contact import CLIPPED, OPEN, classify, exit_margin, law_of, normal_force
from rsc.kernel.dopri5 import attempt, error_square, interpolate
from rsc.kernel.jit import entry, inlined
from rsc.kernel.model import (
    BUFFER_FULL,
    CONTACT_TIME,
    DIVERGED,
    E_CONTACT,
    E_DRIVE,
    E_FRICTION,
    FINISHED,
    FRICTION,
    NON_FINITE,
    NORMAL,
    ONSETS,
    PHASE,
    REJECTED,
    RELEASES,
    RHS_CALLS,
    RUNNING,
    SAMPLES,
    SEGMENT,
    STEP_COLLAPSED,
    STEPS,
    SWITCHES,
    T_HI,
    T_LO,
    TOO_MANY_STEPS,
    H,
    constants,
)
from rsc.kernel.rhs import accelerations, contact_kinematics, turn_ahead, turn_at

EPS = 2.220446049250313e-16
MAX_SEARCH = 16


class State(NamedTuple):
    """A point where a step starts or ends."""

    x: object
    v: object
    a: object
    powers: object
    clock: object
    turn: object
    kin: object


class Clock(NamedTuple):
    """Where the run is: time as a sum hi + lo, rotation in turns modulo one, speed in Hz."""

    hi: float
    lo: float
    phase: float
    speed: float
    speed_rate: float


class Search(NamedTuple):
    """Bracket of a switch inside a step, in step length; h = 0 when nothing is searched."""

    h: float  # next length to try
    near: float  # margin >= 0 there
    far: float
    g_near: float
    g_far: float
    tries: int


NO_SEARCH = Search(0.0, 0.0, 0.0, 0.0, 0.0, 0)


@inlined
def _clock_at(model, segment, hi, lo, phase):
    t0 = model.corner_time[segment]
    f0 = model.corner_speed[segment]
    rate = (model.corner_speed[segment + 1] - f0) / (model.corner_time[segment + 1] - t0)
    return Clock(hi, lo, phase, f0 + rate * ((hi - t0) + lo), rate)


@inlined
def _ahead(model, segment, clock, h):
    """The clock a step later; time is summed in two parts, so that a long run does not drift."""
    hi = clock.hi + h
    part = hi - clock.hi
    lo = clock.lo + ((clock.hi - (hi - part)) + (h - part))
    top = hi + lo
    phase = clock.phase + (clock.speed + 0.5 * clock.speed_rate * h) * h
    return _clock_at(model, segment, top, lo - (top - hi), phase - float(int(phase)))


@inlined
def _margin_inside(con, mode, step, base, theta):
    """(exit margin, rate of the gap) inside an attempted step; base = (x, turn, h)."""
    x0, turn, h = base
    x, v = interpolate(x0, step.x, step.stages, h, theta)
    kin = contact_kinematics(con, x, v, turn_ahead(turn, theta * h))
    return exit_margin(con, mode[0], mode[1], kin), kin.rate


@inlined
def _may_touch_inside(mode, kin, kin_new, h):
    """Could the gap close and open again inside a step that starts and ends open (or the reverse, pressed)?"""
    if mode[0] == OPEN:
        turns = kin.rate > 0.0 and kin_new.rate < 0.0
        reach = max(kin.penetration, kin_new.penetration)
        return turns and reach + h * max(kin.rate, -kin_new.rate) > 0.0
    turns = kin.rate < 0.0 and kin_new.rate > 0.0
    depth = min(kin.penetration, kin_new.penetration)
    return turns and depth - h * max(-kin.rate, kin_new.rate) < 0.0


@inlined
def _extremum_inside(con, mode, step, base, rates):
    """theta where the gap's rate changes sign inside a step, and the exit margin there (Illinois on the interpolant)."""
    a, b = 0.0, 1.0
    f_a, f_b = rates
    theta = 0.5
    margin = 1.0
    for _ in range(12):
        theta = a + (b - a) * f_a / (f_a - f_b)
        margin, rate = _margin_inside(con, mode, step, base, theta)
        if abs(rate) <= 1e-9 * (abs(rates[0]) + abs(rates[1])):
            break
        if (rate > 0.0) == (f_a > 0.0):
            a, f_a, f_b = theta, rate, 0.5 * f_b
        else:
            b, f_b, f_a = theta, rate, 0.5 * f_a
    return theta, margin


@inlined
def _root_inside(con, mode, step, base, bracket):
    """theta of the switch on the interpolant, by Illinois; bracket = (g at 0, theta far, g far), aimed just beyond the switch."""
    g_near, far, g_far = bracket
    aim = 0.5 * con.switch_tol
    near = 0.0
    g_near, g_far = g_near + aim, g_far + aim
    theta = far
    side = 0
    for _ in range(30):
        theta = near + (far - near) * g_near / (g_near - g_far)
        g, _ = _margin_inside(con, mode, step, base, theta)
        g += aim
        if abs(g) <= 0.1 * aim or far - near <= 4.0 * EPS:
            break
        if g > 0.0:
            near, g_near = theta, g
            g_far = 0.5 * g_far if side == 1 else g_far
            side = 1
        else:
            far, g_far = theta, g
            g_near = 0.5 * g_near if side == -1 else g_near
            side = -1
    return theta


@inlined
def _begin_search(con, mode, step, base, ends):
    """Where to try first; ends = (kinematics at the start, at the end, margin at the end)."""
    kin, kin_new, g_end = ends
    h = base[2]
    far, g_far = 1.0, g_end
    if g_end >= -con.switch_tol:
        if g_end < 0.0 or not _may_touch_inside(mode, kin, kin_new, h):
            return NO_SEARCH
        far, g_far = _extremum_inside(con, mode, step, base, (kin.rate, kin_new.rate))
        if g_far >= -con.switch_tol:
            return NO_SEARCH
    g_near = max(exit_margin(con, mode[0], mode[1], kin), 0.0)
    theta = _root_inside(con, mode, step, base, (g_near, far, g_far))
    return Search(theta * h, 0.0, far * h, g_near, g_far, 1)


@inlined
def _continue_search(con, search, margin):
    """Next length from the margin that the step to search.h really reached; h = 0 when that step is to be taken."""
    done = -con.switch_tol <= margin < 0.0
    if done or search.tries >= MAX_SEARCH:
        return NO_SEARCH
    near, far, g_near, g_far = search.near, search.far, search.g_near, search.g_far
    if margin >= 0.0:
        near, g_near = search.h, margin
        g_far = 0.5 * g_far if search.tries > 2 else g_far
    else:
        far, g_far = search.h, margin
        g_near = 0.5 * g_near if search.tries > 2 else g_near
    aim = 0.5 * con.switch_tol
    share = (g_near + aim) / (g_near - g_far)
    return Search(near + (far - near) * min(max(share, 0.0), 1.0), near, far, g_near, g_far, search.tries + 1)


@inlined
def _factor(error2):
    """Step-size factor from the square of the error over its tolerance; NaN shrinks."""
    if not error2 < 1e8:
        return 0.2
    return 5.0 if error2 < 1e-8 else min(5.0, max(0.2, 0.9 * error2**-0.1))


@inlined
def _save_samples(con, rate, law, out, filled, work, step, base, clocks):
    """Write every sample time inside the step; returns the rows filled."""
    x0, turn, h = base
    start, end = clocks
    k = work.count[SAMPLES]
    time = k / rate
    width = out.shape[1] - 3
    while (time - end.hi) - end.lo <= 0.0:
        theta = min(max(((time - start.hi) - start.lo) / h, 0.0), 1.0)
        x, v = interpolate(x0, step.x, step.stages, h, theta)
        kin = contact_kinematics(con, x, v, turn_ahead(turn, theta * h))
        force = max(normal_force(law, kin), 0.0)
        vec.store(out, filled * out.shape[1], x)
        out[filled, width] = force
        out[filled, width + 1] = force * (law.mu + law.mu_slope * kin.slip)
        out[filled, width + 2] = kin.tangential
        filled += 1
        k += 1
        time = k / rate
    work.count[SAMPLES] = k
    return filled


@inlined
def _book(con, work, lanes, done, mode, kins, h):
    """Add an accepted step's energies and contact time to the ledger; kins = contact kinematics at its start and end."""
    vec.store(work.ledger_damping, 0, vec.load(work.ledger_damping, 0, lanes) + done.damping)
    vec.store(work.ledger_input, 0, vec.load(work.ledger_input, 0, lanes) + done.drive)
    if mode[0] != OPEN:
        work.real[CONTACT_TIME] += h
        work.real[E_CONTACT] += done.contact
        work.real[E_FRICTION] += done.friction
        work.real[E_DRIVE] += done.ring
    if mode[0] == CLIPPED:
        # without a force the spring unloads for nothing: what it held is lost
        p_0, p_1 = kins[0].penetration, kins[1].penetration
        work.real[E_CONTACT] += 0.5 * con.k_c * (p_0 * p_0 - p_1 * p_1)


@inlined
def _change_mode(work, mode, mode_new):
    count = work.count
    count[SWITCHES] += 1
    count[ONSETS] += mode[0] == OPEN and mode_new[0] != OPEN
    count[RELEASES] += mode[0] != OPEN and mode_new[0] == OPEN
    count[NORMAL], count[FRICTION] = mode_new


@inlined
def _put_away(work, now, h):
    vec.store(work.x, 0, now.x)
    vec.store(work.v, 0, now.v)
    work.real[T_HI], work.real[T_LO], work.real[PHASE] = now.clock.hi, now.clock.lo, now.clock.phase
    work.real[H] = h


@inlined
def _state(con, columns, law, x, v, clock):
    """The full state where a step may start: accelerations, rotation and contact kinematics included."""
    turn = turn_at(clock.phase, clock.speed, clock.speed_rate)
    a, powers = accelerations(con, columns, law, x, v, turn)
    return State(x, v, a, powers, clock, turn, contact_kinematics(con, x, v, turn))


@inlined
def _try_step(model, con, columns, law, segment, now, length):
    """Attempt a step; length = (h, whether it ends on the corner of the schedule). Returns (State at its end, Step)."""
    h, at_corner = length
    clock = _ahead(model, segment, now.clock, h)
    if at_corner:
        clock = _clock_at(model, segment, model.corner_time[segment + 1], 0.0, clock.phase)
    turn = turn_at(clock.phase, clock.speed, clock.speed_rate)
    step, a, powers = attempt(con, columns, law, (now.x, now.v, now.a, now.powers), (now.turn, turn), h)
    kin = contact_kinematics(con, step.x, step.v, turn)
    return State(step.x, step.v, a, powers, clock, turn, kin), step


@inlined
def _stop_before(model, count, spent, budget, rows_needed, rows):
    """Reason not to attempt another step now, or -1."""
    if count[STEPS] >= model.max_steps:
        return TOO_MANY_STEPS
    if spent >= budget:
        return RUNNING
    return BUFFER_FULL if rows_needed > rows else -1


@inlined
def _next_corner(count, corners):
    """Enter the next segment of the schedule; True when there is none."""
    if count[SEGMENT] == corners - 2:
        return True
    count[SEGMENT] += 1
    return False


@inlined
def _after_step(model, con, columns, work, now, law, flags):
    """State and law to go on with after an accepted step; flags = (switched, at a corner). FSAL ends where the field has a kink."""
    switched, at_corner = flags
    count = work.count
    if not (switched or at_corner):
        return now, law
    if switched:
        mode = classify(con, now.kin)
        _change_mode(work, (count[NORMAL], count[FRICTION]), mode)
        law = law_of(con, mode[0], mode[1])
    count[RHS_CALLS] += 1
    clock = _clock_at(model, count[SEGMENT], now.clock.hi, now.clock.lo, now.clock.phase)
    return _state(con, columns, law, now.x, now.v, clock), law


@inlined
def _resume(model, con, columns, work, x, v):
    """State and law where the last call ended; a run that has not begun (normal mode -1) is classified by its state."""
    real, count = work.real, work.count
    clock = _clock_at(model, count[SEGMENT], real[T_HI], real[T_LO], real[PHASE])
    if count[NORMAL] < 0:
        turn = turn_at(clock.phase, clock.speed, clock.speed_rate)
        count[NORMAL], count[FRICTION] = classify(con, contact_kinematics(con, x, v, turn))
    law = law_of(con, count[NORMAL], count[FRICTION])
    return _state(con, columns, law, x, v, clock), law


@entry
def march(model, work, out, lanes, budget):
    """Advance `work` by at most `budget` attempted steps, writing samples into `out`.

    Parameters: Model, Work, out (rows, 2n + 3) for x, normal force N, friction force N, tangential velocity m/s; lanes, a tuple of
    2n floats that carries the width. Returns (code, rows filled).
    """
    con = constants(model, lanes)
    columns = (model.damping_columns, model.gyroscopic_columns)
    count = work.count
    now, law = _resume(model, con, columns, work, vec.load(work.x, 0, lanes), vec.load(work.v, 0, lanes))
    search, at_corner, finite = NO_SEARCH, False, True
    h = work.real[H]
    h_next, filled, spent = h, 0, 0
    while True:
        segment = count[SEGMENT]
        h_try = search.h
        if not search.h > 0.0:
            left = (model.corner_time[segment + 1] - now.clock.hi) - now.clock.lo
            at_corner = h >= left
            h_try = left if at_corner else h
            code = _stop_before(model, count, spent, budget, filled + h_try * model.sample_rate + 2.0, out.shape[0])
            if not h >= max(10.0 * EPS * now.clock.hi, 1e-290):  # written so that a NaN ends the run as well
                code = STEP_COLLAPSED if finite else NON_FINITE
            if code >= 0:
                break
        spent += 1
        new, step = _try_step(model, con, columns, law, segment, now, (h_try, at_corner))
        count[RHS_CALLS] += 6
        error2 = error_square(con, now.x, step.stages, h_try)
        if not error2 <= 1.0:
            count[REJECTED] += 1
            search, at_corner = NO_SEARCH, False
            h = h_try * min(_factor(error2), 0.9)
            finite = error2 < 1e300
            continue
        finite = True
        mode = (count[NORMAL], count[FRICTION])
        margin = exit_margin(con, mode[0], mode[1], new.kin)
        base = (now.x, now.turn, h_try)
        if search.h > 0.0:
            search = _continue_search(con, search, margin)
        else:
            h_next = min(h_try * _factor(error2), model.h_max)
            h_next = max(h, h_next) if at_corner else h_next
            search = _begin_search(con, mode, step, base, (now.kin, new.kin, margin))
        if search.h > 0.0:
            at_corner = False
            continue
        filled = _save_samples(con, model.sample_rate, law, out, filled, work, step, base, (now.clock, new.clock))
        _book(con, work, lanes, step.work, mode, (now.kin, new.kin), h_try)
        count[STEPS] += 1
        now, h = new, h_next
        if at_corner and _next_corner(count, model.corner_time.shape[0]):
            code = FINISHED
            break
        now, law = _after_step(model, con, columns, work, now, law, (margin < 0.0, at_corner))
        if not vec.largest(now.x * now.x) <= model.divergence * model.divergence:
            code = DIVERGED
            break
    _put_away(work, now, h)
    return code, filled
