"""Many steps: error control, steps that end on the switches of the contact, output between steps, statuses.

Saving, chunks and checkpoints never change a step: samples are interpolated inside accepted steps, and `Work` holds all
that the next step depends on. While marching all of it is in local values (`Tally`, `Mode`, `State`); the arrays of `Work` are
read once and written once, because Numba counts a reference wherever an array is handed to a helper.
"""

from typing import NamedTuple

from rsc.kernel import vec
from rsc.kernel.clock import ahead, clock_at, contact_turn, segment_of, turn_of
from rsc.kernel.contact import Kinematics, classify, law_of, stays
from rsc.kernel.control import factor
from rsc.kernel.dopri5 import attempt, error_square, size_square, stage_turns
from rsc.kernel.jit import entry, inlined
from rsc.kernel.model import (
    BUFFER_FULL,
    DIVERGED,
    FINISHED,
    FRICTION,
    H_OTHER,
    LOG_ERROR,
    NON_FINITE,
    NORMAL,
    PHASE,
    RUNNING,
    SAMPLES,
    SEGMENT,
    STEP_COLLAPSED,
    T_HI,
    T_LO,
    TOO_MANY_STEPS,
    H,
    constants,
)
from rsc.kernel.rhs import accelerations, contact_kinematics, field
from rsc.kernel.switches import EPS, Path, may_touch_inside, search
from rsc.kernel.tally import book, count_rejected, count_switch, load_tally, save_samples, store_tally

MAX_SEARCH = 16


class State(NamedTuple):
    """A point where a step starts or ends."""

    x: object
    v: object
    a: object
    powers: object
    clock: object
    kin: Kinematics


class Mode(NamedTuple):
    """The contact's mode and its force."""

    normal: int
    friction: int
    law: object


class Pace(NamedTuple):
    """Step-size control between steps."""

    h: float  # s, next step
    h_other: float  # s, the step length that contact (in free flight) or free flight (in contact) had last
    log_error: float  # of the last step, for the controller


@inlined
def _mode_of(con, normal, friction):
    return Mode(normal, friction, law_of(con, normal, friction))


@inlined
def _state(con, law, x, v, clock):
    """The full state where a step may start: accelerations and contact kinematics included."""
    turn = turn_of(clock)
    a, powers, _ = accelerations(con, field(con, law, 1.0), x, v, turn)
    return State(x, v, a, powers, clock, contact_kinematics(con, x, v, turn))


@inlined
def _try_step(con, law, segment, now, h):
    """Attempt a step that ends at the latest at the segment's end. Returns (State at its end, Step)."""
    clock = ahead(segment, now.clock, h)
    if h >= (segment.end - now.clock.hi) - now.clock.lo:
        clock = clock_at(segment, segment.end, 0.0, clock.phase)
    turns = stage_turns(now.clock, clock, h)
    step = attempt(con, law, (now.x, now.v, now.a, now.powers), turns, h)
    kin = step.kin
    if not law.k > 0.0:
        kin = contact_kinematics(con, step.x, step.v, contact_turn(con, clock, 0.0))
    return State(step.x, step.v, step.a, step.powers, clock, kin), step


@inlined
def _change_mode(con, kin, mode, pace):
    """(Mode, Pace) after a switch; contact and free flight each resume the step length they last had."""
    normal, friction = classify(con, kin)
    if (mode.normal == 0) != (normal == 0):
        pace = Pace(pace.h_other, pace.h, pace.log_error)
    return _mode_of(con, normal, friction), pace


@inlined
def _stop_before(con, steps, now, h, finite):
    """Reason not to attempt another step from here, or -1."""
    if not h >= max(10.0 * EPS * now.clock.hi, 1e-290):  # written so that a NaN ends the run as well
        return STEP_COLLAPSED if finite else NON_FINITE
    return TOO_MANY_STEPS if steps >= con.max_steps else -1


@inlined
def _resume(model, con, work, lanes):
    """(State, Mode) where the last call ended; a run that has not begun (normal mode -1) is classified by its state."""
    real, count = work.real, work.count
    x, v = vec.load(work.x, lanes), vec.load(work.v, lanes)
    clock = clock_at(segment_of(model, count[SEGMENT]), real[T_HI], real[T_LO], real[PHASE])
    if count[NORMAL] < 0:
        count[NORMAL], count[FRICTION] = classify(con, contact_kinematics(con, x, v, turn_of(clock)))
    mode = _mode_of(con, count[NORMAL], count[FRICTION])
    return _state(con, mode.law, x, v, clock), mode


