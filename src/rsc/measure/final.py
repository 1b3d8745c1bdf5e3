"""The motion in which a run ends, from its last window: one word and a few numbers."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rsc.measure import spectra
from rsc.measure.features import RunLike, slip
from rsc.measure.windows import CLEAR_LINE, FORWARD, LINE_FLOOR, ROLLING

# how a run may end; None of them where it has no samples enough
NO_CONTACT, FORWARD_RUB, WHIRL, ROLLS, INTERMITTENT, UNKNOWN, RUNS_AWAY = MOTIONS = (
    "no contact", "forward rub", "backward whirl", "rolling", "intermittent contact", "unknown", "runs away"
)  # fmt: skip
_DIVERGED = "diverged"  # the status of a run that left every bound
PART = 0.25  # of the run that the last window takes at constant speed
LASTING = 0.99  # share of the time in contact from which it is permanent
FLOOR = 1e-3  # of the largest bin: what is weaker is no line


@dataclass(frozen=True)
class FinalMotion:
    """The last window of a run, at the contact coordinate of the rotor.

    motion : str, one of `MOTIONS`
    backward_frequency Hz (negative) and backward_amplitude m : the strongest backward line, NaN where there is none
    synchronous_amplitude : m, the line at the rotor speed; NaN where there is none
    amplitude_min, amplitude_max : m, of |r|
    force_mean, force_max : N, normal force
    contact_share : share of the time in contact, 0 to 1
    """

    motion: str
    backward_frequency: float
    backward_amplitude: float
    synchronous_amplitude: float
    amplitude_min: float
    amplitude_max: float
    force_mean: float
    force_max: float
    contact_share: float


_NOTHING = FinalMotion(UNKNOWN, *(math.nan,) * 8)


class EndedRun(RunLike, Protocol):
    """A run that also tells how it ended, as `rsc.Trajectory` does."""

    @property
    def status(self) -> str: ...


def final_motion(result: EndedRun) -> FinalMotion:
    """The motion at the end of a run: `final_motions` of one."""
    return final_motions([result])[0]


def final_motions(results: Sequence[EndedRun]) -> list[FinalMotion]:
    """The motions at the ends of runs.

    The window is the last quarter of a run, or shorter where the speed changes, so that a synchronous line stays within one bin.
    The motion is a backward whirl where there is contact and a clear backward line, rolling where such a contact sticks for more
    than half of the time, a forward rub where contact is permanent and without a clear backward line. A backward line at the
    rotor speed is half of an ellipse, unless it is the larger half and contact permanent. A run that diverged runs away.

    Parameters
    ----------
    results : sequence of Trajectory

    Returns
    -------
    list of FinalMotion
    """
    motions = [_NOTHING] * len(results)
    groups: dict[tuple[int, float], list[tuple[int, _Window]]] = {}
    for i, result in enumerate(results):
        window = _last_window(result)
        if window is not None:
            groups.setdefault((len(window.rotor), window.rate), []).append((i, window))
    for (_, rate), members in groups.items():  # spectra of as many samples go together
        windows = [window for _, window in members]
        lines = _lines(windows, rate)
        for (i, window), *numbers in zip(members, *(column.tolist() for column in lines), strict=True):
            motions[i] = _motion(window, *numbers)
    for i, result in enumerate(results):
        if result.status == _DIVERGED:
            motions[i] = replace(motions[i], motion=RUNS_AWAY)
    return motions


@dataclass(frozen=True)
class _Window:
    """The last samples of a run: rotor (n,) m, force (n,) N, sticks (n,) bool; their rate, rotor speed and gap."""

    rotor: NDArray[np.complex128]
    force: NDArray[np.float64]
    sticks: NDArray[np.bool_]
    rate: float
    speed: float
    gap: float


def _last_window(result: RunLike) -> _Window | None:
    """The last window of a run; None where it has no samples enough, or some that are not finite."""
    time, speed = result.time, result.speed
    n = len(time)
    if n < spectra.MIN_SAMPLES:
        return None
    rate = result.scene.output.rate
    change = abs(float(speed[-1] - speed[-2])) * rate
    count = max(int(PART * n), spectra.MIN_SAMPLES)
    if change > 0.0:
        count = min(count, round(spectra.window_duration(change, float(time[-1]), rate) * rate))
    last, contact = slice(n - count, n), result.scene.contact
    rotor, force = result.contact_rotor()[last], result.normal_force[last]
    if not np.isfinite(rotor).all():
        return None
    sticks = np.zeros(count, dtype=bool)
    if contact.diameter is not None:
        sticks = (np.abs(slip(result)[last]) < contact.slip_velocity) & (force > 0.0)
    return _Window(rotor, force, sticks, rate, float(speed[last].mean()), contact.gap)


def _lines(windows: Sequence[_Window], rate: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Frequency (Hz) and amplitude (m) of the strongest backward line, and the amplitude at the rotor speed, of equal windows."""
    n = len(windows[0].rotor)
    frequency = np.fft.fftshift(np.fft.fftfreq(n, 1.0 / rate))
    weights = (1.0 - np.cos(2.0 * np.pi * np.arange(n) / n)) / n
    spectrum = np.fft.fftshift(np.fft.fft(np.array([window.rotor for window in windows]) * weights), axes=1)
    speed = np.array([window.speed for window in windows])
    fall = spectra.Waterfall(frequency, speed, np.zeros(len(windows)), np.abs(spectrum), n / rate, n)
    seen = fall.amplitude > FLOOR * fall.amplitude.max(axis=1, keepdims=True)
    bin_width = rate / n
    lines = spectra.strongest_line(fall, seen & (frequency < -0.5 * bin_width))
    synchronous = spectra.strongest_line(fall, np.abs(frequency - speed[:, None]) <= 2.0 * bin_width)
    return *lines, synchronous[1]


def _motion(window: _Window, frequency: float, backward: float, synchronous: float) -> FinalMotion:
    size, touching = np.abs(window.rotor), window.force > 0.0
    return FinalMotion(
        motion=_word(window, touching, (frequency, backward), synchronous),
        backward_frequency=frequency,
        backward_amplitude=backward,
        synchronous_amplitude=synchronous,
        amplitude_min=float(size.min()),
        amplitude_max=float(size.max()),
        force_mean=float(window.force.mean()),
        force_max=float(window.force.max()),
        contact_share=float(touching.mean()),
    )


def _word(window: _Window, touching: NDArray[np.bool_], backward: tuple[float, float], synchronous: float) -> str:
    """The word for a window; backward: frequency and amplitude of its line."""
    if not touching.any():
        return NO_CONTACT
    if window.sticks.sum() > ROLLING * touching.sum():
        return ROLLS
    line, forward = np.nan_to_num([backward[1], synchronous])
    lasting = bool(touching.mean() > LASTING)
    # half of an ellipse, by supports or loads that tell directions apart; a whirl presses all the time, and is the larger half
    ellipse = abs(backward[0] + window.speed) * len(touching) < window.rate and not (lasting and line > forward)
    if line >= (CLEAR_LINE if forward > FORWARD * line else LINE_FLOOR) * window.gap and not ellipse:
        return WHIRL
    return FORWARD_RUB if lasting else INTERMITTENT
