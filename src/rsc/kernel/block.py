"""One block of flight: the forces at its nodes, its error and its work.

A block from (x, v) needs the polynomial of the forces (`nodes_of`); everything else about it is weights times that, by (F) of
`rsc.kernel.flight`.
"""

from typing import NamedTuple

from rsc.kernel.clock import turn_of, turns_after
from rsc.kernel.model import NODES, ROWS_OF_NUMBER, ROWS_OF_STATE
from rsc.kernel.questions import by_component, is_coupled
from rsc.kernel.rhs import forces_beside, imposed_at
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.static import static
from rsc.kernel.step import weighed_square
from rsc.kernel.turn import pick

# squares of shares of the tolerance: the error that a block may have, and below which one twice as long is tried next. Errors of
# blocks add up, where those of steps that stability holds short are nothing beside the tolerance: with these a run is as exact as
# one without flight
ALLOWED, DOUBLE = 0.02**2, 0.0002**2
# sweeps end when the change of the last force is worth less than this, squared
SWEPT, MOST_SWEEPS = 0.002**2, 16


class Nodes(NamedTuple):
    """Forces at the five nodes of a block, tuples; see `rhs.forces_beside`."""

    force: tuple
    held: tuple
    put_in: tuple


class Block(NamedTuple):
    """An attempted block."""

    first: int  # row of the weights of its first unit
    number: int  # of the unit at which it begins
    units: int
    nodes: Nodes
    end: tuple  # (x, v)
    error2: float  # square of the error norm, infinite where the sweeps do not converge
    clear: int  # units until a contact may begin


@inlined
def _weighed(con, first, x, v, force):
    """(F): seven rows of weights times x_0, v_0 and the forces at the nodes."""
    at = con.flight.weights
    total = vec.fma(vec.row_at(at, first + 1, x), v, vec.row_at(at, first, x) * x)
    for m in range(NODES):
        total = vec.fma(vec.row_at(at, first + 2 + m, x), force[m], total)
    return total


@inlined
def _known(con, first, x, v, force):
    """The part of (F) that no sweep changes."""
    at = con.flight.weights
    total = vec.fma(vec.row_at(at, first + 1, x), v, vec.row_at(at, first, x) * x)
    return vec.fma(vec.row_at(at, first + 2, x), force, total)


@inlined
def _completed(con, first, known, force):
    """(F) from its `_known` part."""
    at, total = con.flight.weights, known
    for m in range(1, NODES):
        total = vec.fma(vec.row_at(at, first + 2 + m, known), force[m], total)
    return total


@static
def _known_at(con, first, x, v, force):
    """`_known` parts of x, where a force needs it, and of v at the node whose weights begin at a row."""
    if by_component(con):
        return _known(con, first, x, v, force), _known(con, first + ROWS_OF_NUMBER, x, v, force)
    return (), _known(con, first + ROWS_OF_NUMBER, x, v, force)


@static
def _position(con, first, known, force):
    """x at a node, () where no force needs it."""
    return _completed(con, first, known, force) if by_component(con) else ()


@inlined
def _at_node(con, field, first, known, force, turn, imposed):
    """`forces_beside` at a node."""
    x, v = _position(con, first, known[0], force), _completed(con, first + ROWS_OF_NUMBER, known[1], force)
    return forces_beside(con, field, x, v, turn, imposed)


@inlined
def _swept(con, field, first, known, nodes, turns, imposed):
    """Nodes after one sweep: each is computed from those before it as they are now."""
    (f_0, f_1, f_2, f_3, f_4), held, put_in = nodes
    f_1, h_1, p_1 = _at_node(con, field, first, known[0], (f_0, f_1, f_2, f_3, f_4), pick(turns, 0), imposed[0])
    first += ROWS_OF_STATE
    f_2, h_2, p_2 = _at_node(con, field, first, known[1], (f_0, f_1, f_2, f_3, f_4), pick(turns, 1), imposed[1])
    first += ROWS_OF_STATE
    f_3, h_3, p_3 = _at_node(con, field, first, known[2], (f_0, f_1, f_2, f_3, f_4), pick(turns, 2), imposed[2])
    first += ROWS_OF_STATE
    f_4, h_4, p_4 = _at_node(con, field, first, known[3], (f_0, f_1, f_2, f_3, f_4), pick(turns, 3), imposed[3])
    return Nodes((f_0, f_1, f_2, f_3, f_4), (held[0], h_1, h_2, h_3, h_4), (put_in[0], p_1, p_2, p_3, p_4))


