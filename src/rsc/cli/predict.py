"""`rsc predict`: analytic prediction without simulation."""

import argparse
import json
import sys
from typing import TYPE_CHECKING, Any

from rsc.cli.common import FORCE, JSON, OK, Commands, RotorSpeeds, add_units, load
from rsc.cli.progress import note, signs_of_life
from rsc.errors import SolverError

if TYPE_CHECKING:
    from rsc.scene.scene import Scene


def add(commands: Commands) -> None:
    parser = commands("predict", predict_command, "predict whirls over the speeds of the run or at given speeds")
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("--speed", metavar="HZ", action=RotorSpeeds, nargs="+", help="rotor speeds for a table of whirls")
    parser.add_argument("--sensitivity", action="store_true", help="also print the sensitivity of the whirls to every value")
    parser.add_argument("-o", "--output", metavar="FILE", help="file for the map of the branches")
    parser.add_argument("--force", action="store_true", help=FORCE)
    parser.add_argument("--json", action="store_true", help=JSON)
    add_units(parser)


def predict_command(options: argparse.Namespace) -> int:
    scene = load(options.scene)
    if options.sensitivity and not options.speed:
        raise SolverError("--sensitivity: requires rotor speeds (--speed HZ ...)")
    if options.speed and options.output is not None:
        problem = "draws the map over the speeds of the run and cannot be combined with --speed"
        raise SolverError(f"--output: {problem}")
    if options.speed:
        return _at_speeds(scene, options, options.speed)
    return _over_the_run(scene, options) if len(scene.contacts) == 1 else _of_sets(scene, options)


def _at_speeds(scene: "Scene", options: argparse.Namespace, speeds: list[float]) -> int:
    from rsc.show.words.plain import plain, whirls_plain
    from rsc.show.words.sensitivities import sensitivity_text
    from rsc.show.words.several import several_text
    from rsc.show.words.text import whirls_text
    from rsc.study.prediction.predictions import predictions

    with signs_of_life():
        told = predictions(scene, speeds, options.sensitivity, note)
    if options.json:
        plains = [whirls_plain(at.whirls, at.ratios, at.loads) for at in told]
        if options.sensitivity:
            plains = [{"whirls": own, "sensitivity": plain(at.sensitivity)} for own, at in zip(plains, told, strict=True)]
        print(json.dumps(plains))
        return OK
    if len(scene.contacts) > 1:
        texts = [several_text(at.whirls, speed, at.remarks, at.loads) for at, speed in zip(told, speeds, strict=True)]
    else:
        texts = [whirls_text(at.whirls, scene.contact.gap, at.remarks, at.ratios, at.loads) for at in told]
    if options.sensitivity:
        texts = [f"{text}\n\n{sensitivity_text(at.sensitivity)}" for text, at in zip(texts, told, strict=True)]
    print("\n\n".join(texts))
    return OK


def _of_sets(scene: "Scene", options: argparse.Namespace) -> int:
    """The whirls of several contacts at the corners of the schedule, and the map of every pressed set over its speeds."""
    from rsc.analysis.survey.survey import survey_of_sets
    from rsc.study.prediction.predictions import turned_forward

    _refuse_output(options)
    ended = _at_speeds(scene, options, list(dict.fromkeys(scene.drive.speed)))
    if options.output is not None:
        with signs_of_life() as shown:
            prediction = survey_of_sets(turned_forward(scene, scene.drive.speed)[0], shown)
        _save_map(prediction, options)
    return ended


def _over_the_run(scene: "Scene", options: argparse.Namespace) -> int:
    from rsc.show.words.plain import survey_plain
    from rsc.show.words.text import survey_text
    from rsc.study.prediction.predictions import surveyed, turned_forward

    _refuse_output(options)
    scene, _ = turned_forward(scene, scene.drive.speed, note)
    with signs_of_life() as shown:
        prediction = surveyed(scene, shown)
    print(json.dumps(survey_plain(prediction)) if options.json else survey_text(prediction))
    if options.output is not None:
        _save_map(prediction, options)
    return OK


def _refuse_output(options: argparse.Namespace) -> None:
    """DataError for a picture that cannot be written, before anything is computed."""
    if options.output is not None:
        from rsc.show.pictures.plots import picture_target

        picture_target(options.output, options.force)


def _save_map(prediction: Any, options: argparse.Namespace) -> None:
    from rsc.show.pictures import plots
    from rsc.show.pictures.branch_map import branch_map

    plots.save(branch_map(prediction), options.output, options.force)
    print(f"written: {options.output}", file=sys.stderr)
