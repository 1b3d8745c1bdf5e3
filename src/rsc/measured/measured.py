"""`Measured`: a run as two probes and a Keyphasor saw it, with the parts that spectra, peaks, lines and envelopes take."""

import hashlib
import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.arguments import PATH, takes
from rsc.errors import DataError, one_line
from rsc.measure import window_length
from rsc.measured.channel import Channel
from rsc.measured.clock import CommonClock, Signal, at, clock_of
from rsc.measured.keys import Channels, read_channels
from rsc.measured.reading import Selection, channels_of
from rsc.measured.sampled import signals_of
from rsc.measured.scales import metres, turns_a_second
from rsc.measured.shaft import MeasuredShaft, shaft_from_speed, shaft_of
from rsc.measured.troubles import clipped, turned_backwards
from rsc.presented import Brief

LARGEST = 1e12  # of a column, beyond which a number is none
MOST_SLOW = 50_000  # samples that tell runout
HARMONICS = 10  # of the shaft, of which runout consists
NO_MARK = "no Keyphasor: phases at the rotor speed are counted from the first sample, and no fit takes them"
NO_TOOTH = (
    "it is unknown which of {} pulses in a turn is the mark: "
    "phases at the rotor speed are measured from the first one and not fitted"
)
STANDS = 0.02  # of the largest speed, below which a measured one of the other sign is that of a shaft at rest
_SPANS = 64  # of a run, between whose mean speeds its steepest rise is read


