"""`rsc new`: a scene to start from."""

import argparse

from rsc.cli.common import OK, Commands
from rsc.scene.templates import MODELS, template


def add(commands: Commands) -> None:
    parser = commands("new", new_command, "print a commented scene to start from")
    parser.add_argument("model", choices=MODELS, metavar="MODEL", help=", ".join(MODELS))


def new_command(options: argparse.Namespace) -> int:
    print(template(options.model), end="")
    return OK
