"""Spectra, envelopes and contact strip of a run: `rsc.measure.spectra` applied to a Trajectory at its contact coordinate."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rsc.arguments import REAL, RUN, TEXT, WHOLE, optional, takes
from rsc.measure import envelopes, spectra, window_length


class RunLike(Protocol):
    """The parts of a `rsc.Trajectory` that its features are taken from: samples over time and the scene."""

    @property
    def scene(self) -> Any: ...

    @property
    def time(self) -> NDArray[np.float64]: ...

    @property
    def speed(self) -> NDArray[np.float64]: ...

    @property
    def normal_force(self) -> NDArray[np.float64]: ...

    @property
    def friction_force(self) -> NDArray[np.float64]: ...

    @property
    def tangential_velocity(self) -> NDArray[np.float64]: ...

    def contact_rotor(self) -> NDArray[np.complex128]: ...

    def contact_stator(self) -> NDArray[np.complex128]: ...


@takes(result=RUN, window=optional(REAL), f_max=optional(REAL))
def waterfall(result: RunLike, window: float | None = None, f_max: float | None = None) -> spectra.Waterfall:
    """Two-sided amplitude spectra of the contacting rotor coordinate over the run.

    Parameters
    ----------
    result : Trajectory
    window : float, s, optional
        Default: chosen from the run-up rate so that a line stays within one bin.
    f_max : float, Hz, optional
        Keep only |frequency| <= f_max.

    Returns
    -------
    spectra.Waterfall

    Examples
    --------
    >>> waterfall = rsc.waterfall(rsc.simulate(rsc.load_scene("laval.toml")), f_max=100.0)
    >>> waterfall.amplitude.shape == (len(waterfall.speed), len(waterfall.frequency))
    True
    """
    window = getattr(result, "window", None) if window is None else window  # a measured run's speed is never smooth
    return spectra.waterfall(result.time, result.contact_rotor(), result.speed, window=window, f_max=f_max)


@takes(result=RUN, side=TEXT, count=WHOLE, window=optional(REAL))
def spectral_peaks(
    result: RunLike, side: spectra.Side = "negative", count: int = 3, window: float | None = None
) -> spectra.Peaks:
    """The strongest lines of each window on one side, interpolated between bins; see `spectra.spectral_peaks`.

    Examples
    --------
    >>> peaks = rsc.spectral_peaks(rsc.simulate(rsc.load_scene("laval.toml")), count=1)
    >>> print(f"{peaks.frequency[48, 0]:.1f} Hz")  # in the middle of the run
    -60.6 Hz
    """
    return spectra.spectral_peaks(waterfall(result, window=window), side=side, count=count)


@takes(result=RUN, window=optional(REAL))
def envelope(result: RunLike, window: float | None = None) -> envelopes.Envelope:
    """Smallest and largest |r| at the contacting rotor coordinate per window; see `envelopes.envelope`.

    Examples
    --------
    >>> envelope = rsc.envelope(rsc.simulate(rsc.load_scene("laval.toml")))
    >>> print(f"{1e3 * envelope.maximum.max():.2f} mm")
    2.86 mm
    """
    if window is None:
        window = getattr(result, "window", None) or default_window(result)
    return envelopes.envelope(result.time, result.contact_rotor(), result.speed, window)


def default_window(result: RunLike) -> float:
    """Default window length in s of the spectra of a run."""
    drive = getattr(result, "scheduled", result).scene.drive
    steepest = np.abs(np.diff(drive.speed) / np.diff(drive.time)).max()
    time = result.time
    return window_length.window_duration(float(steepest), float(time[-1] - time[0]), result.scene.output.rate)


@dataclass(frozen=True)
class ContactStrip:
    """Contact over a run, means over the windows of a waterfall, and the largest force in each; arrays (n_w,).

    speed Hz, time s, share of the time in contact (0 to 1), normal_force N, peak_force N, slip_velocity m/s (None without a
    contact diameter), friction_power W: lost in the slip, or, without a diameter, fed into the lateral motion
    """

    speed: NDArray[np.float64]
    time: NDArray[np.float64]
    share: NDArray[np.float64]
    normal_force: NDArray[np.float64]
    peak_force: NDArray[np.float64]
    slip_velocity: NDArray[np.float64] | None
    friction_power: NDArray[np.float64]


def contact_strip(result: RunLike, fall: spectra.Waterfall, features: Any) -> ContactStrip:
    """Contact share, normal force, slip and friction power of a run per window of its waterfall; `features` of the same windows,
    `rsc.measure.windows.Features`."""
    diameter = result.scene.contact.diameter
    velocity = result.tangential_velocity if diameter is None else slip(result)
    power = result.friction_force * velocity * (1.0 if diameter is not None else -1.0)
    return ContactStrip(
        speed=fall.speed,
        time=fall.time,
        share=features.share,
        normal_force=features.force,
        peak_force=features.force_max,
        slip_velocity=None if diameter is None else window_means(result.time, velocity, fall),
        friction_power=window_means(result.time, power, fall),
    )


def slip(result: Any) -> NDArray[np.float64]:
    """Slip in m/s at the samples of a run with a contact diameter, Omega d_R/2 + v_t, less omega (d_R/2 + gap) where a race turns
    at omega."""
    contact = result.scene.contact
    passed = result.tangential_velocity + np.pi * result.speed * contact.diameter
    if contact.race_inertia is None:
        return passed
    return passed - np.pi * result.race_speed * (contact.diameter + 2.0 * contact.gap)


def window_means(time: NDArray[np.float64], values: ArrayLike, fall: spectra.Waterfall) -> NDArray[np.float64]:
    """(n_w,) means of samples over the windows of a waterfall, NaN where one of them is not finite."""
    first, last = _edges(time, fall)
    known = np.isfinite(values)
    total, count = (np.concatenate([[0.0], np.cumsum(each, dtype=float)]) for each in (np.where(known, values, 0.0), known))
    means = (total[last] - total[first]) / (last - first)
    return np.where(count[last] - count[first] == last - first, means, np.nan)


def _edges(time: NDArray[np.float64], fall: spectra.Waterfall) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """(n_w,) numbers of the first sample of each window of a waterfall, and of the sample after its last."""
    first = np.searchsorted(time, fall.time - 0.5 * fall.window - 0.5 * (time[1] - time[0]))
    return first, np.minimum(first + fall.n_samples, len(time))


def turns(drive: Any, time: ArrayLike) -> NDArray[np.float64]:
    """(n,) turns of the shaft since the start of a speed schedule of straight pieces at times (n,) in s."""
    time, corners, speeds = (np.asarray(values, dtype=float) for values in (time, drive.time, drive.speed))
    before = np.concatenate([[0.0], np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * np.diff(corners))])
    i = np.clip(np.searchsorted(corners, time, side="right") - 1, 0, len(corners) - 1)
    return before[i] + 0.5 * (speeds[i] + np.interp(time, corners, speeds)) * (time - corners[i])


def turned(run: Any, time: ArrayLike) -> NDArray[np.float64]:
    """(n,) turns of the shaft of a run at times (n,) in s: as its Keyphasor saw them if it was measured, else by its schedule."""
    seen = getattr(run, "turns", None)
    if seen is None:
        return turns(getattr(run, "scheduled", run).scene.drive, time)
    return np.interp(np.asarray(time, dtype=float), run.time, seen)


def ellipse(motion: NDArray[np.complex128], turned: ArrayLike) -> tuple[complex, complex]:
    """A motion filtered at one frequency, as a Hann window over all of it reads its two lines there.

    Parameters
    ----------
    motion : (n,) complex m, samples of equal distance
    turned : (n,) turns of that frequency at the samples, which may change on the way: of the shaft for 1X

    Returns
    -------
    forward, backward : complex m
        The filtered motion is forward e^(i phi) + backward e^(-i phi) with phi = 2 pi turned, an ellipse of semi-axes
        |forward| + |backward| and ||forward| - |backward||; a circle where one of them is 0.
    """
    turn = np.exp(2j * np.pi * np.asarray(turned, dtype=float))
    weighted = spectra.weights(len(motion)) * motion
    return complex(weighted @ turn.conj()), complex(weighted @ turn)


def revolution_marks(result: RunLike) -> NDArray[np.intp]:
    """Indices of the first samples after each completed revolution of the shaft."""
    return np.flatnonzero(np.diff(np.floor(turned(result, result.time) + 1e-9)) != 0.0) + 1
