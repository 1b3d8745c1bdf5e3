"""Simulated features against predicted whirls: three comparisons of every window, with the best prediction at hand (`Best`)."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rsc.measure.kinds import Kind, ProbeKind
from rsc.measure.reasons import Code, Reason
from rsc.measure.transients import leaving, settling
from rsc.measure.verdict import (
    ALONE,
    BALANCE,
    ELLIPTIC,
    FIRST_ORDER,
    ROLLS,
    RUB,
    Effects,
    Verdict,
    Window,
    few_periods,
    judged,
    row_of,
    with_reason,
)
from rsc.measure.window_length import sweep_loss
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
    SYNCHRONOUS,
    TOLERANCES,
)

# a term of second order may have a coefficient of this size
ORDER_ONE = 4.0
# a line whose frequency or amplitude is further from the whirl than this is not that of the whirl, whatever else fits
SAME_LINE = {FREQUENCY: 0.02, AMPLITUDE: 0.3}


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
    return [_without_coincidences(window) for window in leaving(settling(features, growth, upset, windows))]


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
        row = row_of(features, i, quantity, values, by=by, branch=pair.branch.label)
        row = judged(features, i, row, effects, otherwise)
        if by_stator and quantity == AMPLITUDE:
            row = with_reason(row, Reason(Code.OF_STATOR))
        if row.verdict == AGREES and not pair.whirl.decays:
            row = with_reason(row, Reason(Code.UNSTABLE))
        rows.append(row)
    return Window(*rows)


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
    line = max(float(features.size[i]), 1e-300)  # the samples may show no line of the whirl
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
        row = row_of(features, i, quantity, (simulated[i], predicted[i]), by=ROLLS, branch=ROLL)
        row = judged(features, i, row, [_beside(features, i), ("motion during the window", moving)])
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
    frequency = row_of(features, i, FREQUENCY, (features.frequency[i], math.nan), **why)
    amplitude = row_of(features, i, AMPLITUDE, (features.amplitude[i], math.nan), **why)
    motion, by = _steady_motion(features, i, steady)
    if not motion[i] > 0.0:
        return Window(frequency, amplitude, row_of(features, i, SYNCHRONOUS, (features.synchronous[i], math.nan), **why))
    if share == 0.0 and steady.moving[i] > 0.0:
        row = row_of(features, i, SYNCHRONOUS, (features.synchronous[i], steady.moving[i]), by=ALONE)
        return Window(frequency, amplitude, judged(features, i, row, []))
    before, after = max(i - 1, 0), min(i + 1, last)
    change = np.ptp(motion[before : after + 1]) / motion[i]  # of all three: at a resonance the two beside are alike
    if after > before:
        rate = np.diff(features.speed[[before, after]]) / np.diff(features.time[[before, after]])
        change += sweep_loss(float(rate[0]), features.window)
    row = row_of(features, i, SYNCHRONOUS, (features.synchronous[i], motion[i]), by=by)
    row = judged(features, i, row, [("motion during the window", float(np.nan_to_num(change)))])
    return Window(frequency, amplitude, row)


def _steady_motion(features: Features, i: int, steady: Steady) -> tuple[np.ndarray, str]:
    """The predicted motions (n_w,) that turn with the shaft of the kind of window i, and its word; of a measured window that
    reaches the gap the nearer one, since probes do not show contact."""
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
        return NOT_RESOLVED, few_periods(features, line)[0]
    if kind == Kind.ROLLING:
        return NO_PREDICTION, Reason(Code.ROLLS_BY_NONE, numbers=(float(features.rolling[i]),))
    return NO_PREDICTION, Reason(Code.BY_NONE, (kind,), (share if share == share else 1.0,))


def _without_coincidences(window: Window) -> Window:
    """A window in which frequency and amplitude agree only where the other one can be that of the same line, too."""
    frequency, amplitude = window.frequency, window.amplitude
    far, large = (abs(row.difference) > SAME_LINE[row.quantity] for row in (frequency, amplitude))
    kept = window
    # a whirl of another amplitude than predicted is still that whirl, one of another frequency is not
    if frequency.verdict == AGREES and large and amplitude.verdict != DIFFERS:
        kept = replace(kept, frequency=replace(frequency, verdict=amplitude.verdict, reasons=amplitude.reasons))
    if amplitude.verdict == AGREES and far:
        kept = replace(kept, amplitude=replace(amplitude, verdict=frequency.verdict, reasons=frequency.reasons))
    return kept
