"""Events along a line of whirls: where force, amplitude, sliding, clearances or stability change, located.

A line (lines.py) is cut into the pieces on which all contacts of its set are pressed. Margins, positive where a condition holds,
are followed along each, and their zeros are the events.
"""

import contextlib
import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import tau as TWO_PI
from typing import Protocol

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.follow.curve import Points, WhirlCurve
from rsc.analysis.follow.lines import FOLD, FORCE, RANGE_END, UNBOUNDED, UNRESOLVED, Join, WhirlLine
from rsc.analysis.follow.walk import between, walk
from rsc.analysis.paper.predict import Whirl
from rsc.analysis.paper.stability import Growth

# causes of ends and events; those of ends also come from `rsc.analysis.follow.lines`
AMPLITUDE = "|r_R| above the gap"
SLIDING = "sliding forward (12)"
TOUCHES = "within the clearances"
CREEPING = "stable (creeping)"
OSCILLATORY = "stable (oscillatory)"
CAUSES = (FOLD, RANGE_END, UNBOUNDED, UNRESOLVED, FORCE, AMPLITUDE, SLIDING, TOUCHES, CREEPING, OSCILLATORY)
_MARGINS: dict[str, Callable[[Whirl], float]] = {
    AMPLITUDE: lambda whirl: whirl.conditions["rotor_amplitude_exceeds_gap"],
    SLIDING: lambda whirl: whirl.conditions["sliding"],
    TOUCHES: lambda whirl: whirl.conditions.get("within_clearances", np.nan),
}
_REAL = 1e-9  # of a whirl's frequency, below which what grows does not oscillate
_CLOSE = 1e-3  # a point is put this share of a step beside an end where the force is unbounded
_LOCATED = 1e-12  # of the distance of two points, to which an event is located between them


class Told(Protocol):
    """The whirls at points of a curve (whirls.py)."""

    def whirls(self, points: Points) -> Sequence[Whirl]:
        """Those at points (n, k)."""

    def growth(self, point: Points) -> Growth:
        """The growth of small motions at one point."""


@dataclass(frozen=True)
class Event:
    """A place on a branch.

    cause : str, one of `CAUSES`: why the branch ends there, or which condition changes there
    value : float, of the parameter (Hz for the rotor speed)
    frequency : float Hz, of the whirl there
    holds : str, "above" or "below": on which side of `value` the condition holds; "" for an end of the line itself
    """

    cause: str
    value: float
    frequency: float
    holds: str = ""


def pieces_of(curve: WhirlCurve, line: WhirlLine) -> list[WhirlLine]:
    """The parts of a line where its set is pressed, each cut where that begins or ends, with a point put next to the cut."""
    points = line.points
    pressed = curve.held(points) > 0.0
    pieces = []
    for part in np.split(np.arange(len(points)), np.flatnonzero(np.diff(pressed)) + 1):
        if not pressed[part[0]]:
            continue
        piece, begin, end = points[part], line.begin, line.end
        if part[0] > 0:
            begin, near = _cut(curve, piece[0], points[part[0] - 1])
            piece = np.concatenate([near, piece])
        elif begin.cause == FOLD:
            piece = np.concatenate([_beside(curve, piece[:2]), piece[1:]])
        if part[-1] < len(points) - 1:
            end, near = _cut(curve, piece[-1], points[part[-1] + 1])
            piece = np.concatenate([piece, near])
        elif end.cause == FOLD:
            piece = np.concatenate([piece[:-1], _beside(curve, piece[:-3:-1])])
        pieces.append(WhirlLine(piece, begin, end))
    return pieces


def _cut(curve: WhirlCurve, inner: Points, outer: Points) -> tuple[Join, Points]:
    """Where a set ceases to be pressed between a point of a line and one where it is not, and points (n, k) up to that. The way
    there is walked: of two points far apart it is open whether forces pass zero or all bounds."""
    low, high = sorted((float(inner[-1]), float(outer[-1])))
    way = walk(curve, inner, (low, high), bool(outer[-1] > inner[-1]), np.inf).points
    lost = np.flatnonzero(curve.held(way) <= 0.0)
    pair = curve.unwrapped(way[lost[0] - 1 : lost[0] + 1] if len(lost) else np.array([inner, outer]))
    a, b = curve.held(pair)
    share, point = _located(curve, pair, lambda at: float(curve.held(at[None])[0]), (float(a), float(b)))
    near = between(curve, pair, share * (1.0 - _CLOSE), curve.high - curve.low)
    join = Join(float(point[-1]), float(point[0]), FORCE)
    if near is None or not curve.held(near[None])[0] > 0.0 or near[-1] in (point[-1], inner[-1]):
        return join, inner[None, :][:0]
    parts = way[1 : lost[0]] if len(lost) else way[:0]
    added = np.concatenate([parts, near[None]])
    return join, added if outer[-1] > inner[-1] else added[::-1]


