"""One comparison of a simulated value with a predicted one, and its verdict with its reasons.

A difference beyond the tolerance is excused only by a named effect whose computed size covers it.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from rsc.measure.reasons import Code, Reason
from rsc.measure.windows import LEAST_PERIODS, Features
from rsc.measure.words import AGREES, DIFFERS, NO_PREDICTION, NOT_RESOLVED, OUTSIDE, SYNCHRONOUS, TOLERANCES

# a prediction that may be wrong by this share is none
VOID = 1.0

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


def row_of(features: Features, i: int, quantity: str, values: tuple[float, float], **more: Any) -> Row:
    """A row of simulated and predicted value, with its verdict, by, branch and reasons as far as they are given."""
    simulated, predicted = float(values[0]), float(values[1])
    difference = simulated / predicted - 1.0 if predicted else math.nan
    window = float(features.speed[i]), float(features.time[i]), float(features.share[i])
    return Row(quantity, *window, simulated, predicted, difference, **{"verdict": "", "by": "", "branch": "", **more})


def judged(features: Features, i: int, row: Row, effects: Effects, otherwise: Verdict = (DIFFERS, ())) -> Row:
    """A row with its verdict; `otherwise`: verdict and reasons of a difference that no effect covers."""
    line = row.speed if row.quantity == SYNCHRONOUS else features.frequency[i]
    if features.window * abs(line) < LEAST_PERIODS:
        return replace(row, verdict=NOT_RESOLVED, reasons=few_periods(features, line))
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


def few_periods(features: Features, line: float) -> tuple[Reason, ...]:
    """The reason "too few periods of the line in the window"; line in Hz."""
    return (Reason(Code.FEW_PERIODS, numbers=(float(features.window * abs(line)),)),)


def with_reason(row: Row, reason: Reason, **more: Any) -> Row:
    """The row with one more reason."""
    return replace(row, reasons=(*row.reasons, reason), **more)
