"""What a run shows of its backward whirl, window by window, read from measured and simulated samples by the same function."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError
from rsc.measure import spectra
from rsc.measure.course import Windows, windows_of
from rsc.measured.run import MeasuredRun
from rsc.study.report.report import course_of
from rsc.system.assemble import assemble

MOST_WINDOWS = 60  # of a measured run; of more, so many evenly chosen ones
LEAST_WINDOWS = 4  # on a whirl, from which a run is fitted
HELD_BACK = 3  # every third window is
JUMP = 0.01  # of its frequency, from which a whirl is another one than in the window before
RAYLEIGH = float(np.sqrt(2.0 * np.log(2.0)))  # median of the size of complex noise over the deviation of its parts
WIDTH = 1.5  # bins of a Hann window, in which it gathers noise
# of a window: logarithms of frequency and amplitude of the whirl, and both parts of the line at the rotor speed in m
FEATURES, WITHOUT_PHASE, WHIRL_ONLY = 4, 3, 2
BAND = 3.0  # of the frequency of the whirl, within which noise is read
SHARP = 0.9  # deviation of a frequency in bins over that of its amplitude, relative, of a Hann window read at three bins
# least deviations, relative, of frequency and amplitude of the whirl and of the line at the rotor speed: what simulations promise
FLOORS = 4e-6, 4e-5, 1e-3
LEAST = 1e-6  # of the amplitude of the whirl, deviation of the line at the rotor speed at least
PHASE = 1e-3  # rad, deviation of the angle of the mark, alike in all windows
ANY = 1e-3  # m, deviation of a runout of which nothing is known
UNKNOWN = 1e6  # rad, deviation of an angle of which nothing is known: the line counts for nothing


@dataclass(frozen=True)
class WindowLines:
    """frequency : (n_w,) Hz of the strongest backward line, negative; amplitude : (n_w,) m; order : (n_w,) complex m, the line at
    the rotor speed in the frame of the shaft; NaN where there is none."""

    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    order: NDArray[np.complex128]


def lines_of(
    deflection: NDArray[np.complex128], turns: NDArray[np.float64], starts: NDArray[np.intp], size: int, rate: float
) -> WindowLines:
    """The lines of a motion (n,) m in windows of `size` samples, at `rate` Hz, of a shaft that made so many `turns` (n,)."""
    amplitude = spectra.amplitudes(deflection, starts, size)
    nothing = np.zeros(len(starts))
    fall = spectra.Waterfall(spectra.frequencies(size, rate), nothing, nothing, amplitude, size / rate, size)
    peaks = spectra.spectral_peaks(fall, side="negative", count=1)
    turning, weights = np.exp(-2j * np.pi * turns), spectra.weights(size)
    order = [
        _beside(deflection[start : start + size], turning[start : start + size], weights, turn / rate)
        for start, turn in zip(starts, 2j * np.pi * peaks.frequency[:, 0], strict=True)
    ]
    return WindowLines(peaks.frequency[:, 0], peaks.amplitude[:, 0], np.array(order, dtype=complex))


def _beside(
    motion: NDArray[np.complex128], turning: NDArray[np.complex128], weights: NDArray[np.float64], turn: complex
) -> complex:
    """The line at the rotor speed beside a whirl that turns by `turn` rad from sample to sample.

    Without what the whirl leaks into it: small, but its phase follows the frequency so fast that it would seem to tell values.
    """
    if not np.isfinite(turn):
        return complex(weights @ (motion * turning))
    return complex(weights @ (_without(motion, weights, turn) * turning))


def _without(motion: NDArray[np.complex128], weights: NDArray[np.float64], turn: complex) -> NDArray[np.complex128]:
    """A motion in a window without the whirl that turns by `turn` from sample to sample."""
    whirl = np.exp(turn * np.arange(len(motion)))
    return motion - (weights @ (motion / whirl)) * whirl


@dataclass(frozen=True)
class Span:
    """Consecutive windows of a measured run on one whirl.

    own : slice of the windows of `FittedWindows`; first, last : int, its samples, last exclusive, with a window before and behind
    """

    own: slice
    first: int
    last: int


@dataclass(frozen=True)
class FittedWindows:
    """The whirl of a measured run in the windows it is fitted in.

    run : MeasuredRun; size : int, samples of a window; starts : (n_w,) int, their first samples; speed, time : (n_w,) Hz, s
    lines : WindowLines; deviation : (n_w, 4), standard deviations of frequency over itself, of amplitude over itself, and of both
        parts of the line at the rotor speed over the amplitude
    held : (n_w,) bool, the windows that are held back; spans : tuple of Span
    runout : float m, deviation of each part of the runout that is left in all lines at the rotor speed; large without slow roll
    """

    run: MeasuredRun
    size: int
    starts: NDArray[np.intp]
    speed: NDArray[np.float64]
    time: NDArray[np.float64]
    lines: WindowLines
    deviation: NDArray[np.float64]
    held: NDArray[np.bool_]
    spans: tuple[Span, ...]
    runout: float

    @property
    def told(self) -> int:
        """Number of usable features of a window: without a mark on the shaft the line at the rotor speed has a size and no
        direction, and of a speed that was measured without pulses it is not known closely enough for either."""
        if self.run.jitter is None:
            return WHIRL_ONLY
        return FEATURES if self.run.marked else WITHOUT_PHASE

    def order_of(self, lines: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Lines at the rotor speed; without a known mark their magnitudes."""
        return _told_of(self.run, lines)


