"""Signals on one clock: shifted by when they began, and filtered and sampled anew where their rates differ."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal.windows import kaiser

from rsc.errors import DataError
from rsc.measured.times import LEAST_SAMPLES

ALIKE = 1e-6  # relative, sample intervals of one rate
_TOGETHER = 0.01  # of a sample, within which samples of two signals are taken at one time
_LOBES, _BETA = 32, 8.6  # zero crossings of the filter to each side, and the shape of its window: 85 dB
_PASSED = 0.9  # of half the lower rate, where a filter for a lower rate has lost half
_FINE = 512  # points of the filter between two zero crossings
_BLOCK = 2_000_000  # products that are formed together


class Signal(NamedTuple):
    """Samples at start + k step, in s; NaN where one is missing."""

    name: str
    start: float
    step: float
    values: NDArray[np.float64]

    @property
    def end(self) -> float:
        """s, of the last sample."""
        return self.start + self.step * (len(self.values) - 1)

    def times_after(self, moment: float) -> NDArray[np.float64]:
        """(n,) s of its samples behind a moment in s."""
        return np.asarray(self.start - moment + self.step * np.arange(len(self.values)), dtype=np.float64)


class CommonClock(NamedTuple):
    """The common times: start + k step, k < samples, in s."""

    start: float
    step: float
    samples: int

    @property
    def times(self) -> NDArray[np.float64]:
        """(samples,) s, from 0."""
        return np.asarray(self.step * np.arange(self.samples), dtype=np.float64)


def clock_of(signals: list[Signal], others: list[Signal], source: str) -> tuple[CommonClock, list[str]]:
    """The times of the slowest of some signals while all of them, and others that keep their times, are known; what to tell.

    Raises
    ------
    DataError
        Where the signals contradict each other or are never known together.
    """
    everything = signals + others
    _refuse_contradictions(everything, source)
    slowest = max(signals, key=lambda signal: signal.step)
    late, early = max(everything, key=lambda signal: signal.start), min(everything, key=lambda signal: signal.end)
    first = max(int(np.ceil((late.start - slowest.start) / slowest.step - _TOGETHER)), 0)
    count = int(np.floor((early.end - slowest.start) / slowest.step + _TOGETHER)) - first + 1
    if count < LEAST_SAMPLES:
        together = f"{late.name} begins {late.start - early.end:.3g} s after the end of {early.name}"
        if late.start < early.end:
            together = f"{early.name} and {late.name} overlap by {max(count, 0)} samples, and at least {LEAST_SAMPLES} make a run"
        raise DataError(source, f"its channels are not known together: {together}; give channels of one run")
    told = []
    apart = late.start - min(signal.start for signal in everything)
    if apart > _TOGETHER * slowest.step:
        told.append(f"its channels begin up to {apart:.3g} s apart, {late.name} last: shifted by their start times")
    rates = {signal.name: 1.0 / signal.step for signal in signals}
    if any(abs(signal.step - slowest.step) > ALIKE * slowest.step for signal in signals):
        listed = ", ".join(f"{name} {rate:.6g}" for name, rate in rates.items())
        most = 0.8 * 0.5 / slowest.step
        told.append(f"its probes have not one rate ({listed} samples a second): both at the lower one, up to {most:.4g} Hz")
    return CommonClock(slowest.start + first * slowest.step, slowest.step, count), told


def _refuse_contradictions(signals: list[Signal], source: str) -> None:
    """Refuse what no two channels of one run can be: as many samples at another rate, or fewer from one start at one rate."""
    counts = [len(signal.values) for signal in signals]
    one_length = len(set(counts)) == 1
    one_rate = max(signal.step for signal in signals) - min(signal.step for signal in signals) <= ALIKE * signals[0].step
    if one_length and not one_rate:
        listed = ", ".join(f"{signal.name} {1.0 / signal.step:.9g}" for signal in signals)
        problem = f"its channels have not one rate ({listed} samples a second) and yet one length"
        raise DataError(source, f"{problem}: their clocks run apart; correct the wrong rate")
    starts = [signal.start for signal in signals]
    if one_rate and not one_length and max(starts) - min(starts) <= _TOGETHER * signals[0].step:
        listed = ", ".join(f"{signal.name} {count}" for signal, count in zip(signals, counts, strict=True))
        problem = f"its channels have not one length ({listed}) from one start at one rate"
        raise DataError(source, f"{problem}: samples are missing at unknown places")


def at(signal: Signal, clock: CommonClock) -> NDArray[np.float64]:
    """(samples,) values of a signal at the times of a clock: its own samples where it has them there, else filtered ones; NaN
    beside missing samples."""
    first = (clock.start - signal.start) / signal.step
    ratio = clock.step / signal.step
    whole = round(first)
    last_place = abs(first - whole) + abs(ratio - 1.0) * clock.samples
    if last_place <= _TOGETHER:
        return signal.values[max(whole, 0) :][: clock.samples]
    places = np.asarray(first + ratio * np.arange(clock.samples), dtype=np.float64)
    return resampled(signal.values, places, min(1.0, _PASSED / ratio) if ratio > 1.0 else 1.0)


def resampled(values: NDArray[np.float64], places: NDArray[np.float64], passed: float) -> NDArray[np.float64]:
    """(m,) values between samples, by a low-pass filter of windowed sinc.

    Parameters
    ----------
    values : (n,), NaN where a sample is missing
    places : (m,) counted in samples, rising
    passed : part of half the rate up to which it passes
    """
    known = np.isfinite(values)
    if not known.any():
        return np.full(len(places), np.nan)
    row = np.arange(len(values))
    filled = values if known.all() else np.interp(row, row[known], values[known])
    grid = np.arange(_LOBES * _FINE + 1) / _FINE
    window = kaiser(2 * _LOBES * _FINE + 1, _BETA)[_LOBES * _FINE :]
    half = int(np.ceil(_LOBES / passed))
    beside = np.arange(-half, half + 1)
    result = np.empty(len(places))
    block = max(_BLOCK // len(beside), 1)
    for begin in range(0, len(places), block):
        some = places[begin : begin + block]
        index = np.round(some).astype(int)[:, None] + beside
        shares = np.interp(np.abs(some[:, None] - index) * passed, grid, np.sinc(grid) * window, right=0.0)
        shares[(index < 0) | (index >= len(values))] = 0.0
        result[begin : begin + block] = (filled[np.clip(index, 0, len(values) - 1)] * shares).sum(axis=1) / shares.sum(axis=1)
    if not known.all():
        reach = np.minimum(np.maximum(1.0, 0.5 / passed), half)
        lost = np.convolve(~known, np.ones(2 * int(np.ceil(reach)) + 1), "same") > 0.5
        result[lost[np.clip(np.round(places).astype(int), 0, len(values) - 1)]] = np.nan
    return result
