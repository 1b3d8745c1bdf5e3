"""Folder of compiled code on disk, named by a hash of everything the code depends on.

Numba's disk cache checks only the file of the cached function, so that after editing a helper in another file old code would keep
running silently. The folder name is therefore a hash of all sources in the given folder and in this wing, versions and processor.
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

OWN_SOURCES = Path(__file__).parent  # these sources determine the compiled code, too
_SETTING = threading.Lock()  # Numba's cache folder is a setting of the process
_PLACES = ("CACHE_DIR", "CACHE_LOCATOR_CLASSES")  # of numba.config; a file in the current folder may set them, too


def fingerprint(place):
    """Hash for compiled code: of its source file or folder of sources, the sources of this wing, versions and processor."""
    digest = hashlib.sha256()
    for folder in (Path(place), OWN_SOURCES):
        for source in sorted(folder.rglob("*.py")) if folder.is_dir() else [folder]:
            digest.update(str(source.relative_to(folder.parent)).encode())
            digest.update(source.read_bytes())
    parts = (sys.version, numba.__version__, llvmlite.__version__, llvmlite.binding.get_host_cpu_name())
    digest.update(repr(parts).encode())
    return digest.hexdigest()[:20]


def cache_folder(place):
    """Cache folder for code compiled from exactly this source (file or folder), versions and processor, created if missing.

    Its content is unpickled and executed, so nobody else may be able to write it. None, with a single warning, if there is no
    such folder: code is then kept in memory only.
    """
    if not numba.config.OPT:  # Numba then embeds addresses that are invalid in other processes
        _say_once("NUMBA_OPT=0 is set", "unset it")
        return None
    try:
        return own_folder(user_caches(), "rsc", fingerprint(place))
    except UnsafeFolder as error:
        _say_once(str(error), f"or set {CACHES} to a folder that you own")
    return None


def keeps_code():
    """Whether compiled code is kept for later processes."""
    return cache_folder(OWN_SOURCES) is not None


@cache
def _say_once(reason, advice):
    warnings.warn(f"compiled code is not kept on disk, and every start compiles anew: {reason}; {advice}", stacklevel=4)


def in_folder(function, folder, options):
    """Apply numba.njit with these options, caching compiled code in a folder (None: in memory only)."""
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
        except RuntimeError:  # Numba found no writable folder
            pass
        finally:
            for name, value in settings.items():
                setattr(numba.config, name, value)
    # Numba could not write there and chose another, unchecked folder: compile without a cache
    return numba.njit(**options)(function)
