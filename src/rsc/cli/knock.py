"""`rsc knock`: the smallest knock that starts a whirl."""

import argparse
import json

from rsc.cli.common import INTERRUPTED, JSON, OK, Commands, add_units, in_hertz, in_si, load, shown_runs


def add(commands: Commands) -> None:
    parser = commands("knock", knock_command, "the smallest knock that starts a whirl of a rotor that turns without contact")
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("--speed", metavar="HZ", type=in_hertz, help="constant rotor speed; by default the scene's")
    parser.add_argument("--contact", metavar="NAME", help="knock at this one of several contacts; by default at the first")
    parser.add_argument("--directions", metavar="N", type=int, default=24, help="over the full turn (default: 24)")
    parser.add_argument("--largest", metavar="NS", type=in_si("impulse"), help="largest impulse that is tried, such as \"2 N s\"")
    parser.add_argument("--json", action="store_true", help=JSON)
    add_units(parser)


def knock_command(options: argparse.Namespace) -> int:
    from rsc.show.words.knocks import knocks_text
    from rsc.show.words.text import plain
    from rsc.study.motions.knock import smallest_knock

    scene = load(options.scene)
    ended = OK
    with shown_runs() as note:
        try:
            knocks = smallest_knock(scene, options.speed, options.directions, options.largest, contact=options.contact, note=note)
        except KeyboardInterrupt as stop:
            if not hasattr(stop, "result"):
                raise
            knocks, ended = stop.result, INTERRUPTED
    print(json.dumps(plain(knocks)) if options.json else knocks_text(knocks, scene.title))
    return ended
