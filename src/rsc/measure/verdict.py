"""Simulated features against predicted whirls: a row per window and quantity, the changes of whirl, and a verdict."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

# limits of agreement: the prediction is for a circle without unbalance at constant speed
FREQUENCY_TOLERANCE = 0.005  # of the frequency
AMPLITUDE_TOLERANCE = 0.02  # of the amplitude
# a line further from every predicted frequency belongs to none
NEAR = 0.1
# in the place of a branch's label
ROLL = "roll"
# a window rolls when its contact does for more than this share of the time
ROLLING = 0.5
# a backward line below this share of the gap is no whirl
LINE_FLOOR = 0.01
# a term of second order may have a coefficient of this size
ORDER_ONE = 4.0
# relaxation times after which a disturbance of a whirl is forgotten (e^-3 = 5 %)
MEMORY = 3.0
# the most e-foldings that rounding (1e-16 of the motion) can need to become visible
MOST_FOLDS = 40.0

# quantity -> (relative tolerance, predicted value); the synchronous line is first order in the unbalance
QUANTITIES: dict[str, tuple[float, Callable[[Any], float]]] = {
    "whirl frequency": (FREQUENCY_TOLERANCE, lambda whirl: whirl.frequency),
    "whirl amplitude": (AMPLITUDE_TOLERANCE, lambda whirl: whirl.rotor_amplitude),
    "synchronous line": (0.05, lambda whirl: whirl.synchronous.consistent.amplitude),
}

AGREES, DIFFERS = "agrees", "differs"
NO_PREDICTION, OUTSIDE, NO_WHIRL = "no prediction", "outside assumptions", "no whirl"


Failing = list[tuple[str, float | None]]  # assumptions that do not hold, with the relative error they can make


class BranchLike(Protocol):
    """The parts of a `rsc.analysis.branches.Branch` that a run is compared with; its whirls as in `rsc.Whirl`."""

    @property
    def label(self) -> str: ...

    @property
    def lost(self) -> tuple[float, ...]: ...

    @property
    def speed(self) -> NDArray[np.float64]: ...

    @property
    def growth_rate(self) -> NDArray[np.float64]: ...

    def at(self, value: float) -> Any: ...


@dataclass(frozen=True)
class Features:
    """Quantities measured in the windows of a run; arrays (n_w,) unless said otherwise, NaN where absent.

    speed Hz, time s, share (contact, 0 to 1), frequency Hz and amplitude m of the strongest backward line, second_frequency and
    second_amplitude of the next one, synchronous m (line at the rotor speed), rolling (share of the time in contact with less
    slip than full friction needs; 0 without a contact diameter)
    """

    speed: NDArray[np.float64]
    time: NDArray[np.float64]
    share: NDArray[np.float64]
    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    second_frequency: NDArray[np.float64]
    second_amplitude: NDArray[np.float64]
    synchronous: NDArray[np.float64]
    rolling: NDArray[np.float64]


@dataclass(frozen=True)
class Steady:
    """Predicted synchronous motions without a whirl, m at the contact, (n_w,) each: without contact, in permanent contact
    (forward rub; NaN where it does not exist)."""

    alone: NDArray[np.float64]
    rub: NDArray[np.float64]


@dataclass(frozen=True)
class Rolls:
    """The whirl predicted to roll next to the line of each window, (n_w,) each, NaN where there is none: frequency in Hz, |r| at
    the contact in m, growth rate in 1/s, and the share of a line's amplitude that is lost where it moves during the window."""

    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    growth_rate: NDArray[np.float64]
    loss: NDArray[np.float64]


@dataclass(frozen=True)
class Row:
    """One comparison: simulated beside predicted; difference is relative to the prediction, NaN where there is none."""

    quantity: str
    speed: float  # Hz
    simulated: float  # Hz or m
    predicted: float
    difference: float
    verdict: str
    branch: str  # label of the predicted whirl, ROLL, or ""
    note: str


@dataclass(frozen=True)
class Resonance:
    """The unbalance line on one whirl where it is largest inside the stretch that the run has that whirl.

    branch : label of the whirl
    speed, height : float Hz and m, simulated
    predicted_speed, predicted_height : float Hz and m, of the first order in the unbalance
    """

    branch: str
    speed: float
    height: float
    predicted_speed: float
    predicted_height: float


