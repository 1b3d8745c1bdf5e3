"""Arithmetic in Python operators that emits LLVM code: recurrences whose loops are gone when the kernel runs.

A function of `Value`s runs once, while compiling: its Python loops and lists become straight-line code, its sums and products
instructions in exactly the order written, never reordered or contracted.
"""

from functools import partial
from typing import NamedTuple

from llvmlite import ir
from numba import types

from rsc.kernel.simd.registers import F64, VecType, add, each, fma_lanewise, is_vec, join, keep_larger, splat, type_of
from rsc.kernel.simd.wide import WideType

PAIR = VecType(2)


class Value:
    """A number or a packed vector of the code being emitted.

    A vector in memory is not made at once: it stands for an operation on others, done inside the walk over the registers of what
    is made of it (of each of them), until it is `kept`.
    """

    def __init__(self, builder, kind, code, operation=None, operands=()):
        self.builder, self.kind = builder, kind
        self._code, self._operation, self._operands = code, operation, operands

    @property
    def code(self):
        """The LLVM value."""
        return self.kept()._code

    def kept(self):
        """This value, made if it was not yet."""
        if self._operation is None:
            return self
        return self._new(self._walked([None])[0])

    def _walked(self, places, **options):
        leaves = self._leaves()
        apply = partial(self._on_registers, leaves)
        return self.kind.walked(self.builder, places, lambda *parts: [apply(*parts)], *(leaf._code for leaf in leaves), **options)

    def _later(self, operation, *others):
        """The vector in memory that `operation` makes of this one and others, register by register."""
        return Value(self.builder, self.kind, None, operation, (self, *others))

    def _leaves(self):
        """The Values that are made of which this one is."""
        if self._operation is None:
            return [self]
        leaves = {}
        for operand in self._operands:
            if isinstance(operand, Value):
                leaves |= {leaf._code: leaf for leaf in operand._leaves()}
        return list(leaves.values())

    def _on_registers(self, leaves, *parts):
        """One register, from those of the leaves."""
        kinds = [type_of(part) for part in parts]
        known = {leaf._code: Value(self.builder, k, p) for leaf, k, p in zip(leaves, kinds, parts, strict=True)}
        return self._evaluated(known).code

    def _evaluated(self, known):
        key = self if self._operation else self._code
        if key not in known:
            operands = [item._evaluated(known) if isinstance(item, Value) else item for item in self._operands]
            known[key] = self._operation(*operands)
        return known[key]

    def _new(self, code, kind=None):
        return Value(self.builder, kind or self.kind, code)

    def code_of(self, other):
        """Code of `other` with the kind of self: numbers and constants in every lane."""
        if isinstance(other, Value) and other.kind == self.kind:
            return other.code
        number = other.code if isinstance(other, Value) else ir.Constant(F64, float(other))
        if not is_vec(self.kind) or number.type != F64:
            return number  # for `each` to put in every lane
        return join(self.builder, self.kind, [splat(self.builder, number, size) for size in self.kind.parts])

    def _apply(self, name, other):
        if isinstance(self.kind, WideType):
            return self._later(lambda a, b: a._apply(name, b), other)
        operation, codes = getattr(self.builder, name), (self.code, self.code_of(other))
        return self._new(each(self.builder, self.kind, operation, *codes) if is_vec(self.kind) else operation(*codes))

    def __add__(self, other):
        return self._apply("fadd", other)

    def __sub__(self, other):
        return self._apply("fsub", other)

    def __mul__(self, other):
        if isinstance(other, Value) and is_vec(other.kind) and self.kind == types.float64:
            return other * self
        return self._apply("fmul", other)

    __rmul__ = __mul__

    def __truediv__(self, other):
        return self._apply("fdiv", other)

    def reciprocal(self):
        """1 over the number."""
        return self._new(self.builder.fdiv(self.code_of(1.0), self.code))

    def turned(self):
        """The imaginary unit times every pair."""
        if isinstance(self.kind, WideType):
            return self._later(Value.turned)
        return self._new(self.kind.turned(self.builder, self.code))

    def pair_sums(self, other):
        """(y + z, y + z of another) in every pair."""
        if isinstance(self.kind, WideType):
            return self._later(Value.pair_sums, other)
        return self._new(self.kind.pair_sums(self.builder, self.code, other.code))

    def swapped(self):
        """The two numbers of every pair exchanged."""
        return self._new(self.kind.swapped(self.builder, self.code))

    def pair(self):
        """Sum of all pairs, as a pair."""
        if self._operation:
            return self._new(self._walked([], combine=[add])[0], PAIR)
        return pair_of(*(self._new(code, types.float64) for code in self.kind.one_pair(self.builder, self.code, add)))

    def product(self, pattern):
        """A vector of which only the sum is wanted, as `vec.product` of vectors like `pattern` has it."""
        return self if pattern.kind.product_type == self.kind else self.pair()

    def lane(self, i):
        """One number of a pair."""
        return self._new(self.kind.one_pair(self.builder, self.code, None)[i], types.float64)

    def across(self):
        """Sum of the two numbers of a pair."""
        return self.lane(0) + self.lane(1)

    def difference(self):
        """The first number of a pair less the second."""
        return self.lane(0) - self.lane(1)

    def spread(self, number):
        """A number in every lane."""
        return self._new(each(self.builder, self.kind, lambda part, *_: part, number.code))

    def filled(self, y, z):
        """(y, z, y, z, ...) of two numbers."""
        if isinstance(self.kind, WideType):
            return self._later(Value.filled, y, z)
        return self._new(self.kind.filled(self.builder, y.code, z.code, self.code))

    def repeated(self, pattern):
        """A pair in every pair of a vector like `pattern`."""
        return pattern.filled(self.lane(0), self.lane(1))

    def columns(self, base, *others):
        """Real matrix at the address `base` times the vector (and others below it)."""
        return self._new(self.kind.columns(self.builder, base.code, self.code, *(other.code for other in others)))

    def where(self, present, change):
        """change(self) where `present` (a truth value or an address) is not zero, else self: a branch."""
        self = self.kept()
        builder, before = self.builder, self.builder.block
        with builder.if_then(builder.icmp_signed("!=", present.code, ir.Constant(present.code.type, 0))):
            changed = change(self).kept()
            inside = builder.block
        result = builder.phi(self.code.type)
        result.add_incoming(changed.code, inside)
        result.add_incoming(self.code, before)
        return self._new(result)


