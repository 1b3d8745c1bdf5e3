"""Facts of the motion in each stretch of a run, accumulated in every step, so that they do not depend on the output rate.

The sums are kept in memory, not in registers, since nothing in a step waits for them. A stretch ends with the first step that
ends after its end time; its row is then copied to the finished ones, and the next stretch begins.
"""

import math
from typing import NamedTuple

from rsc.kernel import springs
from rsc.kernel.contact import CREEPING, OPEN, normal_force
from rsc.kernel.cubic import cubic, extreme, largest_between, passage
from rsc.kernel.questions import has_race, is_array, is_none
from rsc.kernel.race import surface_of
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import compiled, inlined, unrolled
from rsc.kernel.simd.static import static

# entries of a stretch. CROSSINGS: signed, of the contact deflection d across the negative y axis; PRESSED_ANGLE (rad), rotation
# of d while in contact; ROLLING (s), time in contact within the slip range around zero; squares of |r| (m^2) of rotor and stator;
# ARC_Y, ARC_Z (m s), integral of d while in contact; NORMAL, TANGENTIAL (N s), impulses of normal and friction force; GIVEN (J),
# work that friction takes from the drive, RACED (J) the part of it that goes into a race; EXTENTS, four entries: min and max of
# y, then of z (m) of the rotor; *_TIME (s), when the largest value was reached
(
    CROSSINGS, PRESSED_ANGLE, ROLLING, ROTOR_MOST, ROTOR_LEAST, STATOR_MOST, DEFLECTION, FORCE, ARC_Y, ARC_Z, NORMAL, TANGENTIAL,
    GIVEN, RACED, EXTENTS, _, _, _, ROTOR_TIME, DEFLECTION_TIME, FORCE_TIME, N_SUMS,
) = range(22)  # fmt: skip
# then marks at the start of the stretch and at its current end: time (s), d (m), sums of the run
BEGIN, END = N_SUMS, N_SUMS + 6
TIME, D_Y, D_Z, CONTACT_TIME, ONSETS, FRICTION_WORK, N_MARKS = range(7)
N_ROW = N_SUMS + 2 * N_MARKS
# after the row: end time of the stretch, number of finished stretches, (|r|^2)'/2 and r' of the rotor after the last step
UNTIL, FINISHED, SLOPE, RATE_Y, RATE_Z, N_STRETCH = range(N_ROW, N_ROW + 6)
# then, in the running stretch and in finished rows, entries for each clearance: square of its largest deflection, m^2; time in s
# at which the run first exceeded its gap, infinite before; min and max of y, then of z of its deflection, m
MOST, PASSED, WATCHED_EXTENTS, N_WATCHED = 0, 1, 2, 6


class Stretch(NamedTuple):
    """Memory in which facts of a contact are accumulated: addresses of the running stretch and of the finished rows, length of a
    stretch in s."""

    running: int
    rows: int
    length: float
    watched: tuple  # (address of rows, address of gaps, number) of the clearances; () without any


@static
def _watched_of(rows, gaps):
    """See `Stretch.watched`."""
    return (vec.address(rows), vec.address(gaps), len(gaps)) if is_array(rows) else ()


@static
def _count(watched):
    """Number of clearances."""
    return 0 if is_none(watched) else watched[2]


@inlined
def stretches_of(model, work, rows):
    """The Stretch of every contact; rows (contacts, n, N_ROW + N_WATCHED k) for k clearances, repeated for each contact."""
    watched = _watched_of(model.watched_rows, model.watched_gaps)
    first = Stretch(vec.address(work.stretch), vec.address(rows), model.stretch, watched)
    return _from(model.contacts, first, 8 * (N_STRETCH + N_WATCHED * _count(watched)), 8 * rows.shape[1] * rows.shape[2])


@static
def _from(contacts, first, running, rows):
    """The first Stretch and the following ones; running, rows: bytes of a running stretch and of all rows of a contact."""
    if is_none(contacts):
        return ()
    following = Stretch(first.running + running, first.rows + rows, first.length, first.watched)
    return (first,) + _from(contacts[1:], following, running, rows)


@inlined
def _add(at, i, more):
    vec.store_number(at, i, vec.number_at(at, i) + more)


@inlined
def _keep_larger(at, i, value):
    if value > vec.number_at(at, i):
        vec.store_number(at, i, value)


@inlined
def _keep_larger_at(at, i, value, when, time):
    """Update a maximum and the time at which it is reached."""
    if value > vec.number_at(at, i):
        vec.store_number(at, i, value)
        vec.store_number(at, when, time)