def seen_of(run: Any) -> FittedWindows:
    """The whirl of a MeasuredRun.

    Raises
    ------
    DataError
        Its backward whirl is seen in fewer than `LEAST_WINDOWS` windows between its changes.
    """
    windows = windows_of(run)
    features = course_of(run, windows, assemble(run.scene)).features
    whirls = np.array([features.on_whirl(i) and features.frequency[i] < 0.0 for i in range(len(features.speed))])
    groups = [group for group in _groups(whirls, features.frequency) if len(group) > 2]
    chosen = [group[1:-1] for group in groups]  # what comes and goes is in its first and last window
    count = sum(map(len, chosen))
    if count < LEAST_WINDOWS:
        raise DataError(run.source, f"shows a backward whirl that lasts in {count} windows of {windows.window:.3g} s: too few")
    every = -(-count // MOST_WINDOWS)
    chosen = [group[::every] for group in chosen]
    spans, begin = [], 0
    for group, own in zip(groups, chosen, strict=True):
        last = int(windows.starts[group[-1]]) + windows.n_samples
        spans.append(Span(slice(begin, begin + len(own)), int(windows.starts[group[0]]), last))
        begin += len(own)
    places = np.concatenate(chosen)
    starts = windows.starts[places]
    lines = lines_of(run.deflection, run.turns, starts, windows.n_samples, windows.rate)
    lines = replace(lines, order=_told_of(run, lines.order))
    held = np.arange(len(places)) % HELD_BACK == HELD_BACK - 1
    noise = _noise(run, windows, starts, lines)
    return FittedWindows(
        run=run,
        size=windows.n_samples,
        starts=starts,
        speed=windows.speed[places],
        time=features.time[places],
        lines=lines,
        deviation=_deviation(noise, windows.window, lines, _angle(run.jitter, windows.speed[places], windows)),
        held=held,
        spans=tuple(spans),
        runout=_left(run, float(np.median(noise)) * np.sqrt(windows.n_samples / WIDTH)),
    )


def _told_of(run: MeasuredRun, lines: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return lines if run.marked or run.jitter is None else np.abs(lines).astype(complex)


def _groups(whirls: NDArray[np.bool_], frequency: NDArray[np.float64]) -> list[NDArray[np.intp]]:
    """Numbers of consecutive windows on one whirl."""
    places = np.flatnonzero(whirls)
    if not len(places):
        return []
    apart = (np.diff(places) > 1) | (np.abs(np.diff(frequency[places])) > JUMP * np.abs(frequency[places[1:]]))
    return np.split(places, np.flatnonzero(apart) + 1)


def _noise(run: MeasuredRun, windows: Windows, starts: NDArray[np.intp], lines: WindowLines) -> NDArray[np.float64]:
    """(n_w,) m, deviation of both parts of a line in each window, by the median of its spectrum without the whirl, which leaks
    into it."""
    size, weights = windows.n_samples, spectra.weights(windows.n_samples)
    turns = 2j * np.pi * lines.frequency / windows.rate
    others = [_without(run.deflection[start : start + size], weights, turn) for start, turn in zip(starts, turns, strict=True)]
    frequencies = np.abs(spectra.frequencies(size, windows.rate))
    sizes = spectra.amplitudes(np.concatenate(others), size * np.arange(len(starts)), size)
    near = frequencies < BAND * np.abs(lines.frequency)[:, None]
    return np.asarray(np.nanmedian(np.where(near, sizes, np.nan), axis=1)) / RAYLEIGH


def _angle(jitter: float | None, speed: NDArray[np.float64], windows: Windows) -> NDArray[np.float64]:
    """(n_w,) rad, deviation of the angle of the mark, of one pulse in a turn; without pulses it is not known."""
    if jitter is None:
        return np.full(len(speed), UNKNOWN)
    turns = np.maximum(np.abs(speed) * windows.window, 1.0)
    return 2.0 * np.pi * np.abs(speed) * jitter / np.sqrt(turns)


def _deviation(noise: NDArray[np.float64], window: float, lines: WindowLines, angle: NDArray[np.float64]) -> NDArray[np.float64]:
    share = noise / lines.amplitude
    frequency = SHARP * share / window / np.abs(lines.frequency)
    order = np.hypot(np.hypot(share, LEAST), np.hypot(FLOORS[2], angle) * np.abs(lines.order) / lines.amplitude)
    return np.column_stack([np.hypot(frequency, FLOORS[0]), np.hypot(share, FLOORS[1]), order, order])


def _left(run: MeasuredRun, noise: float) -> float:
    """Standard deviation of the remaining runout, for noise with this deviation in both parts of a sample."""
    if run.slow_roll is None:
        return ANY
    slow = (run.speed >= run.slow_roll[0]) & (run.speed <= run.slow_roll[1])
    return noise / math.sqrt(max(int(slow.sum()), 1))
