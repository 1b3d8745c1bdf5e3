"""`rsc motions`: every motion of a machine that lasts at a rotor speed."""

import argparse
import json
import sys

from rsc.cli.common import FORCE, INTERRUPTED, JSON, OK, Commands, add_largest, add_units, in_hertz, load
from rsc.cli.progress import shown_runs


def add(commands: Commands) -> None:
    parser = commands("motions", motions_command, "find all motions that last at a speed: whirl, rub, no contact")
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("--speed", metavar="HZ", type=in_hertz, help="rotor speed (default: the first of the scene)")
    parser.add_argument("--starts", metavar="N", type=int, default=64, help="number of random impacts (default: 64)")
    parser.add_argument("--seed", metavar="N", type=int, default=0, help="seed of the random impacts (default: 0)")
    add_largest(parser)
    parser.add_argument("--smallest", action="store_true", help="also find the smallest impulse that starts each motion")
    parser.add_argument("-o", "--output", metavar="PNG", help="plot of the random impacts, coloured by the motion they end in")
    parser.add_argument("--force", action="store_true", help=FORCE)
    parser.add_argument("--json", action="store_true", help=JSON)
    add_units(parser)


def motions_command(options: argparse.Namespace) -> int:
    from rsc.show.words.motions import motions_text
    from rsc.show.words.plain import plain
    from rsc.study.motions.motions import motions

    scene, ended = load(options.scene), OK
    if options.output is not None:
        from rsc.show.pictures.plots import picture_target

        picture_target(options.output, options.force)
    with shown_runs() as note:
        try:
            more = {"seed": options.seed, "smallest": options.smallest, "largest": options.largest}
            listed = motions(scene, options.speed, options.starts, **more, note=note)
        except KeyboardInterrupt as stop:
            if not hasattr(stop, "result"):
                raise
            listed, ended = stop.result, INTERRUPTED
    print(json.dumps(plain(listed)) if options.json else motions_text(listed, scene.title))
    if options.output is not None:
        from rsc.show.pictures.maps import plot_starts
        from rsc.show.pictures.plots import save

        save(plot_starts(listed, title=scene.title), options.output, options.force)
        print(f"written: {options.output}", file=sys.stderr)
    return ended
