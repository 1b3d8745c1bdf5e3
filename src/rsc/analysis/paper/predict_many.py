"""Predicted whirls of many scenes at many speeds, as arrays: `predict_many(scenes, speeds, near) -> WhirlArrays`."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import tau as TWO_PI
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rsc.analysis.paper.anisotropy import mirror_line
from rsc.analysis.paper.predict import MOST_SPEED, refuse_speeds
from rsc.analysis.paper.receptance import along
from rsc.analysis.paper.stability import whirl_eigenvalues
from rsc.analysis.paper.synchronous import synchronous_lines, unbalance_response
from rsc.analysis.paper.watched import shares, whirl_deflections
from rsc.analysis.paper.whirls import CIRCULAR, WITHIN, side_conditions, whirl_shapes, whirls_by_place
from rsc.arguments import ROTOR_SPEEDS, scenes_in, takes
from rsc.errors import SceneError, shown
from rsc.presented import Brief, drawing
from rsc.system.assemble import SceneLike, assemble
from rsc.system.blas import one_thread
from rsc.system.system import System, stacked

# scenes at one speed each that are solved together: their matrices stay in the cache of the processor
_TOGETHER = 512

Indices = tuple[NDArray[np.intp], NDArray[np.intp]]


@dataclass(frozen=True, eq=False, repr=False)
class WhirlArrays(Brief):
    """Whirls of many scenes at many rotor speeds; NaN, and False in `conditions`, where there is none.

    Arrays are (n_scenes, n_speeds, n_whirls) unless said otherwise; each value is that of `rsc.Whirl` of the same name.

    speed : (n_scenes, n_speeds) Hz
    frequency : Hz; normal_force : N; rotor_amplitude, stator_amplitude : m
    growth_rate : 1/s; growth_frequency : Hz
    line : complex m, of the rotor at the contact and its speed, to first order in the unbalance, against the mark of the shaft
    clearance_share : largest deflection over gap, with the unbalance, at the clearances that are watched; clearance : number of
        the one where that is, counted from 0; NaN without any
    conditions : dict, name -> bool array, whether the side condition holds
    """

    speed: NDArray[np.float64]
    frequency: NDArray[np.float64]
    normal_force: NDArray[np.float64]
    rotor_amplitude: NDArray[np.float64]
    stator_amplitude: NDArray[np.float64]
    growth_rate: NDArray[np.float64]
    growth_frequency: NDArray[np.float64]
    line: NDArray[np.complex128]
    clearance_share: NDArray[np.float64]
    clearance: NDArray[np.float64]
    conditions: dict[str, NDArray[np.bool_]]

    @property
    def exists(self) -> NDArray[np.bool_]:
        """Whether there is such a whirl."""
        return np.isfinite(self.frequency)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether it exists, every small motion decays, it is nearly a circle and touches no clearance."""
        return self.decays & self.conditions.get(WITHIN, np.True_)

    @property
    def decays(self) -> NDArray[np.bool_]:
        """As `stable`, whatever it touches."""
        return (self.growth_rate < 0.0) & self.conditions.get(CIRCULAR, np.True_)

    @property
    def admissible(self) -> NDArray[np.bool_]:
        """Whether it exists and every side condition holds."""
        return np.logical_and.reduce([*self.conditions.values()])

    def plot(self, ax: Any = None, scene: int = 0, **style: Any) -> Any:
        """Draw the Campbell diagram of one scene: whirls over the rotor speed, filled where stable, open where not.

        ax : matplotlib axes, by default those of a new figure; scene : number of the scene, from 0; style : properties of lines
        of matplotlib. Returns the axes.
        """
        return drawing().whirls(self.speed[scene][:, None], self.frequency[scene], self.stable[scene], ax, style)


