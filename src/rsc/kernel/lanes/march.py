"""Many cases of one shape in lockstep, one per lane of the registers, each with its own time, step length, contact state and law.

All lanes attempt a step at once, by the very sources that step a single run. A lane whose step is plain (inside its contact
state) takes it; one that may have left its state is looked at alone (search.py) and takes it or attempts a shorter one with the
others; a lane with a step rejected, at a corner of the schedule or at its end is walked on alone by one attempt from where it
was. So every case has the bits it has alone. A lane that has finished takes the next.
"""

from rsc.kernel.clock import Corners, ahead, clock_at, segment_of, turn_of
from rsc.kernel.contact import CLIPPED, CLOSING, CREEPING, OPEN, OPENING, classify, normal_force
from rsc.kernel.control import kept_between, smooth_factor
from rsc.kernel.dense import dense_of
from rsc.kernel.lanes import layout as rows
from rsc.kernel.lanes.layout import View, number, put_number, vector
from rsc.kernel.lanes.search import LEAVES, STAYS, Look, change_contact, look, put_attempt
from rsc.kernel.lanes.stage_loop import rolled_attempt
from rsc.kernel.march import WINDOW, Progress, State, contact_of, state_at, walk
from rsc.kernel.model import NORMAL, RHS_CALLS, RUNNING, SAMPLES, T_HI, H
from rsc.kernel.rhs import contact_kinematics
from rsc.kernel.simd import vec
from rsc.kernel.simd.hints import aligned_stack
from rsc.kernel.simd.jit import compiled, entry, inlined, unrolled
from rsc.kernel.simd.lanes import choose, lowest_bit, mask_bits, some, whole_part
from rsc.kernel.simd.registers import BYTES
from rsc.kernel.step import attempt, error_square, size_square
from rsc.kernel.switches import EPS, Path, kinematics_inside, rate_dips, slope_of_rate
from rsc.kernel.tableau import table_of
from rsc.kernel.tally import Output, book

PLENTY = 1 << 60


@inlined
def _stays_surely(con, flags, contact, kin):
    """Lanes whose state still belongs to their contact state; a lane that belongs there by rounding alone may be left out."""
    p, rate = kin.place.penetration, kin.motion.rate
    force = con.k_c * p + con.b_c * rate
    closing = (p >= 0.0) & ((con.b_c == 0.0) | (rate >= 0.0))
    opening = (rate <= 0.0) & (force >= 0.0)
    inside = ((contact.normal == CLOSING) & closing) | ((contact.normal == OPENING) & opening)
    if len(flags[2]) > 0:
        slip = kin.motion.slip
        creeping = con.slip_velocity - abs(slip)
        sliding = contact.friction * slip - con.slip_velocity
        margin = choose(contact.friction == CREEPING, creeping, sliding)
        inside = inside & ((margin >= 0.0) | (con.radius == 0.0))
    clipped = (p >= 0.0) & (force <= 0.0)
    return inside | ((contact.normal == OPEN) & (p <= 0.0)) | ((contact.normal == CLIPPED) & clipped)


@inlined
def _may_touch(contact, kin, kin_new, h):
    """Lanes for which `switches.may_touch_inside` holds."""
    p, p_new, rate, rate_new = kin.place.penetration, kin_new.place.penetration, kin.motion.rate, kin_new.motion.rate
    reach = h * max(abs(rate), abs(rate_new))
    is_open = contact.normal == OPEN
    touching = (rate < 0.0) & (rate_new > 0.0) & (min(p, p_new) - reach < 0.0)
    return (is_open & (max(p, p_new) + reach > 0.0)) | (~is_open & touching)


@inlined
def _may_turn(con, contact, start, new, h):
    """Lanes for which `switches.may_turn_inside` holds."""
    closing = contact.normal == CLOSING
    sign = choose(closing, vec.spread(1.0, h), vec.spread(-1.0, h))
    return (closing | (contact.normal == OPENING)) & (con.b_c > 0.0) & rate_dips(sign, start, new, h)


@unrolled
def _attempt(con, law, start, before, clock_end, h, attempted, method):
    """`step.attempt`; of lanes of four, where registers are few, a pair's stages are a loop."""
    if table_of(method) and len(attempted[attempted.fields.index("lanes")]) <= 4:
        return lambda con, law, start, before, clock_end, h, attempted, method: rolled_attempt(
            con, law, start, before, clock_end, h, attempted, method
        )
    return lambda con, law, start, before, clock_end, h, attempted, method: attempt(con, law, start, before, clock_end, h, method)


