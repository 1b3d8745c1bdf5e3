"""What the dampers take over a step, for the energy ledger: per coordinate and unit modal mass.

With full matrices of damping the powers v * (-C v) of the stages are added up by the weights of the method. Where every
coordinate has a damping of its own, C times the integral of v^2: by the weights as well, or by Dormand-Prince, of order 5, from
the ends of the step. With Legendre's polynomials P_n on the step v is sum c_n P_n, and

    integral of v^2 = h (c_0^2 + c_1^2/3 + c_2^2/5) + O(h^7),   c_n = O(h^n),

where c_0 is the mean velocity, c_1 = 3/5 (v_1 - v_0) - h (a_0 + a_1)/20 + O(h^5) and c_2 = (v_0 + v_1)/2 - c_0 + O(h^4).
"""

from numba import types

from rsc.kernel.simd import vec
from rsc.kernel.simd.fused import fused
from rsc.kernel.simd.jit import unrolled
from rsc.kernel.tableau import estimate_order, table_of


def is_coupled(con):
    """Whether Constants, a type, have full matrices of damping or gyroscopics."""
    return len(con[con.fields.index("columns")]) > 0


def from_ends(con, stages):
    """Whether the method's losses come from the ends of a step."""
    return table_of(stages) is not None and estimate_order(stages) <= 5 and not is_coupled(con)


@unrolled
def first_share(con, start, h, weight, stages):
    """Share of a step's first stage in what the stages add up, () for nothing to be added up."""
    if from_ends(con, stages):
        return lambda con, start, h, weight, stages: ()
    if is_coupled(con):
        return lambda con, start, h, weight, stages: (h * weight) * start.powers.damping
    return lambda con, start, h, weight, stages: _square(weight, start.v)


@fused()
def _square(weight, v):
    return weight * v * v


@unrolled
def lost_until(con, field, done, total, velocities, slopes, stages):
    """Losses up to a step's end, from those `done` before and the `total` of its stages.

    velocities = v_0, the mean and v_1; slopes = h times the accelerations, the first and the last of which are those of the ends.
    """
    if from_ends(con, stages):
        return lambda con, field, done, total, velocities, slopes, stages: between_ends(
            velocities, slopes[0], slopes[-1], field.damping, done
        )
    if is_coupled(con):
        return lambda con, field, done, total, velocities, slopes, stages: summed(done, total)
    return lambda con, field, done, total, velocities, slopes, stages: _scaled_and_added(field.damping, total, done)


@fused(over=[1])
def between_ends(velocities, slope_0, slope_1, damping, done):
    """`done` with damping times the mean of v^2 over a step; velocities = v_0, c_0 and v_1, slope_0 = h a_0, slope_1 = h a_1."""
    v_0, mean, v_1 = velocities
    first = vec.fma(-1.0 / 12.0, slope_0 + slope_1, v_1 - v_0)  # 5/3 c_1
    second = vec.fma(-2.0, mean, v_0 + v_1)  # 2 c_2
    square = vec.fma(0.05 * second, second, vec.fma(0.12 * first, first, mean * mean))
    return vec.fma(damping, square, done)


@fused(over=[1])
def _scaled_and_added(damping, total, done):
    return vec.fma(damping, total, done)


@fused(over=[1])
def summed(done, total):
    """A sum of vectors, the second of which nobody needs any more."""
    return done + total


def is_none(kind):
    """Whether a type is that of ()."""
    return isinstance(kind, types.BaseTuple)
