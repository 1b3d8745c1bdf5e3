"""Survey of a scene over the speeds of its run: branches, forward rubs, attractors, delayed jumps."""

from dataclasses import dataclass, field
from math import tau as TWO_PI

import numpy as np

from rsc.analysis.follow.branches import SPEEDS, branches, set_branches
from rsc.analysis.follow.delayed_jump import delayed_jump
from rsc.analysis.follow.force_ratio import ratio_places
from rsc.analysis.follow.forward_rub import attractors, rub_ranges
from rsc.analysis.follow.patience import silent
from rsc.analysis.paper.predict import refuse_backwards
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.survey.load import whirl_loads
from rsc.analysis.survey.remarks import branch_remarks, rub_remarks, scene_remarks
from rsc.system.assemble import assemble
from rsc.system.system import System

MOST_ROLLS = 21  # speeds at most at which whirls that roll are looked for


@dataclass(frozen=True)
class Survey:
    """Predictions over the speeds of a scene's run.

    scene : Scene
    speeds : (n,) Hz, rising; one for a constant speed
    branches : list of branches.Branch, labelled on the way of the run
    ratios : list of force_ratio.RatioPlace, where the normal forces of two branches pass the limit
    rubs : list of forward_rub.RubRange
    attractors : dict, speed in Hz (first and last of the run) -> list of forward_rub.Attractor
    delays : dict, label -> delayed_jump.Delay, of every branch that loses stability on the way of a run that starts on it
    remarks : list of str, in words: no friction, free motions, where unstable whirls lead, undecided stability
    loads : dict, label -> tuple of rsc.system.held.Load, what the whirls take from a drive with a torque at the first speed
    rolls : dict, speed in Hz -> list of rolling.Roll, the whirls that roll at some of the speeds
    """

    scene: object
    speeds: np.ndarray
    branches: list
    ratios: list
    rubs: list
    attractors: dict
    delays: dict
    remarks: list
    loads: dict = field(default_factory=dict)
    rolls: dict = field(default_factory=dict)


def survey(scene, note=silent):
    """Predict a scene over the speeds of its run; returns a Survey. note: as for `branches`."""
    system = assemble(scene)
    first, last = scene.drive.speed[0], scene.drive.speed[-1]
    speeds = _speeds(scene)
    whirl_branches = branches(system, speeds if last >= first else speeds[::-1], note)
    rubs = rub_ranges(system, speeds) if len(speeds) > 1 else []
    remarks = scene_remarks(system, [w for b in whirl_branches for w in b.whirls]) + branch_remarks(system, whirl_branches)
    return Survey(
        scene=scene,
        speeds=speeds,
        branches=whirl_branches,
        ratios=ratio_places(system, whirl_branches),
        rubs=rubs,
        attractors={speed: attractors(system, speed) for speed in dict.fromkeys((first, last))},
        delays=delays_of(scene, system, whirl_branches),
        remarks=remarks + rub_remarks(rubs),
        rolls={speed: rolling_whirls(system, TWO_PI * speed) for speed in speeds[:: -(-len(speeds) // MOST_ROLLS)].tolist()},
        loads={b.label: whirl_loads(system, b.whirls[0]) for b in whirl_branches} if system.drive else {},
    )


def survey_of_sets(scene, note=silent):
    """The whirls of every pressed set of several contacts over the speeds of a scene's run; returns a Survey without what is
    computed for one contact only: forward rubs, whirls that roll, ratios of forces and delayed jumps."""
    speeds = _speeds(scene)
    way = speeds if scene.drive.speed[-1] >= scene.drive.speed[0] else speeds[::-1]
    made = set_branches(assemble(scene), way, 0, note)
    return Survey(scene, speeds, made, ratios=[], rubs=[], attractors={}, delays={}, remarks=[])


def _speeds(scene):
    """Speeds over those of a run in Hz, rising; one for a constant speed."""
    low, high = min(scene.drive.speed), max(scene.drive.speed)
    refuse_backwards("survey", low)
    return np.array([low]) if low == high else np.linspace(low, high, SPEEDS)


def delays_of(scene, system: System, whirl_branches):
    """label -> Delay of every branch that is stable at the start of the run and loses its stability on the way."""
    first = scene.drive.speed[0]
    return {b.label: delayed_jump(system, b) for b in whirl_branches if b.lost and _starts(b, first)}


def _starts(branch, speed):
    """Whether a branch is there and stable at the start of the run."""
    whirl = branch.at(speed)
    return whirl is not None and whirl.decays and branch.begin.value <= speed <= branch.end.value