@inlined
def _known_everywhere(con, first, x, v, force):
    """`_known_at` of the four nodes behind the first."""
    one, two = _known_at(con, first, x, v, force), _known_at(con, first + ROWS_OF_STATE, x, v, force)
    first += 2 * ROWS_OF_STATE
    return one, two, _known_at(con, first, x, v, force), _known_at(con, first + ROWS_OF_STATE, x, v, force)


@inlined
def _turned(force, turn, later):
    """A force that turns with the shaft, at a later rotation."""
    c, s = turn.cos * later.cos + turn.sin * later.sin, turn.cos * later.sin - turn.sin * later.cos
    return vec.fma(s, vec.times_i(force), c * force)


@inlined
def _taken(con, first, change, weight):
    """The error norm's square of a force, taken to a time by two rows of weights: this one and that for v."""
    at = con.flight.weights
    by_x, by_v = vec.row_at(at, first, change), vec.row_at(at, first + ROWS_OF_NUMBER, change)
    return weighed_square(by_x * change, by_v * change, weight)


@static
def nodes_of(con, field, first, end, begin, clock, h, weight):
    """(Nodes of a block that begins at (x, v), evaluations of the forces, whether the sweeps converged); first, end: rows of its
    weights and of those for its end."""
    x, v = begin
    quarter = 0.25 * h
    turns = turns_after(clock, vec.from_numbers((quarter, 2.0 * quarter, 3.0 * quarter, h), x))
    turn = turn_of(clock)
    g_0, g_1, g_2 = imposed_at(con, turn), imposed_at(con, pick(turns, 0)), imposed_at(con, pick(turns, 1))
    g_3, g_4 = imposed_at(con, pick(turns, 2)), imposed_at(con, pick(turns, 3))
    if not is_coupled(con):
        imposed = (g_0, g_1, g_2, g_3, g_4)
        return Nodes(imposed, imposed, imposed), NODES, True
    f_0, held, put_in = forces_beside(con, field, x, v, turn, g_0)
    beside = f_0 - g_0
    force = (
        f_0, g_1 + _turned(beside, turn, pick(turns, 0)), g_2 + _turned(beside, turn, pick(turns, 1)),
        g_3 + _turned(beside, turn, pick(turns, 2)), g_4 + _turned(beside, turn, pick(turns, 3)),
    )  # fmt: skip
    nodes = Nodes(force, (held, held, held, held, held), (put_in, put_in, put_in, put_in, put_in))
    known = _known_everywhere(con, first, x, v, f_0)
    sweeps, converged = 0, False
    while sweeps < MOST_SWEEPS and not converged:
        last = nodes.force[NODES - 1]
        nodes = _swept(con, field, first, known, nodes, turns, (g_1, g_2, g_3, g_4))
        converged = _taken(con, end + 1 + NODES, nodes.force[NODES - 1] - last, weight) <= SWEPT
        sweeps += 1
    return nodes, 1 + (NODES - 1) * sweeps, converged


@inlined
def block_error2(con, end, force, weight):
    """Square of the error norm: the part of degree 4 of the force, a polynomial's last difference."""
    outer, inner = force[0] + force[4], force[1] + force[3]
    difference = vec.fma(-1.0 / 6.0, outer, vec.fma(2.0 / 3.0, inner, -1.0 * force[2]))
    return _taken(con, end + 2 + NODES // 2, difference, weight)


@inlined
def _energy(con, x, v):
    """Kinetic energy of the coordinates and that of their own springs, per mass."""
    return 0.5 * vec.fma(-1.0 * con.stiffness * x, x, v * v)


@inlined
def block_work(con, block, begin):
    """(work of the dampers, work of unbalance and load as a `vec.product`) over a block from (x, v). The force is a polynomial in
    the block, so its work is exact; a coordinate's own damper has taken what is missing in the coordinate's energy."""
    (x, v), nodes, end = begin, block.nodes, block.end
    first = block.first - ROWS_OF_NUMBER * NODES
    fed = vec.product(x, 0.0 * x)
    damping = _energy(con, end[0], end[1]) - _energy(con, x, v)
    for m in range(NODES):
        moved = _weighed(con, first + ROWS_OF_NUMBER * m, x, v, nodes.force)
        fed = fed + vec.product(moved, nodes.put_in[m])
        damping = damping - moved * nodes.held[m]
    return damping, fed


@inlined
def state_behind(con, first, unit, begin, force):
    """(x, v) behind so many units and one of a block whose first unit has its weights at a row."""
    row = first + ROWS_OF_STATE * unit
    return (
        _weighed(con, row, begin[0], begin[1], force), _weighed(con, row + ROWS_OF_NUMBER, begin[0], begin[1], force)
    )  # fmt: skip
