"""Modes of a machine at a rotor speed: damped vibrations of the free rotor, of the stator, and of both joined at the contact.

Each is a motion r = shape e^{lambda t}, or an ellipse where directions differ, with lambda = growth_rate + 2 pi i frequency from
the equation of motion of one body (physics.md, section 2). Joined means that both move as one at every contact, l_R r_R = l_S
r_S: what the prediction calls the coupled system, H_R + H_S = 0, where there is one contact.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import copysign, inf, nan
from math import tau as TWO_PI
from typing import Any, overload

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from rsc.analysis.alone.free_vibration import FreeVibration, vibrations_of
from rsc.analysis.alone.mode_lines import Line, followed
from rsc.analysis.alone.mode_shapes import ModeShape, shape_of
from rsc.analysis.paper.predict import refuse_speeds
from rsc.arguments import LINE_OF_SPEEDS, SCENE, optional, takes
from rsc.files.tables import Table
from rsc.presented import Brief, BriefList, drawing
from rsc.system.assemble import SceneLike, assemble
from rsc.system.blas import one_thread
from rsc.system.body import ANISOTROPIC, Body
from rsc.system.system import System

FORWARD, BACKWARD, STRAIGHT, MIXED, NONE = "forward", "backward", "straight", "mixed", "-"
FREE, STILL, UNSTABLE, UNDAMPED = "free: nothing opposes it", "does not oscillate", "unstable", "undamped"
_FREE, _UNDAMPED = 1e-6, 1e-12  # of the fastest motion, in which eigenvalues near 0 and growth rates are rounded
_STRAIGHT = 1e-6  # difference of the two circles of an ellipse over their sum
_PART = 0.01  # of the kinetic energy that must turn the other way for a mode to be mixed
COLUMNS = ("rotor speed in Hz", "of", "frequency in Hz", "undamped frequency in Hz", "growth rate in 1/s",
           "logarithmic decrement", "damping ratio", "sense", "participation of the contact", "remark")  # fmt: skip
_GRID = 101  # speeds between which critical speeds are counted
_HALVINGS = 60


@dataclass(frozen=True)
class Mode:
    """One mode.

    frequency : Hz, damped, negative backward
    undamped : Hz, of the mode without damping whose shape is nearest, NaN where none is and in a closed loop
    growth_rate : 1/s, negative: it dies away
    decrement : logarithmic decrement, -growth_rate/|frequency|, infinite where it does not oscillate
    damping_ratio : -growth_rate/|lambda|
    sense : "forward", "backward", "straight" (an ellipse without width), "mixed" (parts of the machine turn against each other),
        "-" where it does not oscillate
    share : modal participation of the contact: the part that this mode has of the mobility l M^-1 l there; the modes of one sense
        have 1 together, where nothing is gyroscopic or damped; of several contacts the largest
    remark : "", "free: nothing opposes it", "does not oscillate", "unstable", "undamped"
    """

    frequency: float
    undamped: float
    growth_rate: float
    decrement: float
    damping_ratio: float
    sense: str
    share: float
    remark: str


@dataclass(frozen=True, repr=False)
class Modes(Brief):
    """Modes at one rotor speed in Hz, the slowest first, by the size of lambda; those of the stator do not depend on it.

    rotor, stator, coupled : tuples of Mode; coupled: rotor and stator joined at every contact
    shapes : tuple of ModeShape, one for each of `rotor` if the rotor was given by its stations (model "shaft"), else empty
    """

    speed: float
    rotor: tuple[Mode, ...]
    stator: tuple[Mode, ...]
    coupled: tuple[Mode, ...]
    shapes: tuple[ModeShape, ...] = field(default=(), repr=False)

    @property
    def parts(self) -> dict[str, tuple[Mode, ...]]:
        """The modes by what vibrates."""
        return {"rotor": self.rotor, "stator": self.stator, "coupled": self.coupled}

    def plot(self, mode: int = 0, ax: Any = None, **style: Any) -> Any:
        """Draw the shape of one mode of the rotor: the bent shaft, and orbits of its nodes in the colour of their sense of whirl.

        mode : its number in `rotor`; ax : matplotlib axes, by default those of a new figure; style : properties of lines of
            matplotlib

        Returns the axes; SceneError for a mode that has no shape, or a rotor that was not given by its stations.
        """
        return drawing().mode_shape(self, mode, ax, style)

    def table(self) -> Table:
        """A `rsc.files.tables.Table` with a row for each mode, for pandas (`to_dataframe`) and CSV (`to_csv`)."""
        rows = [
            (self.speed, name, m.frequency, m.undamped, m.growth_rate, m.decrement, m.damping_ratio, m.sense, m.share, m.remark)
            for name, modes in self.parts.items() for m in modes
        ]  # fmt: skip
        return Table(COLUMNS, rows)

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


class Campbell(BriefList[Modes]):
    """The Modes at several rotor speeds, a list.

    criticals : tuple of float, critical speeds in Hz between the lowest and the highest of these speeds
    lines : modes of the rotor followed from speed to speed by their shapes; each line is a tuple with the number of its mode in
        `rotor` for every speed, None where it does not oscillate
    """

    def __init__(self, made: Sequence[Modes], criticals: Sequence[float] = (), lines: Sequence[Line] = ()) -> None:
        super().__init__(made)
        self.criticals, self.lines = tuple(criticals), tuple(lines)

    def plot(self, ax: Any = None, **style: Any) -> Any:
        """Draw the Campbell diagram: damped natural frequencies over the rotor speed, with the critical speeds.

        ax : matplotlib axes, by default those of a new figure; style : properties of lines of matplotlib. Returns the axes.
        """
        return drawing().campbell(self, ax, style)

    def table(self) -> Table:
        """The tables of all speeds, one below the other."""
        return Table(COLUMNS, [row for each in self for row in each.table().rows])

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


@overload
def modes(scene: SceneLike, speed: float | str | None = None) -> Modes: ...


@overload
def modes(scene: SceneLike, speed: Sequence[float] | list[str] | tuple[str, ...] | NDArray[np.floating]) -> Campbell: ...


@takes(scene=SCENE, speed=optional(LINE_OF_SPEEDS))
def modes(
    scene: SceneLike, speed: float | str | Sequence[float] | list[str] | tuple[str, ...] | NDArray[np.floating] | None = None
) -> Modes | Campbell:
    """Damped natural frequencies, logarithmic decrements and senses of a machine without contact, and with it closed.

    Parameters
    ----------
    scene : rsc.Scene
        A reduced body counts as it was reduced: its modes are right within the band of its reduction. Bearings that are switched
        off during a run are there.
    speed : None, float or str, or a sequence of them, Hz
        Rotor speed, also with its unit: "3000 rpm"; None takes the highest speed of the scene's drive.

    Returns
    -------
    Modes, or for a sequence of speeds a Campbell, the list of them with the critical speeds

    Raises
    ------
    SceneError
        A speed that is no number or that no drive may have, or for which the rotor was not reduced.

    Examples
    --------
    >>> at_speed = rsc.modes(rsc.load_scene("disk.toml"), "3000 rpm")
    >>> [f"{mode.frequency:.1f} Hz" for mode in at_speed.rotor]
    ['-25.6 Hz', '40.5 Hz', '-45.3 Hz', '110.4 Hz']
    """
    speeds = np.atleast_1d(np.asarray(max(scene.drive.speed, key=abs) if speed is None else speed, dtype=float))
    refuse_speeds("modes", "speed", scene, speeds)
    system = assemble(scene).at_start
    nodes, rows = (np.array(getattr(scene.rotor, name, None) or ()) for name in ("nodes", "node_rows"))
    made = [modes_at(system, value, (nodes, rows) if nodes.size else None) for value in speeds.tolist()]
    if speed is None or np.ndim(speed) == 0:
        return made[0]
    if not speeds.size:
        return Campbell(made)
    criticals = critical_speeds(system, float(speeds.min()), float(speeds.max()))
    return Campbell(made, criticals, mode_lines(system, speeds.tolist()))


@one_thread
def modes_at(system: System, speed: float, nodes: tuple[Any, Any] | None = None) -> Modes:
    """The Modes of a System at a rotor speed in Hz; nodes: their positions in m and their rows (`shape_of`), for shapes."""
    system = system.at_speed(TWO_PI * speed)
    rotor, stator = system.bodies
    if len(system.contacts) > 1:
        rotor = replace(rotor, contact=np.array([contact.rotor for contact in system.contacts]))
        stator = replace(stator, contact=np.array([contact.stator for contact in system.contacts]))
    vibrating = _modes_with_vibrations(rotor, speed, nodes[1] if nodes else None)
    held, coupled = (tuple(modes_of(body, speed)) for body in (stator, joined_at_contacts(system)))
    shapes = tuple(shape_of(vibration, *nodes) for _, vibration in vibrating) if nodes else ()
    return Modes(speed, tuple(mode for mode, _ in vibrating), held, coupled, shapes)


@one_thread
def mode_lines(system: System, speeds: Sequence[float]) -> tuple[Line, ...]:
    """The lines of the rotor's modes over rotor speeds in Hz (`Campbell.lines`)."""

    def at(speed: float) -> list[FreeVibration]:
        body = system.rotor.at_speed(TWO_PI * speed)
        return [vibration for _, vibration in _modes_with_vibrations(body, speed)]

    return followed(speeds, at, system.rotor.mass)


