"""Lists of motions judged by the third engine: each motion is where its run stood, impacts start what is said."""

import itertools
from typing import NamedTuple

import numpy as np

from answers_labels import kinds
from drive_outcomes import judged_held
from product_witness import Runs
from rsc.measure.catalogue import WHIRLING
from rsc.measure.kinds import SELF_EXCITED, Kind
from rsc.study.motions.search import Search
from rsc.study.motions.settle import shown
from third_engine import TooStiff, beside, prescribed, run, state_of

MOST_BLOCKS, ALIKE, LAST = 40, 0.01, 6  # blocks of a run; change from block to block of one at rest; blocks of one that is not
STEADY, RESTLESS = (0.02, 0.05, 0.1), (0.1, 0.3, 0.5)  # of frequency, deflection, force: up to which two motions are one
IMPACTS, FEW, MANY = 2, 3, 24  # impacts tried of a motion; runs from beside each, first and where these end in another motion
TRIED = (1.0, 1.02, 0.98)  # shares of the smallest impulse, which stands at a border
AWAY, GROWS = 20.0, 1.02  # gaps, and growth from block to block, of a motion that runs away


class Place(NamedTuple):
    """Where a run ends at one contact: kinds that it may be called, turning Hz, deflection in gaps, largest force N."""

    kinds: set
    turning: float
    over_gap: float
    force: float


class Follower:
    """The third engine at the speed of a list."""

    def __init__(self, scene, speed, starts, largest=None):
        self.search, self.speed = Search(scene, speed, largest), speed
        self.listed = self.search.motions(starts, 0)
        self.system, self.block = self.search.system, self.search.settling.block
        shaft = prescribed([[0.0, 2.0 * np.pi * speed], [1.0, 2.0 * np.pi * speed]])
        state = self.state(self.search.base, self.search.base_turns)
        self.runs = Runs(self.search.scene, self.system, state, shaft, self.block)

    def state(self, start, turns):
        """A state of `march` of an InitialState; speeds of surfaces become those of races."""
        contacts = self.system.contacts
        state = state_of(start, turns, self.speed, len(contacts))
        if start.races is not None:
            state[2 : 2 + len(contacts)] /= [0.5 * (contact.law.diameter or 2.0) + contact.gap for contact in contacts]
        return state

    def end(self, state):
        """([Place] at every contact, whether it is steady) in which a run from a state ends."""
        blocks = []
        for _ in range(MOST_BLOCKS):
            path = run(self.runs.machine, self.runs.shaft, state, self.block)
            state, each = path.state, self.runs.signals(path)
            blocks.append([self._place(signals) for signals in each])
            if _away(blocks[-LAST:]):
                return [place._replace(kinds={str(Kind.RUNNING_AWAY)}) for place in blocks[-1]], True
            if _steady(blocks):
                return blocks[-1], True
        return [_joined(own) for own in zip(*blocks[-LAST:], strict=True)], False

    def _place(self, signals):
        over = signals.largest(signals.d) / signals.gap
        turning = signals.turning(0.0, self.block)
        return Place(kinds(signals, 0.0, self.block), turning, over, signals.largest(signals.force))

    def hit(self, impulse, k):
        """The state after random impact number k of the list, or one of that place."""
        return self.state(self.search.hit(impulse, k), self.search.base_turns)


def _away(blocks):
    """Whether a motion rises from block to block, far beyond the gap."""
    largest = [max(place.over_gap for place in places) for places in blocks]
    return len(blocks) == LAST and largest[-1] > AWAY and all(b > GROWS * a for a, b in itertools.pairwise(largest))


def _steady(blocks):
    """Whether the last blocks are alike at every contact."""
    if len(blocks) < 3:
        return False
    for own in zip(*blocks[-3:], strict=True):
        if not set.intersection(*(place.kinds for place in own)):
            return False
        numbers = np.array([place[1:] for place in own])
        scales = [abs(numbers[-1, 0]) + 1e-9, max(numbers[-1, 1], 1.0), numbers[-1, 2]]
        if numbers[:, 2].any() and not (np.ptp(numbers, axis=0) <= ALIKE * np.array(scales)).all():
            return False
        if not numbers[:, 2].any() and numbers[-1, 1] > (1.0 + ALIKE) * numbers[0, 1]:
            return False
    return True


def _joined(places):
    """What a contact of a motion that is not at rest may be called in any of the last blocks, and its largest numbers."""
    return Place(
        set.union(*(place.kinds for place in places)), float(np.mean([place.turning for place in places])),
        max(place.over_gap for place in places), max(place.force for place in places),
    )  # fmt: skip


def claimed(motion):
    """[(kind, turning, over_gap, force)] of a listed motion at every contact; what is not told is NaN."""
    if motion.contacts:
        return [(own.motion, np.nan, own.over_gap, own.force_max) for own in motion.contacts.values()]
    return [(motion.motion, motion.frequency, np.nan, motion.force_max)]


