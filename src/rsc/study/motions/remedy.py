"""Which change of a single value takes the lasting backward motion away: found on predictions, confirmed by simulated lists."""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import tau as TWO_PI

import numpy as np

from rsc.analysis.follow.escape import escapes
from rsc.analysis.follow.least_friction import band_of
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.several.predict import predict_several
from rsc.arguments import FUNCTION, IMPULSE, SCENE, SPEED, WHOLE, optional, takes
from rsc.errors import RscError, SceneError
from rsc.measure.catalogue import LastingMotion, Motions
from rsc.measure.kinds import HARMFUL
from rsc.measure.severity import verdict_of
from rsc.presented import Brief
from rsc.scene.scene import Scene
from rsc.scene.values import physical_values, with_entries
from rsc.study.motions.motions import STARTS, refuse_starts
from rsc.study.motions.random_impacts import read_largest
from rsc.study.motions.search import Search
from rsc.study.motions.settle import End, shown
from rsc.study.motions.shaft_levers import is_of, shown_name
from rsc.system.assemble import assemble
from rsc.system.system import System

# what is changed: table, key, whether it may grow, whether it may shrink
LEVERS = (
    ("contact", "friction", False, True), ("contact", "gap", True, True),
    ("rotor", "damping_ratio", True, False), ("rotor", "damping", True, False), ("rotor", "dampings", True, False),
    ("stator", "damping_ratio", True, False), ("stator", "damping", True, False), ("stator", "dampings", True, False),
    ("stator", "mass", True, True), ("stator", "masses", True, True), ("stator", "frequency", True, True),
    ("stator", "stiffness", True, True), ("stator", "stiffnesses", True, True), ("rotor", "eccentricity", False, True),
    ("rotor", "unbalance", False, True),
)  # fmt: skip
SPEED_NAME, SPEED_RANGE = "drive.speed", (2.0, 1.0 / 3.0)
FURTHEST, LEAST_FRICTION = 10.0, 0.02  # a value is changed up to this factor or its inverse, friction down to this share
STEPS, HALVINGS = 24, 5  # of the factor up to there, for the prediction, and of a step where the prediction changes
# beyond the factor from which on nothing is predicted to last: powers of it, and a little more, that are simulated in turn
BEYOND, MORE = (1.05, 1.3, 1.7, 2.5), 1.02
# powers of the furthest factor that are simulated: where what lasts is not predicted, and where predictions tell no limit
UNPREDICTED, TELLING = (0.1, 0.2, 0.4, 0.7, 1.0), (0.5, 1.0)
BISECTIONS, NEAR = 2, 0.1  # between a factor that does not help and one that does, until their logarithms are so near


@dataclass(frozen=True, repr=False)
class Remedy(Brief):
    """A change of one value that was looked at.

    name : str, of a value, or of a list whose entries all change by the factor; value : float in SI (Hz), NaN of a list
    factor : float, by which it is changed; of what does not help the furthest that was simulated, 1 where none could be
    helps : bool, whether the list at the changed value has no backward motion that lasts, and none is predicted to run away
    remains : tuple of LastingMotion, of that list, or the backward ones that last nevertheless
    predicted : float, factor from which on no backward whirl is predicted to last; NaN where none up to ten times is
    severity : str, one of `rsc.measure.severity.Severity`, of that list; "" of what does not help
    words : str, what is changed as the scene's own file calls it: the name, but of a shaft or a finite-element machine
    """

    name: str
    value: float
    factor: float
    helps: bool
    remains: tuple[LastingMotion, ...]
    predicted: float
    severity: str = ""
    words: str = ""

    @property
    def changed(self) -> float:
        """The changed value."""
        return self.value * self.factor

    @property
    def change(self) -> float:
        """The relative change, -0.4 for 40 % less."""
        return self.factor - 1.0

    @property
    def size(self) -> float:
        """The factor up or down, at least 1: to halve a value is as large a change as to double it."""
        return max(self.factor, 1.0 / self.factor)


