"""Runge-Kutta pairs as data; `step` compiles each as if it were written out.

Sources: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19, interpolant as in dopri5 (Hairer, Norsett, Wanner,
Solving Ordinary Differential Equations I); J. H. Verner, Numer. Algorithms 53 (2010) 383, the "most efficient" 7(6) pair (its
fractions of up to 70 digits as the nearest doubles). The order conditions of what
stands here are checked by tests/unit/kernel/test_tableau.py.
"""

from fractions import Fraction
from functools import cache
from typing import NamedTuple

ROUNDING = 1e-13  # shares of the largest weight that are what is left of nothing where numbers of a table are rounded


class Tableau(NamedTuple):
    """An explicit pair of s stages; the slope at the step's end, which begins the next step, counts as stage s + 1."""

    nodes: tuple  # c_1 .. c_s
    rows: tuple  # a_ij of stage 2 .. s
    weights: tuple  # b_1 .. b_s of the solution
    error: tuple  # (b - b^)_1 .. s + 1
    dense: tuple  # weights of the last term of the interpolant of dopri5, or () for the one by `step.Middle`
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

VERNER = Tableau(
    nodes=(0.0, 1 / 200, 49 / 450, 49 / 300, 911 / 2000, 3480084980 / 5709648941, 221 / 250, 37 / 40, 1.0, 1.0),
    rows=(
        (1 / 200,),
        (-4361 / 4050, 2401 / 2025),
        (49 / 1200, 0.0, 49 / 400),
        (0.6389139236255726, 0.0, -2.455672638223657, 2.272258714598084),
        (-2.6615773750187572, 0.0, 10.804513886456137, -8.3539146573962, 0.820487594956657),
        (6.067741434696771, 0.0, -24.711273635911084, 20.427517930788895, -1.9061579788166472, 1.006172249242068),
        (
            12.054670076253203,
            0.0,
            -49.75478495046899,
            41.142888638604674,
            -4.461760149974004,
            2.042334822239175,
            -0.09834843665406108,
        ),
        (
            10.138146522881808,
            0.0,
            -42.6411360317175,
            35.76384003992257,
            -4.3480228403929075,
            2.0098622683770357,
            0.3487490460338272,
            -0.27143900510483127,
        ),
        (
            -45.030072034298676,
            0.0,
            187.3272437654589,
            -154.02882369350186,
            18.56465306347536,
            -7.141809679295079,
            1.3088085781613785,
            0.0,
            0.0,
        ),
    ),
    weights=(
        0.04715561848627222,
        0.0,
        0.0,
        0.25750564298434153,
        0.2621665397741262,
        0.15216092656738558,
        0.49399691700324844,
        -0.29430311714032503,
        0.0813174723249511,
        0.0,
    ),
    error=(
        0.0025470118799310456,
        0.0,
        0.0,
        -0.00965839487279575,
        0.0420647097563969,
        -0.0666822437469301,
        0.26500974646212816,
        -0.29430311714032503,
        0.0813174723249511,
        -0.020295184663356284,
        1e-300,  # so that a slope at the end that is no number is an error as well
    ),
    dense=(),
    estimate_order=7,
)


class Positions(NamedTuple):
    """The same pair for the positions of x'' = a(x, x', t), by its accelerations alone: as a Runge-Kutta-Nystrom method.

    With the velocities of the stages put in, x of stage i is x_0 + h (c_i v_0 + sum_k (A A)_ik h a_k) (Hairer, Norsett, Wanner,
    Solving Ordinary Differential Equations I, II.14): the velocities of the stages need not be kept. Error and interpolant have
    no v_0, since their weights add up to nothing.
    """

    rows: tuple  # of stage 2 .. s and of the step's end
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


# a kernel is told its method by a tuple of as many numbers as the method has stages (or terms): a type, so that each compiles by
# itself. The Taylor series needs no table. Orders 7 to 12 differ little (bench/series_orders.py); of those that do not let an
# undamped motion grow (8 for steps up to 3.39/omega) the smaller compile faster, 12 is faster on small systems at tight rtol.
METHODS = {"rk45": (0.0,) * 6, "verner76": (0.0,) * 10, "taylor8": (0.0,) * 8}
_BY_STAGES = {len(table.nodes): table for table in (DORMAND_PRINCE, VERNER)}


def table_of(stages):
    """The table of a method; None for the Taylor series, whose order is the number of its terms."""
    return _BY_STAGES.get(len(stages))


def estimate_order(stages):
    """The k of an error estimate O(h^k)."""
    table = table_of(stages)
    return table.estimate_order if table else len(stages)