@inlined
def _put_away(work, now, mode, pace):
    vec.store(work.x, now.x)
    vec.store(work.v, now.v)
    real, count = work.real, work.count
    real[T_HI], real[T_LO], real[PHASE] = now.clock.hi, now.clock.lo, now.clock.phase
    real[H], real[H_OTHER], real[LOG_ERROR] = pace.h, pace.h_other, pace.log_error
    count[NORMAL], count[FRICTION] = mode.normal, mode.friction


@entry
def march(model, work, out, lanes, budget):
    """Advance `work` by at most `budget` attempted steps, writing samples into `out`.

    Parameters: Model, Work, out (rows, 2n + 3) for x, normal force N, friction force N, tangential velocity m/s; lanes, a tuple
    of 2n floats that carries the width. Returns (code, rows filled).
    """
    con = constants(model, lanes)
    now, mode = _resume(model, con, work, lanes)
    i_segment, corners = work.count[SEGMENT], model.corner_time.shape[0]
    segment = segment_of(model, i_segment)
    pace = Pace(work.real[H], work.real[H_OTHER], work.real[LOG_ERROR])
    tally = load_tally(work, lanes)
    rows, base = out.shape[0], vec.address(out)
    sample = work.count[SAMPLES]
    sample_time, first = sample / con.sample_rate, sample
    h_next, log_next, h_search = pace.h, pace.log_error, 0.0
    spent, tries, finite = 0, 0, True
    while True:
        left = (segment.end - now.clock.hi) - now.clock.lo
        h_try = h_search
        if not h_search > 0.0:
            h_try = min(pace.h, left)
            code = _stop_before(con, tally.steps, now, pace.h, finite)
            if code < 0 and spent >= budget:
                code = RUNNING
            if code < 0 and (sample - first) + h_try * con.sample_rate + 2.0 > rows:
                code = BUFFER_FULL
            if code >= 0:
                break
        spent += 1
        new, step = _try_step(con, mode.law, segment, now, h_try)
        error2 = error_square(con, now.x, now.v, step.stages)
        if not error2 <= 1.0:
            tally = count_rejected(tally)
            h_search, tries = 0.0, 0
            pace = Pace(h_try * min(factor(error2, 0.0)[0], 0.9), pace.h_other, pace.log_error)
            finite = error2 < 1e300
            continue
        finite = True
        path = Path(step, now.clock, h_try)
        if not h_search > 0.0:
            scale, log_next = factor(error2, pace.log_error)
            h_next = min(h_try * scale, con.h_max)
            h_next = max(pace.h, h_next) if h_try < pace.h else h_next
        inside = stays(con, mode.normal, mode.friction, new.kin)
        h_search = 0.0
        if (not inside or may_touch_inside(mode.normal, now.kin, new.kin, h_try)) and tries < MAX_SEARCH:
            h_search = search(con, (mode.normal, mode.friction), path, now.kin, new.kin)
            tries += 1
            if h_search > 0.0:
                continue
        tries = 0
        if (sample_time - new.clock.hi) - new.clock.lo <= 0.0:
            sample = save_samples(con, mode.law, (base, first), sample, path, new.clock)
            sample_time = sample / con.sample_rate
        tally = book(con, tally, step.work, mode.normal, (now.kin, new.kin), h_try)
        now, pace = new, Pace(h_next, pace.h_other, log_next)
        at_corner = h_try >= left
        if at_corner:
            if i_segment == corners - 2:
                code = FINISHED
                break
            i_segment += 1
            segment = segment_of(model, i_segment)
        if not inside:
            normal_before = mode.normal
            mode, pace = _change_mode(con, now.kin, mode, pace)
            tally = count_switch(tally, normal_before, mode.normal)
        if at_corner or not inside:
            clock = clock_at(segment, now.clock.hi, now.clock.lo, now.clock.phase)
            now = _state(con, mode.law, now.x, now.v, clock)
        if not size_square(now.x) <= con.divergence2:
            code = DIVERGED
            break
    _put_away(work, now, mode, pace)
    store_tally(work, tally, spent)
    work.count[SAMPLES], work.count[SEGMENT] = sample, i_segment
    return code, sample - first
