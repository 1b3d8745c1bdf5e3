"""Whirl branches: backward whirls over the rotor speed or over any quantity of a scene, with their ends and events.

The roots come from `rsc.rootlines`; what happens along them (force, amplitude, sliding, stability) is located here.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from rsc.analytic import normal_force, side_conditions, whirl_roots
from rsc.assemble import assemble
from rsc.predict import predict_system
from rsc.rootlines import FOLD, RANGE_END, UNBOUNDED, UNRESOLVED, Family, Join, contact_receptance, phase_slopes, root_lines
from rsc.stability import whirl_growths

TWO_PI = 2.0 * np.pi

# causes of ends and events; those of ends also come from `rsc.rootlines`
FORCE = "normal force positive"
AMPLITUDE = "|r_R| above the gap"
SLIDING = "sliding forward (12)"
CREEPING = "stable (creeping)"
OSCILLATORY = "stable (oscillatory)"
CAUSES = (FOLD, RANGE_END, UNBOUNDED, UNRESOLVED, FORCE, AMPLITUDE, SLIDING, CREEPING, OSCILLATORY)
_LOCATED = 1e-12  # relative accuracy asked of the located values
_STRAY = 1e-3  # share of a root by which it may lie beside the line's own interpolation


@dataclass(frozen=True)
class Event:
    """A place on a branch.

    cause : str, one of `CAUSES`: why the branch ends there, or which condition changes there
    value : float, of the parameter (Hz for the rotor speed)
    frequency : float Hz, of the whirl there
    holds : str, "above" or "below": on which side of `value` the condition holds; "" for an end of the line itself
    """

    cause: str
    value: float
    frequency: float
    holds: str = ""


@dataclass(frozen=True)
class Branch:
    """One whirl over rotor speed, or over a quantity of the scene.

    label : str, "A", "B", ... by rising |frequency| where the branch begins
    whirls : tuple of Whirl, at consecutive values of the grid (one between them if the branch meets none)
    lost : tuple of float, values where the whirl turns from stable to unstable on the way of the given grid
    values : (n,) parameter of the whirls; equal to `speed` for branches over the rotor speed
    begin, end : Event, at the lowest and the highest value
    events : tuple of Event between them, by rising value; each located to 1e-6 or better
    """

    label: str
    whirls: tuple
    lost: tuple
    values: np.ndarray
    begin: Event
    end: Event
    events: tuple

    speed = property(lambda self: np.array([w.speed for w in self.whirls]), doc="(n,) Hz")
    frequency = property(lambda self: np.array([w.frequency for w in self.whirls]), doc="(n,) Hz")
    stable = property(lambda self: np.array([w.stable for w in self.whirls]), doc="(n,) bool")
    amplitude = property(lambda self: np.array([w.rotor_amplitude for w in self.whirls]), doc="(n,) m, at the contact")
    growth_rate = property(lambda self: np.array([w.growth_rate for w in self.whirls]), doc="(n,) 1/s")

    def envelope(self, i):
        """(n,) m: smallest (i = 0) or largest (i = 1) |r| with the unbalance, consistent first order."""
        return np.array([w.synchronous.consistent.envelope[i] for w in self.whirls])

    def at(self, value):
        """The branch's whirl at the grid value next to `value`, or None outside the branch."""
        own = self.values
        step = np.ptp(own) / max(len(own) - 1, 1)
        if not own.min() - step <= value <= own.max() + step:
            return None
        return self.whirls[int(np.argmin(np.abs(own - value)))]


def branches(system, speeds):
    """Follow the backward whirls over the rotor speed.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    speeds : (n,) Hz, monotonic
        The way of the run: falling speeds only change what `Branch.lost` means.

    Returns
    -------
    list of Branch, by label
        Every piece of every root line with F_N > 0; empty without friction.
    """
    return _branches(lambda value: (system, float(value)), speeds)


def continuation(scene, key, values, speed=None):
    """Follow the backward whirls over a quantity of the scene at one rotor speed.

    Parameters
    ----------
    scene : Scene
    key : str
        Dotted key of a number, for example "contact.friction".
    values : (n,) float, monotonic
        In SI units (Hz for frequencies).
    speed : float, optional, Hz
        Default: the first speed of the scene's drive.

    Returns
    -------
    list of Branch, by label

    Raises
    ------
    SceneError
        A value that the scene refuses.
    """
    speed = scene.drive.speed[0] if speed is None else float(speed)
    systems = {}

    def at(value):
        if value not in systems:
            systems[value] = assemble(scene.with_values({key: float(value)}))
        return systems[value], speed

    return _branches(at, values)


