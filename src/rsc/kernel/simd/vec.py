"""Packed vectors of doubles as a Numba type: the state of all coordinates in SIMD registers, no arrays, no loops.

A `Vec` of width 2 n holds n complex numbers as pairs (y_0, z_0, y_1, z_1, ...), in registers of 8, 4 and 2 doubles. Its width is
part of its type, so every number of coordinates compiles to straight-line packed instructions; only vectors of many lie in memory
(wide.py). No operation is ever reordered or contracted by the compiler; `fma` is written where it is wanted, and lane by lane
only, so that a turn of the frame by 90 degrees changes no bit.
"""

import operator
from functools import cache, partial

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from rsc.kernel.simd.jit import inlined, overloaded, unrolled
from rsc.kernel.simd.registers import (
    F64,
    I32,
    I64,
    VecType,
    add,
    addresses,
    call_lanewise,
    each,
    fma_lanewise,
    is_vec,
    join,
    keep_larger,
    register,
    split,
    stored,
)
from rsc.kernel.simd.wide import RoomType, WideType, close_room, halved, narrow, new_room, use_half, value_of


@intrinsic
def address(typingctx, array):
    """Address of an array's data as an integer: unlike the array it can be handed on without counting references."""

    def codegen(context, builder, sig, args):
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        return builder.ptrtoint(data, I64)

    return types.int64(array), codegen


@intrinsic
def load_at(typingctx, base, offset, lanes):
    """Vector of `len(lanes)` doubles at an address; `lanes` is a tuple that only carries the width."""
    vec = VecType(len(lanes))

    def codegen(context, builder, sig, args):
        pointers = addresses(builder, args[0], args[1], vec)
        return join(builder, vec, [builder.load(pointer, align=8) for pointer in pointers])

    def wide(context, builder, sig, args):
        source = builder.gep(builder.inttoptr(args[0], F64.as_pointer()), [args[1]])
        return each(builder, kind, lambda part: part, value_of(builder, source, args[2]))

    if isinstance(lanes, RoomType):
        kind = WideType(len(lanes))
        return kind(types.int64, types.intp, lanes), wide
    return vec(types.int64, types.intp, lanes), codegen


def _room(lanes, is_series):
    if len(lanes) <= narrow(is_series):
        return lanes(lanes), lambda context, builder, sig, args: args[0]
    kind = RoomType(len(lanes))
    return kind(lanes), lambda context, builder, sig, args: new_room(builder, kind.width)


@intrinsic
def room_of_pair(typingctx, lanes):
    """What `load` makes the vectors of a run by a Runge-Kutta pair of: `lanes`, or for many a room in memory, to be closed."""
    return _room(lanes, is_series=False)


@intrinsic
def room_of_series(typingctx, lanes):
    """As `room_of_pair`, of a run by a Taylor series."""
    return _room(lanes, is_series=True)


@intrinsic
def close(typingctx, room):
    """Give the memory of a room back, and with it all vectors in it."""

    def codegen(context, builder, sig, args):
        if isinstance(room, RoomType):
            close_room(builder, args[0])
        return context.get_dummy_value()

    return types.none(room), codegen


@intrinsic
def mark(typingctx, like):
    """How far the room of `like` is filled."""

    def codegen(context, builder, sig, args):
        return builder.load(builder.extract_value(args[0], 1)) if isinstance(like, WideType) else ir.Constant(I64, 0)

    return types.int64(like), codegen


@intrinsic
def release(typingctx, like, to):
    """Let the room of `like` be filled again from a mark on: vectors made since last until another is made."""

    def codegen(context, builder, sig, args):
        if isinstance(like, WideType):
            builder.store(args[1], builder.extract_value(args[0], 1))
        return context.get_dummy_value()

    return types.none(like, types.int64), codegen


@intrinsic
def halves(typingctx, like):
    """Two marks, where the halves of what is left of the room of `like` begin."""

    def codegen(context, builder, sig, args):
        marks = (ir.Constant(I64, 0),) * 2
        if isinstance(like, WideType):
            marks = halved(builder, builder.extract_value(args[0], 1))
        return context.make_tuple(builder, sig.return_type, marks)

    return types.UniTuple(types.int64, 2)(like), codegen


@intrinsic
def use(typingctx, like, half):
    """Let one half of the room of `like` be filled anew, from its beginning to its end."""

    def codegen(context, builder, sig, args):
        if isinstance(like, WideType):
            use_half(builder, builder.extract_value(args[0], 1), args[1])
        return context.get_dummy_value()

    return types.none(like, types.int64), codegen


@intrinsic
def moved(typingctx, place, a):
    """The vector, put in the memory of the vector `place` if it is in memory at all."""

    def codegen(context, builder, sig, args):
        if not isinstance(a, WideType):
            return args[1]
        a.copy(builder, *(builder.extract_value(value, 0) for value in (args[1], args[0])))
        return args[0]

    return a(place, a), codegen


