"""Hints to the compiler that change speed only, no value."""

from llvmlite import ir
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