@inlined
def _keep_extents(at, i, place):
    """Update min and max of y and of z, entries i to i + 3."""
    for k in range(2):
        if place[k] < vec.number_at(at, i + 2 * k):
            vec.store_number(at, i + 2 * k, place[k])
        if place[k] > vec.number_at(at, i + 2 * k + 1):
            vec.store_number(at, i + 2 * k + 1, place[k])


@inlined
def _keep_turning_points(at, i, begin, end, h):
    """`_keep_extents` for extrema of y or z inside a step; begin = (r, r') at its start, end likewise."""
    (y, z), (y_dot, z_dot) = begin
    (y_new, z_new), (y_dot_new, z_dot_new) = end
    _keep_extents(at, i, (extreme(y, y_new, h * y_dot, h * y_dot_new), extreme(z, z_new, h * z_dot, h * z_dot_new)))


@inlined
def _rotor(con, x, v):
    """(r, r') of the rotor at the contact, pairs."""
    return vec.pair_sum(vec.product(con.rotor_row, x)), vec.pair_sum(vec.product(con.rotor_row, v))


@inlined
def _see_size(con, at, start, new, place, h):
    """Update |r| of rotor and stator, and extents of the rotor; extrema inside a step are located for the rotor only."""
    r, r_dot = _rotor(con, new.x, new.v)
    s_y, s_z = r[0] - place.d_y + place.ring_y, r[1] - place.d_z + place.ring_z
    if con.has_offset:
        s_y, s_z = s_y - con.offset_y, s_z - con.offset_z
    square, slope = r[0] * r[0] + r[1] * r[1], r[0] * r_dot[0] + r[1] * r_dot[1]
    before = vec.number_at(at, SLOPE)
    vec.store_number(at, SLOPE, slope)
    _keep_larger(at, STATOR_MOST, s_y * s_y + s_z * s_z)
    if square < vec.number_at(at, ROTOR_LEAST):
        vec.store_number(at, ROTOR_LEAST, square)
    turns_y, turns_z = vec.number_at(at, RATE_Y) * r_dot[0] < 0.0, vec.number_at(at, RATE_Z) * r_dot[1] < 0.0
    vec.store_number(at, RATE_Y, r_dot[0])
    vec.store_number(at, RATE_Z, r_dot[1])
    # most such maxima stay below the largest so far: a concave curve does not exceed the tangent at its end
    turns = before > 0.0 and slope < 0.0 and square - 2.0 * h * slope > vec.number_at(at, ROTOR_MOST)
    _keep_larger_at(at, ROTOR_MOST, square, ROTOR_TIME, new.clock.hi)
    _keep_extents(at, EXTENTS, r)
    if turns or turns_y or turns_z:
        begin, end = _rotor(con, start.x, start.v), (r, r_dot)
        _keep_turning_points(at, EXTENTS, begin, end, h)
        if turns:
            largest, theta = largest_between(begin, end, h)
            _keep_larger_at(at, ROTOR_MOST, largest, ROTOR_TIME, start.clock.hi + theta * h)


@inlined
def _see_force(con, at, contact, kins, raced, slopes, fed, times):
    """Add facts of the contact forces over a step in contact; slopes: p'' at its ends; raced: see `_raced`; times: length of the
    step and its end time, s."""
    h, end = times
    law, place, motion = contact.law, kins[0].place, kins[0].motion
    place_new, motion_new = kins[1].place, kins[1].motion
    force, force_new = max(normal_force(law, kins[0]), 0.0), max(normal_force(law, kins[1]), 0.0)
    friction, friction_new = law.mu + law.mu_slope * motion.slip, law.mu + law.mu_slope * motion_new.slip
    half = 0.5 * h
    # correction of the trapezoidal rule for a force with slopes F' p' + b p'' at the ends; a Taylor step may be long
    stiff, stiff_new = springs.slope(law.spring, place.penetration), springs.slope(law.spring, place_new.penetration)
    change = stiff * (motion.rate - motion_new.rate) + (stiff - stiff_new) * motion_new.rate
    bend = h * h / 12.0 * (change + law.b * (slopes[0] - slopes[1]))
    _add(at, PRESSED_ANGLE, half * (motion.tangential * place.inverse + motion_new.tangential * place_new.inverse))
    _add(at, ARC_Y, half * (place.d_y + place_new.d_y))
    _add(at, ARC_Z, half * (place.d_z + place_new.d_z))
    _add(at, NORMAL, half * (force + force_new) + bend)
    tangential = half * (friction * force + friction_new * force_new) + 0.5 * (friction + friction_new) * bend
    surface = 0.5 * (motion.slip - motion.tangential + motion_new.slip - motion_new.tangential)
    if not len(con.race) and contact.friction == CREEPING and surface > 0.0:
        normal = half * (force + force_new) + bend
        heat = _heat_of_creep(law, kins, (force, force_new), normal, h)
        tangential = (heat + fed) / surface  # the heat is small compared with the energy fed by friction
    _add(at, TANGENTIAL, tangential)
    if con.surfaces.radius > 0.0:
        _add(at, GIVEN, tangential * (surface + raced))
        _add(at, RACED, tangential * raced)
    _keep_larger_at(at, FORCE, force_new, FORCE_TIME, end)
    if con.surfaces.radius > 0.0 and contact.friction == CREEPING:
        _add(at, ROLLING, h)


