"""The Runge-Kutta pair as data; `step` unrolls it at compile time.

Source: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19, interpolant as in dopri5 (Hairer, Norsett, Wanner,
Solving Ordinary Differential Equations I). tests/unit/kernel/test_tableau.py checks the order conditions of these coefficients.
"""

from fractions import Fraction
from functools import cache
from typing import NamedTuple

ROUNDING = 1e-13  # relative to the largest weight: smaller sums are rounding errors of the table and taken as zero


class Tableau(NamedTuple):
    """An explicit pair of s stages; the slope at the end of the step, reused by the next step, counts as stage s + 1."""

    nodes: tuple  # c_1 .. c_s
    rows: tuple  # a_ij of stage 2 .. s
    weights: tuple  # b_1 .. b_s of the solution
    error: tuple  # (b - b^)_1 .. s + 1
    dense: tuple  # weights of the last term of dopri5's interpolant
    estimate_order: int  # the error estimate is O(h^this)


DORMAND_PRINCE = Tableau(
    nodes=(0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0),
    rows=(
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    ),
    weights=(35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    error=(71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40),
    dense=(
        -12715105075 / 11282082432,
        0.0,
        87487479700 / 32700410799,
        -10690763975 / 1880347072,
        701980252875 / 199316789632,
        -1453857185 / 822651844,
        69997945 / 29380423,
    ),
    estimate_order=5,
)


class Positions(NamedTuple):
    """The pair for the positions of x'' = a(x, x', t), from accelerations alone, as a Runge-Kutta-Nystrom method.

    Eliminating the velocities of the stages gives x_i = x_0 + h (c_i v_0 + sum_k (A A)_ik h a_k) at stage i (Hairer, Norsett,
    Wanner, Solving Ordinary Differential Equations I, II.14), so they need not be stored. Error and interpolant contain no v_0,
    since their weights sum to zero.
    """

    rows: tuple  # of stages 2 .. s and of the end of the step
    error: tuple  # 1 .. s
    dense: tuple


@cache
def positions_of(table):
    """`Positions` of a Tableau."""
    square = ((), *table.rows, table.weights)

    def through(row):
        terms = [[Fraction(a) * Fraction(b) for b in inner] for a, inner in zip(row, square, strict=False)]
        sums = [sum(term[k] for term in terms if k < len(term)) for k in range(len(row) - 1)]
        least = max(map(abs, sums), default=0) * ROUNDING
        return tuple(float(total) if abs(total) > least else 0.0 for total in sums)

    return Positions(tuple(through(row) for row in square[1:]), through(table.error), through(table.dense))


# the kernel receives its method as a tuple with as many numbers as the method has stages (or terms): a type, so that each is
# compiled separately. The Taylor series needs no table. Orders 7 to 12 differ little (bench/results/series_orders.md); of those
# under which undamped motions do not grow (8: steps up to 3.39/omega), lower ones compile faster, 12 is faster at tight rtol.
METHODS = {"rk45": (0.0,) * 6, "taylor8": (0.0,) * 8}


def table_of(method):
    """The Tableau of a method; None for the Taylor series, whose order is its number of terms."""
    return DORMAND_PRINCE if len(method) == len(DORMAND_PRINCE.nodes) else None


def estimate_order(method):
    """Order k of an error estimate O(h^k)."""
    table = table_of(method)
    return table.estimate_order if table else len(method)
