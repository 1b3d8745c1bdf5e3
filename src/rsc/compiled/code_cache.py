"""Folder of compiled code on disk, named by what the code is made of.

Numba's own disk cache looks only at the file of the cached function, so an edited helper in another file would leave old code
running silently. The folder is therefore named by a hash of every source in it, of this wing, the versions and the processor.
"""

import hashlib
import sys
import threading
import warnings
from functools import cache
from pathlib import Path

import llvmlite
import llvmlite.binding
import numba

from rsc.operating_system import CACHES, UnsafeFolder, own_folder, user_caches

OWN_SOURCES = Path(__file__).parent  # how code is compiled decides what it is, as its own source does
_SETTING = threading.Lock()  # Numba's cache folder is one for all threads
_PLACES = ("CACHE_DIR", "CACHE_LOCATOR_CLASSES")  # of numba.config; a file in the current folder can set them as well


def fingerprint(place):
    """Name for compiled code: a hash of its source or sources below its folder, those of this wing, versions and processor."""
    digest = hashlib.sha256()
    for folder in (Path(place), OWN_SOURCES):
        for source in sorted(folder.rglob("*.py")) if folder.is_dir() else [folder]:
            digest.update(str(source.relative_to(folder.parent)).encode())
            digest.update(source.read_bytes())
    parts = (sys.version, numba.__version__, llvmlite.__version__, llvmlite.binding.get_host_cpu_name())
    digest.update(repr(parts).encode())
    return digest.hexdigest()[:20]


def cache_folder(place):
    """Folder of what is compiled from exactly this source (or folder of sources), versions and processor, made when missing.

    What is in it gets unpickled and executed, so it is one that nobody else can write. Without any, None: code then is kept in
    memory only, which is said once.
    """
    if not numba.config.OPT:  # Numba then puts addresses into the code, which are no others' in another process
        _say_once("NUMBA_OPT=0 is set", "unset it")
        return None
    try:
        return own_folder(user_caches(), "rsc", fingerprint(place))
    except UnsafeFolder as error:
        _say_once(str(error), f"or set {CACHES} to a folder of yours")
    return None


def keeps_code():
    """Whether compiled code is found again by the next process."""
    return cache_folder(OWN_SOURCES) is not None


@cache
def _say_once(reason, advice):
    warnings.warn(f"compiled code is not kept on disk, and every start compiles anew: {reason}; {advice}", stacklevel=4)


def in_folder(function, folder, options):
    """numba.njit with these options, what it compiles kept in a folder (None: in memory only)."""
    options = {"nogil": True, "error_model": "numpy", **options}
    if folder is None:
        return numba.njit(**options)(function)
    with _SETTING:
        settings = {name: getattr(numba.config, name) for name in _PLACES if hasattr(numba.config, name)}
        numba.config.CACHE_DIR, numba.config.CACHE_LOCATOR_CLASSES = str(folder), ""
        try:
            kept = numba.njit(cache=True, **options)(function)
            if Path(kept.stats.cache_path).is_relative_to(folder):
                return kept
        except RuntimeError:  # no folder at all
            pass
        finally:
            for name, value in settings.items():
                setattr(numba.config, name, value)
    # where Numba cannot write it takes a folder that nobody has checked
    return numba.njit(**options)(function)
