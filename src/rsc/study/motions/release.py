"""Motions of a machine at constant speed, released to the torque of its drive: each is simulated until it holds, stops or settles
elsewhere (docs/users/drives.md)."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import tau as TWO_PI
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.measure.catalogue import Motions
from rsc.measure.final import drive_load
from rsc.measure.kinds import LASTING, LEAST_TURNS, RANK, SELF_EXCITED, Kind, Motion, motion_of, of_contacts, parts_of
from rsc.measure.stretches import Stretches, side_by_side
from rsc.scene.scene import Scene
from rsc.scene.tables.drive import Drive
from rsc.simulation.pack import Packed
from rsc.simulation.shot import Shot, packed_for_shots
from rsc.study.motions.search import Search
from rsc.study.motions.settle import End, Settling, shown
from rsc.system.assemble import assemble
from rsc.system.held import BRAKES, CAPTURED, HOLDS, SPEEDS_UP, STOPS, UNKNOWN, Held, Load, balance_above, loads

MOST_STEPS, ATTEMPTS = 4_000_000, 200  # of a run, and between two looks at it
MOST_STRETCHES = 20_000
LATER = 1.1  # a run is asked whether it has settled whenever it has become so much longer
# three windows at the end of a run, each such a share of it, in which speed and motion are compared
WINDOW = 0.2
# share of the speed up to which it is the same; up to which the three windows tell where it goes to; ratio of their changes above
# which it does not approach anything yet; share of its size and force within which a motion stays
SAME_SPEED, KNOWN, APPROACHES, ALIKE = 0.005, 1e-3, 0.9, 0.05
STILL = 1e-7  # share of the speed by which it changes from window to window where it rests: less than a slow coast-down
FASTER = 2.0  # times the fastest speed that a torque can give to the scene's own run, at which a run is ended
STRETCHES = 6  # in a block at least, of which the kind is told


def with_held(search: Search, listed: Motions, scene: Scene, most_steps: int = MOST_STEPS) -> Motions:
    """A list of motions with the outcome of each under the torque of the drive; unchanged for a prescribed speed."""
    if scene.drive.inertia is None or not listed.speed > 0.0:
        return listed
    release = Release(scene, search.settling, most_steps)
    held = release.held([shown(group) for group in search.groups], [motion.torque for motion in listed.motions])
    pairs = zip(listed.motions, held, strict=True)
    motions = [replace(motion, held=own) for motion, own in pairs]
    return replace(listed, motions=motions, interrupted=search.settling.interrupted)


class Release:
    """The drive of a scene and the runs of its motions at one speed.

    Parameters
    ----------
    scene : Scene
        With a torque.
    settling : Settling
        Of the same machine, at the speed at which the motions were found.
    most_steps : int, of a run
    """

    def __init__(self, scene: Scene, settling: Settling, most_steps: int = MOST_STEPS) -> None:
        self._settling, self._most_steps = settling, most_steps
        drive = assemble(scene).drive
        assert drive is not None
        self._drive, speed, stretch = drive, settling.speed, settling.stretch
        self._fastest = FASTER * max(speed, drive.fastest / TWO_PI)
        self._packed: list[Packed] = []
        for torque in scene.drive.curves:
            prescribed = Drive.along((0.0, MOST_STRETCHES * stretch), (speed, speed))
            own = replace(prescribed, inertia=scene.drive.inertia, torque=torque)
            system = assemble(replace(scene, drive=own))
            assert system.drive is not None
            system = replace(system, drive=replace(system.drive, fastest=min(system.drive.fastest, TWO_PI * self._fastest)))
            self._packed.append(packed_for_shots(system, scene, stretch))

    def held(self, ends: Sequence[End], torques: Sequence[float]) -> list[tuple[Held, ...]]:
        """What becomes of motions, each the End of a run, of which friction takes a torque in N m; () of those that run away, and
        of those that a Ctrl-C left no time for."""
        runs = [
            (i, part, load)
            for i, (end, torque) in enumerate(zip(ends, torques, strict=True))
            if end.motion.kind != Kind.RUNNING_AWAY
            for part, load in enumerate(loads(self._drive, self._settling.speed, torque))
        ]
        told = self._settling.over(self._released, [(ends[i], part, load) for i, part, load in runs])
        count = len(self._packed)
        outcomes: list[tuple[Held, ...]] = [()] * len(ends)
        for first in range(0, len(told) - count + 1, count):  # both parts of the drive, or none
            outcomes[runs[first][0]] = tuple(told[first : first + count])
        return outcomes

    def _released(self, end: End, part: int, load: Load) -> Held:
        """One run of a motion under a part of the drive's torque."""
        shot, course = Shot(self._packed[part], end.state, end.turns), _TorqueCourse(self._settling, end.motion)
        due, goes_on, settled = self._settling.duration, True, None
        course.see(shot)
        for _ in range(max(self._most_steps // ATTEMPTS, 1)):
            goes_on = shot.advance(ATTEMPTS)
            course.see(shot)
            if not goes_on or shot.speed > self._fastest or self._settling.stopped:
                break
            if shot.time >= due:
                due = LATER * shot.time
                settled = course.settled(shot.facts())
                if settled is not None:
                    break
        course.take(shot.facts())
        way = course.way()
        if shot.stopped:
            outcome, speed, time, rate = STOPS, 0.0, shot.time, 0.0
        elif settled is None:
            outcome, time = UNKNOWN, shot.time
            speed, rate = course.speed_at_end()
        else:
            outcome = self._outcome(part, settled, way.motion, course.friction())
            speed, time, rate = settled, course.time_of(settled), 0.0
        return Held(**vars(load), outcome=outcome, speed=speed, time=time, rate=rate, **way._asdict())

    def _outcome(self, part: int, speed: float, motion: str, torque: float) -> str:
        """The outcome of a settled speed, with a motion whose friction takes a torque."""
        begin = self._settling.speed
        if abs(speed - begin) <= SAME_SPEED * begin:
            return HOLDS
        if speed < begin:
            return BRAKES
        synchronous = motion in (Kind.NO_CONTACT, Kind.FORWARD_RUB)
        further = balance_above(self._drive, part, speed, torque) > (1.0 + 2.0 * SAME_SPEED) * speed
        return CAPTURED if synchronous and further else SPEEDS_UP


class _Way(NamedTuple):
    """The motions of a run for a `Held`: the final one, where the first one was left, the worst in between."""

    motion: str
    frequency: float
    left_speed: float
    left_time: float
    passed: str


@dataclass(frozen=True)
class _Block:
    """A part of a run: numbers of its first and last (exclusive) stretch, and its motion."""

    first: int
    last: int
    motion: Motion


class _TorqueCourse:
    """A run whose speed is integrated, from a motion on."""

    def __init__(self, settling: Settling, own: Motion) -> None:
        self._settling, self._own = settling, own
        # of the looks: time, turns of the shaft since the first, its speed in Hz
        self._time, self._turns, self._speed = list[float](), list[float](), list[float]()
        self._phase = 0.0
        self._each, self._blocks = list[Stretches](), list[_Block]()

    def see(self, shot: Shot) -> None:
        """Note time, angle and speed where a run stands."""
        if self._time and not shot.time > self._time[-1]:
            return
        turned = 0.0
        if self._time:
            about = 0.5 * (self._speed[-1] + shot.speed) * (shot.time - self._time[-1])
            turned = (shot.turns - self._phase) % 1.0
            turned += self._turns[-1] + round(about - turned)  # the whole turns between two looks
        self._time.append(shot.time)
        self._turns.append(turned)
        self._speed.append(shot.speed)
        self._phase = shot.turns

    def settled(self, rows: NDArray[np.float64]) -> float | None:
        """The speed in Hz at which the run has settled, or which it approaches with the motion that it is in; None of neither."""
        self._each = side_by_side(rows, len(self._settling.gaps))
        end = self._time[-1]
        windows = list(itertools.pairwise((1.0 - k * WINDOW) * end for k in (3, 2, 1, 0)))
        speeds = [self._mean(*window) for window in windows]
        motions = [self._motion(*self._each[0].places(*window)) for window in windows]
        if not _alike(motions, self._settling.gaps):
            return None
        return _limit(speeds)

    def take(self, rows: NDArray[np.float64]) -> None:
        """The motion of a finished run from block to block."""
        self._each = side_by_side(rows, len(self._settling.gaps))
        first, ends, turned = 0, self._each[0].end, self._turned(self._each[0].end)
        while first < len(ends):
            begun = turned[first - 1] if first else 0.0
            last = max(first + STRETCHES, int(np.searchsorted(turned, begun + LEAST_TURNS + 1.0)) + 1)
            last = len(ends) if len(ends) - last < STRETCHES else last
            self._blocks.append(_Block(first, last, self._motion(first, last)))
            first = last

    def speed_at_end(self) -> tuple[float, float]:
        """(speed in Hz, its rate in Hz/s) of the last block."""
        if not self._blocks:
            return self._speed[-1], 0.0
        begin, end = self._times(self._blocks[-1])
        half = 0.5 * (begin + end)
        before, after = self._mean(begin, half), self._mean(half, end)
        rate = (after - before) / (end - half)
        return after + 0.5 * rate * (end - half), rate

    def time_of(self, speed: float) -> float:
        """Time in s from which on the mean speed of every block is this one, and its motion that of the end."""
        for block in reversed(self._blocks):
            begin, end = self._times(block)
            off = abs(self._mean(begin, end) - speed) > SAME_SPEED * speed
            if off or block.motion.kind != self._blocks[-1].motion.kind:
                return end
        return 0.0

    def friction(self) -> float:
        """Torque in N m that friction takes in the last block."""
        if not self._blocks:
            return 0.0
        contacts = self._settling.scene.contacts
        last = self._blocks[-1].motion.everywhere
        return sum(drive_load(own.facts, contact)[0] for own, contact in zip(last, contacts, strict=True))

    def way(self) -> _Way:
        """The motions of a run that has ended."""
        known = [block for block in self._blocks if block.motion.kind != Kind.NOT_RESOLVED]
        if not known:
            return _Way(str(self._own.kind), self._own.frequency, math.nan, math.nan, "")
        end, own = known[-1].motion, self._own.kind
        left = math.nan if end.kind == own else self._left(known)
        speed = math.nan
        if not math.isnan(left):
            around = max(left - self._settling.stretch, 0.0), min(left + self._settling.stretch, self._time[-1])
            speed = self._mean(*around) if left > 0.0 else self._speed[0]
        worst = min((block.motion.kind for block in known), key=RANK.index)
        passed = RANK.index(worst) < min(RANK.index(own), RANK.index(end.kind))
        frequency = end.frequency if end.kind in SELF_EXCITED else math.nan
        return _Way(str(end.kind), frequency, speed, left, str(worst) if passed else "")

    def _left(self, known: Sequence[_Block]) -> float:
        """Time in s at which the first motion is left for good."""
        same = [i for i, block in enumerate(known) if block.motion.kind == self._own.kind]
        first = known[same[-1]].first if same else 0
        last = known[min(same[-1] + 1 if same else 0, len(known) - 1)].last
        for i in range(first, last):
            pairs = zip(self._each, self._own.everywhere, strict=True)
            if any(self._changed(own, before.facts.share, i) for own, before in pairs):
                return float(self._each[0].begin[i])
        return self._times(known[same[-1]])[1] if same else 0.0

    @staticmethod
    def _changed(own: Stretches, share: float, i: int) -> bool:
        """Whether permanent contact is lost in a stretch, or contact begins where there was none."""
        part = float(own.contact_time[i] / (own.end[i] - own.begin[i]))
        return part < LASTING if share >= LASTING else share == 0.0 and part > 0.0

    def _times(self, block: _Block) -> tuple[float, float]:
        return float(self._each[0].begin[block.first]), float(self._each[0].end[block.last - 1])

    def _mean(self, begin: float, end: float) -> float:
        """Mean speed in Hz between two times."""
        first, last = self._turned(np.array([begin, end]))
        return float(last - first) / (end - begin) if end > begin else self._speed[-1]

    def _turned(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Turns of the shaft until some times in s."""
        if len(self._time) < 2:
            return self._speed[0] * times
        turned: NDArray[np.float64] = scipy.interpolate.CubicHermiteSpline(self._time, self._turns, self._speed)(times)
        return turned

    def _motion(self, first: int, last: int) -> Motion:
        """The motion of the stretches from number first to last (exclusive)."""
        begin, end = float(self._each[0].begin[first]), float(self._each[0].end[last - 1])
        shaft = self._mean(begin, end) * (end - begin)
        pairs = zip(self._each, self._settling.gaps, strict=True)
        driven = self._settling.system.driven
        return of_contacts([motion_of(parts_of(own, first, last), shaft, gap, False, driven) for own, gap in pairs])


def _alike(motions: Sequence[Motion], gaps: Sequence[float]) -> bool:
    """Whether motions have the same type, size and force; without contact, the size need only not grow."""
    if len({motion.kind for motion in motions}) > 1 or motions[-1].kind == Kind.NOT_RESOLVED:
        return False
    for course, gap in zip(zip(*(motion.everywhere for motion in motions), strict=True), gaps, strict=True):
        sizes, forces = ([getattr(own.facts, name) for own in course] for name in ("deflection_max", "mean_force"))
        grows = sizes[-1] - min(sizes) > ALIKE * max(sizes[-1], 0.2 * gap)
        if grows or np.ptp(forces) > ALIKE * max(forces):
            return False
    return True


def _limit(speeds: Sequence[float]) -> float | None:
    """The limit of three mean speeds of consecutive windows by an exponential; None if undetermined."""
    before, after, last = speeds[1] - speeds[0], speeds[2] - speeds[1], speeds[2]
    if max(abs(before), abs(after)) <= STILL * last:
        return last
    ratio = after / before if before else math.inf
    if abs(ratio) >= APPROACHES:
        return None
    further = after * ratio / (1.0 - ratio)
    return last + further if abs(further) <= KNOWN * last else None
