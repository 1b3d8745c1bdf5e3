"""Numba's code generator, with code and constants of a function in one block of memory.

Numba lets LLVM assume that they may be anywhere, so that every call and every constant takes an instruction for its address, and
calls go through registers. Within one block relative addresses suffice. On Windows Numba's own assumption stays: functions of
other libraries lie out of reach there, LLVM's loader of COFF code makes no jumps to them, and an assertion ends the process.
"""

from functools import cache

import numba
from numba.core.codegen import JITCPUCodegen
from numba.core.compiler_lock import global_compiler_lock

from rsc.operating_system import NEAR_CODE


class _NearCodegen(JITCPUCodegen):
    def _customize_tm_options(self, options):
        super()._customize_tm_options(options)
        options.update(reloc="pic", codemodel="small")


@global_compiler_lock
@cache
def near_codegen():
    """The code generator, one per process, for code kept by `code_cache`."""
    if not NEAR_CODE:
        return JITCPUCodegen("rsc")
    before = numba.config.USE_LLVMLITE_MEMORY_MANAGER
    numba.config.USE_LLVMLITE_MEMORY_MANAGER = True  # this memory manager puts all sections of a function into one block
    try:
        return _NearCodegen("rsc")
    finally:
        numba.config.USE_LLVMLITE_MEMORY_MANAGER = before
