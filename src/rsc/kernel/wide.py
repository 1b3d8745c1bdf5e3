"""Vectors too wide for registers: numbers in memory, every operation a loop over registers in a function of its own.

Straight-line code for every register of every operation grows with the number of coordinates, and the time LLVM takes for it
faster. A `WideType` is a pointer instead: each operation is a call of a small function that takes the next free slots of a run's
room, walks the registers once and returns the slots. Registers, order and rounding are those of a `VecType`, and so are the bits.

What an operation made stays until the room is released to a mark before it (`vec.mark`, `vec.release`); what must outlive that is
moved to a slot made before the mark (`vec.moved`). In a `VecType` all three are nothing.
"""

import hashlib

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import models, register_model

from rsc.kernel.registers import F64, I32, I64, LARGEST, VecType, constant, fma_lanewise, register, shuffle, splat

NUMBERS = F64.as_pointer()
BYTES_AT = ir.IntType(8).as_pointer()
ROOM = I64.as_pointer()  # addresses of the next free slot, of the end and of the memory as allocated; behind them the slots
VALUE = ir.LiteralStructType([NUMBERS, ROOM])
PRODUCT = ir.LiteralStructType([VALUE, VALUE])
LINE = 64  # bytes, what slots are multiples of
BLOCK = 8  # registers of a matrix-vector product that are summed at a time
SLOTS = 512  # the most of any method in tests/test_wide.py is near 200


def narrow(stages):
    """Numbers up to which a vector is a VecType in a method of so many stages.

    In registers of four the straight-line code of more, and what lives through a step, fill the first caches. With methods of
    more stages (verner76) little is gained, with a series something lost.
    """
    return 56 if LARGEST == 8 or stages > 6 else 24


class RoomType(types.Type):
    """Numba type of a run's room for wide vectors; like the tuple `lanes` it carries their width."""

    def __init__(self, width):
        self.width = width
        super().__init__(name=f"Room{width}")

    def __len__(self):
        return self.width


@register_model(RoomType)
class _RoomModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ROOM)


