"""Small motions about a whirl in more detail: the one that grows fastest, its lines, and where it leads."""

import itertools
from dataclasses import dataclass

import numpy as np
import scipy

from rsc.analysis.receptance import receptance
from rsc.analysis.stability import Growth, state_matrices, whirl_growth
from rsc.analysis.whirls import normal_force, whirl_roots, whirl_shapes

TWO_PI = 2.0 * np.pi
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
    left : (4 (N + M),) complex, gives c from a state [Re x, Im x, Re x', Im x']
    """

    eigenvalue: complex
    lines: np.ndarray
    left: np.ndarray

    def part_of(self, x, x_dot):
        """The factor c of a disturbance x (N + M,) m with the rate x_dot m/s, both in the turning frame."""
        return complex(self.left @ np.concatenate([x.real, x.imag, x_dot.real, x_dot.imag]))


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


def small_motion(system, Psi, F_N, Omega, b_star=None):
    """Find the fastest growing small motion about a whirl; arguments as `rsc.analysis.stability.whirl_growth`."""
    b_star = 0.5 * system.contact_damping if b_star is None else b_star
    matrix = state_matrices(system, np.array([Psi]), np.array([F_N]), Omega, b_star)[0]
    values, left, right = scipy.linalg.eig(matrix, left=True)
    rotor, stator = whirl_shapes(system, Psi, F_N, Omega)
    shape = np.concatenate([rotor, stator])
    n = len(shape)
    phase = np.concatenate([-shape.imag, shape.real, np.zeros(2 * n)])
    overlap = np.abs(phase @ right) / np.linalg.norm(phase) / np.linalg.norm(right, axis=0)
    phase_index = np.argmax(overlap - np.abs(values) / abs(Psi))  # the eigenvalue 0 whose vector is the phase
    ranked = [i for i in np.argsort(-values.real) if i != phase_index and values[i].imag >= 0.0]
    i = ranked[0]
    vector, dual = right[:, i], left[:, i].conj()
    dual = dual / (dual @ vector)
    lines = np.array([v[:n] + 1j * v[n : 2 * n] for v in (vector, vector.conj())])
    return SmallMotion(complex(values[i]), lines, dual)


def damper_limits(system, Psi, F_N, Omega):
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
    growths = [whirl_growth(system, Psi, F_N, Omega, share * system.contact_damping) for share in (0.0, 0.5, 1.0)]
    return DamperLimits(*growths, signs_agree=len({growth.rate > 0.0 for growth in growths}) == 1)


def undecided(system, branch):
    """Find where the limits of the one-sided contact damper disagree on the stability of a branch over the rotor speed.

    Parameters
    ----------
    system : System
    branch : rsc.analysis.branches.Branch

    Returns
    -------
    list of (float, float), Hz
        Ranges of speed with different signs of the growth rate for b* = 0 and b* = b_C, but for those narrower than 1e-4 of
        the speed: no drive holds its speed so well, and the crossing is the same for either limit.
    """
    if system.contact_damping == 0.0:
        return []

    def rates(speed):
        Omega, near = TWO_PI * speed, TWO_PI * np.interp(speed, *_rising(branch))
        roots = whirl_roots(system, Omega)
        Psi = roots[np.argmin(np.abs(roots - near))]
        F_N = normal_force(system, Psi, Omega)
        return [whirl_growth(system, Psi, F_N, Omega, b_star).rate for b_star in (0.0, system.contact_damping)]

    speeds = np.sort(branch.speed)
    inside = [event.value for event in branch.events if speeds[0] < event.value < speeds[-1]]
    places = np.linspace(0, len(speeds) - 1, _NODES).astype(int) if system.gyroscopic else [0, -1]  # else all speeds are one
    nodes = np.unique([*speeds[places], *inside])
    signs = np.array([rates(speed) for speed in nodes]) > 0.0
    edges = [
        scipy.optimize.brentq(lambda speed, i=i: rates(speed)[i], nodes[j], nodes[j + 1], xtol=_LOCATED, rtol=_LOCATED)
        for i in (0, 1)
        for j in np.flatnonzero(signs[:-1, i] != signs[1:, i])
    ]
    if len(nodes) == 1:
        return [(float(nodes[0]),) * 2] if signs[0, 0] != signs[0, 1] else []
    points = np.sort([nodes[0], nodes[-1], *edges])
    ranges = [pair for pair in itertools.pairwise(points) if pair[1] - pair[0] > _NARROW * max(abs(pair[0]), abs(pair[1]))]
    return [(float(low), float(high)) for low, high in ranges if np.prod(np.sign(rates(0.5 * (low + high)))) < 0.0]


def _rising(branch):
    order = np.argsort(branch.speed)
    return branch.speed[order], branch.frequency[order]


def departure(system, whirl, whirls):
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
    sizes = [abs(line[: system.n_rotor] @ system.contact_r) for line in motion.lines]
    line = whirl.frequency + (1.0 if sizes[0] >= sizes[1] else -1.0) * motion.eigenvalue.imag / TWO_PI
    stable = [w.frequency for w in whirls if w.stable]
    return Departure("oscillatory", min(stable, key=lambda f: abs(f - line), default=np.nan), False, line)


def _partner(system, whirl, whirls):
    """The neighbouring whirl with no zero of Re H in between: the two merge at a smaller friction."""
    for neighbour in sorted(whirls, key=lambda w: abs(w.frequency - whirl.frequency))[1:]:
        between = TWO_PI * np.linspace(whirl.frequency, neighbour.frequency, _BETWEEN)
        if neighbour.frequency < 0.0 and (receptance(system, between, TWO_PI * whirl.speed).real < 0.0).all():
            return neighbour.frequency
    return np.nan
