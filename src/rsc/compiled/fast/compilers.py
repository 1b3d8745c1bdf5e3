"""Compilers: helpers are turned into LLVM code once, and optimised only inside the functions that Python calls."""

import gc

import llvmlite.binding
from numba.core import typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager

from rsc.compiled.fast.calls import HelperLowering, call_of
from rsc.compiled.fast.near_code import near_codegen

_BETWEEN_COLLECTIONS = 20_000  # allocations; with Python's default of 700 compiling takes a few percent longer

# Numba's passes for a helper, without those for features that the kernel does not use (nested functions, `with`, None as an
# argument, array expressions, reference counting) and for what LLVM does itself (dead branches)
_PASSES = (
    untyped_passes.TranslateByteCode,
    untyped_passes.FixupArgs,
    untyped_passes.IRProcessing,
    untyped_passes.GenericRewrites,
    untyped_passes.ReconstructSSA,
    typed_passes.NopythonTypeInference,
    typed_passes.PreLowerStripPhis,
    HelperLowering,
    typed_passes.NoPythonBackend,
)


class _WholeLibrary(JITCodeLibrary):
    """LLVM code of a function called by Python; every helper that it uses directly or indirectly is linked in once."""

    def add_linking_library(self, library):
        for part in (library, *library._linking_libraries):
            if part not in self._linking_libraries:
                super().add_linking_library(part)


class _Part(_WholeLibrary):
    """LLVM code of a helper, optimised and translated only inside the functions called by Python. Numba would do both for every
    helper separately, optimise again for each of its callers, and add two wrappers for calls from Python and C. Stored as
    bitcode, which takes less memory than modules (bench/results/memory.md)."""

    def finalize(self):
        self._finalized = True
        self._bitcode = super()._get_module_for_linking().as_bitcode()
        self._final_module = self._shared_module = None

    def _get_module_for_linking(self):
        return llvmlite.binding.parse_bitcode(self._bitcode)

    def _optimize_functions(self, ll_module):
        ll_module.data_layout = self._codegen._data_layout


class _WholeCompiler(Compiler):
    def define_pipelines(self):
        self.state.library = _WholeLibrary(near_codegen(), self.state.func_id.func_qualname)
        self.state.library.enable_object_caching()
        return super().define_pipelines()

    def compile_extra(self, func):
        # compiling creates hardly any garbage, but makes Python's collector search all objects often
        usual = gc.get_threshold()
        gc.set_threshold(max(usual[0], _BETWEEN_COLLECTIONS) if usual[0] else 0, *usual[1:])
        try:
            return super().compile_extra(func)
        finally:
            gc.set_threshold(*usual)


class _PartCompiler(Compiler):
    def define_pipelines(self):
        self.state.flags.no_compile = True
        self.state.library = _Part(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        passes = PassManager("part")
        for needed in _PASSES:
            passes.add_pass(needed)
        passes.finalize()
        return [passes]

    def compile_extra(self, func):
        result = super().compile_extra(func)
        name = [result].append  # a placeholder of the type by which Numba looks functions up
        self.state.targetctx.insert_func_defn([(call_of(result.fndesc, result.library), name, result.fndesc.argtypes)])
        return result._replace(entry_point=name)

# options of numba.njit for a function called only by compiled code, and for one called by Python
HELPER = {
    "nogil": True,
    "_nrt": False,  # the kernel creates no arrays: no reference counting in helpers
    "error_model": "numpy",
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "pipeline_class": _PartCompiler,
}
ENTRY = {"_nrt": False, "pipeline_class": _WholeCompiler}
