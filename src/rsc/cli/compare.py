"""`rsc compare`: a measured run beside a scene."""

import argparse
import json
from pathlib import Path

from rsc.cli.common import JSON, OK, Commands, add_scene_and_measured, scene_and_measured, signs_of_life
from rsc.files.output import folder, target


def add(commands: Commands) -> None:
    text = "a measured run beside the predictions for a scene: print the answer, write the page"
    parser = commands("compare", compare_command, text)
    add_scene_and_measured(parser)
    parser.add_argument("-o", "--output", metavar="FILE", help="the page (default out/MEASURED/comparison.html)")
    parser.add_argument("--verbose", action="store_true", help="print the tables of the report as well")
    parser.add_argument("--json", action="store_true", help=JSON)


def compare_command(options: argparse.Namespace) -> int:
    from rsc.measured.measured import read_measured
    from rsc.show.page import BEGINS, write_page
    from rsc.show.words.text import report_plain, report_text
    from rsc.study.report.compare import compare

    scene, file = scene_and_measured(options, "compare")
    measured = read_measured(file)
    default = Path("out") / Path(file).stem
    page = folder(default) / "comparison.html" if options.output is None else target(options.output, BEGINS)
    with signs_of_life() as note:
        report = compare(scene, measured, note=note)
    written = write_page(report, page)
    if options.json:
        print(json.dumps(report_plain(report)))
    else:
        print(report_text(report, options.verbose))
        print(f"\nwritten: {written}")
    return OK
