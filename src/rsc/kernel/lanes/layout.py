"""Where the data of many cases lie: in a room of one column per lane, or in a record of one case, with the same rows.

Vectors come first, vector k in the 2n rows from 2n k on, then the numbers; all are float64. A `View` reads and writes a whole
room (a number of all lanes at once) or one case: a column of the room, whose rows are W numbers apart, or a record.
"""

from typing import NamedTuple

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, register_jitable

from rsc.kernel.clock import Clock, Segment
from rsc.kernel.contact import Kinematics, Law, Motion, Place
from rsc.kernel.march import Here, Mode, Pace, State
from rsc.kernel.model import Constants
from rsc.kernel.rhs import Powers
from rsc.kernel.simd import vec
from rsc.kernel.simd.cases import CasesType, CaseVecType, MaskType, counted
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.simd.registers import BYTES, F64, I64, VecType, frozen, join, register, split
from rsc.kernel.tally import Tally

# vectors: of the model, of a run; the last three only in the room
STIFFNESS, DAMPING, CONTACT_ROW, FORCE_ROW, UNBALANCE, EULER, LOAD, SCALE_X, SCALE_V = range(9)
X, V, LEDGER_DAMPING, LEDGER_INPUT, A, POWER_DAMPING, POWER_DRIVE, N_VECTORS = range(9, 17)
# numbers: of the model
GAP, MU, K_C, B_C, RING_Y, RING_Z, RADIUS, SLIP_VELOCITY, SWITCH_TOL, PER_RTOL2 = range(10)
H_MAX, STABLE_OPEN, STABLE_CLOSING, STABLE_OPENING, RESOLVED_ANGLE, DIVERGENCE2, MAX_STEPS, RATE = range(10, 18)
# of a run
T_HI, T_LO, PHASE, H, H_OTHER, LOG_ERROR, NORMAL, FRICTION, CONTACT_TIME, E_CONTACT, E_FRICTION, E_DRIVE = range(18, 30)
STEPS, REJECTED, SWITCHES, ONSETS, RELEASES, LIMITED, STIFF, SAMPLE, SEGMENT, FINITE = range(30, 40)
# addresses (exact in doubles: below 2^53) of the samples' x and of the first of three series behind it, all of so many rows
CALLS, MOTION, FORCES, ROWS, FIRST_CORNER, N_CORNERS, RECORD_NUMBERS = range(40, 47)
# only in the room: first rows of tuples of numbers
SPEED, POWERS, PLACE, LAW, NEAR_LIMIT, PIECE, RUNNING = 46, 48, 51, 64, 68, 69, 73
# of attempts that search a switch: length and tries so far, the step-size control to go on with, verdict of the last;
# length and kinematics of the last
H_SEARCH, TRIES, H_THEN, LOG_ERROR_THEN, VERDICT, H_TRIED, ATTEMPT = 74, 75, 76, 77, 78, 79, 80
# p''; address of the matrices in the record of a lane's case; time of the next sample in s; cosine and sine of the rotation;
# samples on their way out (2n + 3)
RATE_SLOPE, MATRICES, DUE, COS, OUTPUT = 93, 94, 95, 96, 98


@register_jitable
def matrix_rows(width):
    """Numbers of the damping's matrix and of the gyroscopics', which lie behind the numbers."""
    return width * width


@register_jitable
def first_matrix(width):
    """Row of a room where the matrices begin."""
    return N_VECTORS * width + OUTPUT + width + 3


def room_rows(width):
    """Rows of a room."""
    return first_matrix(width) + matrix_rows(width)


SLOPES = 3  # vector of a room of attempts from which on the slopes of a step lie, behind x, v and a


def attempt_rows(width, stages):
    """Rows of a room of attempts (`looks.put_attempt`) of 2n numbers by a method of so many stages, a series at most."""
    return (SLOPES + 2 * (stages + 1)) * width


@register_jitable
def record_length(width):
    """Numbers of a record before its matrices."""
    return N_VECTORS * width + RECORD_NUMBERS


class View(NamedTuple):
    """All lanes of a room or one case: `cases` is a tuple of W floats that carries W, or empty."""

    base: int  # address of the first row
    stride: int  # numbers from one row to the next, of one case only
    lanes: object  # a tuple of 2n floats that carries the width
    driven: object  # a tuple of as many floats as there are numbers of vectors of which the rest, on the stator, is zero
    cases: object
    where: object  # a mask of the lanes that are written, or an empty tuple for all


