"""How bad it is: the verdict on a run and on what an impact can start, in facts; `rsc.show.words.verdict` says it in words.

The vocabulary is closed and explained in docs/users/motions.md.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from rsc.measure.catalogue import WHIRLING, AssumedRoll, LastingMotion, Motions, Predicted, SmallestImpact
from rsc.measure.kinds import LEAST_TURNS, RANK, Kind
from rsc.measure.several import name_of
from rsc.measure.windows import Features
from rsc.system.border import Border
from rsc.system.held import Held

# a listed motion is the run's own within such shares of speed, and of frequency; of the amplitude within three times that
SAME_SPEED, ALIKE = 0.01, 0.1
CLAIMED = 0.5  # share of all impacts that a single motion may reach unseen, above which a search tells nothing


class Severity(StrEnum):
    """What a motion, or the worst of several, means for a machine; the least severe first."""

    SAFE = "safe"
    UNKNOWN = "unknown"
    AT_RISK = "at risk"
    RUB = "rub"
    WHIRL = "whirl"
    DESTRUCTIVE = "destructive"

    @property
    def level(self) -> int:
        """Place in the order, 0 for safe."""
        return list(Severity).index(self)


def severity_of(kind: str, border: Border | None = None) -> Severity:
    """The severity of a motion of a kind, and with a Border."""
    if border is not None and border.passed:
        return Severity.DESTRUCTIVE
    if kind == Kind.NO_CONTACT:
        return Severity.SAFE
    if kind == Kind.NOT_RESOLVED:
        return Severity.UNKNOWN
    return Severity.WHIRL if kind in WHIRLING else Severity.RUB


@dataclass(frozen=True)
class RunFacts:
    """What a run did where it was worst.

    severity : Severity; motion : str, one of `rsc.measure.kinds.Kind`
    touched : bool, whether there was any contact in the run
    frequency : (2,) float Hz, lowest and highest at which that motion turned, NaN without a sense of turning
    speed : (2,) float Hz, lowest and highest rotor speed at which it was seen
    force_max : float N, of the whole run, at any contact
    border : Border of the whole run
    on_race : bool, whether the motion rolls on a race, which turns along: that is what a race is for
    """

    severity: Severity
    motion: str
    touched: bool
    frequency: tuple[float, float]
    speed: tuple[float, float]
    force_max: float
    border: Border
    on_race: bool


@dataclass(frozen=True)
class ImpactFacts:
    """The worst motion that impacts start beside the run's own; where they start none, the worst that lasts all the same.

    severity : Severity; speed : float Hz; motion : str; frequency : float Hz; force_max : float N; border : Border
    hits : int, of so many impacts, random ones, of at most largest N s; touched : int, of these, after which there was contact
    smallest : SmallestImpact that starts a whirl of the list, or None; starts : str, that whirl, named as `motion`
    held : tuple of Held, what a drive with a torque makes of the motion
    assumed : tuple of AssumedRoll, where it would end with a contact diameter, of one that runs away
    """

    severity: Severity
    speed: float
    motion: str
    frequency: float
    force_max: float
    border: Border
    hits: int
    impacts: int
    touched: int
    largest: float
    smallest: SmallestImpact | None
    starts: str
    held: tuple[Held, ...]
    assumed: tuple[AssumedRoll, ...]


@dataclass(frozen=True)
class Coverage:
    """What the random impacts at one speed can claim.

    speed : float Hz; impacts : int; touched : int, of them, after which there was any contact; unsettled : int, of those
    excluded : float, share of the impacts that touch below which any one motion that is not listed must be, with 95 % confidence;
        1 where nothing is claimed
    """

    speed: float
    impacts: int
    touched: int
    unsettled: int
    excluded: float


@dataclass(frozen=True)
class NotReached:
    """A whirl at a rotor speed in Hz that is predicted to be stable, or to be left very slowly, and that no run ended in."""

    speed: float
    whirl: Predicted


@dataclass(frozen=True)
class Verdict:
    """The first thing to read of a run or of a list of motions.

    severity : Severity, the worst of run and impacts; at risk where these are safe, and yet a motion in contact is known to last
    run : RunFacts, None of a list alone; impact : ImpactFacts, None where nothing lasts but the run's own motion
    coverage : tuple of Coverage, one a list
    not_reached : NotReached, the whirl with the largest force among those, None without
    """

    severity: Severity
    run: RunFacts | None
    impact: ImpactFacts | None
    coverage: tuple[Coverage, ...]
    not_reached: NotReached | None = None


def verdict_of(run: RunFacts | None, features: Features | None, speeds: Sequence[float], lists: Sequence[Motions]) -> Verdict:
    """The Verdict of a run, with its features and the rotor speeds of its windows in Hz, and of the lists of what can last."""
    told = [facts for listed in lists if (facts := impact_facts(listed, features, speeds))]
    impact = max(told, key=lambda facts: (facts.hits > 0, facts.severity.level, facts.force_max), default=None)
    coverage = tuple(map(coverage_of, lists))
    levels = [run.severity] if run else []
    levels += [impact.severity] if impact and impact.hits else []
    known = [one for listed in lists if (one := not_reached(listed)) and not _is_shown(one, features, speeds)]
    left = max(known, key=lambda one: one.whirl.normal_force, default=None)
    levels += [Severity.AT_RISK] if left or (impact and not impact.hits) else []
    searched = bool(coverage) and all(one.excluded <= CLAIMED for one in coverage)
    levels += [Severity.SAFE if searched else Severity.UNKNOWN] if not run or run.severity == Severity.SAFE else []
    return Verdict(max(levels, key=lambda severity: severity.level), run, impact, coverage, left)


def coverage_of(listed: Motions) -> Coverage:
    """What the random impacts of a list can claim; one that was interrupted claims nothing."""
    touched, excluded = int(listed.touched.sum()), 1.0 if listed.interrupted else listed.excluded
    return Coverage(listed.speed, listed.starts, touched, listed.unsettled, excluded)


def _is_shown(one: NotReached, features: Features | None, speeds: Sequence[float]) -> bool:
    """Whether the run itself turns as a predicted whirl, at that speed."""
    if features is None:
        return False
    pairs = zip(speeds, features.turning.tolist(), strict=True)
    near = [turning for speed, turning in pairs if abs(speed / one.speed - 1.0) < SAME_SPEED and turning]
    return any(abs(one.whirl.frequency / turning - 1.0) < ALIKE for turning in near)


def not_reached(listed: Motions) -> NotReached | None:
    """The predicted whirl of a list with the largest force that no run ended in, though it is stable or left very slowly."""
    whirls = [one for one in listed.not_reached if one.stable and one.label != "forward rub"] + listed.leaving
    hardest = max(whirls, key=lambda one: one.normal_force, default=None)
    return NotReached(listed.speed, hardest) if hardest else None


def impact_facts(listed: Motions, features: Features | None = None, speeds: Sequence[float] = ()) -> ImpactFacts | None:
    """The worst motion of a list other than that of the run; None if none is in contact."""
    others = [motion for motion in others_of(listed, features, speeds) if motion.motion != Kind.NO_CONTACT]
    if not others:
        return None
    worst = max(others, key=lambda motion: (listed.hits(motion) > 0, _severity(motion, listed).level, motion.danger))
    smallest = listed.smallest
    return ImpactFacts(
        severity=_severity(worst, listed),
        speed=listed.speed,
        motion=_name(worst),
        frequency=worst.frequency,
        force_max=max((own.force_max for own in worst.contacts.values()), default=worst.force_max),
        border=worst.border,
        hits=listed.hits(worst),
        impacts=listed.starts,
        touched=int(listed.touched.sum()),
        largest=listed.largest,
        smallest=smallest,
        starts=_name(listed.motions[smallest.motion]) if smallest else "",
        held=worst.held,
        assumed=() if worst.bounded else listed.assumed,
    )


def _name(motion: LastingMotion) -> str:
    """What a motion is, of several contacts at which."""
    return name_of({name: own.motion for name, own in motion.contacts.items()}) if motion.contacts else motion.motion


def _severity(motion: LastingMotion, listed: Motions) -> Severity:
    """The severity of a listed motion; of one that runs away, the least one that an assumed contact diameter gives."""
    if motion.bounded:
        return severity_of(motion.motion, motion.border)
    assumed = [severity_of(Kind.ROLLING, one.border) for one in listed.assumed if one.border]
    return min(assumed, key=lambda severity: severity.level, default=Severity.WHIRL)


def others_of(listed: Motions, features: Features | None, speeds: Sequence[float]) -> list[LastingMotion]:
    """The motions of a list that the run itself does not show at that speed."""
    if features is None:
        return listed.motions
    own = [i for i in range(len(speeds)) if abs(speeds[i] / listed.speed - 1.0) < SAME_SPEED]
    own = own[-1:] if np.ptp(np.asarray(speeds)) == 0.0 else own
    return [motion for motion in listed.motions if not any(is_own(features, i, motion) for i in own)]


def is_own(features: Features, i: int, motion: LastingMotion) -> bool:
    """Whether a listed motion is the one that window i of the run itself shows."""
    if str(features.kind[i]) != motion.motion:
        return False
    known = not math.isnan(motion.frequency) and features.turning[i] != 0.0
    near = not known or abs(motion.frequency / features.turning[i] - 1.0) < ALIKE
    if features.names:
        return near and name_of({name: own.motion for name, own in motion.contacts.items()}) == features.names[i]
    return near and (motion.motion == Kind.NO_CONTACT or abs(motion.amplitude_max / features.largest[i] - 1.0) < 3.0 * ALIKE)


def rate_of(features: Features, i: int) -> float:
    """Rate at which the contact deflection of window i turns, Hz; that of its strongest line where the two are one."""
    return float((features.frequency if is_line(features, i) else features.turning)[i])


def is_line(features: Features, i: int) -> bool:
    """Whether the strongest line of a window is its whirl's, which turns at that rate, in a window long enough to have lines."""
    turning, line = features.turning[i], features.frequency[i]
    return bool(abs(turning) * features.window >= LEAST_TURNS and abs(line - turning) * features.window < 0.5)


def run_facts(
    features: Features, speeds: Sequence[float], touched: bool, force_max: float, border: Border, races: bool = False
) -> RunFacts:
    """RunFacts of the windows of a run; a border that it passes makes its severity destructive whatever its motion is."""
    kinds = [str(kind) for kind in features.kind]
    worst = max(set(kinds), key=lambda kind: (severity_of(kind).level, -RANK.index(Kind(kind))))
    own = np.flatnonzero(np.array(kinds) == worst)
    if worst == Kind.NO_CONTACT and touched:
        worst = Kind.TRANSIENT
    turns = worst in (*WHIRLING, Kind.FORWARD_RUB)
    turning = np.array([rate_of(features, int(i)) for i in own] if turns else [math.nan])
    seen = np.asarray(speeds)[own]
    return RunFacts(
        severity=severity_of(worst, border if touched else None),
        motion=worst,
        touched=touched,
        frequency=(float(turning.min()), float(turning.max())),
        speed=(float(seen.min()), float(seen.max())),
        force_max=force_max,
        border=border,
        on_race=races and worst == Kind.ROLLING,
    )
