"""The step-size controller: a length whose error is a set share of the tolerance, by a power good to a few parts per thousand."""

import math

from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.tableau import estimate_order


@inlined
def log2_roughly(x):
    """log2 of a positive number by its bits: exact at powers of two, at most 0.09 too low between."""
    return vec.bits(x) * 2.0**-52 - 1023.0


@inlined
def _exp2(y):
    """2**y for |y| < 3 to 3e-4, without the library."""
    z = y * (0.6931471805599453 / 8.0)
    t = 1.0 + z * (1.0 + z * (0.5 + z * (1.0 / 6.0)))
    t = t * t
    t = t * t
    return t * t


def _aim(method):
    """Square of the error over its tolerance that the controller aims at: steps some tenth below what would pass."""
    return 0.2 if estimate_order(method) == 5 else 0.02


@unrolled
def kept_between(method):
    """Squares of the error over its tolerance between which the step length is kept; the first is its aim."""
    bounds = _aim(method), 0.5 if estimate_order(method) == 5 else 0.25
    return lambda method: bounds


@unrolled
def _power(method, log_error2):
    """log2 of the step-size factor from that of the square of the error over its tolerance; the estimate is O(h^k)."""
    exponent = 0.5 / estimate_order(method)
    aim = exponent * math.log2(_aim(method))
    return lambda method, log_error2: aim - exponent * log_error2


@inlined
def factor(error2, method):
    """Step-size factor from the square of the error over its tolerance; NaN shrinks."""
    if not error2 < 1e8:
        return 0.2
    # 2^-40 stands for no error at all; 2^+-2.3 is a factor of five either way
    power = _power(method, max(log2_roughly(error2), -40.0))
    return _exp2(min(max(power, -2.3), 2.3))
