"""One step of the Dormand-Prince 5(4) pair for x'' = a(x, x', t), and its fourth-order interpolant.

Coefficients: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19; interpolant as in dopri5 (Hairer, Norsett, Wanner,
Solving Ordinary Differential Equations I). tests/test_kernel.py checks the order conditions of what stands here.
"""

from typing import NamedTuple

from rsc.kernel import vec
from rsc.kernel.jit import inlined
from rsc.kernel.rhs import Powers, accelerations, turn_ahead

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
    """The slopes of x (velocities) and of v (accelerations) that the interpolant and the error need."""

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
    """An attempted step: the new state, its stages and the work done by part."""

    x: object
    v: object
    stages: object
    work: object  # Powers integrated over the step


@inlined
def _row3(h, base, c, k):
    """base + h (c_1 k_1 + c_2 k_2 + c_3 k_3)."""
    return vec.fma(h * c[0], k[0], vec.fma(h * c[1], k[1], vec.fma(h * c[2], k[2], base)))


@inlined
def attempt(con, columns, law, start, turns, h):
    """Step of length h from start = (x, v, a, powers) between turns = (at the start, at the end), in one contact mode."""
    x, v, a1, p1 = start
    turn, turn_end = turns
    a2, _ = accelerations(
        con, columns, law, vec.fma(h * A21, v, x), vec.fma(h * A21, a1, v), turn_ahead(turn, C2 * h)
    )
    v2 = vec.fma(h * A21, a1, v)
    v3 = vec.fma(h * A32, a2, vec.fma(h * A31, a1, v))
    x3 = vec.fma(h * A32, v2, vec.fma(h * A31, v, x))
    a3, p3 = accelerations(con, columns, law, x3, v3, turn_ahead(turn, C3 * h))
    v4 = _row3(h, v, (A43, A42, A41), (a3, a2, a1))
    x4 = _row3(h, x, (A43, A42, A41), (v3, v2, v))
    a4, p4 = accelerations(con, columns, law, x4, v4, turn_ahead(turn, C4 * h))
    v5 = vec.fma(h * A54, a4, _row3(h, v, (A53, A52, A51), (a3, a2, a1)))
    x5 = vec.fma(h * A54, v4, _row3(h, x, (A53, A52, A51), (v3, v2, v)))
    a5, p5 = accelerations(con, columns, law, x5, v5, turn_ahead(turn, C5 * h))
    v6 = vec.fma(h * A65, a5, vec.fma(h * A64, a4, _row3(h, v, (A63, A62, A61), (a3, a2, a1))))
    x6 = vec.fma(h * A65, v5, vec.fma(h * A64, v4, _row3(h, x, (A63, A62, A61), (v3, v2, v))))
    a6, p6 = accelerations(con, columns, law, x6, v6, turn_end)
    v7 = vec.fma(h * B6, a6, vec.fma(h * B5, a5, _row3(h, v, (B4, B3, B1), (a4, a3, a1))))
    x7 = vec.fma(h * B6, v6, vec.fma(h * B5, v5, _row3(h, x, (B4, B3, B1), (v4, v3, v))))
    a7, p7 = accelerations(con, columns, law, x7, v7, turn_end)
    stages = Stages(v, v3, v4, v5, v6, v7, a1, a3, a4, a5, a6, a7)
    return Step(x7, v7, stages, _work(h, p1, p3, p4, p5, p6)), a7, p7


@inlined
def _work(h, p1, p3, p4, p5, p6):
    """Energies of the step by the fifth-order weights, outside the error norm."""
    h1, h3, h4, h5, h6 = h * B1, h * B3, h * B4, h * B5, h * B6
    damping = h1 * p1.damping + h3 * p3.damping + h4 * p4.damping + h5 * p5.damping + h6 * p6.damping
    drive = h1 * p1.drive + h3 * p3.drive + h4 * p4.drive + h5 * p5.drive + h6 * p6.drive
    return Powers(
        damping,
        drive,
        h1 * p1.contact + h3 * p3.contact + h4 * p4.contact + h5 * p5.contact + h6 * p6.contact,
        h1 * p1.friction + h3 * p3.friction + h4 * p4.friction + h5 * p5.friction + h6 * p6.friction,
        h1 * p1.ring + h3 * p3.ring + h4 * p4.ring + h5 * p5.ring + h6 * p6.ring,
    )


@inlined
def _error(h, k1, k3, k4, k5, k6, k7):
    total = vec.fma(E6, k6, vec.fma(E5, k5, vec.fma(E4, k4, vec.fma(E3, k3, E1 * k1))))
    return h * vec.fma(E7, k7, total)


@inlined
def error_square(con, x, s, h):
    """Square of the error norm: the largest |error_i|^2 / (rtol^2 (scale_i^2 + |value_i|^2)) over the complex coordinates.

    y and z enter as the sum of a pair, the coordinates as a maximum: a turn of the frame by 90 degrees changes no bit.
    """
    e_x = _error(h, s.v1, s.v3, s.v4, s.v5, s.v6, s.v7)
    e_v = _error(h, s.a1, s.a3, s.a4, s.a5, s.a6, s.a7)
    ratio_x = _pair_square(e_x) / (con.scale_x + _pair_square(x))
    ratio_v = _pair_square(e_v) / (con.scale_v + _pair_square(s.v1))
    top_x, top_v = vec.largest(ratio_x), vec.largest(ratio_v)
    top = top_x if top_x >= top_v or top_x != top_x else top_v
    return top * con.per_rtol2


@inlined
def _pair_square(a):
    """y^2 + z^2 on both lanes of every pair."""
    square = a * a
    return square + vec.swap(square)


@inlined
def interpolate(x0, x1, s, h, theta):
    """(x, v) inside an accepted step at theta in [0, 1]."""
    x = _quartic(x0, x1, h, (s.v1, s.v3, s.v4, s.v5, s.v6, s.v7), theta)
    return x, _quartic(s.v1, s.v7, h, (s.a1, s.a3, s.a4, s.a5, s.a6, s.a7), theta)


@inlined
def _quartic(y0, y1, h, k, theta):
    rest = 1.0 - theta
    rise = y1 - y0
    bend = vec.fma(h, k[0], -1.0 * rise)
    twist = rise - vec.fma(h, k[5], bend)
    last = vec.fma(D5, k[3], vec.fma(D4, k[2], vec.fma(D3, k[1], D1 * k[0])))
    last = h * vec.fma(D7, k[5], vec.fma(D6, k[4], last))
    inner = vec.fma(theta, vec.fma(rest, last, twist), bend)
    return vec.fma(theta, vec.fma(rest, inner, rise), y0)
