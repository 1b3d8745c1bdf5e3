"""The course of a run over its windows, measured piece by piece: memory does not grow with the length of the run."""

from dataclasses import dataclass, fields, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rsc.measure import envelopes, spectra
from rsc.measure.features import (
    ContactStrip,
    RunLike,
    contact_strip,
    contact_turning,
    rolling_share,
    turns,
    window_means,
)
from rsc.measure.windows import Features

# samples held at a time
PIECE = 2**18
# windows at most: with more they stand further apart
MOST_WINDOWS = 4000
# points of the path that is kept of every window: some periods of its slower motion, and points enough for its faster one
PATH_POINTS, SLOW_PERIODS, FAST_PERIODS = 200, 3.0, 12.0
# amplitudes that the waterfalls of rotor and stator keep together; of more, the largest of neighbouring bins, for pictures
MOST_CELLS = 2**23


class LongRun(Protocol):
    """The parts of a `rsc.Trajectory` that its course is taken from."""

    @property
    def scene(self) -> Any: ...

    @property
    def n_time(self) -> int: ...

    def samples(self, first: int, last: int) -> RunLike: ...


@dataclass(frozen=True)
class Windows:
    """Windows of equal length over a run.

    n_samples : int; rate : float Hz, samples a second
    starts : (n_w,) int, numbers of their first samples
    speed : (n_w,) Hz, rotor speed at their centres
    """

    n_samples: int
    rate: float
    starts: NDArray[np.intp]
    speed: NDArray[np.float64]

    @property
    def window(self) -> float:
        """Their length in s."""
        return self.n_samples / self.rate


@dataclass(frozen=True)
class Orbits:
    """Paths in the middle of every window, for pictures.

    time : (n_w, k) s; rotor, stator : (n_w, k) complex m at the contact; normal_force : (n_w, k) N
    """

    time: NDArray[np.float64]
    rotor: NDArray[np.complex64]
    stator: NDArray[np.complex64]
    normal_force: NDArray[np.float64]


@dataclass(frozen=True)
class Course:
    """What a run shows in its windows, and over all of it.

    fall : spectra.Waterfall, of the rotor; stator_fall : spectra.Waterfall, of the stator about its mean, or None for a rigid one
    features : windows.Features; strip : features.ContactStrip; orbits : Orbits
    order : (n_w,) complex m, the line at the rotor speed in the frame of the shaft: a whirl with it stands still there
    centre : (n_w,) complex m, mean position of the rotor
    envelope : envelopes.Envelope, over windows of its own that cover every sample
    normal_force : float N, the largest; motion : float m, the largest |r| of a sample, both at the contact
    """

    fall: spectra.Waterfall
    stator_fall: spectra.Waterfall | None
    features: Features
    strip: ContactStrip
    orbits: Orbits
    order: NDArray[np.complex128]
    centre: NDArray[np.complex128]
    envelope: envelopes.Envelope
    normal_force: float
    motion: float


def steepest(run: LongRun) -> float:
    """Largest run-up rate in Hz/s of the part of its schedule that a run has reached."""
    drive, end = run.scene.drive, (run.n_time - 1) / run.scene.output.rate
    rates = np.abs(np.diff(drive.speed) / np.diff(drive.time))
    return float(rates[np.asarray(drive.time)[:-1] < max(end, 1e-300)].max(initial=0.0))


def windows_of(run: LongRun, window: float | None = None) -> Windows:
    """Windows of a given length in s, or as long as the run-up allows."""
    rate, n_time, drive = run.scene.output.rate, run.n_time, run.scene.drive
    if window is None:
        window = spectra.window_duration(steepest(run), (n_time - 1) / rate, rate)
    n_samples = spectra.window_samples(window, rate, n_time)
    starts = spectra.window_starts(n_samples, n_time, most=MOST_WINDOWS)
    return Windows(n_samples, rate, starts, np.interp((starts + 0.5 * n_samples) / rate, drive.time, drive.speed))