@takes(speeds=ROTOR_SPEEDS)
@one_thread
def predict_many(scenes: Sequence[SceneLike], speeds: ArrayLike, near: ArrayLike | None = None) -> WhirlArrays:
    """Predict the whirls of many scenes at many rotor speeds: what `rsc.predict` tells one by one, for searches.

    Parameters
    ----------
    scenes : sequence of rsc.Scene
        All with the same numbers of rotor and of stator coordinates; everything else may differ.
    speeds : (n_speeds,) Hz, or (n_scenes, n_speeds) with the speeds of each scene; also with their units: "3000 rpm"
    near : (n_whirls,) Hz, optional
        Frequencies, negative for backward whirls (forward ones need negative damping). For each the whirl next to it in Hz (a
        root with positive normal force), however far away: `frequency` says where. Two of them may name one whirl.
        Default: all whirls by rising frequency, as many as the scene and speed with the most has.

    Returns
    -------
    WhirlArrays

    Raises
    ------
    SceneError
        No scene, a scene of another shape, a speed that no drive may have, or a frequency that no whirl can have.

    Examples
    --------
    >>> scene = rsc.load_scene("disk.toml")
    >>> softer = scene.with_values({"contact.stiffness": "1e6 N/m"})
    >>> whirls = rsc.predict_many([scene, softer], [20.0, 50.0, 100.0])
    >>> whirls.frequency.shape  # scenes, speeds, whirls; NaN where there are fewer
    (2, 3, 5)
    """
    scenes = scenes_in("predict_many", scenes)
    systems = _systems(scenes)
    each = _speeds(speeds, len(systems))
    for one, row in zip(scenes, each, strict=True):
        refuse_speeds("predict_many", "speeds", one, row)
    targets = None if near is None else _targets(near)
    Omega = TWO_PI * each.ravel()
    scene = np.repeat(np.arange(len(systems)), each.shape[1])
    backwards = Omega < 0.0  # solved in the mirror image
    if backwards.any():
        systems = systems + [system.mirrored() for system in systems]
        scene[backwards] += len(systems) // 2
    stack = stacked(systems)
    indices, numbers, conditions = [], [], []
    for i in range(0, len(Omega), _TOGETHER):
        block = slice(i, i + _TOGETHER)
        (place, column), values, holds = _whirls(stack.at(scene[block]), Omega[block], targets)
        indices.append((i + place, column))
        numbers.append(values)
        conditions.append(holds)
    index = tuple(np.concatenate(indices, axis=1))
    shape = (*each.shape, len(targets) if targets is not None else int(index[1].max(initial=-1)) + 1)
    return WhirlArrays(speed=each, **_tables(index, numbers, shape), conditions=_tables(index, conditions, shape))


@one_thread
def unbalance_lines(scenes: Sequence[SceneLike], speeds: ArrayLike) -> NDArray[np.complex128]:
    """The line of the rotor at the contact and at its speed without contact, against the mark of the shaft.

    Parameters
    ----------
    scenes : sequence of rsc.Scene, as for `predict_many`
    speeds : (n_speeds,) Hz, not negative

    Returns
    -------
    (n_scenes, n_speeds) complex m
    """
    systems, Omega = _systems(scenes_in("unbalance_lines", scenes)), TWO_PI * _numbers("speeds", speeds)
    contact = np.array([system.rotor.contact for system in systems])
    scene = np.repeat(np.arange(len(systems)), len(Omega))
    rotor = unbalance_response(stacked(systems).at(scene), np.tile(Omega, len(systems)))[0]
    return along(rotor, contact[scene]).reshape(len(systems), len(Omega))


def _systems(scenes: Sequence[SceneLike]) -> list[System]:
    systems = [assemble(scene) for scene in scenes]
    if not systems:
        raise SceneError("predict_many", "scenes", [], "at least one scene")
    shapes = [f"{system.n_rotor} + {system.n_stator} coordinates" for system in systems]
    for i, shape in enumerate(shapes):
        if shape != shapes[0]:
            wanted = f"a scene of {shapes[0]}, as the first one"
            raise SceneError("predict_many", f"scenes[{i}]", shape, wanted, "call it once for each size")
    watched = [tuple(place.name for place in system.clearances) for system in systems]
    for i, names in enumerate(watched):
        if names != watched[0]:
            raise SceneError("predict_many", f"scenes[{i}]", list(names), "the clearances of the first", "one call for each")
    return systems


def _speeds(speeds: ArrayLike, n_scenes: int) -> NDArray[np.float64]:
    """Speeds in Hz of each scene, (n_scenes, n_speeds)."""
    values = _numbers("speeds", speeds)
    if values.ndim not in (1, 2) or values.size == 0 or (values.ndim == 2 and len(values) != n_scenes):
        wanted = f"of the shape (n,), or ({n_scenes}, n) with a row for each scene"
        raise SceneError("predict_many", "speeds", f"array of the shape {values.shape}", wanted)
    for value in values[~(np.abs(values) <= MOST_SPEED)][:1]:
        raise SceneError("predict_many", "speeds", float(value), f"speeds in Hz between {-MOST_SPEED:g} and {MOST_SPEED:g}")
    return np.broadcast_to(values, (n_scenes, values.shape[-1])).copy()


