"""One step of x'' = a(x, x', t) by a Runge-Kutta pair or a Taylor series, with its error estimate and data for dense output.

`method` is a tuple whose length selects one of `tableau.METHODS`: code that depends on it is unrolled at compile time, and every
weight becomes a constant.
"""

from typing import NamedTuple

from rsc.kernel import series, springs
from rsc.kernel.clock import angle_reached, driven_turn, reached, turn_of, turns_after
from rsc.kernel.contact_forces import contact_kinematics, motions, over_time, places_anyhow, places_at, rows_times
from rsc.kernel.losses import first_share, lost_until
from rsc.kernel.questions import is_driven, is_none, is_one
from rsc.kernel.rhs import Field, Powers, accelerations, field_itself, no_powers, with_share
from rsc.kernel.series import Series
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import static
from rsc.kernel.turn import pick
from rsc.kernel.weights import (
    all_known,
    at_end,
    by_series,
    error_of_v,
    error_of_x,
    inner_nodes,
    lane_of_next,
    node_after_next,
    position_sum,
    velocity_sum,
    weight_of_next,
)


class Step(NamedTuple):
    """An attempted step: initial state, final state, slopes, and the work done, by cause."""

    x0: object
    v0: object
    x: object
    v: object
    a: object
    powers: object
    kins: tuple  # kinematics of each contact at the end
    slopes: object  # h times the accelerations of the s stages and of the end; or the Taylor `Series`
    work: object  # Powers integrated from the start of the run to the end of the step
    clock: object  # at its end


class Instant(NamedTuple):
    """Clock data that a Taylor series needs at its start."""

    turn: object
    following: tuple  # `clock.Segment`
    torque: tuple  # `clock.Clock`
    states: tuple  # `clock.Segment`


class Turns(NamedTuple):
    """The Turns of the stages: `inside` the step as vectors, and at its `end`."""

    inside: object
    end: object


@static
def _stage_turns(con, clock, clock_end, h, method, pattern):
    """The Turns at the nodes, in registers like those of `pattern`, and at the end of the step; for an integrated speed, whose
    rotation follows from the stages, the clock."""
    if is_driven(con):
        return clock
    inside = vec.from_numbers(inner_nodes(method), pattern)
    return Turns(turns_after(clock, h * inside), turn_of(clock_end))


@static
def _turn_at(con, turns, method, slopes, x, v):
    """The Turn at the next stage, after those whose slopes are known, or at the end of the step, with state (x, v)."""
    if is_driven(con):
        return driven_turn(con, turns, x, v)
    return turns.end if at_end(method, slopes) else pick(turns.inside, lane_of_next(method, slopes))


@static
def attempt(con, laws, start, before, clock_end, h, method):
    """Step of length h from State `start` to `clock_end`, with the contact states fixed; before: work up to its start."""
    if by_series(method):
        return _series_step(con, laws, start, before, clock_end, h, method)
    return _pair_step(con, laws, start, before, clock_end, h, method)


@inlined
def _expanded(con, laws, places, instant, begin, h, method):
    """`series` of a step: separate code for each contact state, which avoids multiplications by zero; with several contacts those
    that are open, undamped or not creeping add zeros."""
    if not pressed_in(laws):
        return series.free(con, laws, places, instant, begin, h, method)
    if _any_creeps(laws):
        return _creeping(con, laws, places, instant, begin, h, method)
    if _any_damps(laws):
        return series.damped(con, laws, places, instant, begin, h, method)
    return series.sliding(con, laws, places, instant, begin, h, method)


@static
def _creeping(con, laws, places, instant, begin, h, method):
    """`series` of a step in which the friction of a contact depends on the slip (creeping)."""
    if is_one(laws):
        return series.creeping(con, laws, places, instant, begin, h, method)
    return series.together(con, laws, places, instant, begin, h, method)


@static
def pressed_in(laws):
    """Whether any contact is closed with a nonzero spring force."""
    if is_none(laws):
        return False
    return laws[0].spring.k > 0.0 or pressed_in(laws[1:])


@static
def _any_creeps(laws):
    """Whether any contact creeps."""
    return False if is_none(laws) else laws[0].mu_slope != 0.0 or _any_creeps(laws[1:])


@static
def _any_damps(laws):
    """Whether the damper of any contact acts."""
    return False if is_none(laws) else laws[0].b > 0.0 or _any_damps(laws[1:])


@static
def _places_of(kins):
    return () if is_none(kins) else (kins[0].place,) + _places_of(kins[1:])


