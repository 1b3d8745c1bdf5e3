"""Undamped critical speed map: critical speeds of a shaft over the stiffness of its bearings."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rsc.analysis.paper.predict import SceneLike
from rsc.arguments import LINE, SCENE, TEXTS, optional, takes
from rsc.errors import SceneError, nearest
from rsc.files.tables import Table
from rsc.machine.shaft.criticals import mean_stiffness, undamped_criticals
from rsc.machine.shaft.parts import Shaft
from rsc.presented import Brief, drawing
from rsc.system.blas import one_thread

SPEEDS, STEPS = 6, 61  # critical speeds in a map; stiffnesses by default
REACH = 1e-2, 1e2  # of the stiffnesses, relative to the smallest and largest of the machine


@dataclass(frozen=True, repr=False)
class MappedBearing(Brief):
    """A bearing of the map as it is in the machine: (n,) speeds in Hz and mean direct stiffness in N/m, one of each if constant.

    varied : bool, whether the map varies its stiffness; another one keeps that at its lowest speed
    """

    name: str
    speed: NDArray[np.float64]
    stiffness: NDArray[np.float64]
    varied: bool


@dataclass(frozen=True, repr=False)
class CriticalMap(Brief):
    """Undamped critical speeds over the stiffness that all varied bearings have.

    stiffness : (k,) N/m; speed : (k, 6) Hz, increasing, NaN where there are fewer; bearings : tuple of MappedBearing
    """

    stiffness: NDArray[np.float64]
    speed: NDArray[np.float64]
    bearings: tuple[MappedBearing, ...]

    def table(self) -> Table:
        """A `rsc.files.tables.Table` with a row for each stiffness, for pandas (`to_dataframe`) and CSV (`to_csv`)."""
        names = ("stiffness in N/m", *(f"critical speed {i + 1} in Hz" for i in range(self.speed.shape[1])))
        return Table(names, np.column_stack([self.stiffness, self.speed]).tolist())

    def plot(self, ax: Any = None, **style: Any) -> Any:
        """Draw the map on logarithmic axes, with the stiffnesses that the bearings have.

        ax : matplotlib axes, by default those of a new figure; style : properties of lines of matplotlib. Returns the axes.
        """
        return drawing().critical_map(self, ax, style)

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


@takes(scene=SCENE, stiffness=optional(LINE), bearings=optional(TEXTS))
@one_thread
def critical_map(
    scene: SceneLike, stiffness: ArrayLike | None = None, bearings: str | Sequence[str] | None = None
) -> CriticalMap:
    """Undamped forward critical speeds of a rotor with model "shaft" over the stiffness of its bearings.

    Without damping, cross-coupling and contact; every varied bearing has the same stiffness in all directions.

    Parameters
    ----------
    scene : rsc.Scene
        From a file or text; that of a result has only the reduced rotor.
    stiffness : (k,) N/m, optional
        By default 61 from a hundredth of the smallest to a hundred times the largest stiffness of the varied bearings.
    bearings : str or sequence of str, optional
        Names of the bearings to vary; by default all of them. The others, such as seals, keep the mean of their direct
        stiffnesses.

    Raises
    ------
    SceneError
        A rotor of another model, a name that no bearing has, a stiffness that is not positive.

    Examples
    --------
    >>> scene = rsc.load_scene("pump.toml")
    >>> criticals = rsc.critical_map(scene, [1e7, 1e8])
    >>> criticals.speed.shape
    (2, 6)
    """
    reductions = getattr(scene, "reductions", ()) if scene.rotor.model == "reduced" else ()
    models = [reduced.model for reduced in reductions[:1]]
    shaft: Shaft | None = getattr(models[0], "shaft", None) if models else None
    if shaft is None:
        raise SceneError("critical_map", "rotor", scene.rotor.model, 'model "shaft" of a scene file')
    known = [one.name for one in shaft.supports]
    chosen = known if bearings is None else [bearings] if isinstance(bearings, str) else list(bearings)
    if not chosen:
        raise SceneError("critical_map", "bearings", bearings, "at least one bearing of the shaft")
    for name in () if bearings is None else chosen:
        if name not in known or not name:
            names = ", ".join(filter(None, known)) or "none of them has a name"
            raise SceneError("critical_map", "bearings", name, f"the name of a bearing ({names})", nearest(name, known))
    varied = [i for i, name in enumerate(known) if bearings is None or name in chosen]
    actual = tuple(
        MappedBearing(one.name or f"bearing at {one.place:g} m", one.speeds, mean_stiffness(one), i in varied)
        for i, one in enumerate(shaft.supports)
    )
    values = _default(actual) if stiffness is None else np.atleast_1d(np.asarray(stiffness, dtype=float))
    if values.ndim != 1 or not (np.isfinite(values) & (values > 0.0)).all() or not len(values):
        raise SceneError("critical_map", "stiffness", stiffness, "numbers > 0 N/m")
    nodes = sorted(models[0].position.values())
    return CriticalMap(values, undamped_criticals(shaft, nodes, values, varied, SPEEDS), actual)


def _default(bearings: Sequence[MappedBearing]) -> NDArray[np.float64]:
    """Stiffnesses about those of the varied bearings."""
    own = np.concatenate([one.stiffness for one in bearings if one.varied])
    own = own[own > 0.0]
    low, high = (own.min(), own.max()) if own.size else (1e7, 1e7)
    return np.geomspace(REACH[0] * low, REACH[1] * high, STEPS)
