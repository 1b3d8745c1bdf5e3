"""What Numba is made to do: helpers become LLVM code only, once, and are optimised inside the functions that Python calls."""

import gc

import llvmlite.binding
from numba.core import typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager

from rsc.compiled.fast.calls import HelperLowering, call_of
from rsc.compiled.fast.near_code import near_codegen

_BETWEEN_COLLECTIONS = 20_000  # objects made; with Python's own 700 compiling takes some percent longer

# Numba's passes for a helper. Left out are those for what the kernel has not (nested functions, `with`, None as an argument,
# arrays in expressions, counted references) and for what LLVM does (branches never taken)
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
    """LLVM code of a function that Python calls: each of its helpers, near and far, is linked in once."""

    def add_linking_library(self, library):
        for part in (library, *library._linking_libraries):
            if part not in self._linking_libraries:
                super().add_linking_library(part)


class _Part(_WholeLibrary):
    """LLVM code of a helper: optimised and translated only inside the functions that Python calls, where Numba would do both for
    every helper alone, optimise again for each caller of it, and add two wrappers for calls from Python and C. Kept as
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
        # next to nothing of what Python's collector looks through meanwhile is garbage, and all of it is looked through often
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
        name = [result].append  # no compiled function, but of the type that Numba looks them up by
        self.state.targetctx.insert_func_defn([(call_of(result.fndesc, result.library), name, result.fndesc.argtypes)])
        return result._replace(entry_point=name)

# options of numba.njit for a function that only compiled code calls, and for one that Python calls
HELPER = {
    "nogil": True,
    "_nrt": False,  # the kernel makes no arrays: no references are counted in every helper
    "error_model": "numpy",
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "pipeline_class": _PartCompiler,
}
ENTRY = {"_nrt": False, "pipeline_class": _WholeCompiler}
