"""Modes followed over the rotor speed by their shapes: which mode at one speed is which at the next.

Two modes are alike by the modal assurance criterion (MAC) of their ellipses, |<u, v>|^2 / (<u, u> <v, v>) with the mass matrix,
and by their eigenvalues. Between speeds whose modes cannot be told apart so, further speeds are put.
"""

import itertools
from collections.abc import Callable, Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.alone.free_vibration import FreeVibration

_ALIKE, _NEAR = 0.9, 0.1  # least MAC, and largest relative difference of eigenvalues, of modes that are surely the same
_OTHER = 0.5  # MAC below which they are not the same, however near the speeds
_SURE = 16  # number of slowest modes that must be identified so
_HALVINGS = 7
_STILL = 1e-6  # of |lambda|: a smaller imaginary part is rounding

Line = tuple[int | None, ...]


def followed(speeds: Sequence[float], at: Callable[[float], list[FreeVibration]], mass: NDArray[np.float64]) -> tuple[Line, ...]:
    """The lines of a Campbell diagram.

    speeds : Hz, in the order in which modes are followed; at : vibrations at a speed, the slowest first; mass : (N, N)

    Returns a tuple of lines, each with a number in `at(speed)` for every speed, None where the line has no oscillating mode: it
    is overdamped there. In the order of the first speed, and then of those at which they begin.
    """
    if not speeds:
        return ()
    at_speeds = {speed: _Oscillating(at(speed), mass) for speed in speeds}
    lines: list[list[int | None]] = [[i] for i in range(len(at_speeds[speeds[0]].places))]
    for number, (first, last) in enumerate(itertools.pairwise(speeds), start=1):
        ends = (first, at_speeds[first]), (last, at_speeds[last])
        following = _pairs(*ends, lambda speed: _Oscillating(at(speed), mass), _HALVINGS)
        for line in lines:
            line.append(None if line[-1] is None else following.get(line[-1]))
        taken = {line[-1] for line in lines}
        lines += [[*[None] * number, i] for i in range(len(at_speeds[last].places)) if i not in taken]
    places = [at_speeds[speed].places for speed in speeds]
    return tuple(tuple(None if i is None else own[i] for own, i in zip(places, line, strict=True)) for line in lines)


class _Oscillating:
    """Those of some vibrations that oscillate: places in their list, eigenvalues (n,), ellipses (n, 2 N) of energy 1."""

    def __init__(self, vibrations: list[FreeVibration], mass: NDArray[np.float64]) -> None:
        rate = [complex(each.growth_rate, 2.0 * np.pi * abs(each.frequency)) for each in vibrations]
        self.places = [i for i, value in enumerate(rate) if value.imag > _STILL * abs(value)]
        self.rate = np.array([rate[i] for i in self.places])
        own = [_ellipse(vibrations[i]) for i in self.places]
        root = np.linalg.cholesky(mass)
        weighted = np.array([np.concatenate([part @ root for part in pair]) for pair in own]).reshape(len(own), 2 * len(mass))
        self.ellipses = weighted / np.linalg.norm(weighted, axis=1, keepdims=True)


def _ellipse(vibration: FreeVibration) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Circles r = P e^{i phi} + conj(N) e^{-i phi} of a vibration, phi = 2 pi |frequency| t: those of one that turns the other
    way change their places, so that a mode whose sense changes stays alike."""
    circles = vibration.shape, vibration.mirror_shape
    positive, negative = circles if vibration.frequency >= 0.0 else circles[::-1]
    return positive, negative.conj()


def _pairs(
    first: tuple[float, _Oscillating], last: tuple[float, _Oscillating], at: Callable[[float], _Oscillating], halvings: int
) -> dict[int, int]:
    """Modes at the last speed by those at the first."""
    one, other = first[1], last[1]
    alike = np.abs(one.ellipses @ other.ellipses.conj().T) ** 2
    sizes = np.abs(one.rate)[:, None], np.abs(other.rate)
    apart = np.abs(one.rate[:, None] - other.rate) / np.maximum(*sizes)
    pairs = list(zip(*scipy.optimize.linear_sum_assignment(1.0 - alike + apart), strict=True)) if alike.size else []
    sure = [(i, j) for i, j in pairs if alike[i, j] >= _ALIKE and apart[i, j] <= _NEAR]
    slowest = min(_SURE, max(alike.shape))
    if halvings == 0 or {i for i, _ in sure if i < slowest} >= set(range(slowest)):
        return {int(i): int(j) for i, j in pairs if alike[i, j] >= _OTHER}
    middle = 0.5 * (first[0] + last[0])
    half = middle, at(middle)
    before, after = _pairs(first, half, at, halvings - 1), _pairs(half, last, at, halvings - 1)
    return {i: after[j] for i, j in before.items() if j in after}
