"""Output of `rsc predict`: whirls at rotor speeds with remarks, or the survey over the speeds of the run."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rsc.analysis.follow.force_ratio import ForceRatio, ratios_of
from rsc.analysis.follow.patience import silent
from rsc.analysis.paper.predict import Whirls, refuse_backwards, refuse_speeds
from rsc.analysis.several.predict import predict
from rsc.analysis.survey.load import whirl_loads
from rsc.analysis.survey.plausible import speed_remarks
from rsc.analysis.survey.remarks import body_remarks, mirror_remarks, rolling_remarks, scene_remarks, set_remarks, whirl_remarks
from rsc.analysis.survey.survey import Survey, survey
from rsc.scene.scene import MIRRORED, Scene
from rsc.study.prediction.reductions import coefficient_remarks, reduction_remarks
from rsc.study.prediction.sensitivity import sensitivity
from rsc.system.assemble import assemble
from rsc.system.held import Load

Note = Callable[[str], object]


@dataclass(frozen=True, eq=False)
class AtSpeed:
    """The predictions at one rotor speed.

    whirls : Whirls
    remarks : list of str, in words: on the scene, its whirls, those that roll, the speed and reduced bodies
    ratios : list of ForceRatio, of the whirls that exist together
    loads : list of tuple of rsc.system.held.Load, what each whirl takes from a drive with a torque; empty without one
    sensitivity : rsc.study.prediction.sensitivity.Sensitivity, or None where it was not asked for
    """

    whirls: Whirls
    remarks: list[str]
    ratios: list[ForceRatio]
    loads: list[tuple[Load, ...]]
    sensitivity: Any = None


def turned_forward(scene: Scene, speeds: Sequence[float], note: Note = silent) -> tuple[Scene, list[float]]:
    """A scene and rotor speeds in Hz at none of which it turns backwards: its mirror image where it did at all, which is noted.

    Speeds of both signs stay as they are: what needs them forward refuses them.
    """
    if max(speeds) <= 0.0 > min(speeds):
        note(f"the rotor {MIRRORED}")
        return scene.mirrored(), [abs(speed) for speed in speeds]
    return scene, list(speeds)


def predictions(scene: Scene, speeds: Sequence[float], sensitive: bool = False, note: Note = silent) -> list[AtSpeed]:
    """Predict the whirls of a scene at rotor speeds, with their remarks, ratios of forces and sensitivities.

    Parameters
    ----------
    scene : Scene
    speeds : sequence of float, Hz
        All forward, or all backwards: then of the mirror image, which is noted.
    sensitive : bool
        Also by how much every value of the scene changes the whirls (`rsc.sensitivity`).
    note : function of a line of text

    Returns
    -------
    list of AtSpeed

    Raises
    ------
    SceneError
        As `rsc.predict`, and for speeds of both signs.
    """
    refuse_speeds("predict", "speed", scene, np.array(speeds))  # in the user's numbers, not those of a mirror image
    scene, speeds = turned_forward(scene, speeds, note)
    refuse_backwards("--speed", min(speeds))
    system, told = assemble(scene), []
    for speed, whirls in zip(speeds, predict(scene, speed=speeds), strict=True):
        taken = [whirl_loads(system, whirl) for whirl in whirls] if system.drive else []
        changes = sensitivity(scene, speed) if sensitive else None
        if len(scene.contacts) > 1:
            told.append(AtSpeed(whirls, _several_remarks(scene, whirls, speed), [], taken, changes))
            continue
        remarks = (
            scene_remarks(system, whirls)
            + whirl_remarks(system, whirls)
            + rolling_remarks(system, speed)
            + speed_remarks(system, speed)
            + coefficient_remarks(scene)
            + reduction_remarks(scene, (whirl for whirl in whirls if whirl.stable))
        )
        told.append(AtSpeed(whirls, remarks, ratios_of(system, whirls), taken, changes))
    return told


def _several_remarks(scene: Scene, whirls: Whirls, speed: float) -> list[str]:
    """Remarks on a scene with several contacts and its whirls at a rotor speed in Hz."""
    system = assemble(scene)
    remarks: list[str] = body_remarks(system, whirls) + set_remarks(system) + mirror_remarks(whirls)
    remarks += speed_remarks(system, speed)
    return remarks + coefficient_remarks(scene) + reduction_remarks(scene, (whirl for whirl in whirls if whirl.stable))


def surveyed(scene: Scene, note: Note = silent) -> Survey:
    """`survey` of a scene, or of its mirror image if its rotor turns backwards, with the remarks on reduced bodies."""
    scene, _ = turned_forward(scene, scene.drive.speed, note)
    prediction = survey(scene, note)
    stable = (branch.whirls[0] for branch in prediction.branches if branch.stable.any())
    prediction.remarks.extend(coefficient_remarks(scene) + reduction_remarks(scene, stable))
    return prediction
