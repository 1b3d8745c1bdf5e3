"""`[drive]` with a torque: knots of the torque over the speed, and how fast they let a rotor turn."""

import math

import numpy as np

from rsc.scene.keys.keys import Later, Listed, Number, RawTable, Sequence, Values, as_list

Knots = tuple[tuple[float, float], ...]

_SPEED, _TORQUE = Number("frequency", low=0.0, high=1e6), Number("torque")
TORQUE = Later("a list of [speed in Hz, torque in N m]", (Sequence(Listed((_SPEED, _TORQUE))),))
MEANING = "Torque of the motor less that of the load over the speed: linear between knots, constant beyond the ends."


def read(table: RawTable, values: Values, speed_reader: Number) -> None:
    """Read the keys of a drive with a torque in place.

    Raises
    ------
    SceneError
        More than one speed, knots out of order, or a rotor that never moves.
    """
    if as_list(values["speed"]) is not None:
        table.refuse("speed", values["speed"], "one number, the first speed", "with drive.torque what follows is integrated")
    first, duration, trip = speed_reader.read(table, "speed", values["speed"]), values["duration"], values["trip"]
    if first < 0.0:
        table.refuse("speed", first, ">= 0 Hz", "a drive with a torque turns forward")
    torque = _read_knots(table, "torque", values["torque"])
    if first == 0.0 and torque_at(torque, 0.0) <= 0.0:
        table.refuse("torque", values["torque"], "> 0 N m at a standstill", "the rotor would never move")
    values["speed"], values["torque"] = (first, first), torque
    if trip is None:
        return
    if not 0.0 < trip < duration:
        table.refuse("trip", trip, f"between 0 s and drive.duration = {duration:g} s")
    values["coast"] = ((0.0, 0.0),) if values["coast"] is None else _read_knots(table, "coast", values["coast"], 1)


def _read_knots(table, key, raw, least=2):
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
            table.refuse(f"{key}[{i}][0]", made[i][0], f"more than {made[i - 1][0]:g} Hz", "knots stand in order")
    return tuple(made)


def torque_at(knots: Knots, speed: float) -> float:
    """Torque in N m at a speed in Hz."""
    return float(np.interp(speed, *np.array(knots).T))


def fastest(drive) -> float:
    """A speed in Hz that the run hardly passes: where the torque ends, or what its largest gives in the time."""
    largest = drive.speed[0]
    for knots in filter(None, (drive.torque, drive.coast)):
        speeds, torque = zip(*knots, strict=True)
        falling = [
            a + (b - a) * p / (p - q) for a, b, p, q in zip(speeds[:-1], speeds[1:], torque[:-1], torque[1:], strict=True)
            if p > 0.0 >= q
        ]  # fmt: skip
        ends = math.inf if torque[-1] > 0.0 else max(falling, default=0.0)
        gained = max(*torque, 0.0) * drive.duration / drive.inertia / (2.0 * math.pi)
        largest = max(largest, min(ends, drive.speed[0] + gained))
    return largest
