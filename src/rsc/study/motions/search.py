"""The search for motions that last at one speed: where runs from predicted motions and after random impacts end."""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.follow.least_friction import least_frictions
from rsc.errors import SceneError
from rsc.measure.catalogue import LastingMotion, Motions, Predicted
from rsc.measure.final import described
from rsc.measure.kinds import SELF_EXCITED, Kind
from rsc.scene.scene import Scene
from rsc.simulation.run import InitialState
from rsc.study.motions.assumed import assumed_rolls
from rsc.study.motions.candidates import candidates, several_candidates
from rsc.study.motions.random_impacts import ImpactSizes
from rsc.study.motions.settle import End, Settling, same, shown
from rsc.study.run.start import initial_state
from rsc.system.border import border_of

# velocities of a state beside a motion differ by such a share; what comes back to it lasts, if it is restless so many times: a
# chaotic motion that is left in the end is left at random
BESIDE, RESTLESS_RUNS = 0.03, 8
QUIET, QUIET_RUNS = 0.01, 8  # share of the vibration without contact that may still decay from run to run; runs at most
# a motion is what was predicted where its frequency is no further from it than this share; of an orbit that bounces than that
NEAR, NEAR_BOUNCING = 0.02, 0.2
IMPULSE_DIRECTIONS, IMPULSE_SIZES, HALVINGS = 8, np.geomspace(0.01, 1.0, 25), 6
# of a steady motion on a prediction whose small motions grow: e-foldings to wait for, blocks that this may take; and the growth
# that is rounding, in parts of the slowest frequency
DEPART, MOST_BLOCKS, ROUNDING = 7.0, 600, 1e-6


