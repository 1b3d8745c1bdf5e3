"""Many cases of one shape in lockstep, one per lane of the registers, each with its own time, step length, mode and law.

All lanes attempt a step at once, by the very sources that step a single run. A lane whose step is plain (inside its mode) takes
it; one that may have left its mode is looked at alone (search.py) and takes it or attempts a shorter one with the others; a lane
with a step rejected, at a corner of the schedule or at its end is walked on alone by one attempt from where it was. So every case
has the bits it has alone. A lane that has finished takes the next.
"""

from rsc.kernel.clock import Corners, ahead, clock_at, segment_of, turn_of
from rsc.kernel.contact import CLIPPED, CLOSING, CREEPING, OPEN, OPENING, classify, normal_force
from rsc.kernel.control import kept_between, smooth_factor
from rsc.kernel.dense import dense_of
from rsc.kernel.lanes.layout import (
    BUSY,
    COUNT,
    DUE,
    FIRST_CORNER,
    FORCES,
    H_SEARCH,
    H_THEN,
    MATRICES,
    MOTION,
    N_CORNERS,
    N_VECTORS,
    OUTPUT,
    REAL,
    ROWS,
    TRIES,
    VERDICT,
    V,
    View,
    X,
    constants_in,
    first_matrix,
    here_in,
    matrix_rows,
    number,
    put_here,
    put_number,
    put_state,
    record_length,
    tally_in,
    vector,
)
from rsc.kernel.lanes.search import LEAVES, STAYS, Look, change_mode, look, put_attempt
from rsc.kernel.lanes.stage_loop import rolled_attempt
from rsc.kernel.march import WINDOW, Here, State, mode_of, state_at, walk
from rsc.kernel.model import FRICTION, NORMAL, PHASE, RHS_CALLS, RUNNING, SAMPLES, SEGMENT, T_HI, T_LO, H
from rsc.kernel.rhs import contact_kinematics
from rsc.kernel.simd import vec
from rsc.kernel.simd.cases import choose, lowest_bit, mask_bits, some, whole_part
from rsc.kernel.simd.hints import aligned_stack
from rsc.kernel.simd.jit import compiled, entry, inlined, unrolled
from rsc.kernel.simd.registers import BYTES
from rsc.kernel.step import attempt, error_square, size_square
from rsc.kernel.switches import EPS, Path, kinematics_inside, rate_dips, slope_of_rate
from rsc.kernel.tableau import table_of
from rsc.kernel.tally import Output, book

PLENTY = 1 << 60


@inlined
def _stays_surely(con, flags, mode, kin):
    """Lanes whose state still belongs to their mode; a lane that belongs there by rounding alone may be left out."""
    p, rate = kin.place.penetration, kin.motion.rate
    force = con.k_c * p + con.b_c * rate
    closing = (p >= 0.0) & ((con.b_c == 0.0) | (rate >= 0.0))
    opening = (rate <= 0.0) & (force >= 0.0)
    inside = ((mode.normal == CLOSING) & closing) | ((mode.normal == OPENING) & opening)
    if len(flags[2]) > 0:
        slip = kin.motion.slip
        creeping = con.slip_velocity - abs(slip)
        sliding = mode.friction * slip - con.slip_velocity
        margin = choose(mode.friction == CREEPING, creeping, sliding)
        inside = inside & ((margin >= 0.0) | (con.radius == 0.0))
    clipped = (p >= 0.0) & (force <= 0.0)
    return inside | ((mode.normal == OPEN) & (p <= 0.0)) | ((mode.normal == CLIPPED) & clipped)


@inlined
def _may_touch(mode, kin, kin_new, h):
    """Lanes for which `switches.may_touch_inside` holds."""
    p, p_new, rate, rate_new = kin.place.penetration, kin_new.place.penetration, kin.motion.rate, kin_new.motion.rate
    reach = h * max(abs(rate), abs(rate_new))
    is_open = mode.normal == OPEN
    touching = (rate < 0.0) & (rate_new > 0.0) & (min(p, p_new) - reach < 0.0)
    return (is_open & (max(p, p_new) + reach > 0.0)) | (~is_open & touching)


