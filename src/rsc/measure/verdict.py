"""Simulated features against predicted whirls: three comparisons of every window, each with its verdict and its reasons.

A window is compared with the best prediction at hand (`Best`). A difference beyond the tolerance is excused only by a named
effect whose computed size covers it.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rsc.measure.changes import MOST_FOLDS
from rsc.measure.kinds import Kind, ProbeKind
from rsc.measure.reasons import Code, Reason
from rsc.measure.spectra import sweep_loss
from rsc.measure.windows import (
    LEAST_PERIODS,
    ROLL,
    Best,
    BranchLike,
    Features,
    Followed,
    Rolls,
    Steady,
    followed,
    same_branch,
)
from rsc.measure.words import (
    AGREES,
    AMPLITUDE,
    DIFFERS,
    FREQUENCY,
    NO_PREDICTION,
    NO_WHIRL,
    NOT_RESOLVED,
    NOT_YET_STEADY,
    OUTSIDE,
    SYNCHRONOUS,
    TOLERANCES,
)

# a term of second order may have a coefficient of this size
ORDER_ONE = 4.0
# a prediction that may be wrong by this share is none
VOID = 1.0
# a line whose frequency or amplitude is further from the whirl than this is not that of the whirl, whatever else fits
SAME_LINE = {FREQUENCY: 0.02, AMPLITUDE: 0.3}
# windows at the beginning of a stretch on one whirl that show how far the motion was from it
FIRST = 3
# a motion that leaves a whirl is so many times as far from it as it was
LEAVES = 1.2

# what a prediction was made with
BALANCE, FIRST_ORDER, ROLLS, ALONE, RUB = "balance", "first order", "rolling", "without contact", "forward rub"
ELLIPTIC = "elliptic"  # balance of a whirl without unbalance in supports whose directions differ

Verdict = tuple[str, tuple[Reason, ...]]  # and why
Effects = list[tuple[str, float]]  # names of effects that the prediction leaves out, and the relative difference they can make


@dataclass(frozen=True)
class Row:
    """One comparison: simulated beside predicted; difference is relative to the prediction, NaN where there is none.

    quantity : str, one of `rsc.measure.words.TOLERANCES`
    speed : float Hz; time : float s, at the centre of the window; contact : float, share of the window in contact
    simulated, predicted : float, Hz or m
    by : str, what the prediction was made with: "balance" (the whole unbalance), "elliptic" (directions that differ, without the
        unbalance), "first order", "rolling", "without contact", "forward rub"; "" where there is none
    branch : str, label of the predicted whirl, "roll", or ""
    verdict : str, one of `rsc.measure.words.VERDICTS`; reasons : tuple of `rsc.measure.reasons.Reason`, why it is so
    """

    quantity: str
    speed: float
    time: float
    contact: float
    simulated: float
    predicted: float
    difference: float
    verdict: str
    by: str
    branch: str
    reasons: tuple[Reason, ...] = ()

    def has(self, code: Code) -> bool:
        """Whether a code is among its reasons."""
        return any(reason.code == code for reason in self.reasons)


@dataclass(frozen=True)
class Window:
    """The comparisons of one window; speed, time, contact and branch are those of each."""

    frequency: Row  # of the whirl
    amplitude: Row  # of the whirl
    synchronous: Row  # line at the rotor speed

    def __iter__(self) -> Iterator[Row]:
        return iter((self.frequency, self.amplitude, self.synchronous))

    @property
    def branch(self) -> str:
        """Label of the predicted whirl, "roll", or ""."""
        return self.frequency.branch


def compare(
    features: Features,
    branches: Sequence[BranchLike],
    steady: Steady,
    rolls: Rolls | None = None,
    best: Best | None = None,
    load: float = 0.0,
) -> list[Window]:
    """Frequency and amplitude of the whirl and the synchronous line of every window, with their predictions.

    Parameters
    ----------
    features : Features
    branches : list of rsc.analysis.follow.branch.Branch
    steady : Steady
    rolls : Rolls, optional
    best : Best, optional
        Default: the first order in the unbalance everywhere.
    load : float, m
        Deflection at the contact by a constant load, which no prediction has.

    Returns
    -------
    list of Window
    """
    pairs = followed(features, branches, rolls)
    growth = np.full(len(pairs), np.nan)
    windows: list[Window] = []
    for i, pair in enumerate(pairs):
        on_whirl = features.on_whirl(i)
        if pair is not None:
            windows.append(_on_whirl(features, i, pairs, best, load))
            growth[i] = pair.whirl.growth_rate
        elif rolls is not None and on_whirl and not math.isnan(rolls.frequency[i]) and not features.too_fast(i):
            windows.append(_on_roll(features, i, rolls))
            growth[i] = rolls.growth_rate[i]
        else:
            windows.append(_off_whirl(features, i, steady))
            growth[i] = steady.growth_rate[i]
    upset = np.zeros(len(pairs), dtype=bool) if best is None else best.reached < 1.0
    return [_without_coincidences(window) for window in _leaving(_settling(features, growth, upset, windows))]


def _row(features: Features, i: int, quantity: str, values: tuple[float, float], **more: Any) -> Row:
    """A row of simulated and predicted value, with its verdict, by, branch and reasons as far as they are given."""
    simulated, predicted = float(values[0]), float(values[1])
    difference = simulated / predicted - 1.0 if predicted else math.nan
    window = float(features.speed[i]), float(features.time[i]), float(features.share[i])
    return Row(quantity, *window, simulated, predicted, difference, **{"verdict": "", "by": "", "branch": "", **more})


def _judged(features: Features, i: int, row: Row, effects: Effects, otherwise: Verdict = (DIFFERS, ())) -> Row:
    """A row with its verdict; `otherwise`: verdict and reasons of a difference that no effect covers."""
    line = row.speed if row.quantity == SYNCHRONOUS else features.frequency[i]
    if features.window * abs(line) < LEAST_PERIODS:
        return replace(row, verdict=NOT_RESOLVED, reasons=_few_periods(features, line))
    if math.isnan(row.difference):
        return replace(row, verdict=NO_PREDICTION)
    if abs(row.difference) <= TOLERANCES[row.quantity]:
        return replace(row, verdict=AGREES)
    void = tuple(Reason(Code.TOO_FAR, (name,), (size,)) for name, size in effects if size >= VOID)
    if void:
        return replace(row, verdict=NO_PREDICTION, reasons=void)
    covering = tuple(Reason(Code.COVERED, (name,), (size,)) for name, size in effects if abs(row.difference) <= size)
    if covering:
        return replace(row, verdict=OUTSIDE, reasons=covering)
    return replace(row, verdict=otherwise[0], reasons=otherwise[1])


def _few_periods(features: Features, line: float) -> tuple[Reason, ...]:
    return (Reason(Code.FEW_PERIODS, numbers=(float(features.window * abs(line)),)),)


def _on_whirl(features: Features, i: int, pairs: Sequence[Followed | None], best: Best | None, load: float) -> Window:
    """A window that follows a predicted whirl; the amplitude is that of the body that moves more."""
    pair = pairs[i]
    assert pair is not None
    by_stator = bool(features.stator_amplitude[i] > features.amplitude[i])
    amplitude = features.stator_amplitude[i] if by_stator else features.amplitude[i]
    measured = (features.frequency[i], amplitude, features.synchronous[i])
    predicted = _predicted(pair.whirl, best, i, by_stator)
    by = BALANCE if best is not None and not math.isnan(best.synchronous[i]) else FIRST_ORDER
    if best is not None and pair.whirl.mirror is not None:
        by = ELLIPTIC
    otherwise: Verdict = (DIFFERS, ())
    if best is not None and best.reached[i] < 1.0:
        cause = "unbalance" if by != ELLIPTIC else "difference of the directions"
        otherwise = (NO_PREDICTION, (Reason(Code.NONE_WITH_SO_MUCH, (cause,), (float(best.reached[i]),)),))
    rows = []
    for quantity, values in zip(TOLERANCES, zip(measured, predicted, strict=True), strict=True):
        effects = [*_second_order(features, i, pair, best, load), _moving(features, i, pairs, best, quantity)]
        row = _row(features, i, quantity, values, by=by, branch=pair.branch.label)
        row = _judged(features, i, row, effects, otherwise)
        if by_stator and quantity == AMPLITUDE:
            row = _with(row, Reason(Code.OF_STATOR))
        if row.verdict == AGREES and not pair.whirl.decays:
            row = _with(row, Reason(Code.UNSTABLE))
        rows.append(row)
    return Window(*rows)


def _with(row: Row, reason: Reason, **more: Any) -> Row:
    """The row with one more reason."""
    return replace(row, reasons=(*row.reasons, reason), **more)


def _predicted(whirl: Any, best: Best | None, i: int, by_stator: bool) -> tuple[float, float, float]:
    """Frequency, amplitude and synchronous line by the best prediction at hand."""
    first = whirl.stator_amplitude if by_stator else whirl.rotor_amplitude
    values = [whirl.frequency, first, whirl.synchronous.consistent.amplitude]
    if best is not None:
        better = (best.frequency, best.stator_amplitude if by_stator else best.amplitude, best.synchronous)
        values = [float(b[i]) if not math.isnan(b[i]) else v for v, b in zip(values, better, strict=True)]
    return values[0], values[1], values[2]


def _second_order(features: Features, i: int, pair: Followed, best: Best | None, load: float) -> Effects:
    """Parts of the motion that a prediction linearises or neglects, and the size of their squares."""
    line = max(float(features.size[i]), 1e-300)  # a whirl of which the samples show nothing
    steady = _predicted(pair.whirl, best, i, False)[2]
    parts = {
        "the constant load": load / line,
        "the unbalance line off its steady value": abs(features.synchronous[i] ** 2 - steady**2) ** 0.5 / line,
    }
    if best is None or math.isnan(best.synchronous[i]):
        parts["the unbalance"] = pair.whirl.synchronous.consistent.amplitude / pair.whirl.rotor_amplitude
    squares = [(f"{name}, second order", ORDER_ONE * float(part) ** 2) for name, part in parts.items() if part > 0.0]
    return [_beside(features, i), *squares]


def _beside(features: Features, i: int) -> tuple[str, float]:
    """What the square of another backward line can make: round a whirl that is unstable a modulated one may last."""
    share = np.nan_to_num(features.other_size[i, 0]) / max(float(features.size[i]), 1e-300)
    return "another backward line, second order", ORDER_ONE * float(share) ** 2


def _moving(features: Features, i: int, pairs: Sequence[Followed | None], best: Best | None, quantity: str) -> tuple[str, float]:
    """Effect of the speed range in a window: predicted change, and amplitude loss of a moving line."""
    places = [k for k in (i - 1, i, i + 1) if same_branch(pairs, i, k)]
    values = np.array([_predicted(pairs[k].whirl, best, k, False) for k in places])  # type: ignore[union-attr]
    seconds = float(np.ptp(features.time[places]))
    column = list(TOLERANCES).index(quantity)
    value = abs(values[places.index(i), column])
    change = float(np.ptp(values[:, column]) / value) if value > 0.0 else 0.0
    if quantity != FREQUENCY and seconds > 0.0:
        moved = features.speed[places] if quantity == SYNCHRONOUS else values[:, 0]
        change += sweep_loss(float(np.ptp(moved)) / seconds, features.window)
    return ("motion during the window", change)


def _on_roll(features: Features, i: int, rolls: Rolls) -> Window:
    """A window whose whirl rolls."""
    by_stator = bool(features.stator_amplitude[i] > features.amplitude[i])
    bodies = (features.stator_amplitude, rolls.stator_amplitude) if by_stator else (features.amplitude, rolls.amplitude)
    rows = []
    lines = (features.frequency, rolls.frequency), bodies, (features.synchronous, rolls.synchronous)
    for quantity, (simulated, predicted) in zip(TOLERANCES, lines, strict=True):
        neighbours = predicted[max(i - 1, 0) : i + 2]
        neighbours = neighbours[np.isfinite(neighbours)]
        moving = float(np.ptp(neighbours)) / abs(float(predicted[i])) if len(neighbours) and predicted[i] else 0.0
        moving += float(np.nan_to_num(rolls.loss[i])) if quantity == AMPLITUDE else 0.0
        row = _row(features, i, quantity, (simulated[i], predicted[i]), by=ROLLS, branch=ROLL)
        row = _judged(features, i, row, [_beside(features, i), ("motion during the window", moving)])
        codes = [Code.ROLLS]
        codes += [Code.UNSTABLE] if not rolls.growth_rate[i] < 0.0 else []
        codes += [Code.OF_STATOR] if by_stator and quantity == AMPLITUDE else []
        rows.append(replace(row, reasons=(*map(Reason, codes), *row.reasons)))
    return Window(*rows)


def _off_whirl(features: Features, i: int, steady: Steady) -> Window:
    """A window on no predicted whirl; its synchronous line may be that of another motion."""
    share, last = float(features.share[i]), len(features.speed) - 1
    verdict, reason = _without_whirl(features, i)
    why: dict[str, Any] = {"verdict": verdict, "reasons": (reason,) if reason else ()}
    frequency = _row(features, i, FREQUENCY, (features.frequency[i], math.nan), **why)
    amplitude = _row(features, i, AMPLITUDE, (features.amplitude[i], math.nan), **why)
    motion, by = _steady_motion(features, i, steady)
    if not motion[i] > 0.0:
        return Window(frequency, amplitude, _row(features, i, SYNCHRONOUS, (features.synchronous[i], math.nan), **why))
    if share == 0.0 and steady.moving[i] > 0.0:
        row = _row(features, i, SYNCHRONOUS, (features.synchronous[i], steady.moving[i]), by=ALONE)
        return Window(frequency, amplitude, _judged(features, i, row, []))
    before, after = max(i - 1, 0), min(i + 1, last)
    change = np.ptp(motion[before : after + 1]) / motion[i]  # of all three: at a resonance the two beside are alike
    if after > before:
        rate = np.diff(features.speed[[before, after]]) / np.diff(features.time[[before, after]])
        change += sweep_loss(float(rate[0]), features.window)
    row = _row(features, i, SYNCHRONOUS, (features.synchronous[i], motion[i]), by=by)
    row = _judged(features, i, row, [("motion during the window", float(np.nan_to_num(change)))])
    return Window(frequency, amplitude, row)


def _steady_motion(features: Features, i: int, steady: Steady) -> tuple[np.ndarray, str]:
    """The predicted motions (n_w,) that turn with the shaft of the kind of window i, and its word; of a measured window that
    reaches the gap the one next to it, since no probe tells whether it touches."""
    kinds = {Kind.NO_CONTACT: ALONE, Kind.FORWARD_RUB: RUB}
    by = kinds.get(features.kind[i], "")
    if features.kind[i] == ProbeKind.WITH_SHAFT:
        off = {ALONE: abs(steady.alone[i] - features.synchronous[i]), RUB: abs(steady.rub[i] - features.synchronous[i])}
        by = RUB if features.share[i] != 0.0 and off[RUB] < off[ALONE] else ALONE
    return {ALONE: steady.alone, RUB: steady.rub, "": np.full(len(features.speed), np.nan)}[by], by


def _without_whirl(features: Features, i: int) -> tuple[str, Reason | None]:
    """Verdict and reason of a window that lies on no predicted whirl."""
    kind, share, line = str(features.kind[i]), float(features.share[i]), features.frequency[i]
    if kind == Kind.NOT_RESOLVED:
        return NOT_RESOLVED, Reason(Code.SHORT, (str(features.why[i]),))
    if not features.on_whirl(i):
        tells_all = kind in (Kind.NO_CONTACT, Kind.FORWARD_RUB, ProbeKind.WITH_SHAFT)
        return NO_WHIRL, None if tells_all else Reason(Code.OTHER_MOTION, (kind,))
    if features.too_fast(i):
        return NOT_RESOLVED, Reason(Code.TOO_FAST, numbers=(float(features.turning[i]), features.rate))
    if features.window * abs(line) < LEAST_PERIODS:
        return NOT_RESOLVED, _few_periods(features, line)[0]
    if kind == Kind.ROLLING:
        return NO_PREDICTION, Reason(Code.ROLLS_BY_NONE, numbers=(float(features.rolling[i]),))
    return NO_PREDICTION, Reason(Code.BY_NONE, (kind,), (share if share == share else 1.0,))


def _settling(features: Features, growth: np.ndarray, upset: np.ndarray, windows: Sequence[Window]) -> list[Window]:
    """Windows with rows that differ while a motion decays towards its whirl, or leaves an unstable one, at the predicted rate.

    growth : (n_w,) 1/s, of small disturbances of the whirl that each window follows, or of its motion without one
    upset : (n_w,) bool, where there is no steady whirl with so much unbalance: behind it the motion begins anew
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
        return _with(row, Reason(Code.DECAYS, ("s",), (*since, remains)), verdict=NOT_YET_STEADY)
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
        return _with(row, told, verdict=NOT_YET_STEADY)
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
    return _with(row, Reason(Code.DEPARTURE, numbers=(float(own[-1]), grown)), verdict=OUTSIDE)


def _leaving(windows: Sequence[Window]) -> list[Window]:
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


def _without_coincidences(window: Window) -> Window:
    """A window in which frequency and amplitude agree only where the other one can be that of the same line, too."""
    frequency, amplitude = window.frequency, window.amplitude
    far, large = (abs(row.difference) > SAME_LINE[row.quantity] for row in (frequency, amplitude))
    judged = window
    # a whirl of another amplitude than predicted is still that whirl, one of another frequency is not
    if frequency.verdict == AGREES and large and amplitude.verdict != DIFFERS:
        judged = replace(judged, frequency=replace(frequency, verdict=amplitude.verdict, reasons=amplitude.reasons))
    if amplitude.verdict == AGREES and far:
        judged = replace(judged, amplitude=replace(amplitude, verdict=frequency.verdict, reasons=frequency.reasons))
    return judged
