"""`rsc fit`: fit values of a scene to a measured run."""

import argparse
import json

from rsc.cli.common import (
    FORCE,
    INTERRUPTED,
    JSON,
    NUMERICS,
    OK,
    Commands,
    add_scene_and_measured,
    add_units,
    refuse_shared,
    scene_and_measured,
)
from rsc.cli.progress import signs_of_life
from rsc.files.mark import TOML
from rsc.files.output import put, target


def add(commands: Commands) -> None:
    parser = commands("fit", fit_command, "fit values of a scene to the backward whirl of a measured run")
    add_scene_and_measured(parser)
    text = "values to fit, separated by commas: contact.friction,contact.gap"
    parser.add_argument("--free", metavar="NAMES", required=True, help=text)
    text = 'range of a value, such as "contact.gap=0.1 mm:0.4 mm"; default: a quarter to four times its value'
    parser.add_argument("--prior", metavar="NAME=LOW:HIGH", action="append", default=[], type=_prior, help=text)
    parser.add_argument("-o", "--output", metavar="FILE", help="write the scene with the fitted values (.toml)")
    parser.add_argument("--force", action="store_true", help=FORCE)
    parser.add_argument("--json", action="store_true", help=JSON)
    add_units(parser)


def _prior(text: str) -> tuple[str, str]:
    name, equals, range_ = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f"{text!r} must be NAME=LOW:HIGH")
    return name.strip(), range_.strip()


def fit_command(options: argparse.Namespace) -> int:
    from rsc.measured.measured import read_measured
    from rsc.show.words.fitted import fit_plain, fit_text
    from rsc.study.fit.fit import fit

    scene, file = scene_and_measured(options, "fit")
    measured = read_measured(file)
    if options.output is not None:
        refuse_shared("fit", [options.scene, options.measured], [options.output])
        target(options.output, TOML, options.force)
    names = [name.strip() for name in options.free.split(",")]
    stopped = False
    with signs_of_life() as note:
        try:
            fitted = fit(scene, measured, names, dict(options.prior), note=note)
        except KeyboardInterrupt as stop:
            if not hasattr(stop, "result"):
                raise
            fitted, stopped = stop.result, True
    print(json.dumps(fit_plain(fitted)) if options.json else fit_text(fitted))
    if options.output is not None:
        head = f"# rsc fit: of {', '.join(names)}; what is not told is as good as any other value\n"
        put(options.output, (head + fitted.scene.to_toml()).encode(), TOML, options.force)
        if not options.json:
            print(f"\nwritten: {options.output}")
    return INTERRUPTED if stopped else OK if fitted.converged else NUMERICS
