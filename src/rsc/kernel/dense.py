"""The motion inside a step: dopri5's interpolant of order 4, one of order 6 with the acceleration at the middle, or a series."""

from typing import NamedTuple

from rsc.kernel.clock import turn_inside
from rsc.kernel.rhs import accelerations, field, no_powers, place_at
from rsc.kernel.simd import vec
from rsc.kernel.simd.fused import fused
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.tableau import positions_of, table_of


class Quartics(NamedTuple):
    """x and v by separate quartics y0 + theta (rise + rest (bend + theta (twist + rest last))), rest = 1 - theta."""

    x: object  # (y0, rise, bend, twist, last)
    v: object


class Sextic(NamedTuple):
    """x = c0 + theta (c1 + rest (c2 + theta (c3 + rest (c4 + theta (c5 + rest c6))))), v its derivative.

    It meets x, v and a at both ends and a at the middle. There a is taken at the quintic of the end values, whose velocity is of
    one order more there than elsewhere: x and h v are left with errors O(h^7), the order of the Verner pair's global error.
    """

    c: object  # c0 .. c6
    per_h: float  # 1/s


class Series(NamedTuple):
    """x and v by their Taylor coefficients."""

    x: object
    v: object


@unrolled
def dense_of(con, law, path, stages):
    """Polynomials of an attempted step, in the mode of `law`."""
    table = table_of(stages)
    if table is None:
        terms = len(stages) + 1
        return lambda con, law, path, stages: Series(path.step.slopes[:terms], path.step.slopes[terms:])
    if table.dense:
        of_x, of_v = vec.weighted_sum(positions_of(table).dense), vec.weighted_sum(table.dense)

        @fused(8)
        def polynomials(h, begin, end, slopes):
            x = _quartic(begin[0], end[0], h * begin[1], h * end[1])
            v = _quartic(begin[1], end[1], slopes[0], slopes[-1])
            return *x, h * of_x(None, slopes), *v, of_v(None, slopes)

        def quartics(con, law, path, stages):
            s = path.step
            c = polynomials(path.h, (s.x0, s.v0), (s.x, s.v), s.slopes)
            return Quartics((s.x0, *c[:4]), (s.v0, *c[4:]))

        return quartics
    return lambda con, law, path, stages: _sextic(con, law, path)


@unrolled
def extra_calls(stages):
    """Right-hand sides that `dense_of` calls."""
    table = table_of(stages)
    calls = 1 if table and not table.dense else 0
    return lambda stages: calls


@fused(3)
def _quartic(y0, y1, slope0, slope1):
    rise = y1 - y0
    bend = slope0 - rise
    return rise, bend, rise - slope1 - bend


@inlined
def _sextic(con, law, path):
    s, h = path.step, path.h
    c1 = s.x - s.x0
    c2 = h * s.v0 - c1
    c3 = c1 - h * s.v - c2
    c4 = vec.fma(0.5 * h, s.slopes[0], c2 - c3)
    c5 = vec.fma(0.5 * h, s.slopes[-1], vec.fma(2.0, c3, c2 - c4))
    x = s.x0 + vec.fma(0.5, c1, vec.fma(0.25, c2, vec.fma(0.125, c3, vec.fma(0.0625, c4, 0.03125 * c5))))
    v = (1.0 / h) * vec.fma(0.25, c3, vec.fma(0.0625, c5, c1))
    turn = turn_inside(path.clock, 0.5 * h)
    d, d_dot = vec.product(con.contact_row, x), vec.product(con.contact_row, v)
    a, _ = accelerations(con, field(con, law, h), (x, v, d_dot), turn, place_at(con, law, d, turn), 0.0, no_powers(h))
    c6 = (-8.0 / 3.0) * vec.fma(h, a, vec.fma(2.0, c2, vec.fma(0.5, c5, c3 + c4)))
    return Sextic((s.x0, c1, c2, c3, c4, c5, c6), 1.0 / h)


@unrolled
def interpolate(dense, theta):
    """(x, v) inside a step at theta in [0, 1]."""
    if dense.instance_class is Series:
        return lambda dense, theta: (_horner(dense.x, theta), _horner(dense.v, theta))
    if dense.instance_class is Quartics:
        return lambda dense, theta: (_nested(dense.x, theta), _nested(dense.v, theta))
    return lambda dense, theta: _value_and_rate(dense, theta)


@unrolled
def _horner(c, theta):
    """Value of a series by its coefficients."""
    if len(c) == 1:
        return lambda c, theta: c[0]
    return lambda c, theta: vec.fma(theta, _horner(c[1:], theta), c[0])


@inlined
def _nested(c, theta):
    rest = 1.0 - theta
    inner = vec.fma(theta, vec.fma(rest, c[4], c[3]), c[2])
    return vec.fma(theta, vec.fma(rest, inner, c[1]), c[0])


@inlined
def _value_and_rate(dense, theta):
    c, rest = dense.c, 1.0 - theta
    p5 = vec.fma(rest, c[6], c[5])
    p4 = vec.fma(theta, p5, c[4])
    p3 = vec.fma(rest, p4, c[3])
    p2 = vec.fma(theta, p3, c[2])
    p1 = vec.fma(rest, p2, c[1])
    d4 = vec.fma(-theta, c[6], p5)
    d3 = vec.fma(rest, d4, (-1.0) * p4)
    d2 = vec.fma(theta, d3, p3)
    d1 = vec.fma(rest, d2, (-1.0) * p2)
    return vec.fma(theta, p1, c[0]), dense.per_h * vec.fma(theta, d1, p1)
