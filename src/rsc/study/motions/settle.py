"""Runs at constant speed from many states until the motion has settled or diverged, for lists of motions."""

import itertools
import math
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from math import tau as TWO_PI
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.clear import Clear
from rsc.analysis.alone.free_vibration import free_vibrations
from rsc.analysis.paper.receptance import coupled_frequencies, uncoupled_frequencies
from rsc.measure.kinds import BACKWARD, SELF_EXCITED, Kind, Motion, motion_of, of_contacts, parts_of
from rsc.measure.stretches import COLUMNS, Stretches, side_by_side
from rsc.operating_system import processors
from rsc.scene.scene import Scene
from rsc.simulation.run import InitialState
from rsc.simulation.shot import Shot, packed_for_shots
from rsc.system.assemble import assemble
from rsc.system.system import System

Result = TypeVar("Result")

_OSCILLATES = 0.01  # cycles in the time in which a free vibration falls to 1/e: fewer are none
FREE = 1e-6  # of the largest frequency, below which nothing holds a motion
# a block: so many periods of the slowest of shaft and free vibrations, in so many stretches
PERIODS, STRETCHES = 12.0, 6
# blocks that a run has at least and at most, and e-foldings of the slowest decay that it is given in between
LEAST, MOST, FOLDS = 12, 150, 8.0
# consecutive blocks that are alike within a share once a motion is steady, and blocks that its facts are taken from
ALIKE, SAME, LAST = 3, 0.01, 6
UNSETTLED = 12  # last blocks of a motion that is never steady, whose kind must be the same in both halves
GROWS, FAR = 1.02, 20.0  # from block to block, and in gaps, of a motion that runs away
# ends are one motion within these shares of frequency and of |r|; where it is not steady within the second ones
SAME_STEADY, SAME_RESTLESS = (0.01, 0.05), (0.05, 0.3)
RECOGNISED = 2  # last blocks that must each be a known motion, for a run that need not settle again
ATTEMPTS = 2_000  # steps between two looks at a run
MOST_STEPS = 20_000_000  # of a run at most, over the number of coordinates: by so much a step takes longer


@dataclass(frozen=True)
class End:
    """Where a run ends: its motion, whether that is the same from block to block, whether it lasts in kind, and its last state.

    motion : Motion of the last blocks; steady : bool; settled : bool, the kind at least does not change any more; a run that was
        stopped before has the motion that it was in
    state : InitialState, turns : float, of the shaft, in which it stands; time : float s, that the run took
    touched : bool, whether there was any contact in the run
    """

    motion: Motion
    steady: bool
    settled: bool
    state: InitialState
    turns: float
    time: float
    touched: bool


