"""Threads of the linear algebra: for matrices as small as those of a scene they cost more than they give.

NumPy and SciPy come with an OpenBLAS each, and the threads of one wait for work on the processor that the other needs.
"""

import contextlib
import threading
from functools import cache

_THREADED = 20  # coordinates from which OpenBLAS divides some products among threads; with fewer the limit only costs


@cache
def _libraries():
    import scipy.linalg  # noqa: F401  brings its own OpenBLAS, which is found only once it is loaded
    from threadpoolctl import ThreadpoolController  # 5 ms, which few runs need

    return ThreadpoolController()


class _OneThread(contextlib.ContextDecorator):
    """Context, or decorator, in which the linear algebra of the whole process has one thread.

    Threads of a program may be inside at the same time: the last one that leaves restores what the first one found.
    """

    def __init__(self):
        self._lock, self._inside, self._limits = threading.Lock(), 0, None

    def __enter__(self):
        with self._lock:
            if self._inside == 0:
                self._limits = _libraries().limit(limits=1, user_api="blas")
            self._inside += 1

    def __exit__(self, *_):
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                self._limits.restore_original_limits()


one_thread = _OneThread()


@cache
def product():
    """NumPy's linear algebra and the kind of processor that it is set to, on which bits depend: `OPENBLAS_CORETYPE` can change it
    under the same versions of everything."""
    from threadpoolctl import ThreadpoolController

    libraries = [lib for lib in ThreadpoolController().info() if lib["user_api"] == "blas"]
    own = next((lib for lib in libraries if "numpy" in lib["filepath"]), libraries[0] if libraries else {})
    return " ".join(filter(None, (own.get("internal_api", "its own linear algebra"), own.get("architecture"))))


def threads_for(coordinates):
    """Context for linear algebra with so many coordinates: one thread where more than one would be taken."""
    return one_thread if coordinates >= _THREADED else contextlib.nullcontext()
