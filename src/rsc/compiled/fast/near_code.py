"""Numba's code generator with what belongs to a function, its code and its constants, in one block of memory.

Numba lets LLVM assume that they may lie anywhere: every call and every constant then takes an instruction for its address, and
calls go through registers. In one block they are reached by their distance.
"""

from functools import cache

import numba
from numba.core.codegen import JITCPUCodegen
from numba.core.compiler_lock import global_compiler_lock


class _NearCodegen(JITCPUCodegen):
    def _customize_tm_options(self, options):
        super()._customize_tm_options(options)
        options.update(reloc="pic", codemodel="small")


@global_compiler_lock
@cache
def near_codegen():
    """The one code generator of this process for what `code_cache` keeps."""
    before = numba.config.USE_LLVMLITE_MEMORY_MANAGER
    numba.config.USE_LLVMLITE_MEMORY_MANAGER = True  # the memory manager that puts all sections of a function in one block
    try:
        return _NearCodegen("rsc")
    finally:
        numba.config.USE_LLVMLITE_MEMORY_MANAGER = before
