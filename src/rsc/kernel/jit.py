"""The one decorator of the kernel: compiled without the GIL, never with fastmath, cached by the content of all kernel sources.

Numba's own disk cache looks only at the file of the cached function, so an edited helper in another file would leave old code
running silently. The cache folder is therefore named by a hash of every kernel source, the versions and the processor.
"""

import hashlib
import os
import sys
import tempfile
import warnings
from pathlib import Path

import llvmlite
import llvmlite.binding
import numba
from numba.core.caching import IndexDataCacheFile
from numba.extending import overload


def fingerprint(folder):
    """Name for compiled code: a hash of every source in a folder, the versions and the processor."""
    digest = hashlib.sha256()
    for source in sorted(Path(folder).glob("*.py")):
        digest.update(source.name.encode())
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


def cache_folder():
    """Folder of the compiled kernels of exactly these sources, versions and processor (made when missing)."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    name = fingerprint(Path(__file__).parent)
    for folder in (base / "rsc" / name, Path(tempfile.gettempdir()) / f"rsc-{os.getuid()}" / name):
        if _writable(folder):
            return folder
    return Path(tempfile.mkdtemp(prefix="rsc-"))


_INLINED = {"nogil": True, "forceinline": True, "error_model": "numpy"}


def inlined(function):
    """Compile a helper that is merged into its caller; it keeps no cache of its own."""
    return numba.njit(**_INLINED)(function)


def unrolled(choose):
    """A helper whose code depends on its arguments' types: `choose` gets the types and returns the function to merge."""

    def helper(*args):
        raise NotImplementedError("only compiled code calls this")

    overload(helper, jit_options=_INLINED, strict=False)(choose)
    return helper


def compiled(function):
    """Compile a helper that stays a function of its own inside its caller's cached code."""
    return numba.njit(nogil=True, error_model="numpy")(function)


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
            warnings.warn(f"a compiled kernel in {self._cache_path} is damaged ({error}); compiling it anew", stacklevel=2)
            self.flush()
            return None

    @staticmethod
    def _check(content):
        if hashlib.sha256(content[:-32]).digest() != content[-32:]:
            raise ValueError("wrong sum")


def entry(function):
    """Compile a function that Python calls: cached on disk in the folder named after the kernel's content."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        dispatcher = numba.njit(nogil=True, error_model="numpy", cache=True)(function)
        dispatcher._cache._cache_file.__class__ = _SummedCache
        return dispatcher
    finally:
        numba.config.CACHE_DIR = before
