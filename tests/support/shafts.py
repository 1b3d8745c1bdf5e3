"""Random shafts whose turns are known: run-ups, coast-downs and stops, seen by a Keyphasor that loses pulses and has noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MOST_RATE, IN_TOOTH = 100e3, 20.0  # samples a second; in a tooth at the largest speed
NOISE = 0.02  # of a pulse


@dataclass(frozen=True)
class Turning:
    """time, speed (n,) s and Hz, turns and pulses (n,) of a shaft with a wheel of so many teeth, of which it lacks some.

    lost : s, from when to when no pulse is seen, or None; corners : (k,) s, where its rise changes
    """

    kind: str
    time: NDArray[np.float64]
    speed: NDArray[np.float64]
    turns: NDArray[np.float64]
    pulses: NDArray[np.float64]
    teeth: int
    lacking: int
    lost: tuple[float, float] | None
    corners: NDArray[np.float64]


def _corners(rng):
    """(kind, times, speeds) of a speed on straight pieces."""
    kind = str(rng.choice(["run-up", "coast-down", "from rest", "to rest", "stops", "constant"]))
    top, low = rng.uniform(20.0, 90.0), rng.uniform(3.0, 15.0)
    rest, ramp, hold = rng.uniform(0.3, 3.0), rng.uniform(3.0, 9.0), rng.uniform(0.5, 3.0)
    pieces = {
        "run-up": [(low, 0.0), (top, ramp), (top, hold)],
        "coast-down": [(top, 0.0), (top, hold), (low, ramp)],
        "from rest": [(0.0, 0.0), (0.0, rest), (top, ramp), (top, hold)],
        "to rest": [(top, 0.0), (top, hold), (0.0, ramp), (0.0, rest)],
        "stops": [(top, 0.0), (top, hold), (0.0, ramp), (0.0, rest), (0.6 * top, ramp)],
        "constant": [(top, 0.0), (top, ramp)],
    }[kind]
    speeds, durations = zip(*pieces, strict=True)
    return kind, np.cumsum(durations), np.array(speeds)


def shaft(rng):
    """A random Turning."""
    kind, times, speeds = _corners(rng)
    teeth = int(np.round(np.exp(rng.uniform(0.0, np.log(60.0)))))
    rate = float(np.clip(IN_TOOTH * teeth * speeds.max(), 4000.0, MOST_RATE))
    time = np.arange(0.0, times[-1], 1.0 / rate)
    speed = np.interp(time, times, speeds)
    before = np.concatenate([[0.0], np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * np.diff(times))])
    i = np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(times) - 2)
    turns = before[i] + 0.5 * (speeds[i] + speed) * (time - times[i]) + rng.uniform(0.0, 1.0)
    lacking = int(rng.integers(1, 3)) if teeth >= 6 and rng.random() < 0.4 else 0
    phase, tooth = (turns * teeth) % 1.0, np.floor(turns * teeth) % teeth
    pulses = np.where((phase < (0.06 if teeth == 1 else 0.4)) & (tooth < teeth - lacking), 1.0, 0.0)
    lost = None
    if rng.random() < 0.5:
        begin = rng.uniform(-0.5, times[-1])
        lost = (begin, begin + np.exp(rng.uniform(np.log(0.02), np.log(3.0))))
        pulses[(time >= lost[0]) & (time < lost[1])] = 0.0
    return Turning(kind, time, speed, turns, pulses + NOISE * rng.normal(size=len(time)), teeth, lacking, lost, times[1:-1])


def apart_from_corners(one):
    """(n,) bool, samples more than a turn away from every corner of the speed."""
    before = np.interp(one.corners, one.time, one.turns)
    return (np.abs(one.turns[:, None] - before) > 1.0).all(axis=1)
