"""What a drive with a torque makes of a motion, in words."""

from math import tau as TWO_PI

from rsc.show.words.wording import amount, hertz
from rsc.system.held import BRAKES, HOLDS, SLOWS

SAME_SPEED = 0.005  # share of the speed, below which a rotor that is braked or sped up is held


def held_text(outcomes):
    """What a motion takes beside what the drive gives, and what becomes of it, of its tuple of `rsc.system.held.Held`; "" without
    any."""
    if not outcomes:
        return ""
    first = outcomes[0]
    power = amount(first.torque * TWO_PI * first.begin, "W")
    takes = f"takes {amount(first.torque, 'N m')} ({power}), " if first.torque else ""
    return takes + "; ".join(_part(one) for one in outcomes)


def _part(one):
    tripped = "after the trip " if one.coasting else ""
    return f"{tripped}the drive gives {amount(one.drive, 'N m')}: {outcome_text(one)}"


def outcome_text(one):
    """What becomes of the speed."""
    if one.outcome == SLOWS:
        return "the drive does not hold it"
    near = abs(one.speed - one.begin) <= SAME_SPEED * one.begin
    if one.outcome == HOLDS:
        faster = " and speeds up" + (f" to {hertz(one.speed)} Hz" if one.speed < float("inf") else "")
        return "the drive holds it" + ("" if near else faster)
    if one.outcome == BRAKES:
        return "the drive holds it" if near else f"brakes to {hertz(one.speed)} Hz"
    return f"stops after about {one.time:.2g} s"


def outcomes_text(outcomes):
    """What becomes of the speed, for the run and after its trip; "" without any."""
    return "; ".join(f"{'after the trip ' if one.coasting else ''}{outcome_text(one)}" for one in outcomes)