class Settling:
    """A machine at constant speed whose motions are looked for.

    Parameters
    ----------
    scene : Scene
        Whatever its schedule is, it turns at `speed`.
    speed : float, Hz
    threads : int, optional
    note : callable, called with the number of runs that have ended whenever one has
    """

    def __init__(
        self, scene: Scene, speed: float, threads: int | None = None, note: Callable[[int], object] = lambda count: None
    ) -> None:
        self.speed, self._threads, self._note = speed, threads or processors(), note
        self.runs, self.looks, self.interrupted = 0, 0, False  # looks: of `ATTEMPTS` steps each, what the runs cost
        self.slowest, decay, self.grows = _slowest(assemble(scene), speed)
        self.block = PERIODS / (min(self.slowest, abs(speed)) if speed else self.slowest)
        self.duration = self.block * float(np.clip(FOLDS / (decay * self.block), LEAST, MOST))
        faster = scene.with_values({"output.rate": max(scene.output.rate, 8.0 * abs(speed))})
        self.scene = faster.steady(speed, self.duration)
        self.system = assemble(self.scene)
        self.gaps = [contact.gap for contact in self.system.contacts]
        self.stretch = self.block / STRETCHES
        self._packed = packed_for_shots(self.system, self.scene, self.stretch)
        self._clear = Clear(self.system, TWO_PI * speed)
        self._stop, self._lock = threading.Event(), threading.Lock()

    def ends(
        self,
        starts: Sequence[InitialState],
        turns: Sequence[float] | None = None,
        known: Sequence[End] = (),
        until_quiet: bool = False,
    ) -> list[End]:
        """Where runs from some states end, in their order.

        One that has taken too many steps has settled where its kind did not change in the last blocks, as one that ended by time.
        A run may stop at one of the ends in `known` as soon as it is recognised, and where it cannot touch again, unless it is to
        go on until its free vibrations have decayed. After a Ctrl-C `interrupted` is set, and those whose runs had not begun are
        missing."""
        places = [0.0] * len(starts) if turns is None else turns
        return self.over(self._end, [(*pair, known, until_quiet) for pair in zip(starts, places, strict=True)])

    def over(self, run: Callable[..., Result], arguments: Sequence[tuple[Any, ...]]) -> list[Result]:
        """What runs give, each with arguments of its own, on all threads, in their order; interrupted as `ends`."""
        if self.interrupted:
            return []
        with ThreadPoolExecutor(self._threads) as pool:
            futures = list[Future[Result]]()
            try:
                for own in arguments:
                    futures.append(pool.submit(run, *own))
                wait(futures)
            except KeyboardInterrupt:
                self.interrupted = True
                self._stop.set()
                pool.shutdown(cancel_futures=True)
        return [future.result() for future in futures if not future.cancelled()]

    @property
    def stopped(self) -> bool:
        """Whether runs are to end at once."""
        return self._stop.is_set()

    def _end(self, start: InitialState, turns: float, known: Sequence[End] = (), until_quiet: bool = False) -> End:
        shot = Shot(self._packed, start, turns)
        rolls = all(contact.law.diameter is not None for contact in self.system.contacts)
        course = _Course(self.gaps, self.speed, self.grows, self.system.driven, rolls)
        home, looks, most = None, 0, MOST_STEPS // (self.system.n_rotor + self.system.n_stator)
        while looks < most // ATTEMPTS:
            looks += 1
            goes_on = shot.advance(ATTEMPTS)
            course.see(shot.facts())
            home = course.recognised(known)
            if not goes_on or course.steady or course.runs_away or home or self.stopped:
                break
            if not until_quiet and course.open and self._stays_clear(shot):
                course.end_free()
                break
        motion, settled = course.ending(shot.diverged, shot.finished or len(course.blocks) >= UNSETTLED)
        with self._lock:
            self.runs += 1
            self.looks += looks
            self._note(self.runs)
        end = End(motion, course.steady, settled, shot.state(), shot.turns, course.time, course.touched)
        return replace(end, motion=home.motion, settled=True) if home else end


    def _stays_clear(self, shot: Shot) -> bool:
        """Whether a run cannot touch again."""
        if not self._clear.known:
            return False
        state = shot.state()
        parts = (state.rotor, state.rotor_velocity, state.stator, state.stator_velocity)
        return self._clear.stays(parts, shot.turns)


