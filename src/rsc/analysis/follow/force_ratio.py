"""Ratio of the normal forces of two whirls that exist together: whether one loses its stability towards the other.

Derivation, census and limits of use: docs/maintainers/analysis.md.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.follow.branch import Branch
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.predict import Whirl, refuse_backwards
from rsc.analysis.paper.receptance import contact_receptance, receptance
from rsc.analysis.paper.roots import whirl_roots
from rsc.analysis.paper.whirls import normal_force
from rsc.analysis.several.predict import predict
from rsc.arguments import SCENE, SPEED, optional, takes
from rsc.presented import Brief
from rsc.system.assemble import SceneLike, assemble
from rsc.system.system import System, only_one

SMALL = 0.3  # mirror share, and shift of the half, up to which the first order holds (bench/results/transition_criterion.md)
_BY_UNBALANCE = {"asynchronous_force_dominates"}  # the side condition that a whirl without unbalance does not have
_LOCATED = 1e-9


@dataclass(frozen=True, eq=False)
class PairLimit:
    """What whirl A needs to be stable towards whirl B, at (n,) pairs.

    least : (n,) F_A/F_B below which a small line next to Psi_B grows on A: a half, but for the mirror line to first order
    mirror_share : (n,) |q|/|H' + q| of the mirror line at 2 Psi_A - Psi_B: what the half leaves out
    slope : (n,) slope of Im(cH) over Psi at B, -1 to 1 (over |(cH)'|); where it is positive the line grows above `least`
    """

    least: NDArray[np.float64]
    mirror_share: NDArray[np.float64]
    slope: NDArray[np.float64]

    @property
    def holds(self) -> NDArray[np.bool_]:
        """(n,) bool, whether the limit means something: a mirror line that is small, in its share and in what it shifts, and a B
        on the stable side of its fold."""
        return (self.mirror_share < SMALL) & (np.abs(0.5 / self.least - 1.0) < SMALL) & (self.slope < 0.0)


@dataclass(frozen=True, repr=False)
class ForceRatio(Brief):
    """Normal forces of a whirl A and a whirl B at one rotor speed.

    frequency, towards : float Hz, of A and of B
    ratio : float, F_A/F_B
    least : float, the ratio below which A is unstable towards B; a half without the mirror line
    mirror_share : float, size of the mirror line's part; below `SMALL`, since `least` means nothing beyond
    """

    frequency: float
    towards: float
    ratio: float
    least: float
    mirror_share: float


@dataclass(frozen=True)
class RatioPlace:
    """Place over the rotor speed at which the forces of two branches pass the limit.

    label, towards : str, labels of the branches A and B
    speed, frequency : float Hz, of the rotor and of A
    holds : str, "above" or "below": on which side of the speed F_A is large enough
    ratio, mirror_share : float, as in `ForceRatio`; the ratio is the least one
    """

    label: str
    towards: str
    speed: float
    frequency: float
    holds: str
    ratio: float
    mirror_share: float


def pair_limit(
    system: System, Psi: NDArray[np.float64], F_N: NDArray[np.float64], Omega: float | NDArray[np.float64]
) -> PairLimit:
    """Find the ratio of forces at which whirl A loses its stability towards whirl B.

    With H' = H + 1/(c k_C) a line at w on A meets H'(w) + q - e(w), q = s/(2 c F_A), e = |q|^2 / conj(H'(2 Psi_A - w) + q), and
    B fulfils H'(Psi_B) = -s/(c F_B). With e = 0 both are one where F_A = F_B/2; one Newton step from Psi_B brings e in to first
    order. The contact damper is left out.

    Parameters
    ----------
    system : System
    Psi : (2, n) rad/s, the roots of A and B
    F_N : (2, n) N, their normal forces
    Omega : float or (n,), rad/s

    Returns
    -------
    PairLimit
    """
    law = law_of(system)
    c, elastic = law.turn, law.dynamic_stiffness(0.0)
    q = law.gap / (2.0 * c * F_N[0])
    mirror = receptance(system, 2.0 * Psi[0] - Psi[1], Omega) + 1.0 / (c * elastic) + q
    e = c * np.abs(q) ** 2 / mirror.conj()
    slope = contact_receptance(system, Omega, Psi[1])[1]
    shift = F_N[1] / law.gap * (e.real - slope.real / slope.imag * e.imag)
    return PairLimit(0.5 / (1.0 + shift), np.abs(q / mirror), slope.imag / np.abs(slope))


@takes(scene=SCENE, speed=optional(SPEED))
def force_ratios(scene: SceneLike, speed: float | str | None = None) -> list[ForceRatio]:
    """Compare the normal forces of the backward whirls that exist together at one rotor speed.

    Where `ratio` < `least`, the first whirl is unstable and a line next to the second grows on it. The reverse need not hold: it
    may be unstable towards another whirl, or creep.

    Parameters
    ----------
    scene : rsc.Scene
    speed : float or str, Hz, optional
        Also with its unit: "3000 rpm".
        Default: the first speed of the scene's drive.

    Returns
    -------
    list of ForceRatio
        Of every ordered pair of whirls that hold their side conditions (but for that on the unbalance) and whose `least` means
        something; by frequency.

    Raises
    ------
    SceneError
        A speed that no drive may have.

    Examples
    --------
    >>> (ratio,) = rsc.force_ratios(rsc.load_scene("disk.toml"), 100.0)
    >>> ratio.ratio > ratio.least
    True
    """
    refuse_backwards("force_ratios", scene.drive.speed[0] if speed is None else float(speed))
    only_one(scene.contacts)
    return ratios_of(assemble(scene), predict(scene, speed))


def ratios_of(system: System, whirls: Sequence[Whirl]) -> list[ForceRatio]:
    """Compare the normal forces of whirls at one rotor speed, given all of a System; returns as `force_ratios`."""
    backward = [whirl for whirl in whirls if whirl.frequency < 0.0 and _exists(whirl)]
    pairs = [(a, b) for a in backward for b in backward if a is not b]
    if not pairs:
        return []
    Psi = TWO_PI * np.array([[w.frequency for w in pair] for pair in pairs]).T
    F_N = np.array([[w.normal_force for w in pair] for pair in pairs]).T
    limit = pair_limit(system, Psi, F_N, TWO_PI * backward[0].speed)
    return [
        ForceRatio(a.frequency, b.frequency, *(float(x[i]) for x in (F_N[0] / F_N[1], limit.least, limit.mirror_share)))
        for i, (a, b) in enumerate(pairs)
        if limit.holds[i]
    ]


def ratio_places(system: System, branches: Sequence[Branch]) -> list[RatioPlace]:
    """Find where along the rotor speed the forces of two branches pass the limit.

    Parameters
    ----------
    system : System
    branches : list of Branch over the rotor speed (`rsc.analysis.follow.branches.branches`)

    Returns
    -------
    list of RatioPlace
        By branch; only where the limit means something and both whirls are as large as the gap.
    """
    if not system.turns:  # no whirl depends on the speed
        return []
    large = [branch for branch in branches if branch.amplitude.max() > system.contact.gap]
    return [place for a in large for b in large if a is not b for place in _places(system, a, b)]


def _exists(whirl: Whirl) -> bool:
    """Whether a whirl holds the side conditions that it has without unbalance."""
    return set(whirl.violated) <= _BY_UNBALANCE


def _places(system: System, a: Branch, b: Branch) -> Iterator[RatioPlace]:
    """The `RatioPlace`s of one ordered pair of branches."""
    speeds, i, j = np.intersect1d(a.speed, b.speed, return_indices=True)
    if len(speeds) < 2:
        return
    together = [[branch.whirls[m] for m in places] for branch, places in ((a, i), (b, j))]

    def at(speed: float) -> tuple[NDArray[np.float64], NDArray[np.float64], PairLimit]:
        """(Psi, F_N, PairLimit) at a speed, looked up next to the branches."""
        Omega = TWO_PI * speed
        roots = whirl_roots(system, Omega)
        near = [TWO_PI * np.interp(speed, speeds, [w.frequency for w in whirls]) for whirls in together]
        Psi = np.array([roots[[np.argmin(np.abs(roots - psi))]] for psi in near])
        F_N = normal_force(system, Psi, Omega)
        return Psi, F_N, pair_limit(system, Psi, F_N, Omega)

    def excess(speed: float) -> float:
        _, F_N, limit = at(speed)
        return float((F_N[0] / F_N[1] / limit.least)[0]) - 1.0

    Psi = TWO_PI * np.array([[w.frequency for w in whirls] for whirls in together])
    F_N = np.array([[w.normal_force for w in whirls] for whirls in together])
    limit = pair_limit(system, Psi, F_N, TWO_PI * speeds)
    usable = limit.holds & np.array([_exists(v) and _exists(w) for v, w in zip(*together, strict=True)])
    over = F_N[0] / F_N[1] / limit.least > 1.0
    for k in np.flatnonzero((over[:-1] != over[1:]) & usable[:-1] & usable[1:]):
        speed = scipy.optimize.brentq(excess, speeds[k], speeds[k + 1], xtol=_LOCATED, rtol=_LOCATED)
        Psi, F_N, limit = at(speed)
        frequency, ratio, share = (float(x[0]) for x in (Psi[0] / TWO_PI, F_N[0] / F_N[1], limit.mirror_share))
        yield RatioPlace(a.label, b.label, float(speed), frequency, "below" if over[k] else "above", ratio, share)