@inlined
def _may_turn(con, mode, now, new, h):
    """Lanes for which `switches.may_turn_inside` holds."""
    closing = mode.normal == CLOSING
    sign = choose(closing, vec.spread(1.0, h), vec.spread(-1.0, h))
    return (closing | (mode.normal == OPENING)) & (con.b_c > 0.0) & rate_dips(sign, now, new, h)


@unrolled
def _attempt(con, law, start, done, clock_end, h, there, stages):
    """`step.attempt`; of lanes of four, where registers are few, a pair's stages are a loop."""
    if table_of(stages) and len(there[there.fields.index("cases")]) <= 4:
        return lambda con, law, start, done, clock_end, h, there, stages: rolled_attempt(
            con, law, start, done, clock_end, h, there, stages
        )
    return lambda con, law, start, done, clock_end, h, there, stages: attempt(con, law, start, done, clock_end, h, stages)


@inlined
def _try_steps(con, here, h, there, stages):
    """Attempt a step in every lane. Returns (State at its end, Step)."""
    now, law = here.now, here.mode.law
    clock = ahead(here.segment, now.clock, h)
    step = _attempt(con, law, now, here.tally.work, clock, h, there, stages)
    return State(step.x, step.v, step.a, step.powers, clock, step.kin, slope_of_rate(con, law, step.kin, step.a, clock)), step


@inlined
def _next_lengths(con, h, h_try, error2, stages):
    """Lengths of the steps after attempts that were taken, made in place of ones of lengths h."""
    least, most = kept_between(stages)
    kept = (error2 > least) & (error2 < most) & (h_try == h)
    if not some(~kept):
        return h  # a branch: the next attempt begins before the errors of this one are known
    h_next = min(h_try * smooth_factor(error2, stages), con.h_max)
    return choose(kept, h, choose(h_try < h, max(h, h_next), h_next))


@compiled
def _begin(room, width, record, schedule, flags, lanes):
    """Put a case into a column of the room."""
    column = View(room, width, lanes, lanes, (), ())
    length, first = record_length(len(lanes)), first_matrix(len(lanes))
    for i in range(length):
        vec.store_number(room, i * width, vec.number_at(record, i))
    for i in range(matrix_rows(len(lanes))):
        vec.store_number(room, (first + i) * width, vec.number_at(record, length + i))
    put_number(column, MATRICES, float(record + BYTES * length))
    con = constants_in(column, flags)
    i_segment, sample = int(number(column, COUNT + SEGMENT)), int(number(column, COUNT + SAMPLES))
    segment = segment_of(_corners(column, schedule), i_segment)
    clock = clock_at(segment, number(column, REAL + T_HI), number(column, REAL + T_LO), number(column, REAL + PHASE))
    x, v = vector(column, X), vector(column, V)
    normal, friction = int(number(column, COUNT + NORMAL)), int(number(column, COUNT + FRICTION))
    if normal < 0:
        normal, friction = classify(con, contact_kinematics(con, x, v, turn_of(clock)))
    mode = mode_of(con, normal, friction)
    now = state_at(con, mode.law, x, v, clock)
    put_here(column, Here(now, mode, number(column, REAL + H), tally_in(column), segment, i_segment, sample, True))
    put_number(column, BUSY, 1.0)
    put_number(column, DUE, sample / con.sample_rate)
    _forget_search(column, 0.0)


@inlined
def _forget_search(view, none):
    put_number(view, H_SEARCH, none)
    put_number(view, TRIES, none)


@inlined
def _corners(column, schedule):
    first = BYTES * int(number(column, FIRST_CORNER))
    return Corners(schedule[0] + first, schedule[1] + first, int(number(column, N_CORNERS)))


@compiled
def _alone(room, width, schedule, flags, sizes):
    """Walk the case in a column of the room on by one attempt; returns the code of `walk`."""
    lanes, _, _, stages = sizes
    column = View(room, width, lanes, lanes, (), ())
    con = constants_in(column, flags)
    where = Output(int(number(column, MOTION)), len(lanes), int(number(column, FORCES)), 1, int(number(column, ROWS)), 0, PLENTY)
    code, calls, here = walk(con, _corners(column, schedule), where, here_in(column, flags), stages, 1)
    put_here(column, here)
    put_number(column, COUNT + RHS_CALLS, number(column, COUNT + RHS_CALLS) + calls)
    put_number(column, DUE, here.sample / con.sample_rate)
    _forget_search(column, 0.0)
    return code


