"""Whirl branches: backward whirls over the rotor speed or over any quantity of a scene, with their ends and events.

The roots come from `rsc.analysis.lines.rootlines`; what happens along them (force, amplitude, sliding, stability) is located in
`rsc.analysis.lines.events`.
"""

from dataclasses import dataclass, replace
from math import tau as TWO_PI
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rsc.analysis.lines.events import CREEPING, OSCILLATORY, Event, Growths, at_grid, events_of, node_margins, pieces_of
from rsc.analysis.lines.one_line import whirl_line
from rsc.analysis.lines.patience import Note, Patience, silent
from rsc.analysis.lines.rootlines import RANGE_END, Family, Node, blocks, root_lines
from rsc.analysis.paper.predict import Whirl, whirls_of
from rsc.analysis.paper.whirls import normal_force
from rsc.system.assemble import assemble
from rsc.system.blas import one_thread
from rsc.system.system import System, together

SPEEDS = 201  # points on the way of a run


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


def branches(system: System, speeds: ArrayLike, note: Note = silent) -> list[Branch]:
    """Follow the backward whirls over the rotor speed.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    speeds : (n,) Hz, monotonic
        The way of the run: falling speeds only change what `Branch.lost` means.
    note : callable, called every two seconds of a long search with a line of text

    Returns
    -------
    list of Branch, by label
        Every piece of every root line with F_N > 0; empty without friction.
    """
    return _branches(lambda value: (system, float(value)), speeds, note, system.knot_speed / TWO_PI)


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
def _branches(at, values, note=silent, knots=()):
    """Branches of the family value -> (System, speed in Hz) over monotonic values; knots: values where it has kinks."""
    way = np.asarray(values, dtype=float)
    rising = np.sort(way)

    def family_at(value):
        system, speed = at(value)
        return system, TWO_PI * speed

    family = Family(family_at, rising[0], rising[-1])
    patience = Patience(note)
    kinks = [knot for knot in knots if rising[0] < knot < rising[-1]]
    nodes, lines = root_lines(family, np.union1d(rising, kinks) if kinks else rising, patience)
    growths = Growths()
    margins = node_margins(nodes, growths)
    unlabelled = []
    for i, line in enumerate(lines):
        patience.say(f"whirls and their events are computed along the lines of roots, {i} of {len(lines)} done")
        for piece in pieces_of(family, line, nodes, margins):
            piece_values, roots = at_grid(piece, rising)
            whirls = _whirls(at, piece_values, roots, growths)
            unlabelled.append(_branch(piece, piece_values, whirls, events_of(family, piece), way))
    return labelled(unlabelled)


@one_thread
def follow(system: System, near: float, speeds: ArrayLike) -> Branch:
    """Follow the backward whirl next to a frequency over the rotor speed, and no other.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    near : float, Hz
        The whirl at the first speed that is next to it is followed (rsc.analysis.lines.one_line).
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
    (piece,) = pieces_of(family, line, nodes, node_margins(nodes, Growths()))  # a line ends with its force
    piece_values, roots = at_grid(piece, way)
    F_N = normal_force(system, roots, TWO_PI * piece_values)
    return _branch(piece, piece_values, tuple(whirls_of(system, roots, F_N, piece_values)), events_of(family, piece), way)


def _branch(piece, values, whirls, events, way):
    """The Branch, without a label, of a piece with its whirls at values, and its events."""
    holds = "below" if way[-1] >= way[0] else "above"
    lost = tuple(e.value for e in events if e.cause in (CREEPING, OSCILLATORY) and e.holds == holds)
    begin, end = (Event(join.cause, join.value, join.root / TWO_PI) for join in (piece.begin, piece.end))
    return Branch("", whirls, lost, values, begin, end, events)


def labelled(unlabelled):
    """Branches in the order of their labels: those that are stable somewhere first, then by the value and by the |frequency|
    where they begin."""

    def place(branch):
        # where the range begins its value may differ by rounding from branch to branch
        begin = -np.inf if branch.begin.cause == RANGE_END else branch.begin.value
        return not branch.decays.any(), begin, abs(branch.begin.frequency), abs(branch.end.frequency)

    return [replace(branch, label=_name(i)) for i, branch in enumerate(sorted(unlabelled, key=place))]


def _name(i):
    return chr(ord("A") + i) if i < 26 else f"Z{i - 25}"


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
