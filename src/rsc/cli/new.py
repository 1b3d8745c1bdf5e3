"""`rsc new`: a scene to start from."""

import argparse

from rsc.cli.common import OK, Commands
from rsc.scene.files.templates import MODELS, STARTS, template


def add(commands: Commands) -> None:
    parser = commands("new", new_command, "print a commented scene to start from")
    parser.add_argument("model", choices=MODELS, metavar="MODEL", help=", ".join(MODELS))
    text = "start on a whirl (does it stay?) or at rest (does the rotor get there?)"
    parser.add_argument("--start", choices=STARTS, default=STARTS[0], help=text)


def new_command(options: argparse.Namespace) -> int:
    print(template(options.model, options.start), end="")
    return OK
