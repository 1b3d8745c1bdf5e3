"""Where the unbalance line of a run is largest on each whirl."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rsc.measure.verdict import Row, Window
from rsc.measure.windows import ROLL


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


def resonances(windows: Sequence[Window], first_order: Sequence[float]) -> list[Resonance]:
    """Where the unbalance line is largest on each whirl of a run, by the speed of the windows.

    Parameters
    ----------
    windows : list of Window
    first_order : (n_w,) m, the line to first order at every window
    """
    lines: dict[str, list[tuple[Row, float]]] = {}
    for window, first in zip(windows, first_order, strict=True):
        row = window.synchronous
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