def modes_of(body: Body, speed: float) -> list[Mode]:
    """The modes of one body at a rotor speed in Hz, by the size of lambda."""
    return [mode for mode, _ in _modes_with_vibrations(body, speed)]


def _modes_with_vibrations(body: Body, speed: float, rows: Any = None) -> list[tuple[Mode, FreeVibration]]:
    """The modes of one body with their vibrations, by the size of lambda; rows: of its nodes, where the coordinates are none."""
    if not body.n_coordinates:
        return []
    damped, undamped = vibrations_of(body, speed), vibrations_of(_without_damping(body), speed)
    fastest = max(TWO_PI * abs(each.frequency) + abs(each.growth_rate) for each in damped)
    mobility = [float(row @ np.linalg.solve(body.mass, row)) for row in _rows(body)]
    spin = -1.0 if speed < 0.0 else 1.0
    made = [(_mode(body, each, undamped, (fastest, mobility), _sense(body, each, spin, rows)), each) for each in damped]
    return sorted(made, key=lambda one: _place(one[0]))


def _place(mode: Mode) -> tuple[float, float]:
    """By the size of lambda, of two alike the backward one first."""
    return float(f"{abs(complex(mode.growth_rate, TWO_PI * mode.frequency)):.9g}"), mode.frequency


def _rows(body: Body) -> list[NDArray[np.float64]]:
    """Rows (n,) of the displacements at the contacts of a body."""
    return [body.contact] if body.contact.ndim == 1 else list(body.contact)