@dataclass(frozen=True)
class Transition:
    """A change from one predicted whirl to another (or to none) along the run.

    before, after : labels of branches ("" : no whirl)
    first_seen : float Hz, speed of the first window that shows the new line at all
    taken_over : float Hz, speed of the first window where the new line is the strongest
    predicted : float Hz, speed where the old whirl is predicted to lose stability or end; NaN if neither happens before
    folds : float, e-foldings of the disturbance between `predicted` and `taken_over`
    verdict, note : str
    """

    before: str
    after: str
    first_seen: float
    taken_over: float
    predicted: float
    folds: float
    verdict: str
    note: str


def compare(
    features: Features,
    branches: Sequence[BranchLike],
    steady: Steady,
    gap: float,
    delays: Mapping[str, Any] | None = None,
    rolls: Rolls | None = None,
) -> tuple[list[Row], list[Transition]]:
    """Rows and transitions of one run.

    Parameters
    ----------
    features : Features
    steady : Steady
    branches : list of rsc.analysis.branches.Branch
    gap : float, m
    delays : dict, optional
        Label -> rsc.analysis.delayed_jump.Delay of the branches that the run is predicted to leave late.
    rolls : Rolls, optional

    Returns
    -------
    rows : list of Row, frequency and amplitude of the whirl and the synchronous line of every window
    transitions : list of Transition
    """
    rows, labels = [], []
    for i in range(len(features.speed)):
        branch, whirl = _nearest(branches, features.speed[i], features.frequency[i])
        on_whirl = _has_whirl(features, i, gap)
        rolling = on_whirl and features.rolling[i] > ROLLING
        if rolling and rolls is not None and rolls.frequency[i] < 0.0:
            rows += _roll_rows(features, i, rolls)
        elif on_whirl and branch is not None:
            rows += _whirl_rows(features, i, branch, whirl)
        else:
            rows += _rows_off_whirl(features, i, steady, on_whirl)
        # a whirl that rolls is none of the branches, which slide
        labels.append({""} if not on_whirl else set() if rolling else _possible(branches, features, i))
    transitions = _transitions(features, branches, labels, delays or {})
    return _while_changing(features, branches, rows, transitions), transitions


def resonances(rows: list[Row]) -> list[Resonance]:
    """Where the unbalance is largest on each whirl of a run, simulated and predicted, by the speed of the windows."""
    lines: dict[str, list[Row]] = {}
    for row in rows:
        if row.quantity == "synchronous line" and row.branch not in ("", ROLL):
            lines.setdefault(row.branch, []).append(row)
    peaks = []
    for branch, own in lines.items():
        speeds = np.array([row.speed for row in own])
        simulated = _peak(speeds, np.array([row.simulated for row in own]))
        predicted = _peak(speeds, np.array([row.predicted for row in own]))
        if simulated is not None and predicted is not None:
            peaks.append(Resonance(branch, *simulated, *predicted))
    return peaks


def _peak(speeds: np.ndarray, line: np.ndarray) -> tuple[float, float] | None:
    """Speed and height of the largest value, by a parabola through it and its neighbours; None at an end."""
    i = int(np.argmax(line))
    if not 0 < i < len(line) - 1:
        return None
    bend, slope, height = np.polyfit(speeds[i - 1 : i + 2] - speeds[i], line[i - 1 : i + 2], 2)
    at = -0.5 * slope / bend if bend < 0.0 else 0.0
    return float(speeds[i] + at), float(height + slope * at + bend * at * at)


def summary(rows: Sequence[Row], transitions: Sequence[Transition], status: str) -> str:
    """One sentence on the whole run."""
    if status == "out of assumptions":
        return f"the run left the one-sided friction law's assumption of sliding forward (12): {_counted(rows)}"
    if status != "finished":
        return f"the run stopped early ({status}): {_counted(rows)}"
    unexplained = [t for t in transitions if t.verdict == DIFFERS]
    if unexplained:
        return f"simulation and prediction disagree on a change of whirl: {_counted(rows)}"
    whirl = [row.verdict for row in rows if row.quantity == "whirl frequency"]
    if DIFFERS in whirl or NO_PREDICTION in whirl:
        return f"differs in places: {_counted(rows)}"
    if AGREES not in whirl:
        return f"no steady whirl to compare: {_counted(rows)}"
    return f"agrees wherever the assumptions hold: {_counted(rows)}"


def _counted(rows: Sequence[Row]) -> str:
    whirl = [row.verdict for row in rows if row.quantity == "whirl frequency"]
    return ", ".join(f"{whirl.count(v)} windows {v}" for v in dict.fromkeys(sorted(whirl, key=_order)))


def _order(verdict: str) -> int:
    return (AGREES, DIFFERS, NO_PREDICTION, OUTSIDE, NO_WHIRL).index(verdict)


