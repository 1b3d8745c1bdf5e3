"""Packed vectors in SIMD registers: their Numba type, and LLVM code on registers for the intrinsics of `vec`."""

import struct
from functools import partial

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import models, register_model

BYTES = 8  # of a double
F64 = ir.DoubleType()
I32 = ir.IntType(32)
I64 = ir.IntType(64)
# vectors of at most so many numbers use registers of four: while registers of eight are in use, processors close one of their
# three ports to all other arithmetic
FEW = 16


class VecType(types.Type):
    """Numba type of a packed vector of `width` doubles. Only this class knows how its numbers are distributed over registers."""

    def __init__(self, width, largest=None):
        self.width = width
        allowed = largest or (8 if width > FEW else 4)
        self.largest = next(size for size in (8, 4, 2, 1) if size <= min(allowed, width))  # register
        super().__init__(name=f"Vec{width}of{self.largest}")

    @property
    def parts(self):
        """Widths of the registers, e.g. 26 = 8 + 8 + 8 + 2."""
        count, beyond = divmod(self.width, self.largest)
        return [self.largest] * count + [size for size in (4, 2, 1) if beyond & size]

    def swapped(self, builder, value):
        """Every pair with its components exchanged."""
        return each(builder, self, partial(exchanged, builder), value)

    def pair_sums(self, builder, a, b):
        """(y + z of a, y + z of b) in every pair."""

        def both(p, q):
            size = p.type.count
            first = [i + i % 2 * (size - 1) for i in range(size)]
            return builder.fadd(shuffle(builder, p, q, first), shuffle(builder, p, q, [i + 1 for i in first]))

        return each(builder, self, both, a, b)

    def alternated(self, builder, a, b):
        """(y of a, z of b) in every pair."""
        return each(builder, self, partial(alternating, builder), a, b)

    def turned(self, builder, value):
        """(y, z) -> (-z, y) in every pair."""

        def turn(part):
            size = part.type.count
            signs = ir.Constant(register(size), [ir.Constant(F64, -1.0 if i % 2 == 0 else 1.0) for i in range(size)])
            return builder.fmul(part, signs)

        return each(builder, self, turn, self.swapped(builder, value))

    def each(self, builder, apply, *values):
        """See `each`."""
        rows = [self._registers(builder, value) for value in values]
        return join(builder, self, [apply(*row) for row in zip(*rows, strict=True)])

    def _registers(self, builder, value):
        if value.type == F64:
            return (splat(builder, value, size) for size in self.parts)
        return split(builder, self, value)

    def filled(self, builder, y, z, pattern):
        """(y, z, y, z, ...) with the width of `pattern`."""
        undef = ir.Constant(register(2), ir.Undefined)
        pair = builder.insert_element(undef, y, ir.Constant(I32, 0))
        pair = builder.insert_element(pair, z, ir.Constant(I32, 1))
        return join(builder, self, [shuffle(builder, pair, undef, [i % 2 for i in range(size)]) for size in self.parts])

    def one_pair(self, builder, value, combine):
        """[y, z] of all pairs combined: first registers of equal size, then the upper half of a register with its lower half."""
        total = self._combined(builder, split(builder, self, value), combine)
        return [builder.extract_element(total, ir.Constant(I32, i)) for i in range(2)]

    def _combined(self, builder, parts, combine):
        """A two-lane register with all pairs combined; parts: registers, or pairs of registers to be multiplied."""
        # always this tree, on any processor: another order of summation would change bits
        total = None
        for size in (8, 4, 2):
            for part in (part for part, width in zip(parts, self.parts, strict=True) if width == size):
                total = merged(builder, combine, total, part)
            if total is not None and size > 2:
                upper = shuffle(builder, total, total, list(range(size // 2, size)))
                total = combine(builder, shuffle(builder, total, total, list(range(size // 2))), upper)
        return total

    @property
    def product_type(self):
        """Type of a `vec.product`: a pair, or the vector itself if it is a single register."""
        return self if len(self.parts) == 1 else VecType(2)

    def product(self, builder, a, b):
        """See `vec.product`."""
        pairs = list(zip(split(builder, self, a), split(builder, self, b), strict=True))
        return builder.fmul(a, b) if len(pairs) == 1 else self._combined(builder, pairs, add)

    def columns(self, builder, base, *values):
        """Real matrix times the stacked vectors, see `vec.times_columns`."""
        # a column times one entry of the vector is added to all rows: independent sums, without latency chains
        parts = [part for value in values for part in split(builder, self, value)]
        pairs = [(part, 2 * k) for part in parts for k in range(part.type.count // 2)]
        total = [constant(0.0, register(size)) for size in self.parts]
        for j, (source, first) in enumerate(pairs):
            pointers = addresses(builder, base, ir.Constant(I64, j * self.width), self)
            for i, (size, pointer) in enumerate(zip(self.parts, pointers, strict=True)):
                entry = shuffle(builder, source, source, [first + k % 2 for k in range(size)])
                total[i] = fma_lanewise(builder, builder.load(pointer, align=8), entry, total[i])
        return join(builder, self, total)

    def get(self, builder, value, i):
        """Lane i of a vector."""
        number, first = None, 0
        for part in split(builder, self, value):
            candidate = builder.extract_element(part, builder.sub(i, ir.Constant(I64, first)))
            number = candidate if number is None else builder.select(_reaches(builder, i, first), candidate, number)
            first += part.type.count
        return number


def _reaches(builder, i, first):
    return builder.icmp_signed(">=", i, ir.Constant(I64, first))


def register(size):
    """LLVM type of a register of `size` doubles."""
    return ir.VectorType(F64, size)


@register_model(VecType)
class VecModel(models.PrimitiveModel):
    """LLVM representation: a single register, or a structure of registers."""

    def __init__(self, dmm, fe_type):
        parts = [register(size) for size in fe_type.parts]
        super().__init__(dmm, fe_type, parts[0] if len(parts) == 1 else ir.LiteralStructType(parts))


def split(builder, vec, value):
    """The registers of a vector."""
    count = len(vec.parts)
    return [value] if count == 1 else [builder.extract_value(value, i) for i in range(count)]


def join(builder, vec, parts):
    """The vector made of registers."""
    if len(parts) == 1:
        return parts[0]
    value = ir.Constant(ir.LiteralStructType([register(size) for size in vec.parts]), ir.Undefined)
    for i, part in enumerate(parts):
        value = builder.insert_value(value, part, i)
    return value


def each(builder, vec, apply, *values):
    """Apply a function of registers to vectors, register by register; scalars among the values are broadcast."""
    return vec.each(builder, apply, *values)


def emitted(signature, make):
    """Return value of an intrinsic: its signature, and make(builder, *codes of its arguments), which emits its code."""

    def codegen(context, builder, sig, args):
        return make(builder, *args)

    return signature, codegen


def is_vec(*args):
    """Whether all arguments are vector types."""
    return all(isinstance(a, VecType) for a in args)


def shuffle(builder, a, b, lanes):
    """The given lanes of two registers."""
    mask = ir.Constant(ir.VectorType(I32, len(lanes)), [ir.Constant(I32, i) for i in lanes])
    return builder.shuffle_vector(a, b, mask)


def exchanged(builder, part):
    """A register with the lanes of every pair exchanged."""
    return shuffle(builder, part, part, [i ^ 1 for i in range(part.type.count)])


def alternating(builder, a, b):
    """Even lanes of a and odd lanes of b, each in its place."""
    size = a.type.count
    return shuffle(builder, a, b, [i + size * (i % 2) for i in range(size)])


def splat(builder, scalar, size):
    """A number in every lane of a register."""
    undef = ir.Constant(register(size), ir.Undefined)
    one = builder.insert_element(undef, scalar, ir.Constant(I32, 0))
    return shuffle(builder, one, undef, [0] * size)


def constant(number, kind):
    """A number in every lane of a register of an LLVM type."""
    return ir.Constant(kind, [ir.Constant(F64, number)] * kind.count)


def stored(builder, number, kind):
    """A number in every lane of a register of an LLVM type, from memory.

    A constant in the code needs one instruction for its address and one to broadcast it; these are then executed once before the
    loop and not in every step, since arithmetic reads all lanes from memory.
    """
    name = f"rsc.{struct.pack('>d', number).hex()}.{kind.count}"
    place = builder.module.globals.get(name)
    if place is None:
        place = ir.GlobalVariable(builder.module, kind, name)
        place.initializer = constant(number, kind)
        # "linkonce": LLVM must assume that another module may replace it, else it would become an immediate constant again
        place.linkage, place.global_constant, place.align = "linkonce", True, BYTES * kind.count
    return builder.load(place)


def addresses(builder, base, offset, vec):
    """Register pointers to consecutive numbers from `offset` after an address (NumPy guarantees only 8-byte alignment)."""
    data = builder.inttoptr(base, F64.as_pointer())
    pointers = []
    for size in vec.parts:
        pointers.append(builder.bitcast(builder.gep(data, [offset]), register(size).as_pointer()))
        offset = builder.add(offset, ir.Constant(I64, size))
    return pointers


def call_lanewise(builder, name, *args):
    """Call LLVM's lane-wise function `name` on registers."""
    ty = args[0].type
    function = ir.FunctionType(ty, [ty] * len(args))
    return builder.call(cgutils.get_or_insert_function(builder.module, function, f"{name}.v{ty.count}f64"), args)


def rounded(builder, part):
    """A register rounded to the nearest integers, halves to even."""
    return call_lanewise(builder, "llvm.rint", part)


def fma_lanewise(builder, s, a, b):
    """s * a + b with one rounding on registers."""
    return call_lanewise(builder, "llvm.fma", s, a, b)


def keep_larger(builder, p, q):
    """Lane-wise maximum of two registers of numbers >= 0; NaN where either is NaN."""
    # numbers >= +0 are ordered like their bits as unsigned integers, and any NaN is above all of them
    bits = ir.VectorType(I64, p.type.count)
    above = builder.icmp_unsigned(">", builder.bitcast(p, bits), builder.bitcast(q, bits))
    return builder.select(above, p, q)


def merged(builder, combine, total, part):
    """Combine `total` (None: nothing yet) with a register, or add the product of two registers with one rounding."""
    if isinstance(part, tuple):
        return builder.fmul(*part) if total is None else fma_lanewise(builder, *part, total)
    return part if total is None else combine(builder, total, part)


def add(builder, p, q):
    """Lane-wise sum of two registers."""
    return builder.fadd(p, q)
