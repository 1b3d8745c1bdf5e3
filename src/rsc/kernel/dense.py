"""The motion inside a step: dopri5's interpolant of order 4, or a series."""

from typing import NamedTuple

from rsc.kernel.simd import vec
from rsc.kernel.simd.fused import fused
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.tableau import positions_of, table_of


class Quartics(NamedTuple):
    """x and v by separate quartics y0 + theta (rise + rest (bend + theta (twist + rest last))), rest = 1 - theta."""

    x: object  # (y0, rise, bend, twist, last)
    v: object


class Series(NamedTuple):
    """x and v by their Taylor coefficients."""

    x: object
    v: object


@unrolled
def dense_of(path, method):
    """Polynomials of an attempted step."""
    table = table_of(method)
    if table is None:
        terms = len(method) + 1
        return lambda path, method: Series(path.step.slopes[:terms], path.step.slopes[terms:])
    of_x, of_v = vec.weighted_sum(positions_of(table).dense), vec.weighted_sum(table.dense)

    @fused(8)
    def polynomials(h, begin, end, slopes):
        x = _quartic(begin[0], end[0], h * begin[1], h * end[1])
        v = _quartic(begin[1], end[1], slopes[0], slopes[-1])
        return *x, h * of_x(None, slopes), *v, of_v(None, slopes)

    def quartics(path, method):
        s = path.step
        c = polynomials(path.h, (s.x0, s.v0), (s.x, s.v), s.slopes)
        return Quartics((s.x0, *c[:4]), (s.v0, *c[4:]))

    return quartics


@fused(3)
def _quartic(y0, y1, slope0, slope1):
    rise = y1 - y0
    bend = slope0 - rise
    return rise, bend, rise - slope1 - bend


@unrolled
def interpolate(dense, theta):
    """(x, v) inside a step at theta in [0, 1]."""
    if dense.instance_class is Series:
        return lambda dense, theta: (_horner(dense.x, theta), _horner(dense.v, theta))
    return lambda dense, theta: (_nested(dense.x, theta), _nested(dense.v, theta))


@unrolled
def _horner(c, theta):
    """Value of a series by its coefficients."""
    if len(c) == 1:
        return lambda c, theta: c[0]
    return lambda c, theta: vec.fma(theta, _horner(c[1:], theta), c[0])


@inlined
def _nested(c, theta):
    left = 1.0 - theta
    inner = vec.fma(theta, vec.fma(left, c[4], c[3]), c[2])
    return vec.fma(theta, vec.fma(left, inner, c[1]), c[0])