def course(run: LongRun, windows: Windows, loaded: bool) -> Course:
    """Measure a run in windows.

    Parameters
    ----------
    run : Trajectory
    windows : Windows
    loaded : bool
        A constant load deflects the rotor: its mean is taken off before lines are looked for.
    """
    means = _means(run) if loaded else (0.0, 0.0)
    hop = int(windows.starts[1] - windows.starts[0]) if len(windows.starts) > 1 else 1
    count = max(1, (PIECE - windows.n_samples) // hop + 1)
    n_falls = 2 if run.scene.stator.n_coordinates else 1
    n_columns = max(1, MOST_CELLS // n_falls // len(windows.starts))
    falls, stators, features, strips, orbits, orders, centres = [], [], [], [], [], [], []
    for i in range(0, len(windows.starts), count):
        own = replace(windows, starts=windows.starts[i : i + count], speed=windows.speed[i : i + count])
        part = run.samples(int(own.starts[0]), int(own.starts[-1]) + windows.n_samples)
        fall = _fall(own, part.contact_rotor())
        stator = _fall(own, part.contact_stator() - means[1]) if run.scene.stator.n_coordinates else None
        features.append(_features(own, part, (fall, stator), means))
        strips.append(contact_strip(part, fall))
        orbits.append(_orbits(own, part, features[-1].frequency))
        orders.append(_order(own, part))
        rotor = part.contact_rotor()
        centres.append(window_means(part.time, rotor.real, fall) + 1j * window_means(part.time, rotor.imag, fall))
        falls.append(_thinned(fall, n_columns))
        if stator is not None:
            stators.append(_thinned(stator, n_columns))
    envelope, force, motion = _extremes(run, windows)
    lines = np.concatenate(orders), np.concatenate(centres)
    both = _whole(falls), _whole(stators) if stators else None
    return Course(*both, _joined(features), _joined(strips), _joined(orbits), *lines, envelope, force, motion)


def _whole(falls: list[spectra.Waterfall]) -> spectra.Waterfall:
    """One waterfall of several that follow each other."""
    columns: dict[str, Any] = {name: np.concatenate([getattr(f, name) for f in falls]) for name in ("speed", "time", "amplitude")}
    return replace(falls[0], **columns)


def _fall(windows: Windows, signal: NDArray[np.complex128]) -> spectra.Waterfall:
    """The waterfall of a motion that begins with the first of the windows."""
    amplitude = spectra.amplitudes(signal, windows.starts - windows.starts[0], windows.n_samples)
    time = np.asarray((windows.starts + 0.5 * windows.n_samples) / windows.rate, dtype=float)
    frequency = spectra.frequencies(windows.n_samples, windows.rate)
    return spectra.Waterfall(frequency, windows.speed, time, amplitude, windows.window, windows.n_samples)


def _thinned(fall: spectra.Waterfall, n_columns: int) -> spectra.Waterfall:
    """A waterfall of at most so many columns, each the largest of several bins, in single precision; or as it is."""
    if fall.frequency.size <= n_columns:
        return fall
    edges = np.arange(n_columns + 1) * fall.frequency.size // n_columns
    centres = 0.5 * (fall.frequency[edges[:-1]] + fall.frequency[edges[1:] - 1])
    amplitude: Any = np.fmax.reduceat(fall.amplitude, edges[:-1], axis=1).astype(np.float32)
    return replace(fall, frequency=centres, amplitude=amplitude)


def _features(
    windows: Windows,
    part: RunLike,
    both: tuple[spectra.Waterfall, spectra.Waterfall | None],
    means: tuple[complex, complex],
) -> Features:
    """Features in the windows of a part of a run; `both` are the waterfalls of rotor and stator there."""
    fall, stator_fall = both
    rotor, stator = part.contact_rotor() - means[0], part.contact_stator() - means[1]
    # a constant load's line at 0 Hz would hide slow lines beside it
    falls = {"rotor": fall if means == (0.0, 0.0) else _fall(windows, rotor)}
    if stator_fall is not None:
        falls |= {"relative": _fall(windows, rotor - stator), "stator": stator_fall}
    peaks = [spectra.spectral_peaks(each, side="negative", count=3) for each in falls.values()]
    frequency, size = (np.array([getattr(peak, name) for peak in peaks]) for name in ("frequency", "amplitude"))
    places = np.arange(len(fall.speed))
    body = np.nan_to_num(size[:, :, 0]).argmax(axis=0)
    strongest = frequency[body, places, 0]
    at_line = {name: np.nan_to_num(spectra.line_at(each, strongest).amplitude) for name, each in falls.items()}
    synchronous = np.array([spectra.line_at(each, fall.speed).amplitude for each in falls.values()])
    return Features(
        window=fall.window,
        rate=part.scene.output.rate,
        speed=fall.speed,
        time=fall.time,
        share=window_means(part.time, part.normal_force > 0.0, fall),
        frequency=strongest,
        size=np.nan_to_num(size[body, places, 0]),
        amplitude=at_line["rotor"],
        stator_amplitude=at_line.get("stator", np.zeros(len(places))),
        other_frequency=frequency[body, places, 1:],
        other_size=size[body, places, 1:],
        synchronous=synchronous[0],
        synchronous_size=synchronous[body, places],
        turning=contact_turning(part, part.contact_rotor() - part.contact_stator(), fall),
        rolling=rolling_share(part, fall),
    )


def _orbits(windows: Windows, part: RunLike, line: NDArray[np.float64]) -> Orbits:
    """Paths in the middle of the windows of a part of a run; `line`: Hz, their strongest backward lines, NaN for none."""
    turn = np.abs(windows.speed)
    rates = np.array([turn, np.where(np.isfinite(line), np.abs(line), turn)])
    span = np.minimum(SLOW_PERIODS / np.maximum(rates.min(axis=0), 1e-9), FAST_PERIODS / np.maximum(rates.max(axis=0), 1e-9))
    count = min(PATH_POINTS, windows.n_samples)
    step = np.clip(span * windows.rate / count, 1, max(1, windows.n_samples // count)).astype(int)
    first = windows.starts - windows.starts[0] + (windows.n_samples - count * step) // 2
    places = first[:, None] + step[:, None] * np.arange(count)
    rotor, stator = part.contact_rotor()[places], part.contact_stator()[places]
    return Orbits(part.time[places], rotor.astype(np.complex64), stator.astype(np.complex64), part.normal_force[places])


def _order(windows: Windows, part: RunLike) -> NDArray[np.complex128]:
    """The line at the rotor speed in the windows of a part of a run, in the frame of the shaft."""
    turning = part.contact_rotor() * np.exp(-2j * np.pi * turns(part.scene.drive, part.time))
    weights = spectra.weights(windows.n_samples)
    places = windows.starts - windows.starts[0]
    return np.array([weights @ turning[place : place + windows.n_samples] for place in places])


def _joined(parts: list[Any]) -> Any:
    """One dataclass of several whose arrays follow each other; what is no array they share."""
    columns = [field.name for field in fields(parts[0]) if isinstance(getattr(parts[0], field.name), np.ndarray)]
    return replace(parts[0], **{name: np.concatenate([getattr(part, name) for part in parts]) for name in columns})


def _pieces(run: LongRun) -> list[tuple[int, int]]:
    """First and last sample (exclusive) of consecutive pieces of a run."""
    return [(first, min(first + PIECE, run.n_time)) for first in range(0, run.n_time, PIECE)]


def _means(run: LongRun) -> tuple[complex, complex]:
    """Mean displacements of rotor and stator over a run, m."""
    sums = np.zeros(2, dtype=complex)
    for piece in _pieces(run):
        part = run.samples(*piece)
        sums += part.contact_rotor().sum(), part.contact_stator().sum()
    rotor, stator = (sums / run.n_time).tolist()
    return rotor, stator


def _extremes(run: LongRun, windows: Windows) -> tuple[envelopes.Envelope, float, float]:
    """The envelope of a run, its largest normal force in N and its largest |r| in m at the contact."""
    edges = envelopes.envelope_edges(windows.n_samples, run.n_time)
    count = max(1, PIECE // windows.n_samples)
    extremes, force, motion = [], 0.0, 0.0
    for first in range(0, len(edges) - 1, count):
        own = edges[first : first + count + 1]
        begin, end = max(int(own[0]) - 1, 0), min(int(own[-1]) + 1, run.n_time)
        part = run.samples(begin, end)
        extremes.append(envelopes.extremes_between(part.contact_rotor(), own - begin))
        force = max(force, float(part.normal_force.max()))
        motion = max(motion, float(np.abs(part.contact_rotor()).max()))
    low, high = np.concatenate(extremes, axis=1)
    drive, centre = run.scene.drive, np.asarray(0.5 * (edges[:-1] + edges[1:] - 1) / windows.rate, dtype=float)
    return envelopes.Envelope(np.interp(centre, drive.time, drive.speed), centre, low, high), force, motion