@inlined
def _try_steps(con, progress, h, attempted, method):
    """Attempt a step in every lane. Returns (State at its end, Step)."""
    start, law = progress.start, progress.contact.law
    clock = ahead(progress.segment, start.clock, h)
    step = _attempt(con, law, start, progress.tally.work, clock, h, attempted, method)
    return State(step.x, step.v, step.a, step.powers, clock, step.kin, slope_of_rate(con, law, step.kin, step.a, clock)), step


@inlined
def _next_lengths(con, h, h_try, error2, method):
    """Lengths of the steps after attempts that were taken, made in place of ones of lengths h."""
    least, most = kept_between(method)
    kept = (error2 > least) & (error2 < most) & (h_try == h)
    if not some(~kept):
        return h  # a branch: the next attempt begins before the errors of this one are known
    h_next = min(h_try * smooth_factor(error2, method), con.h_max)
    return choose(kept, h, choose(h_try < h, max(h, h_next), h_next))


@compiled
def _begin(layout, n_lanes, record, schedule, flags, width):
    """Put a case into a column of the layout."""
    column = View(layout, n_lanes, width, width, (), ())
    length, first = rows.record_length(len(width)), rows.first_matrix(len(width))
    for i in range(length):
        vec.store_number(layout, i * n_lanes, vec.number_at(record, i))
    for i in range(rows.matrix_rows(len(width))):
        vec.store_number(layout, (first + i) * n_lanes, vec.number_at(record, length + i))
    put_number(column, rows.MATRICES, float(record + BYTES * length))
    con = rows.constants_in(column, flags)
    sample, i_segment = rows.counts(column, rows.COUNT + SAMPLES, (0.0, 0.0))
    segment = segment_of(_corners(column, schedule), i_segment)
    hi, lo, phase = rows.numbers(column, rows.REAL + T_HI, rows.THREE)
    clock = clock_at(segment, hi, lo, phase)
    x, v = vector(column, rows.X), vector(column, rows.V)
    normal, friction = rows.counts(column, rows.COUNT + NORMAL, (0.0, 0.0))
    if normal < 0:
        normal, friction = classify(con, contact_kinematics(con, x, v, turn_of(clock)))
    contact = contact_of(con, normal, friction)
    start = state_at(con, contact.law, x, v, clock)
    h, tally = number(column, rows.REAL + H), rows.tally_in(column)
    rows.put_progress(column, Progress(start, contact, h, tally, segment, i_segment, sample, True))
    put_number(column, rows.BUSY, 1.0)
    put_number(column, rows.DUE, sample / con.sample_rate)
    _forget_search(column, 0.0)


@inlined
def _forget_search(view, none):
    put_number(view, rows.H_SEARCH, none)
    put_number(view, rows.TRIES, none)


@inlined
def _corners(column, schedule):
    first = BYTES * int(number(column, rows.FIRST_CORNER))
    return Corners(schedule[0] + first, schedule[1] + first, int(number(column, rows.N_CORNERS)))


@compiled
def _alone(layout, n_lanes, schedule, flags, sizes):
    """Walk the case in a column of the layout on by one attempt; returns the code of `walk`."""
    width, _, _, method = sizes
    column = View(layout, n_lanes, width, width, (), ())
    con = rows.constants_in(column, flags)
    motion, forces, apart, in_row = rows.counts(column, rows.MOTION, rows.FOUR)
    where = Output(motion, in_row, in_row - len(width), forces, 1, apart, 0, PLENTY)
    code, calls, progress = walk(con, _corners(column, schedule), where, rows.progress_in(column, flags), method, 1)
    rows.put_progress(column, progress)
    put_number(column, rows.COUNT + RHS_CALLS, number(column, rows.COUNT + RHS_CALLS) + calls)
    put_number(column, rows.DUE, progress.sample / con.sample_rate)
    _forget_search(column, 0.0)
    return code


@compiled
def _end(layout, n_lanes, record, width):
    """Write a case that has ended back into its record."""
    put_number(View(layout, n_lanes, width, width, (), ()), rows.BUSY, 0.0)
    for i in range(rows.record_length(len(width))):
        vec.store_number(record, i, vec.number_at(layout, i * n_lanes))


