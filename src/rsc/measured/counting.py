"""How many teeth pass between the pulses of a shaft: which of them are missing or doubled, and where nobody can say."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_BESIDE = 8  # steps on one side of another one, whose speeds foretell it
_PAIRS = np.triu_indices(_BESIDE, 1)
_LIKE_BESIDE = 1.25  # times the shorter step beside it, up to which a step is above suspicion
_ONE = 0.6, 1.5  # teeth foretold, between which a step is one
_NEAR = 0.25  # of a tooth, up to which a foretold number is whole
_MOST_FILLED = 3  # teeth of a step that are filled in by its neighbours alone
_MOST_KNOWN = 4.0  # teeth of a step of a wheel with a mark, up to which nothing is looked at but its duration
_ALIKE = 0.25  # of a usual step, by which two parts of one may be off together
_DISPLACED, _FAR = 0.1, 8.0  # of a tooth, and times as far as most, from which an event is not where its tooth is
_SHORT, _MOSTLY = 0.67, 0.6  # of the steps beside it, up to which one is short; share of steps that make a pattern


class Counted(NamedTuple):
    """places (k,) of events in teeth, rising; unsure (k - 1,) bool, steps between them through which nothing was counted;
    missing : int, teeth that were counted without a pulse."""

    places: NDArray[np.float64]
    unsure: NDArray[np.bool_]
    missing: int


def counted(times: NDArray[np.float64], places: NDArray[np.float64] | None = None) -> Counted:
    """Count the teeth between events (k,) in s.

    The speeds of eight steps on each side, on a straight line through the medians of their slopes and heights, foretell how many
    teeth pass in a step. One side is enough to call it one: beside a corner of the speed the other side foretells wrongly. Two
    or three are filled in where both sides foretell them; a step is unsure where they foretell more, different numbers, or a
    shaft that has come to rest.

    places : of a wheel with a mark, which are known; a step that takes longer than they say is unsure
    """
    known = np.arange(len(times), dtype=float) if places is None else places
    steps, teeth = np.diff(times), np.diff(known)
    even = steps / teeth
    padded = np.pad(even, 1, constant_values=np.inf)
    looked = np.flatnonzero((even > _LIKE_BESIDE * np.minimum(padded[:-2], padded[2:])) | (teeth > _MOST_KNOWN))
    unsure, more = np.zeros(len(steps), dtype=bool), np.zeros(len(steps))
    ahead, behind = _foretold(times, teeth, looked)
    for i, left, right in zip(looked.tolist(), (ahead * steps[looked]).tolist(), (behind * steps[looked]).tolist(), strict=True):
        told = [one / teeth[i] for one in (left, right) if one == one]
        if any(_ONE[0] <= one <= _ONE[1] for one in told) and teeth[i] <= _MOST_KNOWN:
            continue
        count = round(told[0]) if told else 0
        if places is None and 2 <= count <= _MOST_FILLED and all(abs(one - count) <= _NEAR for one in told):
            more[i] = count - 1.0
        else:
            unsure[i] = True
    return Counted(known + np.concatenate([[0.0], np.cumsum(more)]), unsure, int(more.sum()))


def _foretold(
    times: NDArray[np.float64], teeth: NDArray[np.float64], looked: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Speeds in teeth/s in the middle of some steps, foretold by the steps ahead of each and by those behind; NaN without any."""
    speed, middle = teeth / np.diff(times), 0.5 * (times[1:] + times[:-1])
    sides = []
    for offsets in (np.arange(-_BESIDE, 0), np.arange(1, _BESIDE + 1)):
        at = looked[:, None] + offsets
        inside = (at >= 0) & (at < len(speed))
        at = np.clip(at, 0, len(speed) - 1)
        u, m = np.where(inside, speed[at], np.nan), middle[at] - middle[looked][:, None]
        sides.append(_at_zero(m, u))
    return sides[0], sides[1]


def _at_zero(m: NDArray[np.float64], u: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) heights at 0 of the straight lines through points m, u (n, 8): medians of slopes and of heights, NaN left out."""
    first, second = _PAIRS
    with np.errstate(invalid="ignore", divide="ignore"):
        slopes = (u[:, second] - u[:, first]) / (m[:, second] - m[:, first])
        slope = _median(slopes)
        return _median(u - np.nan_to_num(slope)[:, None] * m)


def _median(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) medians of rows without their NaN; NaN of rows of NaN."""
    ordered, count = np.sort(values, axis=1), np.isfinite(values).sum(axis=1)
    rows, low, high = np.arange(len(values)), np.maximum(count - 1, 0) // 2, count // 2
    high = np.minimum(high, np.maximum(count - 1, 0))
    return np.where(count > 0, 0.5 * (ordered[rows, low] + ordered[rows, high]), np.nan)


def without_doubled(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Events (k,) without those that part a usual step in two; of a pulse that was seen twice the first stays."""
    times = np.delete(times, _second_of_two(np.diff(times)))
    while len(times) > 2:
        steps = np.diff(times)
        usual = _usual(steps)
        off = np.abs((steps[1:] + steps[:-1]) / np.maximum(usual[1:], usual[:-1]) - 1.0)
        beside = np.pad(off, 1, constant_values=np.inf)
        # of two side by side the likelier one, then anew
        doubled = np.flatnonzero((off < _ALIKE) & (off <= beside[:-2]) & (off < beside[2:])) + 1
        if not doubled.size:
            break
        times = np.delete(times, doubled)
    return times


def displaced(times: NDArray[np.float64]) -> NDArray[np.intp]:
    """Numbers of events (k,) of pulses that were seen in part: far from the cubic through two events on each side, between alike
    steps."""
    if len(times) < 2 * _BESIDE:
        return np.zeros(0, dtype=int)
    expected = (4.0 * (times[1:-3] + times[3:-1]) - times[:-4] - times[4:]) / 6.0
    tooth = 0.5 * (times[3:-1] - times[1:-3])
    off = np.abs(times[2:-2] - expected) / tooth
    before, behind = (times[1:-3] - times[:-4]) / tooth, (times[4:] - times[3:-1]) / tooth
    alike = (np.maximum(before, behind) < _LIKE_BESIDE) & (np.minimum(before, behind) > 1.0 / _LIKE_BESIDE)
    return np.flatnonzero(alike & (off > np.maximum(_DISPLACED, _FAR * np.median(off)))) + 2


def _second_of_two(steps: NDArray[np.float64]) -> NDArray[np.intp]:
    """Events after short steps of a shaft whose pulses are all seen twice (alternating short and long steps)."""
    if len(steps) < 6:
        return np.zeros(0, dtype=int)
    short = steps[:-1] < _SHORT * steps[1:]
    long = _SHORT * steps[:-1] > steps[1:]
    if (short[:-1] & long[1:] | long[:-1] & short[1:]).mean() < _MOSTLY:
        return np.zeros(0, dtype=int)
    # a step is short where that behind it is long, and the other way round: the first one and the last by one neighbour
    short, long = np.append(short, True) & np.append(True, long), np.append(long, True) & np.append(True, short)
    return np.flatnonzero(np.append(long[0], short))


def _usual(steps: NDArray[np.float64], beside: int = 4) -> NDArray[np.float64]:
    """Running medians of steps; at the ends over fewer steps."""
    width = min(2 * beside + 1, len(steps))
    medians = np.median(np.lib.stride_tricks.sliding_window_view(steps, width), axis=1)
    return np.asarray(medians[np.clip(np.arange(len(steps)) - width // 2, 0, len(medians) - 1)])
