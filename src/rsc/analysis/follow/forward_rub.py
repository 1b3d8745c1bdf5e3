"""The forward rub over the rotor speed: where it exists and where it is stable, and which motions attract at a speed.

A synchronous motion in permanent contact rests in the frame turning with Omega (physics.md section 3); small motions
about it obey the equations of `rsc.analysis.paper.stability` with Psi = Omega. The unbalance fixes its phase: no eigenvalue is
free.
"""

import itertools
from dataclasses import dataclass
from functools import cache
from math import tau as TWO_PI

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.algebra.eigenvalues import eigenvalues
from rsc.analysis.alone.free_vibration import free_growth
from rsc.analysis.follow.events import CREEPING, OSCILLATORY, TOUCHES
from rsc.analysis.follow.lines import RANGE_END
from rsc.analysis.paper.anisotropy import largest_without_contact, rub_mirror_share
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.receptance import receptance
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.paper.stability import growth_of, state_matrices
from rsc.analysis.paper.synchronous import forward_rub, unbalance_response
from rsc.analysis.paper.watched import free_deflections, shape_deflections, shares, touched
from rsc.analysis.paper.whirls import MOST_MIRROR
from rsc.system.system import System

ROLLING = "backward whirl, rolling"  # an attractor
# causes of ends of a forward rub
TOUCH = "contact begins"
FOLD = "fold of two forward rubs"
# of an event where directions differ: its mirror line passes the size up to which a rub counts as a circle
CIRCULAR = "nearly circular"
_LOCATED = 1e-12
_BESIDE = 1e-6  # of its speed, how far from an event a rub is looked at on both sides


@dataclass(frozen=True)
class RubEvent:
    """A place on a line of forward rubs: cause, rotor speed in Hz, and on which side a condition holds ("" for an end)."""

    cause: str
    speed: float
    holds: str = ""


@dataclass(frozen=True, eq=False)
class RubRange:
    """A line of forward rubs over the rotor speed.

    solution : int, 0 or 1: the smaller or the larger force of the two that the quadratic may have
    begin, end : RubEvent, at the lowest and the highest speed
    events : tuple of RubEvent between them, where the stability changes or the rub ceases to be nearly a circle
    speed : (n,) Hz, rising, with points on both sides of every event
    amplitude : (n,) m; growth_rate : (n,) 1/s, of the isotropic mean where directions differ
    mirror : (n,) share of the mirror line at -Omega in the rub; 0 where directions are alike
    clearance : (n,) largest deflection over gap of the clearances that are watched; 0 without any
    """

    solution: int
    begin: RubEvent
    end: RubEvent
    events: tuple
    speed: np.ndarray
    amplitude: np.ndarray
    growth_rate: np.ndarray
    mirror: np.ndarray
    clearance: np.ndarray

    @property
    def stable(self) -> NDArray[np.bool_]:
        """(n,) bool: negative growth rate, where directions differ nearly circular, within clearances, as of an `Attractor`."""
        return (self.growth_rate < 0.0) & (self.mirror <= MOST_MIRROR) & ~self.touches

    @property
    def touches(self) -> NDArray[np.bool_]:
        """(n,) bool: whether it touches a clearance."""
        return self.clearance >= 1.0

    def stretches(self, holds):
        """[(lowest, highest speed in Hz)] of the stretches where `holds`, (n,) bool, is true; they end at events."""
        changes = [self.begin.speed]
        for i in np.flatnonzero(holds[1:] != holds[:-1]):
            low, high = self.speed[i : i + 2]
            changes.append(next((e.speed for e in self.events if low <= e.speed <= high), float(0.5 * (low + high))))
        changes.append(self.end.speed)
        return [(float(low), float(high)) for low, high in list(itertools.pairwise(changes))[0 if holds[0] else 1 :: 2]]


@dataclass(frozen=True)
class Attractor:
    """A steady motion at one rotor speed.

    kind : str, "no contact", "forward rub", "backward whirl", which slides, or `ROLLING`
    frequency : float, Hz; amplitude : float m, |r_R| at the contact without (rub, no contact: with) the unbalance
    growth_rate : float, 1/s; stable : bool, negative growth rate, where directions differ nearly circular, and within clearances
    touches : tuple of str, the clearances that it touches
    """

    kind: str
    frequency: float
    amplitude: float
    growth_rate: float
    stable: bool
    touches: tuple[str, ...] = ()


