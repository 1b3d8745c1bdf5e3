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
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
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


class _Whole(JITCodeLibrary):
    """LLVM code of a function that Python calls: each of its helpers, near and far, is linked in once."""

    def add_linking_library(self, library):
        for part in (library, *library._linking_libraries):
            if part not in self._linking_libraries:
                super().add_linking_library(part)


class _Part(_Whole):
    """LLVM code of a helper: optimised and translated only inside the functions that Python calls, where Numba would do both for
    every helper alone, again for each caller of it, and add two wrappers for calls from Python and C."""

    def finalize(self):
        self._finalized = True


class _WholeCompiler(Compiler):
    def define_pipelines(self):
        self.state.library = _Whole(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        self.state.library.enable_object_caching()
        return super().define_pipelines()


class _PartCompiler(Compiler):
    def define_pipelines(self):
        self.state.flags.no_compile = True
        self.state.library = _Part(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        return super().define_pipelines()

    def compile_extra(self, func):
        result = super().compile_extra(func)
        name = [result].append  # no compiled function, but of the type that Numba looks them up by
        self.state.targetctx.insert_user_function(name, result.fndesc, [result.library])
        return result._replace(entry_point=name)


_PART = {
    "nogil": True,
    "error_model": "numpy",
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "pipeline_class": _PartCompiler,
}
_INLINED = {**_PART, "forceinline": True}


def inlined(function):
    """Compile a helper that is merged into its caller; it keeps no cache of its own."""
    return numba.njit(**_INLINED)(function)


def unrolled(choose):
    """A helper whose code depends on its arguments' types: `choose` gets the types and returns the function to merge."""

    def helper(*args):
        raise NotImplementedError("only compiled code calls this")

    overloaded(helper)(choose)
    return helper


def overloaded(function):
    """numba.extending.overload whose code is merged into its caller."""
    return overload(function, jit_options=_INLINED, strict=False)


def compiled(function):
    """Compile a helper that stays a function of its own inside its caller's cached code; only compiled code calls it."""
    return numba.njit(**_PART)(function)


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
        dispatcher = numba.njit(nogil=True, error_model="numpy", cache=True, pipeline_class=_WholeCompiler)(function)
        dispatcher._cache._cache_file.__class__ = _SummedCache
        return dispatcher
    finally:
        numba.config.CACHE_DIR = before
