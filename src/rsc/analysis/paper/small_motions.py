"""Small motions about a whirl in more detail: the one that grows fastest, its lines, and where it leads."""

import itertools
from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import receptance
from rsc.analysis.paper.roots import whirl_roots
from rsc.analysis.paper.stability import Growth, state_matrices, whirl_eigenvalues, whirl_growth, whirl_phases
from rsc.analysis.paper.whirls import normal_force
from rsc.system.system import FloatOrArray, System

# frequencies between two whirls at which the sign of Re H is looked up
_BETWEEN = 401
_NODES = 41  # speeds of a branch at which the limits of the damper are looked up, besides its events
_LOCATED = 1e-9
_NARROW = 1e-4  # of the speed: no drive holds its speed better, so no machine stays in a narrower range


@dataclass(frozen=True, eq=False)
class SmallMotion:
    """The fastest growing small motion about a whirl, in the frame turning with Psi.

    x(t) = x_0 + c lines[0] e^{lambda t} + conj(c) lines[1] e^{conj(lambda) t} for any complex c; for a real eigenvalue
    x(t) = x_0 + c lines[0] e^{lambda t} with c real.

    eigenvalue : complex, 1/s, imaginary part >= 0
    lines : (2, N + M) complex, rotor then stator coordinates, at Psi + Im(lambda) and Psi - Im(lambda)
    left : (4 (N + M) + 2 p,) complex, gives c from a state [Re x, Im x, Re x', Im x', Re z, Im z] with p first-order states z
    """

    eigenvalue: complex
    lines: np.ndarray
    left: np.ndarray

    def part_of(self, x, x_dot, z=()):
        """The factor c of a disturbance x (N + M,) m with the rate x_dot m/s and states z (p,), all in the turning frame."""
        parts = x, x_dot, np.asarray(z, dtype=complex)
        return complex(self.left @ np.concatenate([part for own in parts for part in (own.real, own.imag)]))

    def sizes(self, system: System):
        """(2,) float, sizes of both lines at the contact coordinate of the rotor."""
        return np.abs(self.lines[:, : system.n_rotor] @ system.rotor.contact)

    def larger_line(self, system: System, Psi: FloatOrArray):
        """Frequency in rad/s of the larger line, about a whirl at Psi in rad/s."""
        upper, lower = self.sizes(system)
        return Psi + (1.0 if upper >= lower else -1.0) * self.eigenvalue.imag


@dataclass(frozen=True)
class DamperLimits:
    """Growth of small motions for the bounds of the one-sided contact damper.

    off, mean, on : Growth with b* = 0, b_C / 2 and b_C
    signs_agree : bool, the three rates have one sign; otherwise linear stability is undecided
    """

    off: Growth
    mean: Growth
    on: Growth
    signs_agree: bool


@dataclass(frozen=True)
class Departure:
    """The way in which an unstable whirl is left.

    kind : str, "creeping" (real eigenvalue) or "oscillatory"; "none" for a stable whirl
    towards : float Hz, the whirl the motion leaves for, NaN if there is none: of a creeping one the other root of its
        pair, of an oscillatory one the stable whirl next to its growing line
    loses_contact : bool, a creeping motion leaves that way only if its disturbance presses; otherwise contact is lost
    line : float Hz, frequency of the larger growing line (the whirl's own if creeping)
    """

    kind: str
    towards: float
    loses_contact: bool
    line: float


def small_motion(system: System, Psi: FloatOrArray, F_N: FloatOrArray, Omega: FloatOrArray):
    """Find the fastest growing small motion about a whirl; arguments as `rsc.analysis.paper.stability.whirl_growth`."""
    matrix = state_matrices(system, np.array([Psi]), np.array([F_N]), Omega)[0]
    values, left, right = scipy.linalg.eig(matrix, left=True)
    (phase,), n = whirl_phases(system, np.array([Psi]), np.array([F_N]), Omega), system.n_rotor + system.n_stator
    phase = np.append(phase, np.zeros(len(matrix) - len(phase)))
    overlap = np.abs(phase @ right) / np.linalg.norm(phase) / np.linalg.norm(right, axis=0)
    phase_index = np.argmax(overlap - np.abs(values) / abs(Psi))  # the eigenvalue 0 whose vector is the phase
    ranked = [i for i in np.argsort(-values.real) if i != phase_index and values[i].imag >= 0.0]
    i = ranked[0]
    vector, dual = right[:, i], left[:, i].conj()
    dual = dual / (dual @ vector)
    lines = np.array([v[:n] + 1j * v[n : 2 * n] for v in (vector, vector.conj())])
    return SmallMotion(complex(values[i]), lines, dual)


