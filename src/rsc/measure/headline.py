"""A run in one sentence: how well simulation and prediction agree; and where its unbalance line is largest on each whirl."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rsc.measure.changes import Transition
from rsc.measure.verdict import Row
from rsc.measure.windows import ROLL
from rsc.measure.words import (
    AGREES,
    AMPLITUDE,
    DIFFERS,
    FREQUENCY,
    NO_WHIRL,
    NOT_RESOLVED,
    SYNCHRONOUS,
    TOLERANCES,
    VERDICTS,
    percent,
)

PLURALS = {FREQUENCY: "frequencies", AMPLITUDE: "amplitudes", SYNCHRONOUS: "windows"}


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
    verdicts = [row.verdict for row in _of(rows, FREQUENCY)]
    backward = [verdict not in (NO_WHIRL, NOT_RESOLVED) for verdict in verdicts]
    own = {q: [row.verdict for row, on in zip(_of(rows, q), backward, strict=True) if on] for q in (FREQUENCY, AMPLITUDE)}
    off = [row for row, verdict in zip(_of(rows, SYNCHRONOUS), verdicts, strict=True) if verdict == NO_WHIRL and row.by]
    parts = []
    if any(backward):
        frequencies, amplitudes = (f"in {q.split()[1]} (within {percent(TOLERANCES[q])})" for q in own)
        counts = [values.count(AGREES) for values in own.values()]
        told = f"{counts[0]} agree with the prediction {frequencies}, {counts[1]} {amplitudes}"
        parts.append(f"of {sum(backward)} windows with a backward line {told}{_others(own)}")
    if off:
        lines = [row.verdict for row in off]
        agree = f"{lines.count(AGREES)} of {len(lines)}"
        within = percent(TOLERANCES[SYNCHRONOUS])
        text = f"without a backward line {agree} windows agree in the line at the rotor speed (within {within})"
        parts.append(text + _others({SYNCHRONOUS: lines}))
    if NOT_RESOLVED in verdicts:
        parts.append(f"{verdicts.count(NOT_RESOLVED)} of {len(verdicts)} windows cannot be compared (not resolved)")
    return "; ".join(parts) or "no window to compare"


def _others(own: dict[str, list[str]]) -> str:
    """The verdicts that do not agree, counted."""
    parts = []
    for quantity, verdicts in own.items():
        counted = [f"{verdicts.count(v)} {v}" for v in VERDICTS if v != AGREES and v in verdicts]
        parts += [f"other {PLURALS[quantity]}: {', '.join(counted)}"] if counted else []
    return "".join(f"; {part}" for part in parts)


def _of(rows: Sequence[Row], quantity: str) -> list[Row]:
    return [row for row in rows if row.quantity == quantity]


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
    """Speed and height of the largest value, by a parabola through it and its neighbours; None at an end, a gap, a hold or where
    the speed turns round."""
    i = int(np.nanargmax(line)) if np.isfinite(line).any() else 0
    if not 0 < i < len(line) - 1 or not np.isfinite(line[i - 1 : i + 2]).all() or np.diff(speeds[i - 1 : i + 2]).prod() <= 0.0:
        return None
    bend, slope, height = np.polyfit(speeds[i - 1 : i + 2] - speeds[i], line[i - 1 : i + 2], 2)
    at = -0.5 * slope / bend if bend < 0.0 else 0.0
    return float(speeds[i] + at), float(height + slope * at + bend * at * at)
