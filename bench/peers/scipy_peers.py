"""scipy.integrate.solve_ivp with the Numba-compiled right-hand side of the yardstick."""

import time

import numpy as np
from scipy.integrate import solve_ivp

from peers.common import Deadline, Outcome, absolute_tolerances, motion_of, slim_right_hand_side

METHODS = ("RK45", "DOP853", "Radau", "LSODA")


class Scipy:
    """One method of solve_ivp; a point over the limit is ended from inside the right-hand side."""

    def __init__(self, problem, method):
        self.problem, self.method = problem, method
        self.f, self.parameters = slim_right_hand_side(problem)

    def __call__(self, tol, limit=1e9):
        problem, f, p = self.problem, self.f, self.parameters
        calls, begun = 0, time.process_time()

        def slope(t, y):
            nonlocal calls
            calls += 1
            if calls % 256 == 0 and time.process_time() - begun > limit:
                raise Deadline
            out = np.empty_like(y)
            f(t, y, p, out)
            return out

        atol, times = absolute_tolerances(problem, tol), problem.times
        try:
            found = solve_ivp(slope, (0.0, times[-1]), problem.start, self.method, t_eval=times, rtol=tol, atol=atol)
        except Deadline:
            return Outcome(time.process_time() - begun, None, calls, "T")
        except ValueError:  # NaN inside an implicit method
            return Outcome(time.process_time() - begun, None, calls, "N")
        spent = time.process_time() - begun
        if not found.success:
            return Outcome(spent, None, calls, "C")
        return Outcome(spent, motion_of(np.ascontiguousarray(found.y.T), problem), calls)
