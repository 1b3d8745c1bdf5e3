"""Angle and speed of the shaft over a run, and where they are known: between pulses, and at rest.

Pulses are placed on the teeth of their wheel (wheel.py, counting.py), smoothed piece by piece (smooth.py), and put together here.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.measured.counting import counted, displaced, without_doubled
from rsc.measured.events import edges_of
from rsc.measured.pieces import known_between
from rsc.measured.smooth import LEAST_EVENTS, Events
from rsc.measured.wheel import Wheel, placed, teeth_instead, wheel_of


class MeasuredShaft(NamedTuple):
    """turns (n,) of the mark past the Keyphasor, and speed (n,) Hz, both never falling back; known (n,) bool, where pulses or a
    standstill tell them; numbers of events, of those missing that were counted, and of those left out; jitter in s, deviation of
    the times of events from an even rise of the speed, None without events; marked : bool, whether the direction of the mark is
    known; told : what to tell of it, in lines."""

    turns: NDArray[np.float64]
    speed: NDArray[np.float64]
    known: NDArray[np.bool_]
    events: int
    missing: int
    extra: int
    jitter: float | None
    marked: bool
    told: tuple[str, ...]


def shaft_of(time: NDArray[np.float64], pulses: NDArray[np.float64], events_per_turn: int) -> MeasuredShaft | None:
    """The MeasuredShaft at the samples of a signal of pulses; None where there are fewer than `LEAST_EVENTS`.

    Parameters
    ----------
    time, pulses : (n,) s and any unit; NaN where there is no sample
    events_per_turn : int, teeth of the wheel, with those that it lacks

    Raises
    ------
    ValueError
        The wheel has more teeth than `events_per_turn`; says how many.
    """
    raw, resolution = edges_of(time, pulses)
    if len(raw) < LEAST_EVENTS:
        return None
    wheel = wheel_of(raw, events_per_turn)
    if wheel is None:
        instead = teeth_instead(raw, events_per_turn)
        if instead is not None:
            lacking = instead - events_per_turn
            raise ValueError(
                f"its pulses are those of a wheel of {instead} teeth that lacks {lacking}: events_per_turn must be {instead}, "
                "missing teeth counted"
            )
        times = without_doubled(raw)
        extra = len(raw) - len(times)
        times = np.delete(times, displaced(times))
        places, unsure, missing = counted(times)
    else:
        times, places, numbers, extra = placed(raw, wheel)
        unsure = counted(times, places).unsure
        missing = int((np.diff(numbers) - 1)[~unsure].sum())
    tooth = 1.0 / events_per_turn
    in_turn = events_per_turn if wheel is None else len(wheel.places)
    events = Events(times, places * tooth, resolution, in_turn)
    known = known_between(time, events, unsure, tooth * _longest(wheel), counts=wheel is None)
    if known is None:
        return None
    marked = events_per_turn == 1 or wheel is not None
    told = (*_of_pulses(len(raw), missing + known.filled, extra), *known.told)
    filled = missing + known.filled
    return MeasuredShaft(known.turns, known.speed, known.known, len(raw), filled, extra, known.jitter, marked, told)


def _longest(wheel: Wheel | None) -> float:
    """Teeth that pass between two pulses of a wheel at most."""
    return 1.0 if wheel is None else float(np.diff(wheel.places, append=wheel.teeth).max())


def _of_pulses(events: int, missing: int, extra: int) -> list[str]:
    told = []
    if missing:
        told.append(f"{missing} of {events - extra + missing} pulses of the shaft are missing: interpolated between neighbours")
    if extra:
        told.append(f"{extra} of {events} pulses of the shaft are surplus: ignored")
    return told


def shaft_from_speed(time: NDArray[np.float64], speed: NDArray[np.float64]) -> MeasuredShaft:
    """The MeasuredShaft where its speed was measured: turns are counted from the first sample, where its angle is not known."""
    steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(time)
    turns = np.concatenate([[0.0], np.cumsum(steps)])
    return MeasuredShaft(turns, speed, np.ones(len(time), dtype=bool), 0, 0, 0, None, False, ())
