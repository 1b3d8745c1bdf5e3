"""Threads of the linear algebra: for matrices as small as those of a scene they cost more than they give.

NumPy and SciPy come with an OpenBLAS each, and the threads of one wait for work on the processor that the other needs.
"""

import contextlib
from functools import cache


@cache
def _libraries():
    from threadpoolctl import ThreadpoolController  # 5 ms, which few runs need

    return ThreadpoolController()


@contextlib.contextmanager
def one_thread():
    """Context, or decorator, in which the linear algebra of the whole process has one thread."""
    with _libraries().limit(limits=1, user_api="blas"):
        yield
