"""Flight: exact motion between contacts, in blocks that no stiff mode holds short.

Without contact every coordinate is an oscillator of its own, x'' = K x + C x' + f(t), with all that couples it to others in f. A
block of length H has five nodes t + m H/4. With f the polynomial of degree 4 through its values f_m there

    x(tau) = a x_0 + b v_0 + sum_m A_m f_m,    v(tau) = a' x_0 + b' v_0 + sum_m B_m f_m                                   (F)

are exact for any tau; the weights come from `rsc.simulation.flight`. The f_m depend on v, and with springs by component on x, at
the nodes: they are found by sweeps, each of which takes (F) to one node after the other. The error is that of the degree: the
part of degree 4 of f, taken to the end of the block.

Blocks begin and end on the grid of units (`model.FlightData`). What is decided depends on the state and on the length reached,
which is kept, so a run that is cut anywhere has the same bits.
"""

import math
from typing import NamedTuple

from rsc.kernel.clock import Clock, ahead, clock_at, turn_of, turns_after
from rsc.kernel.contact import OPEN
from rsc.kernel.facts import add_steps
from rsc.kernel.model import BUFFER_FULL, NODES, ROWS_OF_NODES, ROWS_OF_NUMBER, ROWS_OF_STATE, RUNNING, rows_before
from rsc.kernel.questions import by_component, is_coupled, is_none
from rsc.kernel.rhs import contact_kinematics, field_itself, forces_beside, imposed_at, zero_of_each
from rsc.kernel.simd import vec
from rsc.kernel.simd.hints import aligned_stack
from rsc.kernel.simd.jit import compiled, inlined
from rsc.kernel.simd.static import static
from rsc.kernel.step import error_weight, size_square, weighed_square
from rsc.kernel.tally import book_flight, save_sample, turn_for_all
from rsc.kernel.turn import pick

# what `walk` hands back where a flight may begin; above all that `march` returns
TAKE_OFF = 100
# Work.real[FLIGHT]: ready to fly; landed, before another step, since a contact was near; since even the shortest block erred too
# much; and a step later: then a flight is tried again, with the shortest, at every COARSE-th place only. In a flight it is
# 1 + number of the length that comes next
READY, LANDED, ERRED, DOUBTFUL = 0.0, -1.0, -2.0, -3.0
COARSE = 8
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


class Point(NamedTuple):
    """A state between two units, as far as facts of a stretch need it."""

    x: object
    v: object
    clock: Clock
    kins: tuple
    rate_slopes: tuple  # no contact presses: zeros


class Open(NamedTuple):
    """A contact that nothing touches."""

    normal: int
    friction: int
    law: object


class Records(NamedTuple):
    """What is written during a flight."""

    where: object  # SampleRows
    stretch: tuple  # a Stretch of each contact
    each: tuple  # an Open of each


class Reach(NamedTuple):
    """How far the deflection of a contact reaches near the end of a unit, squares in m^2."""

    behind: float  # there, and on the way to the next
    before: float  # there, and on the way from the last
    hidden: float  # what modes may add that ring faster


class Block(NamedTuple):
    """An attempted block."""

    first: int  # row of the weights of its first unit
    number: int  # of the unit at which it begins
    units: int
    nodes: Nodes
    end: tuple  # (x, v)
    error2: float  # square of the error norm, infinite where the sweeps do not converge
    clear: int  # units until a contact may begin


class Landing(NamedTuple):
    """Where a flight ends."""

    code: int  # why the call ends, or -1
    calls: int  # evaluations of the forces
    spent: int  # attempted blocks
    x: object
    v: object
    clock: Clock
    tally: object
    sample: int
    flight: float  # Work.real[FLIGHT]


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
def _node(con, field, first, known, force, turn, imposed):
    """`forces_beside` at a node."""
    x, v = _position(con, first, known[0], force), _completed(con, first + ROWS_OF_NUMBER, known[1], force)
    return forces_beside(con, field, x, v, turn, imposed)


