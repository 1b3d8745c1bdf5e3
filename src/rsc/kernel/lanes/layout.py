"""Where the data of many cases lie: in a layout with a column per lane, or in a record of one case, with the same rows.

Vectors come first, vector k in the 2n rows from 2n k on, then the numbers; all are float64. A `View` reads and writes a whole
layout (a number of all lanes at once) or one case: a column of the layout, whose rows are W numbers apart, or a record.
"""

from itertools import accumulate
from typing import NamedTuple

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, register_jitable

from rsc.kernel.clock import Clock, Segment
from rsc.kernel.contact import Kinematics, Law, Motion, Place
from rsc.kernel.march import Contact, Progress, State
from rsc.kernel.model import (
    CONTACT_TIME,
    E_CONTACT,
    MODEL_VECTORS,
    N_COUNT,
    N_REAL,
    NORMAL,
    SAMPLES,
    STEPS,
    T_HI,
    WORK_VECTORS,
    H,
    Scalars,
    constants_of,
)
from rsc.kernel.rhs import Powers
from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import inlined, unrolled
from rsc.kernel.simd.lanes import LanesType, LaneVecType, MaskType, counted
from rsc.kernel.simd.registers import BYTES, F64, I64, VecType, frozen, join, register, split
from rsc.kernel.tally import Tally

# vectors: MODEL_VECTORS, WORK_VECTORS, and of a state, the last three only in the layout
STIFFNESS, DAMPING, CONTACT_ROW, FORCE_ROW, UNBALANCE, EULER, LOAD, SCALE_X, SCALE_V = range(len(MODEL_VECTORS))
FIRST_OF_STATE = len(MODEL_VECTORS) + len(WORK_VECTORS)
X, V, LEDGER_DAMPING, LEDGER_INPUT = range(len(MODEL_VECTORS), FIRST_OF_STATE)
A, POWER_DAMPING, POWER_DRIVE, N_VECTORS = range(FIRST_OF_STATE, FIRST_OF_STATE + 4)


def _rows(first, *sizes):
    """First rows of tuples of so many numbers one behind the other, and the row behind the last."""
    return tuple(accumulate(sizes, initial=first))


N_PLACE, N_KINEMATICS = len(Place._fields), len(Place._fields) + len(Motion._fields)
# numbers of a record: the scalars of its model; Work.real and Work.count, each in the order of its indices; addresses (exact in
# doubles: below 2^53) of the samples' x and of the first of three series behind it, all of so many rows, numbers in a row of the
# motion (2n, or 4n with velocities); corners of its schedule
SCALARS, REAL, COUNT, MOTION, FORCES, ROWS, IN_ROW, FIRST_CORNER, N_CORNERS, RECORD_NUMBERS = _rows(
    0, len(Scalars._fields), N_REAL, N_COUNT, 1, 1, 1, 1, 1, 1
)
# only in the layout: what State, Contact and Progress have beyond Work; address of the matrices in the record of a lane's case
SPEED, POWERS, KINEMATICS, RATE_SLOPE, LAW, NEAR_LIMIT, PIECE, FINITE, MATRICES, OF_ATTEMPT = _rows(
    RECORD_NUMBERS, len(Clock._fields) - 3, 3, N_KINEMATICS, 1, len(Law._fields), 1, len(Segment._fields), 1, 1
)
# whether a lane has a case; time of its next sample in s; of attempts that search a switch: length, tries so far, the length of
# the step after, verdict of the last; length and kinematics of the last; samples on their way out (4n + 3)
BUSY, DUE, H_SEARCH, TRIES, H_THEN, VERDICT, H_TRIED, ATTEMPT, OUTPUT = _rows(OF_ATTEMPT, 1, 1, 1, 1, 1, 1, 1, N_KINEMATICS)
# so many numbers, for `numbers` and `counts`
THREE, FOUR, SEVEN = (0.0,) * 3, (0.0,) * 4, (0.0,) * 7


@register_jitable
def matrix_rows(width):
    """Numbers of the damping's matrix and of the gyroscopics', which lie behind the numbers."""
    return width * width


@register_jitable
def first_matrix(width):
    """Row of a layout where the matrices begin."""
    return N_VECTORS * width + OUTPUT + 2 * width + 3


def layout_rows(width):
    """Rows of a layout."""
    return first_matrix(width) + matrix_rows(width)


SLOPES = 3  # vector of a layout of attempts from which on the slopes of a step lie, behind x, v and a


def attempt_rows(width, n_slopes):
    """Rows of a layout of attempts (`search.put_attempt`) of 2n numbers by a method of so many stages, a series at most."""
    return (SLOPES + 2 * (n_slopes + 1)) * width


@register_jitable
def record_length(width):
    """Numbers of a record before its matrices."""
    return N_VECTORS * width + RECORD_NUMBERS