class Product(NamedTuple):
    """The product of two vectors in a walk that sums it."""

    a: Value
    b: Value

    @property
    def code(self):
        """The LLVM values."""
        return self.a.code, self.b.code


def fma(a, b, total):
    """a * b + total with one rounding per lane; the result has the kind of `total`, a and b may be numbers."""
    if isinstance(total.kind, WideType):
        return total._later(lambda total, a, b: fma(a, b, total), a, b)
    codes, builder = (total.code_of(a), total.code_of(b), total.code), total.builder
    if not is_vec(total.kind):
        return Value(builder, total.kind, builder.fma(*codes))
    return Value(builder, total.kind, each(builder, total.kind, lambda *parts: fma_lanewise(builder, *parts), *codes))


def weighted(weights, base, vectors):
    """See `vec.weighted_sum`."""
    total = base
    for weight, vector in zip(weights, vectors, strict=False):
        if weight:
            total = vector * weight if total is None else fma(weight, vector, total)
    return total


def larger(a, b):
    """Lane by lane the larger of two vectors of numbers >= 0, NaN where either is NaN."""
    return Value(a.builder, a.kind, each(a.builder, a.kind, lambda p, q: keep_larger(a.builder, p, q), a.code, b.code))


def pair_of(y, z):
    """A pair of two numbers."""
    return Value(y.builder, PAIR, PAIR.filled(y.builder, y.code, z.code, None))


def fields(builder, kind, code):
    """The items of a named tuple by name, those of a tuple in a list."""

    def item(kind, code):
        if isinstance(kind, types.BaseTuple):
            return [item(part, builder.extract_value(code, i)) for i, part in enumerate(kind)]
        return Value(builder, kind, code)

    return dict(zip(kind.fields, item(types.Tuple(kind.types), code), strict=True))
