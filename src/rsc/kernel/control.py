"""The step-size controller: aims at a given fraction of the tolerance, with powers accurate to a few parts per thousand."""

import math

from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import constant, inlined
from rsc.kernel.tableau import estimate_order


@inlined
def log2_roughly(x):
    """log2 of a positive number from its bit pattern: exact at powers of two, otherwise up to 0.09 too low."""
    return vec.bits(x) * 2.0**-52 - 1023.0


@inlined
def _exp2(y):
    """2**y for |y| < 3, relative error 3e-4, without a library call."""
    z = y * (0.6931471805599453 / 8.0)
    t = 1.0 + z * (1.0 + z * (0.5 + z * (1.0 / 6.0)))
    t = t * t
    t = t * t
    return t * t


def _aim(method):
    """Target of (error/tolerance)^2: steps about a tenth shorter than would pass."""
    return 0.2 if estimate_order(method) == 5 else 0.02


@constant
def kept_between(method):
    """Range of (error/tolerance)^2 in which the step length is kept; the lower bound is the target."""
    return _aim(method), 0.5 if estimate_order(method) == 5 else 0.25


@constant
def _line(method):
    """(a, b) of log2 of the step-size factor, a - b log2((error/tolerance)^2), for an estimate O(h^k)."""
    exponent = 0.5 / estimate_order(method)
    return exponent * math.log2(_aim(method)), exponent


@inlined
def factor(error2, method):
    """Step-size factor from (error/tolerance)^2; NaN gives the smallest."""
    if not error2 < 1e8:
        return 0.2
    # 2^-40 represents zero error; 2^+-2.3 is a factor of five up or down
    aim, exponent = _line(method)
    power = aim - exponent * max(log2_roughly(error2), -40.0)
    return _exp2(min(max(power, -2.3), 2.3))