@intrinsic
def store_at(typingctx, base, offset, a):
    """Write a vector at an address."""

    def codegen(context, builder, sig, args):
        if isinstance(a, WideType):
            target = builder.gep(builder.inttoptr(args[0], F64.as_pointer()), [args[1]])
            a.copy(builder, builder.extract_value(args[2], 0), target)
            return context.get_dummy_value()
        pointers = addresses(builder, args[0], args[1], a)
        for part, pointer in zip(split(builder, a, args[2]), pointers, strict=True):
            builder.store(part, pointer, align=8)
        return context.get_dummy_value()

    return types.none(types.int64, types.intp, a), codegen


@intrinsic
def store_number(typingctx, base, offset, number):
    """Write a number at an address."""

    def codegen(context, builder, sig, args):
        pointer = builder.gep(builder.inttoptr(args[0], F64.as_pointer()), [args[1]])
        builder.store(args[2], pointer)
        return context.get_dummy_value()

    return types.none(types.int64, types.intp, types.float64), codegen


@intrinsic
def number_at(typingctx, base, offset):
    """Number at an address."""

    def codegen(context, builder, sig, args):
        return builder.load(builder.gep(builder.inttoptr(args[0], F64.as_pointer()), [args[1]]))

    return types.float64(types.int64, types.intp), codegen


@inlined
def load(array, lanes):
    """Vector of all numbers of a contiguous array."""
    return load_at(address(array), 0, lanes)


@unrolled
def load_product(array, lanes):
    """A `product` of vectors from a contiguous array, for `store`: of a vector that is a pair the first."""
    if isinstance(lanes, RoomType) or len(VecType(len(lanes)).parts) > 1:
        return lambda array, lanes: load_at(address(array), 0, (0.0, 0.0))
    return lambda array, lanes: load(array, lanes)


@inlined
def store(array, a):
    """Write a vector into a contiguous array."""
    store_at(address(array), 0, a)


def _lanewise(op_name):
    @intrinsic
    def apply(typingctx, a, b):
        def codegen(context, builder, sig, args):
            return each(builder, a, getattr(builder, op_name), *args)

        return (a(a, b), codegen) if is_vec(a, b) and a == b else None

    return apply


_add, _sub, _mul, _div = (_lanewise(name) for name in ("fadd", "fsub", "fmul", "fdiv"))


@intrinsic
def _scale(typingctx, s, a):
    def codegen(context, builder, sig, args):
        return each(builder, a, builder.fmul, *args)

    return a(s, a), codegen


@overloaded(operator.add)
def _vec_add(a, b):
    if is_vec(a, b) and a == b:
        return lambda a, b: _add(a, b)


@overloaded(operator.sub)
def _vec_sub(a, b):
    if is_vec(a, b) and a == b:
        return lambda a, b: _sub(a, b)


@overloaded(operator.truediv)
def _vec_div(a, b):
    if is_vec(a, b) and a == b:
        return lambda a, b: _div(a, b)


@overloaded(operator.mul)
def _vec_mul(a, b):
    if is_vec(a, b) and a == b:
        return lambda a, b: _mul(a, b)
    if is_vec(b) and (a == b.number or isinstance(a, types.Float)):
        return lambda a, b: _scale(a, b)


@intrinsic
def fma(typingctx, s, a, b):
    """s * a + b with one rounding per lane; `s` is a vector or a number, and so may be all three."""

    def codegen(context, builder, sig, args):
        if not is_vec(b):
            return builder.fma(*args)
        return each(builder, b, lambda x, y, z: fma_lanewise(builder, x, y, z), *args)

    return b(s, a, b), codegen


def _weigh(builder, factor, part, total=None):
    """factor * part (+ total) for one register."""
    return builder.fmul(factor, part) if total is None else fma_lanewise(builder, factor, part, total)


def _weigh_one(builder, weight, part, *totals):
    """weight * part (+ total) for one register of a vector in registers."""
    return _weigh(builder, stored(builder, weight, part.type), part, *totals)


@cache
def weighted_sum(weights):
    """Intrinsic (base, vectors) -> base + sum of weights_j vectors_j in this order, each with one rounding; base None is none.

    The weights are constants; vectors of weight zero are left out. For fused functions.
    """

    @intrinsic
    def apply(typingctx, base, vectors):
        vec = vectors.dtype

        def codegen(context, builder, sig, args):
            totals = [] if base == types.none else [args[0]]
            for j, weight in enumerate(weights):
                if weight:
                    part = builder.extract_value(args[1], j)
                    totals = [each(builder, vec, partial(_weigh_one, builder, weight), part, *totals)]
            return totals[0]

        return vec(base, vectors), codegen

    apply.row_weights = weights
    return apply


@intrinsic
def times_i(typingctx, a):
    """The vector times the imaginary unit: (y, z) -> (-z, y) in every pair."""

    def codegen(context, builder, sig, args):
        return a.turned(builder, args[0])

    return a(a), codegen


@intrinsic
def swap(typingctx, a):
    """The two numbers of every pair exchanged: (y, z) -> (z, y)."""

    def codegen(context, builder, sig, args):
        return a.swapped(builder, args[0])

    return a(a), codegen


