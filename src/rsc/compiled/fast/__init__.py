"""The fast path: compiling the kernel with private parts of Numba; `rsc.compiled.paths` decides whether it is used.

calls.py: calling convention of helpers; compilers.py: Numba's passes for helpers and for functions called by Python;
near_code.py: memory layout of the code; ready_code.py: loading it from disk.
"""

from rsc.compiled.fast.compilers import ENTRY, HELPER
from rsc.compiled.fast.ready_code import quickly_read

__all__ = ["ENTRY", "HELPER", "quickly_read"]
