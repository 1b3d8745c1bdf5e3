"""Simulated features against predicted whirls: a row and a verdict per window and quantity.

A window is compared with the best prediction at hand (`Best`). A difference beyond the tolerance is excused only by a named
effect whose computed size covers it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rsc.measure.changes import MOST_FOLDS
from rsc.measure.kinds import Kind
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
    percent,
)

# a term of second order may have a coefficient of this size
ORDER_ONE = 4.0
# a prediction that may be wrong by this share is none
VOID, TOO_FAR = 1.0, "too far from a steady motion"
# a line whose frequency or amplitude is further from the whirl than this is not that of the whirl, whatever else fits
SAME_LINE = {FREQUENCY: 0.02, AMPLITUDE: 0.3}
# windows at the beginning of a stretch on one whirl that show how far the motion was from it
FIRST = 3
# a motion that leaves a whirl is so many times as far from it as it was
LEAVES = 1.2

# what a prediction was made with
BALANCE, FIRST_ORDER, ROLLS, ALONE, RUB = "balance", "first order", "rolling", "without contact", "forward rub"
UNSTABLE, DEPARTURE = "unstable there", "departure from an unstable whirl"
OF_STATOR = "of the stator"  # of an amplitude: the stator moves more than the rotor
ELLIPTIC = "elliptic"  # balance of a whirl without unbalance in supports whose directions differ

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
    note: str


def compare(
    features: Features,
    branches: Sequence[BranchLike],
    steady: Steady,
    rolls: Rolls | None = None,
    best: Best | None = None,
    load: float = 0.0,
) -> list[Row]:
    """Frequency and amplitude of the whirl and the synchronous line of every window, beside their predictions.

    Parameters
    ----------
    features : Features
    branches : list of rsc.analysis.lines.branches.Branch
    steady : Steady
    rolls : Rolls, optional
    best : Best, optional
        Default: the first order in the unbalance everywhere.
    load : float, m
        Deflection at the contact by a constant load, which no prediction has.

    Returns
    -------
    list of Row, three a window
    """
    pairs = followed(features, branches, rolls)
    growth = np.full(len(pairs), np.nan)
    rows: list[Row] = []
    for i, pair in enumerate(pairs):
        on_whirl = features.on_whirl(i)
        if pair is not None:
            rows += _whirl_rows(features, i, pairs, best, load)
            growth[i] = pair.whirl.growth_rate
        elif rolls is not None and on_whirl and not math.isnan(rolls.frequency[i]) and not features.too_fast(i):
            rows += _roll_rows(features, i, rolls)
            growth[i] = rolls.growth_rate[i]
        else:
            rows += _rows_off_whirl(features, i, steady)
            growth[i] = steady.growth_rate[i]
    upset = np.zeros(len(pairs), dtype=bool) if best is None else best.reached < 1.0
    return _without_coincidences(_leaving(_settling(features, growth, upset, rows)))


def _row(features: Features, i: int, quantity: str, values: tuple[float, float], words: tuple[str, str, str, str]) -> Row:
    """A row of simulated and predicted value, with the words verdict, by, branch, note."""
    simulated, predicted = float(values[0]), float(values[1])
    difference = simulated / predicted - 1.0 if predicted else math.nan
    window = float(features.speed[i]), float(features.time[i]), float(features.share[i])
    return Row(quantity, *window, simulated, predicted, difference, *words)


def _judged(features: Features, i: int, row: Row, effects: Effects, otherwise: tuple[str, str] = (DIFFERS, "")) -> Row:
    """A row with its verdict; `otherwise`: verdict and note of a difference that no effect covers."""
    line = row.speed if row.quantity == SYNCHRONOUS else features.frequency[i]
    if features.window * abs(line) < LEAST_PERIODS:
        return replace(row, verdict=NOT_RESOLVED, note=_periods(features, line))
    if math.isnan(row.difference):
        return replace(row, verdict=NO_PREDICTION)
    if abs(row.difference) <= TOLERANCES[row.quantity]:
        return replace(row, verdict=AGREES)
    void = [f"{name} ({percent(size)})" for name, size in effects if size >= VOID]
    if void:
        return replace(row, verdict=NO_PREDICTION, note=f"{TOO_FAR}: {', '.join(void)}")
    covering = [f"{name} ({percent(size)})" for name, size in effects if abs(row.difference) <= size]
    if covering:
        return replace(row, verdict=OUTSIDE, note=f"covered by {', '.join(covering)}")
    return replace(row, verdict=otherwise[0], note=otherwise[1])


def _periods(features: Features, line: float) -> str:
    return f"{features.window * abs(line):.1f} periods in a window"


def _whirl_rows(features: Features, i: int, pairs: Sequence[Followed | None], best: Best | None, load: float) -> list[Row]:
    """The three rows of a window that follows a predicted whirl; the amplitude is that of the body that moves more."""
    pair = pairs[i]
    if pair is None:
        return []
    by_stator = bool(features.stator_amplitude[i] > features.amplitude[i])
    amplitude = features.stator_amplitude[i] if by_stator else features.amplitude[i]
    measured = (features.frequency[i], amplitude, features.synchronous[i])
    predicted = _predicted(pair.whirl, best, i, by_stator)
    by = BALANCE if best is not None and not math.isnan(best.synchronous[i]) else FIRST_ORDER
    if best is not None and pair.whirl.mirror is not None:
        by = ELLIPTIC
    otherwise = (DIFFERS, "")
    if best is not None and best.reached[i] < 1.0:
        cause = "unbalance" if by != ELLIPTIC else "difference of the directions"
        otherwise = (NO_PREDICTION, f"no steady whirl with more than {100 * best.reached[i]:.0f} % of the {cause}")
    rows = []
    for quantity, values in zip(TOLERANCES, zip(measured, predicted, strict=True), strict=True):
        effects = [*_second_order(features, i, pair, best, load), _moving(features, i, pairs, best, quantity)]
        row = _row(features, i, quantity, values, ("", by, pair.branch.label, ""))
        row = _judged(features, i, row, effects, otherwise)
        notes = [row.note] if row.note else []
        notes += [OF_STATOR] if by_stator and quantity == AMPLITUDE else []
        notes += [f"the whirl is {UNSTABLE}"] if row.verdict == AGREES and not pair.whirl.stable else []
        rows.append(replace(row, note="; ".join(notes)))
    return rows


def _predicted(whirl: Any, best: Best | None, i: int, by_stator: bool) -> tuple[float, float, float]:
    """Frequency, amplitude and synchronous line by the best prediction at hand."""
    first = whirl.stator_amplitude if by_stator else whirl.rotor_amplitude
    values = [whirl.frequency, first, whirl.synchronous.consistent.amplitude]
    if best is not None:
        better = (best.frequency, best.stator_amplitude if by_stator else best.amplitude, best.synchronous)
        values = [float(b[i]) if not math.isnan(b[i]) else v for v, b in zip(values, better, strict=True)]
    return values[0], values[1], values[2]


def _second_order(features: Features, i: int, pair: Followed, best: Best | None, load: float) -> Effects:
    """Parts of the motion that a prediction takes as small or leaves out, and what their squares can make."""
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
    """What a window makes of a range of speeds: the predicted change, and what a line that moves loses of its amplitude."""
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


def _roll_rows(features: Features, i: int, rolls: Rolls) -> list[Row]:
    """The three rows of a window whose whirl rolls."""
    by_stator = bool(features.stator_amplitude[i] > features.amplitude[i])
    bodies = (features.stator_amplitude, rolls.stator_amplitude) if by_stator else (features.amplitude, rolls.amplitude)
    rows = []
    lines = (features.frequency, rolls.frequency), bodies, (features.synchronous, rolls.synchronous)
    for quantity, (simulated, predicted) in zip(TOLERANCES, lines, strict=True):
        neighbours = predicted[max(i - 1, 0) : i + 2]
        neighbours = neighbours[np.isfinite(neighbours)]
        moving = float(np.ptp(neighbours)) / abs(float(predicted[i])) if len(neighbours) and predicted[i] else 0.0
        moving += float(np.nan_to_num(rolls.loss[i])) if quantity == AMPLITUDE else 0.0
        row = _row(features, i, quantity, (simulated[i], predicted[i]), ("", ROLLS, ROLL, ""))
        row = _judged(features, i, row, [_beside(features, i), ("motion during the window", moving)])
        how = "rolls" if rolls.growth_rate[i] < 0.0 else f"rolls, {UNSTABLE}"
        how += f", {OF_STATOR}" if by_stator and quantity == AMPLITUDE else ""
        rows.append(replace(row, note=f"{how}; {row.note}" if row.note else how))
    return rows


def _rows_off_whirl(features: Features, i: int, steady: Steady) -> list[Row]:
    """The three rows of a window on no predicted whirl; its synchronous line may be that of another motion."""
    share, last = float(features.share[i]), len(features.speed) - 1
    verdict, note = _without_whirl(features, i)
    words = (verdict, "", "", note)
    measured = {FREQUENCY: features.frequency[i], AMPLITUDE: features.amplitude[i]}
    rows = [_row(features, i, quantity, (value, math.nan), words) for quantity, value in measured.items()]
    predictions = {Kind.NO_CONTACT: (steady.alone, ALONE), Kind.FORWARD_RUB: (steady.rub, RUB)}
    motion, by = predictions.get(features.kind[i], (np.full(last + 1, np.nan), ""))
    if not motion[i] > 0.0:
        return [*rows, _row(features, i, SYNCHRONOUS, (features.synchronous[i], math.nan), words)]
    if share == 0.0 and steady.moving[i] > 0.0:
        row = _row(features, i, SYNCHRONOUS, (features.synchronous[i], steady.moving[i]), ("", ALONE, "", ""))
        return [*rows, _judged(features, i, row, [])]
    before, after = max(i - 1, 0), min(i + 1, last)
    change = np.ptp(motion[before : after + 1]) / motion[i]  # of all three: at a resonance the two beside are alike
    if after > before:
        rate = np.diff(features.speed[[before, after]]) / np.diff(features.time[[before, after]])
        change += sweep_loss(float(rate[0]), features.window)
    row = _row(features, i, SYNCHRONOUS, (features.synchronous[i], motion[i]), ("", by, "", ""))
    return [*rows, _judged(features, i, row, [("motion during the window", float(np.nan_to_num(change)))])]


def _without_whirl(features: Features, i: int) -> tuple[str, str]:
    """Verdict and note of a window that lies on no predicted whirl."""
    share, line = features.share[i], features.frequency[i]
    if features.kind[i] == Kind.NOT_RESOLVED:
        return NOT_RESOLVED, str(features.why[i])
    if not features.on_whirl(i):
        return NO_WHIRL, "" if features.kind[i] in (Kind.NO_CONTACT, Kind.FORWARD_RUB) else str(features.kind[i])
    if features.too_fast(i):
        return NOT_RESOLVED, f"contact turns at {features.turning[i]:.4g} Hz, beyond half of output.rate = {features.rate:g} Hz"
    if features.window * abs(line) < LEAST_PERIODS:
        return NOT_RESOLVED, _periods(features, line)
    if features.kind[i] == Kind.ROLLING:
        return NO_PREDICTION, f"rolls for {100 * features.rolling[i]:.0f} % of the time, near no whirl that is predicted to"
    bounces = f", contact for {100 * share:.0f} % of the time" if share < 1.0 else ""
    return NO_PREDICTION, f"{features.kind[i]} near no predicted one{bounces}"


def _settling(features: Features, growth: np.ndarray, upset: np.ndarray, rows: Sequence[Row]) -> list[Row]:
    """Rows with those that differ while a motion decays towards its whirl, or leaves an unstable one, at the predicted rate.

    growth : (n_w,) 1/s, of small disturbances of the whirl that each window follows, or of its motion without one
    upset : (n_w,) bool, where there is no steady whirl with so much unbalance: behind it the motion begins anew
    """
    judged, count = list(rows), len(TOLERANCES)
    for n, row in enumerate(rows):
        if row.branch and row.verdict in (DIFFERS, NO_PREDICTION):
            judged[n] = _not_yet_steady(features, growth, upset, row, rows[n % count : n : count])
            alone = row.quantity == SYNCHRONOUS and not any(DEPARTURE in own.note for own in judged[n - 2 : n])
            judged[n] = row if alone and DEPARTURE in judged[n].note else judged[n]
        elif row.by in (ALONE, RUB) and row.verdict in (DIFFERS, NO_PREDICTION):
            judged[n] = _rings_down(features, growth, row, rows[n % count : n : count])
    return judged


def _rings_down(features: Features, growth: np.ndarray, row: Row, earlier: Sequence[Row]) -> Row:
    """The row of a window without a whirl, as one that settles if what start, knock or contact left of small motions covers it.

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
    told = f"decays at {-own[-1]:.2g} 1/s since {features.time[first]:.4g} s"
    if abs(row.difference) <= remains:
        note = f"{told}, up to {percent(remains)} remain"
        return replace(row, verdict=NOT_YET_STEADY, note=f"{row.note}; {note}" if row.note else note)
    if len(known) < FIRST:
        return replace(row, verdict=NO_PREDICTION, note=f"{TOO_FAR}: {told}")
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
        note = f"decays at {-own[-1]:.2g} 1/s since {features.speed[first]:.4g} Hz, up to {percent(remains)} remain"
        return replace(row, verdict=NOT_YET_STEADY, note=f"{row.note}; {note}" if row.note else note)
    if TOO_FAR in row.note:
        return row
    grows = (folds > 0.0) & np.isfinite(differed)
    grown = float(np.max(differed[grows] * np.exp(np.minimum(folds[grows], MOST_FOLDS)), initial=0.0))
    if not abs(row.difference) <= grown:
        return row
    if grown >= VOID:
        return replace(row, verdict=NO_PREDICTION, note="near a whirl that is unstable and must have been left")
    if not (differed[grows] < abs(row.difference) / LEAVES).any():
        return row
    note = f"covered by {DEPARTURE} (at {own[-1]:.2g} 1/s up to {percent(grown)})"
    return replace(row, verdict=OUTSIDE, note=f"{row.note}; {note}" if row.note else note)


def _leaving(rows: Sequence[Row]) -> list[Row]:
    """Rows that tell of an unstable whirl that it is not yet left, where the run leaves it later."""
    judged, left = list(rows), False
    for n in reversed(range(len(rows))):
        left |= rows[n].branch != rows[-1].branch or DEPARTURE in rows[n].note
        if left:
            judged[n] = replace(rows[n], note=rows[n].note.replace(UNSTABLE, f"{UNSTABLE} and not yet left"))
    return judged


def _without_coincidences(rows: Sequence[Row]) -> list[Row]:
    """Rows in which frequency and amplitude agree only where the other one can be that of the same line, too."""
    judged = list(rows)
    for first in range(0, len(rows), len(TOLERANCES)):
        for own, other in ((first, first + 1), (first + 1, first)):
            far = abs(rows[other].difference) > SAME_LINE.get(rows[other].quantity, math.inf)
            # a whirl of another amplitude than predicted is still that whirl, one of another frequency is not
            if rows[own].verdict == AGREES and far and (own > first or rows[other].verdict != DIFFERS):
                judged[own] = replace(rows[own], verdict=rows[other].verdict, note=rows[other].note)
    return judged