@static
def _raced(con, v, v_new):
    """Mean surface velocity of a race in m/s between two states; 0 without a race."""
    return 0.5 * (surface_of(con, v) + surface_of(con, v_new)) if has_race(con) else 0.0


@inlined
def _heat_of_creep(law, kins, forces, normal, h):
    """Heat of friction over a step in which friction depends on the slip; normal: integral of the normal force.

    Simpson's rule, since the slip may decay within a step: the mid-step slip and force are chosen to match their means; that of
    the slip follows from the rotation angle of d.
    """
    (place, motion), (place_new, motion_new) = (kins[0].place, kins[0].motion), (kins[1].place, kins[1].motion)
    along = place.d_y * place_new.d_y + place.d_z * place_new.d_z
    angle = math.atan2(place.d_y * place_new.d_z - place.d_z * place_new.d_y, along)
    carried = 0.5 * (motion.slip - motion.tangential + motion_new.slip - motion_new.tangential)
    mean = carried + 0.5 * (place.distance + place_new.distance) * angle / h
    slips = motion.slip, 1.5 * mean - 0.25 * (motion.slip + motion_new.slip), motion_new.slip
    middle = 4.0 * (law.mu + law.mu_slope * slips[1]) * (1.5 * normal / h - 0.25 * (forces[0] + forces[1]))
    first, last = (law.mu + law.mu_slope * slips[0]) * forces[0], (law.mu + law.mu_slope * slips[2]) * forces[1]
    return h / 6.0 * (first * slips[0] + middle * slips[1] + last * slips[2])


@inlined
def _see_deflection(at, law, kins, begin, h):
    """Update the largest deflection, and the force at a maximum inside a step; begin: start time of the step, s."""
    place, rate, rate_new = kins[0].place, kins[0].motion.rate, kins[1].motion.rate
    distance = kins[1].place.distance
    if rate > 0.0 and rate_new < 0.0:
        theta = rate / (rate - rate_new)
        largest = cubic(place.distance, distance, h * rate, h * rate_new, theta)[0]
        time = begin + theta * h
        _keep_larger_at(at, DEFLECTION, largest, DEFLECTION_TIME, time)
        deepest = springs.switch(law.spring, largest - place.distance + place.penetration)
        _keep_larger_at(at, FORCE, deepest, FORCE_TIME, time)
    else:
        _keep_larger_at(at, DEFLECTION, distance, DEFLECTION_TIME, begin + h)


@inlined
def _see_turn(at, place, place_new):
    """Count a crossing of the negative y axis by d, with its sign."""
    cross = place.d_y * place_new.d_z - place.d_z * place_new.d_y
    if place_new.d_z < 0.0 and cross > 0.0:
        _add(at, CROSSINGS, 1.0)
    elif place_new.d_z >= 0.0 and cross < 0.0:
        _add(at, CROSSINGS, -1.0)


@static
def _see_clearances(watched, at, start, new, h):
    """Update the largest deflection at every clearance, and the time when its gap was first exceeded."""
    if is_none(watched):
        return
    rows, gaps, count = watched
    for i in range(count):
        row = vec.row_at(rows, i, new.x)
        begin = vec.pair_sum(vec.product(row, start.x)), vec.pair_sum(vec.product(row, start.v))
        end = vec.pair_sum(vec.product(row, new.x)), vec.pair_sum(vec.product(row, new.v))
        (y, z), (y_dot, z_dot) = begin
        (y_new, z_new), (y_dot_new, z_dot_new) = end
        largest = y_new * y_new + z_new * z_new
        if y * y_dot + z * z_dot > 0.0 and y_new * y_dot_new + z_new * z_dot_new < 0.0:
            largest = max(largest, largest_between(begin, end, h)[0])
        place, gap = N_STRETCH + N_WATCHED * i, vec.number_at(gaps, i)
        _keep_extents(at, place + WATCHED_EXTENTS, end[0])
        _keep_turning_points(at, place + WATCHED_EXTENTS, begin, end, h)
        _keep_larger(at, place + MOST, largest)
        if largest > gap * gap and vec.number_at(at, place + PASSED) == math.inf:
            vec.store_number(at, place + PASSED, start.clock.hi + h * passage(begin, end, h, gap))


