"""Weights and nodes of the stages of a step, from the table of its method, as constants of the compiled code.

The next stage follows from how many slopes are known: with none the step begins, with s the state at its end is due.
"""

from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import constant, unrolled
from rsc.kernel.simd.static import question
from rsc.kernel.tableau import positions_of, table_of


@question
def by_series(method):
    """Whether a method is the Taylor series."""
    return table_of(method) is None


@question
def all_known(method, slopes):
    """Whether the slopes of all stages are known."""
    return len(slopes) == len(table_of(method).nodes)


@question
def at_end(method, slopes):
    """Whether the next stage is at the end of the step."""
    return _next_node(method, slopes) == 1.0


def _next_node(method, slopes):
    return (*table_of(method).nodes, 1.0)[len(slopes)]


def _inner_nodes(method):
    """Distinct nodes inside the step, at which the rotation is needed."""
    return sorted(set(table_of(method).nodes[1:]) - {1.0})


@constant
def inner_nodes(method):
    """`_inner_nodes`, filled up with zeros to whole registers."""
    nodes = _inner_nodes(method)
    return (*nodes, *(0.0,) * (-len(nodes) % 4))


@constant
def lane_of_next(method, slopes):
    """Place of the next stage among the `inner_nodes`."""
    return _inner_nodes(method).index(_next_node(method, slopes))


@constant
def node_after_next(method, slopes):
    """Node of the stage after the next one, 1 for the end of the step."""
    return (*table_of(method).nodes, 1.0)[len(slopes) + 1]


@constant
def weight_of_next(method, slopes):
    """Weight of the next stage in the solution."""
    return table_of(method).weights[len(slopes)]


def _weighted(weights_of):
    """Helper (method, base, slopes) -> base + sum of w_j slopes_j, base None for 0, w = weights_of(table, number of slopes)."""

    def choose(method, base, slopes):
        row = vec.weighted_sum(weights_of(table_of(method), len(slopes)))
        return lambda method, base, slopes: row(base, slopes)

    choose.__doc__ = weights_of.__doc__
    return unrolled(choose)


@_weighted
def velocity_sum(table, i):
    """Velocity at the next stage or at the end of the step, on v at its start."""
    return (*table.rows, table.weights)[i - 1]


@_weighted
def position_sum(table, i):
    """Mean velocity up to the stage after the next one, or to the end of the step, on c v_0."""
    return positions_of(table).rows[i]


@_weighted
def error_of_x(table, i):
    """Estimated error of x, over the length of the step."""
    return positions_of(table).error


@_weighted
def error_of_v(table, i):
    """Estimated error of v."""
    return table.error


@_weighted
def dense_x(table, i):
    """Last term of x inside the step, over its length."""
    return positions_of(table).dense


@_weighted
def dense_v(table, i):
    """Last term of v inside the step."""
    return table.dense
