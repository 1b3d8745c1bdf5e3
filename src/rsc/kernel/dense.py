"""Dense output, the motion inside a step: dopri5's interpolant of order 4, or the Taylor series."""

from typing import NamedTuple

from rsc.kernel.questions import is_one
from rsc.kernel.series import Series
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import question, static
from rsc.kernel.weights import by_series, dense_v, dense_x


class Quartics(NamedTuple):
    """x and v as separate quartics y0 + theta (rise + rest (bend + theta (twist + rest last))), rest = 1 - theta."""

    x: object  # (y0, rise, bend, twist, last)
    v: object


@static
def dense_of(path, method):
    """Polynomials (Quartics or Series) of an attempted step."""
    if by_series(method):
        return path.step.slopes
    s, h = path.step, path.h
    x = s.x0, *_quartic(s.x0, s.x, h * s.v0, h * s.v), h * dense_x(method, None, s.slopes)
    v = s.v0, *_quartic(s.v0, s.v, s.slopes[0], s.slopes[-1]), dense_v(method, None, s.slopes)
    return Quartics(x, v)


@inlined
def _quartic(y0, y1, slope0, slope1):
    # cubic Hermite polynomial through both ends, nested as in dopri5's `contd5`; the stages add the fourth order
    rise = y1 - y0
    bend = slope0 - rise
    return rise, bend, rise - slope1 - bend


@question
def _is_series(dense):
    """Whether dense output is a Taylor series."""
    return dense.instance_class is Series


@static
def interpolate(dense, theta):
    """(x, v) inside a step, theta in [0, 1]."""
    if _is_series(dense):
        return _horner(dense.x, theta), _horner(dense.v, theta)
    return _nested(dense.x, theta), _nested(dense.v, theta)


@static
def _horner(c, theta):
    """Value of a power series with coefficients c."""
    if is_one(c):
        return c[0]
    return vec.fma(theta, _horner(c[1:], theta), c[0])


@inlined
def _nested(c, theta):
    left = 1.0 - theta
    inner = vec.fma(theta, vec.fma(left, c[4], c[3]), c[2])
    return vec.fma(theta, vec.fma(left, inner, c[1]), c[0])
