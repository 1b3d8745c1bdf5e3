"""One step of the Dormand-Prince 5(4) pair for x'' = a(x, x', t), and its fourth-order interpolant.

Coefficients: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19; interpolant as in dopri5 (Hairer, Norsett, Wanner,
Solving Ordinary Differential Equations I). tests/test_kernel.py checks the order conditions of what stands here.
"""

from typing import NamedTuple

from rsc.kernel import vec
from rsc.kernel.jit import inlined
from rsc.kernel.rhs import Powers, accelerations, field
from rsc.kernel.turn import pick, turns_at

C2, C3, C4, C5 = 1 / 5, 3 / 10, 4 / 5, 8 / 9
A21 = 1 / 5
A31, A32 = 3 / 40, 9 / 40
A41, A42, A43 = 44 / 45, -56 / 15, 32 / 9
A51, A52, A53, A54 = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
A61, A62, A63, A64, A65 = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
B1, B3, B4, B5, B6 = 35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
E1, E3, E4, E5, E6, E7 = 71 / 57600, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40
D1, D3, D4 = -12715105075 / 11282082432, 87487479700 / 32700410799, -10690763975 / 1880347072
D5, D6, D7 = 701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423


class Stages(NamedTuple):
    """The slopes of x (velocities) and of v (accelerations) that the interpolant and the error need, all times h."""

    v1: object
    v3: object
    v4: object
    v5: object
    v6: object
    v7: object
    a1: object
    a3: object
    a4: object
    a5: object
    a6: object
    a7: object


class Step(NamedTuple):
    """An attempted step: where it starts, the new state, its stages and the work done by part."""

    x0: object
    v0: object
    x: object
    v: object
    a: object
    powers: object
    kin: object  # contact kinematics at the end where the contact presses
    stages: object
    work: object  # Powers integrated over the step


@inlined
def stage_turns(clock, clock_end, h):
    """Rotations at the stages 2 to 5 and, in lane 4, at the step's end; there by the end's own phase, so that a step that
    starts there finds the same bits."""
    tau = h * vec.from_numbers((C2, C3, C4, C5, 1.0, 0.0, 0.0, 0.0))
    rate = vec.spread(clock.speed_rate, tau)
    speed = vec.spread(clock.speed, tau)
    phase = vec.fma(tau, vec.fma(tau, 0.5 * rate, speed), vec.spread(clock.phase, tau))
    speed = vec.put(vec.fma(tau, rate, speed), 4, clock_end.speed)
    return turns_at(vec.put(phase, 4, clock_end.phase), speed, clock.speed_rate)


@inlined
def _row3(base, c, k):
    """base + c_1 k_1 + c_2 k_2 + c_3 k_3, the newest first so that it is waited for last."""
    return vec.fma(c[0], k[0], vec.fma(c[1], k[1], vec.fma(c[2], k[2], base)))


@inlined
def attempt(con, law, start, turns, h):
    """Step of length h from start = (x, v, a, powers) with the stages' rotations, in one contact mode.

    The stages' accelerations are computed times h, so that every weight of the tableau is a constant.
    """
    x, v, a, p1 = start
    scaled = field(con, law, h)
    v1, a1 = h * v, h * a
    s2, v2 = vec.fma(A21, v1, x), vec.fma(A21, a1, v)
    a2, _, _ = accelerations(con, scaled, s2, v2, pick(turns, 0))
    v2 = h * v2
    s3, v3 = vec.fma(A32, v2, vec.fma(A31, v1, x)), vec.fma(A32, a2, vec.fma(A31, a1, v))
    a3, p3, _ = accelerations(con, scaled, s3, v3, pick(turns, 1))
    v3 = h * v3
    v4 = _row3(v, (A43, A42, A41), (a3, a2, a1))
    s4 = _row3(x, (A43, A42, A41), (v3, v2, v1))
    a4, p4, _ = accelerations(con, scaled, s4, v4, pick(turns, 2))
    v4 = h * v4
    v5 = vec.fma(A54, a4, _row3(v, (A53, A52, A51), (a3, a2, a1)))
    s5 = vec.fma(A54, v4, _row3(x, (A53, A52, A51), (v3, v2, v1)))
    a5, p5, _ = accelerations(con, scaled, s5, v5, pick(turns, 3))
    v5 = h * v5
    v6 = vec.fma(A65, a5, vec.fma(A64, a4, _row3(v, (A63, A62, A61), (a3, a2, a1))))
    s6 = vec.fma(A65, v5, vec.fma(A64, v4, _row3(x, (A63, A62, A61), (v3, v2, v1))))
    end = pick(turns, 4)
    a6, p6, _ = accelerations(con, scaled, s6, v6, end)
    v6 = h * v6
    v_new = vec.fma(B6, a6, vec.fma(B5, a5, _row3(v, (B4, B3, B1), (a4, a3, a1))))
    x_new = vec.fma(B6, v6, vec.fma(B5, v5, _row3(x, (B4, B3, B1), (v4, v3, v1))))
    a_new, p_new, kin = accelerations(con, field(con, law, 1.0), x_new, v_new, end)
    stages = Stages(v1, v3, v4, v5, v6, h * v_new, a1, a3, a4, a5, a6, h * a_new)
    return Step(x, v, x_new, v_new, a_new, p_new, kin, stages, _work(h, p1, p3, p4, p5, p6))


