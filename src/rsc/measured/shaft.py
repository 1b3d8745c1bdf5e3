"""Angle and speed of the shaft from the pulses of a Keyphasor, which may miss some or see one twice."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicHermiteSpline

LEAST_EVENTS = 5  # from which a speed is told
_SMOOTHED = 5, 11, 21  # events over which their times are smoothed, as many as one parabola goes through
_THROUGH = 2.0  # of what the times of events scatter about the shortest parabolas, up to which a longer one goes through them
_MEDIAN = math.sqrt(math.log(2.0))  # of the scatter about a parabola through five events, over its deviation
_LONG, _SHORT = 1.5, 0.6  # of the usual time between events, from which some are missing, below which one is too many


class Shaft(NamedTuple):
    """turns (n,) of the mark past the Keyphasor; speed (n,) Hz; numbers of events, of those filled in and of those left out;
    jitter in s, deviation of the times of events from an even rise of the speed, None without events."""

    turns: NDArray[np.float64]
    speed: NDArray[np.float64]
    events: int
    missing: int
    extra: int
    jitter: float | None


def shaft_of(time: NDArray[np.float64], pulses: NDArray[np.float64], events_per_turn: int) -> Shaft | None:
    """The Shaft at the samples of a signal of pulses; None where there are fewer than `LEAST_EVENTS`.

    An event is where a pulse begins: the signal passes the middle between its extremes towards the side on which it is seldom,
    interpolated between samples; to count again it must have gone back by a quarter of the way. Turns and speed at each event are
    those of a parabola in time through it and its neighbours, 21 events at most: a shaft whose speed rises evenly from corner to
    corner is met exactly.
    """
    raw = _events(time, pulses)
    times, missing, extra = _mended(raw)
    if len(times) < LEAST_EVENTS:
        return None
    (turns, speeds, rises), jitter = _parabolas(times, np.arange(len(times)) / events_per_turn)
    at, speed = CubicHermiteSpline(times, turns, speeds)(time), np.interp(time, times, speeds)
    for end, beyond in ((0, time < times[0]), (-1, time > times[-1])):  # as evenly accelerated as beside it
        later = time[beyond] - times[end]
        speed[beyond] = speeds[end] + rises[end] * later
        at[beyond] = turns[end] + (speeds[end] + 0.5 * rises[end] * later) * later
    return Shaft(at, speed, len(raw), missing, extra, jitter)


def _parabolas(times: NDArray[np.float64], turns: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """(3, n) turns, speed in Hz and its rise in Hz/s at each event, by least squares through events beside it; their jitter in s.

    Each takes the longest parabola that goes through its events: of 21 events where the speed rises evenly, of fewer, to one side
    of the event where need be, beside a corner of the speed.
    """
    usual, best = 0.0, np.zeros((3, len(times)))
    for count in _SMOOTHED:
        if count > len(times):
            break
        parabolas, scatter = _through(times, turns, count)
        about = np.clip(np.arange(len(times)) - count // 2, 0, len(scatter) - 1)  # the parabola with the event in its middle
        if count == _SMOOTHED[0]:
            usual = float(np.median(scatter[about]))
        chosen = np.where(scatter[about] <= _THROUGH * usual, about, _least_beside(scatter, count))
        values = _at(parabolas[:, chosen], times - times[chosen])
        best = values if count == _SMOOTHED[0] else np.where(scatter[chosen] <= _THROUGH * usual, values, best)
    return best, usual / _MEDIAN


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


def shaft_from_speed(time: NDArray[np.float64], speed: NDArray[np.float64]) -> Shaft:
    """The Shaft where its speed was measured: turns are counted from the first sample, where its angle is not known."""
    steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(time)
    return Shaft(np.concatenate([[0.0], np.cumsum(steps)]), speed, 0, 0, 0, None)


def _events(time: NDArray[np.float64], pulses: NDArray[np.float64]) -> NDArray[np.float64]:
    known = np.isfinite(pulses)
    time, pulses = time[known], pulses[known]
    if not pulses.size:
        return np.zeros(0)
    low, high = float(pulses.min()), float(pulses.max())
    middle = 0.5 * (low + high)
    if np.median(pulses) > middle:
        pulses, low, high, middle = -pulses, -high, -low, -middle
    above, armed = pulses > middle, pulses < middle - 0.25 * (high - low)
    rises = np.flatnonzero(above[1:] & ~above[:-1]) + 1
    # the last arming before each rise must lie behind the rise before it
    last = np.maximum.accumulate(np.where(armed, np.arange(len(armed)), -1))
    before = np.concatenate([[-1], rises[:-1]])
    rises = rises[last[rises] > before] if rises.size else rises
    share = (middle - pulses[rises - 1]) / (pulses[rises] - pulses[rises - 1])
    return np.asarray(time[rises - 1] + share * (time[rises] - time[rises - 1]))


def _mended(times: ArrayLike) -> tuple[NDArray[np.float64], int, int]:
    """Events with those that are missing filled in evenly and those too many left out, and both numbers.

    The usual time between events at each place is the median of those of some neighbours, so that a run-up is no trouble.
    """
    times = np.asarray(times, dtype=float)
    if len(times) < LEAST_EVENTS:
        return times, 0, 0
    kept = [times[0]]
    usual = _usual(np.diff(times))
    for k in range(1, len(times)):
        if times[k] - kept[-1] >= _SHORT * usual[k - 1]:
            kept.append(times[k])
    extra, times = len(times) - len(kept), np.array(kept)
    steps = np.diff(times)
    count = np.where(steps > _LONG * _usual(steps), np.round(steps / _usual(steps)), 1.0)
    places = np.concatenate([[0.0], np.cumsum(count)])
    return np.interp(np.arange(places[-1] + 1.0), places, times), int(places[-1] + 1 - len(times)), extra


def _usual(steps: NDArray[np.float64], beside: int = 4) -> NDArray[np.float64]:
    """Medians of each step and of so many on both sides."""
    padded = np.pad(steps, beside, mode="edge") if steps.size else steps
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, 2 * beside + 1), axis=1))
