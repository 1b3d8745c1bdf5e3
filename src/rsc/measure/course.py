"""The course of a run over its windows, measured piece by piece: memory does not grow with the length of the run."""

from dataclasses import dataclass, field, fields, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rsc.measure import envelopes, spectra, window_length
from rsc.measure.features import ContactStrip, RunLike, contact_strip, turned, window_means
from rsc.measure.kinds import MOST_PARTS, Motion, ProbeKind, motion_between, seen_of
from rsc.measure.stretches import Stretches, at_contacts
from rsc.measure.windows import Features

# samples held at a time
PIECE = 2**18
# windows at most: with more they stand further apart
MOST_WINDOWS = 4000
# points of the path that is kept of every window: some periods of its slower motion, and points enough for its faster one
PATH_POINTS, SLOW_PERIODS, FAST_PERIODS = 200, 3.0, 12.0
# backward lines that are kept of a window; bins within which a line is at minus the rotor speed, and how far the skirts of such a
# line reach, with lines of which share of it
LINES, MIRRORED, SKIRT, SKIRT_SHARE = 3, 3, 12, 0.05
NEARLY = 0.9  # of the gap, in a whirl at least
# of a measured run: points in a turn of the fastest line, to which its noise is averaged, and the least part of its motion
# (root mean square) that the backward line of a whirl has
SMOOTHED, WHIRLING = 32, 0.5
# amplitudes that the waterfalls of rotor and stator keep together; of more, the largest of neighbouring bins, for pictures
MOST_CELLS = 2**23