def rub_growth(system: System, rub, Omega: float):
    """Growth rate of small motions about a forward rub.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    rub : rsc.analysis.paper.synchronous.ForwardRub
    Omega : float, rad/s

    Returns
    -------
    Growth
        With all 4 (N + M) eigenvalues; frequencies in the frame turning with Omega.

    Raises
    ------
    ValueError
        Rigid contact.
    """
    # small motions do not see the unbalance, only the frame, the force and the friction
    matrix = state_matrices(system, np.array([Omega]), np.array([rub.normal_force]), Omega)[0]
    return growth_of(eigenvalues(matrix))


def rub_ranges(system: System, speeds):
    """Find where forward rubs exist and are stable.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    speeds : (n,) Hz, rising
        Ends are located to rounding; a range that fits between two speeds of the grid is found if it begins at the
        touching of the gap, |E| = s, or where the response is largest in between.

    Returns
    -------
    list of RubRange, by the speed where they begin
    """
    grid = np.asarray(speeds, dtype=float)
    cuts = [(speed, TOUCH) for speed in _roots(lambda v: _clearance(system, v), grid)]
    cuts += [(speed, FOLD) for speed in _roots(lambda v: _discriminant(system, v), grid)]
    cuts = [(grid[0], RANGE_END), *sorted(cuts), (grid[-1], RANGE_END)]
    ranges = []
    for (low, cause_low), (high, cause_high) in itertools.pairwise(cuts):
        inside = grid[(grid > low) & (grid < high)]
        ends = [v for v, c in ((low, cause_low), (high, cause_high)) if c == RANGE_END]
        points = np.unique(np.concatenate([inside, ends, [0.5 * (low + high)] if len(inside) + len(ends) == 0 else []]))
        if high <= low and len(grid) > 1:
            continue
        counts = [len(forward_rub(system, TWO_PI * v)) for v in points]
        for solution in range(min(counts, default=0)):
            ranges.append(_range(system, (solution, min(counts)), points, (RubEvent(cause_low, low), RubEvent(cause_high, high))))
    return sorted(_joined(ranges), key=lambda r: (r.begin.speed, r.solution))


def attractors(system: System, speed):
    """List the steady motions at a rotor speed: no contact, forward rubs and backward whirls that slide or roll, stable or not.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    speed : float, Hz

    Returns
    -------
    list of Attractor
    """
    Omega = TWO_PI * float(speed)
    amplitude, distance = largest_without_contact(system, Omega)
    motions, gaps = [], np.array([place.gap for place in system.clearances])
    if distance < law_of(system).gap:
        rate = free_growth(system, Omega)
        touches = touched(system, free_deflections(system, Omega) / gaps)
        motions.append(Attractor("no contact", float(speed), amplitude, rate, rate < 0.0 and not touches, touches))
    for rub in forward_rub(system, Omega):
        rate = rub_growth(system, rub, Omega).rate
        circular = rub_mirror_share(system, rub, Omega) <= MOST_MIRROR
        touches = touched(system, shape_deflections(system, rub.rotor_shape, rub.stator_shape) / gaps)
        stable = rate < 0.0 and circular and not touches
        motions.append(Attractor("forward rub", float(speed), rub.amplitude, rate, stable, touches))
    whirls = [w for w in predict_system(system, speed) if w.frequency < 0.0]
    motions += [Attractor("backward whirl", w.frequency, w.rotor_amplitude, w.growth_rate, w.stable, w.touches) for w in whirls]
    for roll in rolling_whirls(system, Omega):
        motions.append(Attractor(ROLLING, roll.Psi / TWO_PI, roll.rotor_amplitude, roll.growth_rate, roll.stable))
    return motions


def _clearance(system: System, speed):
    """(s - |E|) / s: the free gap of the motion without contact, over the gap."""
    return 1.0 - abs(unbalance_response(system, TWO_PI * speed)[1]) / law_of(system).gap


