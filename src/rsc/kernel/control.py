"""The step-size controller: 0.9 times the length that would just pass, with a power good to a few parts per thousand."""

from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.tableau import estimate_order

SAFETY_LOG2 = -0.15200309344504997  # log2(0.9)


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


@unrolled
def _exponent(stages):
    """1/(2 k), for squares of the error over its tolerance; the estimate is O(h^k)."""
    exponent = 0.5 / estimate_order(stages)
    return lambda stages: exponent


@unrolled
def kept_between(stages):
    """Squares of the error over its tolerance between which the step length is kept: around 0.9^(2 k), where the controller
    settles, which is 0.35 for k = 5 and 0.19 for 8."""
    bounds = (0.2, 0.6) if estimate_order(stages) == 5 else (0.02, 0.25)
    return lambda stages: bounds


@inlined
def factor(error2, stages):
    """Step-size factor from the square of the error over its tolerance; NaN shrinks."""
    return smooth_factor(error2, stages) if error2 < 1e8 else 0.2


@inlined
def smooth_factor(error2, stages):
    """Step-size factor for an error that is no NaN and not far too large."""
    power = SAFETY_LOG2 - _exponent(stages) * max(log2_roughly(error2), -40.0)
    return _exp2(min(max(power, -2.3), 2.3))
