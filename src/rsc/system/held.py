"""What a drive with a torque makes of a motion: what friction takes, what the drive gives, and where that was shown to lead."""

import math
from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np

from rsc.system.system import SystemDrive

OUTCOMES = HOLDS, SPEEDS_UP, BRAKES, CAPTURED, STOPS, UNKNOWN = "holds", "speeds up", "brakes", "captured", "stops", "unknown"


@dataclass(frozen=True)
class Load:
    """The torque of a motion beside that of the drive.

    begin : float Hz, the rotor speed of the motion
    torque : float N m, that friction takes; drive : float N m, T of the drive at that speed, motor less load
    coasting : bool, whether T is that behind `trip`
    """

    begin: float
    torque: float
    drive: float
    coasting: bool


@dataclass(frozen=True)
class Held(Load):
    """What becomes of a motion that is released to the torque of its drive: as `Load`, and what the simulation shows.

    outcome : str, what becomes of the speed: it `HOLDS`, settles above (`SPEEDS_UP`, `CAPTURED` where unbalance takes the
        torque that would speed the rotor up further) or below (`BRAKES`), `STOPS`, or had not settled in the end (`UNKNOWN`)
    speed : float Hz, at which it has settled, 0 where it stops, or at which the run was ended
    time : float s, after which speed and kind stay; of what is not settled the length of the run
    rate : float Hz/s, at which the speed still changes at the end of what is not settled, else 0
    motion : str, the `rsc.measure.kinds.Kind` at the end; frequency : float Hz, at which that turns, NaN where it does not
    left_speed : float Hz, left_time : float s, where and when the motion is left for good; NaN of one that stays
    passed : str, a more dangerous kind of motion on the way, "" for none
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
    """What a motion at a speed in Hz takes and the drive gives, for the run and for the time behind `trip` if there is one.

    Parameters
    ----------
    drive : SystemDrive or None
        None of a prescribed speed.
    speed : float, Hz, not negative
    torque : float, N m
        That friction takes; NaN where it is not known.

    Returns
    -------
    tuple of Load
        Empty without a drive or a torque.
    """
    if drive is None or math.isnan(torque):
        return ()
    return tuple(Load(speed, torque, float(drive.torque(TWO_PI * speed, part)), part > 0) for part in range(len(drive.torques)))


def balance_above(drive: SystemDrive, part: int, speed: float, torque: float) -> float:
    """The first speed in Hz, from one in Hz on upwards, at which T falls to a torque in N m; infinite without a bound."""
    knots = drive.torques[part][:, 0]
    speeds = np.array([TWO_PI * speed, *knots[knots > TWO_PI * speed]])
    net = drive.torque(speeds, part) - torque
    if net[0] <= 0.0:
        return speed
    for i in range(len(net) - 1):
        if net[i + 1] <= 0.0:
            return float(speeds[i] + (speeds[i + 1] - speeds[i]) * net[i] / (net[i] - net[i + 1])) / TWO_PI
    return math.inf
