"""One number per lane as a Numba type, and vectors of such: the same sources then step W cases of one shape at once.

`LanesType` stands where a number stands in a single run, `LaneVecType` where a `VecType` stands: 2 n registers of W cases each
instead of 2 n numbers of one case. Every operation is the single run's on every case, in the same order and with the same
roundings, so every case keeps the bits it has alone. Comparisons give masks; `choose` takes the place of a branch.
"""

import math
import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, models, register_model

from rsc.kernel.simd import vec
from rsc.kernel.simd.jit import overloaded
from rsc.kernel.simd.registers import (
    I64,
    VecModel,
    VecType,
    add,
    call_lanewise,
    compare,
    constant,
    each,
    emitted,
    fma_lanewise,
    is_vec,
    join,
    merged,
    register,
    splat,
    split,
)


class LanesType(VecType):
    """Numba type of one double per lane."""

    def __init__(self, width):
        super().__init__(width, name=f"Lanes{width}")

    @property
    def parts(self):
        return [self.width]

    def over(self, pattern):
        """The type of this number in every lane of `pattern`."""
        return self if isinstance(pattern, LanesType) else LaneVecType(pattern.width, self)


class LaneVecType(VecType):
    """Numba type of a vector of `width` numbers, each with one double per lane."""

    def __init__(self, width, number):
        self.number = number
        super().__init__(width, name=f"LaneVec{width}x{number.width}")

    @property
    def parts(self):
        return [self.number.width] * self.width

    def swapped(self, builder, value):
        parts = split(builder, self, value)
        return join(builder, self, [parts[i ^ 1] for i in range(self.width)])

    def pair_sums(self, builder, a, b):
        rows = split(builder, self, a), split(builder, self, b)
        return join(builder, self, [builder.fadd(*rows[i % 2][i - i % 2 :][:2]) for i in range(self.width)])

    def alternated(self, builder, a, b):
        rows = split(builder, self, a), split(builder, self, b)
        return join(builder, self, [rows[i % 2][i] for i in range(self.width)])

    def turned(self, builder, value):
        parts = split(builder, self, self.swapped(builder, value))
        minus = constant(-1.0, parts[0].type)
        return join(builder, self, [builder.fmul(p, minus) if i % 2 == 0 else p for i, p in enumerate(parts)])

    def filled(self, builder, y, z, pattern):
        return join(builder, self, [(y, z)[i % 2] for i in range(self.width)])

    def one_pair(self, builder, value, combine):
        return self._combined(builder, split(builder, self, value), combine)

    def _combined(self, builder, parts, combine):
        # the tree of sums of the single run, whose registers are these groups; None is what is zero in all cases
        groups = []
        for size in VecType(self.width).parts:
            groups.append(parts[:size])
            parts = parts[size:]

        def both(low, high):
            return [p if q is None else merged(builder, combine, p, q) for p, q in zip(low, high, strict=True)]

        total = None
        for size in (8, 4, 2):
            for group in (g for g in groups if len(g) == size):
                total = both([None] * size if total is None else total, group)
            if total is not None and size > 2:
                total = both(total[: size // 2], total[size // 2 :])
        return total

    def product_type(self, other):
        return LaneVecType(2 if len(VecType(self.width).parts) > 1 else other.width, self.number)

    def product(self, builder, other, a, b):
        pairs = list(zip(split(builder, self, a), split(builder, other, b), strict=False))
        kind = self.product_type(other)
        if len(VecType(self.width).parts) == 1:
            return join(builder, kind, [builder.fmul(*pair) for pair in pairs])
        return join(builder, kind, self._combined(builder, pairs + [None] * (self.width - len(pairs)), add))

    def columns(self, builder, base, value):
        """Real matrix of every case times its vector; an entry of all cases is a row of the layout."""
        parts, row = split(builder, self, value), register(self.number.width)
        entries = builder.inttoptr(base, row.as_pointer())
        total = [constant(0.0, row)] * self.width
        for j in range(self.width // 2):
            for i in range(self.width):
                place = builder.gep(entries, [ir.Constant(I64, j * self.width + i - i % 2)])
                entry = builder.load(place, align=8 * self.number.width)
                total[i] = fma_lanewise(builder, entry, parts[2 * j + i % 2], total[i])
        return join(builder, self, total)

    def get(self, builder, value, i):
        # a constant index in the end, but not yet: through memory, which LLVM removes
        place = cgutils.alloca_once_value(builder, _packed(builder, self, value))
        return builder.load(builder.gep(place, [ir.Constant(I64, 0), i]))


class MaskType(types.Type):
    """Numba type of one truth value per lane."""

    def __init__(self, width):
        self.width = width
        super().__init__(name=f"Mask{width}")


register_model(LanesType)(VecModel)
register_model(LaneVecType)(VecModel)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ir.VectorType(ir.IntType(1), fe_type.width))


def _packed(builder, vec_type, value):
    """A vector as an LLVM array, which an index can reach into."""
    packed = ir.Constant(ir.ArrayType(register(vec_type.number.width), vec_type.width), ir.Undefined)
    for k, part in enumerate(split(builder, vec_type, value)):
        packed = builder.insert_value(packed, part, k)
    return packed


def _is_number(kind):
    return isinstance(kind, types.Float | types.Integer)


def _one_each(a, b):
    """Whether both are numbers per lane, or one is and the other is the same number for all."""
    lanes = [isinstance(kind, LanesType) for kind in (a, b)]
    return any(lanes) and all(case or _is_number(kind) for case, kind in zip(lanes, (a, b), strict=True))


@intrinsic
def _outer(typingctx, s, a):
    kind = LaneVecType(a.width, s)

    def codegen(context, builder, sig, args):
        numbers = [builder.extract_element(args[1], ir.Constant(ir.IntType(32), k)) for k in range(a.width)]
        return join(builder, kind, [builder.fmul(args[0], splat(builder, number, s.width)) for number in numbers])

    return kind(s, a), codegen


@overloaded(operator.mul)
def _lanes_times_vec(a, b):
    if isinstance(a, LanesType) and type(b) is VecType and len(b.parts) == 1:
        return lambda a, b: _outer(a, b)


def _overload_mixed(operation):
    """number (operation) cases and cases (operation) number, by spreading the number."""

    @overloaded(operation)
    def mixed(a, b):
        if _one_each(a, b) and not is_vec(a, b):
            if is_vec(a):
                return lambda a, b: operation(a, vec.spread(float(b), a))
            return lambda a, b: operation(vec.spread(float(a), b), b)

    return mixed


for _operation in (operator.add, operator.sub, operator.truediv):
    _overload_mixed(_operation)


@overloaded(operator.mul)
def _lanes_times_number(a, b):
    if isinstance(a, LanesType) and _is_number(b):
        return lambda a, b: vec._scale(float(b), a)
    if isinstance(b, LanesType) and isinstance(a, types.Integer):
        return lambda a, b: vec._scale(float(a), b)


_negated = vec.of_one(lambda kind, builder, a: each(builder, kind, builder.fneg, a))


@overloaded(operator.neg)
def _neg(a):
    if is_vec(a):
        return lambda a: _negated(a)


def _overload_compare(operation, predicate):
    @intrinsic
    def apply(typingctx, a, b):
        return emitted(MaskType(a.width)(a, b), lambda builder, *args: compare(builder, predicate, *args))

    @overloaded(operation)
    def compared(a, b):
        if _one_each(a, b):
            if is_vec(a, b):
                return lambda a, b: apply(a, b)
            if is_vec(a):
                return lambda a, b: apply(a, vec.spread(float(b), a))
            return lambda a, b: apply(vec.spread(float(a), b), b)


for _operation, _predicate in (
    (operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">="), (operator.eq, "=="), (operator.ne, "!="),
):  # fmt: skip
    _overload_compare(_operation, _predicate)


def _overload_masks(operation, name):
    @intrinsic
    def combined(typingctx, a, b):
        return emitted(a(a, b), lambda builder, *args: getattr(builder, name)(*args))

    @overloaded(operation)
    def combine(a, b):
        if isinstance(a, MaskType) and a == b:
            return lambda a, b: combined(a, b)


_overload_masks(operator.and_, "and_")
_overload_masks(operator.or_, "or_")


_not = vec.of_one(lambda kind, builder, a: builder.not_(a))


@overloaded(operator.invert)
def _invert(a):
    if isinstance(a, MaskType):
        return lambda a: _not(a)


@intrinsic
def mask_bits(typingctx, mask):
    """A mask as an integer, lane i in bit i."""

    return emitted(types.int64(mask), lambda builder, *args: builder.zext(builder.bitcast(args[0], ir.IntType(mask.width)), I64))


@intrinsic
def lowest_bit(typingctx, number):
    """Place of the lowest bit that is set."""

    return emitted(types.int64(types.int64), lambda builder, *args: builder.cttz(args[0], ir.Constant(ir.IntType(1), 1)))


@intrinsic
def choose(typingctx, mask, a, b):
    """Where the mask holds `a`, else `b`."""
    if not (isinstance(mask, MaskType | types.Boolean) and a == b):
        return None

    def codegen(context, builder, sig, args):
        if isinstance(mask, types.Boolean):
            return builder.select(args[0], args[1], args[2])
        return each(builder, a, lambda p, q: builder.select(args[0], p, q), *args[1:])

    return a(mask, a, b), codegen


@intrinsic
def sized(typingctx, a, pattern):
    """A vector with as many numbers as `pattern`, cut or with zeros behind; of a single run, where all have the same, itself."""

    return emitted(pattern(a, pattern), lambda builder, *args: sized_lanewise(builder, a, pattern, args[0]))


def sized_lanewise(builder, a, pattern, value):
    """See `sized`."""
    if a == pattern:
        return value
    parts, nothing = split(builder, a, value), constant(0.0, register(a.number.width))
    return join(builder, pattern, (parts + [nothing] * pattern.width)[: pattern.width])


@intrinsic
def some(typingctx, mask):
    """Whether a mask holds in any lane; a plain truth value is what it is."""

    def codegen(context, builder, sig, args):
        if isinstance(mask, types.Boolean):
            return args[0]
        bits = builder.bitcast(args[0], ir.IntType(mask.width))
        return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))

    return types.boolean(mask), codegen