def joined_at_contacts(system: System) -> Body:
    """Rotor and stator that move as one at every contact, as a Body of N + M coordinates less one for each."""
    body, own = system.joined(), system.contacts
    basis = scipy.linalg.null_space(np.array([np.concatenate([contact.rotor, -contact.stator]) for contact in own]))
    names = [*body.terms, *(name for name in ANISOTROPIC if getattr(body, name) is not None)]
    matrices = {name: basis.T @ getattr(body, name) @ basis for name in names}
    rows = [np.concatenate([contact.rotor, np.zeros(system.n_stator)]) @ basis for contact in own]
    symmetric = {name: 0.5 * (matrix + matrix.T) for name, matrix in matrices.items()}
    if body.n_states:
        sensed = {name: getattr(body, name) @ basis for name in ("state_displacement", "state_velocity")}
        symmetric |= {"state_matrix": body.state_matrix, "state_force": basis.T @ body.state_force, **sensed}
    return Body(**symmetric, contact=rows[0] if len(rows) == 1 else np.array(rows))


def critical_speeds(system: System, low: float, high: float) -> list[float]:
    """Rotor speeds in Hz between two at which a free vibration of the rotor turns with it: where its unbalance meets a resonance.

    A rotor that turns backwards has those of its mirror image, as negative speeds.

    Where all directions are alike unbalance drives forward vibrations only, where they differ backward ones too. Vibrations
    faster than the rotor are counted at 101 speeds (slower ones may cease to oscillate); where their number changes the place is
    found by halving.
    """

    def faster(speed: float) -> int:
        frequencies = np.array([each.frequency for each in vibrations_of(system.rotor, speed)])
        turning = frequencies * copysign(1.0, speed) if system.isotropic else np.abs(frequencies)
        return int(np.count_nonzero(turning > abs(speed)))

    def between(first: tuple[float, int], last: tuple[float, int], halvings: int) -> list[float]:
        if first[1] == last[1]:
            return []
        middle = 0.5 * (first[0] + last[0])
        if not halvings:
            return [middle] * abs(last[1] - first[1])
        half = middle, faster(middle)
        return between(first, half, halvings - 1) + between(half, last, halvings - 1)

    counted = [(float(speed), faster(float(speed))) for speed in np.linspace(low, high, _GRID)]
    return [speed for first, last in itertools.pairwise(counted) for speed in between(first, last, _HALVINGS)]


