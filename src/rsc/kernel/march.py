"""Many steps: error control, steps that end on the switches of the contact, output between steps, statuses.

Saving, chunks and checkpoints never change a step: samples are interpolated inside accepted steps, and `Work` holds all
that the next step depends on. While marching all of it is in local values (`Tally`, `Contact`, `State`); the arrays of `Work` are
read once and written once, because Numba counts a reference wherever an array is handed to a helper.
"""

from typing import NamedTuple

from rsc.kernel.clock import at_start, clock_in, corners_of, planned, segment_of, settled, turn_of
from rsc.kernel.contact import CLOSING, OPENING, Kinematics, classify, law_of, stays
from rsc.kernel.control import factor, kept_between
from rsc.kernel.drive import stands, until_knot
from rsc.kernel.facts import add_step, mark, stretch_of
from rsc.kernel.model import (
    BUFFER_FULL,
    DIVERGED,
    FINISHED,
    FRICTION,
    NON_FINITE,
    NORMAL,
    PHASE,
    RUNNING,
    SAMPLES,
    SEGMENT,
    STEP_COLLAPSED,
    STOPPED,
    T_HI,
    T_LO,
    TOO_MANY_STEPS,
    TOO_STIFF,
    H,
    constants,
)
from rsc.kernel.rhs import accelerations, contact_kinematics, field_itself, no_powers
from rsc.kernel.simd import vec
from rsc.kernel.simd.hints import aligned_stack
from rsc.kernel.simd.jit import entry, inlined
from rsc.kernel.step import attempt, error_square, size_square
from rsc.kernel.switches import EPS, Path, may_leave_inside, search, slope_of_rate
from rsc.kernel.tally import (
    Output,
    book,
    count_rejected,
    count_switch,
    end_window,
    load_tally,
    save_samples,
    store_tally,
)

MAX_SEARCH = 16
# stiffness is looked for every WINDOW steps: MANY of them above NEAR of the limit of stability, where such steps mostly stand,
# though the motion needs LOSS times fewer; it is found at most WINDOW + MANY steps after it began
WINDOW, MANY, NEAR, LOSS = 512, 256, 0.4, 10.0


class State(NamedTuple):
    """A point where a step starts or ends."""

    x: object
    v: object
    a: object
    powers: object
    clock: object
    kin: Kinematics
    rate_slope: float  # p'', see `switches.slope_of_rate`


class Contact(NamedTuple):
    """The contact's state and its force."""

    normal: int
    friction: int
    law: object
    near_limit: float  # s, length of a step that is near the limit of stability


class Progress(NamedTuple):
    """Where a run is between two steps."""

    start: State
    contact: Contact
    h: float  # s, length of the next step
    tally: object
    segment: object
    i_segment: int
    sample: int  # the next one
    finite: bool  # whether the last attempt was


@inlined
def contact_of(con, normal, friction):
    """The Contact in states that are told."""
    stable = con.stable_open
    if normal == CLOSING:
        stable = con.stable_closing
    elif normal == OPENING:
        stable = con.stable_opening
    return Contact(normal, friction, law_of(con, normal, friction), NEAR * stable)


@inlined
def state_at(con, law, segment, x, v, clock):
    """The full state where a step may start: accelerations and contact kinematics included."""
    turn = turn_of(clock)
    kin, d_dot = contact_kinematics(con, x, v, turn), vec.product(con.contact_row, v)
    a, powers = accelerations(con, field_itself(con, law, clock), (x, v, d_dot), turn, kin.place, 1.0, no_powers(con))
    clock = settled(con, segment, clock, a)
    return State(x, v, a, powers, clock, kin, slope_of_rate(con, law, kin, a, clock))


@inlined
def _try_step(con, law, segment, start, before, h, method):
    """Attempt a step of length h that ends at the latest at the segment's end; `before` is the work up to its start. Returns
    (State at its end, Step)."""
    step = attempt(con, law, start, before, planned(con, segment, start.clock, h), h, method)
    end, x = settled(con, segment, step.clock, step.a), at_start(con, step.x)
    return State(x, step.v, step.a, step.powers, end, step.kin, slope_of_rate(con, law, step.kin, step.a, end)), step