class Search:
    """The search for motions of a scene at one speed.

    base : InitialState of the rotor that is hit: running without contact, or where its run from the scene's start has settled
    """

    def __init__(
        self,
        scene: Scene,
        speed: float,
        largest: float | None = None,
        threads: int | None = None,
        note: Callable[[int, int], object] = lambda ended, of: None,
    ) -> None:
        self._asked, self._leaving = 0, list[Predicted]()
        self.groups = list[list[End]]()  # of the list that was made last, in its order
        self.settling = Settling(scene, speed, threads, lambda ended: note(ended, self._asked))
        self.scene, self.system, self.speed = self.settling.scene, self.settling.system, speed
        self.candidates = (candidates if len(self.system.contacts) == 1 else several_candidates)(self.system, speed)
        self.base, self.base_turns = self._base()
        # at each contact: change of the velocities by 1 N s
        self.changes = [np.linalg.solve(self.system.rotor.mass, contact.rotor) for contact in self.system.contacts]
        self.sizes = ImpactSizes(self.settling, largest)
        self.largest = self.sizes.largest

    def _base(self) -> tuple[InitialState, float]:
        """The motion that is hit, and the turns of the shaft there."""
        try:
            return initial_state(self.scene.with_values({"start.running": True}), self.system), 0.0
        except SceneError:  # it would touch
            (end,) = self.ends([self._resting()])
            return replace(end.state, races=None), end.turns  # impacts are given with races at rest

    def _resting(self) -> InitialState:
        """Where everything rests, of a rotor that lies in several contacts the bearing centre, from where it falls."""
        try:
            return initial_state(_at_rest(self.scene), self.system)
        except SceneError:
            if len(self.system.contacts) == 1:
                raise
            return initial_state(self.scene.with_values({"start.centre": True}), self.system)

    def ends(
        self,
        starts: Sequence[InitialState],
        turns: Sequence[float] | None = None,
        known: Sequence[End] = (),
        until_quiet: bool = False,
    ) -> list[End]:
        """Where runs from some states end, as `Settling.ends`."""
        self._asked += len(starts)
        return self.settling.ends(starts, turns, known, until_quiet)

    def after(
        self, impulses: NDArray[np.complex128], places: Sequence[int] | None = None, known: Sequence[End] = ()
    ) -> list[End]:
        """Where the runs end after impacts (n,) in N s on the base motion, at the contacts of these numbers, or at the first."""
        at = [0] * len(impulses) if places is None else places
        states = [self.hit(impulse, j) for impulse, j in zip(impulses.tolist(), at, strict=True)]
        return self.ends(states, [self.base_turns] * len(states), known)

    def hit(self, impulse: complex, place: int = 0) -> InitialState:
        """The base motion after an impact in N s at the contact of this number."""
        return replace(self.base, rotor_velocity=self.base.rotor_velocity + self.changes[place] * impulse)

    def motions(self, starts: int, seed: int, smallest: bool = False) -> Motions:
        """The list, see `motions`."""
        rng = np.random.default_rng(seed)
        (impulses, places), n = self.sizes.random(starts, rng), len(self.largest)
        random = self.after(impulses, places)
        predicted = self.ends([candidate.state for candidate in self.candidates])
        groups = _grouped([*random, *predicted], self.settling.gaps)
        if not self.settling.interrupted:
            groups = self._lasting(groups, rng)
        pairs = [(group, self.as_listed(group)) for group in groups]
        pairs.sort(key=lambda pair: pair[1].danger, reverse=True)
        self.groups = groups = [group for group, _ in pairs]
        ended = [self._home(groups, end) for end in random]
        shares = [ended.count(i) / len(ended) if ended else math.nan for i in range(len(groups))]
        sizes = np.abs(impulses[: len(random)])
        own = [_least(sizes[np.equal(ended, i)], group) for i, group in enumerate(groups)]
        contacts = range(len(self.largest)) if smallest else ()
        smallest_impulses = np.fmin.reduce([own, *(self._smallest_impulses(groups, j) for j in contacts)])
        lasting = [
            replace(motion, share=share, smallest_impulse=impulse)
            for (_, motion), share, impulse in zip(pairs, shares, smallest_impulses.tolist(), strict=True)
        ]
        known = {id(one) for one in [*(motion.predicted for motion in lasting), *self._leaving]}
        least, whirl = least_frictions(self.scene, self.speed) if n == 1 else (None, None)
        return Motions(
            speed=self.speed,
            gap=min(self.settling.gaps),
            motions=lasting,
            not_reached=[one.predicted for one in self.candidates if id(one.predicted) not in known],
            leaving=self._leaving,
            starts=len(random),
            seed=seed,
            largest=max(self.largest),
            runs=self.settling.runs,
            impulse=impulses[: len(random), None].view(float).reshape(-1, 2),
            ended=np.array(ended, dtype=int),
            touched=np.array([end.touched for end in random], dtype=bool),
            mu_min=least.value if least else math.nan,
            mu_min_frequency=least.frequency if least else math.nan,
            mu_whirl=whirl.value if whirl else math.nan,
            mu_whirl_frequency=whirl.frequency if whirl else math.nan,
            interrupted=self.settling.interrupted,
            largest_at=dict(zip((one.name for one in self.system.contacts), self.largest, strict=True)) if n > 1 else {},
            friction=self.scene.contact.friction if n == 1 else math.nan,
            assumed=assumed_rolls(self.scene, self.speed, lasting),
        )

    def _home(self, groups: list[list[End]], end: End) -> int:
        """Number of the group that an end is in, or that a run was in when it was stopped; -1 for none."""
        if end.settled:
            return next((i for i, group in enumerate(groups) if any(own is end for own in group)), -1)
        return next((i for i, group in enumerate(groups) if same(group[0], end, self.settling.gaps)), -1)

    def _lasting(self, groups: list[list[End]], rng: np.random.Generator) -> list[list[End]]:
        """The groups whose motion comes back after a small disturbance; what these runs end in joins the groups."""
        checked: list[list[End]] = []
        waiting = groups
        for _ in range(2):  # what a motion that does not last is left for is looked at once more
            beside = self._ends_beside([group[0] for group in waiting], rng)
            new: list[End] = []
            for group, first in zip(waiting, beside, strict=True):
                end = self._departed(group, first) if group[0].steady else self._left(group, first, rng)
                if end is None:
                    continue
                if end.settled and same(group[0], end, self.settling.gaps):
                    checked.append([*group, end])
                elif end.settled:
                    new.append(end)
            waiting = []
            for own in _grouped(new, self.settling.gaps):
                home = next((group for group in checked if same(group[0], own[0], self.settling.gaps)), None)
                if home is None:
                    waiting.append(own)
        return checked

    def _ends_beside(self, ends: list[End], rng: np.random.Generator) -> list[End]:
        """The ends of runs started near the last states of others."""
        states = [_beside(end, rng) for end in ends]
        return self.ends([state for state, _ in states], [turns for _, turns in states])

    def _left(self, group: list[End], end: End, rng: np.random.Generator) -> End:
        """The end of a run started near a restless motion; if it stays, a further run that settles elsewhere."""
        if end.steady or end.motion.kind == Kind.RUNNING_AWAY or not same(group[0], end, self.settling.gaps):
            return end
        own = itertools.islice(itertools.cycle([*group, end]), RESTLESS_RUNS - 1)
        more = self._ends_beside(list(own), rng)
        return next((one for one in more if one.steady and not same(group[0], one, self.settling.gaps)), end)

    def _departed(self, group: list[End], end: End) -> End | None:
        """Where a run beside a motion ends once small motions about its prediction have had time to grow, if they do: far from
        such a motion all is steady for long. None where that takes too long, and the prediction joins those that leave slowly."""
        one = self._prediction(group[0]) if group[0].motion.kind != Kind.BOUNCING else None
        waited, rate = 0.0, one.rate if one else 0.0
        if one is None or not rate > ROUNDING * self.settling.slowest:
            return end
        while end.settled and rate * waited < DEPART and same(group[0], end, self.settling.gaps):
            ends = self.ends([end.state], [end.turns]) if waited < MOST_BLOCKS * self.settling.block else []
            if not ends:
                self._leaving += [one] if one not in self._leaving else []
                return None
            end = ends[0]
            waited += end.time
        return end

    def _smallest_impulses(self, groups: list[list[End]], place: int) -> list[float]:
        """The smallest impulse found at a contact that starts each motion, N s; NaN for one that none starts, and for what needs
        none."""
        turns = np.exp(2j * np.pi * np.arange(IMPULSE_DIRECTIONS) / IMPULSE_DIRECTIONS)
        sizes = self.largest[place] * IMPULSE_SIZES
        ends = self.after((sizes[:, None] * turns).ravel(), [place] * (len(sizes) * len(turns)))
        smallest = []
        for group in groups:
            places = [k for k, end in enumerate(ends) if end.settled and same(group[0], end, self.settling.gaps)]
            if not places or group[0].motion.kind == Kind.NO_CONTACT:
                smallest.append(math.nan)
                continue
            i, k = divmod(places[0], len(turns))
            low, high = sizes[i - 1] if i else 0.0, sizes[i]
            for _ in range(HALVINGS):
                (end,) = self.after(np.array([0.5 * (low + high) * turns[k]]), [place]) or (None,)
                if end is None:
                    break
                hit = end.settled and same(group[0], end, self.settling.gaps)
                low, high = (low, 0.5 * (low + high)) if hit else (0.5 * (low + high), high)
            smallest.append(float(high))
        return smallest

    def as_listed(self, group: list[End]) -> LastingMotion:
        """A group of ends as a motion; its share and smallest impact are not known yet."""
        own = shown(group)
        if own.motion.kind == Kind.NO_CONTACT:  # it may still decay
            own = self._quieted(own)
            group.append(own)
        told = described(own.motion, self.scene)
        forces, mass = [at.facts.force_max for at in own.motion.everywhere], self.scene.rotor.total_mass
        return LastingMotion(
            **vars(told),
            share=math.nan,
            modulated=not own.steady,
            predicted=self._prediction(own),
            smallest_impulse=math.nan,
            border=border_of(self.system, self.speed, forces, told.amplitude_max, told.frequency, told.power, mass),
        )

    def _quieted(self, end: End) -> End:
        """An end without contact once its free vibrations no longer add to the vibration that the unbalance leaves."""
        before = math.inf
        for _ in range(QUIET_RUNS):
            more = self.ends([end.state], [end.turns], until_quiet=True)
            if not more or more[0].motion.kind != end.motion.kind:
                return end
            end = more[0]
            if end.motion.facts.peak_to_peak > (1.0 - QUIET) * before:
                return end
            before = end.motion.facts.peak_to_peak
        return end

    def _prediction(self, end: End) -> Predicted | None:
        """The prediction that a motion is near to."""
        kind, frequency = end.motion.kind, end.motion.frequency
        wanted = {Kind.NO_CONTACT: "no contact", Kind.FORWARD_RUB: "forward rub", Kind.ROLLING: "roll"}.get(kind)
        known = [one.predicted for one in self.candidates]
        if kind in (Kind.NO_CONTACT, Kind.FORWARD_RUB):
            own = [one for one in known if one.label == wanted]
            return min(own, key=lambda one: abs(one.amplitude - end.motion.facts.rotor_max), default=None)
        if kind not in SELF_EXCITED:
            return None
        own = [one for one in known if (one.label == "roll") == (kind == Kind.ROLLING) and one.frequency * frequency > 0.0]
        whole = described(end.motion, self.scene)
        own = [one for one in own if one.pressed == whole.pressed == whole.touched]
        nearest = min(own, key=lambda one: abs(one.frequency - frequency), default=None)
        reach = NEAR_BOUNCING if kind == Kind.BOUNCING else NEAR
        return nearest if nearest and abs(nearest.frequency / frequency - 1.0) < reach else None