@dataclass(frozen=True, repr=False)
class Remedies(Brief):
    """Changes that take the lasting backward motion away, and others that do not.

    speed : float Hz; motions : Motions, as the machine is
    helping : tuple of Remedy, the smallest change by its factor first; others : tuple of Remedy
    starts : int, random impacts of every list; interrupted : bool, whether not every value was looked at
    """

    speed: float
    motions: Motions
    helping: tuple[Remedy, ...]
    others: tuple[Remedy, ...]
    starts: int
    interrupted: bool

    @property
    def harmful(self) -> list[LastingMotion]:
        """The lasting backward motions and diverging motions of the unchanged machine."""
        return harmful_of(self.motions)

    @property
    def severity(self) -> str:
        """Severity of the unchanged machine, one of `rsc.measure.severity.Severity`."""
        return _severity_of(self.motions)


def _severity_of(listed: Motions) -> str:
    return str(verdict_of(None, None, (), [listed]).severity)


def harmful_of(listed: Motions) -> list[LastingMotion]:
    """The backward and diverging motions of a list."""
    return [motion for motion in listed.motions if motion.motion in HARMFUL]


@takes(scene=SCENE, speed=optional(SPEED), starts=WHOLE, seed=WHOLE, largest=optional(IMPULSE), threads=optional(WHOLE),
       note=FUNCTION)
def remedy(
    scene: Scene,
    speed: float | str | None = None,
    starts: int = STARTS,
    *,
    seed: int = 0,
    largest: float | str | None = None,
    threads: int | None = None,
    note: Callable[[int, int], object] = lambda ended, of: None,
) -> Remedies:
    """Find changes of single values that leave no backward motion which lasts.

    Friction, gaps, damping of rotor and stator, mass and stiffness of the stator, unbalance and the rotor speed are changed one
    by one, up to ten times or down to a tenth (friction to a fiftieth, the speed to twice or a third). Along each the
    predictions tell from where on no backward whirl lasts, and none runs away; there, and further on where that does not do, the
    motions that last are looked for anew (`rsc.motions`), and first whether a run that begins in the whirl of the machine as it
    is still ends in one. Only what these simulations confirm is called a remedy.

    Parameters
    ----------
    scene : Scene
    speed : float or str, Hz, optional
        Also with its unit: "3000 rpm".
        Default: the first speed of the scene.
    starts : int
        Random impacts of each list.
    seed : int
        Of these impacts.
    largest : float or str, N s, optional
        Of these impacts, as in `rsc.motions`; by default what that is for each changed machine.
    threads : int, optional
    note : callable, called with the number of runs that have ended, and how many there are so far

    Returns
    -------
    Remedies

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C; its attribute `result` is the Remedies found until then.
    SceneError
        A speed that no drive may have.
    SolverError
        A number of starts or an impulse that cannot be.

    Examples
    --------
    >>> found = rsc.remedy(rsc.load_scene("laval.toml"), starts=16)
    >>> for remedy in found.helping:
    ...     print(f"{remedy.name} times {remedy.factor:.2f}")
    contact.friction times 0.37
    """
    refuse_starts(starts, seed, threads)
    size = read_largest(largest)
    value = scene.drive.speed[0] if speed is None else float(speed)
    forward = scene.steady(value)
    if value < 0.0:
        forward, value = forward.mirrored(), -value
    remedies = _Remedying(forward, value, starts, seed, size, threads, note).remedies()
    if remedies.interrupted:
        error = KeyboardInterrupt("interrupted: the remedies found until then are kept")
        error.result = remedies  # type: ignore[attr-defined]
        raise error
    return remedies


@dataclass(frozen=True)
class _Lever:
    """A value, or the entries of a list, changed by factors up to `furthest`, below 1 downwards; values: by their names."""

    name: str
    values: dict[str, float]
    furthest: float

    def applied(self, scene: Scene, speed: float, factor: float) -> tuple[Scene, float]:
        """The scene, and the speed in Hz, with the change."""
        if self.name == SPEED_NAME:
            return scene.steady(speed * factor), speed * factor
        return with_entries(scene, {name: value * factor for name, value in self.values.items()}), speed


# factor of a change that helps, severity and motions that it leaves
_Helping = tuple[float, str, tuple[LastingMotion, ...]]


