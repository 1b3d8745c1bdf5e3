"""`predict(scene, speed)`: the whirls of a scene, at its contact or at several, frequencies in Hz."""

from collections.abc import Sequence
from math import tau as TWO_PI
from typing import overload

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.paper.predict import Whirls, predict_system, refuse_speeds
from rsc.analysis.several.described import described
from rsc.analysis.several.search import whirls_of_sets
from rsc.analysis.several.whirl import SeveralWhirl, SeveralWhirls
from rsc.arguments import LINE_OF_SPEEDS, SCENE, optional, takes
from rsc.errors import SolverError
from rsc.system.assemble import SceneLike, assemble
from rsc.system.blas import one_thread
from rsc.system.system import System


@overload
def predict(scene: SceneLike, speed: float | str | None = None) -> Whirls: ...


@overload
def predict(scene: SceneLike, speed: Sequence[float] | list[str] | tuple[str, ...] | NDArray[np.floating]) -> list[Whirls]: ...


@takes(scene=SCENE, speed=optional(LINE_OF_SPEEDS))
def predict(
    scene: SceneLike, speed: float | str | Sequence[float] | list[str] | tuple[str, ...] | NDArray[np.floating] | None = None
) -> Whirls | list[Whirls]:
    """Predict the steady whirls of a scene.

    A constant load (weight) and the end of sliding are not part of the theory; the latter is a side condition.

    Parameters
    ----------
    scene : rsc.Scene
    speed : None, float or str, or a sequence of them, Hz
        Rotor speed, also with its unit: "3000 rpm"; None takes the first speed of the scene's drive.

    Returns
    -------
    Whirls, a list of Whirl, or a list of them for a sequence of speeds
        Every root with positive normal force, stable or not, sorted by frequency; empty where there is none. Of a scene with
        several contacts those of every pressed set, each a `SeveralWhirl`; that none is missing is not shown for sets of three
        contacts and more.

    Raises
    ------
    SceneError
        A speed that is no number or that no drive may have, or for which the rotor was not reduced.
    SolverError
        Several contacts and directions that differ, or a stator that is not around the bearing centre.

    Examples
    --------
    >>> scene = rsc.load_scene("laval.toml")
    >>> for whirl in rsc.predict(scene, "3000 rpm"):
    ...     print(f"{whirl.frequency:.2f} Hz, {1e3 * whirl.rotor_amplitude:.3f} mm, stable: {whirl.stable}")
    -228.88 Hz, 0.140 mm, stable: False
    -60.66 Hz, 2.554 mm, stable: True
    -33.32 Hz, 1.043 mm, stable: False
    """
    system = assemble(scene)
    speeds = np.atleast_1d(scene.drive.speed[0] if speed is None else speed)
    refuse_speeds("predict", "speed", scene, speeds)
    lists = [_whirls(system, float(value)) for value in speeds]
    return lists[0] if speed is None or np.ndim(speed) == 0 else lists


def _whirls(system: System, speed: float) -> Whirls:
    return Whirls(predict_system(system, speed)) if len(system.contacts) == 1 else SeveralWhirls(predict_several(system, speed))


@one_thread
def predict_several(system: System, speed: float) -> list[SeveralWhirl]:
    """Predict the whirls of a System with several contacts at one rotor speed in Hz, by frequency; raises as `predict`."""
    refuse_unpredictable(system)
    if speed < 0.0:  # a whirl against the spin has a positive frequency then
        return [whirl.mirrored() for whirl in predict_several(system.mirrored(), -speed)[::-1]]
    whirls = [whirl for own in whirls_of_sets(system, TWO_PI * speed) for whirl in described(system, own, speed)]
    return sorted(whirls, key=lambda whirl: whirl.frequency)


def refuse_unpredictable(system: System) -> None:
    """SolverError for what is not predicted yet at several contacts: a stator beside the bearing centre, first-order states where
    directions differ."""
    if system.n_states and not system.isotropic:
        system.rotor.refuse_states()
        system.stator.refuse_states()
    for contact in system.contacts:
        if contact.offset:
            raise SolverError(f"contact.{contact.name}.offset: only a stator around the bearing centre can be predicted yet")
