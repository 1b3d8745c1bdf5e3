"""Windows of a run with several contacts: the type of motion at every contact and of the whole."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.measure.course import Course, Windows, motions_in
from rsc.measure.kinds import RANK, Kind, Motion
from rsc.measure.stretches import StretchedRun, at_contacts

EVERYWHERE = (Kind.NO_CONTACT, Kind.RUNNING_AWAY)  # told of no contact by itself


@dataclass(frozen=True)
class ContactCourse:
    """What the windows of a run are at one of several contacts, (n_w,) each.

    kind : str, one of `rsc.measure.kinds.Kind`
    over_gap : largest deflection over the gap; peak_to_peak m, of the rotor there; share : of the time in contact, 0 to 1
    force, force_max : N, mean and largest normal force
    """

    kind: NDArray[np.str_]
    over_gap: NDArray[np.float64]
    peak_to_peak: NDArray[np.float64]
    share: NDArray[np.float64]
    force: NDArray[np.float64]
    force_max: NDArray[np.float64]


def hardest(run: StretchedRun) -> int:
    """Number of the contact that takes the largest impulse over a run; 0 where none touches."""
    return int(np.argmax([own.normal_impulse.sum() for own in at_contacts(run)]))


def together(names: Sequence[str]) -> str:
    """Some names in words: "seal, bush and drum"."""
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def name_of(kinds: dict[str, str]) -> str:
    """What a motion is, given its kind at each contact, in words: each kind that it is somewhere, and where."""
    at = {kind: [name for name, own in kinds.items() if own == kind] for kind in RANK}
    told = [f"{kind} at {together(names)}" for kind, names in at.items() if names and kind not in EVERYWHERE]
    return ", with ".join(told) or next(iter(kinds.values()))


def of_several(run: Any, windows: Windows, seen: Course, lead: int, driven: bool) -> Course:
    """The course of a run, given that at one of its contacts, with what its windows are at all of them.

    Parameters
    ----------
    run : Trajectory
    windows : Windows
    seen : Course, at the contact of number `lead`
    lead : int
    driven : bool
        As in `rsc.measure.kinds.motion_of`.

    Returns
    -------
    Course
        Kind, turning and rolling of its features are those of the whole motion, share is the largest at any contact.
    """
    motions, names = motions_in(windows, run, int(windows.starts[-1]), driven), [one.name for one in run.scene.contacts]
    each = zip(run.scene.contacts, zip(*(motion.at for motion in motions), strict=True), strict=True)
    contacts = {contact.name: _course_at(own, contact.gap) for contact, own in each}
    features = replace(
        seen.features,
        kind=np.array([str(motion.kind) for motion in motions]),
        why=np.array([motion.why for motion in motions]),
        turning=np.array([motion.facts.turning for motion in motions]),
        rolling=np.array([motion.facts.rolling_share for motion in motions]),
        share=np.max([own.share for own in contacts.values()], axis=0),
        names=tuple(name_of({name: str(own.kind) for name, own in zip(names, motion.at, strict=True)}) for motion in motions),
        sets=tuple(_set_of(motion, names) for motion in motions),
    )
    return replace(seen, features=features, lead=names[lead], contacts=contacts)


def _course_at(own: Sequence[Motion], gap: float) -> ContactCourse:
    facts = [motion.facts for motion in own]
    return ContactCourse(
        kind=np.array([str(motion.kind) for motion in own]),
        over_gap=np.array([each.deflection_max / gap for each in facts]),
        peak_to_peak=np.array([each.peak_to_peak for each in facts]),
        share=np.array([each.share for each in facts]),
        force=np.array([each.mean_force for each in facts]),
        force_max=np.array([each.force_max for each in facts]),
    )


def _set_of(motion: Motion, names: list[str]) -> tuple[str, ...]:
    """The pressed set of a motion: the contacts that touch, if it is of its kind at all of them."""
    touching = [(name, own.kind) for name, own in zip(names, motion.at, strict=True) if own.facts.share > 0.0]
    return tuple(name for name, _ in touching) if all(kind == motion.kind for _, kind in touching) else ()