def _places(builder, view, value, row, kind):
    """Pointers to the registers of a vector (or the number) of type `kind` at a row of a view; of one case every number has
    its own, a stride apart."""
    base, stride = (builder.extract_value(value, k) for k in (0, 1))
    if not isinstance(kind, VecType) or type(kind) is VecType:
        data, count = builder.inttoptr(base, F64.as_pointer()), kind.width if isinstance(kind, VecType) else 1
        rows = [builder.mul(builder.add(row, ir.Constant(I64, k)), stride) for k in range(count)]
    else:
        data = builder.inttoptr(base, register(kind.parts[0]).as_pointer())
        rows = [builder.add(row, ir.Constant(I64, k)) for k in range(len(kind.parts))]
    return [builder.gep(data, [k]) for k in rows]


def _alignment(view):
    """Rows of all lanes lie on addresses that are a multiple of their size."""
    return BYTES * max(len(view[4]), 1)


def _gather(builder, kind, numbers):
    """A value of type `kind` of what lies at its places."""
    if not isinstance(kind, VecType):
        return numbers[0]
    if type(kind) is not VecType:
        return join(builder, kind, numbers)
    parts, first = [], 0
    for size in kind.parts:
        part = ir.Constant(register(size), ir.Undefined)
        for k in range(size):
            part = builder.insert_element(part, numbers[first + k], ir.Constant(ir.IntType(32), k))
        parts.append(part)
        first += size
    return join(builder, kind, parts)


def _scatter(builder, kind, value):
    """What lies at the places of a value."""
    if isinstance(kind, types.Boolean | MaskType):
        to = F64 if isinstance(kind, types.Boolean) else register(kind.width)
        return [builder.uitofp(value, to)]
    if isinstance(kind, types.Integer):
        return [builder.sitofp(value, F64)]
    if not isinstance(kind, VecType):
        return [value]
    parts = split(builder, kind, value)
    if type(kind) is not VecType:
        return parts
    return [builder.extract_element(p, ir.Constant(ir.IntType(32), k)) for p in parts for k in range(p.type.count)]


# intrinsics, because Numba would compile a function anew for every constant it is called with


@intrinsic
def number(typingctx, view, i):
    """A number: of all lanes or of the one case of the view."""
    kind = CasesType(len(view[4])) if len(view[4]) else types.float64

    def codegen(context, builder, sig, args):
        (place,) = _places(builder, view, args[0], _behind_vectors(builder, view, args[1]), kind)
        return builder.load(place, align=_alignment(view))

    return kind(view, types.intp), codegen


