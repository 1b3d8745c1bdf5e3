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

from rsc.kernel.block import ALLOWED, DOUBLE, Block, block_error2, block_work, nodes_of, state_behind
from rsc.kernel.clearance import are_clear, reaches, units_clear
from rsc.kernel.clock import Clock, ahead, clock_at, turn_of
from rsc.kernel.contact import OPEN
from rsc.kernel.contact_forces import contact_kinematics
from rsc.kernel.facts import add_steps
from rsc.kernel.model import BUFFER_FULL, ROWS_OF_NODES, ROWS_OF_STATE, RUNNING, rows_before
from rsc.kernel.progress import laws_of
from rsc.kernel.questions import is_none
from rsc.kernel.rhs import field_itself, zero_of_each
from rsc.kernel.simd.hints import aligned_stack
from rsc.kernel.simd.jit import compiled, inlined
from rsc.kernel.simd.static import static
from rsc.kernel.step import error_weight, size_square
from rsc.kernel.tally import book_flight, save_sample, turn_for_all

# what `walk` hands back where a flight may begin; above all that `march` returns
TAKE_OFF = 100
# Work.real[FLIGHT]: ready to fly; landed, before another step, since a contact was near; since even the shortest block erred too
# much; and a step later: then a flight is tried again, with the shortest, at every COARSE-th place only. In a flight it is
# 1 + number of the length that comes next
READY, LANDED, ERRED, DOUBTFUL = 0.0, -1.0, -2.0, -3.0
COARSE = 8


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
        x, v = state_behind(con, block.first, unit, (begin.x, begin.v), block.nodes.force)
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
    nodes, calls, converged = nodes_of(con, field, first, last, (x, v), clock, h, weight)
    error2 = block_error2(con, last, nodes.force, weight) if converged else math.inf
    clear, end = 0, (x, v)
    if error2 <= ALLOWED:
        clear, end = units_clear(con, first_unit, (x, v), clock, nodes.force, units, reach)
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
        reach = reaches(con, con.contacts, 0, point.x, point.v, point.kins)
        if not are_clear(con, 0, reach, reach):
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
        damping, drive = block_work(con, block, (point.x, point.v))
        point, sample = _recorded(con, records, tally, point, block, clock, sample)
        tally, number = book_flight(tally, damping, drive), number + units
        if block.error2 <= DOUBLE and length < data.count - 1:
            length += 1
    landed = landed if length < 0 else 1.0 + length
    return Landing(code, calls, spent, point.x, point.v, point.clock, tally, sample, landed)