class LongRun(Protocol):
    """The parts of a `rsc.Trajectory` that its course is taken from."""

    @property
    def scene(self) -> Any: ...

    @property
    def n_time(self) -> int: ...

    @property
    def status(self) -> str: ...

    def samples(self, first: int, last: int) -> RunLike: ...

    def stretches(self, contact: str | None = None) -> Any: ...  # None of a measured run


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
    stretches : stretches.Stretches, what the steps of the run tell of it
    Of a measured run stator_fall, strip and stretches are None: probes see neither stator nor contact.
    Of several contacts this is at the one with the name `lead` ("" with one), but for what features tell of the whole motion;
    contacts : dict, name -> rsc.measure.several.ContactCourse of each
    """

    fall: spectra.Waterfall
    stator_fall: spectra.Waterfall | None
    features: Features
    strip: ContactStrip | None
    orbits: Orbits
    order: NDArray[np.complex128]
    centre: NDArray[np.complex128]
    envelope: envelopes.Envelope
    stretches: Stretches | None
    lead: str = ""
    contacts: dict[str, Any] = field(default_factory=dict)


def steepest(run: LongRun) -> float:
    """Largest run-up rate in Hz/s of the part of its schedule that a run has reached."""
    drive, end = run.scene.drive, (run.n_time - 1) / run.scene.output.rate
    rates = np.abs(np.diff(drive.speed) / np.diff(drive.time))
    return float(rates[np.asarray(drive.time)[:-1] < max(end, 1e-300)].max(initial=0.0))


def windows_of(run: LongRun, window: float | None = None) -> Windows:
    """Windows of a given length in s, or as long as the run-up allows."""
    rate, n_time, drive = run.scene.output.rate, run.n_time, run.scene.drive
    window = getattr(run, "window", None) if window is None else window  # a measured run's speed is never smooth
    if window is None:
        window = window_length.window_duration(steepest(run), (n_time - 1) / rate, rate)
    n_samples = window_length.window_samples(window, rate, n_time)
    starts = window_length.window_starts(n_samples, n_time, most=MOST_WINDOWS)
    return Windows(n_samples, rate, starts, np.interp((starts + 0.5 * n_samples) / rate, drive.time, drive.speed))


def course(run: LongRun, windows: Windows, loaded: bool, unequal: bool = False, driven: bool = False) -> Course:
    """Measure a run in windows.

    Parameters
    ----------
    run : Trajectory
    windows : Windows
    loaded : bool
        A constant load deflects the rotor: its mean is taken off before lines are looked for.
    unequal : bool
        Directions differ: a line at minus the rotor speed is the other half of the unbalance's ellipse, and no whirl's.
    driven : bool
        As in `rsc.measure.kinds.motion_of`.
    """
    hop = int(windows.starts[1] - windows.starts[0]) if len(windows.starts) > 1 else 1
    count = max(1, (PIECE - windows.n_samples) // hop + 1)
    stretches = run.stretches()
    means = _means(run) if loaded and stretches is not None else (0.0, 0.0)  # a measured run is about its resting position
    sees_stator = bool(run.scene.stator.n_coordinates) and stretches is not None
    n_falls = 2 if sees_stator else 1
    n_columns = max(1, MOST_CELLS // n_falls // len(windows.starts))
    falls, stators = (_Whole(len(windows.starts), ("frequency",)) for _ in range(2))
    features, strips, orbits = (_Whole(len(windows.starts)) for _ in range(3))
    orders, centres = [], []
    for i in range(0, len(windows.starts), count):
        own = replace(windows, starts=windows.starts[i : i + count], speed=windows.speed[i : i + count])
        part = run.samples(int(own.starts[0]), int(own.starts[-1]) + windows.n_samples)
        fall = _fall(own, part.contact_rotor())
        stator = _fall(own, part.contact_stator() - means[1]) if sees_stator else None
        measured = _features(own, part, (fall, stator), means, unequal)
        if stretches is None:
            features.add(replace(measured, **_seen(own, part, measured)))
        else:
            measured = replace(measured, **_kinds(motions_in(own, run, int(windows.starts[-1]), driven)))
            features.add(measured)
            strips.add(contact_strip(part, fall, measured))
        orbits.add(_orbits(own, part, measured.frequency))
        orders.append(_order(own, part))
        rotor = part.contact_rotor()
        centres.append(window_means(part.time, rotor.real, fall) + 1j * window_means(part.time, rotor.imag, fall))
        first = own.starts - own.starts[0]
        falls.add(_thinned(spectra.without_means(fall, rotor, first), n_columns))
        if stator is not None:
            stators.add(_thinned(spectra.without_means(stator, part.contact_stator() - means[1], first), n_columns))
    return Course(
        fall=falls.joined(),
        stator_fall=stators.joined(),
        features=features.joined(),
        strip=strips.joined(),
        orbits=orbits.joined(),
        order=np.concatenate(orders),
        centre=np.concatenate(centres),
        envelope=_envelope(run, windows),
        stretches=stretches,
    )


class _Whole:
    """Dataclasses of consecutive windows as one: their arrays are written into those of all windows as they come, since a list of
    them and what it is joined to would be held at a time."""

    def __init__(self, n_windows: int, shared: tuple[str, ...] = ()) -> None:
        self._n_windows, self._shared, self._filled = n_windows, shared, 0
        self._arrays: dict[str, NDArray[Any]] = {}
        self._last: Any = None

    def add(self, part: Any) -> None:
        """Append the next part; arrays `shared` by all windows are those of the last part."""
        named = {field.name: getattr(part, field.name) for field in fields(part) if field.name not in self._shared}
        for name, values in named.items():
            if isinstance(values, np.ndarray):
                if name not in self._arrays:
                    self._arrays[name] = np.empty((self._n_windows, *values.shape[1:]), values.dtype)
                self._arrays[name][self._filled : self._filled + len(values)] = values
                count = len(values)
        self._filled, self._last = self._filled + count, part

    def joined(self) -> Any:
        """The dataclass of all windows; None where nothing was added."""
        return replace(self._last, **self._arrays) if self._filled else None


def _fall(windows: Windows, signal: NDArray[np.complex128]) -> spectra.Waterfall:
    """The waterfall of a motion that begins with the first of the windows."""
    amplitude = spectra.amplitudes(signal, windows.starts - windows.starts[0], windows.n_samples)
    time = np.asarray((windows.starts + 0.5 * windows.n_samples) / windows.rate, dtype=float)
    frequency = spectra.frequencies(windows.n_samples, windows.rate)
    return spectra.Waterfall(frequency, windows.speed, time, amplitude, windows.window, windows.n_samples)


def _thinned(fall: spectra.Waterfall, n_columns: int) -> spectra.Waterfall:
    """A waterfall with a limited number of columns (maximum of several bins, single precision), or unchanged."""
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
    unequal: bool,
) -> Features:
    """Features in the windows of a part of a run; `both` are the waterfalls of rotor and stator there."""
    fall, stator_fall = both
    rotor, stator = part.contact_rotor() - means[0], part.contact_stator() - means[1]
    # a constant load's line at 0 Hz would hide slow lines beside it
    falls = {"rotor": fall if means == (0.0, 0.0) else _fall(windows, rotor)}
    if stator_fall is not None:
        falls |= {"relative": _fall(windows, rotor - stator), "stator": stator_fall}
    peaks = [spectra.spectral_peaks(each, side="negative", count=LINES + (MIRRORED if unequal else 0)) for each in falls.values()]
    frequency, size = (np.array([getattr(peak, name) for peak in peaks]) for name in ("frequency", "amplitude"))
    synchronous = np.array([spectra.line_at(each, fall.speed).amplitude for each in falls.values()])
    if unequal:
        gap, relative = part.scene.contact.gap, list(falls).index("relative" if stator_fall is not None else "rotor")
        frequency, size = _without_ellipse(fall, (frequency, size), np.nan_to_num(synchronous), (relative, gap))
    places = np.arange(len(fall.speed))
    body = np.nan_to_num(size[:, :, 0]).argmax(axis=0)
    strongest = frequency[body, places, 0]
    at_line = {name: np.nan_to_num(spectra.line_at(each, strongest).amplitude) for name, each in falls.items()}
    nothing, text = np.zeros(len(places)), np.zeros(len(places), dtype="U1")  # `_kinds` fills them
    filled = ("share", "turning", "rolling", "largest", "peak_to_peak", "stator_largest", "force", "force_max")
    numbers: Any = dict.fromkeys(filled, nothing)
    return Features(
        window=fall.window,
        rate=part.scene.output.rate,
        kind=text,
        why=text,
        **numbers,
        speed=fall.speed,
        time=fall.time,
        frequency=strongest,
        size=np.nan_to_num(size[body, places, 0]),
        amplitude=at_line["rotor"],
        stator_amplitude=at_line.get("stator", np.zeros(len(places))),
        other_frequency=frequency[body, places, 1:],
        other_size=size[body, places, 1:],
        synchronous=synchronous[0],
    )


def motions_in(windows: Windows, run: Any, last: int, driven: bool) -> list[Motion]:
    """The motion of a run in each of its windows; last: first sample of its last one."""
    begin, each = windows.starts / windows.rate, at_contacts(run)
    motions: list[Motion] = []
    for start in begin.tolist():
        at_end = start == last / windows.rate  # what comes behind the last window belongs to it
        end = float(each[0].end[-1]) if at_end else start + windows.window
        motions.append(motion_between(each, (start, end), run.scene, at_end and run.status == "diverged", driven))
    return motions


def _kinds(motions: list[Motion]) -> dict[str, Any]:
    """Fields of Features from the integration steps of a run."""
    facts = [motion.facts for motion in motions]
    values = {
        "share": "share", "turning": "turning", "rolling": "rolling_share", "largest": "rotor_max",
        "peak_to_peak": "peak_to_peak", "stator_largest": "stator_max", "force": "mean_force", "force_max": "force_max",
    }  # fmt: skip
    numbers = {name: np.array([getattr(own, attribute) for own in facts]) for name, attribute in values.items()}
    texts = np.array([(str(motion.kind), motion.why) for motion in motions]).reshape(len(motions), 2)
    return numbers | {"kind": texts[:, 0], "why": texts[:, 1]}


def _seen(windows: Windows, part: RunLike, lines: Features) -> dict[str, Any]:
    """Fields of Features from two probes, for a part of a run."""
    shaft, gap, n_windows = turned(part, part.time), part.scene.contact.gap, len(windows.starts)
    unknown = np.full(n_windows, np.nan)
    names = ("share", "turning", "largest", "peak_to_peak", "stator_largest", "force", "force_max")
    values = {name: unknown.copy() for name in names}
    kinds = np.full(n_windows, ProbeKind.NOT_RESOLVED, dtype="U40")
    why = np.full(n_windows, "samples are missing", dtype="U40")
    for i, start in enumerate((windows.starts - windows.starts[0]).tolist()):
        own = part.contact_rotor()[start : start + windows.n_samples]
        if not np.isfinite(own).all():
            continue
        fastest = float(np.fmax(np.abs(lines.frequency[i]), windows.speed[i]))
        count = max(1, min(int(windows.rate / max(SMOOTHED * fastest, 1e-9)), len(own) // (2 * MOST_PARTS)))  # of a shaft at rest
        smooth = own[: len(own) // count * count].reshape(-1, count).mean(axis=1)
        smooth = smooth - smooth.mean()
        steps = np.angle(smooth[1:] * smooth[:-1].conj()) / (2.0 * np.pi)
        turns = [float(piece.sum()) for piece in np.array_split(steps, MOST_PARTS)]
        kind = seen_of(turns, float(shaft[start + windows.n_samples - 1] - shaft[start]))
        if kind == ProbeKind.WHIRL and not lines.size[i] >= WHIRLING * np.sqrt(np.mean(np.abs(smooth) ** 2)):
            kind = ProbeKind.NEITHER  # noise, or an ellipse of unequal supports that turns backward with the shaft
        values["largest"][i], values["turning"][i] = np.abs(own).max(), sum(turns) / windows.window
        values["peak_to_peak"][i] = max(np.ptp(own.real), np.ptp(own.imag))
        if kind != ProbeKind.WHIRL and values["largest"][i] < gap:
            values["share"][i] = 0.0
        kinds[i], why[i] = kind, "fewer than three turns: too short" if kind == ProbeKind.NOT_RESOLVED else ""
    return values | {"kind": kinds, "why": why, "rolling": np.zeros(n_windows)}


def _without_ellipse(
    fall: spectra.Waterfall,
    lines: tuple[NDArray[np.float64], NDArray[np.float64]],
    synchronous: NDArray[np.float64],
    contact: tuple[int, float],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The strongest backward lines without those at minus the rotor speed and in the skirts of these, which a run-up makes wider.

    A whirl that passes minus the rotor speed stays: there the motion at the contact is larger than the gap, and turns backward.

    lines : frequency (bodies, n_w, more) Hz and size m; returned (bodies, n_w, LINES)
    synchronous : (bodies, n_w) m, forward line at the rotor speed; contact : number of the body that the contact sees, gap in m
    """
    (frequency, size), (seen, gap) = lines, contact
    away = np.abs(frequency + fall.speed[:, None]) * fall.window
    ellipse = np.nanmax(np.where(away <= MIRRORED, size, 0.0), axis=2, initial=0.0)
    whirls = (ellipse[seen] > NEARLY * gap) & (ellipse[seen] > synchronous[seen])
    own = ~((away <= MIRRORED) | ((away <= SKIRT) & (size < SKIRT_SHARE * ellipse[..., None]))) | whirls[:, None]
    frequency, size = (np.where(own, values, np.nan) for values in (frequency, size))
    order = np.argsort(-np.nan_to_num(size), axis=2, kind="stable")[..., :LINES]
    return np.take_along_axis(frequency, order, axis=2), np.take_along_axis(size, order, axis=2)


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
    turning = part.contact_rotor() * np.exp(-2j * np.pi * turned(part, part.time))
    weights = spectra.weights(windows.n_samples)
    places = windows.starts - windows.starts[0]
    return np.array([weights @ turning[place : place + windows.n_samples] for place in places])


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


def _envelope(run: LongRun, windows: Windows) -> envelopes.Envelope:
    """The envelope of a run."""
    edges = envelopes.envelope_edges(windows.n_samples, run.n_time)
    count = max(1, PIECE // windows.n_samples)
    extremes = []
    for first in range(0, len(edges) - 1, count):
        own = edges[first : first + count + 1]
        begin, end = max(int(own[0]) - 1, 0), min(int(own[-1]) + 1, run.n_time)
        extremes.append(envelopes.extremes_between(run.samples(begin, end).contact_rotor(), own - begin))
    low, high = np.concatenate(extremes, axis=1)
    drive, centre = run.scene.drive, np.asarray(0.5 * (edges[:-1] + edges[1:] - 1) / windows.rate, dtype=float)
    return envelopes.Envelope(np.interp(centre, drive.time, drive.speed), centre, low, high)
