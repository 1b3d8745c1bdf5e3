"""When the pulses of a shaft begin: its events."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_BACK = 0.25  # of the way between the extremes, by which a signal must go back behind the middle before it counts again
_STEEP = 0.1  # of a sample interval about its middle, in which edges lie that pass from one level to the other in one step
_MOSTLY = 0.8  # share of such edges, from which none is known more closely than its sample


class Edges(NamedTuple):
    """times (k,) s at which pulses begin; resolution in s, deviation of edges, 0 where they are interpolated."""

    times: NDArray[np.float64]
    resolution: float


def edges_of(time: NDArray[np.float64], pulses: NDArray[np.float64]) -> Edges:
    """The edges of a signal (n,) at times (n,) in s, interpolated between samples.

    A pulse begins where the signal passes the middle between its extremes towards the side on which it stays for shorter; to
    count again it must have gone back by a quarter of the way, so that a trembling edge is one event.
    """
    known = np.isfinite(pulses)
    time, pulses = time[known], pulses[known]
    if not pulses.size:
        return Edges(np.zeros(0), 0.0)
    up, down = _rises(time, pulses), _rises(time, -pulses)
    return up if _shorter(up.times, down.times, pulses) else down


def _shorter(up: NDArray[np.float64], down: NDArray[np.float64], pulses: NDArray[np.float64]) -> bool:
    """Whether the signal stays for shorter above its middle than below, between its passages upward and downward.

    Medians of single stays, not of samples: a shaft that stands with its mark below the probe stays there for long, once.
    """
    above, below = _stays(up, down), _stays(down, up)
    if not above.size or not below.size:
        return bool(np.median(pulses) <= 0.5 * (pulses.min() + pulses.max()))
    return bool(np.median(above) <= np.median(below))


def _stays(begin: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    place = np.searchsorted(end, begin)
    inside = place < len(end)
    return np.asarray(end[place[inside]] - begin[inside])


def _rises(time: NDArray[np.float64], signal: NDArray[np.float64]) -> Edges:
    """Edges at which a signal rises through the middle between its extremes."""
    low, high = float(signal.min()), float(signal.max())
    middle = 0.5 * (low + high)
    above, armed = signal > middle, signal < middle - _BACK * (high - low)
    rises = np.flatnonzero(above[1:] & ~above[:-1]) + 1
    # the last arming before each rise must lie behind the rise before it
    last = np.maximum.accumulate(np.where(armed, np.arange(len(armed)), -1))
    before = np.concatenate([[-1], rises[:-1]])
    rises = rises[last[rises] > before] if rises.size else rises
    share = (middle - signal[rises - 1]) / (signal[rises] - signal[rises - 1])
    steps = time[rises] - time[rises - 1]
    steep = rises.size and float(np.mean(np.abs(share - 0.5) < _STEEP)) >= _MOSTLY
    return Edges(time[rises - 1] + share * steps, float(np.median(steps)) / math.sqrt(12.0) if steep else 0.0)
