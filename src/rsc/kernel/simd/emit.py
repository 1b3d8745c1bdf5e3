"""Arithmetic with Python operators that emits LLVM code, for recurrences whose loops are unrolled at compile time.

A function of `Emitted`s runs once, at compile time: its Python loops and lists become straight-line code, its sums and products
instructions in exactly the order written, never reordered or contracted.
"""

from functools import partial
from types import SimpleNamespace

from llvmlite import ir
from numba import types

from rsc.kernel.simd.registers import F64, VecType, add, each, fma_lanewise, is_vec, join, splat

PAIR = VecType(2)


class Emitted:
    """A number or a packed vector of the code being emitted: its Numba type `kind` and its LLVM value `code`."""

    def __init__(self, builder, kind, code):
        self.builder, self.kind, self.code = builder, kind, code

    def _new(self, code, kind=None):
        return Emitted(self.builder, kind or self.kind, code)

    def code_of(self, other):
        """Code of `other` with the kind of self: numbers and constants in every lane."""
        if isinstance(other, Emitted) and other.kind == self.kind:
            return other.code
        number = other.code if isinstance(other, Emitted) else ir.Constant(F64, float(other))
        if not is_vec(self.kind) or number.type != F64:
            return number  # `each` broadcasts it to every lane
        return join(self.builder, self.kind, [splat(self.builder, number, size) for size in self.kind.parts])

    def _apply(self, name, other):
        operation, codes = getattr(self.builder, name), (self.code, self.code_of(other))
        return self._new(each(self.builder, self.kind, operation, *codes) if is_vec(self.kind) else operation(*codes))

    def __add__(self, other):
        return self._apply("fadd", other)

    def __sub__(self, other):
        return self._apply("fsub", other)

    def __mul__(self, other):
        if isinstance(other, Emitted) and is_vec(other.kind) and self.kind == types.float64:
            return other * self
        return self._apply("fmul", other)

    __rmul__ = __mul__

    def __truediv__(self, other):
        return self._apply("fdiv", other)

    def reciprocal(self):
        """Reciprocal of a number."""
        return self._new(self.builder.fdiv(self.code_of(1.0), self.code))

    def turned(self):
        """Every pair times the imaginary unit: (y, z) -> (-z, y)."""
        return self._new(self.kind.turned(self.builder, self.code))

    def swapped(self):
        """Every pair with its components exchanged."""
        return self._new(self.kind.swapped(self.builder, self.code))

    def pair(self):
        """Sum of all pairs, as a pair."""
        return pair_of(*(self._new(code, types.float64) for code in self.kind.one_pair(self.builder, self.code, add)))

    def product(self, pattern):
        """A vector needed only for its sum, in the form of a `vec.product` of vectors like `pattern`."""
        return self if pattern.kind.product_type == self.kind else self.pair()

    def lane(self, i):
        """One component of a pair."""
        return self._new(self.kind.one_pair(self.builder, self.code, None)[i], types.float64)

    def across(self):
        """Sum of the components of a pair."""
        return self.lane(0) + self.lane(1)

    def difference(self):
        """First minus second component of a pair."""
        return self.lane(0) - self.lane(1)

    def filled(self, y, z):
        """(y, z, y, z, ...) with the kind of self."""
        return self._new(self.kind.filled(self.builder, y.code, z.code, self.code))

    def repeated(self, pattern):
        """A pair repeated to a vector like `pattern`."""
        return pattern.filled(self.lane(0), self.lane(1))

    def columns(self, base, *others):
        """Real matrix at address `base` times the vector (stacked on others)."""
        return self._new(self.kind.columns(self.builder, base.code, self.code, *(other.code for other in others)))

    def where(self, present, change):
        """change(self) where `present` (a truth value or an address) is not zero, else self: a branch."""
        builder, before = self.builder, self.builder.block
        with builder.if_then(builder.icmp_signed("!=", present.code, ir.Constant(present.code.type, 0))):
            changed = change(self)
            inside = builder.block
        result = builder.phi(self.code.type)
        result.add_incoming(changed.code, inside)
        result.add_incoming(self.code, before)
        return self._new(result)


def fma(a, b, total):
    """a * b + total with one rounding per lane; the result has the kind of `total`, a and b may be scalars."""
    codes, builder = (total.code_of(a), total.code_of(b), total.code), total.builder
    if not is_vec(total.kind):
        return Emitted(builder, total.kind, builder.fma(*codes))
    return Emitted(builder, total.kind, each(builder, total.kind, partial(fma_lanewise, builder), *codes))


def pair_of(y, z):
    """A pair made of two numbers."""
    return Emitted(y.builder, PAIR, PAIR.filled(y.builder, y.code, z.code, None))


def parts(builder, kind, code):
    """Components of a value, recursively: a named tuple becomes attributes, a tuple a list."""
    if isinstance(kind, types.BaseNamedTuple):
        return SimpleNamespace(**dict(zip(kind.fields, parts(builder, types.Tuple(kind.types), code), strict=True)))
    if isinstance(kind, types.BaseTuple):
        return [parts(builder, part, builder.extract_value(code, i)) for i, part in enumerate(kind)]
    return Emitted(builder, kind, code)


def product(a, b, k, first=0, last=None):
    """Sum of a_j b_(k-j), j = first .. last (k); the terms with the latest coefficients come last, so that the others need not
    wait."""
    # fused multiply-adds form a chain in which each waits for the one before: early coefficients go first
    terms = sorted(range(first, (k if last is None else last) + 1), key=lambda j: max(j, k - j))
    total = a[terms[0]] * b[k - terms[0]]
    for j in terms[1:]:
        total = fma(a[j], b[k - j], total)
    return total
