"""Compilation of functions and the disk cache of their code. Private parts of Numba are used only in `fast`."""

import numba

from rsc.errors import RscError

OLDEST_NUMBA = (0, 63)  # 0.61 fails on vectors in memory

if tuple(int(part) for part in numba.__version__.split(".")[:2]) < OLDEST_NUMBA:
    needed = ".".join(map(str, OLDEST_NUMBA))
    raise RscError(f"Numba {numba.__version__} is too old for rsc: python -m pip install --upgrade 'numba>={needed}'")