class WideType(VecType):
    """Numba type of a vector of `width` doubles in memory."""

    def __init__(self, width):
        super().__init__(width, name=f"Wide{width}")

    def each(self, builder, apply, *values):
        def spread(*parts):
            size = next(part.type.count for part in parts if part.type != F64)
            return [apply(*(splat(builder, part, size) if part.type == F64 else part for part in parts))]

        return self.walked(builder, [None], spread, *values)[0]

    def walked(self, builder, places, apply, *values):
        """Vectors in the memory of others, the `places`, or new (None); `apply` makes their registers of those of the values, in
        one walk."""
        room, taken = _room_of(builder, values), [place for place in places if place is not None]
        count = len(places) - len(taken)

        def targets(out, taken):
            new, taken = (self._further(builder, out, i) for i in range(count)), iter(taken)
            return [next(new if place is None else taken) for place in places]

        def write(room, *inner):
            out = self.slots(builder, room, count) if count else ir.Constant(NUMBERS, ir.Undefined)
            self._walk(builder, apply, targets(out, inner[: len(taken)]), inner[len(taken) :])
            return out

        data = _call(builder, NUMBERS, [room, *(_bare(builder, v) for v in (*taken, *values))], write)
        return [value_of(builder, place, room) for place in targets(data, [_bare(builder, place) for place in taken])]

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

    def slots(self, builder, room, count):
        """Pointer to the next free slots."""
        start = builder.load(room)
        end = builder.add(start, ir.Constant(I64, 8 * self._size * count))
        limit = builder.load(builder.gep(room, [ir.Constant(I32, 1)]))
        with builder.if_then(builder.icmp_unsigned(">", end, limit), likely=False):
            trap = cgutils.get_or_insert_function(builder.module, ir.FunctionType(ir.VoidType(), []), "llvm.trap")
            builder.call(trap, [])
        builder.store(end, room)
        return builder.inttoptr(start, NUMBERS)

    def filled(self, builder, y, z, like):
        def mixed(_, p, q):
            size = p.type.count
            return shuffle(builder, p, q, [i + size * (i % 2) for i in range(size)])

        return self.each(builder, mixed, like, y, z)

    def one_pair(self, builder, value, combine):
        return self.reduced(builder, combine, lambda part: part, value)

    def reduced(self, builder, combine, apply, *values):
        """[y, z] of all pairs combined, of the registers that `apply` makes of those of the values."""
        # the order of VecType.one_pair: registers of a size first, then the upper half of a register onto its lower
        pair = ir.LiteralStructType([F64, F64])

        def write(*sources):
            def part(offset, size):
                return apply(*(s if s.type == F64 else _part(builder, s, offset, size) for s in sources))

            total = _loop(builder, 1, self.width // 8, [part(0, 8)], lambda i, totals: [
                combine(builder, totals[0], part(_times(builder, i, 8), 8))
            ])[0]  # fmt: skip
            offset = self.width // 8 * 8
            for size in (4, 2):
                upper = shuffle(builder, total, total, list(range(size, 2 * size)))
                total = combine(builder, shuffle(builder, total, total, list(range(size))), upper)
                if self.width % 8 & size:
                    total = combine(builder, total, part(offset, size))
                    offset += size
            result = ir.Constant(pair, ir.Undefined)
            for i in range(2):
                result = builder.insert_value(result, builder.extract_element(total, ir.Constant(I32, i)), i)
            return result

        result = _call(builder, pair, [_bare(builder, v) for v in values], write)
        return [builder.extract_value(result, i) for i in range(2)]

    def columns(self, builder, base, value):
        room = _room_of(builder, [value])

        def write(room, base, data):
            out, matrix = self.slots(builder, room, 1), builder.inttoptr(base, NUMBERS)
            parts = self.parts
            for first in range(0, len(parts), BLOCK):
                block = parts[first : first + BLOCK]

                def column(j, totals, first=first, block=block):
                    pair = _part(builder, data, _times(builder, j, 2), 2)
                    start = builder.add(_times(builder, j, self.width), ir.Constant(I64, 8 * first))
                    sums = []
                    for i, (size, total) in enumerate(zip(block, totals, strict=True)):
                        entry = shuffle(builder, pair, pair, [k % 2 for k in range(size)])
                        offset = builder.add(start, ir.Constant(I64, sum(block[:i])))
                        sums.append(fma_lanewise(builder, _part(builder, matrix, offset, size), entry, total))
                    return sums

                zeros = [constant(0.0, register(size)) for size in block]
                totals = _loop(builder, 0, self.width // 2, zeros, column)
                for i, total in enumerate(totals):
                    _put(builder, out, ir.Constant(I64, 8 * first + sum(block[:i])), total)
            return out

        data = _call(builder, NUMBERS, [room, base, _bare(builder, value)], write)
        return value_of(builder, data, room)

    def get(self, builder, value, i):
        raise NotImplementedError("lanes are taken from a single register")

    put = get

    def _walk(self, builder, apply, targets, sources):
        """targets = apply(numbers and registers of the sources), register by register."""

        def at(offset, size):
            parts = apply(*(s if s.type == F64 else _part(builder, s, offset, size) for s in sources))
            for target, part in zip(targets, parts, strict=True):
                _put(builder, target, offset, part)

        _loop(builder, 0, self.width // 8, [], lambda i, _: at(_times(builder, i, 8), 8) or [])
        offset = self.width // 8 * 8
        for size in self.parts[self.width // 8 :]:
            at(ir.Constant(I64, offset), size)
            offset += size


class ProductType(types.Type):
    """Numba type of two wide vectors whose product is summed."""

    number = types.float64

    def __init__(self, factor):
        self.factor = factor
        super().__init__(name=f"Product{factor.width}")

    def of(self, builder, a, b):
        """The product of two vectors."""
        return builder.insert_value(builder.insert_value(ir.Constant(PRODUCT, ir.Undefined), a, 0), b, 1)

    def one_pair(self, builder, value, combine):
        """[y, z] of all pairs of the product combined."""
        return self.factor.reduced(builder, combine, builder.fmul, *(builder.extract_value(value, i) for i in range(2)))


@register_model(ProductType)
class _ProductModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, PRODUCT)


@register_model(WideType)
class _WideModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, VALUE)


def value_of(builder, data, room):
    """The vector at a pointer."""
    value = builder.insert_value(ir.Constant(VALUE, ir.Undefined), data, 0)
    return builder.insert_value(value, room, 1)


def new_room(builder, width):
    """An empty room, to be given back by `close_room`."""
    size = SLOTS * (-(-8 * width // LINE) * LINE)
    memory = _of_numba(builder, BYTES_AT, "NRT_Allocate", ir.Constant(I64, size + 2 * LINE))
    start = builder.and_(builder.add(builder.ptrtoint(memory, I64), ir.Constant(I64, LINE - 1)), ir.Constant(I64, -LINE))
    room, first = builder.inttoptr(start, ROOM), builder.add(start, ir.Constant(I64, LINE))
    for i, item in enumerate((first, builder.add(first, ir.Constant(I64, size)), builder.ptrtoint(memory, I64))):
        builder.store(item, builder.gep(room, [ir.Constant(I32, i)]))
    return room


def close_room(builder, room):
    """Give a room's memory back."""
    memory = builder.load(builder.gep(room, [ir.Constant(I32, 2)]))
    _of_numba(builder, ir.VoidType(), "NRT_Free", builder.inttoptr(memory, BYTES_AT))


def _of_numba(builder, result, name, argument):
    """Call a function of Numba's run time; its `context.nrt` wants every function to count references."""
    kind = ir.FunctionType(result, [argument.type])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [argument])


def _bare(builder, value):
    """The pointer of a vector, anything else as it is."""
    return builder.extract_value(value, 0) if value.type == VALUE else value


def _room_of(builder, values):
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
    return builder.call(function, arguments)
