"""What a reader wants first: whether the machine whirls, what changes, and how well simulation and prediction agree."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from rsc.measure.changes import Transition
from rsc.measure.verdict import Row
from rsc.measure.windows import FORWARD, ROLL
from rsc.measure.words import AGREES, AMPLITUDE, DIFFERS, FREQUENCY, NO_WHIRL, SYNCHRONOUS, TOLERANCES, VERDICTS, percent


@dataclass(frozen=True)
class Resonance:
    """The unbalance line on one whirl where it is largest inside the stretch that the run has that whirl.

    branch : label of the whirl
    speed, height : float Hz and m, simulated
    predicted_speed, predicted_height : float Hz and m, with the whole unbalance (harmonic balance) where that was found
    first_order_speed, first_order_height : float Hz and m, to first order in the unbalance
    """

    branch: str
    speed: float
    height: float
    predicted_speed: float
    predicted_height: float
    first_order_speed: float
    first_order_height: float


def headline(rows: Sequence[Row], transitions: Sequence[Transition], status: str, gap: float, force: float) -> list[str]:
    """Three lines on a run: its backward whirl, its changes of whirl, and the verdict (`summary`).

    Parameters
    ----------
    rows, transitions : of `rsc.measure.verdict.compare`
    status : str, how the run ended
    gap : float, m
    force : float, N, largest normal force of the run
    """
    return [_whirl_line(rows, gap, force), _change_line(transitions), "verdict: " + summary(rows, transitions, status)]


def _whirl_line(rows: Sequence[Row], gap: float, force: float) -> str:
    windows = [window for window in _windows(rows) if window[0].verdict != NO_WHIRL]
    # beside a larger forward motion, one that rubs or bounces, a backward line is no whirl
    whirling = [window for window in windows if not window[2].simulated > FORWARD * window[1].simulated]
    largest = f"normal force up to {force:.3g} N"
    if not whirling:
        share = np.mean([row.contact for row in _of(rows, FREQUENCY)])
        beside = max((amplitude.simulated / gap for _, amplitude, _ in windows), default=0.0)
        lines = f"; backward lines up to {beside:.2f} gaps beside the forward motion" if windows else ""
        contact = f"; contact for {percent(float(share))} of the time" + (f", {largest}" if share > 0.0 else "")
        return f"no backward whirl{lines}{contact}"
    speeds, lines_there = ([getattr(row, name) for row, *_ in whirling] for name in ("speed", "simulated"))
    size = max(amplitude.simulated for _, amplitude, _ in whirling)
    kind = ", rolling" if any(row.branch == ROLL for row, *_ in whirling) else ""
    seconds = f" ({whirling[0][0].time:.3g} to {whirling[-1][0].time:.3g} s)" if np.ptp(speeds) == 0.0 else ""
    band = f"{_range(lines_there, '.1f')} Hz"
    where = f"{_range(speeds, '.1f')} Hz ({_range([60.0 * speed for speed in speeds], '.0f')} rpm){seconds}"
    length = f"{1e3 * size:.3g} mm" if size >= 1e-3 else f"{1e6 * size:.3g} um"
    return (
        f"backward whirl{kind} at rotor speeds of {where}: {band}, amplitude up to {size / gap:.2f} gaps "
        f"({length}), {largest}"
    )


def _range(values: Iterable[float], form: str) -> str:
    values = list(values)
    low, high = format(min(values), form), format(max(values), form)
    return low if low == high else f"{low} to {high}"


def _change_line(transitions: Sequence[Transition]) -> str:
    if not transitions:
        return "no change of whirl"
    parts = []
    for t in transitions:
        names = f"{f'whirl {t.before}' if t.before else 'no whirl'} to {f'whirl {t.after}' if t.after else 'no whirl'}"
        jump = f" and left at {t.predicted_jump:.1f} Hz" if t.predicted_jump == t.predicted_jump else ""
        end = f" (predicted to end at {t.predicted:.1f} Hz{jump})" if t.predicted == t.predicted else ""
        parts.append(f"{names} at {t.taken_over:.1f} Hz{end}")
    return "changes: " + "; ".join(parts)


def summary(rows: Sequence[Row], transitions: Sequence[Transition], status: str) -> str:
    """One sentence on how well simulation and prediction agree over the run, in windows and quantities."""
    counts = _counted(rows)
    if status == "out of assumptions":
        return f"the run left the one-sided friction law's assumption of sliding forward (12): {counts}"
    if status != "finished":
        return f"the run stopped early ({status}): {counts}"
    if any(t.verdict == DIFFERS for t in transitions):
        return f"simulation and prediction disagree on a change of whirl: {counts}"
    return counts


def _counted(rows: Sequence[Row]) -> str:
    """How many windows agree in which quantity, and what the others say."""
    backward = [row.verdict != NO_WHIRL for row in _of(rows, FREQUENCY)]
    own = {q: [row.verdict for row, on in zip(_of(rows, q), backward, strict=True) if on] for q in (FREQUENCY, AMPLITUDE)}
    lines = [row for row, on in zip(_of(rows, SYNCHRONOUS), backward, strict=True) if not on and row.by]
    parts = []
    if any(backward):
        agree = ", ".join(
            f"{verdicts.count(AGREES)} in {quantity.split()[1]} (within {percent(TOLERANCES[quantity])})"
            for quantity, verdicts in own.items()
        )
        parts.append(f"of {sum(backward)} windows with a backward line prediction and simulation agree for {agree}{_others(own)}")
    if lines:
        agree = f"{sum(row.verdict == AGREES for row in lines)} of {len(lines)}"
        within = percent(TOLERANCES[SYNCHRONOUS])
        parts.append(f"without a backward line {agree} windows agree in the line at the rotor speed (within {within})")
    return "; ".join(parts) or "no window to compare"


def _others(own: dict[str, list[str]]) -> str:
    """The verdicts of whirls that do not agree, counted."""
    parts = []
    for quantity, verdicts in own.items():
        counted = [f"{verdicts.count(v)} {v}" for v in VERDICTS if v != AGREES and v in verdicts]
        parts += [f"{quantity.split()[1]} of the others: {', '.join(counted)}"] if counted else []
    return "".join(f"; {part}" for part in parts)


def _of(rows: Sequence[Row], quantity: str) -> list[Row]:
    return [row for row in rows if row.quantity == quantity]


def _windows(rows: Sequence[Row]) -> list[Sequence[Row]]:
    """The rows of every window: frequency, amplitude, synchronous line."""
    return [rows[i : i + len(TOLERANCES)] for i in range(0, len(rows), len(TOLERANCES))]


def resonances(rows: Sequence[Row], first_order: Sequence[float]) -> list[Resonance]:
    """Where the unbalance line is largest on each whirl of a run, by the speed of the windows.

    Parameters
    ----------
    rows : list of Row
    first_order : (n_w,) m, the line to first order at every window
    """
    lines: dict[str, list[tuple[Row, float]]] = {}
    for row, first in zip(_of(rows, SYNCHRONOUS), first_order, strict=True):
        if row.branch not in ("", ROLL):
            lines.setdefault(row.branch, []).append((row, first))
    peaks = []
    for branch, own in lines.items():
        speeds = np.array([row.speed for row, _ in own])
        heights = [[row.simulated for row, _ in own], [row.predicted for row, _ in own], [first for _, first in own]]
        tops = [_peak(speeds, np.array(height)) for height in heights]
        if tops[0] and tops[1] and tops[2]:
            peaks.append(Resonance(branch, *tops[0], *tops[1], *tops[2]))
    return peaks


def _peak(speeds: np.ndarray, line: np.ndarray) -> tuple[float, float] | None:
    """Speed and height of the largest value, by a parabola through it and its neighbours; None at an end, a gap or a hold."""
    i = int(np.nanargmax(line)) if np.isfinite(line).any() else 0
    if not 0 < i < len(line) - 1 or not np.isfinite(line[i - 1 : i + 2]).all() or (np.diff(speeds[i - 1 : i + 2]) == 0.0).any():
        return None
    bend, slope, height = np.polyfit(speeds[i - 1 : i + 2] - speeds[i], line[i - 1 : i + 2], 2)
    at = -0.5 * slope / bend if bend < 0.0 else 0.0
    return float(speeds[i] + at), float(height + slope * at + bend * at * at)
