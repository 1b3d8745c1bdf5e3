"""Whirl roots followed over one parameter: lines of roots, and the folds where two of them meet (docs/maintainers/analysis.md).

At a root the phase f(Psi, p) of cH = (1 + i mu) H is a multiple of pi. A line moves with dPsi/dp = -f_p / f_Psi; it
ends where f_Psi = 0. All roots are known at every parameter, so that no line can appear unseen.
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy

from rsc.analysis.lines.patience import Patience, silent
from rsc.analysis.paper.receptance import contact_receptance, phase_slopes, slopes_of_phase
from rsc.analysis.paper.whirls import roots_by_place
from rsc.system.system import stacked, together

FOLD, RANGE_END = "fold of two roots", "end of the range"
UNBOUNDED, UNRESOLVED = "frequency beyond all bounds", "not resolved"
# roots above this multiple of the highest natural frequency are not followed (without friction they go to infinity)
BEYOND = 1e3
# a root is followed when the tangents of both ends meet it this much closer than any other root
CLEAR = 0.3
# and when they miss it by less than this share of its frequency
NEAR = 0.02
# halvings of a step of the grid before roots are matched as well as possible
HALVINGS = 30
# values that are added to the grid of all lines together before roots are matched so everywhere: a search has an end
MOST_ADDED = 2000
# entries of a matrix of the systems that are solved together, so that all stay in the cache of the processor
_TOGETHER = 8192
# a line is followed to a fold up to this share of a step of the grid
FOLD_APPROACH = 1e-3


@dataclass(frozen=True)
class Join:
    """Where a line begins or ends: value of the parameter, root (rad/s) there, and cause."""

    value: float
    root: float
    cause: str


@dataclass(frozen=True, eq=False)
class RootLine:
    """One root over the parameter.

    values, roots, slopes : (n,) parameter (rising), Psi in rad/s, dPsi/dp
    begin, end : Join
    """

    values: np.ndarray
    roots: np.ndarray
    slopes: np.ndarray
    begin: Join
    end: Join


@dataclass(frozen=True, eq=False)
class Node:
    """All backward roots at one value of the parameter: roots and slopes (n,), roots rising."""

    value: float
    system: object
    Omega: float
    roots: np.ndarray
    slopes: np.ndarray


class Family:
    """A System and a rotor speed that depend on one parameter.

    Parameters
    ----------
    at : function, value of the parameter -> (System, Omega in rad/s)
    low, high : float, range of the parameter
    """

    def __init__(self, at, low, high):
        self.at = at
        self.low, self.high = low, high
        self._step = 1e-7 * max(high - low, abs(high), abs(low))

    def nodes(self, values):
        """The `Node` at each of several values of the parameter, a list."""
        # the difference looks into the range: beyond it there may be no scene
        steps = [self._step if value <= 0.5 * (self.low + self.high) else -self._step for value in values]
        systems, Omega = self._pairs(values)
        place, roots = _bounded_roots(stacked(systems), Omega)
        value = contact_receptance(together(systems).at(place), Omega[place], roots)
        systems_beyond, beyond = self._pairs([value + step for value, step in zip(values, steps, strict=True)])
        turned = value[0].conj() * contact_receptance(together(systems_beyond).at(place), beyond[place], roots)[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            slopes = -np.angle(turned) / np.array(steps)[place] / slopes_of_phase(*value)[0]
        # where there is no phase, at a root that is a pole but for rounding, it is followed by position
        slopes = np.where(np.isfinite(slopes), slopes, 0.0)
        own = [np.flatnonzero(place == i) for i in range(len(values))]
        return [Node(*at, roots[i], slopes[i]) for *at, i in zip(values, systems, Omega.tolist(), own, strict=True)]

    def _pairs(self, values):
        systems, Omega = zip(*map(self.at, values), strict=True)
        return systems, np.array(Omega)

    def extremum(self, value, Psi):
        """Phase of cH (modulo pi, rad) at its extremum over Psi next to a start, and that Psi; NaN if there is none."""
        system, Omega = self.at(value)
        for _ in range(50):
            slope, bend = (float(part[0]) for part in phase_slopes(system, Omega, np.array([Psi])))
            step = slope / bend
            Psi -= math.copysign(min(abs(step), 0.02 * abs(Psi)), step)
            if abs(step) <= 1e-12 * abs(Psi):
                square = contact_receptance(system, Omega, np.array([Psi]))[0][0] ** 2
                return 0.5 * float(np.angle(square)), Psi
        return math.nan, math.nan


def _bounded_roots(stack, Omega):
    """(places, roots) of the backward whirls of a stack of systems that are not beyond all bounds, by place and rising."""
    place, roots = roots_by_place(stack, Omega, only_met=True)
    followed = (roots < 0.0) & (roots > -np.broadcast_to(_bound(stack, Omega), Omega.shape)[place])
    return place[followed], roots[followed]


def _bound(system, Omega):
    bodies = system.at_speed(Omega).joined()
    square = np.abs(np.linalg.eigvals(np.linalg.solve(bodies.mass, bodies.static))).max(axis=-1)
    turning, mass = (np.diagonal(matrix, axis1=-2, axis2=-1) for matrix in (bodies.turning(Omega), bodies.mass))
    return BEYOND * (np.sqrt(square) + np.abs(turning / mass).max(axis=-1))


def root_lines(family, values, patience=None):
    """Follow every backward root over a grid of the parameter.

    Parameters
    ----------
    family : Family
    values : sequence of float, rising
    patience : rsc.analysis.lines.patience.Patience, optional
        Is told how far the search is.

    Returns
    -------
    nodes : list of Node, those of the grid and those added where roots move fast
    lines : list of RootLine, through the nodes; ends at folds are located to rounding
    """
    patience, todo = patience or Patience(silent), []
    for block in blocks(family.at(values[0])[0], values[::-1]):
        patience.say(f"roots of the whirl condition are looked for, {len(todo)} of {len(values)} values done")
        todo += family.nodes(block)
    nodes, lines, running = [todo.pop()], [], []
    finest, added = min(np.diff(values), default=0.0), 0
    running = [_Open(nodes[0], i, Join(nodes[0].value, psi, RANGE_END)) for i, psi in enumerate(nodes[0].roots)]
    while todo:
        before, after = nodes[-1], todo[-1]
        width = after.value - before.value
        patience.say(f"whirls are followed from value to value, {len(nodes)} of {len(nodes) + len(todo)} done")
        given_up = added >= MOST_ADDED
        links, missing = _links(before, after, last=given_up or width <= finest * 0.5**HALVINGS)
        folds = _folds(family, before, after, missing) if links is not None else None
        cut = None if given_up else _refinement(before, after, folds, finest)
        if cut is not None:
            todo += family.nodes([cut])
            added += 1
            continue
        running, closed = _advance(running, before, after, links, folds)
        lines += closed
        nodes.append(todo.pop())
    last = nodes[-1]
    lines += [line.closed(Join(last.value, last.roots[line.index], RANGE_END)) for line in running]
    return nodes, lines


def blocks(system, items):
    """A list in parts that are solved together: many items while the matrices of their systems, all of one size, are small."""
    many = max(1, _TOGETHER // (system.n_rotor + system.n_stator) ** 2)
    return [items[i : i + many] for i in range(0, len(items), many)]


class _Open:
    """A line that has not ended: `index` is its root in the newest node."""

    def __init__(self, node, index, begin):
        self.begin, self.points = begin, []
        self.add(node, index)

    def add(self, node, index):
        self.index = index
        self.points.append((node.value, node.roots[index], node.slopes[index]))

    def closed(self, end):
        return RootLine(*np.array(self.points).T, self.begin, end)


def _links(before, after, last):
    """Pairs (i, j) of the roots of two nodes, and the unpaired ones ([i], [j]); (None, None): a finer step is needed."""
    n, m = len(before.roots), len(after.roots)
    width = after.value - before.value
    ahead, back = before.roots + width * before.slopes, after.roots - width * after.slopes
    miss = np.abs(ahead[:, None] - after.roots) + np.abs(back - before.roots[:, None])
    if last:
        rows, columns = scipy.optimize.linear_sum_assignment(miss)
        pairs = list(zip(rows.tolist(), columns.tolist(), strict=True))
    else:
        pairs = [pair for pair in zip(range(n), miss.argmin(axis=1).tolist(), strict=True) if m] if n and m else []
        pairs = [(i, j) for i, j in pairs if _is_clear(miss, i, j, abs(after.roots[j]))]
    missing = [i for i in range(n) if i not in {p[0] for p in pairs}], [j for j in range(m) if j not in {p[1] for p in pairs}]
    # roots come and go in pairs only
    if not last and (any(len(group) % 2 for group in missing) or (missing[0] and missing[1])):
        return None, None
    return pairs, missing


def _is_clear(miss, i, j, size):
    distance = miss[i, j]
    next_distance = min(np.delete(miss[i], j).min(initial=np.inf), np.delete(miss[:, j], i).min(initial=np.inf))
    return distance <= CLEAR * next_distance and distance <= NEAR * size


def _folds(family, before, after, missing):
    """Folds of the unpaired roots between two nodes: list of (side, (i, i + 1), Join); None if one is not found."""
    folds = []
    for side, (node, indices) in enumerate(zip((before, after), missing, strict=True)):
        for i, j in zip(indices[::2], indices[1::2], strict=False):
            start = 0.5 * (node.roots[i] + node.roots[j])
            join = fold_between(family, before.value, after.value, start) if j == i + 1 else None
            if join is None:
                return None
            folds.append((side, (i, j), join))
    return folds


def fold_between(family, low, high, start):
    """The Join where two roots next to a frequency (rad/s) merge between two values; None if none is found."""
    ends = [family.extremum(value, start) for value in (low, high)]
    same = abs(ends[0][1] - ends[1][1]) <= 0.1 * abs(start)
    if not same or not ends[0][0] * ends[1][0] < 0.0:
        return None
    try:
        accuracy = 1e-14 * max(abs(low), abs(high))
        value = scipy.optimize.brentq(lambda v: family.extremum(v, start)[0], low, high, xtol=accuracy, rtol=1e-14)
    except ValueError:  # the extremum is lost on the way: the nodes are too far apart
        return None
    return Join(float(value), family.extremum(value, start)[1], FOLD)


def _refinement(before, after, folds, finest):
    """The value at which another node is needed between two, or None."""
    width = after.value - before.value
    if width <= finest * 0.5**HALVINGS:
        return None
    if folds is None:
        return 0.5 * (before.value + after.value)
    near = FOLD_APPROACH * finest
    for side, _, join in folds:
        gap = join.value - before.value if side == 0 else after.value - join.value
        if gap > 2.0 * near:
            return join.value - near if side == 0 else join.value + near
    return None


def _advance(running, before, after, links, folds):
    """Carry the open lines over to the next node; returns (open lines, closed lines)."""
    folds = folds if folds is not None else []
    ended = {i: join for side, pair, join in folds if side == 0 for i in pair}
    begun = {j: join for side, pair, join in folds if side == 1 for j in pair}
    successor = dict(links)
    open_lines, closed = [], []
    for line in running:
        if line.index in successor:
            line.add(after, successor[line.index])
            open_lines.append(line)
        else:
            closed.append(line.closed(ended.get(line.index) or _loose_end(before, line.index)))
    continued = set(successor.values())
    for j in range(len(after.roots)):
        if j not in continued:
            open_lines.append(_Open(after, j, begun.get(j) or _loose_end(after, j)))
    return open_lines, closed


def _loose_end(node, i):
    """End of a line for which no partner was found."""
    unbounded = abs(node.roots[i]) > 0.9 * _bound(node.system, node.Omega)
    return Join(node.value, node.roots[i], UNBOUNDED if unbounded else UNRESOLVED)
