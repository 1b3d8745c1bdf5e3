"""Fixed steps as engineers use them: classical Runge-Kutta of order 4, and Newmark's average acceleration.

Newmark (beta 1/4, gamma 1/2): the constant matrix M + h/2 B + h^2/4 K is inverted once; contact and gyroscopic forces stand on
the right-hand side and come from the previous iterate, which starts at the last step's accelerations and is repeated until no
acceleration changes by more than 1e-10 of the largest, at most 20 times (as rotor codes do; no message when it is not reached).
The argument is the number of steps between two output times. No dense output: every output time is the end of a step.
"""

import time

import numba
import numpy as np

from naive_kernel import right_hand_side_of
from peers.common import Outcome, motion_of, refuse_driven, seconds_per_call
from problems import RATE


def _runge_kutta(f):
    @numba.njit(error_model="numpy")
    def run(m, start, rate, substeps, out):
        h = 1.0 / (rate * substeps)
        y, k, stage, total = start.copy(), np.empty_like(start), np.empty_like(start), np.empty_like(start)
        out[0] = y
        for row in range(1, out.shape[0]):
            for sub in range(substeps):
                t = ((row - 1) * substeps + sub) * h
                f(m, t, y, k)
                for i in range(y.size):
                    total[i] = y[i] + h / 6.0 * k[i]
                    stage[i] = y[i] + 0.5 * h * k[i]
                f(m, t + 0.5 * h, stage, k)
                for i in range(y.size):
                    total[i] += h / 3.0 * k[i]
                    stage[i] = y[i] + 0.5 * h * k[i]
                f(m, t + 0.5 * h, stage, k)
                for i in range(y.size):
                    total[i] += h / 3.0 * k[i]
                    stage[i] = y[i] + h * k[i]
                f(m, t + h, stage, k)
                for i in range(y.size):
                    y[i] = total[i] + h / 6.0 * k[i]
            out[row] = y
        return 4 * substeps * (out.shape[0] - 1)

    return run


def _newmark(f):  # noqa: C901 - one loop, as in a textbook
    @numba.njit(error_model="numpy")
    def run(m, linear, inverse, start, rate, substeps, out):
        h = 1.0 / (rate * substeps)
        half = start.size // 2
        y, stage, slope = start.copy(), np.empty_like(start), np.empty_like(start)
        a, a_new, rest = np.empty(half), np.empty(half), np.empty(half)
        f(m, 0.0, y, slope)
        a[:] = slope[half:]
        calls = 1
        out[0] = y
        for row in range(1, out.shape[0]):
            for sub in range(substeps):
                t = ((row - 1) * substeps + sub + 1) * h
                a_new[:] = a
                for _ in range(20):
                    for i in range(half):
                        stage[half + i] = y[half + i] + 0.5 * h * (a[i] + a_new[i])
                        stage[i] = y[i] + h * y[half + i] + 0.25 * h * h * (a[i] + a_new[i])
                    f(m, t, stage, slope)
                    calls += 1
                    # all forces at the iterate, minus what its own linear part contributes beyond a_new = 0
                    largest, change = 0.0, 0.0
                    for i in range(half):
                        rest[i] = slope[half + i]
                        for j in range(half):
                            rest[i] += linear[i, j] * a_new[j]
                    for i in range(half):
                        total = 0.0
                        for j in range(half):
                            total += inverse[i, j] * rest[j]
                        change = max(change, abs(total - a_new[i]))
                        largest = max(largest, abs(total))
                        stage[i] = total
                    for i in range(half):
                        a_new[i] = stage[i]
                    if not change > 1e-10 * largest:
                        break
                for i in range(half):
                    y[i] += h * y[half + i] + 0.25 * h * h * (a[i] + a_new[i])
                    y[half + i] += 0.5 * h * (a[i] + a_new[i])
                    a[i] = a_new[i]
            out[row] = y
        return calls

    return run


_RUNGE_KUTTA, _NEWMARK = {}, {}


def _kept(runs, make, f):
    if f not in runs:
        runs[f] = make(f)
    return runs[f]


class Fixed:
    """A method of fixed step; a point whose calls alone would take longer than the limit is not begun."""

    def __init__(self, problem, method):
        self.problem, self.newmark = problem, method == "Newmark"
        if self.newmark:
            refuse_driven(problem)
        self.f = right_hand_side_of(problem.matrices)
        self.per_call = seconds_per_call(problem)

    def __call__(self, substeps, limit=1e9):
        problem = self.problem
        steps = substeps * (problem.times.size - 1)
        least = (3 if self.newmark else 4) * steps
        if least * self.per_call > limit:
            return Outcome(float("nan"), None, least, "T")
        out = np.zeros((problem.times.size, problem.start.size))
        begun = time.process_time()
        if self.newmark:
            linear, inverse = self._linear(1.0 / (RATE * substeps))
            calls = _kept(_NEWMARK, _newmark, self.f)(problem.matrices, linear, inverse, problem.start, RATE, substeps, out)
        else:
            calls = _kept(_RUNGE_KUTTA, _runge_kutta, self.f)(problem.matrices, problem.start, RATE, substeps, out)
        return Outcome(time.process_time() - begun, motion_of(out, problem), calls)

    def _linear(self, h):
        """(M^-1 (h/2 B + h^2/4 K), inverse of 1 + that), in the order y, z of the rotor, y, z of the stator."""
        m = self.problem.matrices
        n, k = m.stiffness_r.shape[0], m.stiffness_s.shape[0]
        linear = np.zeros((2 * (n + k),) * 2)
        for first, size, damping, stiffness in ((0, n, m.damping_r, m.stiffness_r), (2 * n, k, m.damping_s, m.stiffness_s)):
            for plane in range(2):
                rows = slice(first + plane * size, first + (plane + 1) * size)
                linear[rows, rows] = 0.5 * h * damping + 0.25 * h * h * stiffness
        return linear, np.linalg.inv(np.eye(linear.shape[0]) + linear)