def _branches(at, values):
    """Branches of the family value -> (System, speed in Hz) over monotonic values."""
    way = np.asarray(values, dtype=float)
    rising = np.sort(way)

    def family_at(value):
        system, speed = at(value)
        return system, TWO_PI * speed

    family = Family(family_at, rising[0], rising[-1])
    nodes, lines = root_lines(family, rising)
    margins = {node.value: _margins(node.system, node.Omega, node.roots) for node in nodes}
    lists = {}
    found = []
    for line in lines:
        for piece in _pieces(family, line, nodes, margins):
            whirls, own = _whirls(at, piece, lists, rising)
            events = _events(family, piece)
            holds = "below" if way[-1] >= way[0] else "above"
            lost = tuple(e.value for e in events if e.cause in (CREEPING, OSCILLATORY) and e.holds == holds)
            begin, end = (Event(join.cause, join.value, join.root / TWO_PI) for join in (piece.begin, piece.end))
            found.append(Branch("", whirls, lost, own, begin, end, events))
    return _labelled(found, rising[0])


def _labelled(found, first):
    """Branches in the order of their labels: those at the first value, then the others, by |frequency|."""
    found = sorted(found, key=lambda b: (b.begin.value > first, abs(b.whirls[0].frequency)))
    return [replace(branch, label=_name(i)) for i, branch in enumerate(found)]


def _name(i):
    return chr(ord("A") + i) if i < 26 else f"Z{i - 25}"


# ---------------------------------------------------------------- along a line


@dataclass(frozen=True, eq=False)
class _Piece:
    """A root line where F_N > 0: points (n,), margins {cause: (n,)} and its ends as Join."""

    values: np.ndarray
    roots: np.ndarray
    slopes: np.ndarray
    margins: dict
    begin: Join
    end: Join


def _margins(system, Omega, Psi):
    """Margins of the conditions at roots (n,): {cause: (n,)}, positive where it holds, NaN where F_N <= 0."""
    real = contact_receptance(system, Omega, Psi)[0].real
    force = -system.contact_stiffness * real - 1.0  # the inverse of F_N: it passes zero where F_N is unbounded
    margins = {FORCE: force}
    margins.update({cause: np.full(len(Psi), np.nan) for cause in (AMPLITUDE, SLIDING, OSCILLATORY)})
    good = np.isfinite(force) & (force > 0.0)
    if good.any():
        F_N = normal_force(system, Psi[good], Omega)
        conditions = side_conditions(system, Psi[good], F_N, Omega, np.ones(len(F_N)))
        margins[AMPLITUDE][good] = conditions["rotor_amplitude_exceeds_gap"].margin
        margins[SLIDING][good] = conditions["sliding"].margin
        margins[OSCILLATORY][good] = [-growth.rate for growth in whirl_growths(system, Psi[good], F_N, Omega)]
    return margins


def _pieces(family, line, nodes, margins):
    """The parts of a root line with positive normal force, cut where the force passes through infinity."""
    by_value = {node.value: node for node in nodes}
    at_nodes = [
        (margins[v], int(np.argmin(np.abs(by_value[v].roots - psi)))) for v, psi in zip(line.values, line.roots, strict=True)
    ]
    own = {cause: np.array([m[cause][i] for m, i in at_nodes]) for cause in (FORCE, AMPLITUDE, SLIDING, OSCILLATORY)}
    good = np.isfinite(own[FORCE]) & (own[FORCE] > 0.0)
    edges = np.flatnonzero(np.diff(good.astype(int))) + 1
    pieces = []
    for part in np.split(np.arange(len(good)), edges):
        if not good[part[0]]:
            continue
        cuts = []
        for k, outside, join in ((part[0], part[0] - 1, line.begin), (part[-1], part[-1] + 1, line.end)):
            if 0 <= outside < len(good):
                value, root = _located(family, line, min(k, outside), lambda s, o, p: _margins(s, o, p)[FORCE])
                join = Join(value, root, FORCE)
            cuts.append(join)
        taken = {cause: margin[part] for cause, margin in own.items()}
        pieces.append(_Piece(line.values[part], line.roots[part], line.slopes[part], taken, *cuts))
    return pieces