@inlined
def _save(con, law, due, path, end, view, method):
    """Write every sample time inside the attempts of the lanes `due`; returns (next samples, their times).

    Also of attempts that are not taken, whose samples are written again: then no branch here waits for the step's error.
    """
    start, h, dense = path.clock, path.h, dense_of(path, method)
    sample, time = number(view, rows.COUNT + SAMPLES), number(view, rows.DUE)
    n_lanes, n = len(view.lanes), len(view.width)
    first, going_on = rows.N_VECTORS * n + rows.OUTPUT, True
    while going_on:
        theta = min(max(((time - start.hi) - start.lo) / h, 0.0), 1.0)
        (x, v), kin = kinematics_inside(con, path, dense, theta)
        force = normal_force(law, kin)
        force = choose(force > 0.0, force, vec.spread(0.0, force))
        friction = force * (law.mu + law.mu_slope * kin.motion.slip)
        put_number(view, rows.OUTPUT, (force, friction, kin.motion.tangential, x))
        in_row, apart = number(view, rows.IN_ROW), number(view, rows.ROWS)
        if some(in_row > n):
            put_number(view, rows.OUTPUT + 3 + n, v)
        motions, forces = number(view, rows.MOTION) + sample * BYTES * in_row, number(view, rows.FORCES) + sample * BYTES
        waiting = mask_bits(due)
        while waiting != 0:
            i = lowest_bit(waiting)
            waiting &= waiting - 1
            row, series, between = int(vec.lane(motions, i)), int(vec.lane(forces, i)), int(vec.lane(apart, i))
            for k in range(3):
                vec.store_number(series, k * between, vec.number_at(view.base, (first + k) * n_lanes + i))
            for k in range(n):
                vec.store_number(row, k, vec.number_at(view.base, (first + 3 + k) * n_lanes + i))
            if vec.lane(in_row, i) > n:
                for k in range(n, 2 * n):
                    vec.store_number(row, k, vec.number_at(view.base, (first + 3 + k) * n_lanes + i))
        sample = choose(due, sample + 1.0, sample)
        time = sample / con.sample_rate
        due = due & ((time - end.hi) - end.lo <= 0.0)
        going_on = some(due)
    return sample, time


@inlined
def _length_after(con, view, h, h_try, error2, searched, method):
    """Lengths after steps that are taken: of a step that searched a switch as of the one that met it. It is kept for such."""
    after = _next_lengths(con, h, h_try, error2, method)
    if some(searched):
        after = choose(searched, number(view, rows.H_THEN), after)
    put_number(view, rows.H_THEN, after)
    return after


@inlined
def _look_at(target, view, attempts, flags, sizes):
    """Look at lanes one by one; returns those that take their step and, as bits, those that leave their contact state with it."""
    waiting = mask_bits(target)
    while waiting != 0:
        i = lowest_bit(waiting)
        waiting &= waiting - 1
        look(Look(view.base + BYTES * i, attempts + BYTES * i, view.stride, flags, sizes))
    verdict = number(view, rows.VERDICT)
    return target & (verdict >= STAYS), mask_bits(target & (verdict == LEAVES))


@inlined
def _put_taken(target, view, due, sample, time, after, method):
    """Write where the lanes are that take their step."""
    if some(due):
        put_number(target, rows.COUNT + SAMPLES, sample)
        put_number(target, rows.DUE, time)
    rows.put_state(target, after)
    calls = number(view, rows.COUNT + RHS_CALLS) + (number(view, rows.TRIES) + 1.0) * len(method)
    put_number(target, rows.COUNT + RHS_CALLS, calls)
    _forget_search(target, vec.spread(0.0, after.h))


