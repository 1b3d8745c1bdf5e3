"""The motion in which a run ends, from the facts of its last part."""

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rsc.measure.kinds import Kind, Motion, motion_between
from rsc.measure.stretches import StretchedRun, Stretches, at_contacts
from rsc.presented import Brief

_DIVERGED = "diverged"  # the status of a run that left every bound
PART = 0.25  # of the run that its last part takes at constant speed
LEAST = 4  # stretches of the last part at least


@dataclass(frozen=True)
class MotionAtContact:
    """What a motion is at one of several contacts.

    motion : str, one of `rsc.measure.kinds.Kind`
    over_gap : float, largest deflection over the gap; share : float, of the time in contact, 0 to 1
    force_mean, force_max : float N, normal force
    """

    motion: str
    over_gap: float
    share: float
    force_mean: float
    force_max: float


@dataclass(frozen=True, repr=False)
class FinalMotion(Brief):
    """The last part of a run, at the contact; from the steps of the simulation, whatever `output.rate` is.

    Of several contacts it is that at the one where it is most dangerous, and `contacts` tells of each; torque and power are those
    of all of them.

    motion : str, one of `rsc.measure.kinds.Kind`
    frequency : float Hz, mean rate at which the contact deflection turns, negative backward; NaN without a lasting sense
    amplitude_min, amplitude_max : m, of |r| of the rotor; stator_max : m, of the stator
    peak_to_peak : m, vibration of the rotor at the contact, the larger of its extents in y and z
    force_mean, force_max : N, normal force
    contact_share : share of the time in contact, 0 to 1
    torque : N m, mean, by friction against the drive; power : W, that it takes; NaN without a contact diameter
    clearances : dict, name -> largest deflection over gap at each place that is only watched
    contacts : dict, name -> MotionAtContact, of several contacts; empty with one
    """

    motion: str
    frequency: float
    amplitude_min: float
    amplitude_max: float
    peak_to_peak: float
    stator_max: float
    force_mean: float
    force_max: float
    contact_share: float
    torque: float
    power: float
    clearances: dict[str, float]
    contacts: dict[str, MotionAtContact]

    @property
    def pressed(self) -> tuple[str, ...]:
        """Names of those of several contacts at which the motion is of its kind."""
        return tuple(name for name, own in self.contacts.items() if own.motion == self.motion)

    @property
    def touched(self) -> tuple[str, ...]:
        """Names of those of several contacts that touch at all."""
        return tuple(name for name, own in self.contacts.items() if own.share > 0.0)

    @property
    def touches(self) -> tuple[str, ...]:
        """Names of the clearances whose gap it reaches, the one that is passed furthest first."""
        passed = [name for name, share in self.clearances.items() if share >= 1.0]
        return tuple(sorted(passed, key=lambda name: -self.clearances[name]))


class EndedRun(StretchedRun, Protocol):
    """A run that has ended, as `rsc.Trajectory`."""

    @property
    def status(self) -> str: ...


def final_motion(result: EndedRun, driven: bool = False) -> FinalMotion:
    """The motion at the end of a run.

    It is looked at in the last quarter of the run, or in less where the speed changes, so that it changes by little meanwhile; in
    more where that is too short to tell.

    Parameters
    ----------
    result : Trajectory
    driven : bool
        As in `rsc.measure.kinds.motion_of`.

    Returns
    -------
    FinalMotion
    """
    result = getattr(result, "scheduled", result)
    each = at_contacts(result)
    stretches = each[0]
    if not len(stretches):
        return FinalMotion(Kind.NOT_RESOLVED, *(math.nan,) * 10, {}, {})
    scene, end, part = result.scene, float(stretches.end[-1]), last_part(result.scene, stretches)
    count = stretches.places(end - part, end)
    while count[1] - count[0] >= 2 * LEAST and _begins_or_ends(np.sum([own.contact_time[slice(*count)] for own in each], axis=0)):
        part *= 0.5  # what came before is not what the run ends in
        count = stretches.places(end - part, end)
    motion = motion_between(each, (end - part, end), scene, result.status == _DIVERGED, driven)
    while motion.kind == Kind.NOT_RESOLVED and part < end:  # of a short run more than the last part
        part = min(2.0 * part, end)
        motion = motion_between(each, (end - part, end), scene, driven=driven)
    return described(motion, scene)


def _begins_or_ends(contact_time: NDArray[np.float64]) -> bool:
    """Whether there is contact at one end of some stretches and none at the other."""
    ends = contact_time[:LEAST].any(), contact_time[-LEAST:].any()
    return bool(ends[0] != ends[1])


def last_part(scene: Any, stretches: Stretches) -> float:
    """Length in s of the last part of a run."""
    end = float(stretches.end[-1])
    before = end * (1.0 - PART)
    speeds = np.interp([before, end], scene.drive.time, scene.drive.speed)
    change = abs(float(speeds[1] - speeds[0])) / (PART * end)
    least = LEAST * end / len(stretches)
    return min(PART * end, max(least, 1.0 / math.sqrt(change))) if change > 0.0 else PART * end


def described(motion: Motion, scene: Any) -> FinalMotion:
    """What is told of a motion of a scene."""
    facts = motion.facts
    loads = [drive_load(own.facts, contact) for own, contact in zip(motion.everywhere, scene.contacts, strict=True)]
    torque, power = (sum(own) for own in zip(*loads, strict=True))
    return FinalMotion(
        motion=str(motion.kind),
        frequency=motion.frequency,
        amplitude_min=facts.rotor_min,
        amplitude_max=facts.rotor_max,
        peak_to_peak=facts.peak_to_peak,
        stator_max=facts.stator_max,
        force_mean=facts.mean_force,
        force_max=facts.force_max,
        contact_share=facts.share,
        torque=torque,
        power=power,
        clearances={
            place.name: largest / place.gap for place, largest in zip(scene.clearances, facts.clearances, strict=True)
        } if facts.clearances else {},
        contacts={contact.name: _at(own, contact.gap) for own, contact in zip(motion.at, scene.contacts, strict=False)},
    )


def _at(own: Motion, gap: float) -> MotionAtContact:
    facts = own.facts
    return MotionAtContact(str(own.kind), facts.deflection_max / gap, facts.share, facts.mean_force, facts.force_max)


def drive_load(facts: Any, contact: Any) -> tuple[float, float]:
    """(torque N m, power W) that friction takes from the drive at a contact, means over a motion; NaN without its diameter."""
    if contact.diameter is None:
        return math.nan, math.nan
    return facts.mean_friction * 0.5 * contact.diameter, facts.mean_power