class _Remedying:
    """The search for remedies of a scene at one speed."""

    def __init__(
        self, scene: Scene, speed: float, starts: int, seed: int, largest: float | None, threads: int | None,
        note: Callable[[int, int], object],
    ) -> None:
        self._scene, self._speed, self._starts, self._seed = scene, speed, starts, seed
        self._largest, self._threads = largest, threads
        self._note, self._ended, self._interrupted = note, 0, False

    def remedies(self) -> Remedies:
        """All of them."""
        search = self._search(self._scene, self._speed)
        listed = search.motions(self._starts, self._seed)
        self._interrupted = listed.interrupted
        harmful = {id(motion) for motion in harmful_of(listed)}
        pairs = zip(search.groups, listed.motions, strict=True)
        # where a motion that runs away stands is beyond the model, and no place to begin in another machine
        states = [shown(group) for group, motion in pairs if id(motion) in harmful and motion.bounded]
        helping, others = list[Remedy](), list[Remedy]()
        if harmful and not self._interrupted:
            predicted = bool(_lasting(self._scene, self._speed))
            try:
                for own in self._each(states, predicted):
                    (helping if own.helps else others).append(own)
            except KeyboardInterrupt:
                self._interrupted = True
        helping.sort(key=lambda own: own.size)
        return Remedies(self._speed, listed, tuple(helping), tuple(others), self._starts, self._interrupted)

    def _each(self, states: Sequence[End], predicted: bool) -> Iterator[Remedy]:
        """What becomes of every value, the smallest predicted change first, until a Ctrl-C."""
        levers = [(lever, self._border(lever) if predicted else math.nan) for lever in _levers(self._scene, self._speed)]
        levers.sort(key=lambda pair: abs(math.log(pair[1])) if pair[1] == pair[1] else math.inf)
        for lever, border in levers:
            own = self._tried(lever, border, states, predicted)
            if own is None:
                return
            yield own
            if self._interrupted:
                return

    def _search(self, scene: Scene, speed: float) -> Search:
        before = self._ended

        def told(ended: int, of: int) -> None:
            self._ended = before + ended
            self._note(self._ended, before + of)

        return Search(scene, speed, self._largest, self._threads, told)

    def _border(self, lever: _Lever) -> float:
        """Factor nearest to 1 from which on, for a while, no backward whirl is predicted to last; NaN for none."""
        factors = np.exp(np.linspace(0.0, math.log(lever.furthest), STEPS + 1)).tolist()
        lasts = [True]
        for factor in factors[1:]:
            lasts.append(self._predicted(lever, factor))
            if not lasts[-1] and not lasts[-2]:  # at two in turn: one may lie in a narrow gap between two whirls
                break
        place = next((i for i in range(1, len(lasts) - 1) if not lasts[i] and not lasts[i + 1]), None)
        if place is None:
            return math.nan
        low, high = math.log(factors[place - 1]), math.log(factors[place])
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._predicted(lever, math.exp(middle)) else (low, middle)
        return math.exp(high)

    def _predicted(self, lever: _Lever, factor: float) -> bool:
        """Whether a backward whirl is predicted to last, or the scene cannot be."""
        try:
            return _lasting(*lever.applied(self._scene, self._speed, factor))
        except RscError:
            return True

    def _tried(self, lever: _Lever, border: float, states: Sequence[End], predicted: bool) -> Remedy | None:
        """The smallest change of a value that the simulations confirm, or the remaining motions; None if interrupted."""
        value = next(iter(lever.values.values())) if len(lever.values) == 1 else math.nan
        words = shown_name(self._scene, lever.name)
        remains, last, failed = tuple[LastingMotion, ...](), 1.0, 1.0 if math.isnan(border) else border
        for factor in _factors(border, lever.furthest, predicted):
            severity, left = self._left(lever, factor, states)
            if self._interrupted:
                return None
            if severity:
                factor, severity, left = self._refined(lever, failed, (factor, severity, left), states)
                return Remedy(lever.name, value, factor, True, left, border, severity, words)
            if not left:  # beyond what such a scene may have
                break
            remains, last, failed = left, factor, factor
        return Remedy(lever.name, value, last, False, remains, border, words=words)

    def _refined(self, lever: _Lever, failed: float, helping: _Helping, states: Sequence[End]) -> _Helping:
        """The change that helps after bisections between it and one that does not."""
        for _ in range(BISECTIONS):
            if abs(math.log(helping[0] / failed)) < NEAR:
                break
            middle = math.sqrt(failed * helping[0])
            try:
                severity, left = self._left(lever, middle, states)
            except KeyboardInterrupt:
                self._interrupted = True
            if self._interrupted:  # what was found stays
                break
            helping, failed = ((middle, severity, left), failed) if severity else (helping, middle)
        return helping

    def _left(self, lever: _Lever, factor: float, states: Sequence[End]) -> tuple[str, tuple[LastingMotion, ...]]:
        """The severity of a change that leaves no backward motion, else "", and what lasts then: all of it, or else the backward
        motions, if there are any; nothing where such a scene cannot be or after a Ctrl-C."""
        try:
            scene, speed = lever.applied(self._scene, self._speed, factor)
            search = self._search(scene, speed)
        except SceneError:
            return "", ()
        goes_on = self._going_on(search, states)
        listed = search.motions(self._starts if not goes_on else 0, self._seed)
        self._interrupted = self._interrupted or listed.interrupted
        harmful = tuple(harmful_of(listed)) or goes_on
        if self._interrupted:
            return "", ()
        if harmful or _runs_away(assemble(scene), scene, speed):  # a list of a few impacts need not have one that is large enough
            return "", harmful or tuple(listed.motions)
        return _severity_of(listed), tuple(listed.motions)

    @staticmethod
    def _going_on(search: Search, states: Sequence[End]) -> tuple[LastingMotion, ...]:
        """The backward motions in which runs from the whirls of the machine as it is still end."""
        ends = search.ends([replace(end.state, races=None) for end in states], [end.turns for end in states])
        return tuple(search.as_listed([end]) for end in ends if end.motion.kind in HARMFUL)


