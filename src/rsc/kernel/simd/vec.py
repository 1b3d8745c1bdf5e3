"""Packed vectors of doubles as a Numba type: the state of all coordinates in SIMD registers, without arrays and loops.

A `Vec` of width 2n holds n complex numbers as pairs (y_0, z_0, y_1, z_1, ...), in registers of 8, 4 and 2 doubles. Its width is
part of its type, so every number of coordinates compiles to straight-line packed instructions. The compiler never reorders or
contracts operations; `fma` is explicit and lane-wise, so that rotating the frame by 90 degrees changes no bit.
"""

import operator
from functools import cache, partial

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from rsc.kernel.simd.jit import constant, inlined, overloaded
from rsc.kernel.simd.registers import (
    F64,
    I32,
    I64,
    VecType,
    add,
    addresses,
    each,
    emitted,
    fma_lanewise,
    is_vec,
    join,
    keep_larger,
    register,
    rounded,
    splat,
    split,
    stored,
)
from rsc.kernel.simd.static import question, static


@intrinsic
def address(typingctx, array):
    """Address of an array's data as an integer, which unlike the array is passed on without reference counting."""

    def codegen(context, builder, sig, args):
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        return builder.ptrtoint(data, I64)

    return types.int64(array), codegen


def _width(kind):
    """Number of doubles, of the type of a vector or a tuple of numbers."""
    return kind.width if is_vec(kind) else len(kind)


width_of = constant(_width)


@intrinsic
def load_at(typingctx, base, offset, width):
    """Vector at an address, as wide as a vector or as the length of a tuple `width`, whose values do not matter."""
    vec = VecType(_width(width))

    def codegen(context, builder, sig, args):
        pointers = addresses(builder, args[0], args[1], vec)
        return join(builder, vec, [builder.load(pointer, align=8) for pointer in pointers])

    return vec(types.int64, types.intp, width), codegen


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
def load(array, width):
    """Vector of all numbers of a contiguous array."""
    return load_at(address(array), 0, width)


@question
def _in_one_register(width):
    """Whether a vector with as many doubles as a tuple has members is a single register."""
    return len(VecType(len(width)).parts) == 1


@static
def load_product(array, width):
    """Load a `product` of vectors that `store` wrote to a contiguous array: the first pair, or the vector if a single
    register."""
    return load(array, width) if _in_one_register(width) else load_at(address(array), 0, (0.0, 0.0))


@inlined
def row_at(base, i, pattern):
    """Vector number i of consecutive ones at an address, with the width of `pattern`."""
    return load_at(base, i * width_of(pattern), pattern)


@inlined
def store(array, a):
    """Write a vector into a contiguous array."""
    store_at(address(array), 0, a)


def of_one(make, doc=None):
    """Intrinsic a -> make(type of a, builder, code of a), of the same type."""

    @intrinsic
    def apply(typingctx, a):
        return emitted(a(a), partial(make, a))

    apply.__doc__ = doc
    return apply


def of_two(make, doc=None):
    """Intrinsic (a, b) -> make(their type, builder, codes), of two vectors of one type and of that type."""

    @intrinsic
    def apply(typingctx, a, b):
        matching = is_vec(a, b) and a == b
        return emitted(a(a, b), partial(make, a)) if matching else None

    apply.__doc__ = doc
    return apply


def lanewise(operation):
    """For `of_one` and `of_two`: an operation(builder, *registers) on all registers of vectors; numbers are broadcast."""

    def make(kind, builder, *values):
        return each(builder, kind, partial(operation, builder), *values)

    return make


def _overload_arithmetic(operation, instruction):
    apply = of_two(lanewise(instruction))

    @overloaded(operation)
    def operate(a, b):
        if is_vec(a, b) and a == b:
            return lambda a, b: apply(a, b)


_overload_arithmetic(operator.add, ir.IRBuilder.fadd)
_overload_arithmetic(operator.sub, ir.IRBuilder.fsub)
_overload_arithmetic(operator.truediv, ir.IRBuilder.fdiv)
_mul = of_two(lanewise(ir.IRBuilder.fmul))


@intrinsic
def _scale(typingctx, s, a):
    return emitted(a(s, a), partial(lanewise(ir.IRBuilder.fmul), a))


@overloaded(operator.mul)
def _vec_mul(a, b):
    if is_vec(a, b) and a == b:
        return lambda a, b: _mul(a, b)
    if is_vec(b) and isinstance(a, types.Float):
        return lambda a, b: _scale(a, b)


