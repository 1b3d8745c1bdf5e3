"""The loop over steps: error control, ending steps on contact switches, output between steps, status.

Saving, chunks and checkpoints never change a step: samples are interpolated inside accepted steps, and `Work` holds all that the
next step depends on. Inside the loop all of it is in local values (`Tally`, `ContactState`, `State`); the arrays of `Work` are
read and written once, because Numba counts references wherever an array is passed to a helper.
"""

from rsc.kernel.clock import Segment, at_start, corners_of, passed_knot, planned, segment_of, settled
from rsc.kernel.contact import OPEN, stays
from rsc.kernel.control import factor, kept_between
from rsc.kernel.drive import until_knot
from rsc.kernel.ends import judge, stop_before
from rsc.kernel.facts import add_steps, mark_all, stretches_of
from rsc.kernel.flight import TAKE_OFF, Records, after_step, fly, is_ready, next_time
from rsc.kernel.model import FINISHED, FLIGHT, SAMPLES, SEGMENT, H, constants
from rsc.kernel.progress import Progress, State, enter, laws_of, put_away, rate_slopes, resume, state_at
from rsc.kernel.questions import flies, is_none
from rsc.kernel.simd import vec
from rsc.kernel.simd.hints import aligned_stack, room_for_addresses
from rsc.kernel.simd.jit import entry, inlined
from rsc.kernel.simd.static import static
from rsc.kernel.step import attempt, error_square
from rsc.kernel.switches import Path, may_leave_inside, search
from rsc.kernel.tally import SampleRows, book, count_rejected, count_switch, load_tally, save_samples, store_tally

MAX_SEARCH = 16


@inlined
def _try_step(con, laws, segment, start, before, h, method):
    """Attempt a step of length h, cut off at the end of the segment; `before` is the work up to its start. Returns (State at its
    end, Step)."""
    step = attempt(con, laws, start, before, planned(con, segment, start.clock, h), h, method)
    end, x = settled(con, segment, step.clock, step.a), at_start(con, step.x)
    slopes = rate_slopes(con.contacts, laws, step.kins, step.a, end)
    return State(x, step.v, step.a, step.powers, end, step.kins, slopes), step


@inlined
def _next_length(con, h, h_try, error2, method):
    """Length of the next step after an accepted attempt of length h_try, made instead of one of length h."""
    # a length that is about right is kept: the branch lets the processor start the next step before the error is known
    least, most = kept_between(method)
    if least < error2 < most and h_try == h:
        return h
    h_next = min(h_try * factor(error2, method), con.h_max)
    # a step cut at a corner of the schedule is no reason to reduce the original length
    return max(h, h_next) if h_try < h else h_next


@inlined
def check_step(con, contacts, path, states, tries, method):
    """(whether a step ends in the contact states it started in, length to try instead or 0), also for leaving the torque interval
    of a drive; states: at its start and end."""
    start, new = states
    kins, slopes = (start.kins, new.kins), (start.rate_slopes, new.rate_slopes)
    inside, h = check_switches(con.contacts, contacts.each, path, kins, slopes, tries, method)
    return inside, h if h > 0.0 else until_knot(con, path, tries)


@static
def check_switches(con, each, path, kins, slopes, tries, method):
    """(whether all contacts end in their states, length to try instead or 0): the shortest that any contact requires.

    con: ContactConstants of `each`; kins = (at the start, at the end), slopes = p'' likewise; tuples over contacts.
    """
    if is_none(each):
        return True, 0.0
    ends = (kins[0][0], kins[1][0]), (slopes[0][0], slopes[1][0])
    inside, h = _check_switch(con[0], each[0], path, *ends, tries, method)
    remaining = (kins[0][1:], kins[1][1:]), (slopes[0][1:], slopes[1][1:])
    others, h_others = check_switches(con[1:], each[1:], path, *remaining, tries, method)
    return inside and others, _shortest(h, h_others)


@inlined
def _shortest(h, other):
    """The shorter of two lengths, where 0 means no requirement."""
    return min(h, other) if h > 0.0 and other > 0.0 else max(h, other)


@inlined
def _check_switch(con, contact, path, kins, slopes, tries, method):
    inside = stays(con, contact.normal, contact.friction, kins[1])
    if tries >= MAX_SEARCH or (inside and not may_leave_inside(con, contact.normal, kins, slopes, path.h)):
        return inside, 0.0
    return inside, search(con, (contact.normal, contact.friction), path, kins, method)


@static
def _flight_in(con, work):
    """See `Progress.flight`."""
    return work.real[FLIGHT] if flies(con) else ()


@static
def _put_flight_away(work, flight):
    if is_none(flight):
        return
    work.real[FLIGHT] = flight


@static
def _all_open(each):
    """Whether no contact is touched."""
    return True if is_none(each) else each[0].normal == OPEN and _all_open(each[1:])


@static
def _stage(con, segment, contacts, flight, clock):
    """The part of a segment that the next step may reach: where a scene flies and nothing touches it ends where a flight may
    begin."""
    if not flies(con):
        return segment
    end = segment.end
    if _all_open(contacts.each):
        end = min(end, next_time(con, flight, clock))
    return Segment(segment.begin, end, segment.speed, segment.speed_rate, segment.following, segment.torque, segment.states)


@static
def _is_corner(con, stage, segment):
    """Whether the end of a `_stage` is a corner of the schedule."""
    return stage.end == segment.end if flies(con) else True


@static
def _or_fly(con, code, flight, contacts, clock):
    """Reason not to attempt a step from here: `code`, or that a flight may begin."""
    if not flies(con):
        return code
    return TAKE_OFF if code < 0 and _all_open(contacts.each) and is_ready(con, flight, clock) else code


