"""Functions of vectors that are one walk over the registers when the vectors lie in memory."""

from types import FunctionType, SimpleNamespace

from numba import types
from numba.extending import intrinsic

from rsc.kernel.emit import Value, fma, larger
from rsc.kernel.jit import unrolled
from rsc.kernel.registers import type_of
from rsc.kernel.wide import WideType

# what `vec` means to a fused function of wide vectors
_ON_VALUES = SimpleNamespace(
    fma=fma,
    swap=Value.swapped,
    larger=larger,
    fill=lambda y, z, like: like.filled(y, z),
    spread=lambda number, like: like.spread(number),
)


def _on_values(function):
    names = {name: getattr(item, "on_values", item) for name, item in function.__globals__.items()}
    return FunctionType(function.__code__, names | {"vec": _ON_VALUES})


def fused(count=1, over=None):
    """Decorator of a function of vectors and numbers with `count` vectors as result, lane by lane but for `swap`.

    Vectors in registers: a helper merged into its caller. In memory: one walk over the registers for all of the function, which
    runs while compiling, on `emit.Value`s; its results take the memory of the arguments with the numbers `over`, which nobody
    needs any more.
    """

    def decorate(function):
        @intrinsic
        def walk(typingctx, arguments):
            kind = next(kind for kind in arguments if isinstance(kind, WideType))
            result = kind if count == 1 else types.UniTuple(kind, count)

            def codegen(context, builder, sig, args):
                def apply(*parts):
                    kinds = [type_of(part) for part in parts]
                    results = _on_values(function)(*(Value(builder, *both) for both in zip(kinds, parts, strict=True)))
                    return [value.code for value in ((results,) if count == 1 else results)]

                codes = [builder.extract_value(args[0], i) for i in range(len(arguments))]
                places = None if over is None else [codes[i] for i in over]
                vectors = kind.walked(builder, count, apply, *codes, places=places)
                return vectors[0] if count == 1 else context.make_tuple(builder, result, vectors)

            return result(arguments), codegen

        @unrolled
        def choose(*kinds):
            return (lambda *arguments: walk(arguments)) if any(isinstance(kind, WideType) for kind in kinds) else function

        choose.on_values = lambda *values: _on_values(function)(*values)
        return choose

    return decorate
