"""Windows of a motion that is not steady yet: it settles on a whirl or beside all of them, or leaves a whirl that is unstable."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rsc.measure.changes import MOST_FOLDS
from rsc.measure.reasons import Code, Reason
from rsc.measure.verdict import ALONE, RUB, VOID, Row, Window, with_reason
from rsc.measure.windows import Features
from rsc.measure.words import DIFFERS, NO_PREDICTION, NOT_YET_STEADY, OUTSIDE

# windows at the beginning of a stretch on one whirl that show how far the motion was from it
FIRST = 3
# a motion that leaves a whirl is so many times as far from it as it was
LEAVES = 1.2


def settling(features: Features, growth: np.ndarray, upset: np.ndarray, windows: Sequence[Window]) -> list[Window]:
    """Windows with rows that differ while a motion decays towards its whirl, or leaves an unstable one, at the predicted rate.

    growth : (n_w,) 1/s, of small disturbances of the whirl that each window follows, or of its motion without one
    upset : (n_w,) bool, where no whirl is steady with so much unbalance: the motion after it starts anew
    """
    columns = list(zip(*windows, strict=True))
    judged = []
    for i in range(len(windows)):
        rows = [_settled(features, growth, upset, column[: i + 1]) for column in columns]
        # the line at the rotor speed leaves no whirl that neither frequency nor amplitude leaves
        if rows[2].has(Code.DEPARTURE) and not any(row.has(Code.DEPARTURE) for row in rows[:2]):
            rows[2] = windows[i].synchronous
        judged.append(Window(*rows))
    return judged


def _settled(features: Features, growth: np.ndarray, upset: np.ndarray, rows: Sequence[Row]) -> Row:
    """The last of the rows of one quantity, as one that is not yet steady if that covers its difference."""
    *earlier, row = rows
    if row.verdict not in (DIFFERS, NO_PREDICTION):
        return row
    if row.branch:
        return _not_yet_steady(features, growth, upset, row, earlier)
    return _rings_down(features, growth, row, earlier) if row.by in (ALONE, RUB) else row


def _rings_down(features: Features, growth: np.ndarray, row: Row, earlier: Sequence[Row]) -> Row:
    """The row of a window without a whirl, as one that settles if what start, impact or contact left of small motions covers it.

    At the first window of a stretch of one motion that is taken as the line itself, or as more where the first windows show more.
    """
    i = first = len(earlier)
    while first > 0 and earlier[first - 1].by == row.by:
        first -= 1
    own = growth[first : i + 1]
    if not (own < 0.0).all():
        return row
    begun = np.concatenate([[0.0], np.cumsum(np.diff(features.time[first : i + 1]) * 0.5 * (own[1:] + own[:-1]))])
    known = np.abs(np.array([other.difference for other in earlier[first : first + FIRST]]))
    remains = max(1.0, float(np.nanmax(known * np.exp(-begun[: len(known)]), initial=0.0))) * math.exp(begun[-1])
    since = float(-own[-1]), float(features.time[first])
    if abs(row.difference) <= remains:
        return with_reason(row, Reason(Code.DECAYS, ("s",), (*since, remains)), verdict=NOT_YET_STEADY)
    if len(known) < FIRST:
        return replace(row, verdict=NO_PREDICTION, reasons=(Reason(Code.STILL_RINGS, numbers=since),))
    return row


def _not_yet_steady(features: Features, growth: np.ndarray, upset: np.ndarray, row: Row, earlier: Sequence[Row]) -> Row:
    """The row, as one that settles or leaves its whirl if what earlier windows of the stretch differed by covers it.

    A disturbance changes by the e-th power of the integral of the growth rate. At the first window of a stretch on one whirl it
    is taken as 1, after the first windows as the largest that these had.
    """
    i = first = len(earlier)
    while first > 0 and earlier[first - 1].branch == row.branch and (upset[i] or not upset[first - 1]):
        first -= 1
    own = growth[first : i + 1]
    steps = np.diff(features.time[first : i + 1]) * 0.5 * (own[1:] + own[:-1])
    folds = np.cumsum(steps[::-1])[::-1]  # from each earlier window of the stretch to this one
    differed = np.abs(np.array([other.difference for other in earlier[first:]]))
    if own[-1] < 0.0:
        remains = math.exp(min(float(steps.sum()), 0.0))
        if len(differed) >= FIRST:
            remains = min(remains, float(np.nanmax(differed[:FIRST] * np.exp(np.minimum(folds[:FIRST], 0.0)), initial=0.0)))
        if not abs(row.difference) <= remains:
            return row
        told = Reason(Code.DECAYS, ("Hz",), (float(-own[-1]), float(features.speed[first]), remains))
        return with_reason(row, told, verdict=NOT_YET_STEADY)
    if row.has(Code.TOO_FAR):
        return row
    grows = (folds > 0.0) & np.isfinite(differed)
    grown = float(np.max(differed[grows] * np.exp(np.minimum(folds[grows], MOST_FOLDS)), initial=0.0))
    if not abs(row.difference) <= grown:
        return row
    if grown >= VOID:
        return replace(row, verdict=NO_PREDICTION, reasons=(Reason(Code.MUST_BE_LEFT),))
    if not (differed[grows] < abs(row.difference) / LEAVES).any():
        return row
    return with_reason(row, Reason(Code.DEPARTURE, numbers=(float(own[-1]), grown)), verdict=OUTSIDE)


def leaving(windows: Sequence[Window]) -> list[Window]:
    """Marks windows on an unstable whirl as not yet left if the run leaves it later."""
    judged, left = list(windows), False
    for i in reversed(range(len(windows))):
        window = windows[i]
        left |= window.branch != windows[-1].branch or any(row.has(Code.DEPARTURE) for row in window)
        if left:
            judged[i] = Window(*(_renamed(row, Code.UNSTABLE, Code.NOT_YET_LEFT) for row in window))
    return judged


def _renamed(row: Row, old: Code, new: Code) -> Row:
    return replace(row, reasons=tuple(replace(reason, code=new) if reason.code == old else reason for reason in row.reasons))