def _overload_function(function, name):
    apply = vec.of_one(lambda kind, builder, a: call_lanewise(builder, name, a))

    @overloaded(function)
    def called(x):
        if isinstance(x, LanesType):
            return lambda x: apply(x)


_overload_function(math.sqrt, "llvm.sqrt")
_overload_function(abs, "llvm.fabs")
_trunc = vec.of_one(lambda kind, builder, a: call_lanewise(builder, "llvm.trunc", a))


@overloaded(min)
def _lanes_min(a, b):
    if isinstance(a, LanesType):
        return lambda a, b: choose(b < a, vec.spread(b, a), a)


@overloaded(max)
def _lanes_max(a, b):
    if isinstance(a, LanesType):
        return lambda a, b: choose(b > a, vec.spread(b, a), a)


def whole_part(x):
    """A number without its decimals, never -0.0."""
    return float(int(x))


@overloaded(whole_part)
def _whole_part(x):
    if isinstance(x, LanesType):
        return lambda x: _trunc(x) + 0.0
    return lambda x: float(int(x))


def counted(x):
    """A count kept as a float: an integer again in a single run, as it is for many cases."""
    return int(x)


@overloaded(counted)
def _counted(x):
    if isinstance(x, LanesType):
        return lambda x: x
    return lambda x: int(x)
