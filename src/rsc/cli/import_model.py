"""`rsc import`: scenes from ROSS and finite-element models."""

import argparse
from pathlib import Path
from typing import Any

from rsc.cli.common import FORCE, OK, Commands, RotorSpeeds, in_hertz
from rsc.errors import SceneError, shown


def add(commands: Commands) -> None:
    parser = commands("import", import_command, "import a ROSS model or finite-element matrices as a scene")
    kinds = parser.add_subparsers(required=True, metavar="KIND", dest="kind")
    ross = kinds.add_parser("ross", help="ROSS model file (rotor.save, .toml) or matrices (rotor.save_mat, .mat)")
    several = "for several rotor speeds (coefficients are interpolated)"
    ross.add_argument("model", metavar="MODEL", nargs="+", help=f"model file, or matrix file, or matrix files {several}")
    at = "rotor speed of the bearing coefficients"
    ross.add_argument("--speed", metavar="HZ", action=RotorSpeeds, nargs="+", help=f"{at}, one per file")
    fe = kinds.add_parser("fe", help="matrix files of any finite-element program")
    text = "file, or FILE:NAME for one of several matrices in it"
    for name in ("mass", "stiffness", "damping", "gyroscopic", "rotating-damping"):
        fe.add_argument(f"--{name}", metavar="FILE", required=name in ("mass", "stiffness"), help=text)
    fe.add_argument("--coordinates", metavar="TABLE.csv", help="node and direction (x, y, rx, ry, other) of every row")
    fe.add_argument("--units", choices=("m", "mm"), help="units of the matrices: m (SI, default) or mm (mm, N, t, s)")
    fe.add_argument("--axis", choices=("x", "y", "z"), default="z", help="rotor axis in files with directions (default: z)")
    fe.add_argument("--stator", action="store_true", help="the body is a stator; the output is an .npz")
    text = "Nastran deck with NLRGAP: each is a contact, or with --contact one, and the others are monitored clearances"
    fe.add_argument("--gap", metavar="DECK", help=text)
    fe.add_argument("--speed", metavar="HZ", type=in_hertz, help=at)
    over = "table of speed-dependent bearing coefficients: node, hz or rpm, k_xx, k_xy, k_yx, k_yy, c_xx, ..."
    fe.add_argument("--supports", metavar="TABLE.csv", help=over)
    for sub in (ross, fe):
        sub.set_defaults(parser=sub)
        sub.add_argument("-o", "--output", metavar="FILE", required=True, help="scene to write (.toml), or the model (.npz)")
        between = "node at the contact, or NODE,NODE,FRACTION between two"
        sub.add_argument("--contact", metavar="NODE", type=_place, required=sub is ross, help=between)
        sub.add_argument("--unbalance", metavar="NODE", help="node of the unbalance (default: that of the contact)")
        over = "table of bearing coefficients over the vibration frequency, fitted by first-order states; columns as --supports"
        sub.add_argument("--supports-by-frequency", metavar="TABLE.csv", help=over)
        bearings = "nodes at which the scene adds bearings to a free rotor"
        sub.add_argument("--force", action="store_true", help=FORCE)
        sub.add_argument("--bearings", metavar="NODE", nargs="+", default=(), help=bearings)


def import_command(options: argparse.Namespace) -> int:
    from rsc.machine.imports.gaps import RadialGap, gaps_at
    from rsc.machine.imports.importing import import_fe
    from rsc.machine.imports.ross import read_ross, read_ross_over_speed
    from rsc.machine.imports.supports import read_by_frequency
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
    fitted = read_by_frequency(options.supports_by_frequency) if options.supports_by_frequency else []
    free = bool(options.bearings or fitted)
    if options.kind == "ross":
        files, speeds = options.model, options.speed or []
        if len(files) > 1 or len(speeds) > 1:
            model = read_ross_over_speed(files, speeds, free)
        else:
            model = read_ross(files[0], speeds[0] if speeds else None, free)
    else:
        roles = ("mass", "stiffness", "damping", "gyroscopic", "rotating_damping")
        matrices: dict[str, Any] = {name: _matrix(getattr(options, name)) for name in roles}
        more = {"units": options.units, "axis": options.axis, "free": free}
        more |= {name: getattr(options, name) for name in ("speed", "supports") if getattr(options, name) is not None}
        node = contact if isinstance(contact, str) else contact[0]
        model = import_fe(**matrices, coordinates=options.coordinates, contact=node, stator=options.stator, **more)
    bearings = [*options.bearings, *fitted]
    print(import_model(model, options.output, contact, options.unbalance, bearings, gaps, watched, options.force))
    return OK


def _stations(options: argparse.Namespace) -> int:
    """Import a ROSS model file as a shaft model."""
    from rsc.study.import_shaft import import_shaft

    for name in ("speed", "unbalance", "bearings", "supports_by_frequency"):
        if getattr(options, name):
            option, hint = f"--{name.replace('_', '-')}", "model file and scene have it"
            raise SceneError("import", option, shown(getattr(options, name)), "left out", hint)
    if len(options.model) > 1:
        raise SceneError("import", "MODEL", shown(options.model), "one model file (.toml)")
    print(import_shaft(options.model[0], options.output, options.contact, options.force))
    return OK


def _place(text: str) -> str | tuple[str, str, float]:
    """A node, or NODE,NODE,FRACTION."""
    parts = text.split(",")
    if len(parts) != 3:
        return text
    try:
        return parts[0], parts[1], float(parts[2])
    except ValueError:
        raise argparse.ArgumentTypeError(f"{shown(text)}: the fraction of the distance must be a number from 0 to 1") from None


def _matrix(text: str | None) -> str | tuple[str, str] | None:
    """A file, or (file, name) of FILE:NAME."""
    if text is None or ":" not in text or Path(text).exists():
        return text
    file, _, name = text.rpartition(":")
    return file, name