def _at_rest(scene: Scene) -> Scene:
    return scene.with_values({"start.rest": True})


def _grouped(ends: Sequence[End], gaps: Sequence[float]) -> list[list[End]]:
    """Settled ends, those of one motion together, steady ones first."""
    groups: list[list[End]] = []
    for end in sorted((end for end in ends if end.settled), key=lambda end: not end.steady):
        home = next((group for group in groups if same(group[0], end, gaps)), None)
        if home is None:
            groups.append([end])
        else:
            home.append(end)
    return groups


def _least(sizes: NDArray[np.float64], group: list[End]) -> float:
    """The smallest of the impulses (n,) in N s that end in a motion; NaN for none, and for no contact, which needs none."""
    return float(sizes.min()) if sizes.size and group[0].motion.kind != Kind.NO_CONTACT else math.nan


def _beside(end: End, rng: np.random.Generator) -> tuple[InitialState, float]:
    """A state near the last one of a run: only velocities change, since displacements would indent a stiff contact."""
    state = end.state

    def changed(velocity: NDArray[np.complex128]) -> NDArray[np.complex128]:
        z = rng.uniform(-1.0, 1.0, (2, len(velocity)))
        return velocity * (1.0 + BESIDE * (z[0] + 1j * z[1]))

    beside = replace(state, rotor_velocity=changed(state.rotor_velocity), stator_velocity=changed(state.stator_velocity))
    return beside, end.turns
