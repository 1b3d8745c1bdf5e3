"""Compiled code from disk, checked when read, without Numba's compiler."""

import hashlib
import warnings
from pathlib import Path

from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.runtime import rtsys

from rsc.compiled.fast.near_code import near_codegen


class _SummedCache(IndexDataCacheFile):
    """Numba's cache files with a hash at their end: a damaged one is compiled anew, where Numba or LLVM would end the process."""

    def _dump(self, obj):
        data = super()._dump(obj)
        return data + hashlib.sha256(data).digest()  # reading what is pickled stops before it

    def _load_data(self, name):
        self._check(Path(self._data_path(name)).read_bytes())
        return super()._load_data(name)

    def save(self, key, data):
        try:
            super().save(key, (key, data))
        except OSError as error:  # a full disk, or a folder that is gone
            text = f"compiled code cannot be kept in {self._cache_path} ({error.strerror}), and the next start compiles anew"
            warnings.warn(text, stacklevel=2)

    def load(self, key):
        try:
            entry = super().load(key)
            # of processes that begin with an empty folder at once two may have given their code the same name
            return entry[1] if entry is not None and entry[0] == key else None
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


def quickly_read(dispatcher):
    """The function compiled by Numba, its cache on disk, if it has one, checked and read quickly."""
    if dispatcher.stats.cache_path is None:
        return dispatcher
    dispatcher._cache.__class__ = _ReadyCode
    dispatcher._cache._cache_file.__class__ = _SummedCache
    return dispatcher
