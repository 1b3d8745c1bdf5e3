"""One step for x'' = a(x, x', t) by a Runge-Kutta pair or a Taylor series, its error, and what the motion inside it needs.

The method comes as `stages`, a tuple whose length names one of `tableau.METHODS`: what depends on it is unrolled while compiling,
and every weight becomes a constant.
"""

from typing import NamedTuple

from rsc.kernel import series, vec
from rsc.kernel.cases import choose, some
from rsc.kernel.clock import contact_turn, turn_of
from rsc.kernel.fused import fused
from rsc.kernel.jit import inlined, unrolled
from rsc.kernel.rhs import Powers, accelerations, contact_kinematics, field, no_powers, place_at
from rsc.kernel.tableau import table_of
from rsc.kernel.turn import pick, turns_at

END = 7  # lane of the rotation at the step's end


class Step(NamedTuple):
    """An attempted step: where it starts, the new state, its slopes and the work done by part."""

    x0: object
    v0: object
    a0: object
    x: object
    v: object
    a: object
    powers: object
    kin: object  # contact kinematics at the end where the contact presses
    v_slopes: object  # s + 1 vectors: h times the velocities of the stages and of the end, or the series of x
    a_slopes: object  # h times the accelerations, or the series of v
    work: object  # Powers integrated over the step


def _nodes_of(table):
    """Nodes inside the step, each with a rotation of its own."""
    return sorted(set(table.nodes[1:]) - {1.0})


@unrolled
def _nodes(stages, like):
    nodes = _nodes_of(table_of(stages))
    padded = (*nodes, *(0.0,) * (END - len(nodes)), 1.0)
    return lambda stages, like: vec.from_numbers(padded, like)


@inlined
def stage_turns(clock, clock_end, h, stages, like):
    """Rotations at the nodes and, in lane END, at the step's end; there by the end's own phase, so that a step that starts there
    finds the same bits; in registers as those of `like`."""
    tau = h * _nodes(stages, like)
    rate = vec.spread(clock.speed_rate, tau)
    speed = vec.spread(clock.speed, tau)
    phase = vec.fma(tau, vec.fma(tau, 0.5 * rate, speed), vec.spread(clock.phase, tau))
    speed = vec.put(vec.fma(tau, rate, speed), END, clock_end.speed)
    return turns_at(vec.put(phase, END, clock_end.phase), speed, clock.speed_rate)


@unrolled
def attempt(con, law, start, clock_end, h, stages):
    """Step of length h from a State to the clock at its end, in one contact mode."""
    step = _series_step if table_of(stages) is None else _pair_step
    return lambda con, law, start, clock_end, h, stages: step(con, law, start, clock_end, h, stages)


@inlined
def _series_step(con, law, start, clock_end, h, stages):
    """By Taylor series."""
    turn, place, begin = turn_of(start.clock), start.kin.place, (start.x, start.v)
    separating = law.b > 0.0
    if not some(law.k > 0.0):
        e = series.free(con, law, place, turn, begin, h, stages)
    elif some(law.mu_slope != 0.0):
        e = series.creeping(con, law, place, turn, begin, h, stages)
    elif some(separating):
        e = series.damped(con, law, place, turn, begin, h, stages)
    else:
        e = series.sliding(con, law, place, turn, begin, h, stages)
    x_k, v_k, x, v, a, damping, drive, friction, normal, ring = e
    kin = contact_kinematics(con, x, v, contact_turn(con, clock_end, 0.0))
    p_0, p_1 = place.penetration, kin.place.penetration
    lost = choose(separating, normal - 0.5 * law.k * (p_1 * p_1 - p_0 * p_0), 0.0 * h)
    work = Powers(damping, drive, lost, friction, ring)
    return Step(start.x, start.v, start.a, x, v, a, start.powers, kin, x_k, v_k, work)


@inlined
def _pair_step(con, law, start, clock_end, h, stages):
    """By a pair: the stages' accelerations are computed times h, so that every weight of the table is a constant."""
    x, v, a, powers = start.x, start.v, start.a, start.powers
    turns = stage_turns(start.clock, clock_end, h, stages, x)
    work = _first_work(stages, h, powers)
    scaled, slopes = field(con, law, h), ((h * v,), (h * a,))
    ahead = _next_place(con, scaled.law, x, turns, stages, slopes[0])
    v_slopes, a_slopes, work, ahead = _other_stages(con, scaled, (x, v), turns, stages, slopes, ahead, work)
    v_new, (x_new, place) = _solution(stages, v, a_slopes), ahead
    none = no_powers(x, con.unbalance, h)
    a_new, kin, p_new = accelerations(con, field(con, law, 1.0), x_new, v_new, pick(turns, END), place, 1.0, none)
    return Step(x, v, a, x_new, v_new, a_new, p_new, kin, v_slopes + (h * v_new,), a_slopes + (h * a_new,), work)  # noqa: RUF005