@compiled
def _end(room, width, record, lanes):
    """Write a case that has ended back into its record."""
    put_number(View(room, width, lanes, lanes, (), ()), BUSY, 0.0)
    for i in range(record_length(len(lanes))):
        vec.store_number(record, i, vec.number_at(room, i * width))


@inlined
def _save(con, law, due, path, end, view, stages):
    """Write every sample time inside the attempts of the lanes `due`; returns (next samples, their times).

    Also of attempts that are not taken, whose samples are written again: then no branch here waits for the step's error.
    """
    start, h, dense = path.clock, path.h, dense_of(path, stages)
    sample, time = number(view, COUNT + SAMPLES), number(view, DUE)
    width, n = len(view.cases), len(view.lanes)
    going_on = True
    while going_on:
        theta = min(max(((time - start.hi) - start.lo) / h, 0.0), 1.0)
        x, kin = kinematics_inside(con, path, dense, theta)
        force = normal_force(law, kin)
        force = choose(force > 0.0, force, vec.spread(0.0, force))
        put_number(view, OUTPUT, x)
        put_number(view, OUTPUT + n, force)
        put_number(view, OUTPUT + n + 1, force * (law.mu + law.mu_slope * kin.motion.slip))
        put_number(view, OUTPUT + n + 2, kin.motion.tangential)
        motion, forces = number(view, MOTION) + sample * (BYTES * n), number(view, FORCES) + sample * BYTES
        apart = number(view, ROWS)
        rest = mask_bits(due)
        while rest != 0:
            i = lowest_bit(rest)
            rest &= rest - 1
            row, series, between = int(vec.lane(motion, i)), int(vec.lane(forces, i)), int(vec.lane(apart, i))
            for k in range(n):
                vec.store_number(row, k, vec.number_at(view.base, (N_VECTORS * n + OUTPUT + k) * width + i))
            for k in range(3):
                vec.store_number(series, k * between, vec.number_at(view.base, (N_VECTORS * n + OUTPUT + n + k) * width + i))
        sample = choose(due, sample + 1.0, sample)
        time = sample / con.sample_rate
        due = due & ((time - end.hi) - end.lo <= 0.0)
        going_on = some(due)
    return sample, time


@inlined
def _length_after(con, view, h, h_try, error2, searched, stages):
    """Lengths after steps that are taken: of a step that searched a switch as of the one that met it. It is kept for such."""
    after = _next_lengths(con, h, h_try, error2, stages)
    if some(searched):
        after = choose(searched, number(view, H_THEN), after)
    put_number(view, H_THEN, after)
    return after


@inlined
def _look_at(those, view, attempts, flags, sizes):
    """Look at lanes one by one; returns those that take their step and, as bits, those that leave their mode with it."""
    rest = mask_bits(those)
    while rest != 0:
        i = lowest_bit(rest)
        rest &= rest - 1
        look(Look(view.base + BYTES * i, attempts + BYTES * i, view.stride, flags, sizes))
    verdict = number(view, VERDICT)
    return those & (verdict >= STAYS), mask_bits(those & (verdict == LEAVES))


@inlined
def _put_taken(those, view, due, sample, time, after, stages):
    """Write where the lanes are that take their step."""
    if some(due):
        put_number(those, COUNT + SAMPLES, sample)
        put_number(those, DUE, time)
    put_state(those, after)
    calls = number(view, COUNT + RHS_CALLS) + (number(view, TRIES) + 1.0) * len(stages)
    put_number(those, COUNT + RHS_CALLS, calls)
    _forget_search(those, vec.spread(0.0, after.h))


