"""CyRK's compiled solvers (C++) with the yardstick's right-hand side compiled to a C function."""

import ctypes
import time
from functools import cache

import numba
import numpy as np

from peers.common import Outcome, absolute_tolerances, imported, motion_of, seconds_per_call, slim_right_hand_side

METHODS = ("RK45", "DOP853", "Vern7", "LSODA", "RADAU")
CALLS_PER_STEP = {"RK45": 6, "DOP853": 12, "Vern7": 10}


@cache
def _c_function(f, count, size):
    """The compiled right-hand side f(t, y, p, dy) with `count` parameters and `size` states as CyRK calls it."""
    from CyRK.nb.numba_solver import cyjit_sig

    def slope(dy, t, y, args):
        f(t, numba.carray(y, size), numba.carray(args, count), numba.carray(dy, size))

    return numba.cfunc(cyjit_sig, error_model="numpy")(slope)


class CyRK:
    """One method of nbsolve2_ivp; the limit is a number of steps, from the time of one right-hand side."""

    def __init__(self, problem, method):
        self.solve, self.problem, self.method = imported("CyRK").nbsolve2_ivp, problem, method
        f, self.arguments = slim_right_hand_side(problem)
        self.compiled = _c_function(f, self.arguments.size, problem.start.size)
        # an implicit method also differences a Jacobian and factors it, at most every step
        self.per_step = seconds_per_call(problem) * CALLS_PER_STEP.get(method, 6 + problem.start.size)

    def __call__(self, tol, limit=1e9):
        from CyRK.nb.numba_solver import c_get_args_ptr

        problem, half = self.problem, self.problem.start.size // 2
        begun = time.process_time()
        found = self.solve(
            self.compiled.address,
            (0.0, problem.times[-1]),
            problem.start,
            method=self.method,
            t_eval=problem.times,
            args=self.arguments,
            rtols=np.full(2 * half, tol),
            atols=absolute_tolerances(problem, tol),
            max_num_steps=int(min(limit / self.per_step, 1e12)),
            max_ram_MB=4000,
        )
        spent = time.process_time() - begun
        calls = ctypes.cast(c_get_args_ptr(found._ptr), ctypes.POINTER(ctypes.c_double))[0]
        success, rows = found.success, np.array(found.y.T)  # a copy: what `free` gives back is read no more
        steps = int(found.steps_taken)
        found.free()
        if not success:
            finite = rows.size == 0 or np.isfinite(rows[-1]).all()
            return Outcome(spent, None, int(calls), "T" if steps >= 0.99 * limit / self.per_step else "C" if finite else "N")
        return Outcome(spent, motion_of(rows, problem), int(calls))
