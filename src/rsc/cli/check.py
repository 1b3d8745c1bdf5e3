"""`rsc check`: the main job."""

import argparse
import json
from pathlib import Path

from rsc.cli.common import JSON, Commands, code, load, note, wants_progress
from rsc.files.output import folder


def add(commands: Commands) -> None:
    parser = commands("check", check_command, "simulate, predict and compare; write result and report, print the answer")
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for result and report (default out/SCENE)")
    parser.add_argument("--verbose", action="store_true", help="print the tables of the report as well")
    parser.add_argument("--json", action="store_true", help=JSON)


def check_command(options: argparse.Namespace) -> int:
    from rsc.show.page import write_page
    from rsc.show.text import report_plain, report_text
    from rsc.study.check import check
    from rsc.study.stored import NAME, write_stored

    scene = load(options.scene)
    target = folder(Path("out") / Path(options.scene).stem if options.output is None else options.output)
    report = check(scene, progress=wants_progress(), path=target / "result.h5", note=note)
    page = write_page(report, target / "report.html")
    write_stored(report, target / NAME)
    if options.json:
        print(json.dumps(report_plain(report)))
    else:
        print(report_text(report, options.verbose))
        print(f"\nwritten: {page}, {target / NAME}, {target / 'result.h5'} (pictures: rsc plot)")
    return code(report.result.summary, told=not options.json)