def _factors(border: float, furthest: float, predicted: bool) -> list[float]:
    """Factors to be simulated, the smallest change first."""
    if math.isnan(border):
        return [furthest**power for power in (TELLING if predicted else UNPREDICTED)]
    own = [border**power * MORE ** math.copysign(1.0, math.log(furthest)) for power in BEYOND]
    within = [factor for factor in own if abs(math.log(factor)) < abs(math.log(furthest))]
    return within if len(within) == len(own) else [*within, furthest]


def _levers(scene: Scene, speed: float) -> Iterator[_Lever]:
    """Everything that may be changed, each direction by itself."""
    known = physical_values(scene)
    tables = list(dict.fromkeys(name.partition("[")[0].rpartition(".")[0] for name in known))
    groups = {}
    for table, (kind, key, *_) in itertools.product(tables, LEVERS):
        if table.partition(".")[0] == kind:
            groups[f"{table}.{key}"] = {name: value for name, value in known.items() if is_of(name, f"{table}.{key}")}
    contacts = [table for table in tables if table.startswith("contact.")]
    for key in ("friction", "gap") if len(contacts) > 1 else ():  # of all contacts together
        groups[f"contact.*.{key}"] = {name: known[name] for table in contacts if (name := f"{table}.{key}") in known}
    for name, values in groups.items():
        _, _, up, down = next(own for own in LEVERS if own[:2] == (name.partition(".")[0], name.rpartition(".")[2]))
        least = LEAST_FRICTION if name.endswith("friction") else 1.0 / FURTHEST
        for furthest in (FURTHEST,) * up + (least,) * down if values else ():
            yield _Lever(name, values, furthest)
    for furthest in SPEED_RANGE if speed > 0.0 else ():
        yield _Lever(SPEED_NAME, {SPEED_NAME: speed}, furthest)


def with_remedy(scene: Scene, speed: float, own: Remedy) -> tuple[Scene, float]:
    """The scene and the speed in Hz with a change that was looked at."""
    lever = next(lever for lever in _levers(scene, speed) if lever.name == own.name)
    return lever.applied(scene, speed, own.factor)


def _runs_away(system: System, scene: Scene, speed: float) -> bool:
    """Whether a large enough backward motion at the only contact runs away (`rsc.analysis.follow.escape`)."""
    return len(system.contacts) == 1 and bool(escapes(system, TWO_PI * speed, band_of(scene)))


def _lasting(scene: Scene, speed: float) -> bool:
    """Whether a backward whirl is predicted to last, one that slides or one that rolls, or a large enough motion to run away."""
    system = assemble(scene)
    if _runs_away(system, scene, speed):
        return True
    several = len(system.contacts) > 1
    whirls = predict_several(system, speed) if several else predict_system(system, speed)
    if any(whirl.frequency < 0.0 and whirl.stable for whirl in whirls):
        return True
    rolls = () if several else rolling_whirls(system, TWO_PI * speed)
    return any(roll.Psi < 0.0 and roll.growth_rate < 0.0 for roll in rolls)