def _nearest(branches: Sequence[BranchLike], speed: float, frequency: float) -> tuple[BranchLike, Any] | tuple[None, None]:
    """The branch whose whirl at this speed is next to a frequency; (None, None) where none is near."""
    known = [(b, b.at(speed)) for b in branches]
    known = [(b, w) for b, w in known if w is not None]
    if not known or math.isnan(frequency):
        return None, None
    branch, whirl = min(known, key=lambda pair: abs(pair[1].frequency - frequency))
    return (branch, whirl) if abs(frequency / whirl.frequency - 1.0) <= NEAR else (None, None)


def _has_whirl(features: Features, i: int, gap: float) -> bool:
    """A backward line in contact; not the weak one beside a forward rub."""
    line, share = features.amplitude[i], features.share[i]
    rubs_forward = share >= 1.0 and features.synchronous[i] > 3.0 * line
    return line >= LINE_FLOOR * gap and share > 0.0 and not rubs_forward


def _whirl_rows(features: Features, i: int, branch: BranchLike, whirl: Any) -> list[Row]:
    """The three rows of a window that lies on a predicted whirl."""
    measured = (features.frequency[i], features.amplitude[i], features.synchronous[i])
    rows = []
    for (quantity, (tolerance, value)), simulated in zip(QUANTITIES.items(), measured, strict=True):
        predicted = value(whirl)
        difference = float(simulated) / predicted - 1.0
        verdict, note = _judge(difference, tolerance, _failing(features, i, branch, whirl, value))
        if verdict == AGREES and not whirl.stable:
            note = "the whirl is unstable there and not yet left"
        speed = float(features.speed[i])
        rows.append(Row(quantity, speed, float(simulated), predicted, difference, verdict, branch.label, note))
    return rows


def _roll_rows(features: Features, i: int, rolls: Rolls) -> list[Row]:
    """The three rows of a window whose whirl rolls; of such only frequency and amplitude are predicted."""
    speed, moving = float(features.speed[i]), (f"line at rest ({100 * rolls.loss[i]:.0f} % lost as it moves)", rolls.loss[i])
    stable = rolls.growth_rate[i] < 0.0
    rows, always = [], _partial_contact(features, i) + ([] if stable else [("stable", None)])
    for quantity, simulated, predicted, failing in (
        ("whirl frequency", features.frequency[i], rolls.frequency, []),
        ("whirl amplitude", features.amplitude[i], rolls.amplitude, [moving]),
    ):
        change = abs(predicted[min(i + 1, len(predicted) - 1)] - predicted[max(i - 1, 0)]) / abs(predicted[i])
        difference = float(simulated) / float(predicted[i]) - 1.0
        verdict, note = _judge(difference, QUANTITIES[quantity][0], [*always, (_steadiness(change), change), *failing])
        note = note or ("rolls" if stable else "rolls, unstable there and not yet left")
        rows.append(Row(quantity, speed, float(simulated), float(predicted[i]), difference, verdict, ROLL, note))
    return [*rows, Row("synchronous line", speed, float(features.synchronous[i]), math.nan, math.nan, NO_PREDICTION, ROLL, "")]


def _rows_off_whirl(features: Features, i: int, steady: Steady, has_line: bool) -> list[Row]:
    """The three rows of a window on no predicted whirl; its synchronous line may be that of another motion."""
    speed, share = float(features.speed[i]), float(features.share[i])
    verdict, note = _without_whirl(features, i, has_line)
    rows = [
        Row(quantity, speed, float(simulated), math.nan, math.nan, verdict, "", note)
        for quantity, simulated in (("whirl frequency", features.frequency[i]), ("whirl amplitude", features.amplitude[i]))
    ]
    simulated, tolerance = float(features.synchronous[i]), QUANTITIES["synchronous line"][0]
    motion = {0.0: steady.alone, 1.0: steady.rub}.get(share, np.full(len(features.speed), np.nan))
    name = {0.0: "without contact", 1.0: "forward rub"}.get(share, "")
    predicted = float(motion[i])
    if math.isnan(predicted):
        return [*rows, Row("synchronous line", speed, simulated, math.nan, math.nan, verdict, "", note)]
    difference = simulated / predicted - 1.0 if predicted > 0.0 else math.nan
    before, after = motion[max(i - 1, 0)], motion[min(i + 1, len(motion) - 1)]
    change = abs(after - before) / predicted if predicted > 0.0 else math.nan
    verdict, note = _judge(difference, tolerance, [(_steadiness(change), change)])
    return [*rows, Row("synchronous line", speed, simulated, predicted, difference, verdict, "", note or name)]