def _root_at(family, line, k, value):
    """(System, Omega, root) of a line at a value between its points k and k + 1."""
    v, psi, slope = (x[k : k + 2] for x in (line.values, line.roots, line.slopes))
    width = v[1] - v[0]
    x = (value - v[0]) / width
    guess = psi[0] * (1 + 2 * x) * (1 - x) ** 2 + psi[1] * x**2 * (3 - 2 * x)
    guess += width * (slope[0] * x * (1 - x) ** 2 - slope[1] * x**2 * (1 - x))
    system, Omega = family.at(value)
    roots = whirl_roots(system, Omega)
    return system, Omega, roots[np.argmin(np.abs(roots - guess))]


def _located(family, line, k, margin):
    """Value and root where a margin changes its sign between the points k and k + 1 of a line."""

    def at(value):
        system, Omega, root = _root_at(family, line, k, value)
        return float(margin(system, Omega, np.array([root]))[0])

    low, high = line.values[k : k + 2]
    value = brentq(at, low, high, xtol=_LOCATED * max(abs(low), abs(high)), rtol=_LOCATED)
    return float(value), float(_root_at(family, line, k, value)[2])


def _events(family, piece):
    """Events of a piece, by rising value."""
    found = []
    for cause in (AMPLITUDE, SLIDING, OSCILLATORY):
        values = piece.margins[cause]
        if not np.all(np.isfinite(values)):
            continue
        line, values = _with_extrema(family, piece, cause, values)
        for k in np.flatnonzero(values[:-1] * values[1:] < 0.0):
            value, root = _located(family, line, k, lambda s, o, p, c=cause: _margins(s, o, p)[c])
            name = _kind_of_loss(family, value, root) if cause == OSCILLATORY else cause
            found.append(Event(name, value, root / TWO_PI, "above" if values[k + 1] > 0.0 else "below"))
    return tuple(sorted(found, key=lambda event: event.value))


def _with_extrema(family, piece, cause, margins):
    """The points of a piece with those added at which a margin dips through zero between two points of one sign."""
    v = piece.values
    points = [piece.values, piece.roots, piece.slopes, margins]
    added = []
    for k in range(1, len(v) - 1):
        left, mid, right = margins[k - 1 : k + 2]
        if not (left * mid > 0.0 and mid * right > 0.0 and abs(mid) <= min(abs(left), abs(right))):
            continue
        place = (v[k + 1], v[k - 1])
        at = lambda x, k=k, s=np.sign(mid): s * _margin_near(family, piece, k - 1 if x < v[k] else k, x, cause)  # noqa: E731
        steepness = max(abs(left - mid), abs(right - mid))
        if abs(mid) > steepness:  # an extremum that lies as far from zero as a step reaches
            continue
        best = minimize_scalar(at, bounds=(min(place), max(place)), method="bounded")
        if best.fun < 0.0:
            j = k - 1 if best.x < v[k] else k
            added.append((best.x, _root_at(family, piece, j, best.x)[2], np.interp(best.x, v, piece.slopes), np.sign(mid) * best.fun))
    if not added:
        return piece, margins
    joined = np.concatenate([np.array(points), np.array(added).T], axis=1)
    joined = joined[:, np.argsort(joined[0])]
    return replace(piece, values=joined[0], roots=joined[1], slopes=joined[2]), joined[3]


def _margin_near(family, piece, k, value, cause):
    system, Omega, root = _root_at(family, piece, k, value)
    return float(_margins(system, Omega, np.array([root]))[cause][0])


def _kind_of_loss(family, value, root):
    """Whether the eigenvalue that crosses zero is real or one of a pair."""
    system, Omega = family.at(value)
    F_N = normal_force(system, np.array([root]), Omega)
    growth = whirl_growths(system, np.array([root]), F_N, Omega)[0]
    return OSCILLATORY if growth.frequency > 1e-9 * abs(root) else CREEPING


def _whirls(at, piece, lists, grid):
    """Whirls of a piece at the grid's values, or at its middle if it meets none; and those values."""
    inside = np.isin(piece.values, grid)
    values, roots = piece.values[inside], piece.roots[inside]
    if len(values) == 0:
        i = len(piece.values) // 2
        values, roots = piece.values[i : i + 1], piece.roots[i : i + 1]
    whirls = []
    for value, root in zip(values, roots, strict=True):
        if value not in lists:
            lists[value] = predict_system(*at(value))
        whirls.append(min(lists[value], key=lambda w, root=root: abs(w.frequency - root / TWO_PI)))
    return tuple(whirls), values
