"""How hard a machine is hit at random: from what just touches to ten times that, as far as a machine is ever hit so hard."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.touching import touching_impulses
from rsc.errors import SolverError

if TYPE_CHECKING:
    from rsc.study.motions.settle import Settling

FAST = 10.0  # largest impulse over the one after which a rotor in the centre of the gap just touches
SHOCK = 3.0  # m/s, of the whole rotor: of a machine dropped from half a metre; a larger impulse than this, and than
LEAST = 2.0  # times the one that just touches, is not tried
DIRECTIONS = 24  # over half a turn, in which that is looked for
SMALLEST, LARGEST = 1e-12, 1e12  # N s, that may be asked for


def read_largest(largest: float | str | None) -> float | None:
    """A largest impulse in N s; None for the default, SolverError for one that cannot be."""
    if largest is None:
        return None
    if not SMALLEST <= float(largest) <= LARGEST:
        raise SolverError(f"largest = {largest!r}: must be an impulse from {SMALLEST:g} to {LARGEST:g} N s")
    return float(largest)


class ImpactSizes:
    """How large impacts at each contact are.

    Parameters
    ----------
    settling : Settling, of the machine at its speed
    largest : float N s, largest impulse at every contact; None: the default

    Attributes
    ----------
    largest : list of float N s, largest impulse at each contact
    """

    def __init__(self, settling: "Settling", largest: float | None = None) -> None:
        self._system, self._Omega = settling.system, 2.0 * np.pi * settling.speed
        mass = settling.scene.rotor.total_mass
        self._hardest = np.inf if np.isnan(mass) else SHOCK * mass  # N s
        self._rise = 0.25 / settling.slowest  # s: a vibration from the centre is largest after a quarter of its period
        places = range(len(self._system.contacts))
        self.largest = [largest if largest else self._default(place) for place in places]

    def _default(self, place: int) -> float:
        angles = np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        touching = float(self._each(place, angles)[:, place].max())
        return float(min(FAST * touching, max(LEAST * touching, self._hardest)))

    def _each(self, place: int, angles: NDArray[np.float64]) -> NDArray[np.float64]:
        return touching_impulses(self._system, self._Omega, place, self._rise, angles)

    def touching(self, place: int, angles: NDArray[np.float64]) -> NDArray[np.float64]:
        """The impulses (k,) in N s at a contact, in directions (k,) in rad, after which a rotor in the centre just touches."""
        return np.asarray(self._each(place, angles).min(axis=1))

    def random(self, count: int, rng: np.random.Generator) -> tuple[NDArray[np.complex128], list[int]]:
        """(impulses (count,) in N s, numbers of the contacts that they hit): directions evenly over the turn, sizes evenly from
        what just lets any contact touch from the centre, or from 0 where that is beyond the largest, to the largest."""
        shares, angles = rng.uniform(size=count), 2.0 * np.pi * rng.uniform(size=count)
        places = np.arange(count) % len(self.largest)
        sizes = np.zeros(count)
        for place, largest in enumerate(self.largest):
            own = places == place
            touching = self.touching(place, angles[own])
            least = np.where(touching < largest, touching, 0.0)
            sizes[own] = least + shares[own] * (largest - least)
        return sizes * np.exp(1j * angles), places.tolist()
