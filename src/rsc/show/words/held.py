"""What a drive with a torque makes of a motion, in words."""

import math
from math import tau as TWO_PI

from rsc.measure.kinds import Kind
from rsc.show.words.wording import amount, frequency_text
from rsc.system.held import BRAKES, CAPTURED, HOLDS, SPEEDS_UP, STOPS

STEADY = 1e-3  # share of the speed in Hz/s, below which it is not told whether a rotor still slows down
WITHOUT = "without contact"


def loads_text(own):
    """What friction of a predicted whirl takes beside what the drive gives, of its tuple of `rsc.system.held.Load`; "" of ()."""
    torques = [_given(one) + ("" if one.drive >= one.torque else ", too little for this speed") for one in own]
    return _takes(own) + "; ".join(torques)


def held_text(own):
    """What friction of a motion takes beside what the drive gives, and what becomes of it, of its tuple of
    `rsc.system.held.Held`; "" of ()."""
    return _takes(own) + "; ".join(f"{_given(one)}: {outcome_text(one)}" for one in own)


def outcomes_text(own):
    """What becomes of a motion, for the run and after its trip; "" without any."""
    return "; ".join(f"{_tripped(one)}{outcome_text(one)}" for one in own)


def outcome_text(one):
    """What becomes of a motion that is released to the torque of its drive."""
    left, same = not math.isnan(one.left_time), {HOLDS: "the drive holds it", STOPS: f"the rotor stops after {_time(one.time)}"}
    if not left and one.outcome in same:
        return same[one.outcome] + _passed(one)
    if not left:
        return f"the rotor {_elsewhere(one, '')}{_passed(one)}"
    later = f"leaves it at {frequency_text(one.left_speed)} after {_time(one.left_time)}"
    where = later if one.left_time else "leaves it at once"
    then = f"stops after {_time(one.time)}" if one.outcome == STOPS else _elsewhere(one, _motion(one))
    return f"the rotor {where}, {then}{_passed(one)}"


def _elsewhere(one, motion):
    """At which speed, and in which other motion a release ends."""
    words, after = f"{motion} " if motion else "", f"after {_time(one.time)}"
    speed = f"{frequency_text(one.speed)}"
    if one.outcome == CAPTURED:
        return f"{'is ' * (not words)}captured at {speed} (Sommerfeld effect) {words}{after}"
    if one.outcome in (SPEEDS_UP, BRAKES, HOLDS):
        verb = "settles" if motion else {SPEEDS_UP: "speeds up", BRAKES: "brakes"}[one.outcome]
        return f"{verb} {words}{'at' if motion else 'to'} {speed} {after}"
    slow = abs(one.rate) <= STEADY * one.speed
    change = "not settled" if slow else "still slowing down" if one.rate < 0.0 else "still speeding up"
    return f"{words or 'is '}at {speed} {after}, {change}"


def _motion(one):
    """The motion at the end."""
    if one.motion == Kind.NO_CONTACT:
        return WITHOUT
    rate = "" if math.isnan(one.frequency) else f" ({frequency_text(one.frequency)})"
    if one.motion == Kind.RESTING:
        return str(one.motion)
    return f"in {one.motion}{rate}"


def _passed(one):
    """A more dangerous motion on the way."""
    return f" (on the way {one.passed})" if one.passed else ""


def _time(seconds):
    return f"{seconds:.2g} s" if seconds < 100.0 else f"{seconds:.0f} s"


def _takes(own):
    if not own or not own[0].torque:
        return ""
    power = amount(own[0].torque * TWO_PI * own[0].begin, "W")
    return f"friction takes {amount(own[0].torque, 'N m')} ({power}), "


def _given(one):
    return f"{_tripped(one)}the drive gives {amount(one.drive, 'N m')}"


def _tripped(one):
    return "after the trip " if one.coasting else ""
