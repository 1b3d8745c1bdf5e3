"""The list of the motions that last at a rotor speed: what a simulation showed, and beside it what was only predicted."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from rsc.files.tables import Table
from rsc.measure.final import FinalMotion
from rsc.measure.kinds import BACKWARD, Kind
from rsc.system.held import Held

CONFIDENCE = 0.95
WHIRLING = (Kind.RUNNING_AWAY, *BACKWARD, Kind.FORWARD_WHIRL)


@dataclass(frozen=True)
class Predicted:
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


@dataclass(frozen=True)
class LastingMotion(FinalMotion):
    """A motion that was simulated and comes back after a small disturbance; as `FinalMotion`, and:

    share : float, of the random starts that end in it; NaN without random starts
    modulated : bool, whether it changes from block to block without end
    predicted : Predicted it is near to, or None
    smallest_knock : float N s, the smallest found that starts it; NaN where none was looked for or found
    held : tuple of rsc.system.held.Held, what a drive with a torque makes of it, simulated; empty without one
    """

    share: float
    modulated: bool
    predicted: Predicted | None
    smallest_knock: float
    held: tuple[Held, ...] = ()

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
class Motions:
    """The motions that last at a speed, the most dangerous first.

    speed : float Hz; gap : float m, of several contacts the smallest
    motions : list of LastingMotion
    not_reached : list of Predicted that no run ended in
    leaving : list of Predicted whose small motions grow, but so slowly that no run that began beside it had left it
    starts : int, random ones; seed : int; largest : float N s, of their knocks; runs : int, of all
    largest_at : dict, name -> N s, largest knock at each of several contacts, which are knocked in turn; empty with one
    knock : (starts, 2) N s, y and z, the random ones; ended : (starts,) int, number of the motion that each ends in, -1 for one
        that had not settled or does not last
    mu_min : float, the least friction with which a backward whirl is predicted to last there, NaN where none up to 5 is;
        mu_min_frequency : float Hz, of that whirl; both NaN at several contacts, for which it is not known
    interrupted : bool, whether it was stopped before all was tried; its motions are then not known to last
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
    knock: NDArray[np.float64]
    ended: NDArray[np.intp]
    mu_min: float
    mu_min_frequency: float
    interrupted: bool
    largest_at: dict[str, float] = field(default_factory=dict)

    @property
    def knocks(self) -> str:
        """The random knocks in words."""
        return f"{self.starts} random knocks {self.sizes}"

    @property
    def sizes(self) -> str:
        """How large the random knocks are, in words."""
        at = " and ".join(f"at {name} up to {size:.3g} N s" for name, size in self.largest_at.items())
        return at or f"up to {self.largest:.3g} N s"

    @property
    def excluded(self) -> float:
        """Share of all knocks above which no other motion can be started by, with 95 % confidence."""
        return 1.0 - (1.0 - CONFIDENCE) ** (1.0 / self.starts) if self.starts else 1.0

    @property
    def claim(self) -> str:
        """What the random starts can say of motions that they did not find."""
        if not self.starts:
            return "no random starts: other motions are not excluded"
        share = f"{100.0 * self.excluded:.2g} %"
        told = f"no other motion in {self.knocks}"
        unsettled = int((self.ended < 0).sum())
        lost = f"; {unsettled} had not settled" if unsettled else ""
        if self.interrupted:
            return f"interrupted after {self.knocks}: nothing is claimed"
        return f"{told}: with {100 * CONFIDENCE:.0f} % confidence none that more than {share} of them reach{lost}"

    def mirrored(self) -> "Motions":
        """The list of the machine in the mirror, where its rotor turns the other way."""

        def turned(motion: LastingMotion) -> LastingMotion:
            one = motion.predicted and replace(motion.predicted, frequency=-motion.predicted.frequency)
            return replace(motion, frequency=-motion.frequency, predicted=one)

        return replace(
            self,
            speed=-self.speed,
            motions=[turned(motion) for motion in self.motions],
            not_reached=[replace(one, frequency=-one.frequency) for one in self.not_reached],
            leaving=[replace(one, frequency=-one.frequency) for one in self.leaving],
            knock=self.knock * [1.0, -1.0],
            mu_min_frequency=-self.mu_min_frequency,
        )

    def table(self) -> Table:
        """A `rsc.files.tables.Table` with a row for each motion, for pandas (`to_dataframe`) and CSV (`to_csv`)."""
        columns = _columns(self.gap)
        return Table(tuple(columns), [[value(motion) for value in columns.values()] for motion in self.motions])

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


def _columns(gap: float) -> dict[str, Callable[[LastingMotion], object]]:
    return {
        "motion": lambda motion: motion.motion,
        "frequency in Hz": lambda motion: motion.frequency,
        "largest |r| in gaps": lambda motion: motion.amplitude_max / gap,
        "peak to peak in um": lambda motion: 2e6 * motion.amplitude_max,
        "peak force in N": lambda motion: motion.force_max,
        "torque in N m": lambda motion: motion.torque,
        "power in W": lambda motion: motion.power,
        "share of starts": lambda motion: motion.share,
        "modulated": lambda motion: motion.modulated,
        "touches": lambda motion: ", ".join(motion.touches),
        "predicted": lambda motion: motion.predicted.label if motion.predicted else "",
        "smallest knock in N s": lambda motion: motion.smallest_knock,
        "drive": lambda motion: ", ".join(one.outcome for one in motion.held),
    }