@inlined
def _step(view, attempts, flags, sizes):
    """Attempt a step in every lane and take those that are right. Returns the lanes that are left to be walked alone, as bits."""
    stages = sizes[3]
    con, here = constants_in(view, flags), here_in(view, flags)
    now, mode = here.now, here.mode
    left, h_search = (here.segment.end - now.clock.hi) - now.clock.lo, number(view, H_SEARCH)
    searched = h_search > 0.0
    h = choose(searched, h_search, min(here.h, left))
    there = View(attempts, view.stride, view.lanes, view.driven, view.cases, ())
    new, step = _try_steps(con, here, h, there, stages)
    error2 = error_square(con, step, h, stages)
    running = number(view, BUSY) > 0.0
    right = running & (here.h >= max(10.0 * EPS * now.clock.hi, 1e-290)) & (here.tally.steps < con.max_steps)
    right = right & (error2 <= 1.0) & (h < left) & (size_square(new.x) <= con.divergence2)
    steps = here.tally.steps + 1.0
    right = right & (whole_part(steps / WINDOW) * WINDOW != steps)  # else stiffness is looked for
    path = Path(step, now.clock, h)
    plain = _stays_surely(con, flags, mode, new.kin) & ~_may_touch(mode, now.kin, new.kin, h)
    plain = plain & ~_may_turn(con, mode, now, new, h)
    due = running & ((number(view, DUE) - new.clock.hi) - new.clock.lo <= 0.0)
    sample, time = here.sample, number(view, DUE)
    if some(due):
        sample, time = _save(con, mode.law, due, path, new.clock, view, stages)
    taken, leaving = right & plain, 0
    if some(right & ~plain):
        put_attempt(view, there, new, step, h)
        found, leaving = _look_at(right & ~plain, view, attempts, flags, sizes)
        taken = taken | found
    h_next = _length_after(con, view, here.h, h, error2, searched, stages)
    tally = book(con, here.tally, step.work, mode, (now.kin, new.kin), h)
    after = Here(new, mode, h_next, tally, here.segment, here.i_segment, here.sample, here.finite | taken)
    if some(~taken):  # else, by a branch as well, the next attempt waits for no choice between old and new
        those = View(view.base, view.stride, view.lanes, view.driven, view.cases, taken)
        _put_taken(those, view, due, sample, time, after, stages)
    else:
        _put_taken(view, view, due, sample, time, after, stages)
    while leaving != 0:
        i = lowest_bit(leaving)
        leaving &= leaving - 1
        change_mode(Look(view.base + BYTES * i, attempts + BYTES * i, view.stride, flags, sizes))
    return mask_bits(running & ~right)


@entry
def march_cases(records, schedule, state, flags, sizes, budget):
    """Run every case on towards its end, by at most `budget` attempts of all lanes; returns how many cases are still to be ended.

    Parameters: records (cases, record_length + matrix_rows) with the rows of layout.py; schedule = arrays of the times and speeds
    of all corners; state = (room (room_rows, W) and room of attempts (attempt_rows, W), both aligned to a row; held (W + 1,)
    int64 for the cases in the lanes and the next; codes (cases,) int64 for how each case ended), zeros before the first call;
    flags of all cases as `layout.constants_in` has them; sizes = tuples of 2n, 2N, W and as many floats as the method has stages.
    """
    aligned_stack()
    room, attempts, held, codes = state
    lanes, driven, cases, _ = sizes
    base, first = vec.address(room), vec.address(records)
    corners = (vec.address(schedule[0]), vec.address(schedule[1]))
    width, length = len(cases), BYTES * (record_length(len(lanes)) + matrix_rows(len(lanes)))
    view = View(base, width, lanes, driven, cases, ())
    n = records.shape[0]
    left = n
    for code in codes:
        left -= 1 if code != RUNNING else 0
    if held[width] == 0:
        for i in range(min(width, n)):
            _begin(base + BYTES * i, width, first + i * length, corners, flags, lanes)
            held[i] = i
        held[width] = min(width, n)
    while left > 0 and budget > 0:
        budget -= 1
        rest = _step(view, vec.address(attempts), flags, sizes)
        while rest != 0:
            i = lowest_bit(rest)
            rest &= rest - 1
            code = _alone(base + BYTES * i, width, corners, flags, sizes)
            if code == RUNNING:
                continue
            codes[held[i]] = code
            left -= 1
            _end(base + BYTES * i, width, first + held[i] * length, lanes)
            if held[width] < n:
                held[i] = held[width]
                held[width] += 1
                _begin(base + BYTES * i, width, first + held[i] * length, corners, flags, lanes)
    return left
