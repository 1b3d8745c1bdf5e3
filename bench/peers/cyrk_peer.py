"""CyRK's compiled solvers (C++) with the yardstick's right-hand side compiled to a C function."""

import ctypes
import time

import numpy as np

from naive_kernel import right_hand_side_of
from peers.common import Absent, Outcome, absolute_tolerances, motion_of, seconds_per_call
from problems import Matrices

METHODS = ("RK45", "DOP853", "Vern7", "LSODA", "RADAU")
CALLS_PER_STEP = {"RK45": 6, "DOP853": 12, "Vern7": 10}


def _right_hand_side(problem):
    """(address of the compiled right-hand side, its arguments as numbers); the first argument counts the calls."""
    import CyRK
    import numba

    f, m = right_hand_side_of(problem.matrices), problem.matrices
    n, k, size = m.stiffness_r.shape[0], m.stiffness_s.shape[0], problem.start.size
    i_r, i_s = m.i_r, m.i_s
    fields = ("stiffness_r", "damping_r", "gyroscopic_r", "stiffness_s", "damping_s", "unbalance", "euler")
    numbers = (m.per_mass_r, m.per_mass_s, m.gap, m.friction, m.k_c, m.b_c, m.omega, m.omega_dot)
    arguments = np.concatenate([[0.0], numbers, *(getattr(m, name).ravel() for name in fields)])
    a = np.cumsum([9, n * n, n * n, n * n, k * k, k * k, n, n])
    total = arguments.size
    a0, a1, a2, a3, a4, a5, a6, a7 = (int(item) for item in a)

    def slope(dy, t, y, args):
        p = numba.carray(args, total)
        p[0] += 1.0
        m = Matrices(
            p[a0:a1].reshape(n, n), p[a1:a2].reshape(n, n), p[a3:a4].reshape(k, k), p[a4:a5].reshape(k, k), p[a5:a6],
            i_r, i_s, p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[a2:a3].reshape(n, n), p[a6:a7],
        )  # fmt: skip
        f(m, t, numba.carray(y, size), numba.carray(dy, size))

    return numba.cfunc(CyRK.cyjit_sig if hasattr(CyRK, "cyjit_sig") else _signature(), error_model="numpy")(slope), arguments


def _signature():
    from CyRK.nb.numba_solver import cyjit_sig

    return cyjit_sig


class CyRK:
    """One method of nbsolve2_ivp; the limit is a number of steps, from the time of one right-hand side."""

    def __init__(self, problem, method):
        try:
            import CyRK
        except ImportError as cause:
            raise Absent("CyRK is not installed") from cause
        self.solve, self.problem, self.method = CyRK.nbsolve2_ivp, problem, method
        self.compiled, self.arguments = _right_hand_side(problem)
        # an implicit method also differences a Jacobian and factors it, at most every step
        self.per_step = seconds_per_call(problem) / 3.0 * CALLS_PER_STEP.get(method, 6 + problem.start.size)

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
        success, status, rows = found.success, int(found.status), np.ascontiguousarray(found.y.T)
        steps = int(found.steps_taken)
        found.free()
        if not success:
            finite = rows.size == 0 or np.isfinite(rows[-1]).all()
            return Outcome(spent, None, int(calls), "T" if steps >= 0.99 * limit / self.per_step else "C" if finite else "N")
        assert status >= 0
        return Outcome(spent, motion_of(rows, problem), int(calls))
