"""Vectors too wide for registers: numbers in memory, every operation a loop over registers in a function of its own.

Straight-line code for every register of every operation grows with the number of coordinates, and the time LLVM takes for it
faster. A `WideType` is a pointer instead: each operation calls a small function that takes the next free slots of a run's arena,
walks the registers once and returns the slots. Registers, order and rounding are those of a `VecType`, and so are the bits.

What an operation made stays until the arena is released to a mark before it (`vec.mark`, `vec.release`); what must outlive that
is moved to a slot made before the mark (`vec.moved`), or lies in the other half of the arena (`vec.halves`, `vec.use`), as what a
step starts from. In a `VecType` all this is nothing.
"""

import hashlib
from functools import partial

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import models, register_model

from rsc.kernel.simd.registers import (
    F64,
    FEW,
    I32,
    I64,
    LARGEST,
    VecType,
    add,
    alternating,
    constant,
    fma_lanewise,
    merged,
    register,
    shuffle,
    splat,
)

NUMBERS = F64.as_pointer()
BYTES_AT = ir.IntType(8).as_pointer()
# addresses of the next free slot, of the end and of the memory as allocated, and the size of a half; a line behind them the slots
ARENA = I64.as_pointer()
VALUE = ir.LiteralStructType([NUMBERS, ARENA])
LINE = 64  # bytes, what slots are multiples of
BLOCK = 8  # registers of a matrix-vector product that are summed at a time
SLOTS = 512  # the most of any method in tests/unit/kernel/test_wide.py is near 340
CALLING = "preserve_nonecc"  # a dozen pointers in registers, which the function need not keep: its caller keeps little in any


def narrow(is_series):
    """Numbers up to which a vector is a VecType.

    In registers of four the straight-line code of more, and what lives through a step, fill the first caches; a series, which
    keeps more of what it makes, gains nothing by memory before.
    """
    if LARGEST == 8:
        return 56
    return 24 if is_series else FEW


class ArenaType(types.Type):
    """Numba type of a run's arena for wide vectors; like the tuple `width` it carries their width."""

    def __init__(self, width):
        self.width = width
        super().__init__(name=f"Room{width}")

    def __len__(self):
        return self.width


@register_model(ArenaType)
class _ArenaModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ARENA)


