"""Whirl branches: backward whirls over the rotor speed or over any quantity of a scene, with their ends and events.

The roots come from `rsc.analysis.rootlines`; what happens along them (force, amplitude, sliding, stability) is located here.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from rsc.analysis.one_line import whirl_line
from rsc.analysis.predict import Whirl, whirls_of
from rsc.analysis.rootlines import (
    FOLD,
    RANGE_END,
    UNBOUNDED,
    UNRESOLVED,
    Family,
    Join,
    Node,
    blocks,
    contact_receptance,
    phase_slopes,
    root_lines,
)
from rsc.analysis.stability import whirl_growths
from rsc.analysis.whirls import normal_force, receptance, receptance_rotor, side_conditions, whirl_roots
from rsc.system.assemble import SceneLike, assemble
from rsc.system.blas import one_thread
from rsc.system.system import System, together

TWO_PI = 2.0 * np.pi

# causes of ends and events; those of ends also come from `rsc.analysis.rootlines`
FORCE = "normal force positive"
AMPLITUDE = "|r_R| above the gap"
SLIDING = "sliding forward (12)"
CREEPING = "stable (creeping)"
OSCILLATORY = "stable (oscillatory)"
NO_LEAST = "any friction"  # of `mu_min`: there is no fold, the least friction is 0
CAUSES = (FOLD, RANGE_END, UNBOUNDED, UNRESOLVED, FORCE, AMPLITUDE, SLIDING, CREEPING, OSCILLATORY)
_CONDITIONS = (FORCE, AMPLITUDE, SLIDING, OSCILLATORY)
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


def branches(system: System, speeds: ArrayLike) -> list[Branch]:
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


def continuation(scene: Any, key: str, values: ArrayLike, speed: float | None = None) -> list[Branch]:
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


@one_thread
def _branches(at, values):
    """Branches of the family value -> (System, speed in Hz) over monotonic values."""
    way = np.asarray(values, dtype=float)
    rising = np.sort(way)

    def family_at(value):
        system, speed = at(value)
        return system, TWO_PI * speed

    family = Family(family_at, rising[0], rising[-1])
    nodes, lines = root_lines(family, rising)
    growths = _Growths()
    margins = _node_margins(nodes, growths)
    unlabelled = []
    for line in lines:
        for piece in _pieces(family, line, nodes, margins):
            piece_values, roots = _at_grid(piece, rising)
            whirls = _whirls(at, piece_values, roots, growths)
            unlabelled.append(_branch(piece, piece_values, whirls, _events(family, piece), way))
    return _labelled(unlabelled)


@one_thread
def follow(system: System, near: float, speeds: ArrayLike) -> Branch:
    """Follow the backward whirl next to a frequency over the rotor speed, and no other.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    near : float, Hz
        The whirl at the first speed that is next to it is followed (rsc.analysis.one_line).
    speeds : (n,) Hz, monotonic
        The way, as for `branches`.

    Returns
    -------
    Branch
        That of `branches` on which the whirl lies, from the first speed on; its label is "".

    Raises
    ------
    SceneError
        No whirl at the first speed, or speeds or a frequency that cannot be.
    SolverError
        The whirl cannot be followed.
    """
    family, way, line = whirl_line(system, near, speeds)
    Omega = TWO_PI * line.values
    points = zip(line.values, Omega, line.roots[:, None], line.slopes[:, None], strict=True)
    nodes = [Node(value, system, own, root, slope) for value, own, root, slope in points]
    all_margins = _margins([system] * len(Omega), Omega, line.roots, _Growths())
    margins = {value: {c: m[i : i + 1] for c, m in all_margins.items()} for i, value in enumerate(line.values)}
    (piece,) = _pieces(family, line, nodes, margins)  # a line ends with its force
    piece_values, roots = _at_grid(piece, way)
    F_N = normal_force(system, roots, TWO_PI * piece_values)
    return _branch(piece, piece_values, tuple(whirls_of(system, roots, F_N, piece_values)), _events(family, piece), way)


def _branch(piece, values, whirls, events, way):
    """The Branch, without a label, of a piece with its whirls at values, and its events."""
    holds = "below" if way[-1] >= way[0] else "above"
    lost = tuple(e.value for e in events if e.cause in (CREEPING, OSCILLATORY) and e.holds == holds)
    begin, end = (Event(join.cause, join.value, join.root / TWO_PI) for join in (piece.begin, piece.end))
    return Branch("", whirls, lost, values, begin, end, events)


def _labelled(unlabelled):
    """Branches in the order of their labels: those that are stable somewhere first, then by the value and by the |frequency|
    where they begin."""

    def place(branch):
        # where the range begins its value may differ by rounding from branch to branch
        begin = -np.inf if branch.begin.cause == RANGE_END else branch.begin.value
        return not branch.stable.any(), begin, abs(branch.begin.frequency), abs(branch.end.frequency)

    return [replace(branch, label=_name(i)) for i, branch in enumerate(sorted(unlabelled, key=place))]


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


class _Growths:
    """`whirl_growths`, each computed once: margins and whirls ask for the same, and without gyroscopics so do all speeds."""

    def __init__(self):
        self._known = {}  # the System beside its growth, so that its id stays its own

    def __call__(self, systems, Psi, F_N, Omega):
        keys = [
            (id(system), speed if system.gyroscopic else 0.0, psi)
            for system, speed, psi in zip(systems, Omega.tolist(), Psi.tolist(), strict=True)
        ]
        new = list({key: i for i, key in enumerate(keys) if key not in self._known}.values())
        if new:
            of_new = [systems[i] for i in new]
            growths = whirl_growths(together(of_new), Psi[new], F_N[new], Omega[new])
            self._known |= {keys[i]: pair for i, *pair in zip(new, of_new, growths, strict=True)}
        return [self._known[key][1] for key in keys]


def _node_margins(nodes, growths):
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
    return _margins([system], np.array([Omega]), np.array([Psi]), _Growths())


def _margins(systems, Omega, Psi, growths):
    """Margins of the conditions at roots: {cause: (n,)}, positive where it holds, NaN where F_N <= 0.

    systems : list of n System; Omega, Psi : (n,) rad/s; growths : _Growths
    """
    if not len(Psi):
        return {cause: np.zeros(0) for cause in _CONDITIONS}
    system = together(systems)
    real = contact_receptance(system, Omega, Psi)[0].real
    force = -system.contact_stiffness * real - 1.0  # the inverse of F_N: it passes zero where F_N is unbounded
    margins = {FORCE: force}
    margins.update({cause: np.full(len(Psi), np.nan) for cause in _CONDITIONS[1:]})
    pressed = np.flatnonzero(np.isfinite(force) & (force > 0.0))
    if len(pressed):
        system, Omega, Psi = system.at(pressed), Omega[pressed], Psi[pressed]
        F_N = normal_force(system, Psi, Omega)
        conditions = side_conditions(system, Psi, F_N, Omega, np.ones(len(F_N)))
        margins[AMPLITUDE][pressed] = conditions["rotor_amplitude_exceeds_gap"].margin
        margins[SLIDING][pressed] = conditions["sliding"].margin
        margins[OSCILLATORY][pressed] = [-g.rate for g in growths([systems[i] for i in pressed], Psi, F_N, Omega)]
    return margins


def _pieces(family, line, nodes, margins):
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
        piece = _Piece(line.values[part], line.roots[part], line.slopes[part], part_margins, line.begin, line.end)
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


def _events(family, piece):
    """Events of a piece, by rising value."""
    events = []
    for cause in _CONDITIONS[1:]:
        if not np.isfinite(piece.margins[cause]).all():  # nothing that could slip
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


def _at_grid(piece, grid):
    """Values (n,) and roots (n,) of a piece at the values of the grid, or at its middle if it meets none."""
    inside = np.flatnonzero(np.isin(piece.values, grid))
    inside = inside if len(inside) else [len(piece.values) // 2]
    return piece.values[inside], piece.roots[inside]


def _whirls(at, values, roots, growths):
    """The whirl at each of some values with its root, as a tuple."""
    whirls = []
    points = list(zip(values.tolist(), roots.tolist(), strict=True))
    for block in blocks(at(values[0])[0], points):
        systems, speeds = zip(*(at(value) for value, _ in block), strict=True)
        system, speed, Psi = together(systems), np.array(speeds), np.array([root for _, root in block])
        F_N = normal_force(system, Psi, TWO_PI * speed)
        whirls += whirls_of(system, Psi, F_N, speed, growths(systems, Psi, F_N, TWO_PI * speed))
    return tuple(whirls)


# ---------------------------------------------------------------- least friction

_FRICTIONS = np.logspace(-6.0, 3.0, 46)
_ROUNDING = 1e-12  # |r_R| = s exactly for a rigid stator
_ROLLS = 1e-6  # of its frequency: slip of a whirl that is located at the end of sliding


def mu_min(scene: SceneLike, speed: float | None = None) -> Event | None:
    """Find the smallest friction with which a backward whirl with |r_R| >= s exists, sliding or rolling, for rigid contact.

    The frequency of a whirl passes every mu = -Im H / Re H between two zeros of Re H; the least of them is a fold of
    two roots, Im(H'/H) = 0. (An elastic contact adds whirls near its own resonance, at once beyond all bounds and then
    smaller than the gap; `continuation` over the friction shows them.) With a contact diameter no whirl turns faster than
    rolling, -Omega d_R/(2 s) (13), which needs the friction -Im H / Re H there.

    A rotor in a rigid wall has no fold. The frequency at which a given friction holds a steady whirl runs to minus infinity as
    the friction goes to 0, as -b/(mu m) does for a Laval rotor: only rolling bounds it.

    Parameters
    ----------
    scene : Scene
        Its own friction and contact stiffness do not matter.
    speed : float, optional, Hz
        Default: the first speed of the scene's drive.

    Returns
    -------
    Event or None
        `value` is the friction, `cause` `FOLD`, or what comes first: `AMPLITUDE` where |r_R| = s, `SLIDING` where it rolls.
        Values below 1e-6 are given as 0 with the cause `NO_LEAST` and the frequency at 1e-6 (no damping, a free motion of the
        rotor), or minus infinity (a rigid wall, no contact diameter); None if no friction up to 1000 gives a whirl.
    """
    system = assemble(scene)
    Omega = TWO_PI * (scene.drive.speed[0] if speed is None else float(speed))
    first = next((i for i, mu in enumerate(_FRICTIONS) if len(_backward(system, mu, Omega))), None)
    if first is None:
        return None
    high = float(_FRICTIONS[first])
    if first == 0:
        losses = system.damping_r.any() or system.skew_stiffness_r is not None
        endless = system.n_stator == 0 and system.diameter is None and losses
        return Event(NO_LEAST, 0.0, -np.inf if endless else float(_backward(system, high, Omega)[-1]) / TWO_PI)
    low = float(_FRICTIONS[first - 1])
    for relative in (1e-3, 1e-12):
        while high - low > relative * high:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if len(_backward(system, middle, Omega)) else (middle, high)
        fold = _least_friction(system, Omega, _backward(system, high, Omega).mean())
        if fold is not None and abs(fold.value - high) <= 2.0 * relative * high:
            return fold
    Psi = float(_backward(system, high, Omega)[0])
    return Event(SLIDING if _slip(system, Psi, Omega) < _ROLLS * abs(Psi) else AMPLITUDE, high, Psi / TWO_PI, "above")


def _backward(system, friction, Omega):
    """Roots of the backward whirls with F_N > 0 and |r_R| >= s, no faster than rolling, at another friction and rigid contact."""
    system = replace(system, friction=float(friction))
    Psi = whirl_roots(system, Omega)
    Psi = Psi[(Psi < 0.0) & (normal_force(system, Psi, Omega, rigid=True) > 0.0) & (_slip(system, Psi, Omega) >= 0.0)]
    ratio = np.abs(receptance_rotor(system, Psi, Omega)) / np.abs(receptance(system, Psi, Omega))
    return Psi[ratio >= 1.0 - _ROUNDING]


def _slip(system, Psi, Omega):
    """By how much a whirl in rigid contact turns slower than it would roll (13), in rad/s; infinite without a diameter."""
    return np.inf if system.diameter is None else Psi + 0.5 * Omega * system.diameter / system.gap


def _least_friction(system, Omega, Psi):
    """The fold next to a frequency: the minimum of mu = -Im H / Re H; None if there is none with F_N > 0."""
    system = replace(system, friction=0.0)
    for _ in range(60):
        slope, bend = (float(part[0]) for part in phase_slopes(system, Omega, np.array([Psi])))
        step = slope / bend
        Psi -= np.clip(step, -0.02 * abs(Psi), 0.02 * abs(Psi))
        if abs(step) <= 1e-13 * abs(Psi):
            H = contact_receptance(system, Omega, np.array([Psi]))[0][0]
            return Event(FOLD, float(-H.imag / H.real), float(Psi) / TWO_PI)
    return None
