"""Pseudo-arclength continuation of (W): from one point along its curve, round folds, to the end of a stretch of the parameter.

A step goes along the tangent and is corrected across it. It holds where the correction is short, the tangents of both ends agree
and the chord runs along their mean. Since the tangent of a curve keeps its orientation (`WhirlCurve.tangents`), a step that went
over to a neighbouring curve ends on a tangent that points back, and is halved.
"""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.follow.curve import Points, WhirlCurve

_FIRST, _LONGEST, _SHORTEST = 0.25, 1.0, 1e-9  # lengths of steps
_CORRECTION = 0.25  # of its length, which a correction has at most
_OFF = 0.03  # of its length, by which a chord differs from the mean of its tangents at most
_AGREE, _GROW = 0.85, 0.98  # cosine between the tangents of a step that holds, and of one after which steps grow
MOST_STEPS = 2000
_LOCATED = 1e-9  # of the distance of two points, to which a fold is located between them


@dataclass(frozen=True, eq=False)
class Walk:
    """A way along a curve.

    points : (n, k), from the start on
    folds : (n,) bool, the points where the parameter turns back
    landed : float, the end of the stretch that was reached; not a number where the curve was lost before
    """

    points: Points
    folds: NDArray[np.bool_]
    landed: float

    def strands(self) -> list[Points]:
        """The parts from fold to fold, in the order of the way."""
        cuts = np.flatnonzero(self.folds)
        starts, ends = [0, *cuts], [*cuts + 1, len(self.points)]
        return [self.points[i:k] for i, k in zip(starts, ends, strict=True)]


class _Step:
    """A point and its tangent on the way."""

    def __init__(self, curve: WhirlCurve, point: Points, width: float, towards: float) -> None:
        self.point = point
        self.scale = curve.scale(point[None], width)
        self.tangent = curve.tangents(curve.evaluated(point[None], towards)[1], self.scale)[0]

    def leads_to(self, other: "_Step") -> float:
        """Cosine of the angle between the tangents of both; 0 where the chord does not run along their mean, as on a smooth curve
        it does but for the third order of its length."""
        turned = other.tangent * other.scale[0] / self.scale[0]
        turned /= np.linalg.norm(turned)
        chord, mean = (other.point - self.point) / self.scale[0], self.tangent + turned
        length = np.linalg.norm(chord)
        off = np.linalg.norm(chord * np.sign(chord @ mean) - length * mean / np.linalg.norm(mean))
        return float(self.tangent @ turned) if off <= _OFF * length else 0.0


def walk(curve: WhirlCurve, start: Points, stretch: tuple[float, float], rising: bool, bound: float) -> Walk:
    """Follow a curve from a point until the parameter leaves a stretch.

    Parameters
    ----------
    curve : WhirlCurve
    start : (k,) point of it
    stretch : lowest and highest value of the parameter
    rising : bool, whether the parameter rises at first
    bound : float, rad/s, beyond which a frequency is not followed

    Returns
    -------
    Walk
    """
    low, high = stretch
    width, towards = high - low, 0.5 * (low + high)
    current = _Step(curve, start, width, towards)
    points, folds, h = [start], [False], _FIRST
    if not np.isfinite(current.tangent).all():
        return Walk(np.array(points), np.array(folds), np.nan)
    sense = 1.0 if (current.tangent[-1] > 0.0) == rising else -1.0
    for _ in range(MOST_STEPS):
        after = _stepped(curve, current, sense * h, stretch)
        cosine = current.leads_to(after) if after is not None else 0.0
        if after is None or not cosine >= _AGREE or not _near(current, after, h):
            h *= 0.5
            if h < _SHORTEST:
                break
            continue
        if after.tangent[-1] * current.tangent[-1] < 0.0:
            fold = _fold(curve, current, after, towards)
            if fold is None:
                h *= 0.5
                continue
            points.append(fold)
            folds.append(True)
        points.append(after.point)
        folds.append(False)
        if after.point[-1] in stretch:
            return Walk(np.array(points), np.array(folds), float(after.point[-1]))
        if not abs(after.point[0]) < bound:
            break
        h = min(2.0 * h, _LONGEST) if cosine > _GROW else h
        current = after
    return Walk(np.array(points), np.array(folds), np.nan)


def _near(current: _Step, after: _Step, h: float) -> bool:
    """Whether a step is about as long as it should be."""
    return bool(np.linalg.norm((after.point - current.point) / current.scale[0]) <= (1.0 + _CORRECTION) * h)


def _stepped(curve: WhirlCurve, current: _Step, h: float, stretch: tuple[float, float]) -> "_Step | None":
    """A step of a length along the tangent, cut at the ends of the stretch; None where it fails."""
    low, high = stretch
    scale, towards = current.scale, 0.5 * (low + high)
    move = h * current.tangent * scale[0]
    value = current.point[-1] + move[-1]
    if low < value < high:
        guess = current.point + move
        points, met = curve.corrected(guess[None], current.tangent[None], scale, towards)
        if not met[0] or np.abs((points[0] - guess) / scale[0]).max() > _CORRECTION * abs(h):
            return None
        if low < points[0, -1] < high:
            return _Step(curve, points[0], scale[0, -1], towards)
        move = points[0] - current.point
        value = points[0, -1]
    end = low if value <= low else high
    if move[-1] == 0.0 or current.point[-1] == end:
        return None
    guess = current.point + move * (end - current.point[-1]) / move[-1]
    guess[-1] = end
    points, met = curve.corrected(guess[None], _at_value(guess), scale, towards)
    if not met[0] or np.abs((points[0] - guess) / scale[0]).max() > _CORRECTION * abs(h):
        return None
    points[0, -1] = end
    return _Step(curve, points[0], scale[0, -1], towards)


def _at_value(guess: Points) -> Points:
    """The direction of the parameter, for a correction at its value."""
    row = np.zeros((1, guess.shape[-1]))
    row[:, -1] = 1.0
    return row


def between(curve: WhirlCurve, pair: Points, share: float, width: float) -> Points | None:
    """The point of a curve across the chord of two of its points (2, k), at a share of it; None where it is lost.

    width : of the stretch of the parameter in which they lie
    """
    scale, chord = curve.scale(pair[:1], width), pair[1] - pair[0]
    row = chord / scale[0]
    towards = 0.5 * (pair[0, -1] + pair[1, -1])
    points, met = curve.corrected(pair[:1] + share * chord, (row / np.linalg.norm(row))[None], scale, towards)
    return points[0] if met[0] else None


def _fold(curve: WhirlCurve, current: _Step, after: _Step, towards: float) -> Points | None:
    """The point between two where the parameter turns back."""
    pair, width = np.array([current.point, after.point]), current.scale[0, -1]

    def slope(share: float) -> float:
        point = between(curve, pair, share, width)
        if point is None:
            raise ArithmeticError
        return float(curve.tangents(curve.evaluated(point[None], towards)[1], current.scale)[0, -1])

    try:
        share = scipy.optimize.brentq(slope, 0.0, 1.0, xtol=_LOCATED, rtol=_LOCATED)
    except (ArithmeticError, ValueError):
        return None
    return between(curve, pair, share, width)
