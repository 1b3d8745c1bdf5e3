"""`Measured`: a run as two probes and a Keyphasor saw it, with the parts that spectra, peaks, lines and envelopes take."""

import hashlib
import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.arguments import PATH, takes
from rsc.errors import DataError, nearest, one_line
from rsc.measure import spectra
from rsc.measured.columns import columns_of
from rsc.measured.keys import Channels, read_channels
from rsc.measured.shaft import Shaft, shaft_from_speed, shaft_of
from rsc.measured.troubles import clipped, turned_backwards

LEAST_SAMPLES = 64
LARGEST = 1e12  # of a column, beyond which a number is none
JITTER = 0.05  # of a sample interval, from which the times of samples are told to be uneven
RATES = (1e-3, 1e9)  # samples a second that a measurement may have
MOST_SLOW = 50_000  # samples that tell runout
HARMONICS = 10  # of the shaft, of which runout consists
NO_MARK = "no Keyphasor: phases at the rotor speed are counted from the first sample, and no fit takes them"
NO_TOOTH = (
    "nobody knows which of {} pulses in a turn is the mark: "
    "phases at the rotor speed are counted from the first, and no fit takes them"
)
STANDS = 0.02  # of the largest speed, below which a measured one of the other sign is that of a shaft at rest
_GAP = 1.5  # sample intervals from which samples are missing
_SPANS = 64  # of a run, between whose mean speeds its steepest rise is read


