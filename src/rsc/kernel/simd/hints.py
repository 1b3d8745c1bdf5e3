"""Hints to the compiler that change no value."""

from llvmlite import binding, ir
from numba import types
from numba.extending import intrinsic


@intrinsic
def branched(typingctx, value):
    """The value itself; keeps the surrounding branch a branch.

    LLVM turns a short branch into a select, which waits for both sides: a rarely needed side would then delay every step.
    """

    def codegen(context, builder, sig, args):
        builder.asm(ir.FunctionType(ir.VoidType(), []), "", "", [], True)
        return args[0]

    return value(value), codegen


@intrinsic
def aligned_stack(typingctx):
    """Align the stack of the calling function to a cache line, which spilled wide registers need."""

    def codegen(context, builder, sig, args):
        attributes = builder.function.attributes
        attributes.alignstack = 64
        attributes.add("nounwind")  # true for all code compiled by Numba; without it llvmlite omits the alignment
        return context.get_dummy_value()

    return types.none(), codegen


# a section without symbols and relocations: memory is reserved for it, but never used
_ROOM = r".pushsection .rsc.room,\22aw\22,@nobits\0A.zero 4096\0A.popsection"  # \22: quotation mark, \0A: newline


@intrinsic
def room_for_addresses(typingctx):
    """Reserve memory for the addresses of all functions called by the code of the calling function.

    LLVM reserves memory before it loads code and does not count the address table for calls into other libraries. It reserves
    whole pages; if this table would be the first to exceed one, the process aborts ("All memory must be pre-allocated").
    """

    def codegen(context, builder, sig, args):
        if "linux" in binding.get_default_triple():  # code format and loader with this defect are those of Linux
            binding.initialize_native_asmparser()
            builder.asm(ir.FunctionType(ir.VoidType(), []), _ROOM, "", [], True)
        return context.get_dummy_value()

    return types.none(), codegen
