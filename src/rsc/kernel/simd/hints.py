"""Hints to the compiler that change speed only, no value."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


@intrinsic
def branched(typingctx, value):
    """The value; the branch in which this stands stays one.

    LLVM turns a short branch into a selection, which waits for both sides: what is seldom needed then delays every step.
    """

    def codegen(context, builder, sig, args):
        builder.asm(ir.FunctionType(ir.VoidType(), []), "", "", [], True)
        return args[0]

    return value(value), codegen


@intrinsic
def aligned_stack(typingctx):
    """In the function that calls this the stack begins at a whole cache line, as wide registers put away there need it."""

    def codegen(context, builder, sig, args):
        attributes = builder.function.attributes
        attributes.alignstack = 64
        attributes.add("nounwind")  # true of all that Numba compiles; without it llvmlite leaves the alignment unsaid
        return context.get_dummy_value()

    return types.none(), codegen