@inlined
def _sum_of(h, p1, p3, p4, p5, p6):
    return (h * B1) * p1 + B3 * p3 + B4 * p4 + B5 * p5 + B6 * p6


@inlined
def _vector_sum_of(h, p1, p3, p4, p5, p6):
    return vec.fma(B6, p6, vec.fma(B5, p5, vec.fma(B4, p4, vec.fma(B3, p3, (h * B1) * p1))))


@inlined
def _work(h, p1, p3, p4, p5, p6):
    """Energies of the step by the fifth-order weights, outside the error norm; all powers but the first are times h."""
    return Powers(
        _vector_sum_of(h, p1.damping, p3.damping, p4.damping, p5.damping, p6.damping),
        _vector_sum_of(h, p1.drive, p3.drive, p4.drive, p5.drive, p6.drive),
        _sum_of(h, p1.contact, p3.contact, p4.contact, p5.contact, p6.contact),
        _sum_of(h, p1.friction, p3.friction, p4.friction, p5.friction, p6.friction),
        _sum_of(h, p1.ring, p3.ring, p4.ring, p5.ring, p6.ring),
    )


@inlined
def _error(k1, k3, k4, k5, k6, k7):
    return vec.fma(E7, k7, vec.fma(E6, k6, vec.fma(E5, k5, vec.fma(E4, k4, vec.fma(E3, k3, E1 * k1)))))


@inlined
def error_square(con, x, v, s):
    """Square of the error norm: the largest |error_i|^2 / (rtol^2 (scale_i^2 + |value_i|^2)) over the complex coordinates.

    y and z enter as the sum of a pair, the coordinates as a maximum: a turn of the frame by 90 degrees changes no bit.
    The values are those at the start, so that the divisions are done before the errors are known.
    """
    one = vec.spread(con.per_rtol2, x)
    weight_x = one / (con.scale_x + pair_square(x))
    weight_v = one / (con.scale_v + pair_square(v))
    e_x = _error(s.v1, s.v3, s.v4, s.v5, s.v6, s.v7)
    e_v = _error(s.a1, s.a3, s.a4, s.a5, s.a6, s.a7)
    return vec.largest(vec.larger(pair_square(e_x) * weight_x, pair_square(e_v) * weight_v))


@inlined
def pair_square(a):
    """y^2 + z^2 on both lanes of every pair."""
    square = a * a
    return square + vec.swap(square)


@inlined
def size_square(x):
    """Largest |x_i|^2 over the complex coordinates, NaN when there is one."""
    return vec.largest(pair_square(x))


@inlined
def interpolate(step, theta):
    """(x, v) inside an accepted step at theta in [0, 1]."""
    s = step.stages
    x = _quartic(step.x0, step.x, (s.v1, s.v3, s.v4, s.v5, s.v6, s.v7), theta)
    return x, _quartic(step.v0, step.v, (s.a1, s.a3, s.a4, s.a5, s.a6, s.a7), theta)


@inlined
def _quartic(y0, y1, k, theta):
    rest = 1.0 - theta
    rise = y1 - y0
    bend = k[0] - rise
    twist = rise - k[5] - bend
    last = vec.fma(D5, k[3], vec.fma(D4, k[2], vec.fma(D3, k[1], D1 * k[0])))
    last = vec.fma(D7, k[5], vec.fma(D6, k[4], last))
    inner = vec.fma(theta, vec.fma(rest, last, twist), bend)
    return vec.fma(theta, vec.fma(rest, inner, rise), y0)
