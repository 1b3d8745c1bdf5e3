"""`rsc check`: the main job."""

import argparse
import json
from pathlib import Path

from rsc.cli.common import JSON, Commands, code, load, note, wants_progress
from rsc.files.output import folder, put


def add(commands: Commands) -> None:
    parser = commands("check", check_command, "simulate, predict and compare; write result, pictures and verdict table")
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for result and pictures (default out/SCENE)")
    parser.add_argument("--json", action="store_true", help=JSON)


def check_command(options: argparse.Namespace) -> int:
    from rsc.show.report_pictures import draw
    from rsc.show.text import report_plain, report_text
    from rsc.study.check import check

    scene = load(options.scene)
    target = folder(Path("out") / Path(options.scene).stem if options.output is None else options.output)
    report = check(scene, progress=wants_progress(), path=target / "result.h5", note=note)
    pictures = draw(report, target)
    put(target / "report.json", json.dumps(report_plain(report), indent=1).encode(), b"{")
    if options.json:
        print(json.dumps(report_plain(report)))
    else:
        print(report_text(report))
        print("\nwritten: " + ", ".join(str(path) for path in (target / "result.h5", target / "report.json", *pictures)))
    return code(report.result.summary)