@dataclass(frozen=True)
class Measured:
    """A measured run. Arrays have n samples, evenly spaced, as seen from the side where the shaft turns from y to z.

    Attributes
    ----------
    time : (n,) s, from 0
    speed : (n,) Hz, of the shaft
    deflection : (n,) complex m, y + i z of the shaft at the probes; NaN where samples are missing
    turns : (n,) of the shaft: e^{2 pi i turns} is the direction of its mark
    warnings : what is wrong with the signals, in lines
    runout : complex m, harmonics -10 to 10 of the shaft that were taken off, 0 without slow roll
    source : name of the data file
    slow_roll : Hz, lowest and highest of the speeds at which the runout was seen, or None
    jitter : s, deviation of the pulses of the shaft from an even rise of its speed; None without a Keyphasor
    marked : bool, whether the direction of the mark is known; else turns are counted from the first pulse or sample
    """

    time: NDArray[np.float64] = field(repr=False)
    speed: NDArray[np.float64] = field(repr=False)
    deflection: NDArray[np.complex128] = field(repr=False)
    turns: NDArray[np.float64] = field(repr=False)
    warnings: tuple[str, ...]
    runout: NDArray[np.complex128] = field(repr=False)
    source: str
    slow_roll: tuple[float, float] | None = None
    jitter: float | None = None
    marked: bool = True

    @property
    def digest(self) -> str:
        """SHA-256 of its samples."""
        known = hashlib.sha256()
        for values in (self.time, self.speed, self.turns, self.deflection):
            known.update(np.ascontiguousarray(values).tobytes())
        return known.hexdigest()

    def contact_rotor(self) -> NDArray[np.complex128]:
        """(n,) complex m: the deflection."""
        return self.deflection

    @property
    def window(self) -> float:
        """Length in s of the windows of its spectra, in which its steepest rise of speed moves a line by one bin."""
        span = max(len(self.time) // _SPANS, 1)
        count = len(self.time) // span
        means = self.speed[: span * count].reshape(count, span).mean(axis=1)
        rate = 1.0 / (self.time[1] - self.time[0])
        steepest = float(np.abs(np.diff(means)).max(initial=0.0)) * rate / span
        return spectra.window_duration(steepest, float(self.time[-1]), rate)


@takes(path=PATH)
def read_measured(path: str | os.PathLike[str]) -> Measured:
    """Read a measured run: two probes and the shaft.

    Parameters
    ----------
    path : str or path
        A TOML file with a table [measured] (docs/users/measured.md), or the data file with such a file of the same name, ending
        in .toml, beside it.

    Returns
    -------
    Measured
        Its `warnings` say what is wrong with the signals: clipped probes, missing samples, repeated times, missing pulses, probes
        that may be exchanged. Read them first.

    Raises
    ------
    SceneError
        A table that cannot be right.
    DataError
        A data file that cannot be read, or whose columns hold no run.
    """
    path = Path(path)
    channels = read_channels(path if not path.name or path.suffix.lower() == ".toml" else path.with_suffix(".toml"))
    data = path.parent / channels.file
    columns, rate = columns_of(data)
    return _measured(channels, columns, rate, one_line(data))


def _measured(channels: Channels, columns: dict[str, Any], rate: float | None, source: str) -> Measured:
    probes, unknown = zip(*(_numbers(columns, probe.column, source) for probe in channels.probe), strict=True)
    warnings = [line for probe, signal in zip(channels.probe, probes, strict=True) for line in clipped(probe.column, signal)]
    time, place, told = _times(channels, columns, rate, source)
    warnings += [*told, *(line for lines in unknown for line in lines)]
    scale = channels.full_scale if rate is not None else 1.0
    first, second = (_placed(signal * scale * probe.metres, place) for probe, signal in zip(channels.probe, probes, strict=True))
    r = _plane(first, second, *(np.deg2rad(probe.angle) for probe in channels.probe))
    shaft, told = _shaft(channels, columns, time, place, source)
    warnings += told
    turns = shaft.turns + channels.keyphasor_angle / 360.0
    if channels.sense == "z to y":
        r, turns = r.conj(), shaft.turns - channels.keyphasor_angle / 360.0
    r = np.where(shaft.known, r, np.nan)
    nothing = np.zeros(2 * HARMONICS + 1, complex)
    run = Measured(time, shaft.speed, r, turns, (), nothing, source, jitter=shaft.jitter, marked=shaft.marked)
    if channels.slow_roll is not None and not (shaft.marked or shaft.known.all()):
        raise DataError(source, "loses count of a wheel without a mark: leave measured.slow_roll out, runout cannot be taken off")
    run = _without_runout(run, channels.slow_roll)
    return replace(run, warnings=(*turned_backwards(run.deflection, run.turns), *warnings))


def _column(columns: dict[str, Any], name: str, source: str) -> NDArray[np.float64]:
    if name not in columns and name.isdigit() and 0 < int(name) <= len(columns):
        name = list(columns)[int(name) - 1]
    if name not in columns:
        raise DataError(source, f"has no column {one_line(name)[:60]!r} ({one_line(nearest(name, list(columns)))})")
    return np.asarray(columns[name], dtype=float)


def _numbers(columns: dict[str, Any], name: str, source: str) -> tuple[NDArray[np.float64], list[str]]:
    """A column, NaN where it holds no number that can be one, and what to tell."""
    column = _column(columns, name, source)
    with np.errstate(invalid="ignore"):
        known = np.abs(column) < LARGEST
    count = np.count_nonzero(~known)
    told = [f"{count} samples of {one_line(name)} are no numbers: windows on them are empty"] if count else []
    return np.where(known, column, np.nan), told


def _times(
    channels: Channels, columns: dict[str, Any], rate: float | None, source: str
) -> tuple[NDArray[np.float64], Any, list[str]]:
    """Even times from 0, the place of every row of the file among them (None of one that repeats a time), and what to tell."""
    length = len(next(iter(columns.values())))
    rate = rate or channels.rate
    if length < LEAST_SAMPLES:
        raise DataError(source, f"has {length} samples; at least {LEAST_SAMPLES} make a run")
    if channels.time is None:
        if rate is None:
            raise DataError(source, "has no times: measured.time or measured.rate must be given")
        _refuse_impossible(rate, source)
        return np.arange(length) / rate, np.arange(length), []
    raw, told = _column(columns, channels.time, source), []
    if not np.isfinite(raw).all():
        raise DataError(source, f"has a time that is no number, in row {int(np.argmin(np.isfinite(raw))) + 1} of its numbers")
    steps = np.diff(raw)
    if (steps < 0.0).any():
        raise DataError(source, f"has times that go back, behind row {int(np.argmax(steps < 0.0)) + 1} of its numbers")
    keep = np.concatenate([[True], steps > 0.0])
    if not keep.all():
        told.append(f"{np.count_nonzero(~keep)} samples repeat the time before: left out")
    steps = np.diff(raw[keep])
    usual = float(np.median(steps)) if steps.size else 0.0
    inside = steps < _GAP * usual
    if len(raw[keep]) < LEAST_SAMPLES or not inside.any():
        raise DataError(source, f"has fewer than {LEAST_SAMPLES} different times")
    step = float(steps[inside].mean())
    _refuse_impossible(1.0 / step, source)
    places = np.concatenate([[0.0], np.cumsum(np.maximum(np.round(steps / step), 1.0))])
    missing = places[-1] + 1.0 - len(places)
    if not places[-1] <= 4 * length:
        raise DataError(source, f"lacks {missing:.3g} samples between its first and its last time: more than it has")
    place = np.full(length, -1)
    place[keep] = places
    if missing:
        gaps = f"{np.count_nonzero(~inside)} gaps of up to {steps.max():.3g} s"
        told.append(f"{missing:.0f} samples are missing, in {gaps}: windows on them are empty")
    uneven = float(np.abs(steps[inside] / step - 1.0).max())
    if uneven > JITTER:
        told.append(f"its times are uneven by up to {100.0 * uneven:.0f} % of a sample: taken as even")
    return step * np.arange(place.max() + 1), place, told


def _refuse_impossible(rate: float, source: str) -> None:
    if not RATES[0] <= rate <= RATES[1]:
        raise DataError(source, f"has {rate:.3g} samples a second; {RATES[0]:g} to {RATES[1]:g} can be a measurement")


def _placed(signal: NDArray[np.float64], place: Any) -> NDArray[np.float64]:
    """The signal at even times, NaN where the file has no sample."""
    placed = np.full(place.max() + 1, np.nan)
    placed[place[place >= 0]] = signal[place >= 0]
    return placed


def _plane(first: NDArray[np.float64], second: NDArray[np.float64], alpha: Any, beta: Any) -> NDArray[np.complex128]:
    """r = y + i z of two displacements p = y cos(angle) + z sin(angle)."""
    y = first * np.sin(beta) - second * np.sin(alpha)
    z = second * np.cos(alpha) - first * np.cos(beta)
    return (y + 1j * z) / np.sin(beta - alpha)


def _shaft(
    channels: Channels, columns: dict[str, Any], time: NDArray[np.float64], place: Any, source: str
) -> tuple[Shaft, list[str]]:
    if channels.keyphasor is None:
        speed = _placed(_numbers(columns, str(channels.speed), source)[0] * channels.speed_unit, place)
        if np.count_nonzero(np.isfinite(speed)) < 2:
            raise DataError(source, f"its column {channels.speed!r} holds no speeds")
        known = np.isfinite(speed)
        fastest = float(np.abs(speed[known]).max())
        if not fastest * time[1] <= 0.5:
            problem = f"has {fastest:.3g} Hz: more than half a turn between two samples"
            raise DataError(source, f"its column {channels.speed!r} {problem}")
        return shaft_from_speed(time, _one_way(np.interp(time, time[known], speed[known]), source)), [NO_MARK]
    pulses = _numbers(columns, channels.keyphasor, source)[0]
    try:
        shaft = shaft_of(time, _placed(pulses, place), channels.events_per_turn)
    except ValueError as error:
        raise DataError(source, f"its column {channels.keyphasor!r}: {error}") from None
    if shaft is None:
        raise DataError(source, f"its column {channels.keyphasor!r} has fewer pulses than tell a speed")
    no_mark = [] if shaft.marked else [NO_TOOTH.format(channels.events_per_turn)]
    return shaft, [*shaft.told, *no_mark]


def _one_way(speed: NDArray[np.float64], source: str) -> NDArray[np.float64]:
    """Speeds of a shaft that turns one way, at rest 0: little of the other sign is the offset or the noise of its signal."""
    low, high = float(speed.min()), float(speed.max())
    least = STANDS * max(-low, high)
    if low < -least and high > least:
        turns = f"turns at {low:.4g} to {high:.4g} Hz: the shaft reverses"
        raise DataError(source, f"{turns}; give the rows of each way in a file of its own, with measured.sense for that way")
    return np.maximum(-speed if high <= least else speed, 0.0)


def _without_runout(run: Measured, slow_roll: Any) -> Measured:
    """The run without what its shaft shows at slow roll, harmonics of its angle; without slow roll, without its mean position."""
    known = np.isfinite(run.deflection)
    if not known.any():
        raise DataError(run.source, "its probes have no sample that is a number")
    if slow_roll is None:
        return replace(run, deflection=run.deflection - run.deflection[known].mean())
    slow = np.flatnonzero(known & (run.speed >= slow_roll[0]) & (run.speed <= slow_roll[1]))
    slow = slow[:: len(slow) // MOST_SLOW + 1]
    order = np.arange(-HARMONICS, HARMONICS + 1)
    if not slow.size or np.ptp(run.turns[slow]) < 2.0:
        raise DataError(run.source, f"has no two turns between {slow_roll[0]:g} and {slow_roll[1]:g} Hz, measured.slow_roll")
    basis = np.exp(2j * np.pi * np.outer(run.turns[slow], order))
    runout = np.linalg.lstsq(basis, run.deflection[slow], rcond=None)[0]
    taken = np.zeros_like(run.deflection)
    for k, part in zip(order.tolist(), runout, strict=True):
        taken += part * np.exp(2j * np.pi * k * run.turns)
    return replace(run, deflection=run.deflection - taken, runout=np.asarray(runout, dtype=np.complex128), slow_roll=slow_roll)
