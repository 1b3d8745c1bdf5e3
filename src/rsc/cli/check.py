"""`rsc check`: the main job."""

import argparse
import json
from pathlib import Path

from rsc.cli.common import JSON, Commands, code, load, note, signs_of_life, wants_progress
from rsc.files.output import folder


def add(commands: Commands) -> None:
    parser = commands("check", check_command, "simulate, predict and compare; write result and report, print the answer")
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for result and report (default out/SCENE)")
    parser.add_argument("--verbose", action="store_true", help="print the tables of the report as well")
    parser.add_argument("--json", action="store_true", help=JSON)


def check_command(options: argparse.Namespace) -> int:
    from rsc.show.page import write_page
    from rsc.show.words.text import report_plain, report_text
    from rsc.study.report.check import report, run_for_report
    from rsc.study.report.stored import NAME, write_stored

    scene = load(options.scene)
    target = folder(Path("out") / Path(options.scene).stem if options.output is None else options.output)
    result = run_for_report(scene, wants_progress(), target / "result.h5", note)
    with signs_of_life() as told:
        made = report(result, told)
    page = write_page(made, target / "report.html")
    write_stored(made, target / NAME)
    if options.json:
        print(json.dumps(report_plain(made)))
    else:
        print(report_text(made, options.verbose))
        print(f"\nwritten: {page}, {target / NAME}, {target / 'result.h5'} (pictures: rsc plot)")
    return code(made.result.summary, told=not options.json)
