"""Motions under a torque-limited drive: friction torque, drive torque, and the outcome that a simulation showed."""

import math
from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np

from rsc.system.system import SystemDrive

OUTCOMES = HOLDS, SPEEDS_UP, BRAKES, CAPTURED, STOPS, UNKNOWN = "holds", "speeds up", "brakes", "captured", "stops", "unknown"


@dataclass(frozen=True)
class Load:
    """Friction torque of a motion compared with the drive torque.

    begin : float Hz, rotor speed of the motion
    torque : float N m, friction torque on the rotor; drive : float N m, drive torque T at that speed, motor less load
    coasting : bool, whether T is the torque after the trip
    """

    begin: float
    torque: float
    drive: float
    coasting: bool


@dataclass(frozen=True)
class Held(Load):
    """Outcome of a motion when the rotor is released to its torque-limited drive: a `Load` and the simulated end.

    outcome : str, the speed `HOLDS`, settles higher (`SPEEDS_UP`, or `CAPTURED` where unbalance response absorbs the
        accelerating torque) or lower (`BRAKES`), `STOPS`, or had not settled by the end of the run (`UNKNOWN`)
    speed : float Hz, settled speed, 0 if the rotor stops, or the speed at the end of the run
    time : float s, after which speed and kind stay the same; the length of the run if not settled
    rate : float Hz/s, rate of the speed at the end of the run if not settled, else 0
    motion : str, final `rsc.measure.kinds.Kind`; frequency : float Hz, its whirl frequency, NaN if it does not whirl
    left_speed : float Hz, left_time : float s, where and when the motion ends for good; NaN if it stays
    passed : str, a more dangerous kind of motion on the way, "" if none
    """

    outcome: str
    speed: float
    time: float
    rate: float
    motion: str
    frequency: float
    left_speed: float
    left_time: float
    passed: str


def loads(drive: SystemDrive | None, speed: float, torque: float) -> tuple[Load, ...]:
    """Friction and drive torque of a motion at a speed in Hz, for the powered run and, if there is a trip, for the coast-down.

    Parameters
    ----------
    drive : SystemDrive or None
        None for a prescribed speed.
    speed : float, Hz, not negative
    torque : float, N m
        Friction torque; NaN if unknown.

    Returns
    -------
    tuple of Load
        Empty without a drive or a torque.
    """
    if drive is None or math.isnan(torque):
        return ()
    return tuple(Load(speed, torque, float(drive.torque(TWO_PI * speed, part)), part > 0) for part in range(len(drive.torques)))


def balance_above(drive: SystemDrive, part: int, speed: float, torque: float) -> float:
    """Lowest speed in Hz from `speed` upwards at which the drive torque T falls to `torque` in N m; infinite if none."""
    knots = drive.torques[part][:, 0]
    speeds = np.array([TWO_PI * speed, *knots[knots > TWO_PI * speed]])
    net = drive.torque(speeds, part) - torque
    if net[0] <= 0.0:
        return speed
    for i in range(len(net) - 1):
        if net[i + 1] <= 0.0:
            return float(speeds[i] + (speeds[i + 1] - speeds[i]) * net[i] / (net[i] - net[i + 1])) / TWO_PI
    return math.inf
