"""Packed vectors of doubles as a Numba type: the state of all coordinates in SIMD registers, no arrays, no loops.

A `Vec` of width 2 n holds n complex numbers as pairs (y_0, z_0, y_1, z_1, ...), in registers of 8, 4 and 2 doubles. Its width is
part of its type, so every number of coordinates compiles to straight-line packed instructions. No operation is ever reordered or
contracted by the compiler; `fma` is written where it is wanted, and lane by lane only, so that a turn of the frame by 90 degrees
changes no bit.
"""

import operator
from functools import cache, partial

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from rsc.kernel.jit import inlined, overloaded
from rsc.kernel.registers import (
    F64,
    I32,
    I64,
    VecType,
    addresses,
    as_register,
    call_lanewise,
    each,
    fma_lanewise,
    is_vec,
    join,
    register,
    split,
)


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

    return vec(types.int64, types.intp, lanes), codegen


@intrinsic
def store_at(typingctx, base, offset, a):
    """Write a vector at an address."""

    def codegen(context, builder, sig, args):
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
        return each(builder, a, lambda p: builder.fmul(as_register(builder, s, args[0], p.type.count), p), args[1])

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
    """s * a + b with one rounding per lane; `s` is a vector or a number."""

    def codegen(context, builder, sig, args):
        if s == b:
            return each(builder, b, lambda x, y, z: fma_lanewise(builder, x, y, z), *args)

        def fused(y, z):
            return fma_lanewise(builder, as_register(builder, s, args[0], y.type.count), y, z)

        return each(builder, b, fused, *args[1:])

    return b(s, a, b), codegen


def _weigh(builder, weight, part, total=None):
    """weight * part (+ total) for one register."""
    factor = ir.Constant(part.type, [ir.Constant(F64, weight)] * part.type.count)
    return builder.fmul(factor, part) if total is None else fma_lanewise(builder, factor, part, total)


@cache
def weighted_sum(weights):
    """Intrinsic (base, vectors) -> base + sum of weights_j vectors_j in this order, each with one rounding; base None is none.

    The weights become constants of the compiled code; vectors of weight zero are left out.
    """

    @intrinsic
    def apply(typingctx, base, vectors):
        vec = vectors.dtype

        def codegen(context, builder, sig, args):
            totals = [] if base == types.none else [args[0]]
            for j, weight in enumerate(weights):
                if weight:
                    terms = (builder.extract_value(args[1], j), *totals)
                    totals = [each(builder, vec, partial(_weigh, builder, weight), *terms)]
            return totals[0]

        return vec(base, vectors), codegen

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
def fill(typingctx, y, z, like):
    """(y, z, y, z, ...) with the width of `like`."""

    def codegen(context, builder, sig, args):
        return like.filled(builder, args[0], args[1])

    return like(like.number, like.number, like), codegen


@intrinsic
def pair_sum(typingctx, a):
    """(sum of all y, sum of all z)."""
    result = types.UniTuple(a.number, 2)

    def codegen(context, builder, sig, args):
        return context.make_tuple(builder, result, a.one_pair(builder, args[0], lambda bld, p, q: bld.fadd(p, q)))

    return result(a), codegen


def _keep_larger(builder, p, q):
    # numbers >= +0 are ordered like their bits read as unsigned integers, and any NaN lies above them all
    bits = ir.VectorType(I64, p.type.count)
    above = builder.icmp_unsigned(">", builder.bitcast(p, bits), builder.bitcast(q, bits))
    return builder.select(above, p, q)


@intrinsic
def larger(typingctx, a, b):
    """Lane by lane the larger of two vectors of numbers >= 0, NaN where either is NaN."""

    def codegen(context, builder, sig, args):
        return each(builder, a, lambda p, q: _keep_larger(builder, p, q), *args)

    return (a(a, b), codegen) if is_vec(a, b) and a == b else None


@intrinsic
def largest(typingctx, a):
    """Largest of numbers >= 0, or NaN as soon as one lane is NaN; both lanes of a pair must hold the same number."""

    def codegen(context, builder, sig, args):
        return a.one_pair(builder, args[0], _keep_larger)[0]

    return a.number(a), codegen


@intrinsic
def lane(typingctx, a, i):
    """One number of a vector of a single register."""

    def codegen(context, builder, sig, args):
        return a.get(builder, *args)

    return a.number(a, types.intp), codegen


@intrinsic
def put(typingctx, a, i, number):
    """A vector of a single register with one lane replaced."""

    def codegen(context, builder, sig, args):
        return a.put(builder, *args)

    return a(a, types.intp, a.number), codegen


@intrinsic
def spread(typingctx, number, like):
    """A number in every lane, with the width of `like` (which may be a number itself)."""
    if like == types.float64:
        return like(number, like), lambda context, builder, sig, args: args[0]
    kind = number.over(like) if isinstance(number, VecType) else like

    def codegen(context, builder, sig, args):
        return join(builder, kind, [as_register(builder, number, args[0], size) for size in kind.parts])

    return kind(number, like), codegen


@intrinsic
def from_numbers(typingctx, numbers):
    """Vector (a single register) of a tuple of 2, 4 or 8 numbers."""
    vec = VecType(len(numbers))

    def codegen(context, builder, sig, args):
        value = ir.Constant(register(vec.width), ir.Undefined)
        for i in range(vec.width):
            value = builder.insert_element(value, builder.extract_value(args[0], i), ir.Constant(I32, i))
        return value

    return (vec(numbers), codegen) if len(vec.parts) == 1 else None


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