class _Course:
    """A run as blocks of stretches, seen as they end; grows: whether a free vibration does, so that no contact never lasts;
    rolls: whether all contacts have a diameter, so that surfaces come to roll."""

    def __init__(
        self, gaps: Sequence[float], speed: float, grows: bool = False, driven: bool = False, rolls: bool = False
    ) -> None:
        self._rolls = rolls
        self._grows, self._gaps, self._speed, self._driven = grows, gaps, speed, driven
        self._each = [Stretches(np.empty((0, len(COLUMNS)))) for _ in gaps]
        self.blocks = list[Motion]()
        self.steady = False
        self._free: Motion | None = None  # of the last stretch, where nothing touches again

    def see(self, rows: NDArray[np.float64]) -> None:
        """Take all stretches that have ended so far."""
        self._each = side_by_side(rows, len(self._gaps))
        while len(rows) >= STRETCHES * (len(self.blocks) + 1) and not self.steady:
            self.blocks.append(self._motion(len(self.blocks), len(self.blocks) + 1))
            self.steady = not self._leaves(self.blocks[-1]) and _is_steady(self.blocks, self._gaps)

    @property
    def open(self) -> bool:
        """Whether the last stretch had no contact."""
        return self._count > 0 and not any(bool(own.contact_time[-1]) for own in self._each)

    def end_free(self) -> None:
        """Take the motion of the last stretch, of a run that cannot touch again, for the one that it ends in."""
        self._free, self.steady = self._between(self._count - 1, self._count), True

    @property
    def touched(self) -> bool:
        """Whether there was any contact so far."""
        return any(bool(own.contact_time.any()) for own in self._each)

    @property
    def time(self) -> float:
        """s, at which the last stretch ended."""
        return float(self._each[0].end[-1]) if self._count else 0.0

    @property
    def _count(self) -> int:
        """Number of stretches that have ended."""
        return len(self._each[0])

    def _leaves(self, motion: Motion) -> bool:
        return self._grows and motion.kind == Kind.NO_CONTACT

    def _motion(self, first: int, last: int, diverged: bool = False) -> Motion:
        """The motion of the blocks from number first to last (exclusive)."""
        return self._between(first * STRETCHES, min(last * STRETCHES, self._count), diverged)

    def _between(self, begin: int, end: int, diverged: bool = False) -> Motion:
        """The motion of the stretches from number begin to end (exclusive)."""
        if end <= begin:  # stopped before its first stretch ended
            nothing = Motion(Kind.NOT_RESOLVED, "", math.nan, Stretches(np.zeros((1, len(COLUMNS)))).whole())
            return of_contacts([nothing] * len(self._gaps))
        shaft = self._speed * float(self._each[0].end[end - 1] - self._each[0].begin[begin])
        pairs = zip(self._each, self._gaps, strict=True)
        return of_contacts([motion_of(parts_of(own, begin, end), shaft, gap, diverged, self._driven) for own, gap in pairs])

    def ending(self, diverged: bool, complete: bool) -> tuple[Motion, bool]:
        """(the motion of the last blocks, whether its kind lasts); a run that never was steady must show it twice."""
        count = len(self.blocks)
        if diverged or self.runs_away:
            first = max(count - 1, 0)
            return self._motion(first, count + 1, diverged=True), True
        if self._free is not None:
            return self._free, True
        if self.steady:
            return self._motion(max(count - ALIKE, 0), count), True
        if not complete or count < 2:  # half a block tells what it was in, and little of what came before
            own = self._between(max(self._count - STRETCHES // 2, 0), self._count)
            return replace(own, why="the run stopped before its motion settled"), False
        half = min(UNSETTLED, count) // 2
        before, after = self._motion(count - 2 * half, count - half), self._motion(count - half, count)
        if before.kind != after.kind:
            why = f"changes between {before.kind} and {after.kind} to the end"
            return replace(self._last(2 * half), kind=Kind.NOT_RESOLVED, why=why), False
        if self._leaves(after):
            return replace(after, kind=Kind.NOT_RESOLVED, why="a free vibration grows, but has not touched yet"), False
        return after, True  # what came before may hold the way there

    def _last(self, count: int) -> Motion:
        return self._motion(max(len(self.blocks) - count, 0), max(len(self.blocks), 1))

    def recognised(self, known: Sequence[End]) -> End | None:
        """The one of some ends that each of the last blocks is, or None."""
        last = self.blocks[-RECOGNISED:]
        if len(last) < RECOGNISED or self._leaves(last[-1]):
            return None
        return next((end for end in known if all(same_motion(own, end.motion, self._gaps, end.steady) for own in last)), None)

    @property
    def runs_away(self) -> bool:
        """Whether the largest deflection at a contact is far beyond its gap and rose from each of the last blocks to the next;
        with a contact diameter a backward whirl ends in rolling, however far that is."""
        if self._rolls and self.blocks and self.blocks[-1].kind in BACKWARD:
            return False
        courses = zip(*([own.facts.deflection_max for own in motion.everywhere] for motion in self.blocks[-LAST:]), strict=True)
        return any(_runs_away(sizes, gap) for sizes, gap in zip(courses, self._gaps, strict=False))


def shown(group: Sequence[End]) -> End:
    """The representative of several ends with the same motion."""
    if group[0].motion.kind == Kind.NO_CONTACT:  # the others still decay
        return min(group, key=lambda end: end.motion.facts.rotor_max)
    return group[0] if group[0].steady else group[-1]  # of a restless one that which began on it: the way there is none of it


def same(a: End, b: End, gaps: Sequence[float]) -> bool:
    """Whether two ends are one motion, by its kind, its frequency and its size at every contact."""
    return same_motion(a.motion, b.motion, gaps, a.steady and b.steady)


def same_motion(a: Motion, b: Motion, gaps: Sequence[float], steady: bool) -> bool:
    """Whether two motions are one; steady: whether both repeat, so that their figures must agree closely."""
    if a.kind != b.kind:
        return False
    if a.kind in (Kind.NO_CONTACT, Kind.RUNNING_AWAY):
        return True
    of_frequency, of_size = SAME_STEADY if steady else SAME_RESTLESS
    f, g = a.facts.turning, b.facts.turning
    sizes = ([own.facts.rotor_max for own in motion.everywhere] for motion in (a, b))
    turning = a.kind not in (*SELF_EXCITED, Kind.FORWARD_RUB) or abs(f - g) <= of_frequency * max(abs(f), abs(g))
    return turning and all(abs(r - s) <= of_size * max(r, s, gap) for r, s, gap in zip(*sizes, gaps, strict=True))


def _runs_away(sizes: Sequence[float], gap: float) -> bool:
    far = len(sizes) == LAST and sizes[-1] > FAR * gap
    return far and all(b > GROWS * a for a, b in itertools.pairwise(sizes))


def _is_steady(blocks: Sequence[Motion], gaps: Sequence[float]) -> bool:
    """Whether the last blocks are alike at every contact, or the rotor moves there without contact and less and less."""
    last = blocks[-ALIKE:]
    if len(last) < ALIKE:
        return False
    courses = zip(*(motion.everywhere for motion in last), strict=True)
    free = all(motion.kind == Kind.NO_CONTACT for motion in last)
    return all(_is_steady_at(course, gap, free) for course, gap in zip(courses, gaps, strict=True))


def _is_steady_at(last: Sequence[Motion], gap: float, free: bool) -> bool:
    """The same of the last blocks at one contact; free: whether none of several touches."""
    if len({motion.kind for motion in last}) > 1 or last[-1].kind == Kind.NOT_RESOLVED:
        return False
    if free:
        sizes = [motion.facts.deflection_max for motion in last]
        return all(b <= (1.0 + SAME) * a for a, b in itertools.pairwise(sizes))
    facts = [motion.facts for motion in last]
    scales = {
        "rotor_max": gap, "deflection_max": gap, "turning": abs(facts[-1].turning), "mean_force": facts[-1].mean_force,
        "force_max": facts[-1].force_max, "share": 1.0,
    }  # fmt: skip
    return all(np.ptp([getattr(own, name) for own in facts]) <= SAME * max(scale, 0.0) for name, scale in scales.items())


def _slowest(system: System, speed: float) -> tuple[float, float, bool]:
    """(slowest frequency in Hz of the rotor's free vibrations, where nothing holds it of those with the stator at the contact,
    and in a rigid wall the rotor speed; their slowest decay or growth in 1/s; whether one of them grows)."""
    slowest = abs(speed) or 1.0
    for frequencies in (coupled_frequencies(system, TWO_PI * speed), uncoupled_frequencies(system, TWO_PI * speed)):
        size = np.abs(frequencies) / TWO_PI
        vibrating = size[size > FREE * size.max(initial=0.0)]  # a free motion's zero is rounding
        if vibrating.size:
            slowest = float(vibrating.min())
    vibrations = free_vibrations(system, speed)
    if system.n_states:  # a controller is no spring, and some of its own motions hardly oscillate
        size = np.abs([each.frequency for each in vibrations if abs(each.frequency) > _OSCILLATES * abs(each.growth_rate)])
        slowest = float(min(size[size > FREE * size.max(initial=0.0)], default=slowest))
    rates = [vibration.growth_rate for vibration in vibrations if vibration.growth_rate != 0.0]
    grows = max(rates, default=0.0) > FREE * slowest
    return slowest, max(min(map(abs, rates), default=slowest), FREE * slowest), grows
