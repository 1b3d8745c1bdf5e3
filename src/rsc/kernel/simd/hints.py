"""Hints to the compiler that change no value."""

from llvmlite import binding, ir
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


# a section of so many bytes that no symbol and no relocation names: memory is set aside for it, and it is never put there
_ROOM = r".pushsection .rsc.room,\22aw\22,@nobits\0A.zero 4096\0A.popsection"  # \22 a quotation mark, \0A a new line


@intrinsic
def room_for_addresses(typingctx):
    """The code of the function that calls this has memory for the addresses of all that it calls.

    LLVM sets memory aside before it loads code and forgets the addresses through which functions of other libraries are called.
    It takes whole pages; where these addresses are the first beyond one, the process ends ("All memory must be pre-allocated").
    """

    def codegen(context, builder, sig, args):
        if "linux" in binding.get_default_triple():  # the format of the code and the loader that forgets are those of Linux
            binding.initialize_native_asmparser()
            builder.asm(ir.FunctionType(ir.VoidType(), []), _ROOM, "", [], True)
        return context.get_dummy_value()

    return types.none(), codegen