def controlled_frequencies(system: System, speeds: NDArray[np.float64], joined: bool) -> NDArray[np.float64]:
    """Signed damped natural frequencies in Hz of the rotor in its closed loop, (speeds, k), rising: of every motion that
    oscillates at some of the speeds, 0 where it does not; joined: with the stator at every contact."""
    systems = [system.at_speed(TWO_PI * float(speed)) for speed in speeds]
    bodies = [joined_at_contacts(own) if joined else own.rotor for own in systems]
    pairs = zip(bodies, speeds.tolist(), strict=True)
    frequencies = np.array([[each.frequency for each in vibrations_of(body, speed)] for body, speed in pairs])
    size = np.abs(frequencies).max(axis=0)
    return frequencies[:, size > _FREE * size.max(initial=0.0)]


def _without_damping(body: Body) -> Body:
    """The body without damping, cross-coupling and first-order states."""
    body = body.without_states()
    no_matrix: dict[str, Any] = dict.fromkeys(("skew_damping", "anisotropic_damping", "skew_stiffness", "rotating_damping"))
    return replace(body, damping=np.zeros_like(body.damping), **no_matrix)


def _mode(
    body: Body, vibration: FreeVibration, undamped: list[FreeVibration], sizes: tuple[float, list[float]], sense: str
) -> Mode:
    (fastest, mobilities), frequency, growth = sizes, vibration.frequency, vibration.growth_rate
    size = abs(complex(growth, TWO_PI * frequency))
    seen = [np.hypot(abs(row @ vibration.shape), abs(row @ vibration.mirror_shape)) for row in _rows(body)]
    energy = 1.0 + float((vibration.mirror_shape.conj() @ body.mass @ vibration.mirror_shape).real)
    share = max(float(one**2 / energy / own) if own else 0.0 for one, own in zip(seen, mobilities, strict=True))
    if size <= _FREE * fastest:
        return Mode(0.0, 0.0, 0.0, nan, nan, NONE, share, FREE)
    if abs(frequency) * TWO_PI <= _FREE * fastest:
        return Mode(0.0, nan, growth, copysign(inf, -growth), -growth / size, NONE, share, UNSTABLE if growth > 0.0 else STILL)
    still = abs(growth) <= _UNDAMPED * fastest
    growth = 0.0 if still else growth
    remark = UNDAMPED if still else UNSTABLE if growth > 0.0 else ""
    nearest = nan if body.n_states else _nearest(body, vibration, undamped)  # a controller is no spring
    return Mode(frequency, nearest, growth, -growth / abs(frequency), -growth / size, sense, share, remark)


def _nearest(body: Body, vibration: FreeVibration, undamped: list[FreeVibration]) -> float:
    """Frequency in Hz of the undamped vibration of the same sense whose shape is nearest; NaN where none has that sense."""
    alike = [each for each in undamped if each.frequency * vibration.frequency > 0.0]
    if not alike:
        return nan
    mirrored = body.mass @ vibration.mirror_shape

    def likeness(each: FreeVibration) -> float:
        return float(abs(each.shape.conj() @ body.mass @ vibration.shape) + abs(each.mirror_shape.conj() @ mirrored))

    return max(alike, key=likeness).frequency


def _sense(body: Body, vibration: FreeVibration, spin: float, rows: Any = None) -> str:
    """Which way the mode turns, with the rotor or against it: the larger circle of its ellipses, unless parts of the machine turn
    against each other. These parts are the nodes, all with the same weight, or the coordinates."""
    parts = [vibration.shape, vibration.mirror_shape] if rows is None else [rows @ vibration.shape, rows @ vibration.mirror_shape]
    weights = np.diag(body.mass) if rows is None else np.ones(len(rows))
    own = [np.abs(part) ** 2 for part in parts]
    weight = weights * (own[0] - own[1])  # with the sign of the turning; of coordinates their kinetic energy
    with_it, against = weight[weight > 0.0].sum(), -weight[weight < 0.0].sum()
    if with_it + against <= _STRAIGHT * float(weights @ (own[0] + own[1])):
        return STRAIGHT
    if min(with_it, against) > _PART * (with_it + against):
        return MIXED
    return FORWARD if (with_it > against) == (spin * vibration.frequency > 0.0) else BACKWARD
