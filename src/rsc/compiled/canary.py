"""A canary: small functions of every kind in the kernel, to test whether the fast path works with the installed Numba.

They are compiled in a process of their own: where LLVM finds something wrong it may end the process.
"""

import subprocess
import sys
import tempfile
from collections import namedtuple

import numba
import numpy as np

from rsc.compiled.code_cache import in_folder

_Weights = namedtuple("_Weights", "first second")


def _canary(merged, apart, entry):
    """An entry function with an inlined and a separate helper, compiled by the three decorators given."""

    @merged
    def turned(pair, flag):
        return (-pair[1], pair[0]) if flag else pair

    @apart
    def weighted(weights, *pairs):
        total = 0.0
        for pair in pairs:
            y, z = turned(pair, pair[0] > 0.5)
            total += weights.first * y + weights.second * z / 3.0
        return total, len(pairs)

    @entry
    def walk(values, weights):
        total = 0.0
        for i in range(1, len(values)):
            part, count = weighted(weights, (values[i - 1], values[i]), (total, 0.1))
            total += part * count
            values[i] = total
        return total, values[0] / (total + 2.0)

    return walk


_CHILD = """
import sys
sys.path[:] = {path!r}
from rsc.compiled import canary, fast
sys.exit(canary.mismatch(fast))
"""
_LONGEST = 300  # s; a second or two on an idle machine


def try_out():
    """Compile and run the canary in a new process; ValueError if it dies, hangs or computes other numbers than Python."""
    command = [sys.executable, "-c", _CHILD.format(path=sys.path)]
    try:
        child = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=_LONGEST, check=False)
    except subprocess.TimeoutExpired as error:
        raise ValueError(f"the process that tries it out has not ended after {_LONGEST} s") from error
    if child.returncode:
        lines = child.stderr.decode(errors="replace").strip().splitlines()
        raise ValueError(lines[-1] if lines else f"the process that tries it out ended with code {child.returncode}")


def mismatch(fast):
    """Error text if the canary, compiled on the fast path or read back from disk, differs from plain Python; else None."""
    with tempfile.TemporaryDirectory() as folder:

        def entry(function):
            return fast.quickly_read(in_folder(function, folder, fast.ENTRY))

        made = _canary(numba.njit(**fast.HELPER, forceinline=True), numba.njit(**fast.HELPER), entry)
        read = entry(made.py_func)
        known, compiled, again = (_numbers(function) for function in (_canary(_same, _same, _same), made, read))
        if not sum(read.stats.cache_hits.values()):
            return "compiled code is not found on disk again"
    return None if known == compiled == again else "a compiled function computes other numbers than Python"


def _same(function):
    return function


def _numbers(walk):
    values = np.sin(np.arange(9.0))
    return [*walk(values, _Weights(0.7, 1.1)), *values]
