"""Classification of motions by a closed list of kinds. Definitions: docs/users/motions.md.

It is decided by facts that the simulation counted in its own steps (`rsc.measure.stretches`), never by spectra of samples.
Backward needs turns: a straight vibration has two halves and a bouncing orbit negative lines, but neither turns.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from rsc.measure.features import turns
from rsc.measure.stretches import Facts, Stretches


class Kind(StrEnum):
    """What a motion is."""

    NO_CONTACT = "no contact"
    FORWARD_RUB = "forward rub"
    FORWARD_WHIRL = "forward whirl"
    SLIDING = "backward whirl, sliding"
    ROLLING = "backward whirl, rolling"
    BOUNCING = "bouncing backward whirl"
    PARTIAL_RUB = "partial rub"
    RESTING = "resting on the stator"
    RUNNING_AWAY = "running away"
    NOT_RESOLVED = "not resolved"
    TRANSIENT = "transient contact"


class ProbeKind(StrEnum):
    """The kind of a motion as seen by two probes, which measure neither contact nor slip."""

    WHIRL = "backward whirl"
    WITH_SHAFT = "turns with the shaft"
    FORWARD = "turns forward, not with the shaft"
    NEITHER = "turns neither way"
    NOT_RESOLVED = "not resolved"


BACKWARD = (Kind.SLIDING, Kind.ROLLING, Kind.BOUNCING)
SELF_EXCITED = (*BACKWARD, Kind.FORWARD_WHIRL)
HARMFUL = (*BACKWARD, Kind.RUNNING_AWAY)  # what a remedy takes away
# the most dangerous first
RANK = (
    Kind.RUNNING_AWAY, *BACKWARD, Kind.FORWARD_WHIRL, Kind.PARTIAL_RUB, Kind.FORWARD_RUB, Kind.RESTING, Kind.TRANSIENT,
    Kind.NOT_RESOLVED, Kind.NO_CONTACT,
)  # fmt: skip
LASTING = 0.99  # share of the time in contact from which it is permanent
ROLLS = 0.5  # share of the time in contact from which a backward whirl rolls
LEAST_TURNS = 3.0  # turns of the contact deflection, or of the shaft, below which nothing is said
SENSE_TURNS = 2.0  # turns of the contact deflection from which on its sense lasts, if it is the same in every part
MOST_PARTS = 8  # in each of which the contact deflection must turn the same way
ARC = 0.5  # of the gap: length of the mean deflection in contact from which the contact stays in an arc
SAME_TURNS = 0.75  # turns beside those of the shaft up to which a motion turns with it
SAME_SPEED = 0.01  # the same as a share of them
REPEATED = 3  # touches from which contact repeats itself; or one a turn of the contact deflection or the shaft
FREE = 0.5  # of the time in one piece without contact from which contact does not repeat itself
FORWARD_SHARE = 0.5  # of the time in contact from which a forward turning that is not the shaft's is a whirl


@dataclass(frozen=True)
class Motion:
    """What a motion is, from one time to another.

    kind : Kind; why : str, why it is not resolved and what to change, else ""
    frequency : float Hz, mean rate at which the contact deflection turns, negative backward in a scene that spins forward; NaN
        where it has no lasting sense
    facts : Facts
    at : tuple of Motion, what it is at each of several contacts, of which it is the one that `of_contacts` says; empty with one
    """

    kind: Kind
    why: str
    frequency: float
    facts: Facts
    at: tuple["Motion", ...] = ()

    @property
    def everywhere(self) -> tuple["Motion", ...]:
        """What it is at each contact, be it one."""
        return self.at or (self,)


def motion_of(parts: Sequence[Facts], shaft: float, gap: float, diverged: bool = False, driven: bool = False) -> Motion:
    """The kind of a motion.

    Parameters
    ----------
    parts : sequence of Facts
        Of consecutive stretches, some periods each, which together are the motion.
    shaft : float
        Turns of the shaft meanwhile, negative in a scene that spins backward.
    gap : float, m
    diverged : bool
        Whether the run left every bound in it.
    driven : bool
        Whether something beside friction can feed a whirl (`System.driven`): only then is one that bounces forward self-excited.
    """
    whole = joined(parts)
    sign = -1.0 if shaft < 0.0 else 1.0
    if diverged:
        return Motion(Kind.RUNNING_AWAY, "", whole.turning, whole)
    if whole.contact_time == 0.0:
        return Motion(Kind.NO_CONTACT, "", math.nan, whole)
    sense = _sense(parts, sign)
    if abs(whole.turns) < LEAST_TURNS and abs(shaft) < LEAST_TURNS:
        turned = max(abs(whole.turns), abs(shaft))
        return Motion(Kind.NOT_RESOLVED, f"{turned:.1f} turns: too short, run it longer", math.nan, whole)
    if whole.share >= LASTING:
        kind = _lasting(whole, sense, abs(shaft), gap)
    else:
        kind = _repeated(whole, sense, abs(shaft), driven) if _repeats(parts, whole, abs(shaft)) else Kind.TRANSIENT
    turning = kind in (*SELF_EXCITED, Kind.FORWARD_RUB)
    return Motion(kind, "", whole.turning if turning else math.nan, whole)


def seen_of(turned: Sequence[float], shaft: float) -> ProbeKind:
    """The kind of a motion of which probes tell the turns about its mean, in consecutive parts.

    Parameters
    ----------
    turned : sequence of float
        Turns in each part, negative backward.
    shaft : float
        Turns of the shaft meanwhile.
    """
    whole = abs(math.fsum(turned))
    if whole < LEAST_TURNS and shaft < LEAST_TURNS:
        return ProbeKind.NOT_RESOLVED
    if whole < SENSE_TURNS or min(turned) <= 0.0 <= max(turned):
        return ProbeKind.NEITHER
    if turned[0] < 0.0:
        return ProbeKind.WHIRL
    return ProbeKind.WITH_SHAFT if _with_shaft(whole, shaft) else ProbeKind.FORWARD


def of_contacts(own: Sequence[Motion]) -> Motion:
    """The motion of a machine, of its motions at every contact: the most dangerous, of equal ones that which presses hardest."""
    if len(own) == 1:
        return own[0]
    return replace(min(own, key=lambda motion: (RANK.index(motion.kind), -motion.facts.mean_force)), at=tuple(own))


def motion_between(
    each: Sequence[Stretches], times: tuple[float, float], scene: Any, diverged: bool = False, driven: bool = False
) -> Motion:
    """The motion of a run of a scene between two times in s; each: the stretches of the run, one Stretches for each contact."""
    first, last = each[0].places(*times)
    begin, end = turns(scene.drive, [each[0].begin[first], each[0].end[last - 1]])
    pairs = zip(each, scene.contacts, strict=True)
    return of_contacts(
        [motion_of(parts_of(own, first, last), float(end - begin), contact.gap, diverged, driven) for own, contact in pairs]
    )


def parts_of(stretches: Stretches, first: int, last: int) -> list[Facts]:
    """Facts of at most `MOST_PARTS` parts of the stretches from number first to last (exclusive)."""
    count = min(MOST_PARTS, last - first)
    edges = np.linspace(first, last, count + 1).round().astype(int)
    return [stretches.of(a, b) for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)]


def joined(parts: Sequence[Facts]) -> Facts:
    """The Facts of consecutive ones together."""
    if len(parts) == 1:
        return parts[0]
    return Stretches.joined(parts)


def _sense(parts: Sequence[Facts], sign: float) -> int:
    """1 where the contact deflection turns with the spin in every part, -1 where it turns against it, else 0."""
    turns = [sign * part.turns for part in parts]
    if min(turns) > 0.0:
        return 1
    return -1 if max(turns) < 0.0 else 0


def _lasting(whole: Facts, sense: int, shaft: float, gap: float) -> Kind:
    """The kind of a motion in permanent contact."""
    turned = abs(whole.turns)
    if sense < 0 and turned >= SENSE_TURNS:
        return Kind.ROLLING if whole.rolling_share > ROLLS else Kind.SLIDING
    if sense > 0 and turned >= SENSE_TURNS:
        return Kind.FORWARD_RUB if _with_shaft(turned, shaft) else Kind.FORWARD_WHIRL
    return Kind.RESTING if _in_arc(whole, gap) else Kind.PARTIAL_RUB


def _repeats(parts: Sequence[Facts], whole: Facts, shaft: float) -> bool:
    """Whether a contact that comes and goes repeats itself: a free vibration that touches once or twice does not."""
    free = longest = 0.0
    for part in parts:
        free = free + part.duration if part.contact_time == 0.0 else 0.0
        longest = max(longest, free)
    if longest > FREE * whole.duration:
        return False
    return whole.share >= 1.0 - FREE or whole.onsets >= min(REPEATED, max(abs(whole.turns), shaft))


def _repeated(whole: Facts, sense: int, shaft: float, driven: bool) -> Kind:
    """The kind of a motion whose contact comes and goes."""
    turned = abs(whole.turns)
    if sense < 0 and turned >= SENSE_TURNS and whole.friction_work > 0.0:
        return Kind.BOUNCING
    if driven and sense > 0 and turned >= SENSE_TURNS and whole.share >= FORWARD_SHARE and not _with_shaft(turned, shaft):
        return Kind.FORWARD_WHIRL
    return Kind.PARTIAL_RUB


def _with_shaft(turned: float, shaft: float) -> bool:
    return abs(turned - shaft) <= max(SAME_TURNS, SAME_SPEED * shaft)


def _in_arc(whole: Facts, gap: float) -> bool:
    return math.hypot(whole.arc_y, whole.arc_z) > ARC * gap * whole.contact_time