class View(NamedTuple):
    """All lanes of a layout or one case: `lanes` is a tuple of W floats that carries W, or empty."""

    base: int  # address of the first row
    stride: int  # numbers from one row to the next, of one case only
    width: object  # a tuple of 2n floats that carries the width
    driven: object  # a tuple of as many floats as there are numbers of vectors of which the rest, on the stator, is zero
    lanes: object
    where: object  # a mask of the lanes that are written, or an empty tuple for all


def _places(builder, view, value, row, count):
    """Pointers to so many rows of a view from one on: registers of all lanes, or numbers of one case, a stride apart."""
    base, stride = (builder.extract_value(value, k) for k in (0, 1))
    data = builder.inttoptr(base, (register(len(view[4])) if len(view[4]) else F64).as_pointer())
    rows = (builder.add(row, ir.Constant(I64, k)) for k in range(count))
    return [builder.gep(data, [row if len(view[4]) else builder.mul(row, stride)]) for row in rows]


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
    """The numbers or registers of a value, or of all in a tuple, one after the other."""
    if isinstance(kind, types.BaseTuple):
        items = (_scatter(builder, part, builder.extract_value(value, i)) for i, part in enumerate(kind.types))
        return [part for item in items for part in item]
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


def _loaded(builder, view, value, row, count):
    """The registers or numbers of so many rows."""
    return [builder.load(place, align=_alignment(view)) for place in _places(builder, view, value, row, count)]


def _number_reader(whole=False):
    """Intrinsic (view, i, like) -> a tuple or named tuple of the numbers from number i on, of one case whole ones perhaps."""

    @intrinsic
    def read(typingctx, view, i, pattern):
        n_lanes, named = len(view[4]), isinstance(pattern, types.NamedTupleClass)
        kind = LanesType(n_lanes) if n_lanes else types.int64 if whole else types.float64
        count = len(pattern.instance_class._fields) if named else len(pattern)
        result = types.BaseTuple.from_types([kind] * count, pattern.instance_class if named else None)

        def codegen(context, builder, sig, args):
            numbers = _loaded(builder, view, args[0], _behind_vectors(builder, view, args[1]), count)
            counts = kind == types.int64
            return context.make_tuple(builder, result, [builder.fptosi(n, I64) for n in numbers] if counts else numbers)

        return result(view, types.intp, pattern), codegen

    return read


# like: a class of named tuples whose fields are all numbers, or a tuple that is as long
numbers, counts = _number_reader(), _number_reader(whole=True)


@inlined
def number(view, i):
    """A number: of all lanes or of the one case of the view."""
    return numbers(view, i, (0.0,))[0]