@static
def _lost_in(laws, kins, kins_new, normal, before):
    """Energy dissipated by the contact dampers, added to `before`; normal: work against the normal forces."""
    if is_none(laws):
        return ()
    p_0, p_1, law = kins[0].place.penetration, kins_new[0].place.penetration, laws[0]
    # F_N = F(p) + b p': of the work against F_N the spring part is stored, the rest is dissipated
    lost = normal[0] - springs.power(law.spring, p_1, p_0) if law.b > 0.0 else 0.0
    return (before[0] + lost,) + _lost_in(laws[1:], kins[1:], kins_new[1:], normal[1:], before[1:])


@static
def _with_each(more, before):
    """Elementwise sum of two tuples."""
    if is_none(more):
        return ()
    return (before[0] + more[0],) + _with_each(more[1:], before[1:])


@inlined
def _series_step(con, laws, start, before, clock_end, h, method):
    """One step by Taylor series."""
    clock, begin = start.clock, (start.x, start.v)
    instant = Instant(turn_of(clock), clock.following, clock.torque, clock.states)
    e = _expanded(con, laws, _places_of(start.kins), instant, begin, h, method)
    x_k, v_k, x, v, a, damping, drive, friction, normal, ring, rotating, by_speed, control, spin = e
    end = reached(con, start.clock, clock_end, x, v)
    kins = contact_kinematics(con.contacts, x, v, turn_of(end))
    lost = _lost_in(laws, start.kins, kins, normal, before.contact)
    friction, ring = _with_each(friction, before.friction), _with_each(ring, before.ring)
    damping, drive, rotating = before.damping + damping, before.drive + drive, with_share(1.0, rotating, before.rotating)
    by_speed, spin = with_share(1.0, by_speed, before.following), with_share(1.0, spin, before.spin)
    control = with_share(1.0, control, before.control)
    work = Powers(damping, drive, lost, friction, ring, rotating, by_speed, spin, control)
    return Step(start.x, start.v, x, v, a, start.powers, kins, Series(x_k, v_k), work, end)


@inlined
def _pair_step(con, laws, start, before, clock_end, h, method):
    """One step by a Runge-Kutta pair: accelerations of the stages are computed times h, so that all weights are constants."""
    begin, turns = (start.x, start.v), _stage_turns(con, start.clock, clock_end, h, method, start.x)
    field_h, slopes, work, x, d = begun(con, laws, start, before, h, method)
    ahead = x, (), _next_places(con, field_h.laws, d, turns, method, slopes, x)
    slopes, work, ahead = _other_stages(con, field_h, begin, turns, method, slopes, ahead, work)
    # the slope at the end, at x and v of the solution, is the first slope of the next step (first same as last)
    (x, mean, places), v = ahead, velocity_sum(method, begin[1], slopes)
    d_dot = rows_times(con.contacts, v)
    end = reached(con, start.clock, clock_end, x, v)
    turn, field = _end_turn(con, turns, end), field_itself(con, laws, start.clock)
    a, powers = accelerations(con, field, (x, v, d_dot), turn, places, 1.0, no_powers(con))
    kins, slopes = motions(con.contacts, v, d_dot, places, turn), slopes + (h * a,)
    damping = lost_until(con, field_h, before.damping, work.damping, (begin[1], mean, v), slopes)
    w = work
    work = Powers(damping, w.drive, w.contact, w.friction, w.ring, w.rotating, w.following, w.spin, w.control)
    return Step(*begin, x, v, a, powers, kins, slopes, work, end)


@static
def _end_turn(con, turns, end):
    """The Turn at the end of a step, where the clock is `end`."""
    return turn_of(end) if is_driven(con) else turns.end


@static
def with_shares(part, powers, sums):
    """sums + part * powers, for each contact."""
    if is_none(sums):
        return ()
    return (vec.fma(part, powers[0], sums[0]),) + with_shares(part, powers[1:], sums[1:])


@static
def _with_ring_shares(contacts, part, powers, sums):
    """`with_shares` for the contacts that have an eccentric ring."""
    if is_none(sums):
        return ()
    ring = vec.fma(part, powers[0], sums[0]) if contacts[0].has_ring else sums[0]
    return (ring,) + _with_ring_shares(contacts[1:], part, powers[1:], sums[1:])


