"""Changes of a run from one predicted whirl to another or to none."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rsc.measure.kinds import Kind
from rsc.measure.reasons import Code, Reason
from rsc.measure.windows import Best, BranchLike, Features, branches_of, nearest
from rsc.measure.words import AGREES, DIFFERS, FREQUENCY, NO_PREDICTION, TOLERANCES

# the most e-foldings that rounding (1e-16 of the motion) can need to become visible
MOST_FOLDS = 40.0
# windows before a change in which a whirl with its unbalance is asked whether it ended
BEFORE = 12


@dataclass(frozen=True)
class Transition:
    """A change from one predicted whirl to another (or to none) along the run.

    before, after : labels of branches ("" : no whirl)
    first_seen : float Hz, speed of the first window that shows the new line at all
    taken_over : float Hz, speed of the first window where the new line is the strongest
    predicted : float Hz, speed where the old whirl is predicted to lose stability or end; NaN if neither happens before
    predicted_jump : float Hz, speed where it is predicted to be left, the delay of the run included; NaN if not known
    folds : float, e-foldings of the disturbance between `predicted` and `taken_over`
    verdict : str; reasons : tuple of `rsc.measure.reasons.Reason`, one
    """

    before: str
    after: str
    first_seen: float
    taken_over: float
    predicted: float
    predicted_jump: float
    folds: float
    verdict: str
    reasons: tuple[Reason, ...]


def _possible(branches: Sequence[BranchLike], features: Features, i: int) -> set[str]:
    """Labels of the branches that a window's backward line may belong to."""
    line = features.frequency[i]
    known = [(b.label, b.at(features.speed[i])) for b in branches_of(features, branches, i)]
    return {name for name, w in known if w is not None and abs(line / w.frequency - 1.0) <= 4.0 * TOLERANCES[FREQUENCY]}


def transitions(
    features: Features, branches: Sequence[BranchLike], delays: Mapping[str, Any], best: Best | None = None
) -> list[Transition]:
    """Changes of whirl that last for at least two windows; a window that may still be on the old whirl is.

    Parameters
    ----------
    features : Features
    branches : list of rsc.analysis.follow.branch.Branch
    delays : dict
        Label -> rsc.analysis.follow.delayed_jump.Delay of the branches that the run is predicted to leave late.
    best : Best, optional
    """
    labels = [_labels(features, branches, i) for i in range(len(features.speed))]
    changes: list[Transition] = []
    current: str | None = None
    for i, possible in enumerate(labels):
        if not possible or current in possible:
            continue
        label = _next_label(features, branches, possible, i)
        if i + 1 < len(labels) and labels[i + 1] and label not in labels[i + 1]:
            continue
        if current is not None:
            changes.append(_transition(features, branches, (current, label), i, delays.get(current), best))
        current = label
    return changes


def _labels(features: Features, branches: Sequence[BranchLike], i: int) -> set[str]:
    """Labels of the branches that window i may lie on; {""} for no whirl, none for a whirl that rolls: branches slide."""
    if not features.on_whirl(i):
        return {""}
    return set() if features.kind[i] == Kind.ROLLING else _possible(branches, features, i)


def _next_label(features: Features, branches: Sequence[BranchLike], possible: set[str], i: int) -> str:
    """Label of the nearest of several whirls that a line may belong to; "" for none."""
    if possible == {""}:
        return ""
    candidates = [b for b in branches if b.label in possible]
    return min(candidates, key=lambda b: abs(b.at(features.speed[i]).frequency - features.frequency[i])).label


def _transition(
    features: Features,
    branches: Sequence[BranchLike],
    names: tuple[str, str],
    i: int,
    delay: Any,
    best: Best | None,
) -> Transition:
    before, after = names
    speeds = _first_seen(features, branches, after, i), float(features.speed[i])
    if before == "":
        return Transition(before, after, *speeds, math.nan, math.nan, math.nan, AGREES, (Reason(Code.SETS_IN),))
    old = next(b for b in branches if b.label == before)
    if not old.lost and (old.growth_rate >= 0.0).all():
        return Transition(before, after, *speeds, math.nan, math.nan, math.nan, NO_PREDICTION, (Reason(Code.ALWAYS_UNSTABLE),))
    predicted = _predicted_end(old, speeds[1], bool(features.speed[-1] < features.speed[0]))
    if math.isnan(predicted):
        predicted, verdict, reason = _end_with_unbalance(features, i, best)
        return Transition(before, after, *speeds, predicted, math.nan, math.nan, verdict, (reason,))
    folds = _folds(old, features, predicted, i)
    jump = math.nan if delay is None else float(delay.jump)
    verdict = AGREES if 0.0 <= folds <= MOST_FOLDS else DIFFERS
    return Transition(before, after, *speeds, predicted, jump, folds, verdict, (Reason(Code.LATE),))


def _end_with_unbalance(features: Features, i: int, best: Best | None) -> tuple[float, str, Reason]:
    """(predicted speed, verdict, reason) of a whirl that is stable without its unbalance: does that end it just before?"""
    near = np.arange(max(i - BEFORE, 0), i + 1)
    reached = np.ones(len(near)) if best is None else best.reached[near]
    growth = np.full(len(near), np.nan) if best is None else best.growth_rate[near]
    if (reached < 1.0).any():
        share = float(np.nanmin(reached))
        return float(features.speed[near[reached < 1.0][0]]), AGREES, Reason(Code.ENDED_BY_UNBALANCE, numbers=(share,))
    if (growth > 0.0).any():
        largest = float(np.nanmax(growth))
        return float(features.speed[near[growth > 0.0][0]]), AGREES, Reason(Code.UPSET_BY_UNBALANCE, numbers=(largest,))
    return math.nan, DIFFERS, Reason(Code.STABLE_THERE, numbers=(float(features.share[near].min()),))


def _predicted_end(branch: BranchLike, speed: float, falling: bool) -> float:
    """Speed, met before `speed` along the run, where a branch loses stability or, still stable, ends; NaN if neither happened."""
    sign = -1.0 if falling else 1.0  # so that the run goes up
    lost = max((sign * s for s in branch.lost if sign * s <= sign * speed), default=math.nan)
    last = int(np.argmax(sign * branch.speed))
    end = sign * float(branch.speed[last])
    if end <= sign * speed and (math.isnan(lost) or branch.growth_rate[last] < 0.0):
        return sign * end
    return sign * lost


def _folds(branch: BranchLike, features: Features, start: float, i: int) -> float:
    """Integral of the growth rate over time from the speed `start` to window i."""
    speeds, times = features.speed[: i + 1], features.time[: i + 1]
    beyond = (speeds >= start) if features.speed[-1] >= features.speed[0] else (speeds <= start)
    order = np.argsort(branch.speed)
    growth = np.interp(speeds[beyond], branch.speed[order], branch.growth_rate[order])
    return float(np.trapezoid(growth, times[beyond]))


def _first_seen(features: Features, branches: Sequence[BranchLike], label: str, i: int) -> float:
    """Speed of the earliest window before i from which on a line of the new whirl is among the three strongest."""
    first = i
    for k in range(i, -1, -1):
        lines = (features.frequency[k], *features.other_frequency[k])
        near = [nearest(branches, features.speed[k], line) for line in lines]
        if not any(pair is not None and pair.branch.label == label for pair in near):
            break
        first = k
    return float(features.speed[first])
