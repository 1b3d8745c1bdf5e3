"""Torque-limited `[drive]`: knots of torque over speed, and the speed that the rotor can reach."""

import math
from typing import Any

import numpy as np

from rsc.scene.keys.keys import RawTable, Values
from rsc.scene.keys.readers import Later, Listed, Number, Sequence, as_list

Knots = tuple[tuple[float, float], ...]

_SPEED, _TORQUE = Number("frequency", low=0.0, high=1e6), Number("torque")
TORQUE = Later("a list of [speed in Hz, torque in N m]", (Sequence(Listed((_SPEED, _TORQUE))),))
MEANING = "Torque of motor minus load over speed: linear between knots, constant beyond."


def read(table: RawTable, values: Values, speed_reader: Number) -> None:
    """Read the keys of a torque-limited drive, in place.

    Raises
    ------
    SceneError
        More than one speed, knots out of order, or a rotor that never starts.
    """
    if as_list(values["speed"]) is not None:
        table.refuse("speed", values["speed"], "one number, the initial speed", "with drive.torque the speed is then integrated")
    first, duration, trip = speed_reader.read(table, "speed", values["speed"]), values["duration"], values["trip"]
    if first < 0.0:
        table.refuse("speed", first, ">= 0 Hz", "a torque-limited drive turns forward")
    torque = _read_knots(table, "torque", values["torque"])
    if first == 0.0 and torque_at(torque, 0.0) <= 0.0:
        table.refuse("torque", values["torque"], "> 0 N m at standstill", "the rotor would never start")
    values["speed"], values["torque"] = (first, first), torque
    if trip is None:
        return
    if not 0.0 < trip < duration:
        table.refuse("trip", trip, f"between 0 s and drive.duration = {duration:g} s")
    values["coast"] = ((0.0, 0.0),) if values["coast"] is None else _read_knots(table, "coast", values["coast"], 1)


def _read_knots(table: RawTable, key: str, raw: Any, least: int = 2) -> Knots:
    knots = as_list(raw)
    if knots is None or len(knots) < least:
        table.refuse(key, raw, "a list of at least two knots [speed in Hz, torque in N m]")
    made = []
    for i, knot in enumerate(knots):
        parts = as_list(knot)
        if parts is None or len(parts) != 2:
            table.refuse(f"{key}[{i}]", knot, "[speed in Hz, torque in N m]")
        made.append((_SPEED.read(table, f"{key}[{i}][0]", parts[0]), _TORQUE.read(table, f"{key}[{i}][1]", parts[1])))
        if i and not made[i][0] > made[i - 1][0]:
            table.refuse(f"{key}[{i}][0]", made[i][0], f"more than {made[i - 1][0]:g} Hz", "knots must be in order")
    return tuple(made)


def torque_at(knots: Knots, speed: float) -> float:
    """Torque in N m at a speed in Hz."""
    return float(np.interp(speed, *np.array(knots).T))


def fastest(drive: Any) -> float:
    """Estimate of the highest speed in Hz: where the torque vanishes, or what the largest torque achieves within the run."""
    largest = drive.speed[0]
    for knots in drive.curves:
        speeds, torque = zip(*knots, strict=True)
        falling = [
            a + (b - a) * p / (p - q) for a, b, p, q in zip(speeds[:-1], speeds[1:], torque[:-1], torque[1:], strict=True)
            if p > 0.0 >= q
        ]  # fmt: skip
        ends = math.inf if torque[-1] > 0.0 else max(falling, default=0.0)
        gained = max(*torque, 0.0) * drive.duration / drive.inertia / (2.0 * math.pi)
        largest = max(largest, min(ends, drive.speed[0] + gained))
    return largest
