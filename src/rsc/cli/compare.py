"""`rsc compare`: a measured run compared with the predictions for a scene."""

import argparse
import json
from pathlib import Path

from rsc.cli.common import FORCE, JSON, OK, Commands, add_scene_and_measured, add_units, scene_and_measured
from rsc.cli.progress import signs_of_life
from rsc.files.mark import HTML
from rsc.files.output import folder, put_all, target


def add(commands: Commands) -> None:
    text = "compare a measured run with the predictions for a scene; print the answer, write the page"
    parser = commands("compare", compare_command, text)
    add_scene_and_measured(parser)
    parser.add_argument("-o", "--output", metavar="FILE", help="page to write (default: out/MEASURED/comparison.html)")
    parser.add_argument("--force", action="store_true", help=FORCE)
    parser.add_argument("--verbose", action="store_true", help="also print the tables of the report")
    parser.add_argument("--json", action="store_true", help=JSON)
    add_units(parser)


def compare_command(options: argparse.Namespace) -> int:
    from rsc.measured.measured import read_measured
    from rsc.show.page import page_file
    from rsc.show.words.plain import report_plain
    from rsc.show.words.text import report_text
    from rsc.study.report.compare import compare

    scene, file = scene_and_measured(options, "compare")
    measured = read_measured(file)
    default = Path("out") / Path(file).stem
    page = target(folder(default) / "comparison.html" if options.output is None else options.output, HTML, options.force)
    with signs_of_life() as note:
        report = compare(scene, measured, note=note)
    put_all([page_file(report, page)], options.force)
    if options.json:
        print(json.dumps(report_plain(report)))
    else:
        print(report_text(report, options.verbose))
        print(f"\nwritten: {page}")
    return OK
