"""How predicted whirls change with every value of a scene: derivatives of frequency, amplitude, normal force and growth rate."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.paper.predict import Whirl, refuse_backwards
from rsc.analysis.paper.predict_many import predict_many
from rsc.analysis.several.nearby import nearby
from rsc.analysis.several.predict import predict
from rsc.analysis.several.whirl import SeveralWhirl
from rsc.arguments import SCENE, SPEED, TEXTS, optional, takes
from rsc.errors import SceneError
from rsc.presented import Brief
from rsc.scene.scene import Scene
from rsc.scene.values import physical_values, value_of, with_entries
from rsc.system.assemble import assemble

STEP = 1e-3  # relative; a quarter of the difference at half of it is the error, and taken off
GOOD = 0.01  # of a derivative, up to which its error is no matter
NOTHING = 1e-6  # of the quantity itself, alike
QUANTITIES = ("frequency", "rotor_amplitude", "normal_force", "growth_rate")


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity(Brief):
    """Derivatives of the backward whirls at one speed by the values of a scene, each for a relative change: p dQ/dp.

    speed : float Hz
    name : tuple of str, of every value; value : (n_values,) in SI (frequencies Hz); unit : tuple of str
    whirl : (n_whirls,) Hz, their frequencies; stable : (n_whirls,) bool
    pressed : (n_whirls,) tuples of the names of the closed contacts, each empty with one contact
    frequency : (n_values, n_whirls) Hz; a hundredth of it is the change by 1 % of the value
    rotor_amplitude : m; normal_force : N; growth_rate : 1/s; alike; with several contacts at the one that is pressed hardest
    good : (n_values, n_whirls) bool, whether differences of two steps agree within 1 %; NaN and not good where the whirl ends so
        close that a step has none
    """

    speed: float
    name: tuple[str, ...]
    value: NDArray[np.float64]
    unit: tuple[str, ...]
    whirl: NDArray[np.float64]
    stable: NDArray[np.bool_]
    pressed: tuple[tuple[str, ...], ...]
    frequency: NDArray[np.float64]
    rotor_amplitude: NDArray[np.float64]
    normal_force: NDArray[np.float64]
    growth_rate: NDArray[np.float64]
    good: NDArray[np.bool_]


@takes(scene=SCENE, speed=optional(SPEED), values=optional(TEXTS))
def sensitivity(scene: Scene, speed: float | str | None = None, values: str | Sequence[str] | None = None) -> Sensitivity:
    """Differentiate the predicted backward whirls by the values of a scene.

    Parameters
    ----------
    scene : Scene
    speed : float or str, Hz, optional
        Also with its unit: "3000 rpm".
        By default the first speed of the drive.
    values : str or sequence of str, optional
        Names of numbers, as `rsc.sweep` takes them; by default every number of rotor, stator and contact that is not zero.

    Returns
    -------
    Sensitivity
        By central differences of the prediction, with relative steps of 0.001 and half of it.

    Raises
    ------
    SceneError
        A speed that no drive may have, or a value that the scene does not have, or that is zero or no number.

    Examples
    --------
    >>> found = rsc.sensitivity(rsc.load_scene("laval.toml"), values=["contact.friction", "stator.mass"])
    >>> found.name, found.frequency.shape  # values, whirls: Hz per unit of the value
    (('contact.friction', 'stator.mass'), (2, 3))
    """
    at = scene.drive.speed[0] if speed is None else float(speed)
    refuse_backwards("sensitivity", at)
    known = physical_values(scene)
    names = tuple(known) if values is None else (values,) if isinstance(values, str) else tuple(values)
    for name in names:
        if name not in known:
            value_of(scene, name)  # tells what is wrong with the name
            raise SceneError(scene.source, name, None, "a number of rotor, stator or contact that is not zero")
    whirls = [whirl for whirl in predict(scene, at) if whirl.frequency < 0.0]
    shape = len(names), len(whirls)
    derivatives = {quantity: np.full(shape, np.nan) for quantity in QUANTITIES}
    good = np.zeros(shape, dtype=bool)
    places, stepped = _stepped(scene, {name: known[name] for name in names})
    if whirls and stepped:
        rows = _rows(stepped, at, whirls)
        good[places] = True
        for quantity in QUANTITIES:
            derivative, error = _differences(rows[quantity])
            scale = np.abs([getattr(whirl, quantity) for whirl in whirls])
            derivatives[quantity][places] = derivative
            good[places] &= (error <= GOOD * np.abs(derivative)) | (error <= NOTHING * scale)
    return Sensitivity(
        speed=at,
        name=names,
        value=np.array([known[name] for name in names]),
        unit=tuple(value_of(scene, name).unit for name in names),
        whirl=np.array([whirl.frequency for whirl in whirls]),
        stable=np.array([whirl.stable for whirl in whirls], dtype=bool),
        pressed=tuple(getattr(whirl, "pressed", ()) for whirl in whirls),
        good=good,
        **derivatives,
    )


def _stepped(scene: Scene, values: dict[str, float]) -> tuple[list[int], list[Scene]]:
    """Numbers of the values that can be changed, and four scenes of each: by the step up and down, and by half of it."""
    places, scenes = [], []
    for i, (name, value) in enumerate(values.items()):
        try:
            four = [with_entries(scene, {name: value * (1.0 + step * STEP)}) for step in (1.0, -1.0, 0.5, -0.5)]
        except SceneError:  # on the edge of what a scene may have
            continue
        places.append(i)
        scenes += four
    return places, scenes


def _rows(scenes: Sequence[Scene], speed: float, whirls: Sequence[Whirl]) -> dict[str, NDArray[np.float64]]:
    """The quantities of some whirls in scenes nearly alike, (n_scenes, n_whirls) each; NaN where a scene has no such whirl."""
    if len(scenes[0].contacts) == 1:
        arrays = predict_many(scenes, [speed], np.array([whirl.frequency for whirl in whirls]))
        return {name: getattr(arrays, name)[:, 0] for name in QUANTITIES}
    own = [whirl for whirl in whirls if isinstance(whirl, SeveralWhirl)]
    lists = [nearby(assemble(scene), own, speed) for scene in scenes]
    return {
        name: np.array([[np.nan if one is None else getattr(one, name) for one in row] for row in lists]) for name in QUANTITIES
    }


def _differences(rows: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Derivatives (n, n_whirls) by Richardson's extrapolation of two central differences, and the error of the better one; rows
    (4 n, n_whirls) of the scenes of `_stepped`."""
    up, down, half_up, half_down = (rows[k::4] for k in range(4))
    coarse, fine = (up - down) / (2.0 * STEP), (half_up - half_down) / STEP
    error = (fine - coarse) / 3.0
    return fine + error, np.abs(error)