@inlined
def begun(con, laws, start, before, h, method):
    """(field times h, slopes, work, x of the next stage, its product with the contact rows) after the first stage of a step."""
    # the order of statements is the order of execution: first what the next stage waits for, the ledger last; reversed, P1
    # takes 4 % longer
    weight, node = weight_of_next(method, ()), node_after_next(method, ())
    p, part, clock = start.powers, h * weight, start.clock
    parts = h * con.stiffness, h * con.damping, over_time(laws, h)
    field_h = Field(h, parts[0], parts[1], parts[2], clock.following, clock.torque, clock.states)
    slope = h * start.a
    x = vec.fma(h, node * start.v, start.x)
    d = rows_times(con.contacts, x)
    lost, fed = with_shares(part, p.contact, before.contact), with_shares(part, p.friction, before.friction)
    ring = _with_ring_shares(con.contacts, part, p.ring, before.ring)
    rotating, following = with_share(part, p.rotating, before.rotating), with_share(part, p.following, before.following)
    spin, control = with_share(part, p.spin, before.spin), with_share(part, p.control, before.control)
    damping, drive = first_share(con, start, h, weight), vec.fma(part, p.drive, before.drive)
    work = Powers(damping, drive, lost, fed, ring, rotating, following, spin, control)
    return field_h, (slope,), work, x, d


@static
def _end_angle(con, turns, x):
    """The Turn at the end of a step with coordinates x as far as contact places need it, with the same bits as a run that
    continues from there."""
    return angle_reached(con, turns, x) if is_driven(con) else turns.end


@static
def _next_places(con, laws, d, turns, method, slopes, x):
    """Places of the closed contacts at the next stage, with coordinates x, or of all contacts at the end of the step."""
    if all_known(method, slopes):
        return places_anyhow(con.contacts, d, _end_angle(con, turns, x))
    # only the rotation angle is needed, which x contains
    return places_at(con.contacts, laws, d, _turn_at(con, turns, method, slopes, x, x))


@static
def _other_stages(con, field_h, start, turns, method, slopes, ahead, work):
    """(slopes, work, position and places at the end) after the remaining stages, by recursion."""
    if all_known(method, slopes):
        return slopes, work, ahead
    x, _, places = ahead
    v = velocity_sum(method, start[1], slopes)
    d_dot = rows_times(con.contacts, v)
    # the known slopes determine the position one stage further ahead, which waits for less than the acceleration here
    mean = position_sum(method, node_after_next(method, slopes) * start[1], slopes)
    x_next = vec.fma(field_h.time, mean, start[0])
    places_next = _next_places(con, field_h.laws, rows_times(con.contacts, x_next), turns, method, slopes + (v,), x_next)
    turn = _turn_at(con, turns, method, slopes, x, v)
    a, work = accelerations(con, field_h, (x, v, d_dot), turn, places, weight_of_next(method, slopes), work)
    return _other_stages(con, field_h, start, turns, method, slopes + (a,), (x_next, mean, places_next), work)


@inlined
def error_square(con, step, h, method):
    """Square of the error norm: the largest |error_i|^2 / (rtol^2 (scale_i^2 + |value_i|^2)) over the complex coordinates.

    y and z enter as the sum of a pair, the coordinates as a maximum: rotating the frame by 90 degrees changes no bit. The values
    are those at the start, so that the division is done before the errors are known, one for x and v together: the first
    component of a pair then belongs to the displacement, the second to the velocity.
    """
    # first: a division takes as long as the products of several stages, and does not depend on the result of the step
    weight = error_weight(con, step.x0, step.v0)
    e_x, e_v = _errors(method, h, step.slopes)
    return weighed_square(e_x, e_v, weight)


@inlined
def error_weight(con, x, v):
    """What squares of errors are multiplied with, see `error_square`."""
    return vec.spread(con.per_rtol2, x) / (con.scale + vec.pair_sums(x * x, v * v))


@inlined
def weighed_square(e_x, e_v, weight):
    """The largest square of errors of x and v, weighed."""
    worst = vec.pair_sums(e_x * e_x, e_v * e_v) * weight
    return vec.largest(vec.larger(worst, vec.swap(worst)))


@static
def _errors(method, h, slopes):
    """Estimated errors of x and v: by the weights of a Runge-Kutta pair, or the last terms of a series."""
    if by_series(method):
        return slopes.x[-1], slopes.v[-1]
    return h * error_of_x(method, None, slopes), error_of_v(method, None, slopes)


@inlined
def pair_square(a):
    """y^2 + z^2 on both lanes of every pair."""
    square = a * a
    return square + vec.swap(square)


@inlined
def size_square(x):
    """Largest |x_i|^2 over the complex coordinates, NaN if any is NaN."""
    return vec.largest(pair_square(x))
