"""The two ways of compiling: plain `numba.njit`, and a fast path that uses private parts of Numba (the wing `fast`).

Both give the same bits and equally fast code. The fast path compiles in a quarter of the time and half the memory. No release of
Numba guarantees what it needs, so it is used only if a canary has shown that it works with the installed Numba.
"""

import os
import warnings
from functools import cache

import numba

from rsc.compiled.canary import try_out
from rsc.compiled.code_cache import OWN_SOURCES, cache_folder, in_folder
from rsc.errors import SolverError

PLAIN = "RSC_PLAIN"  # environment variable: any value forces the plain path, for tests
_PLAIN_HELPER = {"nogil": True, "error_model": "numpy"}


@cache
def fast_path():
    """The package `fast`, or None for the plain path, with a single warning why. SolverError if compilation is disabled."""
    if numba.config.DISABLE_JIT:
        raise SolverError("NUMBA_DISABLE_JIT is set: a simulation needs compiled code")
    if os.environ.get(PLAIN) or not numba.config.OPT:
        return None
    try:
        from rsc.compiled import fast

        _try_out_once()
    except Exception as error:  # a changed Numba may raise anything
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        text = f"Numba {numba.__version__} does not support rsc's fast compilation ({reason}): same results, slower first call"
        warnings.warn(text, stacklevel=2)
        return None
    return fast


def _try_out_once():
    """Try the fast path out, once for these sources, versions and processor; ValueError where it fails."""
    folder = cache_folder(OWN_SOURCES)
    if folder is not None and (folder / "canary").exists():
        return
    try_out()
    if folder is not None:
        (folder / "canary").touch()


def helper_options(**options):
    """Options of numba.njit for a function called only by compiled code."""
    fast = fast_path()
    return (fast.HELPER if fast else _PLAIN_HELPER) | options


def entry_options():
    """Options of `cached` for a function called by Python."""
    fast = fast_path()
    return fast.ENTRY if fast else {}


def cached(function, place, **options):
    """Compile a function called by Python, with these options of numba.njit, cached for its source file or folder of sources."""
    fast, folder = fast_path(), cache_folder(place)
    if fast is None:
        return in_folder(function, folder and folder / "plain", options)
    return fast.quickly_read(in_folder(function, folder, options))
