"""`rsc predict`: the analysis alone."""

import argparse
import json
import sys

from rsc.cli.common import JSON, OK, Commands, in_hertz, load, note
from rsc.errors import SolverError


def add(commands: Commands) -> None:
    parser = commands("predict", predict_command, "analytic only: branches over the run's speeds, or the whirls at given speeds")
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("--speed", metavar="HZ", type=in_hertz, nargs="+", help="a table of the whirls at these rotor speeds")
    parser.add_argument("--sensitivity", action="store_true", help="also by how much every value of the scene changes the whirls")
    parser.add_argument("-o", "--output", metavar="FILE", help="draw the map of the branches into this picture")
    parser.add_argument("--json", action="store_true", help=JSON)


def predict_command(options: argparse.Namespace) -> int:
    from rsc.scene.scene import MIRRORED
    from rsc.show.text import survey_plain, survey_text, whirls_plain, whirls_text

    scene = load(options.scene)
    if options.sensitivity and not options.speed:
        raise SolverError("--sensitivity: must come with the rotor speeds of interest (--speed HZ ...)")
    if max(options.speed or scene.drive.speed) <= 0.0 > min(options.speed or scene.drive.speed):
        note(f"the rotor {MIRRORED}")
        scene, options.speed = scene.mirrored(), options.speed and [abs(speed) for speed in options.speed]
    if options.speed:
        from rsc.analysis.lines.force_ratio import ratios_of
        from rsc.analysis.paper.predict import predict, refuse_backwards
        from rsc.analysis.survey.plausible import speed_remarks
        from rsc.analysis.survey.remarks import rolling_remarks, scene_remarks, whirl_remarks
        from rsc.study.reductions import coefficient_remarks, reduction_remarks
        from rsc.system.assemble import assemble

        refuse_backwards("--speed", min(options.speed))
        lists, system = predict(scene, speed=options.speed), assemble(scene)
        remarks = [
            scene_remarks(system, whirls)
            + whirl_remarks(system, whirls)
            + rolling_remarks(system, speed)
            + speed_remarks(system, speed)
            + coefficient_remarks(scene)
            + reduction_remarks(scene, (whirl for whirl in whirls if whirl.stable))
            for speed, whirls in zip(options.speed, lists, strict=True)
        ]
        ratios = [ratios_of(system, whirls) for whirls in lists]
        texts = [whirls_text(whirls, scene.contact.gap, *more) for whirls, *more in zip(lists, remarks, ratios, strict=True)]
        plains = [whirls_plain(*pair) for pair in zip(lists, ratios, strict=True)]
        if options.sensitivity:
            from rsc.show.sensitivities import sensitivity_text
            from rsc.show.text import plain
            from rsc.study.sensitivity import sensitivity

            changes = [sensitivity(scene, speed) for speed in options.speed]
            texts = [f"{text}\n\n{sensitivity_text(change)}" for text, change in zip(texts, changes, strict=True)]
            plains = [{"whirls": whirls, "sensitivity": plain(change)} for whirls, change in zip(plains, changes, strict=True)]
        print(json.dumps(plains) if options.json else "\n\n".join(texts))
        return OK
    from rsc.analysis.survey.survey import survey
    from rsc.study.reductions import coefficient_remarks, reduction_remarks

    prediction = survey(scene, note)
    stable = (branch.whirls[0] for branch in prediction.branches if branch.stable.any())
    prediction.remarks.extend(coefficient_remarks(scene) + reduction_remarks(scene, stable))
    print(json.dumps(survey_plain(prediction)) if options.json else survey_text(prediction))
    if options.output is not None:
        from rsc.show import plots
        from rsc.show.branch_map import branch_map

        plots.save(branch_map(prediction), options.output)
        print(f"written: {options.output}", file=sys.stderr)
    return OK
