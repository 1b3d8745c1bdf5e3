"""What every method of the comparison returns, and the scales they share."""

import importlib
import time
from functools import cache
from typing import NamedTuple

import numba
import numpy as np

from driven import Driven, right_hand_side_driven
from naive_kernel import right_hand_side_of
from problems import Matrices, displacements

VELOCITY_SCALE = 300.0  # 1/s: absolute tolerance of velocities is tol * gap * this, of displacements tol * gap


class Outcome(NamedTuple):
    """One run of one method at one tolerance or step."""

    seconds: float  # processor time of the integration alone
    motion: object  # (samples, N + M) complex displacements, or None when there are none
    calls: int  # of the right-hand side
    cause: str = ""  # why it stopped early: N, B, T, C or R of the chart's legend
    setup: float = 0.0  # s, compilation that this very tolerance needed


class Absent(Exception):
    """A peer cannot run here; the message says why."""


def imported(module, name=None):
    """A module of a peer; Absent where it, by this name of the package, is not installed."""
    try:
        return importlib.import_module(module)
    except (ImportError, OSError) as cause:  # OSError: a library of it is missing
        raise Absent(f"{name or module} is not installed") from cause


class Deadline(Exception):
    """The time limit of a point is over."""


def absolute_tolerances(problem, tol):
    """Absolute tolerance of every entry of the yardstick's state."""
    half = problem.start.size // 2
    return tol * problem.matrices.gap * np.repeat([1.0, VELOCITY_SCALE], half)


def slim_right_hand_side(problem):
    """(f, p): f(t, y, p, dy) with all matrices as views into the one array p, cheap to call from Python and from C.

    p[0] counts the calls. Methods and problems of one shape share the compiled f.
    """
    if isinstance(problem, Driven):
        return _slim_driven(problem), np.zeros(1)
    m = problem.matrices
    fields = ("stiffness_r", "damping_r", "gyroscopic_r", "stiffness_s", "damping_s", "unbalance", "euler")
    numbers = (m.per_mass_r, m.per_mass_s, m.gap, m.friction, m.k_c, m.b_c, m.omega, m.omega_dot)
    parameters = np.concatenate([[0.0], numbers, *(getattr(m, name).ravel() for name in fields)])
    return _slim(right_hand_side_of(m), m.stiffness_r.shape[0], m.stiffness_s.shape[0], m.i_r, m.i_s), parameters


@cache
def _slim(inner, n, k, i_r, i_s):
    a0, a1, a2, a3, a4, a5, a6, a7 = (int(item) for item in np.cumsum([9, n * n, n * n, n * n, k * k, k * k, n, n]))

    @numba.njit(error_model="numpy")
    def f(t, y, p, dy):
        p[0] += 1.0
        m = Matrices(
            p[a0:a1].reshape(n, n), p[a1:a2].reshape(n, n), p[a3:a4].reshape(k, k), p[a4:a5].reshape(k, k), p[a5:a6],
            i_r, i_s, p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[a2:a3].reshape(n, n), p[a6:a7],
        )  # fmt: skip
        inner(m, t, y, dy)

    return f


def _slim_driven(problem):
    """The same of a `Driven`, with its matrices as constants."""
    m = problem.matrices

    @numba.njit(error_model="numpy")
    def f(t, y, p, dy):
        p[0] += 1.0
        right_hand_side_driven(m, t, y, dy)

    return f


def refuse_driven(problem):
    """Absent for what knows one contact and a prescribed speed."""
    if isinstance(problem, Driven):
        raise Absent("written for one contact and a prescribed speed")


@cache
def _many_calls(f):
    @numba.njit(error_model="numpy")
    def many(y, p, dy, times):
        for i in range(times):
            f(1e-3 * i, y, p, dy)

    return many


def seconds_per_call(problem):
    """Time of one right-hand side inside compiled code, least of three rounds."""
    f, p = slim_right_hand_side(problem)
    many, out, rounds = _many_calls(f), np.zeros_like(problem.start), []
    many(problem.start, p, out, 1)
    for _ in range(3):
        begun = time.perf_counter()
        many(problem.start, p, out, 3000)
        rounds.append((time.perf_counter() - begun) / 3000)
    return min(rounds)


def motion_of(rows, problem):
    """Displacements of rows of the yardstick's state, or None when the run did not reach the end."""
    with np.errstate(invalid="ignore"):  # of a run that blew up
        return displacements(rows, problem) if rows.shape[0] == problem.times.size else None