def _beside(curve: WhirlCurve, pair: Points) -> Points:
    """A point (1, k) beside a fold, towards the next point: in the fold itself the growth rate is zero but for rounding."""
    near = between(curve, pair, _CLOSE, curve.high - curve.low) if len(pair) == 2 else None
    return pair[:1] if near is None else near[None]


def _located(
    curve: WhirlCurve, pair: Points, margin: Callable[[Points], float], ends: tuple[float, float]
) -> tuple[float, Points]:
    """Where a margin passes zero between two points of a line, given it at both: share of their chord and point."""

    def at(share: float) -> Points:
        point = between(curve, pair, share, curve.high - curve.low)
        return pair[0] + share * (pair[1] - pair[0]) if point is None else point  # beside a pole

    known = dict(zip((0.0, 1.0), ends, strict=True))
    share = scipy.optimize.brentq(lambda x: known[x] if x in known else margin(at(x)), 0.0, 1.0, xtol=_LOCATED, rtol=_LOCATED)
    return float(share), at(share)


def events_of(curve: WhirlCurve, points: Points, whirls: Sequence[Whirl], told: Told) -> tuple[Event, ...]:
    """Events along a piece of a line, by rising value, given its points (n, k), the whirls there, and what tells others."""
    margins = {cause: np.array([margin(whirl) for whirl in whirls]) for cause, margin in _MARGINS.items()}
    margins[OSCILLATORY] = np.array([-whirl.growth_rate for whirl in whirls])
    events = []
    for cause, values in margins.items():
        if not np.isfinite(values).all():  # nothing that could slip or touch
            continue

        def margin(point: Points, cause: str = cause) -> float:
            return -told.growth(point).rate if cause == OSCILLATORY else _MARGINS[cause](told.whirls(point[None])[0])

        for pair, low, high in _changes(curve, points, values, margin):
            point = _located(curve, pair, margin, (low, high))[1]
            name, holds = cause, "above" if high > low else "below"
            if cause == OSCILLATORY and told.growth(point).frequency <= _REAL * abs(point[0]):
                name = CREEPING
            events.append(Event(name, float(point[-1]), float(point[0]) / TWO_PI, holds))
    return tuple(sorted(events, key=lambda event: event.value))


def _changes(
    curve: WhirlCurve, points: Points, margins: NDArray[np.float64], margin: Callable[[Points], float]
) -> Iterator[tuple[Points, float, float]]:
    """(pair of points, margin at both) between which a margin passes zero, also where it dips through zero between points of one
    sign."""
    known = list(zip(points, margins.tolist(), strict=True))
    for k in _dips(margins):
        sign = np.sign(margins[k])
        for pair in (points[k - 1 : k + 1], points[k : k + 2]):
            beyond = _beyond(curve, pair, sign, margin)
            if beyond is not None:
                known.append(beyond)
                break
    known.sort(key=lambda item: item[0][-1])
    for (one, low), (other, high) in itertools.pairwise(known):
        if low * high < 0.0:
            yield np.array([one, other]), low, high


def _dips(margins: NDArray[np.float64]) -> list[int]:
    """The points where a margin comes so near zero that it may pass it on a side."""
    dips = []
    for k in range(1, len(margins) - 1):
        left, mid, right = margins[k - 1 : k + 2] * np.sign(margins[k])
        if min(left, right) >= mid >= 0.0 and max(left - mid, right - mid) > mid:
            dips.append(k)
    return dips


def _beyond(curve: WhirlCurve, pair: Points, sign: float, margin: Callable[[Points], float]) -> tuple[Points, float] | None:
    """A point between two, and the margin there, where it does not have the sign that it has at both; None where it keeps it."""

    opposite = []

    def at(share: float) -> float:
        point = between(curve, pair, share, curve.high - curve.low)
        if point is None:
            return np.inf
        value = margin(point)
        if sign * value < 0.0:
            opposite.append((point, value))
            raise StopIteration
        return sign * value

    with contextlib.suppress(StopIteration):
        scipy.optimize.minimize_scalar(at, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-4})
    return opposite[0] if opposite else None
