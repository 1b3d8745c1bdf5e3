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
from numba.core import cgutils
from numba.extending import intrinsic, models, overload, register_model

from rsc.kernel.jit import inlined

_F64 = ir.DoubleType()
_I32 = ir.IntType(32)
_I64 = ir.IntType(64)


class VecType(types.Type):
    """Numba type of a packed vector of `width` doubles. How its lanes lie in registers is known here only (and in cases.py)."""

    number = types.float64  # type of one lane

    def __init__(self, width, name=None):
        self.width = width
        super().__init__(name=name or f"Vec{width}")

    @property
    def parts(self):
        """Widths of the registers, e.g. 26 = 8 + 8 + 8 + 2."""
        rest = self.width % 8
        return [8] * (self.width // 8) + [size for size in (4, 2, 1) if rest & size]

    def swapped(self, builder, value):
        """The two numbers of every pair exchanged."""
        return _each(builder, self, lambda p: _shuffle(builder, p, p, [i ^ 1 for i in range(p.type.count)]), value)

    def turned(self, builder, value):
        """(y, z) -> (-z, y) in every pair."""

        def turn(part):
            size = part.type.count
            signs = ir.Constant(_register(size), [ir.Constant(_F64, -1.0 if i % 2 == 0 else 1.0) for i in range(size)])
            return builder.fmul(part, signs)

        return _each(builder, self, turn, self.swapped(builder, value))

    def filled(self, builder, y, z):
        """(y, z, y, z, ...)."""
        undef = ir.Constant(_register(2), ir.Undefined)
        pair = builder.insert_element(undef, y, ir.Constant(_I32, 0))
        pair = builder.insert_element(pair, z, ir.Constant(_I32, 1))
        return _join(builder, self, [_shuffle(builder, pair, undef, [i % 2 for i in range(size)]) for size in self.parts])

    def one_pair(self, builder, value, combine):
        """[y, z] of all pairs combined: registers of a size first, then the upper half of a register onto its lower."""
        total = None
        for size in (8, 4, 2):
            for part in (p for p in _split(builder, self, value) if p.type.count == size):
                total = part if total is None else combine(builder, total, part)
            if total is not None and size > 2:
                upper = _shuffle(builder, total, total, list(range(size // 2, size)))
                total = combine(builder, _shuffle(builder, total, total, list(range(size // 2))), upper)
        return [builder.extract_element(total, ir.Constant(_I32, i)) for i in range(2)]

    def columns(self, builder, base, value):
        """Real matrix times the vector, see `times_columns`."""
        parts = _split(builder, self, value)
        pairs = [(part, 2 * k) for part in parts for k in range(part.type.count // 2)]
        total = [ir.Constant(_register(size), [ir.Constant(_F64, 0.0)] * size) for size in self.parts]
        for j, (source, first) in enumerate(pairs):
            pointers = _addresses(builder, base, ir.Constant(_I64, j * self.width), self)
            for i, (size, pointer) in enumerate(zip(self.parts, pointers, strict=True)):
                entry = _shuffle(builder, source, source, [first + k % 2 for k in range(size)])
                total[i] = _fma(builder, builder.load(pointer, align=8), entry, total[i])
        return _join(builder, self, total)

    def get(self, builder, value, i):
        """One lane, of a single register only."""
        return builder.extract_element(value, i) if len(self.parts) == 1 else None

    def put(self, builder, value, i, number):
        """The vector with one lane replaced, of a single register only."""
        return builder.insert_element(value, number, i) if len(self.parts) == 1 else None


def _register(size):
    return ir.VectorType(_F64, size)


@register_model(VecType)
class _VecModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        parts = [_register(size) for size in fe_type.parts]
        super().__init__(dmm, fe_type, parts[0] if len(parts) == 1 else ir.LiteralStructType(parts))


def _split(builder, vec, value):
    """The registers of a vector."""
    count = len(vec.parts)
    return [value] if count == 1 else [builder.extract_value(value, i) for i in range(count)]


def _join(builder, vec, parts):
    """The vector of registers."""
    if len(parts) == 1:
        return parts[0]
    value = ir.Constant(ir.LiteralStructType([_register(size) for size in vec.parts]), ir.Undefined)
    for i, part in enumerate(parts):
        value = builder.insert_value(value, part, i)
    return value


def _each(builder, vec, apply, *values):
    """Apply a function of registers to vectors, register by register."""
    rows = [_split(builder, vec, value) for value in values]
    return _join(builder, vec, [apply(*row) for row in zip(*rows, strict=True)])


def _is_vec(*args):
    return all(isinstance(a, VecType) for a in args)


def _shuffle(builder, a, b, lanes):
    mask = ir.Constant(ir.VectorType(_I32, len(lanes)), [ir.Constant(_I32, i) for i in lanes])
    return builder.shuffle_vector(a, b, mask)


def _splat(builder, scalar, size):
    undef = ir.Constant(_register(size), ir.Undefined)
    one = builder.insert_element(undef, scalar, ir.Constant(_I32, 0))
    return _shuffle(builder, one, undef, [0] * size)


def _addresses(builder, base, offset, vec):
    """Pointers to number `offset` behind an address and on, seen as registers (numpy guarantees 8-byte alignment only)."""
    data = builder.inttoptr(base, _F64.as_pointer())
    pointers = []
    for size in vec.parts:
        pointers.append(builder.bitcast(builder.gep(data, [offset]), _register(size).as_pointer()))
        offset = builder.add(offset, ir.Constant(_I64, size))
    return pointers


def _call(builder, name, *args):
    """Call LLVM's lane by lane function `name` on registers."""
    ty = args[0].type
    function = ir.FunctionType(ty, [ty] * len(args))
    return builder.call(cgutils.get_or_insert_function(builder.module, function, f"{name}.v{ty.count}f64"), args)


def _fma(builder, s, a, b):
    return _call(builder, "llvm.fma", s, a, b)


@intrinsic
def address(typingctx, array):
    """Address of an array's data as an integer: unlike the array it can be handed on without counting references."""

    def codegen(context, builder, sig, args):
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        return builder.ptrtoint(data, _I64)

    return types.int64(array), codegen


@intrinsic
def load_at(typingctx, base, offset, lanes):
    """Vector of `len(lanes)` doubles at an address; `lanes` is a tuple that only carries the width."""
    vec = VecType(len(lanes))

    def codegen(context, builder, sig, args):
        pointers = _addresses(builder, args[0], args[1], vec)
        return _join(builder, vec, [builder.load(pointer, align=8) for pointer in pointers])

    return vec(types.int64, types.intp, lanes), codegen


@intrinsic
def store_at(typingctx, base, offset, a):
    """Write a vector at an address."""

    def codegen(context, builder, sig, args):
        pointers = _addresses(builder, args[0], args[1], a)
        for part, pointer in zip(_split(builder, a, args[2]), pointers, strict=True):
            builder.store(part, pointer, align=8)
        return context.get_dummy_value()

    return types.none(types.int64, types.intp, a), codegen


@intrinsic
def store_number(typingctx, base, offset, number):
    """Write a number at an address."""

    def codegen(context, builder, sig, args):
        pointer = builder.gep(builder.inttoptr(args[0], _F64.as_pointer()), [args[1]])
        builder.store(args[2], pointer)
        return context.get_dummy_value()

    return types.none(types.int64, types.intp, types.float64), codegen


@intrinsic
def number_at(typingctx, base, offset):
    """Number at an address."""

    def codegen(context, builder, sig, args):
        return builder.load(builder.gep(builder.inttoptr(args[0], _F64.as_pointer()), [args[1]]))

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
            return _each(builder, a, getattr(builder, op_name), *args)

        return (a(a, b), codegen) if _is_vec(a, b) and a == b else None

    return apply


_add, _sub, _mul, _div = (_lanewise(name) for name in ("fadd", "fsub", "fmul", "fdiv"))


def _as_register(builder, kind, number, size):
    """A number in every lane of a register; one number per case (cases.py) is a register already."""
    return number if isinstance(kind, VecType) else _splat(builder, number, size)


@intrinsic
def _scale(typingctx, s, a):
    def codegen(context, builder, sig, args):
        return _each(builder, a, lambda p: builder.fmul(_as_register(builder, s, args[0], p.type.count), p), args[1])

    return a(s, a), codegen


@overload(operator.add)
def _vec_add(a, b):
    if _is_vec(a, b) and a == b:
        return lambda a, b: _add(a, b)


@overload(operator.sub)
def _vec_sub(a, b):
    if _is_vec(a, b) and a == b:
        return lambda a, b: _sub(a, b)


@overload(operator.truediv)
def _vec_div(a, b):
    if _is_vec(a, b) and a == b:
        return lambda a, b: _div(a, b)


@overload(operator.mul)
def _vec_mul(a, b):
    if _is_vec(a, b) and a == b:
        return lambda a, b: _mul(a, b)
    if _is_vec(b) and (a == b.number or isinstance(a, types.Float)):
        return lambda a, b: _scale(a, b)


@intrinsic
def fma(typingctx, s, a, b):
    """s * a + b with one rounding per lane; `s` is a vector or a number."""

    def codegen(context, builder, sig, args):
        if s == b:
            return _each(builder, b, lambda x, y, z: _fma(builder, x, y, z), *args)
        return _each(builder, b, lambda y, z: _fma(builder, _as_register(builder, s, args[0], y.type.count), y, z), *args[1:])

    return b(s, a, b), codegen


def _weigh(builder, weight, part, total=None):
    """weight * part (+ total) for one register."""
    factor = ir.Constant(part.type, [ir.Constant(_F64, weight)] * part.type.count)
    return builder.fmul(factor, part) if total is None else _fma(builder, factor, part, total)


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
                    totals = [_each(builder, vec, partial(_weigh, builder, weight), *terms)]
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
    bits = ir.VectorType(_I64, p.type.count)
    above = builder.icmp_unsigned(">", builder.bitcast(p, bits), builder.bitcast(q, bits))
    return builder.select(above, p, q)


@intrinsic
def larger(typingctx, a, b):
    """Lane by lane the larger of two vectors of numbers >= 0, NaN where either is NaN."""

    def codegen(context, builder, sig, args):
        return _each(builder, a, lambda p, q: _keep_larger(builder, p, q), *args)

    return (a(a, b), codegen) if _is_vec(a, b) and a == b else None


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
        return _join(builder, kind, [_as_register(builder, number, args[0], size) for size in kind.parts])

    return kind(number, like), codegen


@intrinsic
def from_numbers(typingctx, numbers):
    """Vector (a single register) of a tuple of 2, 4 or 8 numbers."""
    vec = VecType(len(numbers))

    def codegen(context, builder, sig, args):
        value = ir.Constant(_register(vec.width), ir.Undefined)
        for i in range(vec.width):
            value = builder.insert_element(value, builder.extract_value(args[0], i), ir.Constant(_I32, i))
        return value

    return (vec(numbers), codegen) if len(vec.parts) == 1 else None


@intrinsic
def whole(typingctx, a):
    """Lane by lane the nearest whole number, halves to even."""

    def codegen(context, builder, sig, args):
        return _each(builder, a, lambda part: _call(builder, "llvm.rint", part), args[0])

    return a(a), codegen


@intrinsic
def bits(typingctx, number):
    """The bits of a number read as an integer, as a number again."""

    def codegen(context, builder, sig, args):
        whole_number = _I64 if number == types.float64 else ir.VectorType(_I64, number.width)
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
        return ir.Constant(_I64, a.width)

    return types.int64(a), codegen
