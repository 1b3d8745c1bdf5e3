"""A measured run with the interface of a simulated one, without forces and stator."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.measured.measured import Measured
from rsc.scene.scene import Scene
from rsc.scene.tables.drive import Drive

STEADY = 1e-3  # of its mean: a speed that moves by less is constant
MOST_CORNERS = 2000  # of the schedule that stands for the measured speed


@dataclass(frozen=True)
class MeasuredRun:
    """Samples of a measured run beside the scene that it is compared with, whose drive and rate are those of the measurement.

    scene : Scene; warnings : what is wrong with the signals; source : name of the data file
    time, speed, turns, deflection, runout : as those of `Measured`; window : float s, of its spectra, or None for the usual one
    slow_roll, jitter, marked : as those of `Measured`
    """

    scene: Scene
    time: NDArray[np.float64] = field(repr=False)
    speed: NDArray[np.float64] = field(repr=False)
    turns: NDArray[np.float64] = field(repr=False)
    deflection: NDArray[np.complex128] = field(repr=False)
    runout: NDArray[np.complex128] = field(repr=False)
    warnings: tuple[str, ...] = ()
    source: str = ""
    window: float | None = None
    slow_roll: tuple[float, float] | None = None
    jitter: float | None = None
    marked: bool = True

    summary = None  # of a simulation: status, counters, ledger
    status = "finished"

    @property
    def n_time(self) -> int:
        """Number of samples."""
        return len(self.time)

    def contact_rotor(self) -> NDArray[np.complex128]:
        """(n,) complex m."""
        return self.deflection

    def contact_stator(self) -> NDArray[np.complex128]:
        """(n,) zeros: no probe sees it."""
        return np.zeros(len(self.time), dtype=complex)

    @property
    def normal_force(self) -> NDArray[np.float64]:
        """(n,) zeros: no probe sees it."""
        return np.zeros(len(self.time))

    def samples(self, first: int, last: int) -> "MeasuredRun":
        """The samples from number first to last (exclusive)."""
        own = slice(first, last)
        return replace(
            self, time=self.time[own], speed=self.speed[own], turns=self.turns[own], deflection=self.deflection[own], window=None
        )

    def stretches(self) -> None:
        """Facts of the contact are known of a simulation only."""
        return

    @contextlib.contextmanager
    def kept_open(self) -> Iterator[None]:
        """It lies in memory."""
        yield


def measured_run(measured: Measured, scene: Scene) -> MeasuredRun:
    """A measured run and a scene whose rotor turns forward."""
    rate = 1.0 / float(measured.time[1] - measured.time[0])
    drive, output = _drive_of(measured), replace(scene.output, rate=rate)
    own = replace(scene, drive=drive, output=output)
    names = ("time", "speed", "turns", "deflection", "runout", "warnings", "source", "window", "slow_roll", "jitter", "marked")
    values: dict[str, Any] = {name: getattr(measured, name) for name in names}
    return MeasuredRun(own, **values)


def _drive_of(measured: Measured) -> Drive:
    """The measured speed as a piecewise linear schedule with at most two pieces per window; a constant speed as such."""
    time, speed = measured.time, measured.speed
    count = int(np.clip(2.0 * time[-1] / measured.window, 1, MOST_CORNERS))
    corners = np.linspace(time[0], time[-1], count + 1)
    # a corner is the straight line's value there, of all samples within half a piece on both sides
    edges = np.searchsorted(time, np.concatenate([[time[0]], 0.5 * (corners[1:] + corners[:-1])]))
    edges = np.append(edges, len(time))
    means = np.array([_at(time[a:b], speed[a:b], corner) for a, b, corner in zip(edges[:-1], edges[1:], corners, strict=True)])
    if np.ptp(means) <= STEADY * abs(means.mean()):
        corners, means = corners[[0, -1]], np.full(2, speed.mean())
    means = np.maximum(means, 0.0)  # a straight line beside a standstill may cross it
    return Drive.along(tuple(corners.tolist()), tuple(means.tolist()))


def _at(time: NDArray[np.float64], speed: NDArray[np.float64], where: float) -> float:
    """Value at a time of the straight line through samples."""
    if len(time) < 2:
        return float(speed.mean())
    return float(np.polyfit(time - where, speed, 1)[-1])