def _without_whirl(features: Features, i: int, has_line: bool) -> tuple[str, str]:
    """Verdict and note of a window that lies on no predicted whirl."""
    share, rolling = features.share[i], features.rolling[i]
    if not has_line:
        return NO_WHIRL, ""
    if share < 1.0:
        return OUTSIDE, f"a backward line in partial contact ({100 * share:.0f} % simulated), no steady whirl"
    if rolling > ROLLING:
        return NO_PREDICTION, f"rolls for {100 * rolling:.0f} % of the time, near no whirl that is predicted to"
    return NO_PREDICTION, "a backward line near no predicted whirl"


def _judge(difference: float, tolerance: float, failing: Failing) -> tuple[str, str]:
    """Verdict and note of a relative difference; failing = assumptions that do not hold with the error they can make."""
    if math.isnan(difference):
        return NO_PREDICTION, ""
    if abs(difference) <= tolerance:
        return AGREES, ""
    explained = [name for name, size in failing if size is None or abs(difference) <= size]
    return (OUTSIDE, "fails: " + ", ".join(explained)) if explained else (DIFFERS, "")


def _partial_contact(features: Features, i: int) -> Failing:
    """Permanent contact, where a window has none, as an assumption that does not hold."""
    return [(f"permanent contact ({100 * features.share[i]:.0f} % simulated)", None)] if features.share[i] < 1.0 else []


def _steadiness(change: float) -> str:
    return f"steady over a window (predicted changes by {100 * change:.0f} %)"


def _second_order(features: Features, i: int, branch: BranchLike, whirl: Any) -> float:
    """Size of the second-order terms in the unbalance: the square of the ratio of synchronous line and whirl.

    The motion remembers some relaxation times, so the largest of them counts.
    """
    since = features.time[i] - MEMORY / max(abs(whirl.growth_rate), 1e-12)
    whirls = [branch.at(features.speed[k]) for k in range(i, -1, -1) if features.time[k] >= since]
    return max((w.synchronous.consistent.amplitude / w.rotor_amplitude) ** 2 for w in whirls if w is not None)


def _failing(features: Features, i: int, branch: BranchLike, whirl: Any, value: Callable[[Any], float]) -> Failing:
    """Assumptions that do not hold in a window: (name, relative error it can make; None where it is unbounded)."""
    failing: Failing = [(name, None) for name in whirl.violated]
    if not whirl.stable:
        failing.append(("stable", None))
    failing += _partial_contact(features, i)
    second_order = _second_order(features, i, branch, whirl)
    failing.append((f"unbalance small (second-order terms {100 * second_order:.1f} %)", ORDER_ONE * second_order))
    # the prediction is for a constant speed, a window sees a range of speeds (the neighbours stand half a window away)
    ends = [branch.at(features.speed[k]) for k in (max(i - 1, 0), min(i + 1, len(features.speed) - 1))]
    if None not in ends:
        change = abs(value(ends[1]) - value(ends[0])) / abs(value(whirl))
        failing.append((_steadiness(change), change))
    return failing


def _possible(branches: Sequence[BranchLike], features: Features, i: int) -> set[str]:
    """Labels of the branches that a window's backward line may belong to."""
    line = features.frequency[i]
    known = [(b.label, b.at(features.speed[i])) for b in branches]
    return {name for name, w in known if w is not None and abs(line / w.frequency - 1.0) <= 4.0 * FREQUENCY_TOLERANCE}


def _transitions(
    features: Features, branches: Sequence[BranchLike], labels: Sequence[set[str]], delays: Mapping[str, Any]
) -> list[Transition]:
    """Changes of whirl that last for at least two windows; a window that may still be on the old whirl is."""
    transitions, current = [], None
    for i, possible in enumerate(labels):
        if not possible or current in possible:
            continue
        label = _next_label(features, branches, possible, i)
        if i + 1 < len(labels) and labels[i + 1] and label not in labels[i + 1]:
            continue
        if current is not None:
            transitions.append(_transition(features, branches, (current, label), i, delays.get(current)))
        current = label
    return transitions


def _next_label(features: Features, branches: Sequence[BranchLike], possible: set[str], i: int) -> str:
    """Label of the nearest of several whirls that a line may belong to; "" for none."""
    if possible == {""}:
        return ""
    candidates = [b for b in branches if b.label in possible]
    return min(candidates, key=lambda b: abs(b.at(features.speed[i]).frequency - features.frequency[i])).label


