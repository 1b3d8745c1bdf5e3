"""`rsc impact`: the smallest impulse that starts a whirl."""

import argparse
import json

from rsc.cli.common import INTERRUPTED, JSON, OK, Commands, add_units, in_hertz, in_si, load
from rsc.cli.progress import shown_runs


def add(commands: Commands) -> None:
    parser = commands("impact", impact_command, "find the smallest impulse that starts a whirl of a free-running rotor")
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("--speed", metavar="HZ", type=in_hertz, help="constant rotor speed (default: that of the scene)")
    parser.add_argument("--contact", metavar="NAME", help="contact at which the impact acts (default: the first)")
    parser.add_argument("--directions", metavar="N", type=int, default=24, help="directions over 360 degrees (default: 24)")
    parser.add_argument("--largest", metavar="NS", type=in_si("impulse"), help="largest impulse tried, e.g. \"2 N s\"")
    parser.add_argument("--json", action="store_true", help=JSON)
    add_units(parser)


def impact_command(options: argparse.Namespace) -> int:
    from rsc.show.words.impulses import impulses_text
    from rsc.show.words.plain import plain
    from rsc.study.motions.smallest_impulse import smallest_impulse

    scene = load(options.scene)
    ended = OK
    with shown_runs() as note:
        try:
            impulses = smallest_impulse(
                scene, options.speed, options.directions, options.largest, contact=options.contact, note=note
            )
        except KeyboardInterrupt as stop:
            if not hasattr(stop, "result"):
                raise
            impulses, ended = stop.result, INTERRUPTED
    print(json.dumps(plain(impulses)) if options.json else impulses_text(impulses, scene.title))
    return ended