@inlined
def _stop_before(start, h, finite, left):
    """Reason not to attempt another step from here, or -1; left = (steps, attempts, rows of output) that may still be made."""
    if not h >= max(10.0 * EPS * start.clock.hi, 1e-290):  # written so that a NaN ends the run as well
        return STEP_COLLAPSED if finite else NON_FINITE
    steps, attempts, rows_left = left
    if steps <= 0:
        return TOO_MANY_STEPS
    if attempts <= 0:
        return RUNNING
    return BUFFER_FULL if rows_left < 0.0 else -1


@inlined
def _next_length(con, h, h_try, error2, method):
    """Length of the step after an attempt that was not too long, made in place of one of length h."""
    # a length that is about right is kept: the branch lets the processor begin the next step before the error is known
    least, most = kept_between(method)
    if least < error2 < most and h_try == h:
        return h
    h_next = min(h_try * factor(error2, method), con.h_max)
    # a step cut at a corner of the schedule says nothing against the length it was cut from
    return max(h, h_next) if h_try < h else h_next


@inlined
def check_switch(con, contact, path, start, new, tries, method):
    """(whether the step ends in its contact state, length to try instead or 0), also of a step that leaves the interval of its
    drive's torque."""
    kins = start.kin, new.kin
    inside = stays(con, contact.normal, contact.friction, new.kin)
    if tries >= MAX_SEARCH or (inside and not may_leave_inside(con, contact, start, new, path.h)):
        return inside, until_knot(con, path, tries)
    h = search(con, (contact.normal, contact.friction), path, kins, method)
    return inside, h if h > 0.0 else until_knot(con, path, tries)


@inlined
def _is_stiff(con, tally, contact, start):
    """Whether most steps of the window just ended are near the limit of stability, and far shorter than the motion needs."""
    if tally.limited < MANY:
        return False
    # stiff is not what is fast but what is fast and idle: steps this short where the motion itself would bear longer ones
    rate2 = size_square(start.v) / size_square(start.x)  # of the motion as a whole, 1/s^2; NaN at rest
    needed = LOSS / NEAR * contact.near_limit
    return con.h_max >= needed and con.resolved_angle * con.resolved_angle >= needed * needed * rate2


@inlined
def _judge(con, tally, contact, start, end):
    """(tally, reason not to go on from an accepted step, or -1); end of the run in s."""
    code = -1 if size_square(start.x) <= con.divergence2 else DIVERGED
    if code < 0 and stands(con, start.v):
        code = STOPPED
    if tally.steps % WINDOW != 0:
        return tally, code
    stiff = tally.stiff
    if code < 0 and stiff == 0 and _is_stiff(con, tally, contact, start):
        stiff = 1 + contact.normal
        # steps at the limit of stability cannot reach the end
        if tally.steps + (end - start.clock.hi) * NEAR / contact.near_limit > con.max_steps:
            code = TOO_STIFF
    return end_window(tally, stiff), code


@inlined
def enter(con, segment, start, contact):
    """(State, Contact) after a switch or a corner of the schedule, where the field has a kink and nothing can be reused."""
    normal, friction = classify(con, start.kin)
    contact = contact_of(con, normal, friction)
    clock = clock_in(con, segment, start.clock.hi, start.clock.lo, start.clock.phase, start.v)
    return state_at(con, contact.law, segment, start.x, start.v, clock), contact


@inlined
def _resume(model, con, work, width):
    """(State, Contact) where the last call ended; a run that has not begun (normal state -1) is classified by its state."""
    real, count = work.real, work.count
    x, v = vec.load(work.x, width), vec.load(work.v, width)
    segment = segment_of(corners_of(model), count[SEGMENT])
    clock = clock_in(con, segment, real[T_HI], real[T_LO], real[PHASE], v)
    if count[NORMAL] < 0:
        count[NORMAL], count[FRICTION] = classify(con, contact_kinematics(con, x, v, turn_of(clock)))
    contact = contact_of(con, count[NORMAL], count[FRICTION])
    return state_at(con, contact.law, segment, x, v, clock), contact


@inlined
def _put_away(work, start, contact, h):
    vec.store(work.x, start.x)
    vec.store(work.v, start.v)
    real, count = work.real, work.count
    real[T_HI], real[T_LO], real[PHASE], real[H] = start.clock.hi, start.clock.lo, start.clock.phase, h
    count[NORMAL], count[FRICTION] = contact.normal, contact.friction