def is_that(places, steady, motion):
    """Whether the end of a run is a listed motion."""
    off = STEADY if steady and not motion.modulated else RESTLESS
    if not motion.bounded:
        return any(str(Kind.RUNNING_AWAY) in place.kinds for place in places)
    for place, (kind, turning, over, force) in zip(places, claimed(motion), strict=True):
        if kind not in place.kinds:
            return False
        turns = kind in (*SELF_EXCITED, Kind.FORWARD_RUB) and not np.isnan(turning)
        if turns and abs(place.turning - turning) > off[0] * abs(turning):
            return False
        if kind != Kind.NO_CONTACT and not np.isnan(over) and abs(place.over_gap - over) > off[1] * max(over, 1.0):
            return False
        if kind != Kind.NO_CONTACT and abs(place.force - force) > off[2] * max(place.force, force):
            return False
    return True


def of_list(scene, listed, torque, largest=None):
    """(topic, sentence, what is false or "" or "skipped") of what is said of a list; torque: the scene with its drive; largest:
    impulse in N s that was asked for."""
    follower = Follower(scene, listed.speed, listed.starts, largest)
    same = [motion.motion for motion in follower.listed.motions] == [motion.motion for motion in listed.motions]
    if not same:
        yield "list", "", "another list from the same seed"
        return
    for group, motion in zip(follower.search.groups, listed.motions, strict=True):
        yield "list", str(motion.motion), _told(_lasts, follower, [shown(group), *group[:1]], motion)
        if listed.hits(motion):
            yield "impacts", str(motion.motion), _told(_started, follower, listed, motion)
    if listed.smallest:
        yield "smallest", "", _told(_smallest, follower, listed)
    for one in listed.not_reached:
        if one.stable and one.label != "forward rub":
            yield "left", one.label, _told(_not_reached, follower, one)
    if torque is not None:
        for _, sentence, false, skipped in judged_held(torque, follower.search, listed):
            yield "held", sentence, "skipped" if skipped else false


def _told(judge, *arguments):
    """What a judge says, "skipped" where the third engine would take too many steps."""
    try:
        return judge(*arguments)
    except TooStiff:
        return "skipped"


def _lasts(follower, ends, motion):
    """A motion, judged by runs from beside the states in which its own runs stood."""
    seen = []
    for end in ends:
        state = follower.state(end.state, end.turns)
        for number in range(2):
            places, steady = follower.end(beside(state, follower.runs.machine, number))
            if is_that(places, steady, motion):
                return ""
            seen.append((places, steady))
    return f"{motion.motion} ({motion.frequency:.5g} Hz, {motion.force_max:.4g} N) is not there: {told(seen)}"


def told(ends):
    """Ends of runs in words."""
    texts = []
    for places, steady in ends:
        each = "; ".join(f"{'/'.join(sorted(p.kinds))} {p.turning:.4g} Hz {p.over_gap:.3g} gaps {p.force:.4g} N" for p in places)
        texts.append(f"[{each}{'' if steady else ', not steady'}]")
    return ", ".join(texts)


def _started(follower, listed, motion):
    """Impacts that are said to end in a motion; skipped where runs from beside one end in several. Where the first few of these
    agree on another motion, many more are tried: a chaotic transient may leave for the rarer of two motions in one run of ten."""
    disagree, seen = False, []
    index = next(i for i, one in enumerate(listed.motions) if one is motion)
    hits = np.flatnonzero(listed.ended == index)[:IMPACTS].tolist()
    for k in hits:
        state = follower.hit(complex(*listed.impulse[k]), k % len(follower.system.contacts))
        further = (follower.end(beside(state, follower.runs.machine, number)) for number in range(MANY))
        ends = list(itertools.islice(further, FEW))
        if any(is_that(*end, motion) for end in ends):
            return ""
        seen += ends
        differ = len({tuple(frozenset(place.kinds) for place in places) for places, _ in ends}) > 1
        disagree |= differ or any(is_that(*end, motion) for end in further)
    return "skipped" if disagree else f"none of impacts {hits} ends in {motion.motion}: {told(seen)}"


def _smallest(follower, listed):
    """The smallest impact: a whirl after it."""
    one, whirls = listed.smallest, {str(kind) for kind in WHIRLING}
    names = [contact.name for contact in follower.system.contacts]
    place = names.index(one.contact) if one.contact else 0
    impulse = one.impulse * np.exp(1j * np.deg2rad(one.direction))
    change = one.impulse * float(follower.search.changes[place] @ follower.system.contacts[place].rotor)
    if abs(change / one.velocity - 1.0) > 1e-6:
        return f"{one.impulse:.4g} N s are {change:.4g} m/s"
    for share in TRIED:
        places, _ = follower.end(follower.hit(share * impulse, place))
        if any(place.kinds & whirls for place in places):
            return ""
    return f"{one.impulse:.4g} N s start no whirl"


def _not_reached(follower, one):
    """A prediction that no run ended in: no run that begins on it stays there; skipped where its state is not known."""
    state = next((own.state for own in follower.search.candidates if own.predicted == one), None)
    if state is None:
        return "skipped"
    places, steady = follower.end(follower.state(state, 0.0))
    pressed = [place for place in places if place.force > 0.0]
    stays = steady and pressed and max(abs(place.turning / one.frequency - 1.0) for place in pressed) < 0.01
    largest = max((place.force for place in pressed), default=0.0)
    if stays and abs(largest / one.normal_force - 1.0) < 0.1:
        return f"{one.label or 'whirl'} ({one.frequency:.5g} Hz) lasts: {told([(places, steady)])}"
    return ""

