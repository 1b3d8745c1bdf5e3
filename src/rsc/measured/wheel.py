"""Which tooth of its wheel each pulse of a shaft comes from: teeth that are missing or doubled on purpose give the mark."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

MOST_MISSING = 3  # teeth side by side that a wheel may lack
_ALIKE = 0.3  # of a tooth, by which a step between pulses may be off
_HALVED = 0.85  # of a tooth, below which a step is part of one
_LIKE_BEFORE = 0.35  # of its duration, by which a tooth may differ from that before it
_IN_TURNS = 0.6  # share of turns that show the pattern of a wheel, from which it is one


class Wheel(NamedTuple):
    """places : (p,) teeth from the mark to each pulse of a turn, the first 0; teeth : int, of a turn, missing ones too;
    marks : (m,) numbers of the events that are the mark."""

    places: NDArray[np.float64]
    teeth: int
    marks: NDArray[np.intp]


def wheel_of(times: NDArray[np.float64], teeth: int) -> Wheel | None:
    """The wheel of so many teeth in a turn that events (k,) in s come from; None of an even one, which has no mark.

    A wheel that lacks up to `MOST_MISSING` teeth side by side has its mark at the first tooth behind them, one with an
    additional tooth at that.
    """
    for lacking in range(1, MOST_MISSING + 1):
        if teeth - lacking >= 2 and (marks := _behind_gaps(times, teeth - lacking, lacking)).size:
            return Wheel(np.arange(teeth - lacking, dtype=float), teeth, marks)
    if teeth >= 2 and (marks := _additional(times, teeth)).size:
        # from the additional tooth to the next one: measured
        ahead = (times[marks + 1] - times[marks]) / (times[marks + 1] - times[marks - 1])
        first = float(np.median(ahead))
        return Wheel(np.concatenate([[0.0], first + np.arange(teeth)]), teeth, marks)
    return None


def teeth_instead(times: NDArray[np.float64], pulses: int) -> int | None:
    """Number of tooth positions of a wheel including missing teeth; None if none is missing."""
    for lacking in range(1, MOST_MISSING + 1):
        if pulses >= 2 and _behind_gaps(times, pulses, lacking).size:
            return pulses + lacking
    return None


def _behind_gaps(times: NDArray[np.float64], pulses: int, lacking: int) -> NDArray[np.intp]:
    """Events behind the gaps of a wheel of so many pulses in a turn, where it lacks teeth; none where the pattern is another."""
    steps = _in_teeth(times, pulses, pulses + lacking)
    if len(steps) < 3 * pulses:
        return np.zeros(0, dtype=int)
    gap, one = np.abs(steps - (lacking + 1)) < _ALIKE * (lacking + 1), np.abs(steps - 1.0) < _ALIKE
    if not _shown((_in_turn(gap, pulses) == 1) & (_in_turn(one, pulses) == pulses - 1)):
        return np.zeros(0, dtype=int)
    return np.flatnonzero(_repeated(gap, pulses)) + 1


def _additional(times: NDArray[np.float64], teeth: int) -> NDArray[np.intp]:
    """Events of an additional tooth between two of a wheel; none where there is none."""
    pulses = teeth + 1
    steps = _in_teeth(times, pulses, teeth)
    if len(steps) < 3 * pulses:
        return np.zeros(0, dtype=int)
    part, one = steps < _HALVED, np.abs(steps - 1.0) < _ALIKE
    pair = np.zeros(len(steps), dtype=bool)
    pair[:-1] = part[:-1] & part[1:] & (np.abs(steps[:-1] + steps[1:] - 1.0) < _ALIKE)
    others = (_in_turn(part, pulses) == 2) & (_in_turn(one & ~part, pulses) == pulses - 2)
    if not _shown(others) or 2 * pair.sum() < _IN_TURNS * part.sum():
        return np.zeros(0, dtype=int)
    return np.flatnonzero(_repeated(pair, pulses)) + 1


def _in_teeth(times: NDArray[np.float64], pulses: int, teeth: int) -> NDArray[np.float64]:
    """(k - 1,) steps between events, in teeth of the turn about each, which has so many pulses."""
    steps = np.diff(times)
    if len(steps) < pulses:
        return np.zeros(0)
    turn = times[pulses:] - times[:-pulses]
    about = np.clip(np.arange(len(steps)) - pulses // 2, 0, len(turn) - 1)
    return np.asarray(steps * teeth / turn[about])


def _in_turn(flags: NDArray[np.bool_], pulses: int) -> NDArray[np.intp]:
    """Number of set flags in each group of consecutive flags."""
    total = np.concatenate([[0], np.cumsum(flags)])
    return np.asarray(total[pulses:] - total[:-pulses])


def _shown(turns: NDArray[np.bool_]) -> bool:
    return bool(turns.mean() >= _IN_TURNS)


def _repeated(flags: NDArray[np.bool_], pulses: int) -> NDArray[np.bool_]:
    """The flags also set one turn earlier or later: a single lost pulse looks like a gap."""
    before, behind = np.zeros_like(flags), np.zeros_like(flags)
    before[pulses:], behind[:-pulses] = flags[:-pulses], flags[pulses:]
    return np.asarray(flags & (before | behind))


class PlacedEvents(NamedTuple):
    """Events with their places: times (k,) s; places (k,) in teeth and numbers (k,) in pulses, both rising; extra, number of
    events that were left out."""

    times: NDArray[np.float64]
    places: NDArray[np.float64]
    numbers: NDArray[np.intp]
    extra: int


def placed(times: NDArray[np.float64], wheel: Wheel) -> PlacedEvents:
    """Events of a wheel with a mark on their places, counted from the first mark.

    Between two marks with a whole number of turns' pulses all of them count, else those before and behind which follow each
    other as on the wheel.
    """
    pulses, marks = len(wheel.places), wheel.marks
    chosen, numbers, number = [np.arange(marks[0])], [np.arange(-marks[0], 0)], 0
    for a, b in zip(marks[:-1].tolist(), marks[1:].tolist(), strict=True):
        if (b - a) % pulses == 0:
            chosen.append(np.arange(a, b))
            numbers.append(number + np.arange(b - a))
            number += b - a
            continue
        ahead, behind = _followed(times[a : b + 1], wheel), _followed(-times[a : b + 1][::-1], _reversed(wheel))
        turns = max(round((times[b] - times[a]) / _turn_beside(times, marks, a, pulses)), 1)
        behind = min(behind, b - a - ahead, max(turns * pulses - ahead, 0))
        chosen += [np.arange(a, a + ahead), np.arange(b - behind, b)]
        numbers += [number + np.arange(ahead), number + turns * pulses - behind + np.arange(behind)]
        number += turns * pulses
    chosen.append(np.arange(marks[-1], len(times)))
    numbers.append(number + np.arange(len(times) - marks[-1]))
    own, counts = np.concatenate(chosen), np.concatenate(numbers)
    places = wheel.places[counts % pulses] + wheel.teeth * (counts // pulses)
    return PlacedEvents(times[own], places, counts, len(times) - len(own))


def _followed(times: NDArray[np.float64], wheel: Wheel) -> int:
    """How many events from a mark on follow each other as on the wheel: each tooth lasts about as long as the last."""
    pulses, usual = len(wheel.places), 0.0
    for k in range(1, len(times) - 1):
        teeth = wheel.places[k % pulses] - wheel.places[(k - 1) % pulses] + wheel.teeth * (k % pulses == 0)
        each = (times[k] - times[k - 1]) / teeth
        if usual and abs(each / usual - 1.0) > _LIKE_BEFORE:
            return k
        usual = each
    return len(times) - 1


def _reversed(wheel: Wheel) -> Wheel:
    """The wheel as it is passed backwards."""
    return wheel._replace(places=np.concatenate([[0.0], wheel.teeth - wheel.places[:0:-1]]))


def _turn_beside(times: NDArray[np.float64], marks: NDArray[np.intp], a: int, pulses: int) -> float:
    """Duration of the whole turns next to event a, s."""
    whole = np.flatnonzero(np.diff(marks) == pulses)
    place = int(np.searchsorted(marks[whole], a))
    near = whole[max(place - 2, 0) : place + 2]
    return float(np.median(times[marks[near + 1]] - times[marks[near]])) if near.size else float(times[-1] - times[0])
