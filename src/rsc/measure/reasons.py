"""Why a comparison has its verdict: a code with its numbers. The words are made in `rsc.show.words.reasons`."""

from dataclasses import dataclass
from enum import StrEnum


class Code(StrEnum):
    """The reason of a verdict; the comments list its names and numbers."""

    # of a row
    FEW_PERIODS = "few periods"  # periods in a window
    SHORT = "short"  # [why the kind of the motion is not resolved]
    TOO_FAST = "too fast"  # Hz at which the contact turns, samples a second
    TOO_FAR = "too far"  # [effect that may change the prediction by more than itself], relative size
    STILL_RINGS = "still rings"  # 1/s at which it decays, s since when: too little is known of a motion that begins
    COVERED = "covered"  # [effect that covers the difference], relative size
    DECAYS = "decays"  # [unit of since], 1/s, since in s or Hz, share that remains
    DEPARTURE = "departure"  # 1/s at which it leaves an unstable whirl, relative size
    MUST_BE_LEFT = "must be left"
    NONE_WITH_SO_MUCH = "none with so much"  # [of what], share of it up to which a steady whirl exists
    OF_STATOR = "of the stator"  # an amplitude: the stator moves more than the rotor
    UNSTABLE = "unstable"
    NOT_YET_LEFT = "not yet left"  # unstable as well, and the run leaves it later
    ROLLS = "rolls"
    ROLLS_BY_NONE = "rolls by none"  # share of the time in contact that it rolls, near no whirl that is predicted to
    BY_NONE = "by none"  # [kind of the motion], share of the time in contact, near no predicted whirl
    OTHER_MOTION = "other motion"  # [its kind], which has no whirl
    # of a transition
    SETS_IN = "sets in"
    ALWAYS_UNSTABLE = "always unstable"
    LATE = "late"  # it is left later than it loses stability, by the delay of the run
    ENDED_BY_UNBALANCE = "ended by unbalance"  # share of it up to which the whirl exists
    UPSET_BY_UNBALANCE = "upset by unbalance"  # largest growth rate in 1/s
    STABLE_THERE = "stable there"  # share of the time in contact


@dataclass(frozen=True)
class Reason:
    """A code with its names (of effects, kinds, units) and numbers."""

    code: Code
    names: tuple[str, ...] = ()
    numbers: tuple[float, ...] = ()