@inlined
def walk(con, corners, where, stretch, progress, method, budget):
    """Attempt at most `budget` steps, plus those that locating a switch takes.

    where: SampleRows; stretch: Stretch of each contact. Returns (code, calls of the right-hand side made by steps, Progress).
    """
    start, contacts, h, tally, segment, i_segment, sample, finite, flight = progress
    sample_time, end = sample / con.sample_rate, vec.number_at(corners.time, corners.count - 1)
    h_next, h_search, tries, spent = h, 0.0, 0, 0
    while True:
        stage = _stage(con, segment, contacts, flight, start.clock)
        left = (stage.end - start.clock.hi) - start.clock.lo
        h_try = h_search if h_search > 0.0 else min(h, left)
        if not h_search > 0.0:
            rows_left = where.rows - (sample - where.first) - h_try * con.sample_rate - 2.0
            code = stop_before(start, h, finite, (con.max_steps - tally.steps, budget - spent, rows_left))
            code = _or_fly(con, code, flight, contacts, start.clock)
            if code >= 0:
                break
        spent += 1
        new, step = _try_step(con, laws_of(contacts.each), stage, start, tally.work, h_try, method)
        error2 = error_square(con, step, h_try, method)
        finite = error2 < 1e300
        if not error2 <= 1.0:  # NaN is rejected, too
            tally = count_rejected(tally)
            h, h_search, tries = h_try * min(factor(error2, method), 0.9), 0.0, 0
            continue
        # a step cut short to end on a switch says nothing about the length that accuracy allows
        if not h_search > 0.0:
            h_next = _next_length(con, h, h_try, error2, method)
        path = Path(step, start.clock, h_try)
        inside, h_search = check_step(con, contacts, path, (start, new), tries, method)
        if h_search > 0.0:
            tries += 1
            continue
        tries = 0
        if (sample_time - new.clock.hi) - new.clock.lo <= 0.0:
            sample = save_samples(con, laws_of(contacts.each), where, sample, path, new.clock, method)
            sample_time = sample / con.sample_rate
        before = tally.work.friction
        tally = book(con, tally, step.work, contacts, (start.kins, new.kins), h_try)
        add_steps(con.contacts, stretch, tally, contacts.each, start, new, before, h_try)
        start, h, flight = new, h_next, after_step(flight)
        corner = h_try >= left and _is_corner(con, stage, segment)
        if corner:
            if i_segment == corners.count - 2:
                code = FINISHED
                break
            i_segment += 1
            segment = segment_of(corners, i_segment)
        # after a switch, a corner or a knot the right-hand side differs: the last slope cannot be reused
        if corner or not inside or passed_knot(con, path.clock, new.clock):
            left_states = contacts.each
            start, contacts = enter(con, segment, start)
            tally = count_switch(tally, inside, left_states, contacts.each)
        tally, code = judge(con, tally, contacts, start, end)
        if code >= 0:
            break
    return code, len(method) * spent, Progress(start, contacts, h, tally, segment, i_segment, sample, finite, flight)


@static
def _travel(con, corners, where, stretch, progress, method, budget):
    """`walk`, and blocks of flight between."""
    if not flies(con):
        return walk(con, corners, where, stretch, progress, method, budget)
    calls = 0
    while True:
        code, more, progress = walk(con, corners, where, stretch, progress, method, budget)
        calls, budget = calls + more, budget - more // len(method)
        if code != TAKE_OFF:
            break
        start, contacts, h, tally, segment, i_segment, sample, finite, flight = progress
        landing = fly(con, segment, Records(where, stretch, contacts.each), start, tally, sample, flight, budget)
        calls, budget, code = calls + landing.calls, budget - landing.spent, landing.code
        start = state_at(con, laws_of(contacts.each), segment, landing.x, landing.v, landing.clock)
        progress = Progress(start, contacts, h, landing.tally, segment, i_segment, landing.sample, finite, landing.flight)
        if code >= 0:
            break
    return code, calls, progress


@entry
def march(model, work, out, rows, width, method, budget):
    """Advance `work` by at most `budget` attempted steps, writing samples into `out` and finished stretches into `rows`.

    Parameters: Model, Work, out (rows, 2n + 3 c) for x and, of each of c contacts, normal force N, friction force N, tangential
    velocity m/s, or (rows, 4n + 3 c) with v after x; rows (c, n_stretches, facts.N_ROW); width, a tuple of 2n floats of which
    only the length matters; method, likewise (`tableau.METHODS`). Returns (code, rows filled).
    """
    aligned_stack()
    room_for_addresses()
    con = constants(model, width)
    start, contacts = resume(model, con, work, width)
    i_segment, first = work.count[SEGMENT], work.count[SAMPLES]
    corners = corners_of(model)
    tally, segment = load_tally(con, work, width), segment_of(corners, i_segment)
    progress = Progress(start, contacts, work.real[H], tally, segment, i_segment, first, True, _flight_in(con, work))
    motion = out.shape[1] - 3 * len(con.contacts)
    where = SampleRows(vec.address(out), out.shape[1], motion - len(width), motion, first, out.shape[0])
    stretch = stretches_of(model, work, rows)
    code, calls, progress = _travel(con, corners, where, stretch, progress, method, budget)
    mark_all(stretch, progress.tally, progress.start)
    put_away(work, progress.start, progress.contacts, progress.h)
    _put_flight_away(work, progress.flight)
    store_tally(work, progress.tally, calls)
    work.count[SAMPLES], work.count[SEGMENT] = progress.sample, progress.i_segment
    return code, progress.sample - first
