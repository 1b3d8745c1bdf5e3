"""`rsc remedy`: changes of single values that remove the backward whirl."""

import argparse
import json

from rsc.cli.common import INTERRUPTED, JSON, OK, Commands, add_largest, in_hertz, load
from rsc.cli.progress import shown_runs


def add(commands: Commands) -> None:
    text = "find changes of single values that remove the backward whirl, predicted and confirmed by simulation"
    parser = commands("remedy", remedy_command, text)
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("--speed", metavar="HZ", type=in_hertz, help="rotor speed (default: the first of the scene)")
    parser.add_argument("--starts", metavar="N", type=int, default=64, help="random impacts per search (default: 64)")
    parser.add_argument("--seed", metavar="N", type=int, default=0, help="seed of the random impacts (default: 0)")
    add_largest(parser)
    parser.add_argument("--json", action="store_true", help=JSON)


def remedy_command(options: argparse.Namespace) -> int:
    from rsc.show.words.plain import plain
    from rsc.show.words.remedies import remedies_text
    from rsc.study.motions.remedy import remedy

    scene, ended = load(options.scene), OK
    with shown_runs() as note:
        try:
            remedies = remedy(scene, options.speed, options.starts, seed=options.seed, largest=options.largest, note=note)
        except KeyboardInterrupt as stop:
            if not hasattr(stop, "result"):
                raise
            remedies, ended = stop.result, INTERRUPTED
    print(json.dumps(plain(remedies)) if options.json else remedies_text(remedies, scene.title))
    return ended
