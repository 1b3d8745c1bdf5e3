"""Even times from those that a file has: gaps, repeated times and rounded ones."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError

LEAST_SAMPLES = 64
JITTER = 0.05  # of a sample interval, from which the times of samples are told to be uneven
RATES = (1e-3, 1e9)  # samples a second that a measurement may have
_GAP = 1.5  # sample intervals from which samples are missing
_MOST_DECIMALS = 9
_COARSE = 0.02  # of a sample interval, from which the last decimal of rounded times matters
_MANY = 0.01  # part of the samples that repeat the time before, from which they are not left out


class Even(NamedTuple):
    """Even times: s of the first, s between two, how many, the place of every row among them (-1 of one that repeats a time), and
    what to tell."""

    start: float
    step: float
    samples: int
    place: Any
    told: list[str]


def evenly(start: float, step: float, count: int, source: str) -> Even:
    """The times of samples that are even."""
    refuse_few(count, source)
    refuse_impossible(1.0 / step, source)
    return Even(start, step, count, np.arange(count), [])


def even_times(raw: NDArray[np.float64], unit: float, source: str) -> Even:
    """The even times behind those of a file, `raw` in units of `unit` seconds."""
    length = len(raw)
    refuse_few(length, source)
    if not np.isfinite(raw).all():
        raise DataError(source, f"has a time that is no number, in row {int(np.argmin(np.isfinite(raw))) + 1} of its numbers")
    steps = np.diff(raw)
    if (steps < 0.0).any():
        raise DataError(source, f"has times that go back, behind row {int(np.argmax(steps < 0.0)) + 1} of its numbers")
    rounded = _rounded(raw, steps)
    if rounded is not None:
        start, step, words = rounded
        refuse_impossible(1.0 / (step * unit), source)
        rate = f"{1.0 / (step * unit):.6g} samples a second"
        return Even(start * unit, step * unit, length, np.arange(length), [f"{words}: taken as even, {rate}"])
    keep = np.concatenate([[True], steps > 0.0])
    told: list[str] = []
    repeated = int(np.count_nonzero(~keep))
    if repeated:
        told.append(f"{repeated} samples repeat the time before: left out")
    times = raw[keep] * unit
    steps = np.diff(times)
    usual = float(np.median(steps)) if steps.size else 0.0
    inside = steps < _GAP * usual
    if len(times) < LEAST_SAMPLES or not inside.any():
        raise DataError(source, f"has fewer than {LEAST_SAMPLES} different times")
    step = float(steps[inside].mean())
    refuse_impossible(1.0 / step, source)
    places = np.concatenate([[0.0], np.cumsum(np.maximum(np.round(steps / step), 1.0))])
    missing = places[-1] + 1.0 - len(places)
    if not places[-1] <= 4 * length:
        raise DataError(source, f"lacks {missing:.3g} samples between its first and its last time: more than it has")
    if repeated > _MANY * length:
        problem = f"{repeated} of {length} samples repeat the time before, and fit no even times that were rounded"
        raise DataError(source, f"{problem}: give measured.rate instead of measured.time")
    place = np.full(length, -1)
    place[keep] = places
    if missing:
        gaps = f"{np.count_nonzero(~inside)} gaps of up to {steps.max():.3g} s"
        told.append(f"{missing:.0f} samples are missing, in {gaps}: windows on them are empty")
    uneven = float(np.abs(steps[inside] / step - 1.0).max())
    if uneven > JITTER:
        told.append(f"its times are uneven by up to {100.0 * uneven:.0f} % of a sample: taken as even")
    return Even(float(times[0]), step, int(place.max()) + 1, place, told)


def _rounded(raw: NDArray[np.float64], steps: NDArray[np.float64]) -> tuple[float, float, str] | None:
    """(first time, step, what to tell) of times that are even but for their last decimal, which is coarse beside a step; None of
    others.

    A row that is missing makes a step that rounding cannot make, or bends the line through the times by more than a decimal.
    """
    if len(raw) < LEAST_SAMPLES or not np.ptp(raw) > 0.0:
        return None
    row = np.arange(len(raw)) - 0.5 * (len(raw) - 1)
    mean = float(raw.mean())
    step = float(row @ (raw - mean) / (row @ row))
    largest = float(np.abs(raw).max())
    for decimals in range(_MOST_DECIMALS + 1):
        last = 10.0**-decimals
        if last < _COARSE * step:
            return None
        counted = raw / last
        if np.abs(counted - np.round(counted)).max() < max(1e-4, 4e-16 * largest / last):
            break
    else:
        return None
    apart = raw - mean - step * row
    even = np.ptp(apart) <= 1.05 * last and np.abs(steps - step).max() < 1.001 * last
    if not even or np.ptp(steps) < 0.5 * last:  # rounding changes nothing of these
        return None
    repeated = np.count_nonzero(steps < 0.5 * last)
    told = f"its times are rounded to {decimals} decimals" + (f", {repeated} repeat the one before" if repeated else "")
    return mean + step * float(row[0]), step, told


def refuse_few(count: int, source: str) -> None:
    """Refuse a run of too few samples."""
    if count < LEAST_SAMPLES:
        raise DataError(source, f"has {count} samples; at least {LEAST_SAMPLES} make a run")


def refuse_impossible(rate: float, source: str) -> None:
    """Refuse a rate that no measurement has."""
    if not RATES[0] <= rate <= RATES[1]:
        raise DataError(source, f"has {rate:.3g} samples a second; {RATES[0]:g} to {RATES[1]:g} can be a measurement")
