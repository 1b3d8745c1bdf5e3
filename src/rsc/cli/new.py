"""`rsc new`: a scene to start from."""

import argparse
import sys

from rsc.cli.common import FORCE, OK, Commands
from rsc.errors import one_line
from rsc.scene.files.templates import ABOUT, MODELS, STARTS, template


def add(commands: Commands) -> None:
    parser = commands("new", new_command, "print a commented scene to start from; without a name, list them")
    parser.add_argument("model", choices=tuple(ABOUT), metavar="NAME", nargs="?", help=", ".join(ABOUT))
    text = "start on a whirl (does it stay? default of laval to matrices) or at rest (does the rotor get there?)"
    parser.add_argument("--start", choices=STARTS, help=text)
    parser.add_argument("-o", "--output", metavar="FILE", help="write it there, in UTF-8, instead")
    parser.add_argument("--force", action="store_true", help=FORCE)


def new_command(options: argparse.Namespace) -> int:
    if options.model is None:
        print(_listed())
        return OK
    text = template(options.model, options.start)
    if options.output is None:
        print(text, end="")
        return OK
    from rsc.files.mark import TOML
    from rsc.files.output import put

    put(options.output, text.encode(), TOML, options.force)
    print(f"written: {one_line(options.output)}", file=sys.stderr)
    return OK


def _listed() -> str:
    """The names of all scenes and what they are."""
    kinds = ["model" if name in MODELS else "machine" for name in ABOUT]
    rows = [(f"rsc new {name}", kind, about) for (name, about), kind in zip(ABOUT.items(), kinds, strict=True)]
    return "\n".join(f"{command:22}{kind:10}{about}" for command, kind, about in rows)