@inlined
def _step(view, attempts, flags, sizes):
    """Attempt a step in every lane and take those that are right. Returns the lanes that are left to be walked alone, as bits."""
    method = sizes[3]
    con, progress = rows.constants_in(view, flags), rows.progress_in(view, flags)
    start, contact = progress.start, progress.contact
    left, h_search = (progress.segment.end - start.clock.hi) - start.clock.lo, number(view, rows.H_SEARCH)
    searched = h_search > 0.0
    h = choose(searched, h_search, min(progress.h, left))
    attempted = View(attempts, view.stride, view.width, view.driven, view.lanes, ())
    new, step = _try_steps(con, progress, h, attempted, method)
    error2 = error_square(con, step, h, method)
    running = number(view, rows.BUSY) > 0.0
    right = running & (progress.h >= max(10.0 * EPS * start.clock.hi, 1e-290)) & (progress.tally.steps < con.max_steps)
    right = right & (error2 <= 1.0) & (h < left) & (size_square(new.x) <= con.divergence2)
    steps = progress.tally.steps + 1.0
    right = right & (whole_part(steps / WINDOW) * WINDOW != steps)  # else stiffness is looked for
    path = Path(step, start.clock, h)
    plain = _stays_surely(con, flags, contact, new.kin) & ~_may_touch(contact, start.kin, new.kin, h)
    plain = plain & ~_may_turn(con, contact, start, new, h)
    due = running & ((number(view, rows.DUE) - new.clock.hi) - new.clock.lo <= 0.0)
    sample, time = progress.sample, number(view, rows.DUE)
    if some(due):
        sample, time = _save(con, contact.law, due, path, new.clock, view, method)
    taken, leaving = right & plain, 0
    if some(right & ~plain):
        put_attempt(view, attempted, new, step, h)
        looked_at, leaving = _look_at(right & ~plain, view, attempts, flags, sizes)
        taken = taken | looked_at
    h_next = _length_after(con, view, progress.h, h, error2, searched, method)
    tally = book(con, progress.tally, step.work, contact, (start.kin, new.kin), h)
    after = Progress(new, contact, h_next, tally, progress.segment, progress.i_segment, progress.sample, progress.finite | taken)
    if some(~taken):  # else, by a branch as well, the next attempt waits for no choice between old and new
        target = View(view.base, view.stride, view.width, view.driven, view.lanes, taken)
        _put_taken(target, view, due, sample, time, after, method)
    else:
        _put_taken(view, view, due, sample, time, after, method)
    while leaving != 0:
        i = lowest_bit(leaving)
        leaving &= leaving - 1
        change_contact(Look(view.base + BYTES * i, attempts + BYTES * i, view.stride, flags, sizes))
    return mask_bits(running & ~right)


@entry
def march_cases(records, schedule, state, flags, sizes, budget):
    """Run every case on towards its end, by at most `budget` attempts of all lanes; returns how many cases are still to be ended.

    Parameters: records (cases, record_length + matrix_rows) with the rows of layout.py; schedule = arrays of the times and speeds
    of all corners; state = (layout (layout_rows, W), layout of attempts (attempt_rows, W), both aligned to a row; held (W + 1,)
    int64 for the cases in the lanes and the next; codes (cases,) int64 for how each case ended), zeros before the first call;
    flags of all cases as `layout.constants_in` has them; sizes = tuples of 2n, 2N, W and as many floats as the method has stages.
    """
    aligned_stack()
    layout, attempts, held, codes = state
    width, driven, lanes, _ = sizes
    base, first = vec.address(layout), vec.address(records)
    corners = (vec.address(schedule[0]), vec.address(schedule[1]))
    n_lanes, length = len(lanes), BYTES * (rows.record_length(len(width)) + rows.matrix_rows(len(width)))
    view = View(base, n_lanes, width, driven, lanes, ())
    n = records.shape[0]
    left = n
    for code in codes:
        left -= 1 if code != RUNNING else 0
    if held[n_lanes] == 0:
        for i in range(min(n_lanes, n)):
            _begin(base + BYTES * i, n_lanes, first + i * length, corners, flags, width)
            held[i] = i
        held[n_lanes] = min(n_lanes, n)
    while left > 0 and budget > 0:
        budget -= 1
        waiting = _step(view, vec.address(attempts), flags, sizes)
        while waiting != 0:
            i = lowest_bit(waiting)
            waiting &= waiting - 1
            code = _alone(base + BYTES * i, n_lanes, corners, flags, sizes)
            if code == RUNNING:
                continue
            codes[held[i]] = code
            left -= 1
            _end(base + BYTES * i, n_lanes, first + held[i] * length, width)
            if held[n_lanes] < n:
                held[i] = held[n_lanes]
                held[n_lanes] += 1
                _begin(base + BYTES * i, n_lanes, first + held[i] * length, corners, flags, width)
    return left
