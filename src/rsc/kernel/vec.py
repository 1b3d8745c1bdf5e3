"""Packed vectors of doubles as a Numba type: the state of all coordinates in SIMD registers, no arrays, no loops.

A `Vec` of width 2 n holds n complex numbers as pairs (y_0, z_0, y_1, z_1, ...). Its width is part of its type, so every
number of coordinates compiles to straight-line packed instructions. No operation is ever reordered or contracted by the
compiler; `fma` is written where it is wanted, and lane by lane only, so that a turn of the frame by 90 degrees changes no bit.
"""

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, models, overload, register_model

_F64 = ir.DoubleType()
_I32 = ir.IntType(32)


class VecType(types.Type):
    """Numba type of a packed vector of `width` doubles."""

    def __init__(self, width):
        self.width = width
        super().__init__(name=f"Vec{width}")


@register_model(VecType)
class _VecModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ir.VectorType(_F64, fe_type.width))


def _llvm(vec):
    return ir.VectorType(_F64, vec.width)


def _is_vec(*args):
    return all(isinstance(a, VecType) for a in args)


def _shuffle(builder, a, b, lanes):
    mask = ir.Constant(ir.VectorType(_I32, len(lanes)), [ir.Constant(_I32, i) for i in lanes])
    return builder.shuffle_vector(a, b, mask)


def _splat(builder, scalar, width):
    undef = ir.Constant(ir.VectorType(_F64, width), ir.Undefined)
    one = builder.insert_element(undef, scalar, ir.Constant(_I32, 0))
    return _shuffle(builder, one, undef, [0] * width)


def _address(context, builder, array_type, array, offset, vec):
    """Pointer to `array[offset]` seen as a vector (numpy guarantees 8-byte alignment only)."""
    data = context.make_array(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [offset]), _llvm(vec).as_pointer())


def _fma_function(builder, vec):
    name = f"llvm.fma.v{vec.width}f64"
    ty = _llvm(vec)
    return cgutils.get_or_insert_function(builder.module, ir.FunctionType(ty, [ty] * 3), name)


@intrinsic
def load(typingctx, array, offset, lanes):
    """Vector of `len(lanes)` doubles from a contiguous array; `lanes` is a tuple that only carries the width."""
    vec = VecType(len(lanes))

    def codegen(context, builder, sig, args):
        pointer = _address(context, builder, sig.args[0], args[0], args[1], vec)
        return builder.load(pointer, align=8)

    return vec(array, types.intp, lanes), codegen


@intrinsic
def store(typingctx, array, offset, a):
    """Write a vector into a contiguous array."""

    def codegen(context, builder, sig, args):
        pointer = _address(context, builder, sig.args[0], args[0], args[1], sig.args[2])
        builder.store(args[2], pointer, align=8)
        return context.get_dummy_value()

    return types.none(array, types.intp, a), codegen


def _lanewise(op_name):
    @intrinsic
    def apply(typingctx, a, b):
        def codegen(context, builder, sig, args):
            return getattr(builder, op_name)(*args)

        return (a(a, b), codegen) if _is_vec(a, b) and a == b else None

    return apply


_add, _sub, _mul, _div = (_lanewise(name) for name in ("fadd", "fsub", "fmul", "fdiv"))


@intrinsic
def _scale(typingctx, s, a):
    def codegen(context, builder, sig, args):
        return builder.fmul(_splat(builder, args[0], sig.args[1].width), args[1])

    return a(types.float64, a), codegen


@overload(operator.add)
def _vec_add(a, b):
    if _is_vec(a, b):
        return lambda a, b: _add(a, b)


@overload(operator.sub)
def _vec_sub(a, b):
    if _is_vec(a, b):
        return lambda a, b: _sub(a, b)


@overload(operator.truediv)
def _vec_div(a, b):
    if _is_vec(a, b):
        return lambda a, b: _div(a, b)


@overload(operator.mul)
def _vec_mul(a, b):
    if _is_vec(a, b):
        return lambda a, b: _mul(a, b)
    if isinstance(a, types.Float) and _is_vec(b):
        return lambda a, b: _scale(a, b)


