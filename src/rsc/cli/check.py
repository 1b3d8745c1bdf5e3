"""`rsc check`: simulate, predict and compare."""

import argparse
import json
from pathlib import Path

from rsc.cli.common import FORCE, JSON, Commands, add_largest, add_units, code, load
from rsc.cli.progress import note, signs_of_life, wants_progress
from rsc.files import mark
from rsc.files.output import folder, put_all, target


def add(commands: Commands) -> None:
    parser = commands("check", check_command, "simulate, predict and compare; print the answer, write result and report")
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder of result and report (default: out/SCENE)")
    parser.add_argument("--force", action="store_true", help=FORCE)
    add_largest(parser)
    parser.add_argument("--verbose", action="store_true", help="also print the tables of the report")
    parser.add_argument("--json", action="store_true", help=JSON)
    add_units(parser)


def check_command(options: argparse.Namespace) -> int:
    from rsc.results.structure import refuse_other_file
    from rsc.show.page import page_file
    from rsc.show.words.plain import report_plain
    from rsc.show.words.text import report_text
    from rsc.study.motions.random_impacts import read_largest
    from rsc.study.report.check import report, run_for_report
    from rsc.study.report.stored import NAME, stored

    scene, largest = load(options.scene), read_largest(options.largest)
    own = folder(Path("out") / Path(options.scene).stem if options.output is None else options.output)
    refuse_other_file(own / "result.h5", options.force)
    page, kept = target(own / "report.html", mark.HTML, options.force), target(own / NAME, mark.JSON, options.force)
    result = run_for_report(scene, wants_progress(), own / "result.h5", note, options.force)
    with signs_of_life() as told:
        made = report(result, told, largest=largest)
    with made.result.kept_open():
        put_all([page_file(made, page), stored(made, kept)], options.force)
        text = json.dumps(report_plain(made)) if options.json else report_text(made, options.verbose)
    print(text)
    if not options.json:
        print(f"\nwritten: {page}, {kept}, {own / 'result.h5'} (pictures: rsc plot)")
    return code(made.result.summary, told=not options.json)