@unrolled
def add_steps(contacts, stretches, tally, each, start, new, before, h):
    """`_add_step` for every contact; tally: the sums at the end of the step; before: work of friction at its start."""
    if not len(contacts):
        return lambda contacts, stretches, tally, each, start, new, before, h: None
    i = len(before) - len(contacts)

    def add(contacts, stretches, tally, each, start, new, before, h):
        at = contacts[0], stretches[0], each[0]
        kins, slopes = (start.kins[i], new.kins[i]), (start.rate_slopes[i], new.rate_slopes[i])
        sums = tally.contact_times[i], tally.onsets[i], tally.work.friction[i]
        _add_step(at, start, new, kins, slopes, sums, sums[2] - before[i], h)
        add_steps(contacts[1:], stretches[1:], tally, each[1:], start, new, before, h)

    return add


@inlined
def _add_step(where, start, new, kins, slopes, sums, fed, h):
    """Add an accepted step, from one State to the next within one contact state, to the facts of one contact.

    where = its constants, Stretch and Contact; kins, slopes: kinematics and p'' at both ends; sums: contact time, onsets and work
    of friction at the end of the step; fed: work of friction on the lateral motion during the step.
    """
    con, stretch, contact = where
    at = stretch.running
    _see_size(con, at, start, new, kins[1].place, h)
    _see_deflection(at, contact.law, kins, start.clock.hi, h)
    _see_clearances(stretch.watched, at, start, new, h)
    if (kins[0].place.d_z < 0.0) != (kins[1].place.d_z < 0.0):
        _see_turn(at, kins[0].place, kins[1].place)
    if contact.normal != OPEN:
        _see_force(con, at, contact, kins, _raced(con, start.v, new.v), slopes, fed, (h, new.clock.hi))
    if new.clock.hi >= vec.number_at(at, UNTIL):
        _mark(stretch, sums, new.clock, kins[1].place)
        _next_stretch(stretch)


@unrolled
def mark_all(stretches, tally, state):
    """Write the current end marks of the running stretches."""
    if not len(stretches):
        return lambda stretches, tally, state: None

    def mark(stretches, tally, state):
        i = len(state.kins) - len(stretches)
        sums = tally.contact_times[i], tally.onsets[i], tally.work.friction[i]
        _mark(stretches[0], sums, state.clock, state.kins[i].place)
        mark_all(stretches[1:], tally, state)

    return mark


@inlined
def _mark(stretch, sums, clock, place):
    at = stretch.running
    vec.store_number(at, END + TIME, clock.hi)
    vec.store_number(at, END + D_Y, place.d_y)
    vec.store_number(at, END + D_Z, place.d_z)
    vec.store_number(at, END + CONTACT_TIME, sums[0])
    vec.store_number(at, END + ONSETS, 1.0 * sums[1])
    vec.store_number(at, END + FRICTION_WORK, sums[2])


@compiled
def _next_stretch(stretch):
    """Copy the running stretch to the finished ones and start the next one where it ended."""
    at, finished = stretch.running, vec.number_at(stretch.running, FINISHED)
    count = _count(stretch.watched)
    row = int(finished) * (N_ROW + N_WATCHED * count)
    for i in range(N_ROW):
        vec.store_number(stretch.rows, row + i, vec.number_at(at, i))
    for i in range(N_WATCHED * count):
        vec.store_number(stretch.rows, row + N_ROW + i, vec.number_at(at, N_STRETCH + i))
    for i in range(count):
        vec.store_number(at, N_STRETCH + N_WATCHED * i + MOST, 0.0)
        _forget_extents(at, N_STRETCH + N_WATCHED * i + WATCHED_EXTENTS)
    for i in range(N_SUMS):
        vec.store_number(at, i, 0.0)
    _forget_extents(at, EXTENTS)
    for i in range(N_MARKS):
        vec.store_number(at, BEGIN + i, vec.number_at(at, END + i))
    vec.store_number(at, ROTOR_LEAST, math.inf)
    vec.store_number(at, FINISHED, finished + 1.0)
    vec.store_number(at, UNTIL, (finished + 2.0) * stretch.length)


@inlined
def _forget_extents(at, i):
    """Reset min and max of y and z."""
    for k in (0, 2):
        vec.store_number(at, i + k, math.inf)
        vec.store_number(at, i + k + 1, -math.inf)