@inlined
def walk(con, corners, where, stretch, progress, method, budget):
    """Attempt at most `budget` steps, and as many more as the search of a switch takes.

    where = the Output, stretch = the Stretch. Returns (code, calls made by steps, Progress).
    """
    start, contact, h, tally, segment, i_segment, sample, finite = progress
    sample_time, end = sample / con.sample_rate, vec.number_at(corners.time, corners.count - 1)
    h_next, h_search, tries, spent = h, 0.0, 0, 0
    while True:
        left = (segment.end - start.clock.hi) - start.clock.lo
        h_try = h_search if h_search > 0.0 else min(h, left)
        if not h_search > 0.0:
            rows_left = where.rows - (sample - where.first) - h_try * con.sample_rate - 2.0
            code = _stop_before(start, h, finite, (con.max_steps - tally.steps, budget - spent, rows_left))
            if code >= 0:
                break
        spent += 1
        new, step = _try_step(con, contact.law, segment, start, tally.work, h_try, method)
        error2 = error_square(con, step, h_try, method)
        finite = error2 < 1e300
        if not error2 <= 1.0:  # a NaN is rejected as well
            tally = count_rejected(tally)
            h, h_search, tries = h_try * min(factor(error2, method), 0.9), 0.0, 0
            continue
        # a step cut short to end on a switch says nothing about the length that accuracy allows
        if not h_search > 0.0:
            h_next = _next_length(con, h, h_try, error2, method)
        path = Path(step, start.clock, h_try)
        inside, h_search = check_switch(con, contact, path, start, new, tries, method)
        if h_search > 0.0:
            tries += 1
            continue
        tries = 0
        if (sample_time - new.clock.hi) - new.clock.lo <= 0.0:
            sample = save_samples(con, contact.law, where, sample, path, new.clock, method)
            sample_time = sample / con.sample_rate
        fed = step.work.friction - tally.work.friction
        tally = book(con, tally, step.work, contact, (start.kin, new.kin), h_try)
        add_step(con, stretch, tally, contact, start, new, fed, h_try)
        start, h = new, h_next
        if h_try >= left:
            if i_segment == corners.count - 2:
                code = FINISHED
                break
            i_segment += 1
            segment = segment_of(corners, i_segment)
        # beyond a switch or a corner the field is another: the slope at the step's end cannot begin the next
        if h_try >= left or not inside:
            normal = contact.normal
            start, contact = enter(con, segment, start, contact)
            tally = count_switch(tally, inside, normal, contact.normal)
        tally, code = _judge(con, tally, contact, start, end)
        if code >= 0:
            break
    return code, len(method) * spent, Progress(start, contact, h, tally, segment, i_segment, sample, finite)


@entry
def march(model, work, out, rows, width, method, budget):
    """Advance `work` by at most `budget` attempted steps, writing samples into `out` and finished stretches into `rows`.

    Parameters: Model, Work, out (rows, 2n + 3) for x, normal force N, friction force N, tangential velocity m/s, or (rows,
    4n + 3) with v behind x; rows (n_stretches, facts.N_ROW); width, a tuple of 2n floats that carries the width; method, a
    tuple that carries the method (`tableau.METHODS`). Returns (code, rows filled).
    """
    aligned_stack()
    con = constants(model, width)
    start, contact = _resume(model, con, work, width)
    i_segment, first = work.count[SEGMENT], work.count[SAMPLES]
    corners = corners_of(model)
    tally, segment = load_tally(con, work, width), segment_of(corners, i_segment)
    progress = Progress(start, contact, work.real[H], tally, segment, i_segment, first, True)
    where = Output(vec.address(out), out.shape[1], out.shape[1] - 3 - len(width), first, out.shape[0])
    stretch = stretch_of(model, work, rows)
    code, calls, progress = walk(con, corners, where, stretch, progress, method, budget)
    mark(stretch, progress.tally, progress.start)
    _put_away(work, progress.start, progress.contact, progress.h)
    store_tally(work, progress.tally, calls)
    work.count[SAMPLES], work.count[SEGMENT] = progress.sample, progress.i_segment
    return code, progress.sample - first
