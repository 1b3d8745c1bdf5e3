"""What every method of the comparison returns, and the scales they share."""

import time
from typing import NamedTuple

import numpy as np

from naive_kernel import right_hand_side_of
from problems import displacements

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


class Deadline(Exception):
    """The time limit of a point is over."""


def absolute_tolerances(problem, tol):
    """Absolute tolerance of every entry of the yardstick's state."""
    half = problem.start.size // 2
    return tol * problem.matrices.gap * np.repeat([1.0, VELOCITY_SCALE], half)


def seconds_per_call(problem):
    """Time of one compiled right-hand side, least of three rounds of 1,000."""
    f, out = right_hand_side_of(problem.matrices), np.zeros_like(problem.start)
    f(problem.matrices, 0.0, problem.start, out)
    rounds = []
    for _ in range(3):
        begun = time.perf_counter()
        for _ in range(1000):
            f(problem.matrices, 0.0, problem.start, out)
        rounds.append((time.perf_counter() - begun) / 1000)
    return min(rounds)


def motion_of(rows, problem):
    """Displacements of rows of the yardstick's state, or None when the run did not reach the end."""
    return displacements(rows, problem) if rows.shape[0] == problem.times.size else None