def _discriminant(system: System, speed):
    """Discriminant of the quadratic for the force over (|H'| s)^2: negative where no forward rub exists."""
    law, Omega = law_of(system), TWO_PI * speed
    c, H = law.against_force(complex(receptance(system, Omega, Omega)))
    direction = H / abs(H) if np.isfinite(H) else -1.0  # with free motions H tends to -infinity at rest
    return (direction * np.conj(c)).real ** 2 - 1.0 + abs(complex(unbalance_response(system, Omega)[1]) / law.gap) ** 2


def _roots(function, grid):
    """Zeros of a function over a grid, with dips through zero between two points found too."""
    points = list(grid)
    values = np.array([function(v) for v in grid])
    for k in range(1, len(grid) - 1):
        side = np.sign(values[k])
        left, mid, right = side * values[k - 1 : k + 2]
        if min(left, right) >= mid >= 0.0 and max(left, right) > 2.0 * mid:
            bounds = grid[k - 1], grid[k + 1]
            best = scipy.optimize.minimize_scalar(lambda v, side=side: side * function(v), bounds=bounds, method="bounded")
            if best.fun < 0.0:
                points.append(best.x)
    points = np.unique(points)
    values = np.array([function(v) for v in points])
    crossings = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    return [float(scipy.optimize.brentq(function, points[k], points[k + 1], xtol=_LOCATED, rtol=_LOCATED)) for k in crossings]


def _range(system: System, chosen, speeds, ends):
    """One solution of the quadratic (chosen: index, number of solutions) over a range without ends inside."""

    @cache
    def rub(speed):
        return forward_rub(system, TWO_PI * speed)[chosen[0]]

    @cache
    def growth(speed):
        return rub_growth(system, rub(speed), TWO_PI * speed)

    @cache
    def share(speed):
        return rub_mirror_share(system, rub(speed), TWO_PI * speed)

    @cache
    def clearance(speed):
        return clearance_share(system, rub(speed))

    def beside(speed):
        return np.clip(speed + _BESIDE * abs(speed) * np.array([-1.0, 1.0]), speeds[0], speeds[-1]).tolist()

    events = []
    for speed in _roots(lambda v: growth(v).rate, speeds) if len(speeds) > 1 else []:
        below = growth(beside(speed)[0]).rate < 0.0
        events.append(RubEvent(OSCILLATORY if growth(speed).frequency > 0.0 else CREEPING, speed, "below" if below else "above"))
    for speed in _roots(lambda v: share(v) - MOST_MIRROR, speeds) if len(speeds) > 1 and not system.isotropic else []:
        events.append(RubEvent(CIRCULAR, speed, "below" if share(beside(speed)[0]) < MOST_MIRROR else "above"))
    for speed in _roots(lambda v: clearance(v) - 1.0, speeds) if len(speeds) > 1 and system.clearances else []:
        events.append(RubEvent(TOUCHES, speed, "below" if clearance(beside(speed)[0]) < 1.0 else "above"))
    events.sort(key=lambda event: event.speed)
    speeds = np.unique(np.concatenate([speeds, *(beside(event.speed) for event in events)]))
    rows = [(rub(v).amplitude, growth(v).rate, share(v), clearance(v)) for v in speeds.tolist()]
    amplitude, rate, mirror, nearest = np.array(rows).T
    begin, end = ends
    solution = 1 if chosen[1] == 1 else chosen[0]
    return RubRange(solution, begin, end, tuple(events), speeds, amplitude, rate, mirror, nearest)


def clearance_share(system: System, rub):
    """Largest deflection over gap of a rub at the clearances that are watched; 0 without any."""
    if not system.clearances:
        return 0.0
    return float(shares(system, shape_deflections(system, rub.rotor_shape, rub.stator_shape)).max())


def _joined(ranges):
    """The ranges, with those joined that meet where the orbit just touches the gap: only the solution with the smaller force ends
    there, the one with the larger force continues."""
    merged = []
    for new in sorted(ranges, key=lambda r: (r.solution, r.begin.speed)):
        last = merged[-1] if merged else None
        if last and last.solution == new.solution and last.end == new.begin and new.begin.cause == TOUCH and new.solution == 1:
            names = ("speed", "amplitude", "growth_rate", "mirror", "clearance")
            arrays = (np.concatenate([getattr(last, n), getattr(new, n)]) for n in names)
            merged[-1] = RubRange(1, last.begin, new.end, last.events + new.events, *arrays)
        else:
            merged.append(new)
    return merged
