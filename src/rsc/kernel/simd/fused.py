"""Functions of vectors that are one walk over the registers when the vectors lie in memory."""

from functools import partial
from types import CellType, FunctionType, SimpleNamespace

from numba import types
from numba.extending import intrinsic

from rsc.kernel.simd.emit import Product, Value, fma, larger, weighted
from rsc.kernel.simd.jit import unrolled
from rsc.kernel.simd.registers import VecType, add, keep_larger, type_of
from rsc.kernel.simd.wide import WideType

# what `vec` means to a fused function of wide vectors
_ON_VALUES = SimpleNamespace(
    fma=fma,
    swap=Value.swapped,
    larger=larger,
    pair_sums=Value.pair_sums,
    product=Product,
    fill=lambda y, z, pattern: pattern.filled(y, z),
    spread=lambda number, pattern: pattern.spread(number),
)


# and other functions it may call
_BY_NAME = {"vec": _ON_VALUES}

# for what the last result of a fused function is wanted
SUM, LARGEST = add, keep_larger


def _on_values(function):
    def known(item):
        weights = getattr(item, "row_weights", None)
        return partial(weighted, weights) if weights else getattr(item, "on_values", item)

    names = {name: known(item) for name, item in function.__globals__.items()} | _BY_NAME
    cells = tuple(CellType(known(cell.cell_contents)) for cell in function.__closure__ or ())
    return FunctionType(function.__code__, names, closure=cells)


def _flat(kind, builder=None, code=None):
    """The types in a tuple and the tuples in it, or given its code theirs."""
    if not isinstance(kind, types.BaseTuple):
        return [kind if builder is None else code]
    codes = [builder and builder.extract_value(code, i) for i in range(len(kind))]
    return [item for part, inner in zip(kind, codes, strict=True) for item in _flat(part, builder, inner)]


def _nested(kind, items):
    """Items in a row as they lie in a tuple."""
    return tuple(_nested(part, items) for part in kind) if isinstance(kind, types.BaseTuple) else next(items)


def fused(count=1, over=None, only=()):
    """Decorator of a function of vectors and numbers, or tuples of them, with vectors as result, lane by lane but for `swap`:
    `count` of them and others behind, of which `only` their `vec.pair_sum` (SUM) or `vec.largest` (LARGEST) is wanted.

    Vectors in registers: a helper merged into its caller. In memory: one walk over the registers for all of the function, which
    runs while compiling, on `emit.Value`s; its results take the memory of the arguments with the numbers `over`, which nobody
    needs any more (None: new memory).
    """

    def decorate(function):
        @intrinsic
        def walk(typingctx, arguments):
            kind = next(kind for kind in _flat(arguments) if isinstance(kind, WideType))
            kinds = [kind] * count + [VecType(2)] * len(only)
            result = types.Tuple(kinds) if len(kinds) > 1 else kinds[0]

            def codegen(context, builder, sig, args):
                def apply(*parts):
                    values = (Value(builder, type_of(part), part) for part in parts)
                    results = _on_values(function)(*_nested(arguments, values))
                    return [value.code for value in (results if len(kinds) > 1 else (results,))]

                codes = _flat(arguments, builder, args[0])
                places = [None if i is None else codes[i] for i in over or [None] * count]
                results = kind.walked(builder, places, apply, *codes, combine=only)
                return context.make_tuple(builder, result, results) if len(kinds) > 1 else results[0]

            return result(arguments), codegen

        @unrolled
        def choose(*kinds):
            wide = any(isinstance(kind, WideType) for kind in _flat(types.Tuple(kinds)))
            return (lambda *arguments: walk(arguments)) if wide else function

        choose.on_values = lambda *values: _on_values(function)(*values)
        return choose

    return decorate
