"""`rsc limits`: separation margins, vibration and clearances of the unbalance response."""

import argparse
import json

from rsc.cli.common import JSON, OK, Commands, add_units, load


def add(commands: Commands) -> None:
    parser = commands("limits", limits_command, "check separation margins, vibration and clearances against [limits]")
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("--json", action="store_true", help=JSON)
    add_units(parser)


def limits_command(options: argparse.Namespace) -> int:
    from rsc.analysis.alone.limits import limits
    from rsc.show.words.limits import limits_text
    from rsc.show.words.plain import plain

    scene = load(options.scene)
    made = limits(scene)
    print(json.dumps(plain(made)) if options.json else limits_text(made, scene.title))
    return OK
