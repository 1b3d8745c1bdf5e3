"""What a drive with a torque makes of a motion that takes one: whether it holds the speed, and otherwise where that leads."""

import math
from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np

from rsc.system.system import Drive

OUTCOMES = HOLDS, BRAKES, STOPS, SLOWS = "holds", "brakes", "stops", "slows"


@dataclass(frozen=True)
class Held:
    """What becomes of the speed under a motion, if it goes on taking the torque that it takes at `begin`.

    begin : float Hz, the rotor speed of the motion
    torque : float N m, that the motion takes; drive : float N m, T of the drive at that speed, motor less load
    outcome : str, `HOLDS` (T is no smaller than the torque), `BRAKES` to a speed that it holds, `STOPS`, or
        `SLOWS`, of a torque that falls with the speed, nobody knows how far
    speed : float Hz, at which T is the torque, from `begin` on upwards or downwards: infinite without a bound, 0 of what stops,
        NaN of what slows
    time : float s, until it stands; NaN of what does not stop
    coasting : bool, whether T is that behind `trip`
    """

    begin: float
    torque: float
    drive: float
    outcome: str
    speed: float
    time: float
    coasting: bool


def held(drive: Drive | None, speed: float, torque: float, constant: bool = True) -> tuple[Held, ...]:
    """What becomes of a rotor that turns at a speed in Hz, under each torque of its drive.

    With J Omega' = T(Omega) - torque, T linear between its knots: the next speed at which both are equal, and down to rest the
    sum of J int dOmega/(torque - T) = J log(n_1/n_0)/b over pieces with n = torque - T linear from n_0 to n_1 and of slope b.

    Parameters
    ----------
    drive : Drive or None
        None of a prescribed speed.
    speed : float, Hz, not negative
    torque : float, N m
        That the motion takes; NaN where it is not known.
    constant : bool
        Whether it takes that at lower speeds as well, as what slides does; a rotor that rolls takes less.

    Returns
    -------
    tuple of Held
        For the run, and for the time behind `trip` if there is one; empty without a drive or a torque.
    """
    if drive is None or math.isnan(torque):
        return ()
    return tuple(_held(drive, part, speed, torque, constant) for part in range(len(drive.torques)))


def _held(drive: Drive, part: int, speed: float, torque: float, constant: bool) -> Held:
    Omega = TWO_PI * speed
    supplied = float(drive.torque(Omega, part))
    knots = drive.torques[part][:, 0]
    if supplied >= torque:
        above = [Omega, *knots[knots > Omega]]
        return Held(speed, torque, supplied, HOLDS, _balance(drive, part, above, torque, math.inf) / TWO_PI, math.nan, part > 0)
    if not constant:
        return Held(speed, torque, supplied, SLOWS, math.nan, math.nan, part > 0)
    below = [Omega, *knots[(knots < Omega) & (knots > 0.0)][::-1], 0.0]
    end = _balance(drive, part, below, torque, 0.0)
    if end > 0.0:
        return Held(speed, torque, supplied, BRAKES, end / TWO_PI, math.nan, part > 0)
    missing = torque - drive.torque(below, part)
    if not missing.all():  # it comes to rest with no torque that brakes it, which takes for ever
        return Held(speed, torque, supplied, BRAKES, 0.0, math.nan, part > 0)
    time = drive.inertia * float(sum(map(_inverse, -np.diff(below), missing[:-1], missing[1:])))
    return Held(speed, torque, supplied, STOPS, 0.0, time, part > 0)


def _balance(drive: Drive, part: int, speeds: list[float], torque: float, otherwise: float) -> float:
    """The first speed in rad/s along some from which T(Omega) = torque on; T is linear between them."""
    net = drive.torque(speeds, part) - torque
    if net[0] == 0.0:
        return speeds[0]
    for i in range(len(net) - 1):
        if net[i] * net[i + 1] <= 0.0 and net[i] != net[i + 1]:
            return speeds[i] + (speeds[i + 1] - speeds[i]) * float(net[i] / (net[i] - net[i + 1]))
    return otherwise


def _inverse(width: float, first: float, last: float) -> float:
    """int dx/n over a width along which n is linear."""
    share = last / first - 1.0
    return width / first * (math.log1p(share) / share if share else 1.0)