@unrolled
def _first_work(stages, h, powers):
    weight = table_of(stages).weights[0]
    return lambda stages, h, powers: _times(h * weight, powers)


@unrolled
def _next_place(con, law, start, turns, stages, v_slopes):
    """(x, place of the contact) of the stage after those whose velocities are known, or of the step's end."""
    table, i = table_of(stages), len(v_slopes)
    at_end = i == len(table.nodes)
    row, lane = vec.weighted_sum(table.weights if at_end else table.rows[i - 1]), END if at_end else _lane_of(table, i)

    def next_place(con, law, start, turns, stages, v_slopes):
        x = row(start, v_slopes)
        return x, place_at(con, law, x, pick(turns, lane))

    return next_place


def _lane_of(table, i):
    """Lane of the rotation at stage i."""
    return END if table.nodes[i] == 1.0 else _nodes_of(table).index(table.nodes[i])


@unrolled
def _other_stages(con, scaled, start, turns, stages, slopes, ahead, work):
    """(v_slopes, a_slopes, work, what comes next) with one stage more, and so on to the last."""
    table, i = table_of(stages), len(slopes[0])
    if i == len(table.nodes):
        return lambda con, scaled, start, turns, stages, slopes, ahead, work: (*slopes, work, ahead)
    row, weight, lane = vec.weighted_sum(table.rows[i - 1]), table.weights[i], _lane_of(table, i)

    def one_more(con, scaled, start, turns, stages, slopes, ahead, work):
        v, (x, place) = row(start[1], slopes[1]), ahead
        v_slopes = slopes[0] + (scaled.time * v,)
        ahead = _next_place(con, scaled.law, start[0], turns, stages, v_slopes)
        mark = vec.mark(x)
        a, _, work = accelerations(con, scaled, x, v, pick(turns, lane), place, weight, work)
        a = vec.moved(x, a)
        vec.release(x, mark)
        return _other_stages(con, scaled, start, turns, stages, (v_slopes, slopes[1] + (a,)), ahead, work)

    return one_more


@unrolled
def _solution(stages, start, slopes):
    row = vec.weighted_sum(table_of(stages).weights)
    return lambda stages, start, slopes: row(start, slopes)


@inlined
def _times(weight, p):
    damping, drive = _scaled(weight, p.damping, p.drive)
    return Powers(damping, drive, weight * p.contact, weight * p.friction, weight * p.ring)


@fused(2)
def _scaled(weight, damping, drive):
    return weight * damping, weight * drive


@unrolled
def _error(stages, slopes):
    table = table_of(stages)
    if table is None:
        return lambda stages, slopes: slopes[-1]
    row = vec.weighted_sum(table.error)
    return lambda stages, slopes: row(None, slopes)


@inlined
def error_square(con, step, stages):
    """Square of the error norm: the largest |error_i|^2 / (rtol^2 (scale_i^2 + |value_i|^2)) over the complex coordinates.

    y and z enter as the sum of a pair, the coordinates as a maximum: a turn of the frame by 90 degrees changes no bit.
    The values are those at the start, so that the divisions are done before the errors are known.
    """
    weight_x, weight_v = _weights(con.per_rtol2, con.scale_x, step.x0, con.scale_v, step.v0)
    e_x, e_v = _error(stages, step.v_slopes), _error(stages, step.a_slopes)
    return vec.largest(_worse(e_x, weight_x, e_v, weight_v))


@fused(2)
def _weights(per_rtol2, scale_x, x, scale_v, v):
    one = vec.spread(per_rtol2, x)
    return one / (scale_x + pair_square(x)), one / (scale_v + pair_square(v))


@fused()
def _worse(e_x, weight_x, e_v, weight_v):
    return vec.larger(pair_square(e_x) * weight_x, pair_square(e_v) * weight_v)


@fused()
def pair_square(a):
    """y^2 + z^2 on both lanes of every pair."""
    square = a * a
    return square + vec.swap(square)


@inlined
def size_square(x):
    """Largest |x_i|^2 over the complex coordinates, NaN when there is one."""
    return vec.largest(pair_square(x))