@inlined
def _swept(con, field, first, known, nodes, turns, imposed):
    """Nodes after one sweep: each is computed from those before it as they are now."""
    (f_0, f_1, f_2, f_3, f_4), held, put_in = nodes
    f_1, h_1, p_1 = _node(con, field, first, known[0], (f_0, f_1, f_2, f_3, f_4), pick(turns, 0), imposed[0])
    first += ROWS_OF_STATE
    f_2, h_2, p_2 = _node(con, field, first, known[1], (f_0, f_1, f_2, f_3, f_4), pick(turns, 1), imposed[1])
    first += ROWS_OF_STATE
    f_3, h_3, p_3 = _node(con, field, first, known[2], (f_0, f_1, f_2, f_3, f_4), pick(turns, 2), imposed[2])
    first += ROWS_OF_STATE
    f_4, h_4, p_4 = _node(con, field, first, known[3], (f_0, f_1, f_2, f_3, f_4), pick(turns, 3), imposed[3])
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
def _nodes_of(con, field, first, end, begin, clock, h, weight):
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
def _error2(con, end, force, weight):
    """Square of the error norm: the part of degree 4 of the force, a polynomial's last difference."""
    outer, inner = force[0] + force[4], force[1] + force[3]
    difference = vec.fma(-1.0 / 6.0, outer, vec.fma(2.0 / 3.0, inner, -1.0 * force[2]))
    return _taken(con, end + 2 + NODES // 2, difference, weight)


@inlined
def _energy(con, x, v):
    """Kinetic energy of the coordinates and that of their own springs, per mass."""
    return 0.5 * vec.fma(-1.0 * con.stiffness * x, x, v * v)


@inlined
def _work(con, block, begin):
    """(work of the dampers, `vec.product` of what is put in) over a block from (x, v): the force is its polynomial, so the
    integrals of v times it are exact, and what the springs and dampers of a coordinate took is what its energy lacks."""
    (x, v), nodes, end = begin, block.nodes, block.end
    first = block.first - ROWS_OF_NUMBER * NODES
    fed = vec.product(x, 0.0 * x)
    damping = _energy(con, end[0], end[1]) - _energy(con, x, v)
    for m in range(NODES):
        moved = _weighed(con, first + ROWS_OF_NUMBER * m, x, v, nodes.force)
        fed = fed + vec.product(moved, nodes.put_in[m])
        damping = damping - moved * nodes.held[m]
    return damping, fed


@static
def _reaches(con, contacts, i, x, v, kins):
    """The Reach of every contact from number i on."""
    if is_none(contacts):
        return ()
    third = 1.0 / (3.0 * con.flight.unit_rate)
    square = kins[0].place.distance * kins[0].place.distance
    sideways, along = third * kins[0].motion.speed, 2.0 * third * kins[0].motion.along
    # corners of the cubic's Bezier polygon, which holds it
    beside = square + sideways * sideways
    at = con.flight.hidden
    hidden = vec.product(vec.row_at(at, 2 * i, x) * x, x) + vec.product(vec.row_at(at, 2 * i + 1, x) * v, v)
    y, z = vec.pair_sum(hidden)
    reach = Reach(max(square, beside + along), max(square, beside - along), y + z)
    return (reach,) + _reaches(con, contacts[1:], i + 1, x, v, kins[1:])


@static
def _are_clear(con, i, begin, end):
    """Whether nothing can touch between two targets, by their Reach, of the contacts from number i on."""
    if is_none(begin):
        return True
    room = vec.number_at(con.flight.clear, i) - math.sqrt(max(begin[0].hidden, end[0].hidden))
    far = max(begin[0].behind, end[0].before)
    return room > 0.0 and far <= room * room and _are_clear(con, i + 1, begin[1:], end[1:])


@inlined
def _units_clear(con, first, begin, clock, force, units, reach):
    """(units of a block until a contact may begin, (x, v) at the end of those that were looked at); first: row of the first unit;
    reach: at its begin."""
    x_end, v_end = begin
    clear = 0
    while clear < units:
        x_end, v_end = _state(con, first, clear, begin, force)
        tau = (clear + 1.0) / con.flight.unit_rate
        kins = contact_kinematics(con.contacts, x_end, v_end, turn_for_all(con.contacts, clock, tau, (x_end, v_end)))
        reach_end = _reaches(con, con.contacts, 0, x_end, v_end, kins)
        if not _are_clear(con, 0, reach, reach_end):
            break
        reach = reach_end
        clear += 1
    return clear, (x_end, v_end)


@inlined
def _state(con, first, unit, begin, force):
    """(x, v) behind so many units and one of a block whose first unit has its weights at a row."""
    row = first + ROWS_OF_STATE * unit
    return (
        _weighed(con, row, begin[0], begin[1], force), _weighed(con, row + ROWS_OF_NUMBER, begin[0], begin[1], force)
    )  # fmt: skip


@static
def laws_of(each):
    """The laws of all contacts."""
    return () if is_none(each) else (each[0].law,) + laws_of(each[1:])


@static
def _opened(each):
    """The contacts as `facts.add_steps` takes them; that they are open is known while compiling."""
    if is_none(each):
        return ()
    return (Open(OPEN, each[0].friction, each[0].law),) + _opened(each[1:])


@inlined
def _recorded(con, records, tally, begin, block, clock_end, sample):
    """Add every unit of a block to the facts of the stretches and write its samples; (Point at its end, next sample)."""
    flight, before, laws, c = con.flight, tally.work.friction, laws_of(records.each), begin.clock
    start, step = begin, 1.0 / flight.unit_rate
    for unit in range(block.units):
        x, v = _state(con, block.first, unit, (begin.x, begin.v), block.nodes.force)
        tau, number = (unit + 1.0) / flight.unit_rate, block.number + unit + 1
        turn = turn_for_all(con.contacts, c, tau, (x, v))
        hi = number / flight.unit_rate
        clock = Clock(hi, 0.0, c.phase, c.speed, c.speed_rate, c.cos, c.sin, c.following, c.torque, c.states)
        if unit == block.units - 1:  # with the bits of a run that goes on from there
            clock, turn = clock_end, turn_of(clock_end)
        new = Point(x, v, clock, contact_kinematics(con.contacts, x, v, turn), start.rate_slopes)
        add_steps(con.contacts, records.stretch, tally, records.each, start, new, before, step)
        if number == sample * flight.per_sample:
            save_sample(con, laws, records.where, sample, c, (x, v), turn)
            sample += 1
        start = new
    return start, sample


@static
def is_ready(con, flight, clock):
    """Whether a flight may begin at a clock; flight: Work.real[FLIGHT]."""
    if is_none(flight):
        return False
    units = _units_at(con, clock)
    on_grid = clock.lo == 0.0 and clock.hi == units / con.flight.unit_rate and units % _apart(con, flight) == 0
    return on_grid and clock.hi > 0.0 and flight != LANDED and flight != ERRED


@inlined
def _apart(con, flight):
    """Units between two places at which a flight may begin."""
    return COARSE * con.flight.shortest if flight <= ERRED else con.flight.shortest


@inlined
def _units_at(con, clock):
    """Number of the unit nearest to a clock."""
    return int(clock.hi * con.flight.unit_rate + 0.5)


@inlined
def next_time(con, flight, clock):
    """The next time behind a clock, s, at which a flight may begin."""
    rate, apart = con.flight.unit_rate, _apart(con, flight)
    number = int(clock.hi * rate) // apart * apart
    while not (number / rate - clock.hi) - clock.lo > 0.0:
        number += apart
    return number / rate


@static
def after_step(flight):
    """Work.real[FLIGHT] behind a step."""
    if is_none(flight):
        return ()
    return DOUBTFUL if flight <= ERRED else READY


@inlined
def _shorter(con, length, most):
    """The longest length below one whose units are at most `most`, -1 for none."""
    length -= 1
    while length >= 0 and con.flight.shortest << length > most:
        length -= 1
    return length


@inlined
def _block(con, laws, point, number, length, reach):
    """The Block of a length from a Point, and the evaluations of the forces that it takes."""
    x, v, clock, data = point.x, point.v, point.clock, con.flight
    units, first = data.shortest << length, rows_before(length, data.shortest)
    first_unit, weight = first + ROWS_OF_NODES, error_weight(con, x, v)
    last, h = first_unit + ROWS_OF_STATE * (units - 1), units / data.unit_rate
    field = field_itself(con, laws, clock)
    nodes, calls, converged = _nodes_of(con, field, first, last, (x, v), clock, h, weight)
    error2 = _error2(con, last, nodes.force, weight) if converged else math.inf
    clear, end = 0, (x, v)
    if error2 <= ALLOWED:
        clear, end = _units_clear(con, first_unit, (x, v), clock, nodes.force, units, reach)
        if not size_square(end[0]) <= con.divergence2:
            clear = 0
    return Block(first_unit, number, units, nodes, end, error2, clear), calls


@inlined
def _stops(con, where, tally, sample, units, left):
    """Why a call ends before a block, or -1; left: blocks that may still be attempted."""
    if left <= 0:
        return RUNNING
    return BUFFER_FULL if where.rows - (sample - where.first) < units // con.flight.per_sample + 2 else -1


@compiled
def fly(con, segment, records, start, tally, sample, flight, budget):
    """Blocks of flight from a state on the grid without contact, until one of the shortest length may touch or errs too much, the
    segment ends, or the call: at most `budget` blocks are attempted and no more rows written than there are.

    Parameters: Constants, the segment of the schedule, Records with a Contact of each, a State, Tally, number of the next sample,
    Work.real[FLIGHT]. Returns a Landing.
    """
    aligned_stack()
    data, records = con.flight, Records(records.where, records.stretch, _opened(records.each))
    laws, point = laws_of(records.each), Point(start.x, start.v, start.clock, start.kins, zero_of_each(con.contacts))
    length = data.count - 1 if flight == READY else max(int(flight), 1) - 1
    landed, number, spent, calls, code = LANDED, _units_at(con, point.clock), 0, 0, -1
    while length >= 0 and tally.steps < con.max_steps:
        units = data.shortest << length
        if (number + units + 1.0) / data.unit_rate > segment.end:
            length = _shorter(con, length, units - 1)
            continue
        code = _stops(con, records.where, tally, sample, units, budget - spent)
        if code >= 0:
            break
        reach = _reaches(con, con.contacts, 0, point.x, point.v, point.kins)
        if not _are_clear(con, 0, reach, reach):
            length = -1
            break
        block, more = _block(con, laws, point, number, length, reach)
        spent, calls = spent + 1, calls + more
        if block.clear < units:
            erred = not block.error2 <= ALLOWED  # a NaN as well
            landed, length = ERRED if erred else LANDED, _shorter(con, length, units if erred else block.clear)
            continue
        time = (number + units) / data.unit_rate
        clock = clock_at(segment, time, 0.0, ahead(segment, point.clock, time - point.clock.hi).phase)
        damping, drive = _work(con, block, (point.x, point.v))
        point, sample = _recorded(con, records, tally, point, block, clock, sample)
        tally, number = book_flight(tally, damping, drive), number + units
        if block.error2 <= DOUBLE and length < data.count - 1:
            length += 1
    landed = landed if length < 0 else 1.0 + length
    return Landing(code, calls, spent, point.x, point.v, point.clock, tally, sample, landed)
