"""Events along a root line: where the normal force, the amplitude, sliding or the stability of a whirl changes, located.

A root line (`rsc.analysis.lines.rootlines`) is cut into the pieces on which the contact is pressed; margins, positive where a
condition holds, are followed along each, and their zeros are the events.
"""

from dataclasses import dataclass, replace
from math import tau as TWO_PI

import numpy as np
import scipy

from rsc.analysis.lines.rootlines import FOLD, RANGE_END, UNBOUNDED, UNRESOLVED, Join, blocks
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import contact_receptance
from rsc.analysis.paper.stability import whirl_growths
from rsc.analysis.paper.synchronous import synchronous_lines
from rsc.analysis.paper.watched import shares, whirl_deflections
from rsc.analysis.paper.whirls import normal_force, side_conditions, whirl_roots
from rsc.system.system import together

# causes of ends and events; those of ends also come from `rsc.analysis.lines.rootlines`
FORCE = "normal force positive"
AMPLITUDE = "|r_R| above the gap"
SLIDING = "sliding forward (12)"
TOUCHES = "within the clearances"
CREEPING = "stable (creeping)"
OSCILLATORY = "stable (oscillatory)"
CAUSES = (FOLD, RANGE_END, UNBOUNDED, UNRESOLVED, FORCE, AMPLITUDE, SLIDING, TOUCHES, CREEPING, OSCILLATORY)
_CONDITIONS = (FORCE, AMPLITUDE, SLIDING, TOUCHES, OSCILLATORY)
_CLOSE = 1e-3  # a point is put this share of a step beside an end where the force is unbounded
_LOCATED = 1e-12  # relative accuracy asked of the located values


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


@dataclass(frozen=True, eq=False)
class Piece:
    """A root line where F_N > 0: points (n,), margins {cause: (n,)} and its ends as Join."""

    values: np.ndarray
    roots: np.ndarray
    slopes: np.ndarray
    margins: dict
    begin: Join
    end: Join


class Growths:
    """`whirl_growths`, each computed once: margins and whirls ask for the same, and without gyroscopics so do all speeds."""

    def __init__(self):
        self._known = {}  # the System beside its growth, so that its id stays its own

    def __call__(self, systems, Psi, F_N, Omega):
        keys = [
            (id(system), speed if system.turns else 0.0, psi)
            for system, speed, psi in zip(systems, Omega.tolist(), Psi.tolist(), strict=True)
        ]
        new = list({key: i for i, key in enumerate(keys) if key not in self._known}.values())
        if new:
            of_new = [systems[i] for i in new]
            growths = whirl_growths(together(of_new), Psi[new], F_N[new], Omega[new])
            self._known |= {keys[i]: pair for i, *pair in zip(new, of_new, growths, strict=True)}
        return [self._known[key][1] for key in keys]


def node_margins(nodes, growths):
    """value -> the margins at the roots of each of some nodes, as `_margins`."""
    margins = {}
    for block in blocks(nodes[0].system, nodes):
        Psi, numbers = np.concatenate([node.roots for node in block]), [len(node.roots) for node in block]
        each = [node for node, n in zip(block, numbers, strict=True) for _ in range(n)]
        flat = _margins([node.system for node in each], np.array([node.Omega for node in each]), Psi, growths)
        for node, end, n in zip(block, np.cumsum(numbers), numbers, strict=True):
            margins[node.value] = {cause: margin[end - n : end] for cause, margin in flat.items()}
    return margins


def _margins_at(system, Omega, Psi):
    """As `_margins`, at one root of one system."""
    return _margins([system], np.array([Omega]), np.array([Psi]), Growths())


def _margins(systems, Omega, Psi, growths):
    """Margins of the conditions at roots: {cause: (n,)}, positive where it holds, NaN where F_N <= 0.

    systems : list of n System; Omega, Psi : (n,) rad/s; growths : Growths
    """
    if not len(Psi):
        return {cause: np.zeros(0) for cause in _CONDITIONS}
    system = together(systems)
    real = contact_receptance(system, Omega, Psi)[0].real
    force = law_of(system).held(real)
    margins = {FORCE: force}
    margins.update({cause: np.full(len(Psi), np.nan) for cause in _CONDITIONS[1:]})
    pressed = np.flatnonzero(np.isfinite(force) & (force > 0.0))
    if len(pressed):
        system, Omega, Psi = system.at(pressed), Omega[pressed], Psi[pressed]
        F_N = normal_force(system, Psi, Omega)
        conditions = side_conditions(system, Psi, F_N, Omega, np.ones(len(F_N)))
        margins[AMPLITUDE][pressed] = conditions["rotor_amplitude_exceeds_gap"].margin
        margins[SLIDING][pressed] = conditions["sliding"].margin
        if system.clearances:
            deflected = whirl_deflections(system, Psi, F_N, Omega, synchronous_lines(system, Psi, F_N, Omega)[:2])
            margins[TOUCHES][pressed] = 1.0 - shares(system, deflected).max(axis=-1)
        margins[OSCILLATORY][pressed] = [-g.rate for g in growths([systems[i] for i in pressed], Psi, F_N, Omega)]
    return margins