def _transition(
    features: Features, branches: Sequence[BranchLike], names: tuple[str, str], i: int, delay: Any
) -> Transition:
    before, after = names
    by_label = {b.label: b for b in branches}
    taken_over = float(features.speed[i])
    first_seen = _first_seen(features, branches, after, i)
    if before == "":
        return Transition(before, after, first_seen, taken_over, math.nan, math.nan, AGREES, "a whirl sets in")
    old = by_label[before]
    falling = features.speed[-1] < features.speed[0]
    predicted = _predicted_end(old, taken_over, falling)
    if math.isnan(predicted):
        shares = features.share[max(i - 12, 0) : i + 1]
        if shares.min() < 1.0:
            note = (
                f"whirl {before} is predicted to be stable there, but contact was lost during the beat with the unbalance "
                f"(contact {100 * shares.min():.0f} % of a window): permanent contact, an assumption of the prediction, ended"
            )
            return Transition(before, after, first_seen, taken_over, predicted, math.nan, OUTSIDE, note)
        note = f"whirl {before} is predicted to be stable there and contact is permanent"
        return Transition(before, after, first_seen, taken_over, predicted, math.nan, DIFFERS, note)
    folds = _folds(old, features, predicted, i)
    note = (
        f"whirl {before} loses stability at {predicted:.2f} Hz (predicted); until the jump at {taken_over:.1f} Hz a disturbance "
        f"grows by e^{folds:.1f}: the delay of a run-up, longer for a smaller disturbance, a tighter tolerance or a faster run-up"
    )
    if delay is not None:
        note += f"; with rounding as the only disturbance it is predicted at {delay.jump:.1f} Hz"
    verdict = AGREES if 0.0 <= folds <= MOST_FOLDS else DIFFERS
    return Transition(before, after, first_seen, taken_over, predicted, folds, verdict, note)


def _predicted_end(branch: BranchLike, speed: float, falling: bool) -> float:
    """Speed, met before `speed` along the run, where a branch loses stability or ends; NaN if neither happened."""
    low, high = branch.speed.min(), branch.speed.max()
    if falling:
        met = [s for s in branch.lost if s >= speed] + ([low] if low >= speed else [])
        return min(met, default=math.nan)
    met = [s for s in branch.lost if s <= speed] + ([high] if high <= speed else [])
    return max(met, default=math.nan)


def _folds(branch: BranchLike, features: Features, start: float, i: int) -> float:
    """Integral of the growth rate over time from the speed `start` to window i."""
    speeds, times = features.speed[: i + 1], features.time[: i + 1]
    beyond = (speeds >= start) if features.speed[-1] >= features.speed[0] else (speeds <= start)
    order = np.argsort(branch.speed)
    growth = np.interp(speeds[beyond], branch.speed[order], branch.growth_rate[order])
    return float(np.trapezoid(growth, times[beyond]))


def _while_changing(
    features: Features, branches: Sequence[BranchLike], rows: Sequence[Row], transitions: Sequence[Transition]
) -> list[Row]:
    """Rows with those outside the assumptions that differ while one whirl gives way to another and the new one still settles."""
    speeds, times = features.speed, features.time
    changing: dict[int, str] = {}
    for change in transitions:
        new = next((b for b in branches if b.label == change.after), None)
        whirl = new and new.at(change.taken_over)
        if not whirl:
            continue
        seen, over = (times[np.argmin(np.abs(speeds - s))] for s in (change.first_seen, change.taken_over))
        settled = over + MEMORY / max(abs(whirl.growth_rate), 1e-12)
        for i in np.flatnonzero((times >= seen) & (times <= settled)).tolist():
            changing[i] = f"fails: steady (changing from {change.before or 'no whirl'} to {change.after})"
    return [
        replace(row, verdict=OUTSIDE, note=changing[k // len(QUANTITIES)])
        if row.verdict == DIFFERS and k // len(QUANTITIES) in changing
        else row
        for k, row in enumerate(rows)
    ]


def _first_seen(features: Features, branches: Sequence[BranchLike], label: str, i: int) -> float:
    """Speed of the earliest window before i from which on a line of the new whirl shows, strongest or second."""
    first = i
    for k in range(i, -1, -1):
        lines = (features.frequency[k], features.second_frequency[k])
        nearest = [_nearest(branches, features.speed[k], line)[0] for line in lines]
        if not any(branch is not None and branch.label == label for branch in nearest):
            break
        first = k
    return float(features.speed[first])