@intrinsic
def fma(typingctx, s, a, b):
    """s * a + b with one rounding per lane; `s` is a vector or a number; all three may be numbers."""

    def codegen(context, builder, sig, args):
        if not is_vec(b):
            return builder.fma(*args)
        return each(builder, b, partial(fma_lanewise, builder), *args)

    return b(s, a, b), codegen


def _weigh(builder, factor, part, total=None):
    """factor * part (+ total) for one register."""
    return builder.fmul(factor, part) if total is None else fma_lanewise(builder, factor, part, total)


def _weigh_one(builder, weight, part, *totals):
    """weight * part (+ total) for one register, with the weight from memory."""
    return _weigh(builder, stored(builder, weight, part.type), part, *totals)


@cache
def weighted_sum(weights):
    """Intrinsic (base, vectors) -> base + sum of weights_j vectors_j in this order, each with one rounding; base may be None.

    The weights are constants; vectors of weight zero are left out.
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

    return apply


times_i = of_one(VecType.turned, "Vector times the imaginary unit: (y, z) -> (-z, y) in every pair.")
swap = of_one(VecType.swapped, "Components of every pair exchanged: (y, z) -> (z, y).")
pair_sums = of_two(VecType.pair_sums, "(y + z of a, y + z of b) in every pair.")
alternate = of_two(VecType.alternated, "(y of a, z of b) in every pair.")
larger = of_two(lanewise(keep_larger), "Lane-wise maximum of two vectors of numbers >= 0; NaN where either is NaN.")
whole = of_one(lanewise(rounded), "Lane-wise rounding to the nearest integer, halves to even.")


@intrinsic
def fill(typingctx, y, z, pattern):
    """(y, z, y, z, ...) with the width of `pattern`."""

    return emitted(pattern(types.float64, types.float64, pattern), pattern.filled)


@intrinsic
def pair_sum(typingctx, a):
    """(sum of all y, sum of all z) of a vector or a `product`."""
    result = types.UniTuple(types.float64, 2)

    def codegen(context, builder, sig, args):
        return context.make_tuple(builder, result, a.one_pair(builder, args[0], add))

    return result(a), codegen


@intrinsic
def product(typingctx, a, b):
    """Lane-wise product of two vectors for `pair_sum`; if longer than one register, already summed to a pair."""

    return emitted(a.product_type(a, b), a.product) if a == b else None


@intrinsic
def largest(typingctx, a):
    """Largest of numbers >= 0, NaN if any lane is; both lanes of a pair must hold the same number."""

    return emitted(types.float64(a), lambda builder, *args: a.one_pair(builder, args[0], keep_larger)[0])


@intrinsic
def lane(typingctx, a, i):
    """Component i of a vector."""

    return emitted(types.float64(a, types.intp), a.get)


@intrinsic
def spread(typingctx, number, pattern):
    """A number in every lane, with the width of `pattern`; a constant is read from memory."""

    def codegen(context, builder, sig, args):
        known = getattr(args[0], "constant", 0.0)  # nonzero constants only: zero takes no instructions
        if known:
            return join(builder, pattern, [stored(builder, known, register(size)) for size in pattern.parts])
        return join(builder, pattern, [splat(builder, args[0], size) for size in pattern.parts])

    return pattern(number, pattern), codegen


@intrinsic
def from_numbers(typingctx, numbers, pattern):
    """Vector of a tuple of numbers, in registers of four if `pattern` is a vector without larger ones."""
    vec = VecType(len(numbers), 4 if is_vec(pattern) and pattern.largest < 8 else 8)

    def codegen(context, builder, sig, args):
        parts, first = [], 0
        for size in vec.parts:
            part = ir.Constant(register(size), ir.Undefined)
            for i in range(size):
                part = builder.insert_element(part, builder.extract_value(args[0], first + i), ir.Constant(I32, i))
            parts.append(part)
            first += size
        return join(builder, vec, parts)

    return vec(numbers, pattern), codegen


@intrinsic
def bits(typingctx, number):
    """The bit pattern of a number as an integer, converted to a float."""

    def codegen(context, builder, sig, args):
        return builder.sitofp(builder.bitcast(args[0], I64), F64)

    return number(number), codegen


@intrinsic
def times_columns(typingctx, base, a):
    """Real matrix times a complex vector: (n, 2n) numbers at an address, column by column, every entry twice."""

    return emitted(a(types.int64, a), a.columns)


@intrinsic
def times_components(typingctx, base, a):
    """Matrix that acts on y and z separately times a complex vector: (2n, 2n) numbers at an address, n columns for the vector, n
    for the swapped one, each entry for one component of the result."""

    return emitted(a(types.int64, a), lambda builder, base, value: a.columns(builder, base, value, a.swapped(builder, value)))
