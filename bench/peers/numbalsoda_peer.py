"""numbalsoda's compiled solvers (Fortran DOP853, C++ LSODA) with the yardstick's right-hand side compiled to a C function.

They take one absolute tolerance for the whole state, so the state they see has its velocities divided by VELOCITY_SCALE.
"""

import time

import numba
import numpy as np

from peers.common import VELOCITY_SCALE, Absent, Outcome, motion_of, seconds_per_call, slim_right_hand_side

METHODS = ("DOP853", "LSODA")
CALLS_PER_STEP = {"DOP853": 12, "LSODA": 2}


def _right_hand_side(problem, signature):
    """(compiled C function, its data): the parameters, of which the first counts the calls, and room for a state."""
    f, parameters = slim_right_hand_side(problem)
    count, size = parameters.size, problem.start.size
    half = size // 2

    def slope(t, y, dy, data):
        scaled, out, p = numba.carray(y, size), numba.carray(dy, size), numba.carray(data, count + size)
        state = p[count:]
        for i in range(half):
            state[i], state[half + i] = scaled[i], scaled[half + i] * VELOCITY_SCALE
        f(t, state, p[:count], out)
        for i in range(half, size):
            out[i] /= VELOCITY_SCALE

    return numba.cfunc(signature, error_model="numpy")(slope), np.concatenate([parameters, np.zeros(size)])


class Numbalsoda:
    """One solver; the limit is a number of steps (LSODA: between two output times), from the time of one right-hand side."""

    def __init__(self, problem, method):
        try:
            import numbalsoda
        except (ImportError, OSError) as cause:  # OSError: the Fortran library is missing
            raise Absent(f"{cause}; PyPI has its source only, which needs a Fortran compiler") from cause
        self.solve = {"DOP853": numbalsoda.dop853, "LSODA": numbalsoda.lsoda}[method]
        self.problem = problem
        self.compiled, self.data = _right_hand_side(problem, numbalsoda.lsoda_sig)
        self.per_step = seconds_per_call(problem) * CALLS_PER_STEP[method]

    def __call__(self, tol, limit=1e9):
        problem, half = self.problem, self.problem.start.size // 2
        scale = np.repeat([1.0, VELOCITY_SCALE], half)
        atol, steps = tol * problem.matrices.gap, int(min(limit / self.per_step, 2e9))
        self.data[0] = 0.0
        begun = time.process_time()
        rows, success = self.solve(
            self.compiled.address, problem.start / scale, problem.times, self.data, rtol=tol, atol=atol, mxstep=steps
        )
        spent, calls = time.process_time() - begun, int(self.data[0])
        if success:
            return Outcome(spent, motion_of(rows * scale, problem), calls)
        # the solvers do not say why they stop
        finite = np.isfinite(self.data[-2 * half :]).all()
        return Outcome(spent, None, calls, "T" if spent > 0.8 * limit else "C" if finite else "N")