def _targets(near: ArrayLike) -> NDArray[np.float64]:
    values = _numbers("near", near)
    if values.ndim != 1 or values.size == 0:
        raise SceneError("predict_many", "near", f"array of the shape {values.shape}", "frequencies of the shape (n,)")
    for value in values[~((np.abs(values) <= MOST_SPEED) & (values != 0.0))][:1]:
        wanted = f"frequencies in Hz up to {MOST_SPEED:g} in size, not 0"
        raise SceneError("predict_many", "near", float(value), wanted, "negative for backward whirls")
    return values


def _numbers(name: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise SceneError("predict_many", name, shown(values), "an array of numbers") from None


def _whirls(
    system: System, Omega: NDArray[np.float64], targets: NDArray[np.float64] | None
) -> tuple[Indices, dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Wanted whirls of a stack of systems at a speed each: their (places, columns), name -> their values, name -> whether a side
    condition holds. Where the speed is negative the system is the mirror image of what is asked for."""
    sense = np.where(Omega < 0.0, -1.0, 1.0)
    Omega = np.abs(Omega)
    place, Psi, F_N = whirls_by_place(system, Omega)
    signed = sense[place] * Psi
    wanted, column = _all(place, signed) if targets is None else _nearest(place, signed, TWO_PI * targets)
    place, Psi, F_N = place[wanted], Psi[wanted], F_N[wanted]
    whirls = system.at(place), Psi, F_N, Omega[place]
    rotor, stator = whirl_shapes(*whirls)
    eigenvalues = whirl_eigenvalues(*whirls)
    fastest = eigenvalues[np.arange(len(Psi)), eigenvalues.real.argmax(axis=1)]
    *forces, line = synchronous_lines(*whirls)
    values = {
        "frequency": signed[wanted] / TWO_PI,
        "normal_force": F_N,
        "rotor_amplitude": np.abs(along(rotor, whirls[0].rotor.contact)),
        "stator_amplitude": np.abs(along(stator, whirls[0].stator.contact)),
        "growth_rate": fastest.real,
        "growth_frequency": np.abs(fastest.imag) / TWO_PI,
        "line": np.where(sense[place] < 0.0, -line.conj(), line),
    }
    mirror_share = None if system.isotropic else mirror_line(*whirls).share
    deflected = None
    if system.clearances:
        deflected = shares(whirls[0], whirl_deflections(*whirls, forces))
    conditions = side_conditions(*whirls, forces[0], mirror_share, deflected)
    none = np.full(Psi.shape, np.nan)
    values["clearance_share"] = none if deflected is None else deflected.max(axis=-1)
    values["clearance"] = none if deflected is None else deflected.argmax(axis=-1).astype(float)
    return (place, column), values, {name: condition.holds for name, condition in conditions.items()}


def _all(place: NDArray[np.intp], Psi: NDArray[np.float64]) -> Indices:
    """Indices of all whirls by rising Psi at each place, and the number of each at its place."""
    return np.lexsort((Psi, place)), np.arange(len(place)) - np.searchsorted(place, place)


def _nearest(place: NDArray[np.intp], Psi: NDArray[np.float64], targets: NDArray[np.float64]) -> Indices:
    """Indices of the whirls next to each target (rad/s) at each place, and the number of the target."""
    wanted = []
    for target in targets:
        order = np.lexsort((np.abs(Psi - target), place))
        wanted.append(order[np.flatnonzero(np.diff(place[order], prepend=-1))])
    return np.concatenate(wanted), np.repeat(np.arange(len(targets)), [len(first) for first in wanted])


def _tables(index: Any, parts: list[dict[str, np.ndarray]], shape: tuple[int, ...]) -> dict[str, Any]:
    """name -> array of a shape, with the values of all parts at their (places, columns), else NaN or False."""
    tables = {}
    for name in parts[0]:
        values = np.concatenate([part[name] for part in parts])
        table = np.full((shape[0] * shape[1], shape[2]), False if values.dtype == bool else np.nan, dtype=values.dtype)
        table[index] = values
        tables[name] = table.reshape(shape)
    return tables