def _vector_loader(twice=False, driven=False, product=False):
    @intrinsic
    def load_vectors(typingctx, view, k, pattern):
        lanes, widths = len(view[4]), (len(view[2]), len(view[3]))
        whole, part = (LaneVecType(width, LanesType(lanes)) if lanes else VecType(width) for width in widths)
        kind = whole.product_type(part) if product else part if driven else whole
        result = types.UniTuple(kind, len(pattern))

        def codegen(context, builder, sig, args):
            vectors = []
            for j in range(len(pattern)):
                first = builder.mul(builder.add(args[1], ir.Constant(I64, j)), ir.Constant(I64, len(view[2])))
                numbers = _loaded(builder, view, args[0], first, kind.width)
                vectors.append(_gather(builder, kind, [numbers[i // 2 * 2 if twice else i] for i in range(kind.width)]))
            return context.make_tuple(builder, result, vectors)

        return result(view, types.intp, pattern), codegen

    return load_vectors


# as many vectors from vector k on as a tuple is long: any, those with equal numbers in both lanes of every pair, those that are
# zero on the stator, `vec.product`s with such
vectors, _pairs = _vector_loader(), _vector_loader(twice=True)
_driven, _products = _vector_loader(driven=True), _vector_loader(product=True)


@inlined
def vector(view, k):
    """Vector k."""
    return vectors(view, k, (0.0,))[0]


def _putter(first_row):
    """Intrinsic (view, i, value): write numbers, truth values or vectors, or all in a tuple, of all lanes or of one case."""

    @intrinsic
    def put(typingctx, view, i, value):
        where = view[5]

        def codegen(context, builder, sig, args):
            parts = _scatter(builder, value, args[2])
            places = _places(builder, view, args[0], first_row(builder, view, args[1]), len(parts))
            mask = builder.extract_value(args[0], 5)
            for part, place in zip(parts, places, strict=True):
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
    """Address of the first row of the matrices and bytes from row to row: for all lanes in the layout, for one in its record."""
    if len(view[4]) == 0:
        return lambda view: (int(number(view, MATRICES)), BYTES)
    return lambda view: (view.base + BYTES * view.stride * first_matrix(len(view.width)), BYTES * view.stride)


@unrolled
def _columns_in(view, matrices):
    """`Constants.columns`: rows of the layout for all lanes, for one case those of its record, one after the other."""
    if len(matrices) == 0:
        return lambda view, matrices: ()

    def columns_in(view, matrices):
        first, size = _first_row(view)
        return first if matrices[0] else 0, first + size * (matrix_rows(len(view.width)) // 2) if matrices[1] else 0

    return columns_in


@inlined
def constants_in(view, flags):
    """The constants; flags = (has_ring, has_euler, has_radius, matrices) of all lanes, the first three () for what no lane has:
    then there is no code for it. matrices = () for diagonals only or whether there is one of the damping, of the gyroscopics."""
    scalars = numbers(view, SCALARS, Scalars)
    radius = scalars.radius if len(flags[2]) > 0 else vec.spread(0.0, scalars.gap)
    scalars = radius, *scalars[1:-1], counted(scalars.max_steps)
    rows, driven, scales = _pairs(view, STIFFNESS, FOUR), _driven(view, UNBALANCE, THREE), _pairs(view, SCALE_X, (0.0, 0.0))
    return constants_of(rows, driven, scales, scalars, (len(flags[0]) > 0, len(flags[1]) > 0, _columns_in(view, flags[3])))


@inlined
def tally_in(view):
    """The sums."""
    (drive,) = _products(view, LEDGER_INPUT, (0.0,))
    work = Powers(vector(view, LEDGER_DAMPING), drive, *numbers(view, REAL + E_CONTACT, THREE))
    return Tally(work, number(view, REAL + CONTACT_TIME), *counts(view, COUNT + STEPS, SEVEN))


@inlined
def kinematics_in(view, i):
    """Kinematics from number i on."""
    return Kinematics(numbers(view, i, Place), numbers(view, i + N_PLACE, Motion))


@unrolled
def _power_in(view, matrices):
    """`Powers.damping` of a state, which only full matrices have."""
    if len(matrices) == 0:
        return lambda view, matrices: ()
    return lambda view, matrices: vector(view, POWER_DAMPING)


@unrolled
def _put_power(view, power):
    """Write `Powers.damping` of a state."""
    if isinstance(power, types.BaseTuple):
        return lambda view, power: None
    return lambda view, power: put_vector(view, POWER_DAMPING, power)


@inlined
def _state(view, matrices):
    (drive,) = _products(view, POWER_DRIVE, (0.0,))
    powers = Powers(_power_in(view, matrices), drive, *numbers(view, POWERS, THREE))
    clock = Clock(*numbers(view, REAL + T_HI, THREE), *numbers(view, SPEED, FOUR))
    motion = vector(view, X), vector(view, V), vector(view, A)
    return State(*motion, powers, clock, kinematics_in(view, KINEMATICS), number(view, RATE_SLOPE))


@inlined
def progress_in(view, flags):
    """Where the lanes, or the case in a column of the layout, are; flags as of `constants_in`."""
    normal, friction = counts(view, COUNT + NORMAL, (0.0, 0.0))
    sample, i_segment = counts(view, COUNT + SAMPLES, (0.0, 0.0))
    contact = Contact(normal, friction, numbers(view, LAW, Law), number(view, NEAR_LIMIT))
    start, piece, finite = _state(view, flags[3]), numbers(view, PIECE, Segment), number(view, FINITE) > 0.0
    return Progress(start, contact, number(view, REAL + H), tally_in(view), piece, i_segment, sample, finite)


@inlined
def put_state(view, progress):
    """Write what a step inside a contact state changes, but for its count of samples."""
    start, tally, before = progress.start, progress.tally, progress.tally.work
    put_vector(view, X, (start.x, start.v, before.damping))
    put_vector(view, LEDGER_INPUT, before.drive)
    put_vector(view, A, start.a)
    _put_power(view, start.powers.damping)
    put_vector(view, POWER_DRIVE, start.powers.drive)
    put_number(view, REAL + T_HI, start.clock[:3])
    put_number(view, SPEED, start.clock[3:])
    put_number(view, REAL + H, progress.h)
    put_number(view, REAL + CONTACT_TIME, (tally.contact_time, before.contact, before.friction, before.ring))
    put_number(view, COUNT + STEPS, tally[2:])
    put_number(view, POWERS, (start.powers.contact, start.powers.friction, start.powers.ring))
    put_number(view, KINEMATICS, (start.kin, start.rate_slope))
    put_number(view, FINITE, progress.finite)


@inlined
def put_progress(view, progress):
    """Write where the lanes, or the case in a column of the layout, are."""
    put_state(view, progress)
    contact = progress.contact
    put_number(view, COUNT + NORMAL, (contact.normal, contact.friction))
    put_number(view, COUNT + SAMPLES, (progress.sample, progress.i_segment))
    put_number(view, LAW, (contact.law, contact.near_limit, progress.segment))
