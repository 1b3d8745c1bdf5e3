"""Turns, speed and rise of a shaft at its events, out of times that scatter: parabolas through neighbours."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LEAST_EVENTS = 5  # from which a speed is told
_SMOOTHED = 5, 11, 21  # events over which their times are smoothed, as many as one parabola goes through
_MOST_SMOOTHED = 61  # the same where a turn has more: those of a whole turn
_THROUGH = 2.0  # of what the times of events scatter about the shortest parabolas, up to which a longer one goes through them
_MEDIAN = math.sqrt(math.log(2.0))  # of the scatter about a parabola through five events, over its deviation


class Events(NamedTuple):
    """Events of a shaft on their places.

    times : (k,) s; turns : (k,); resolution : s, deviation of the times at least: rounded to samples they may seem even for a
    while; in_turn : int, pulses in a turn
    """

    times: NDArray[np.float64]
    turns: NDArray[np.float64]
    resolution: float
    in_turn: int

    def part(self, own: slice) -> "Events":
        """Some of them."""
        return self._replace(times=self.times[own], turns=self.turns[own])

    def moved(self, turns: float) -> "Events":
        """The same, so many turns later."""
        return self._replace(turns=self.turns + turns)

    def with_later(self, later: "Events") -> "Events":
        """These and later ones."""
        return self._replace(times=np.concatenate([self.times, later.times]), turns=np.concatenate([self.turns, later.turns]))


def smoothed(events: Events) -> tuple[NDArray[np.float64], float]:
    """(3, n) turns, speed in Hz and its rise in Hz/s at each event, by least squares through events beside it; their jitter in s.

    Each takes the longest parabola that goes through its events: where the speed rises evenly of 21 events, or of a whole turn
    that has 21 to 60; beside a corner of the speed of fewer, to one side of the event where need be. Three or four events have
    one straight line or parabola.
    """
    times, turns, resolution, in_turn = events
    if len(times) < _SMOOTHED[0]:
        return _through_all(times, turns), resolution
    usual, best = 0.0, np.zeros((3, len(times)))
    whole = (in_turn + 1,) if _SMOOTHED[-1] < in_turn + 1 <= _MOST_SMOOTHED else ()
    for count in (*_SMOOTHED, *whole):
        if count > len(times):
            break
        parabolas, scatter = _through(times, turns, count)
        about = np.clip(np.arange(len(times)) - count // 2, 0, len(scatter) - 1)  # the parabola with the event in its middle
        if count == _SMOOTHED[0]:
            usual = max(float(np.median(scatter[about])), _MEDIAN * resolution)
        chosen = np.where(scatter[about] <= _THROUGH * usual, about, _least_beside(scatter, count))
        values = _at(parabolas[:, chosen], times - times[chosen])
        best = values if count == _SMOOTHED[0] else np.where(scatter[chosen] <= _THROUGH * usual, values, best)
    return best, usual / _MEDIAN


def _through_all(times: NDArray[np.float64], turns: NDArray[np.float64]) -> NDArray[np.float64]:
    later = times - times[0]
    parabola = np.polynomial.Polynomial.fit(later, turns, len(times) - 2)
    return np.array([parabola(later), parabola.deriv()(later), parabola.deriv(2)(later)])


def _through(
    times: NDArray[np.float64], turns: NDArray[np.float64], count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(3, n - count + 1) turns, speed and half its rise at the first event of each `count` ones, of the parabola through them;
    how far in s they scatter about it."""
    t, k = (np.lib.stride_tricks.sliding_window_view(values, count) for values in (times, turns))
    length = t[:, -1:] - t[:, :1]
    powers = ((t - t[:, :1]) / length)[..., None] ** np.arange(3)
    normal, right = np.einsum("nki,nkj->nij", powers, powers), np.einsum("nki,nk->ni", powers, k - k[:, :1])
    shares = np.linalg.solve(normal, right[..., None])[..., 0]
    missed = np.einsum("nki,ni->nk", powers, shares) - (k - k[:, :1])
    parabolas = np.array([k[:, 0] + shares[:, 0], *(shares[:, 1:] / length ** [1, 2]).T])
    return parabolas, np.sqrt((missed**2).sum(axis=1) / (count - 3)) / np.abs(parabolas[1])


def _least_beside(scatter: NDArray[np.float64], count: int) -> NDArray[np.intp]:
    """(n,) of all parabolas through an event the one that its events scatter least about."""
    padded = np.pad(scatter, count - 1, constant_values=np.inf)
    first = np.lib.stride_tricks.sliding_window_view(padded, count).argmin(axis=1)
    return np.asarray(np.arange(len(first)) + first - (count - 1))


def _at(parabolas: NDArray[np.float64], later: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3, n) turns, speed and its rise so many s behind the first event of parabolas."""
    turns, speed, half = parabolas
    return np.array([turns + (speed + half * later) * later, speed + 2.0 * half * later, 2.0 * half])