@dataclass(frozen=True, repr=False)
class Measured(Brief):
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
        return window_length.window_duration(steepest, float(self.time[-1]), rate)


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

    Examples
    --------
    >>> path = rsc.write_measured(rsc.simulate(rsc.load_scene("laval.toml")), "bench.toml")
    >>> measured = rsc.read_measured(path)
    >>> round(measured.speed[0]), round(measured.speed[-1])  # Hz
    (20, 100)
    """
    path = Path(path)
    table = read_channels(path if not path.name or path.suffix.lower() == ".toml" else path.with_suffix(".toml"))
    data = path.parent / table.file
    names = [probe.column for probe in table.probe] + [str(table.keyphasor or table.speed), *([table.time] if table.time else [])]
    return _measured(table, channels_of(data, names), one_line(data))


def _measured(table: Channels, selection: Selection, source: str) -> Measured:
    shaft_name = str(table.keyphasor or table.speed)
    *probes, pulses = (_numbers(selection, name, source) for name in (*(probe.column for probe in table.probe), shaft_name))
    warnings = [line for probe, (values, _) in zip(table.probe, probes, strict=True) for line in clipped(probe.column, values)]
    values = {probe.column: numbers for probe, (numbers, _) in zip(table.probe, probes, strict=True)} | {shaft_name: pulses[0]}
    signals, told = signals_of(table, selection, values, source)
    warnings += [*told, *(line for _, lines in probes for line in lines)]
    seen = [signals[probe.column] for probe in table.probe]
    clock, told = clock_of(seen, [signals[shaft_name]], source)
    warnings += [*told, *selection.told]
    lengths, told = _lengths(table, selection, [at(signal, clock) for signal in seen], source)
    warnings += told
    r = _plane(*lengths, *(np.deg2rad(probe.angle) for probe in table.probe))
    shaft, told = _shaft(table, selection.channels[shaft_name], signals[shaft_name], clock, source)
    warnings += told
    turns = shaft.turns + table.keyphasor_angle / 360.0
    if table.sense == "z to y":
        r, turns = -r.conj(), shaft.turns - table.keyphasor_angle / 360.0
    if table.slow_roll is not None and not (shaft.marked or shaft.known.all()):
        raise DataError(source, "loses count of a wheel without a mark: leave measured.slow_roll out, runout cannot be taken off")
    nothing, r = np.zeros(2 * HARMONICS + 1, complex), np.where(shaft.known, r, np.nan)
    run = Measured(clock.times, shaft.speed, r, turns, (), nothing, source, jitter=shaft.jitter, marked=shaft.marked)
    run = _without_runout(run, table.slow_roll)
    return replace(run, warnings=(*turned_backwards(run.deflection, run.turns), *warnings))


def _numbers(selection: Selection, name: str, source: str) -> tuple[NDArray[np.float64], list[str]]:
    """A column with NaN for invalid numbers, and remarks."""
    column = np.asarray(selection.channels[name].numbers)
    with np.errstate(invalid="ignore"):
        known = np.abs(column) < LARGEST
    count = np.count_nonzero(~known)
    told = [f"{count} samples of {one_line(name)} are no numbers: windows on them are empty"] if count else []
    return np.where(known, column, np.nan), told


def _lengths(
    table: Channels, selection: Selection, signals: list[NDArray[np.float64]], source: str
) -> tuple[list[NDArray[np.float64]], list[str]]:
    """The signals of the probes in m, and remarks."""
    lengths, told = [], []
    if not selection.full_scale and table.full_scale != 1.0:
        told.append("measured.full_scale is that of a WAV file: not used")
    for number, (probe, signal) in enumerate(zip(table.probe, signals, strict=True)):
        full_scale = table.full_scale if selection.full_scale else 1.0
        scale, lines = metres(probe, number, selection.channels[probe.column], full_scale, source)
        lengths.append(signal * scale)
        told += lines
    return lengths, told


def _plane(first: NDArray[np.float64], second: NDArray[np.float64], alpha: Any, beta: Any) -> NDArray[np.complex128]:
    """r = y + i z of two displacements p = y cos(angle) + z sin(angle)."""
    y = first * np.sin(beta) - second * np.sin(alpha)
    z = second * np.cos(alpha) - first * np.cos(beta)
    return (y + 1j * z) / np.sin(beta - alpha)


def _shaft(table: Channels, channel: Channel, signal: Signal, clock: CommonClock, source: str) -> tuple[MeasuredShaft, list[str]]:
    """The MeasuredShaft at the times of a clock, and remarks. Pulses keep their own times: resampling would move them."""
    time = signal.times_after(clock.start)
    if table.keyphasor is None:
        size, told = turns_a_second(table, channel, source)
        speed = signal.values * size
        if np.count_nonzero(np.isfinite(speed)) < 2:
            raise DataError(source, f"its column {table.speed!r} holds no speeds")
        known = np.isfinite(speed)
        fastest = float(np.abs(speed[known]).max())
        if not fastest * clock.step <= 0.5:
            problem = f"has {fastest:.3g} Hz: more than half a turn between two samples"
            raise DataError(source, f"its column {table.speed!r} {problem}")
        even = clock.times
        return shaft_from_speed(even, _one_way(np.interp(even, time[known], speed[known]), source)), [NO_MARK, *told]
    try:
        shaft = shaft_of(time, signal.values, table.events_per_turn)
    except ValueError as error:
        raise DataError(source, f"its column {table.keyphasor!r}: {error}") from None
    if shaft is None:
        raise DataError(source, f"its column {table.keyphasor!r} has fewer pulses than tell a speed")
    no_mark = [] if shaft.marked else [NO_TOOTH.format(table.events_per_turn)]
    return _on_clock(shaft, time, clock), [*shaft.told, *no_mark]


def _one_way(speed: NDArray[np.float64], source: str) -> NDArray[np.float64]:
    """Speeds of a shaft that turns one way, at rest 0: little of the other sign is the offset or the noise of its signal."""
    low, high = float(speed.min()), float(speed.max())
    least = STANDS * max(-low, high)
    if low < -least and high > least:
        turns = f"turns at {low:.4g} to {high:.4g} Hz: the shaft reverses"
        raise DataError(source, f"{turns}; give the rows of each direction in a separate file, with its measured.sense")
    return np.maximum(-speed if high <= least else speed, 0.0)


def _on_clock(shaft: MeasuredShaft, time: NDArray[np.float64], clock: CommonClock) -> MeasuredShaft:
    """The MeasuredShaft at the times of a clock, from its times."""
    even = clock.times
    if len(time) == clock.samples and abs(time[0]) <= 1e-9 * clock.step and abs(time[-1] - even[-1]) <= 1e-6 * clock.step:
        return shaft
    turns, speed, known = (np.interp(even, time, values) for values in (shaft.turns, shaft.speed, shaft.known))
    return shaft._replace(turns=turns, speed=speed, known=known == 1.0)


def _without_runout(run: Measured, slow_roll: Any) -> Measured:
    """The run minus its slow-roll harmonics or, without slow roll, minus its mean position."""
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
