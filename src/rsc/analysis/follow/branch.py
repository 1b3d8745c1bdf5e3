"""A whirl over the rotor speed or over another quantity: what is told of a branch."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.follow.events import Event
from rsc.analysis.follow.lines import RANGE_END
from rsc.analysis.paper.predict import Whirl
from rsc.analysis.several.whirl import SeveralWhirl


@dataclass(frozen=True)
class Branch:
    """One whirl over rotor speed, or over a quantity of the scene.

    label : str, "A", "B", ...: those stable somewhere first, then by the value and the |frequency| where the branch begins
    whirls : tuple of Whirl, at consecutive values of the grid (one between them if the branch meets none)
    lost : tuple of float, values where the whirl turns from stable to unstable on the way of the given grid
    values : (n,) parameter of the whirls; equal to `speed` for branches over the rotor speed
    begin, end : Event, at the lowest and the highest value
    events : tuple of Event between them, by rising value; each located to 1e-6 or better
    """

    label: str
    whirls: tuple[Whirl, ...]
    lost: tuple[float, ...]
    values: NDArray[np.float64]
    begin: Event
    end: Event
    events: tuple[Event, ...]

    @property
    def pressed(self) -> tuple[str, ...]:
        """Names of the pressed set of several contacts; empty with one."""
        return ()

    @property
    def at_contacts(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """What it is at each of several contacts; empty with one."""
        return {}

    @property
    def speed(self) -> NDArray[np.float64]:
        """(n,) Hz."""
        return np.array([w.speed for w in self.whirls])

    @property
    def frequency(self) -> NDArray[np.float64]:
        """(n,) Hz."""
        return np.array([w.frequency for w in self.whirls])

    @property
    def stable(self) -> NDArray[np.bool_]:
        """(n,) bool."""
        return np.array([w.stable for w in self.whirls])

    @property
    def decays(self) -> NDArray[np.bool_]:
        """(n,) bool, as `stable`, whatever the whirl touches."""
        return np.array([w.decays for w in self.whirls])

    @property
    def touches(self) -> tuple[tuple[str, ...], ...]:
        """(n,) of the names of the clearances that the whirl touches."""
        return tuple(w.touches for w in self.whirls)

    @property
    def amplitude(self) -> NDArray[np.float64]:
        """(n,) m, at the contact."""
        return np.array([w.rotor_amplitude for w in self.whirls])

    @property
    def normal_force(self) -> NDArray[np.float64]:
        """(n,) N."""
        return np.array([w.normal_force for w in self.whirls])

    @property
    def growth_rate(self) -> NDArray[np.float64]:
        """(n,) 1/s."""
        return np.array([w.growth_rate for w in self.whirls])

    def envelope(self, i: int) -> NDArray[np.float64]:
        """(n,) m: smallest (i = 0) or largest (i = 1) |r| with the unbalance, consistent first order."""
        return np.array([w.synchronous.consistent.envelope[i] for w in self.whirls])

    def at(self, value: float) -> Whirl | None:
        """The branch's whirl at the grid value next to `value`, or None outside the branch."""
        step = np.ptp(self.values) / max(len(self.values) - 1, 1)
        if not self.values.min() - step <= value <= self.values.max() + step:
            return None
        return self.whirls[int(np.argmin(np.abs(self.values - value)))]


@dataclass(frozen=True)
class SetBranch(Branch):
    """One whirl at a pressed set of several contacts over the rotor speed. Its whirls are `SeveralWhirl`;
    what is of one contact is told at the one that was asked for."""

    whirls: tuple[SeveralWhirl, ...]

    @property
    def pressed(self) -> tuple[str, ...]:
        """Names of the pressed set."""
        return self.whirls[0].pressed

    @property
    def at_contacts(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Contact -> "normal_force" N, "over_gap" and "phase" deg, (n,) each."""
        names = "normal_force", "over_gap", "phase"
        return {
            contact: {name: np.array([getattr(whirl.contacts[contact], name) for whirl in self.whirls]) for name in names}
            for contact in self.whirls[0].contacts
        }


def labelled(unlabelled: list[Branch]) -> list[Branch]:
    """Branches in the order of their labels: those that are stable somewhere first, then by the value and by the |frequency|
    where they begin."""

    def place(branch: Branch) -> tuple[bool, float, float, float]:
        # where the range begins its value may differ by rounding from branch to branch
        begin = -np.inf if branch.begin.cause == RANGE_END else branch.begin.value
        return not branch.decays.any(), begin, abs(branch.begin.frequency), abs(branch.end.frequency)

    return [replace(branch, label=_name(i)) for i, branch in enumerate(sorted(unlabelled, key=place))]


def _name(i: int) -> str:
    return chr(ord("A") + i) if i < 26 else f"Z{i - 25}"