class WideType(VecType):
    """Numba type of a vector of `width` doubles in memory."""

    def __init__(self, width):
        super().__init__(width, name=f"Wide{width}")

    def each(self, builder, apply, *values):
        def spread(*parts):
            size = next(part.type.count for part in parts if part.type != F64)
            return [apply(*(splat(builder, part, size) if part.type == F64 else part for part in parts))]

        return self.walked(builder, [None], spread, *values)[0]

    def walked(self, builder, places, apply, *values, combine=()):
        """Vectors in the memory of others, the `places`, or new (None); `apply` makes their registers of those of the values, in
        one walk. Of what it makes beyond them (or of its products of two) all pairs are combined, each by its function of
        `combine`: a pair in a register."""
        arena, taken = _arena_of(builder, values), [place for place in places if place is not None]
        count = len(places) - len(taken)
        kind = ir.LiteralStructType([NUMBERS] + [register(2)] * len(combine))

        def targets(out, taken):
            new, taken = (self._further(builder, out, i) for i in range(count)), iter(taken)
            return [next(new if place is None else taken) for place in places]

        def write(arena, *inner):
            out = self.slots(builder, arena, count) if count else ir.Constant(NUMBERS, ir.Undefined)
            pairs = self._walk(builder, apply, targets(out, inner[: len(taken)]), inner[len(taken) :], combine)
            return _structure(builder, kind, [out, *pairs])

        result = _call(builder, kind, [arena, *(_bare(builder, v) for v in (*taken, *values))], write)
        data, *pairs = (builder.extract_value(result, i) for i in range(1 + len(combine)))
        vectors = [value_of(builder, place, arena) for place in targets(data, [_bare(builder, place) for place in taken])]
        return vectors + pairs

    @property
    def _size(self):
        """Numbers from one slot to the next."""
        return -(-8 * self.width // LINE) * LINE // 8

    def _further(self, builder, data, slots):
        return builder.gep(data, [ir.Constant(I64, slots * self._size)])

    def copy(self, builder, source, target):
        """Copy from one pointer to another."""

        def write(source, target):
            self._walk(builder, lambda part: [part], [target], [source])
            return ir.Constant(I32, 0)

        _call(builder, I32, [source, target], write)

    def slots(self, builder, arena, count):
        """Pointer to the next free slots."""
        start = builder.load(arena)
        end = builder.add(start, ir.Constant(I64, 8 * self._size * count))
        limit = builder.load(_item(builder, arena, 1))
        with builder.if_then(builder.icmp_unsigned(">", end, limit), likely=False):
            trap = cgutils.get_or_insert_function(builder.module, ir.FunctionType(ir.VoidType(), []), "llvm.trap")
            builder.call(trap, [])
        builder.store(end, arena)
        return builder.inttoptr(start, NUMBERS)

    def filled(self, builder, y, z, pattern):
        return self.each(builder, lambda _, p, q: alternating(builder, p, q), pattern, y, z)

    def one_pair(self, builder, value, combine):
        pair = self.walked(builder, [], lambda part: [part], value, combine=[combine])[0]
        return VecType(2).one_pair(builder, pair, combine)

    def product(self, builder, a, b):
        return self.walked(builder, [], lambda p, q: [(p, q)], a, b, combine=[add])[0]

    def columns(self, builder, base, *values):
        arena = _arena_of(builder, values)

        def write(arena, base, *vectors):
            out, matrix = self.slots(builder, arena, 1), builder.inttoptr(base, NUMBERS)
            parts = self.parts
            for first in range(0, len(parts), BLOCK):
                block = parts[first : first + BLOCK]

                def column(data, j, totals, first=first, block=block):
                    pair = _part(builder, data, _times(builder, j, 2), 2)
                    start = builder.add(_times(builder, j, self.width), ir.Constant(I64, 8 * first))
                    sums = []
                    for i, (size, total) in enumerate(zip(block, totals, strict=True)):
                        entry = shuffle(builder, pair, pair, [k % 2 for k in range(size)])
                        offset = builder.add(start, ir.Constant(I64, sum(block[:i])))
                        sums.append(fma_lanewise(builder, _part(builder, matrix, offset, size), entry, total))
                    return sums

                totals, n = [constant(0.0, register(size)) for size in block], self.width // 2
                for i, data in enumerate(vectors):
                    data = builder.gep(data, [ir.Constant(I64, -i * self.width)]) if i else data
                    totals = _loop(builder, i * n, (i + 1) * n, totals, partial(column, data))
                for i, total in enumerate(totals):
                    _put(builder, out, ir.Constant(I64, 8 * first + sum(block[:i])), total)
            return out

        data = _call(builder, NUMBERS, [arena, base, *(_bare(builder, value) for value in values)], write)
        return value_of(builder, data, arena)

    def get(self, builder, value, i):
        raise NotImplementedError("a number is taken from a single register")

    def _walk(self, builder, apply, targets, sources, combine=()):
        """targets = apply(numbers and registers of sources), register by register; what is beyond them with pairs combined."""

        def joined(totals, others):
            return [merged(builder, join, total, other) for join, total, other in zip(combine, totals, others, strict=True)]

        def at(offset, size, totals):
            parts = apply(*(s if s.type == F64 else _part(builder, s, offset, size) for s in sources))
            for target, part in zip(targets, parts, strict=False):
                _put(builder, target, offset, part)
            return joined(totals, parts[len(targets) :])

        # the order of VecType.one_pair: registers of a size first, then the upper half of a register onto its lower
        begin, first = (at(ir.Constant(I64, 0), 8, [None] * len(combine)), 1) if combine else ([], 0)
        totals = _loop(builder, first, self.width // 8, begin, lambda i, totals: at(_times(builder, i, 8), 8, totals))
        offset = self.width // 8 * 8
        for size in (4, 2):
            totals = joined(*([_lanes(builder, total, first, size) for total in totals] for first in (0, size)))
            if self.width % 8 & size:
                totals = at(ir.Constant(I64, offset), size, totals)
                offset += size
        return totals


def _lanes(builder, part, first, size):
    return shuffle(builder, part, part, list(range(first, first + size)))


@register_model(WideType)
class _WideModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, VALUE)


def value_of(builder, data, arena):
    """The vector at a pointer."""
    return _structure(builder, VALUE, [data, arena])


def new_arena(builder, width):
    """An empty arena, to be given back by `close_arena`."""
    size = SLOTS * (-(-8 * width // LINE) * LINE)
    memory = _of_numba(builder, BYTES_AT, "NRT_Allocate", ir.Constant(I64, size + 2 * LINE))
    start = builder.and_(builder.add(builder.ptrtoint(memory, I64), ir.Constant(I64, LINE - 1)), ir.Constant(I64, -LINE))
    arena, first = builder.inttoptr(start, ARENA), builder.add(start, ir.Constant(I64, LINE))
    for i, item in enumerate((first, builder.add(first, ir.Constant(I64, size)), builder.ptrtoint(memory, I64))):
        builder.store(item, _item(builder, arena, i))
    return arena


def _item(builder, arena, i):
    return builder.gep(arena, [ir.Constant(I32, i)])


def halved(builder, arena):
    """Where the two halves of what is left of an arena begin; their size is noted in the arena."""
    start, end = (builder.load(_item(builder, arena, i)) for i in range(2))
    size = builder.and_(builder.lshr(builder.sub(end, start), ir.Constant(I64, 1)), ir.Constant(I64, -LINE))
    builder.store(size, _item(builder, arena, 3))
    return start, builder.add(start, size)


def use_half(builder, arena, start):
    """Let vectors be made in the half of an arena that begins at `start`."""
    builder.store(start, arena)
    builder.store(builder.add(start, builder.load(_item(builder, arena, 3))), _item(builder, arena, 1))


def close_arena(builder, arena):
    """Give an arena's memory back."""
    memory = builder.load(_item(builder, arena, 2))
    _of_numba(builder, ir.VoidType(), "NRT_Free", builder.inttoptr(memory, BYTES_AT))


def _of_numba(builder, result, name, argument):
    """Call a function of Numba's run time; its `context.nrt` wants every function to count references."""
    kind = ir.FunctionType(result, [argument.type])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [argument])


def _structure(builder, kind, items):
    value = ir.Constant(kind, ir.Undefined)
    for i, item in enumerate(items):
        value = builder.insert_value(value, item, i)
    return value


def _bare(builder, value):
    """The pointer of a vector, anything else as it is."""
    return builder.extract_value(value, 0) if value.type == VALUE else value


def _arena_of(builder, values):
    return builder.extract_value(next(value for value in values if value.type == VALUE), 1)


def _times(builder, i, size):
    return builder.mul(i, ir.Constant(I64, size))


def _pointer(builder, data, offset, size):
    offset = ir.Constant(I64, offset) if isinstance(offset, int) else offset
    return builder.bitcast(builder.gep(data, [offset]), register(size).as_pointer())


def _part(builder, data, offset, size):
    """Register of numbers at a pointer (a multiple of 8 bytes is all that is known of addresses of arrays)."""
    return builder.load(_pointer(builder, data, offset, size), align=8)


def _put(builder, data, offset, part):
    builder.store(part, _pointer(builder, data, offset, part.type.count), align=8)


def _loop(builder, first, end, begin, body):
    """Values after a loop: body(i, values) -> new values, for i = first .. end - 1, at least once."""
    before, block = builder.block, builder.append_basic_block("loop")
    builder.branch(block)
    builder.position_at_end(block)
    i = builder.phi(I64)
    i.add_incoming(ir.Constant(I64, first), before)
    values = [builder.phi(value.type) for value in begin]
    new = body(i, values)
    following = builder.add(i, ir.Constant(I64, 1))
    i.add_incoming(following, builder.block)
    for phi, start, value in zip(values, begin, new, strict=True):
        phi.add_incoming(start, before)
        phi.add_incoming(value, builder.block)
    behind = builder.append_basic_block("behind")
    builder.cbranch(builder.icmp_unsigned("<", following, ir.Constant(I64, end)), block, behind)
    builder.position_at_end(behind)
    return new


def _call(builder, result, arguments, write):
    """Call a function of its own whose body `write(*arguments)` emits; equal bodies are one function, named by their text."""
    kind = ir.FunctionType(result, [argument.type for argument in arguments])

    def emit(module, name):
        function = ir.Function(module, kind, name)
        function.calling_convention = CALLING
        with builder.goto_block(function.append_basic_block("entry")):
            builder.ret(write(*function.args))
        return function

    name = "rsc.wide." + hashlib.sha256(str(emit(ir.Module(), "body")).encode()).hexdigest()[:16]
    function = builder.module.globals.get(name)
    if function is None:
        function = emit(builder.module, name)
        function.linkage = "linkonce_odr"
        for attribute in ("noinline", "nounwind"):
            function.attributes.add(attribute)
    return builder.call(function, arguments, cconv=CALLING)