@intrinsic
def fma(typingctx, s, a, b):
    """s * a + b with one rounding per lane; `s` is a vector or a number."""
    vec = b

    def codegen(context, builder, sig, args):
        factor = args[0] if _is_vec(sig.args[0]) else _splat(builder, args[0], vec.width)
        return builder.call(_fma_function(builder, vec), [factor, args[1], args[2]])

    return vec(s, a, b), codegen


@intrinsic
def times_i(typingctx, a):
    """The vector times the imaginary unit: (y, z) -> (-z, y) in every pair."""

    def codegen(context, builder, sig, args):
        lanes = [i + 1 if i % 2 == 0 else i - 1 for i in range(a.width)]
        swapped = _shuffle(builder, args[0], args[0], lanes)
        signs = ir.Constant(_llvm(a), [ir.Constant(_F64, -1.0 if i % 2 == 0 else 1.0) for i in range(a.width)])
        return builder.fmul(swapped, signs)

    return a(a), codegen


@intrinsic
def swap(typingctx, a):
    """The two numbers of every pair exchanged: (y, z) -> (z, y)."""

    def codegen(context, builder, sig, args):
        return _shuffle(builder, args[0], args[0], [i ^ 1 for i in range(a.width)])

    return a(a), codegen


@intrinsic
def fill(typingctx, y, z, like):
    """(y, z, y, z, ...) with the width of `like`."""

    def codegen(context, builder, sig, args):
        undef = ir.Constant(ir.VectorType(_F64, 2), ir.Undefined)
        pair = builder.insert_element(undef, args[0], ir.Constant(_I32, 0))
        pair = builder.insert_element(pair, args[1], ir.Constant(_I32, 1))
        return _shuffle(builder, pair, undef, [i % 2 for i in range(like.width)])

    return like(types.float64, types.float64, like), codegen


def _halve(builder, value, width, stride, combine):
    """Combine groups of `stride` lanes pairwise until one group is left."""
    groups = [_shuffle(builder, value, value, list(range(i, i + stride))) for i in range(0, width, stride)]
    while len(groups) > 1:
        paired = [combine(builder, *groups[i : i + 2]) for i in range(0, len(groups) - 1, 2)]
        groups = paired + groups[2 * len(paired) :]
    return groups[0]


def _elements(builder, value, count):
    return [builder.extract_element(value, ir.Constant(_I32, i)) for i in range(count)]


@intrinsic
def pair_sum(typingctx, a):
    """(sum of all y, sum of all z)."""
    result = types.UniTuple(types.float64, 2)

    def codegen(context, builder, sig, args):
        total = _halve(builder, args[0], a.width, 2, lambda bld, p, q: bld.fadd(p, q))
        return context.make_tuple(builder, result, _elements(builder, total, 2))

    return result(a), codegen


@intrinsic
def largest(typingctx, a):
    """Largest lane, or NaN as soon as one lane is NaN."""

    def keep_larger(builder, p, q):
        # unordered >=: a NaN on the left wins; the reversed compare lets a NaN on the right win as well
        left = builder.fcmp_unordered(">=", p, q)
        picked = builder.select(left, p, q)
        nan_right = builder.fcmp_unordered("uno", q, q)
        return builder.select(nan_right, q, picked)

    def codegen(context, builder, sig, args):
        top = _halve(builder, args[0], a.width, 1, keep_larger)
        return builder.extract_element(top, ir.Constant(_I32, 0))

    return types.float64(a), codegen


@intrinsic
def times_columns(typingctx, columns, a):
    """Real matrix times the complex vector: `columns[j]` is column j with every entry written twice (n, 2 n), C order."""

    def codegen(context, builder, sig, args):
        total = ir.Constant(_llvm(a), [ir.Constant(_F64, 0.0)] * a.width)
        for j in range(a.width // 2):
            offset = ir.Constant(ir.IntType(64), j * a.width)
            pointer = _address(context, builder, sig.args[0], args[0], offset, a)
            entry = _shuffle(builder, args[1], args[1], [2 * j + i % 2 for i in range(a.width)])
            total = builder.call(_fma_function(builder, a), [builder.load(pointer, align=8), entry, total])
        return total

    return a(columns, a), codegen
