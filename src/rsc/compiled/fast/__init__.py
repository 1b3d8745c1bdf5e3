"""The fast path: how the kernel is compiled with private parts of Numba, which `rsc.compiled.paths` takes or leaves.

calls.py: how helpers call one another; compilers.py: what Numba does for helpers and for functions that Python calls;
near_code.py: where the code lies; ready_code.py: how it is read from disk.
"""

from rsc.compiled.fast.compilers import ENTRY, HELPER
from rsc.compiled.fast.ready_code import quickly_read

__all__ = ["ENTRY", "HELPER", "quickly_read"]
