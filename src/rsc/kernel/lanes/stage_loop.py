"""A pair's step of many cases with its stages as a loop, where step.py writes them out.

With 16 registers most of what the stages of four cases need lies in memory anyway, and written out they are longer than what a
processor keeps of decoded instructions: it waits for the next ones. The loop has the same operations in the same order, so every
case keeps the bits it has alone. The slopes lie in the layout of attempts, the table in memory.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from rsc.kernel.clock import turn_of, turns_after
from rsc.kernel.contact import Kinematics, motion, place_anyhow
from rsc.kernel.lanes.layout import SLOPES, put_vector, vector, vectors
from rsc.kernel.losses import lost_until
from rsc.kernel.rhs import Powers, accelerations, field_itself, no_powers, place_at
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined
from rsc.kernel.simd.registers import F64, I64
from rsc.kernel.step import Step, begun, velocity
from rsc.kernel.tableau import positions_of, table_of

# a line of the table: node and weight of a stage, then for each slope known there its weights in v and in x of the next stage
NODE, WEIGHT, OF_V, OF_X = range(4)


def _line(table):
    """Numbers of a line."""
    return OF_V + 2 * len(table.nodes)


def _numbers(table):
    """The lines of all stages and of the step's end."""
    numbers, of_v, of_x = [], ((), *table.rows, ()), (*positions_of(table).rows, ())
    for i, stage in enumerate(zip((*table.nodes, 1.0), (*table.weights, 0.0), strict=True)):
        line = [*stage, *(weight for both in zip(of_v[i], of_x[i], strict=True) for weight in both)]
        numbers += line + [0.0] * (_line(table) - len(line))
    return numbers


@intrinsic
def _entry(typingctx, method, i, k):
    """Number k of line i of a method's table."""
    table = table_of(method)

    def codegen(context, builder, sig, args):
        numbers, name = _numbers(table), f"rsc.table{len(table.nodes)}"
        place = builder.module.globals.get(name)
        if place is None:
            place = ir.GlobalVariable(builder.module, ir.ArrayType(F64, len(numbers)), name)
            place.initializer = ir.Constant(place.value_type, [ir.Constant(F64, number) for number in numbers])
            place.linkage, place.global_constant = "linkonce", True
        at = builder.add(builder.mul(args[1], ir.Constant(I64, _line(table))), args[2])
        return builder.load(builder.gep(place, [ir.Constant(I64, 0), at]))

    return types.float64(method, types.intp, types.intp), codegen


@inlined
def _turn_at(clock, clock_end, h, node):
    """Rotation at a node, the one of `step._stage_turns`."""
    return turn_of(clock_end) if node == 1.0 else turns_after(clock, h * node)


@inlined
def _summed(total, attempted, method, i, kind):
    """A vector and the slopes known at stage i by their weights (OF_V or OF_X), as `vec.weighted_sum` adds them.

    Those of weight zero as well, which changes no bit: a slope that is no number makes all after it none, and the total is -0.0
    only of a coordinate at rest, whose slopes are then all zeros of one sign.
    """
    for j in range(i):
        total = vec.fma(_entry(method, i, kind + 2 * j), vector(attempted, SLOPES + j), total)
    return total


@inlined
def rolled_attempt(con, law, start, before, clock_end, h, attempted, method):
    """`step.attempt` by a pair; leaves the slopes of the stages in the layout of attempts."""
    n, clock = len(method), start.clock
    field_h, first, work, x, d = begun(con, law, start, before, h, method)
    rise = start.v
    put_vector(attempted, SLOPES, first[0])
    for i in range(1, n):
        turn = _turn_at(clock, clock_end, h, _entry(method, i, NODE))
        place = place_at(con, field_h.law, d, turn)
        v = _summed(start.v, attempted, method, i, OF_V)
        state = x, v, vec.product(con.contact_row, v)
        rise = _summed(_entry(method, i + 1, NODE) * start.v, attempted, method, i, OF_X)
        x = vec.fma(h, rise, start.x)
        d = vec.product(con.contact_row, x)
        a, work = accelerations(con, field_h, state, turn, place, _entry(method, i, WEIGHT), work)
        put_vector(attempted, SLOPES + i, a)
    slopes, turn = vectors(attempted, SLOPES, method), turn_of(clock_end)
    place = place_anyhow(con, vec.pair_sum(d), turn)
    v, d_dot = velocity(method, (start.x, start.v), slopes, con.contact_row)
    a, powers = accelerations(con, field_itself(con, law), (x, v, d_dot), turn, place, 1.0, no_powers(h))
    kin = Kinematics(place, motion(con, vec.pair_sum(d_dot), place, turn))
    slopes = slopes + (h * a,)  # noqa: RUF005
    damping = lost_until(con, field_h, before.damping, work.damping, (start.v, rise, v), slopes)
    work = Powers(damping, work.drive, work.contact, work.friction, work.ring)
    return Step(start.x, start.v, x, v, a, powers, kin, slopes, work)
