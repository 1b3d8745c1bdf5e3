"""`rsc explore`: a page on which values of a scene are moved."""

import argparse

from rsc.cli.common import OK, Commands, add_units, load


def add(commands: Commands) -> None:
    text = "a page on this machine: move values of a scene, and whirls, orbit, spectrum and map follow"
    parser = commands("explore", explore_command, text)
    parser.add_argument("scene", metavar="SCENE")
    parser.add_argument("--port", metavar="N", type=int, default=0, help="on 127.0.0.1 (default: one that is free)")
    add_units(parser)


def explore_command(options: argparse.Namespace) -> int:
    from rsc.study.explore.server import explore

    with explore(load(options.scene), options.port) as page:
        print(f"open {page.address}\nCtrl-C ends it", flush=True)
        try:
            page.wait()
        except KeyboardInterrupt:
            print("ended")
    return OK
