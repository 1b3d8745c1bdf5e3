"""The step-size controller: proportional-integral as in dopri5, with a power good to a few parts per thousand."""

from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.tableau import estimate_order

BETA = 0.04
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
def _exponents(stages):
    """(1/k - 3/4 beta)/2 and beta/2, for squares of the error over its tolerance; the estimate is O(h^k)."""
    now, before = 0.5 / estimate_order(stages) - 0.375 * BETA, 0.5 * BETA
    return lambda stages: (now, before)


@unrolled
def kept_between(stages):
    """Squares of the error over its tolerance between which the step length is kept: from a little below where the controller
    settles, 0.9^(2/(1/k - 7/4 beta)), which is 0.2 for k = 5, 0.05 for 7 and 0.02 for 8."""
    bounds = (0.2, 0.6) if estimate_order(stages) == 5 else (0.02, 0.25)
    return lambda stages: bounds


@inlined
def factor(error2, log_before, stages):
    """(step-size factor, log2 to remember) from the square of the error over its tolerance; NaN shrinks."""
    if not error2 < 1e8:
        return 0.2, log_before
    return smooth_factor(error2, log_before, stages)


@inlined
def smooth_factor(error2, log_before, stages):
    """The same for an error that is no NaN and not far too large."""
    log_now = max(log2_roughly(error2), -40.0)
    now, before = _exponents(stages)
    power = SAFETY_LOG2 - now * log_now + before * log_before
    return _exp2(min(max(power, -2.3), 2.3)), max(log_now, -26.0)
