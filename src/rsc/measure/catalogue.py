"""The list of motions that last at a rotor speed: simulated ones, and predicted ones not reached."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaincinv

from rsc.files.tables import Table
from rsc.measure.final import FinalMotion
from rsc.measure.kinds import BACKWARD, Kind
from rsc.presented import Brief, drawing
from rsc.system.border import Border
from rsc.system.held import Held

CONFIDENCE = 0.95
WHIRLING = (Kind.RUNNING_AWAY, *BACKWARD, Kind.FORWARD_WHIRL)


@dataclass(frozen=True, repr=False)
class Predicted(Brief):
    """A motion that the analysis predicts at a speed.

    label : str, "A", "B", ... of whirls by rising frequency, "roll", "forward rub" or "no contact"
    frequency : float Hz; amplitude : float m, |r| of the rotor; normal_force : float N; of a whirl all without unbalance
    growth_rate : float 1/s, of small motions about it; with_unbalance : float 1/s, the same with its unbalance (NaN: not known)
    possible : bool, whether it slides forward as it is taken to
    touches : tuple of str, the clearances that it touches, and of several contacts those that it touches beside its pressed set
    forces : dict, name -> normal force in N at each of several contacts, 0 where it is not pressed (`normal_force` is the largest
        of them, `amplitude` the one there); empty with one
    """

    label: str
    frequency: float
    amplitude: float
    normal_force: float
    growth_rate: float
    with_unbalance: float
    possible: bool
    touches: tuple[str, ...] = ()
    forces: dict[str, float] = field(default_factory=dict)

    @property
    def pressed(self) -> tuple[str, ...]:
        """Names of the pressed ones of several contacts."""
        return tuple(name for name, force in self.forces.items() if force > 0.0)

    @property
    def rate(self) -> float:
        """Growth rate of small motions about it, with its unbalance where that is known, 1/s."""
        return self.growth_rate if math.isnan(self.with_unbalance) else self.with_unbalance

    @property
    def stable(self) -> bool:
        """Whether it is possible, small motions about it decay, and it touches no clearance."""
        return self.possible and self.rate < 0.0 and not self.touches


@dataclass(frozen=True, repr=False)
class LastingMotion(FinalMotion):
    """A motion that was simulated and comes back after a small disturbance; as `FinalMotion`, and:

    share : float, of the random starts that end in it; NaN without random starts
    modulated : bool, whether it changes from block to block without end
    predicted : Predicted it is near to, or None
    smallest_impulse : float N s, the smallest found that starts it; NaN where none was looked for or found
    border : rsc.system.border.Border, how far it is towards what the contact law and any machine can bear
    held : tuple of rsc.system.held.Held, what a drive with a torque makes of it, simulated; empty without one
    """

    share: float
    modulated: bool
    predicted: Predicted | None
    smallest_impulse: float
    border: Border
    held: tuple[Held, ...] = ()

    @property
    def bounded(self) -> bool:
        """Whether its size is bounded; one that runs away is not."""
        return self.motion != Kind.RUNNING_AWAY

    @property
    def danger(self) -> tuple[bool, float, float]:
        """By which lists are sorted, the largest first: whether it is unbounded, largest force times largest |r| in N m, power in
        W."""
        force = max((own.force_max for own in self.contacts.values()), default=self.force_max)
        power = 0.0 if math.isnan(self.power) else self.power
        return not self.bounded, force * self.amplitude_max, power

    @property
    def off(self) -> tuple[float, float]:
        """How far it is from its prediction, as shares: of frequency, and of mean normal force, the largest of several contacts;
        NaN without a prediction."""
        if self.predicted is None:
            return math.nan, math.nan
        known = self.predicted.forces or {"": self.predicted.normal_force}
        own = {name: at.force_mean for name, at in self.contacts.items()} or {"": self.force_mean}
        forces = [abs(own[name] / force - 1.0) for name, force in known.items() if force > 0.0]
        return abs(self.frequency / self.predicted.frequency - 1.0), max(forces, default=math.nan)


@dataclass(frozen=True)
class SmallestImpact:
    """The smallest impact that was found to start a whirl: an upper bound of the smallest one that does.

    impulse : float N s; direction : float degrees, from y towards z, at the shaft's angle 0
    velocity : float m/s, by which it changes that of the rotor at the contact; of a shaft that of the short piece that is hit
    over_touching : float, it over the smallest impulse in its direction by which a rotor in the centre of the gap just touches
    below : float N s, next smaller size that was tried, in every direction, and started none; 0 where none was
    directions : int, in which sizes were tried
    motion : int, number of the motion of the list that it starts
    first_force : float N, largest normal force of the first touch; first_penetration : float, that over k_C and the gap
    contact : str, name of the one of several contacts that is hit; "" with one
    rotor_velocity : float m/s, at which the whole rotor has as much momentum; NaN where its model does not tell its mass
    """

    impulse: float
    direction: float
    velocity: float
    over_touching: float
    below: float
    directions: int
    motion: int
    first_force: float
    first_penetration: float
    contact: str = ""
    rotor_velocity: float = math.nan


@dataclass(frozen=True)
class AssumedRoll:
    """The rolling whirl in which a motion that runs away would end if the shaft had this diameter at the contact, in m, by
    prediction; None where none is predicted to be stable."""

    diameter: float
    roll: Predicted | None
    border: Border | None


@dataclass(frozen=True, repr=False)
class Motions(Brief):
    """The motions that last at a speed, the most dangerous first.

    speed : float Hz; gap : float m, of several contacts the smallest
    motions : list of LastingMotion
    not_reached : list of Predicted that no run ended in
    leaving : list of Predicted whose small motions grow, but so slowly that no run that began beside it had left it
    starts : int, random ones; seed : int; largest : float N s, of their impacts; runs : int, of all
    largest_at : dict, name -> N s, largest impulse at each of several contacts, which are hit in turn; empty with one
    impulse : (starts, 2) N s, y and z, the random ones; ended : (starts,) int, number of the motion that each ends in, -1 for one
        that had not settled or does not last; touched : (starts,) bool, whether there was any contact after it
    mu_min : float, the least friction with which anything backward is predicted to last or to run away there, NaN where none up
        to 5 is; mu_min_frequency : float Hz, of that motion; both NaN at several contacts, for which it is not known
    mu_whirl : float, the same of what lasts; larger than `mu_min` where motions run away before; mu_whirl_frequency : float Hz
    interrupted : bool, whether it was stopped before all was tried; its motions are then not known to last
    friction : float, of the scene; NaN at several contacts
    smallest : SmallestImpact found to start a whirl, or None where none was looked for or found
    assumed : tuple of AssumedRoll, of a list in which something runs away: without a diameter nothing bounds it
    """

    speed: float
    gap: float
    motions: list[LastingMotion]
    not_reached: list[Predicted]
    leaving: list[Predicted]
    starts: int
    seed: int
    largest: float
    runs: int
    impulse: NDArray[np.float64]
    ended: NDArray[np.intp]
    touched: NDArray[np.bool_]
    mu_min: float
    mu_min_frequency: float
    mu_whirl: float
    mu_whirl_frequency: float
    interrupted: bool
    largest_at: dict[str, float] = field(default_factory=dict)
    friction: float = math.nan
    smallest: SmallestImpact | None = None
    assumed: tuple[AssumedRoll, ...] = ()

    def __len__(self) -> int:
        return len(self.motions)

    def __iter__(self) -> Iterator[LastingMotion]:
        return iter(self.motions)

    def __getitem__(self, number: int) -> LastingMotion:
        return self.motions[number]

    def __bool__(self) -> bool:
        return True  # a list without motions is an answer too

    def plot(self, ax: Any = None) -> Any:
        """Draw the random impacts, of several contacts those at the first, coloured by the motion in which each ends.

        ax : matplotlib axes, by default those of a new figure. Returns the axes.
        """
        return drawing().motions(self, ax)

    @property
    def impacts(self) -> str:
        """The random impacts in words."""
        return f"{self.starts} random impacts {self.sizes}"

    @property
    def sizes(self) -> str:
        """How large the random impacts are, in words."""
        at = " and ".join(f"at {name} up to {size:.3g} N s" for name, size in self.largest_at.items())
        return at or f"up to {self.largest:.3g} N s"

    @property
    def unsettled(self) -> int:
        """Random impacts that touched and after which nothing had settled in a motion of the list."""
        return int((self.touched & (self.ended < 0)).sum())

    @property
    def excluded(self) -> float:
        """Share of the impacts that touch below which any one motion that is not listed must be, with 95 % confidence.

        An impact that had not settled may have been on its way to that motion: with u of n unsettled this is the upper
        Clopper-Pearson bound, 1 - 0.05^(1/n) for u = 0; those after which nothing touched tell nothing. It holds for one motion,
        chosen beforehand, not for all unlisted ones together.
        """
        settled = int(self.touched.sum()) - self.unsettled
        return float(betaincinv(self.unsettled + 1, settled, CONFIDENCE)) if settled else 1.0

    def hits(self, motion: LastingMotion) -> int:
        """How many of the random impacts end in a motion of the list."""
        return sum(self.motions[i] is motion for i in self.ended if i >= 0)

    def mirrored(self) -> "Motions":
        """The list of the machine in the mirror, where its rotor turns the other way."""

        def turned(motion: LastingMotion) -> LastingMotion:
            return replace(motion, frequency=-motion.frequency, predicted=motion.predicted and _turned(motion.predicted))

        return replace(
            self,
            speed=-self.speed,
            motions=[turned(motion) for motion in self.motions],
            not_reached=[_turned(one) for one in self.not_reached],
            leaving=[_turned(one) for one in self.leaving],
            impulse=self.impulse * [-1.0, 1.0],
            mu_min_frequency=-self.mu_min_frequency,
            mu_whirl_frequency=-self.mu_whirl_frequency,
            smallest=self.smallest and replace(self.smallest, direction=(180.0 - self.smallest.direction) % 360.0),
            assumed=tuple(replace(one, roll=one.roll and _turned(one.roll)) for one in self.assumed),
        )

    def table(self) -> Table:
        """A `rsc.files.tables.Table` with a row for each motion, for pandas (`to_dataframe`) and CSV (`to_csv`)."""
        columns = _columns(self.gap)
        return Table(tuple(columns), [[value(motion) for value in columns.values()] for motion in self.motions])

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


def _turned(one: Predicted) -> Predicted:
    return replace(one, frequency=-one.frequency)


def _columns(gap: float) -> dict[str, Callable[[LastingMotion], object]]:
    return {
        "motion": lambda motion: motion.motion,
        "frequency in Hz": lambda motion: motion.frequency,
        "largest |r| in gaps": lambda motion: motion.amplitude_max / gap,
        "peak to peak in um": lambda motion: 1e6 * motion.peak_to_peak,
        "peak force in N": lambda motion: motion.force_max,
        "penetration in gaps": lambda motion: motion.border.penetration,
        "torque in N m": lambda motion: motion.torque,
        "power in W": lambda motion: motion.power,
        "share of starts": lambda motion: motion.share,
        "modulated": lambda motion: motion.modulated,
        "touches": lambda motion: ", ".join(motion.touches),
        "predicted": lambda motion: motion.predicted.label if motion.predicted else "",
        "smallest impulse in N s": lambda motion: motion.smallest_impulse,
        "drive": lambda motion: ", ".join(one.outcome for one in motion.held),
    }