@intrinsic
def pair_sums(typingctx, a, b):
    """(y + z of a, y + z of b) in every pair."""

    def codegen(context, builder, sig, args):
        return a.pair_sums(builder, *args)

    return (a(a, b), codegen) if is_vec(a, b) and a == b else None


@intrinsic
def alternate(typingctx, a, b):
    """(y of a, z of b) in every pair."""

    def codegen(context, builder, sig, args):
        return a.alternated(builder, *args)

    return (a(a, b), codegen) if is_vec(a, b) and a == b else None


@intrinsic
def fill(typingctx, y, z, like):
    """(y, z, y, z, ...) with the width of `like`."""

    def codegen(context, builder, sig, args):
        return like.filled(builder, *args)

    return like(like.number, like.number, like), codegen


@intrinsic
def pair_sum(typingctx, a):
    """(sum of all y, sum of all z) of a vector or a `product`."""
    result = types.UniTuple(a.number, 2)

    def codegen(context, builder, sig, args):
        return context.make_tuple(builder, result, a.one_pair(builder, args[0], add))

    return result(a), codegen


@intrinsic
def product(typingctx, a, b):
    """The product of two vectors lane by lane, to be summed (`pair_sum`): of more than a register it is done at once, to a pair.
    The second may have fewer numbers, with zeros behind them."""

    def codegen(context, builder, sig, args):
        return a.product(builder, b, *args)

    return a.product_type(b)(a, b), codegen


@intrinsic
def larger(typingctx, a, b):
    """Lane by lane the larger of two vectors of numbers >= 0, NaN where either is NaN."""

    def codegen(context, builder, sig, args):
        return each(builder, a, lambda p, q: keep_larger(builder, p, q), *args)

    return (a(a, b), codegen) if is_vec(a, b) and a == b else None


@intrinsic
def largest(typingctx, a):
    """Largest of numbers >= 0, or NaN as soon as one lane is NaN; both lanes of a pair must hold the same number."""

    def codegen(context, builder, sig, args):
        return a.one_pair(builder, args[0], keep_larger)[0]

    return a.number(a), codegen


@intrinsic
def lane(typingctx, a, i):
    """One number of a vector."""

    def codegen(context, builder, sig, args):
        return a.get(builder, *args)

    return a.number(a, types.intp), codegen


@intrinsic
def put(typingctx, a, i, number):
    """A vector with one lane replaced."""

    def codegen(context, builder, sig, args):
        return a.put(builder, *args)

    return a(a, types.intp, a.number), codegen


@intrinsic
def spread(typingctx, number, like):
    """A number in every lane, with the width of `like` (which may be a number itself); a constant comes from memory."""
    if like == types.float64:
        return like(number, like), lambda context, builder, sig, args: args[0]
    kind = number.over(like) if isinstance(number, VecType) else like

    def codegen(context, builder, sig, args):
        known = getattr(args[0], "constant", 0.0)  # of a constant not zero, which takes no instructions
        if known and not isinstance(kind, WideType):
            return join(builder, kind, [stored(builder, known, register(size)) for size in kind.parts])
        return each(builder, kind, lambda part, *_: part, *args if kind == like else args[:1])

    return kind(number, like), codegen


@intrinsic
def from_numbers(typingctx, numbers, like):
    """Vector of a tuple of numbers, in registers of four if `like` is a vector without larger ones."""
    vec = VecType(len(numbers), 4 if type(like) is VecType and like.largest < 8 else 8)

    def codegen(context, builder, sig, args):
        parts, first = [], 0
        for size in vec.parts:
            part = ir.Constant(register(size), ir.Undefined)
            for i in range(size):
                part = builder.insert_element(part, builder.extract_value(args[0], first + i), ir.Constant(I32, i))
            parts.append(part)
            first += size
        return join(builder, vec, parts)

    return vec(numbers, like), codegen


@intrinsic
def whole(typingctx, a):
    """Lane by lane the nearest whole number, halves to even."""

    def codegen(context, builder, sig, args):
        return each(builder, a, lambda part: call_lanewise(builder, "llvm.rint", part), args[0])

    return a(a), codegen


@intrinsic
def bits(typingctx, number):
    """The bits of a number read as an integer, as a number again."""

    def codegen(context, builder, sig, args):
        whole_number = I64 if number == types.float64 else ir.VectorType(I64, number.width)
        return builder.sitofp(builder.bitcast(args[0], whole_number), args[0].type)

    return number(number), codegen


@intrinsic
def times_columns(typingctx, base, a):
    """Real matrix times the complex vector: at the address (n, 2 n) numbers, column after column, every entry twice."""

    def codegen(context, builder, sig, args):
        return a.columns(builder, *args)

    return a(types.int64, a), codegen


@intrinsic
def width(typingctx, a):
    """Number of lanes."""

    def codegen(context, builder, sig, args):
        return ir.Constant(I64, a.width)

    return types.int64(a), codegen
