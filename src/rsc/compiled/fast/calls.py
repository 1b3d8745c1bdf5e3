"""Calling convention of helpers: tuples are passed and returned whole.

Numba's own convention splits a tuple into its numbers for every call, rebuilds it afterwards, and then checks whether the call
has failed: most of the instructions of the kernel's helpers before inlining. Helpers raise nothing, and LLVM itself finds out
which parts of a tuple are used.
"""

from llvmlite import ir
from numba.core import cgutils, errors
from numba.core import ir as numba_ir
from numba.core.callconv import RETCODE_OK, errcode_t, excinfo_ptr_t
from numba.core.compiler_machinery import register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import BaseNativeLowering


def _declared(context, module, description):
    """Declare a helper in a module: the first argument points to its result, the second is Numba's error argument."""
    result = context.get_value_type(description.restype).as_pointer()
    values = [context.get_value_type(kind) for kind in description.argtypes]
    kind = ir.FunctionType(errcode_t, [result, excinfo_ptr_t.as_pointer(), *values])
    function = cgutils.get_or_insert_function(module, kind, description.mangled_name)
    function.args[0].add_attribute("noalias")
    if description.inline:
        function.attributes.add("alwaysinline")
    return function


class _HelperLower(Lower):
    """Numba's lowering to LLVM instructions, with changed arguments and result."""

    def setup_function(self, fndesc):
        self.function = _declared(self.context, self.module, fndesc)
        self.entry_block = self.function.append_basic_block("entry")
        self.builder = ir.IRBuilder(self.entry_block)
        self.call_helper = self.call_conv.init_call_helper(self.builder)

    def extract_function_arguments(self):
        self.fnargs = self.function.args[2:]
        return self.fnargs

    def lower_inst(self, inst):
        if isinstance(inst, numba_ir.Raise | numba_ir.StaticRaise | numba_ir.DynamicRaise):
            raise errors.UnsupportedError("a helper cannot raise: its callers do not check for errors", loc=inst.loc)
        if not isinstance(inst, numba_ir.Return):
            return super().lower_inst(inst)
        self.builder.store(self.loadvar(inst.value.name), self.function.args[0])
        self.builder.ret(RETCODE_OK)


@register_pass(mutates_CFG=True, analysis_only=False)
class HelperLowering(BaseNativeLowering):
    """Numba's lowering pass, for helpers."""

    _name = "helper_lowering"
    lowering_class = _HelperLower


def _packed(builder, value, kind):
    """A value in the layout of its type: Numba passes `*arguments` of one type as a structure where an array is expected."""
    return value if value.type == kind else cgutils.pack_array(builder, cgutils.unpack_tuple(builder, value))


def call_of(description, library):
    """Code generator for calls of a helper."""

    def call(context, builder, sig, args):
        function = _declared(context, builder.module, description)
        result = cgutils.alloca_once(builder, function.args[0].type.pointee)
        values = [_packed(builder, value, place.type) for value, place in zip(args, function.args[2:], strict=True)]
        builder.call(function, [result, ir.Constant(function.args[1].type, None), *values])
        return builder.load(result)

    call.signature = description.argtypes
    call.libs = (library,)
    return call