def damper_limits(system: System, Psi: float, F_N: float, Omega: float):
    """Judge the stability of a whirl for both bounds and the mean of the one-sided contact damper.

    While |d| grows the damper is off, while it shrinks it is on: small motions see b* between 0 and b_C.

    Parameters
    ----------
    system : System
    Psi, F_N, Omega : float, rad/s, N and rad/s

    Returns
    -------
    DamperLimits
    """
    without, half, whole = (whirl_growth(system, Psi, F_N, Omega, law_of(system).damper(share)) for share in (0.0, 0.5, 1.0))
    return DamperLimits(without, half, whole, len({growth.rate > 0.0 for growth in (without, half, whole)}) == 1)


def undecided(system: System, branch):
    """Find where the limits of the one-sided contact damper disagree on the stability of a branch over the rotor speed.

    Parameters
    ----------
    system : System
    branch : rsc.analysis.follow.branch.Branch

    Returns
    -------
    list of (float, float), Hz
        Ranges of speed with different signs of the growth rate for b* = 0 and b* = b_C, but for those narrower than 1e-4 of
        the speed: no drive holds its speed so well, and the crossing is the same for either limit.
    """
    if law_of(system).damper(1.0) == 0.0:
        return []

    whirls = sorted(branch.whirls, key=lambda whirl: whirl.speed)
    line = [w.speed for w in whirls], [w.frequency for w in whirls]

    def rate(speed, i):
        Omega, near = TWO_PI * speed, TWO_PI * np.interp(speed, *line)
        roots = whirl_roots(system, Omega)
        Psi = roots[[np.argmin(np.abs(roots - near))]]
        return float(_rates(system, Psi, normal_force(system, Psi, Omega), Omega)[i, 0])

    places = np.linspace(0, len(whirls) - 1, _NODES).astype(int) if system.turns else [0, -1]  # else all speeds are one
    nodes = {whirls[i].speed: whirls[i] for i in places}
    values = ((w.frequency * TWO_PI, w.normal_force, w.speed * TWO_PI) for w in nodes.values())
    points = dict(zip(nodes, _rates(system, *np.array(list(values)).T).T > 0.0, strict=True))
    for event in branch.events:
        if whirls[0].speed < event.value < whirls[-1].speed:
            points[event.value] = np.array([rate(event.value, i) > 0.0 for i in (0, 1)])
    speeds = sorted(points)
    if len(speeds) == 1:
        return [(speeds[0],) * 2] if len(set(points[speeds[0]])) > 1 else []
    edges = [
        scipy.optimize.brentq(rate, low, high, args=(i,), xtol=_LOCATED, rtol=_LOCATED)
        for i in (0, 1)
        for low, high in itertools.pairwise(speeds)
        if points[low][i] != points[high][i]
    ]
    ends = sorted([speeds[0], speeds[-1], *edges])
    ranges = [pair for pair in itertools.pairwise(ends) if pair[1] - pair[0] > _NARROW * max(abs(pair[0]), abs(pair[1]))]
    return [(float(low), float(high)) for low, high in ranges if np.prod([rate(0.5 * (low + high), i) for i in (0, 1)]) < 0.0]


def _rates(system: System, Psi: NDArray[np.float64], F_N: FloatOrArray, Omega: FloatOrArray):
    """Growth rates (2, n) 1/s of whirls with the contact damper off and on."""
    limits = [law_of(system).damper(share) for share in (0.0, 1.0)]
    return np.array([whirl_eigenvalues(system, Psi, F_N, Omega, b_star).real.max(axis=1) for b_star in limits])


def departure(system: System, whirl, whirls):
    """Tell in which way an unstable whirl is left.

    Parameters
    ----------
    system : System
    whirl : Whirl
    whirls : list of Whirl
        All whirls at the same speed (`rsc.predict`).

    Returns
    -------
    Departure
    """
    if whirl.growth_rate < 0.0:
        return Departure("none", np.nan, False, whirl.frequency)
    motion = small_motion(system, TWO_PI * whirl.frequency, whirl.normal_force, TWO_PI * whirl.speed)
    if motion.eigenvalue.imag == 0.0:
        return Departure("creeping", _partner(system, whirl, whirls), True, whirl.frequency)
    line = float(motion.larger_line(system, TWO_PI * whirl.frequency)) / TWO_PI
    stable = [w.frequency for w in whirls if w.decays]
    return Departure("oscillatory", min(stable, key=lambda f: abs(f - line), default=np.nan), False, line)


def _partner(system: System, whirl, whirls):
    """The neighbouring whirl with no zero of Re H in between: the two merge at a smaller friction."""
    for neighbour in sorted(whirls, key=lambda w: abs(w.frequency - whirl.frequency))[1:]:
        between = TWO_PI * np.linspace(whirl.frequency, neighbour.frequency, _BETWEEN)
        if neighbour.frequency < 0.0 and (receptance(system, between, TWO_PI * whirl.speed).real < 0.0).all():
            return neighbour.frequency
    return np.nan