def _vector_loader(twice=False, driven=False, product=False):
    @intrinsic
    def load_vector(typingctx, view, k):
        cases, widths = len(view[4]), (len(view[2]), len(view[3]))
        whole, part = (CaseVecType(width, CasesType(cases)) if cases else VecType(width) for width in widths)
        kind = whole.product_type(part) if product else part if driven else whole
        width = kind.width

        def codegen(context, builder, sig, args):
            places = _places(builder, view, args[0], builder.mul(args[1], ir.Constant(I64, len(view[2]))), kind)
            loaded = [builder.load(place, align=_alignment(view)) for place in places[:: 2 if twice else 1]]
            return _gather(builder, kind, [loaded[i // 2 if twice else i] for i in range(width)])

        return kind(view, types.intp), codegen

    return load_vector


# a vector, one with the same numbers in both lanes of every pair, one that is zero on the stator, a `vec.product` with such
vector, _pairs, _driven = _vector_loader(), _vector_loader(twice=True), _vector_loader(driven=True)
_product = _vector_loader(product=True)


@unrolled
def vectors(view, k, all_of):
    """As many vectors from vector k on as a tuple has items."""
    if len(all_of) == 0:
        return lambda view, k, all_of: ()
    return lambda view, k, all_of: (vector(view, k),) + vectors(view, k + 1, all_of[1:])  # noqa: RUF005


def _putter(first_row):
    """Write a number, a truth value or a vector of all lanes or of one case."""

    @intrinsic
    def put(typingctx, view, i, value):
        where = view[5]

        def codegen(context, builder, sig, args):
            kind = CasesType(value.width) if isinstance(value, MaskType) else value
            places = _places(builder, view, args[0], first_row(builder, view, args[1]), kind)
            mask = builder.extract_value(args[0], 5)
            for part, place in zip(_scatter(builder, value, args[2]), places, strict=True):
                if isinstance(where, MaskType):
                    old = builder.load(place, align=_alignment(view))
                    part = builder.select(mask, part, old if len(view[4]) == 8 else frozen(builder, old))
                builder.store(part, place, align=_alignment(view))
            return context.get_dummy_value()

        return types.none(view, types.intp, value), codegen

    return put


def _behind_vectors(builder, view, i):
    return builder.add(i, ir.Constant(I64, N_VECTORS * len(view[2])))


# value at number i and on; vector k
put_number = _putter(_behind_vectors)
put_vector = _putter(lambda builder, view, k: builder.mul(k, ir.Constant(I64, len(view[2]))))


@unrolled
def _first_row(view):
    """Address of the first row of the matrices and bytes from row to row: for all lanes in the room, for one in its record."""
    if len(view[4]) == 0:
        return lambda view: (int(number(view, MATRICES)), BYTES)
    return lambda view: (view.base + BYTES * view.stride * first_matrix(len(view.lanes)), BYTES * view.stride)


@unrolled
def _columns_in(view, matrices):
    """`Constants.columns`: rows of the room for all lanes, for one case those of its record, one after the other."""
    if len(matrices) == 0:
        return lambda view, matrices: ()

    def columns_in(view, matrices):
        first, size = _first_row(view)
        return first if matrices[0] else 0, first + size * (matrix_rows(len(view.lanes)) // 2) if matrices[1] else 0

    return columns_in


@inlined
def constants_in(view, flags):
    """The constants; flags = (has_ring, has_euler, has_radius, matrices) of all lanes, the first three () for what no lane has:
    then there is no code for it. matrices = () for diagonals only or whether there is one of the damping, of the gyroscopics."""
    radius = number(view, RADIUS) if len(flags[2]) > 0 else vec.spread(0.0, number(view, GAP))
    unbalance, euler, scale_v = _driven(view, UNBALANCE), _driven(view, EULER), _pairs(view, SCALE_V)
    return Constants(
        _pairs(view, STIFFNESS),
        _pairs(view, DAMPING),
        _pairs(view, CONTACT_ROW),
        _pairs(view, FORCE_ROW),
        unbalance,
        vec.times_i(unbalance),
        euler,
        vec.times_i(euler),
        _driven(view, LOAD),
        vec.alternate(_pairs(view, SCALE_X), scale_v),
        scale_v,
        number(view, GAP),
        number(view, MU),
        number(view, K_C),
        number(view, B_C),
        number(view, RING_Y),
        number(view, RING_Z),
        radius,
        number(view, SLIP_VELOCITY),
        number(view, SWITCH_TOL),
        number(view, PER_RTOL2),
        len(flags[0]) > 0,
        len(flags[1]) > 0,
        _columns_in(view, flags[3]),
        number(view, H_MAX),
        number(view, STABLE_OPEN),
        number(view, STABLE_CLOSING),
        number(view, STABLE_OPENING),
        number(view, RESOLVED_ANGLE),
        number(view, DIVERGENCE2),
        counted(number(view, MAX_STEPS)),
        number(view, RATE),
    )


@inlined
def tally_in(view):
    """The sums."""
    damping, drive = vector(view, LEDGER_DAMPING), _product(view, LEDGER_INPUT)
    return Tally(
        Powers(damping, drive, number(view, E_CONTACT), number(view, E_FRICTION), number(view, E_DRIVE)),
        number(view, CONTACT_TIME),
        counted(number(view, STEPS)),
        counted(number(view, REJECTED)),
        counted(number(view, SWITCHES)),
        counted(number(view, ONSETS)),
        counted(number(view, RELEASES)),
        counted(number(view, LIMITED)),
        counted(number(view, STIFF)),
    )


@inlined
def pace_in(view):
    """The step-size control."""
    return Pace(number(view, H), number(view, H_OTHER), number(view, LOG_ERROR))


@inlined
def kinematics_in(view, k):
    """Kinematics from number k on."""
    place = Place(
        number(view, k),
        number(view, k + 1),
        number(view, k + 2),
        number(view, k + 3),
        number(view, k + 4),
        number(view, k + 5),
        number(view, k + 6),
    )
    motion = Motion(
        number(view, k + 7),
        number(view, k + 8),
        number(view, k + 9),
        number(view, k + 10),
        number(view, k + 11),
        number(view, k + 12),
    )
    return Kinematics(place, motion)


@unrolled
def _power_in(view, matrices):
    """`Powers.damping` of a state, which only full matrices have."""
    if len(matrices) == 0:
        return lambda view, matrices: ()
    return lambda view, matrices: vector(view, POWER_DAMPING)


@unrolled
def _put_power(view, power):
    """Write that."""
    if isinstance(power, types.BaseTuple):
        return lambda view, power: None
    return lambda view, power: put_vector(view, POWER_DAMPING, power)


@inlined
def _state(view, matrices):
    powers = Powers(
        _power_in(view, matrices),
        _product(view, POWER_DRIVE),
        number(view, POWERS),
        number(view, POWERS + 1),
        number(view, POWERS + 2),
    )
    turn = number(view, SPEED), number(view, SPEED + 1), number(view, COS), number(view, COS + 1)
    clock = Clock(number(view, T_HI), number(view, T_LO), number(view, PHASE), *turn)
    motion = vector(view, X), vector(view, V), vector(view, A)
    return State(*motion, powers, clock, kinematics_in(view, PLACE), number(view, RATE_SLOPE))


@inlined
def here_in(view, flags):
    """Where the lanes, or the case in a column of the room, are; flags as of `constants_in`."""
    law = Law(number(view, LAW), number(view, LAW + 1), number(view, LAW + 2), number(view, LAW + 3))
    piece = Segment(number(view, PIECE), number(view, PIECE + 1), number(view, PIECE + 2), number(view, PIECE + 3))
    return Here(
        _state(view, flags[3]),
        Mode(counted(number(view, NORMAL)), counted(number(view, FRICTION)), law, number(view, NEAR_LIMIT)),
        pace_in(view),
        tally_in(view),
        piece,
        counted(number(view, SEGMENT)),
        counted(number(view, SAMPLE)),
        number(view, FINITE) > 0.0,
    )


@inlined
def put_kinematics(view, k, kin):
    """Write kinematics at number k and on."""
    place, motion = kin.place, kin.motion
    put_number(view, k, place.d_y)
    put_number(view, k + 1, place.d_z)
    put_number(view, k + 2, place.inverse)
    put_number(view, k + 3, place.distance)
    put_number(view, k + 4, place.penetration)
    put_number(view, k + 5, place.ring_y)
    put_number(view, k + 6, place.ring_z)
    put_number(view, k + 7, motion.rate)
    put_number(view, k + 8, motion.along)
    put_number(view, k + 9, motion.cross)
    put_number(view, k + 10, motion.tangential)
    put_number(view, k + 11, motion.slip)
    put_number(view, k + 12, motion.speed)


@inlined
def put_state(view, here):
    """Write what a step inside a mode changes, but for its count of samples."""
    now, tally, done = here.now, here.tally, here.tally.work
    put_vector(view, X, now.x)
    put_vector(view, V, now.v)
    put_number(view, T_HI, now.clock.hi)
    put_number(view, T_LO, now.clock.lo)
    put_number(view, PHASE, now.clock.phase)
    put_number(view, H, here.pace.h)
    put_number(view, LOG_ERROR, here.pace.log_error)
    put_vector(view, LEDGER_DAMPING, done.damping)
    put_vector(view, LEDGER_INPUT, done.drive)
    put_number(view, CONTACT_TIME, tally.contact_time)
    put_number(view, E_CONTACT, done.contact)
    put_number(view, E_FRICTION, done.friction)
    put_number(view, E_DRIVE, done.ring)
    put_number(view, STEPS, tally.steps)
    put_number(view, LIMITED, tally.limited)
    put_number(view, FINITE, here.finite)
    put_vector(view, A, now.a)
    _put_power(view, now.powers.damping)
    put_vector(view, POWER_DRIVE, now.powers.drive)
    put_number(view, POWERS, now.powers.contact)
    put_number(view, POWERS + 1, now.powers.friction)
    put_number(view, POWERS + 2, now.powers.ring)
    put_number(view, SPEED, now.clock.speed)
    put_number(view, COS, now.clock.cos)
    put_number(view, COS + 1, now.clock.sin)
    put_kinematics(view, PLACE, now.kin)
    put_number(view, RATE_SLOPE, now.rate_slope)


@inlined
def put_here(view, here):
    """Write where the lanes, or the case in a column of the room, are."""
    put_state(view, here)
    tally = here.tally
    put_number(view, H_OTHER, here.pace.h_other)
    put_number(view, NORMAL, here.mode.normal)
    put_number(view, FRICTION, here.mode.friction)
    put_number(view, REJECTED, tally.rejected)
    put_number(view, SWITCHES, tally.switches)
    put_number(view, ONSETS, tally.onsets)
    put_number(view, RELEASES, tally.releases)
    put_number(view, STIFF, tally.stiff)
    put_number(view, SAMPLE, here.sample)
    put_number(view, SEGMENT, here.i_segment)
    put_number(view, SPEED + 1, here.now.clock.speed_rate)
    law, piece = here.mode.law, here.segment
    put_number(view, LAW, law.k)
    put_number(view, LAW + 1, law.b)
    put_number(view, LAW + 2, law.mu)
    put_number(view, LAW + 3, law.mu_slope)
    put_number(view, NEAR_LIMIT, here.mode.near_limit)
    put_number(view, PIECE, piece.begin)
    put_number(view, PIECE + 1, piece.end)
    put_number(view, PIECE + 2, piece.speed)
    put_number(view, PIECE + 3, piece.speed_rate)
