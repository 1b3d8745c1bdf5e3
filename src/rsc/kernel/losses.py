"""Energy dissipated by the dampers over a step, for the energy ledger: per coordinate and unit modal mass.

With a full damping matrix the powers v * (-C v) of the stages of a Runge-Kutta pair are summed with its weights. With diagonal
damping, C times the integral of v^2 follows from the ends of the step: with Legendre polynomials P_n on the step, v =
sum c_n P_n and

    integral of v^2 = h (c_0^2 + c_1^2/3 + c_2^2/5) + O(h^7),   c_n = O(h^n),

where c_0 is the mean velocity, c_1 = 3/5 (v_1 - v_0) - h (a_0 + a_1)/20 + O(h^5) and c_2 = (v_0 + v_1)/2 - c_0 + O(h^4).
"""

from rsc.kernel.questions import is_coupled
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import static


@static
def first_share(con, start, h, weight):
    """Contribution of the first stage to the sum over the stages of a Runge-Kutta pair; () if nothing is summed."""
    if is_coupled(con):
        return (h * weight) * start.powers.damping
    return ()


@static
def lost_until(con, field, before, total, velocities, slopes):
    """Dissipated energy at the end of a Runge-Kutta step: `before` the step plus that of the step (`total` of its stages).

    velocities = v_0, the mean and v_1; slopes = h times the accelerations, the first and last at the ends of the step.
    """
    if is_coupled(con):
        return before + total
    return between_ends(velocities, slopes[0], slopes[-1], field.damping, before)


@inlined
def between_ends(velocities, slope_0, slope_1, damping, before):
    """`before` plus damping times the mean of v^2 over a step; velocities = v_0, c_0, v_1, slope_0 = h a_0, slope_1 = h a_1."""
    # ends and mean are available anyway; powers of the stages would be computed for the ledger alone
    v_0, mean, v_1 = velocities
    first = vec.fma(-1.0 / 12.0, slope_0 + slope_1, v_1 - v_0)  # 5/3 c_1
    second = vec.fma(-2.0, mean, v_0 + v_1)  # 2 c_2
    square = vec.fma(0.05 * second, second, vec.fma(0.12 * first, first, mean * mean))
    return vec.fma(damping, square, before)
