"""`rsc import`: finite-element models into scenes."""

import argparse
from pathlib import Path
from typing import Any

from rsc.cli.common import FORCE, OK, Commands, RotorSpeeds, in_hertz
from rsc.errors import SceneError, shown


def add(commands: Commands) -> None:
    parser = commands("import", import_command, "a finite-element model into a scene: the rotor of ROSS, or matrices")
    kinds = parser.add_subparsers(required=True, metavar="KIND", dest="kind")
    ross = kinds.add_parser("ross", help="ROSS's own model file (rotor.save, .toml), or its matrices (rotor.save_mat, .mat)")
    several = "of several rotor speeds: coefficients follow the speed from one to the next"
    ross.add_argument("model", metavar="MODEL", nargs="+", help=f"model file, or file of matrices, or such files {several}")
    at = "rotor speed at which bearing coefficients were taken"
    ross.add_argument("--speed", metavar="HZ", action=RotorSpeeds, nargs="+", help=f"{at}, one for each file")
    fe = kinds.add_parser("fe", help="matrix files of any finite-element program")
    text = "file, or FILE:NAME for one of several matrices in it"
    for name in ("mass", "stiffness", "damping", "gyroscopic", "rotating-damping"):
        fe.add_argument(f"--{name}", metavar="FILE", required=name in ("mass", "stiffness"), help=text)
    fe.add_argument("--coordinates", metavar="TABLE.csv", help="node and direction (x, y, rx, ry, other) of every row")
    fe.add_argument("--units", choices=("m", "mm"), help="mm: mm, N, t, s (default: SI, refused where it looks like the latter)")
    fe.add_argument("--axis", choices=("x", "y", "z"), default="z", help="axis of the rotor in files that carry directions")
    fe.add_argument("--stator", action="store_true", help="the body is a stator; the output is an .npz")
    text = "Nastran deck with NLRGAP, each a contact; with --contact the one there is, and the others are watched"
    fe.add_argument("--gap", metavar="DECK", help=text)
    fe.add_argument("--speed", metavar="HZ", type=in_hertz, help=at)
    over = "table of bearings whose coefficients follow the speed: node, hz or rpm, k_xx, k_xy, k_yx, k_yy, c_xx, ..."
    fe.add_argument("--supports", metavar="TABLE.csv", help=over)
    for sub in (ross, fe):
        sub.set_defaults(parser=sub)
        sub.add_argument("-o", "--output", metavar="FILE", required=True, help="scene to begin with (.toml), or the model (.npz)")
        between = "node at the contact, or NODE,NODE,SHARE between two"
        sub.add_argument("--contact", metavar="NODE", type=_place, required=sub is ross, help=between)
        sub.add_argument("--unbalance", metavar="NODE", help="node of the unbalance (default: that of the contact)")
        bearings = "nodes of bearings that the scene adds, for a rotor that moves freely without"
        sub.add_argument("--force", action="store_true", help=FORCE)
        sub.add_argument("--bearings", metavar="NODE", nargs="+", default=(), help=bearings)


def import_command(options: argparse.Namespace) -> int:
    from rsc.machine.imports.gaps import RadialGap, gaps_at
    from rsc.machine.imports.importing import import_fe
    from rsc.machine.imports.ross import read_ross, read_ross_over_speed
    from rsc.study.import_model import import_model

    contact = options.contact
    if options.kind == "ross" and options.model[0].lower().endswith(".toml"):
        return _stations(options)
    gaps: list[RadialGap] = []
    watched: list[RadialGap] = []
    if options.kind == "fe" and options.gap is not None:
        gaps, watched = gaps_at(options.gap, contact, options.axis, options.units)
        contact = str(gaps[0].inner)
    if contact is None:
        raise SceneError("import", "--contact", None, "given", "the node at which rotor and stator touch")
    if options.kind == "ross":
        files, speeds, free = options.model, options.speed or [], bool(options.bearings)
        if len(files) > 1 or len(speeds) > 1:
            model = read_ross_over_speed(files, speeds, free)
        else:
            model = read_ross(files[0], speeds[0] if speeds else None, free)
    else:
        roles = ("mass", "stiffness", "damping", "gyroscopic", "rotating_damping")
        matrices: dict[str, Any] = {name: _matrix(getattr(options, name)) for name in roles}
        more = {"units": options.units, "axis": options.axis, "free": bool(options.bearings)}
        more |= {name: getattr(options, name) for name in ("speed", "supports") if getattr(options, name) is not None}
        node = contact if isinstance(contact, str) else contact[0]
        model = import_fe(**matrices, coordinates=options.coordinates, contact=node, stator=options.stator, **more)
    print(import_model(model, options.output, contact, options.unbalance, options.bearings, gaps, watched, options.force))
    return OK


def _stations(options: argparse.Namespace) -> int:
    """ROSS's own model file into a shaft by its stations."""
    from rsc.study.import_shaft import import_shaft

    for name in ("speed", "unbalance", "bearings"):
        if getattr(options, name):
            raise SceneError("import", f"--{name}", shown(getattr(options, name)), "left out", "model file and scene have it")
    if len(options.model) > 1:
        raise SceneError("import", "MODEL", shown(options.model), "one model file (.toml)")
    print(import_shaft(options.model[0], options.output, options.contact, options.force))
    return OK


def _place(text: str) -> str | tuple[str, str, float]:
    """A node, or NODE,NODE,SHARE."""
    parts = text.split(",")
    if len(parts) != 3:
        return text
    try:
        return parts[0], parts[1], float(parts[2])
    except ValueError:
        raise argparse.ArgumentTypeError(f"{shown(text)}: the share of the way must be a number from 0 to 1") from None


def _matrix(text: str | None) -> str | tuple[str, str] | None:
    """A file, or (file, name) of FILE:NAME."""
    if text is None or ":" not in text or Path(text).exists():
        return text
    file, _, name = text.rpartition(":")
    return file, name