def pieces_of(family, line, nodes, margins):
    """The parts of a root line with positive normal force, cut where the force passes through infinity."""
    by_value = {node.value: node for node in nodes}
    places = [int(np.argmin(np.abs(by_value[v].roots - psi))) for v, psi in zip(line.values, line.roots, strict=True)]
    line_margins = {c: np.array([margins[v][c][i] for v, i in zip(line.values, places, strict=True)]) for c in _CONDITIONS}
    pressed = line_margins[FORCE] > 0.0
    edges = np.flatnonzero(np.diff(pressed.astype(int))) + 1
    pieces = []
    for part in np.split(np.arange(len(pressed)), edges):
        if not pressed[part[0]]:
            continue
        part_margins = {cause: margin[part] for cause, margin in line_margins.items()}
        piece = Piece(line.values[part], line.roots[part], line.slopes[part], part_margins, line.begin, line.end)
        if part[0] > 0:
            piece = _cut(family, line, piece, part[0] - 1, "begin")
        if part[-1] < len(pressed) - 1:
            piece = _cut(family, line, piece, part[-1], "end")
        pieces.append(piece)
    return pieces


def _cut(family, line, piece, k, end):
    """A piece that ends between the points k and k + 1 of its line, with a point put next to that end."""
    value, root = _located(family, line, k, lambda *at: _margins_at(*at)[FORCE])
    inner = piece.values[0 if end == "begin" else -1]
    piece = replace(piece, **{end: Join(value, root, FORCE)})
    close = value + _CLOSE * (inner - value)
    if close in (value, inner):
        return piece
    return _with_points(family, line, piece, [(close, k)])


def _with_points(family, line, piece, extra):
    """A piece with points added at values that lie between the points k and k + 1 of a line: extra = [(value, k)]."""
    columns = [np.vstack([piece.values, piece.roots, piece.slopes, *(piece.margins[c] for c in _CONDITIONS)])]
    for value, k in extra:
        system, Omega, root = _root_at(family, line, k, value)
        margins = _margins_at(system, Omega, root)
        slope = np.interp(value, line.values, line.slopes)
        columns.append(np.array([[value], [root], [slope], *(margins[c] for c in _CONDITIONS)]))
    table = np.concatenate(columns, axis=1)
    table = table[:, np.argsort(table[0])]
    margins = dict(zip(_CONDITIONS, table[3:], strict=True))
    return replace(piece, values=table[0], roots=table[1], slopes=table[2], margins=margins)


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
        return float(margin(system, Omega, root)[0])

    low, high = line.values[k : k + 2]
    value = scipy.optimize.brentq(at, low, high, xtol=_LOCATED * max(abs(low), abs(high)), rtol=_LOCATED)
    return float(value), float(_root_at(family, line, k, value)[2])


def events_of(family, piece):
    """Events of a piece, by rising value."""
    events = []
    for cause in _CONDITIONS[1:]:
        if not np.isfinite(piece.margins[cause]).all():  # nothing that could slip or touch
            continue

        def margin(system, Omega, Psi, cause=cause):
            return _margins_at(system, Omega, Psi)[cause]

        denser = _with_dips(family, piece, cause, margin)
        values = denser.margins[cause]
        for k in np.flatnonzero(values[:-1] * values[1:] < 0.0):
            value, root = _located(family, denser, k, margin)
            name = _kind_of_loss(family, value, root) if cause == OSCILLATORY else cause
            events.append(Event(name, value, root / TWO_PI, "above" if values[k + 1] > 0.0 else "below"))
    return tuple(sorted(events, key=lambda event: event.value))


def _with_dips(family, piece, cause, margin):
    """A piece with points added where a margin dips through zero between points of one sign."""
    v, values = piece.values, piece.margins[cause]
    extra = []
    for k in range(1, len(v) - 1):
        left, mid, right = values[k - 1 : k + 2] * np.sign(values[k])
        reach = max(left - mid, right - mid)
        if not (min(left, right) >= mid >= 0.0 and reach > mid):  # too far from zero, or no dip
            continue

        def size(value, k=k):
            system, Omega, root = _root_at(family, piece, k - 1 if value < v[k] else k, value)
            return float(margin(system, Omega, root)[0] * np.sign(values[k]))

        best = scipy.optimize.minimize_scalar(size, bounds=(v[k - 1], v[k + 1]), method="bounded")
        if best.fun < 0.0:
            extra.append((best.x, k - 1 if best.x < v[k] else k))
    return _with_points(family, piece, piece, extra)


def _kind_of_loss(family, value, root):
    """Whether the eigenvalue that crosses zero is real or one of a pair."""
    system, Omega = family.at(value)
    F_N = normal_force(system, np.array([root]), Omega)
    growth = whirl_growths(system, np.array([root]), F_N, Omega)[0]
    return OSCILLATORY if growth.frequency > 1e-9 * abs(root) else CREEPING


def at_grid(piece, grid):
    """Values (n,) and roots (n,) of a piece at the values of the grid, or at its middle if it meets none."""
    inside = np.flatnonzero(np.isin(piece.values, grid))
    inside = inside if len(inside) else [len(piece.values) // 2]
    return piece.values[inside], piece.roots[inside]
