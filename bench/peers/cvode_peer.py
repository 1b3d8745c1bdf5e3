"""CVODE (SUNDIALS) by scikit-sundae, with the Numba-compiled right-hand side of the yardstick: called through Python, as scipy's.

sksundae takes no address of a compiled function, so each call costs what a Python call costs.
"""

import time

import numpy as np

from peers.common import Outcome, absolute_tolerances, imported, motion_of, slim_right_hand_side

METHODS = ("Adams", "BDF")
PIECE = 200  # output times


class Cvode:
    """One method of sksundae's CVODE, in one continuous integration; the limit is looked at from output time to output time."""

    def __init__(self, problem, method):
        solver = imported("sksundae.cvode", "scikit-sundae").CVODE
        self.solver, self.problem, self.method = solver, problem, method
        self.f, self.parameters = slim_right_hand_side(problem)

    def __call__(self, tol, limit=1e9):
        problem, f, p = self.problem, self.f, self.parameters

        def slope(t, y, dy):
            f(t, y, p, dy)

        p[0] = 0.0
        atol, rows = absolute_tolerances(problem, tol), np.empty((problem.times.size, problem.start.size))
        begun = time.process_time()
        solver = self.solver(slope, method=self.method, rtol=tol, atol=atol, max_num_steps=100_000)
        rows[0] = solver.init_step(0.0, problem.start).y
        cause = ""
        for i in range(1, problem.times.size):
            found = solver.step(problem.times[i])
            rows[i] = found.y
            if not found.success:
                cause = "C" if np.isfinite(found.y).all() else "N"
            elif i % PIECE == 0 and time.process_time() - begun > limit:
                cause = "T"
            if cause:
                return Outcome(time.process_time() - begun, None, int(p[0]), cause)
        return Outcome(time.process_time() - begun, motion_of(rows, problem), int(p[0]))
