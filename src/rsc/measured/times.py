"""Even times from those that a file has: gaps, repeated times and rounded ones."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError

LEAST_SAMPLES = 64
JITTER = 0.05  # of a sample interval, from which the times of samples are told to be uneven
RATES = (1e-3, 1e9)  # samples a second that a measurement may have
_GAP = 1.5  # sample intervals from which samples are missing
_MOST_DIGITS = 9  # of a time
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
        raise DataError(source, f"has decreasing times, after row {int(np.argmax(steps < 0.0)) + 1} of its numbers")
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
    """(first time, step, what to tell) of times that are even but for their last digit, which is coarse beside a step; None of
    others.

    A row that is missing makes a step that rounding cannot make, or bends the line through the times by more than a digit.
    """
    if len(raw) < LEAST_SAMPLES or not np.ptp(raw) > 0.0:
        return None
    row = np.arange(len(raw)) - 0.5 * (len(raw) - 1)
    mean = float(raw.mean())
    step = float(row @ (raw - mean) / (row @ row))
    last, words = _last_digit(raw)
    if not last.max() >= _COARSE * step:
        return None
    apart, most = raw - mean - step * row, np.maximum(last, _COARSE * step)
    apart = apart - 0.5 * (apart.max() + apart.min())  # digits that are cut off instead of rounded
    even = (np.abs(apart) <= 0.55 * most.max()).all() and (np.abs(apart - np.median(apart)) <= 1.05 * most).all()
    even = even and (np.abs(steps - step) < 1.001 * np.maximum(most[1:], most[:-1])).all()
    changed = np.count_nonzero(np.abs(steps - np.median(steps)) > 0.5 * last[1:])
    if not even or changed <= _MANY * len(steps):  # rounding changes nothing of these, or a few rows are missing
        return None
    repeated = np.count_nonzero(steps < 0.5 * last[1:])
    told = f"its times are rounded to {words}" + (f", {repeated} repeat the one before" if repeated else "")
    return mean + step * float(row[0]), step, told


def _last_digit(raw: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
    """(n,) what the last digit of each time counts, and in words how many digits there are: behind the point, or altogether."""
    for decimals in range(_MOST_DIGITS + 1):
        last = np.full(len(raw), 10.0**-decimals)
        if _counts(raw, last):
            break
    size = np.abs(raw)
    size[size == 0.0] = size[size > 0.0].min()
    for digits in range(2, _MOST_DIGITS + 1):
        of_all = 10.0 ** (np.floor(np.log10(size) + 1e-12) + 1.0 - digits)
        if _counts(raw, of_all):
            return (of_all, f"{digits} digits") if of_all.max() > last[0] else (last, f"{decimals} decimals")
    return last, f"{decimals} decimals"


def _counts(raw: NDArray[np.float64], last: NDArray[np.float64]) -> bool:
    """Whether times are whole numbers of what their last digits count."""
    few = len(raw) // 1000 + 1
    if few > 1 and not _counts(raw[::few], last[::few]):  # most that are not need no more
        return False
    counted = raw / last
    return bool((np.abs(counted - np.round(counted)) < np.maximum(1e-4, 4e-16 * np.abs(counted))).all())


def refuse_few(count: int, source: str) -> None:
    """Refuse a run of too few samples."""
    if count < LEAST_SAMPLES:
        raise DataError(source, f"has {count} samples; at least {LEAST_SAMPLES} make a run")


def refuse_impossible(rate: float, source: str) -> None:
    """Refuse a rate that no measurement has."""
    if not RATES[0] <= rate <= RATES[1]:
        raise DataError(source, f"has {rate:.3g} samples a second; {RATES[0]:g} to {RATES[1]:g} can be a measurement")
