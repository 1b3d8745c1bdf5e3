"""Threads of BLAS: for matrices as small as those of a scene more than one costs more than it saves.

NumPy and SciPy each bring an OpenBLAS, and idle threads of one spin on the processors that the other needs.
"""

import contextlib
import threading
from functools import cache
from typing import Any

_THREADED = 20  # coordinates from which OpenBLAS splits some products among threads; below, setting the limit only costs time


@cache
def _libraries() -> Any:
    import scipy.linalg  # noqa: F401  loads its OpenBLAS, which is not found before
    from threadpoolctl import ThreadpoolController  # 5 ms that few runs need

    return ThreadpoolController()


class _OneThread(contextlib.ContextDecorator):
    """Context manager or decorator that limits the BLAS of the whole process to one thread.

    Several threads may be inside at once: the last one to leave restores the limits that the first one found.
    """

    def __init__(self) -> None:
        self._lock, self._inside = threading.Lock(), 0
        self._limits: Any = None

    def __enter__(self) -> None:
        with self._lock:
            if self._inside == 0:
                self._limits = _libraries().limit(limits=1, user_api="blas")
            self._inside += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                self._limits.restore_original_limits()


one_thread = _OneThread()


@cache
def product() -> str:
    """Name of NumPy's BLAS and of the processor type it is set to; results depend on both bit for bit.

    The environment variable `OPENBLAS_CORETYPE` can change the latter with all versions equal.
    """
    from threadpoolctl import ThreadpoolController

    libraries = [lib for lib in ThreadpoolController().info() if lib["user_api"] == "blas"]
    blas = next((lib for lib in libraries if "numpy" in lib["filepath"]), libraries[0] if libraries else {})
    return " ".join(filter(None, (blas.get("internal_api", "its own linear algebra"), blas.get("architecture"))))


def threads_for(coordinates: int) -> contextlib.AbstractContextManager[None]:
    """Context manager for linear algebra with this many coordinates: limits BLAS to one thread where it would use more."""
    return one_thread if coordinates >= _THREADED else contextlib.nullcontext()
