"""Compiled code kept on disk in a folder that its content names, and checked when read.

Numba's own disk cache looks only at the file of the cached function, so an edited helper in another file would leave old code
running silently. The folder is therefore named by a hash of every source in it, the versions and the processor.
"""

import hashlib
import os
import sys
import tempfile
import threading
import warnings
from pathlib import Path

import llvmlite
import llvmlite.binding
import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.runtime import rtsys

from rsc.compiled.near_code import near_codegen

_SETTING = threading.Lock()  # Numba's cache folder is one for all threads


def fingerprint(place):
    """Name for compiled code: a hash of its source or of every source below its folder, the versions and the processor."""
    digest, place = hashlib.sha256(), Path(place)
    for source in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
        digest.update(str(source.relative_to(place.parent)).encode())
        digest.update(source.read_bytes())
    parts = (sys.version, numba.__version__, llvmlite.__version__, llvmlite.binding.get_host_cpu_name())
    digest.update(repr(parts).encode())
    return digest.hexdigest()[:20]


def _writable(folder):
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def cache_folder(place):
    """Folder of what is compiled from exactly this source (or folder of sources), versions and processor (made when missing)."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    name = fingerprint(place)
    for folder in (base / "rsc" / name, Path(tempfile.gettempdir()) / f"rsc-{os.getuid()}" / name):
        if _writable(folder):
            return folder
    return Path(tempfile.mkdtemp(prefix="rsc-"))


class _SummedCache(IndexDataCacheFile):
    """Numba's cache files with a hash at their end: a damaged one is compiled anew, where Numba or LLVM would end the process."""

    def _dump(self, obj):
        data = super()._dump(obj)
        return data + hashlib.sha256(data).digest()  # reading what is pickled stops before it

    def _load_data(self, name):
        self._check(Path(self._data_path(name)).read_bytes())
        return super()._load_data(name)

    def load(self, key):
        try:
            return super().load(key)
        except Exception as error:  # whatever unpickling meets
            warnings.warn(f"compiled code in {self._cache_path} is damaged ({error}); compiling it anew", stacklevel=2)
            self.flush()
            return None

    @staticmethod
    def _check(content):
        if hashlib.sha256(content[:-32]).digest() != content[-32:]:
            raise ValueError("wrong sum")


class _ReadyCode(FunctionCache):
    """Numba's cache, read without loading all that Numba has for compiling, which takes longer than rsc's own start; what is
    compiled later loads it then."""

    def load_overload(self, sig, target_context):
        rtsys.initialize(target_context)  # the functions for arrays that compiled code calls
        return self._load_overload(sig, target_context.subtarget(_internal_codegen=near_codegen()))


def cached(function, place, **options):
    """Compile a function that Python calls, with these options of numba.njit, cached for its source or folder of sources."""
    with _SETTING:
        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(cache_folder(place))
        try:
            dispatcher = numba.njit(nogil=True, error_model="numpy", cache=True, **options)(function)
            dispatcher._cache.__class__ = _ReadyCode
            dispatcher._cache._cache_file.__class__ = _SummedCache
            return dispatcher
        finally:
            numba.config.CACHE_DIR = before
