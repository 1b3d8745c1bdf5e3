"""Loading of compiled code from disk, with a checksum and without Numba's compiler."""

import hashlib
import warnings
from pathlib import Path

from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.runtime import rtsys

from rsc.compiled.fast.near_code import near_codegen


class _SummedCache(IndexDataCacheFile):
    """Numba's cache files with a checksum: a damaged one is recompiled, where Numba or LLVM would abort the process."""

    def _dump(self, obj):
        data = super()._dump(obj)
        return data + hashlib.sha256(data).digest()  # unpickling stops before it

    def _load_data(self, name):
        self._check(Path(self._data_path(name)).read_bytes())
        return super()._load_data(name)

    def save(self, key, data):
        try:
            super().save(key, (key, data))
        except OSError as error:  # a full disk, or a removed folder
            text = f"compiled code cannot be kept in {self._cache_path} ({error.strerror}), and the next start compiles anew"
            warnings.warn(text, stacklevel=2)

    def load(self, key):
        try:
            entry = super().load(key)
            # processes that start together on an empty folder may have used the same file name for different code
            return entry[1] if entry is not None and entry[0] == key else None
        except Exception as error:  # unpickling may raise anything
            warnings.warn(f"compiled code in {self._cache_path} is damaged ({error}); compiling it anew", stacklevel=2)
            self.flush()
            return None

    @staticmethod
    def _check(content):
        if hashlib.sha256(content[:-32]).digest() != content[-32:]:
            raise ValueError("wrong sum")


class _ReadyCode(FunctionCache):
    """Numba's cache, read without loading Numba's compiler, which takes longer than the start of rsc itself; it is loaded when
    something is compiled later."""

    def load_overload(self, sig, target_context):
        rtsys.initialize(target_context)  # the array functions that compiled code calls
        return self._load_overload(sig, target_context.subtarget(_internal_codegen=near_codegen()))


def quickly_read(dispatcher):
    """A function compiled by Numba, whose disk cache (if any) is read quickly and with a checksum."""
    if dispatcher.stats.cache_path is None:
        return dispatcher
    dispatcher._cache.__class__ = _ReadyCode
    dispatcher._cache._cache_file.__class__ = _SummedCache
    return dispatcher
