"""`rsc modes`: natural frequencies, decrements, critical speeds and mode shapes."""

import argparse
import json
import sys
from typing import Any

from rsc.cli.common import FORCE, JSON, OK, Commands, add_units, in_hertz, load
from rsc.cli.progress import note
from rsc.errors import SceneError, SolverError, shown
from rsc.files.mark import CSV
from rsc.files.output import target

MOST = 10_000  # speeds


def add(commands: Commands) -> None:
    parser = commands("modes", modes_command, "damped natural frequencies, logarithmic decrements and critical speeds")
    parser.add_argument("scene", metavar="SCENE", help="a scene, or the .npz of `rsc import` (the full model without reduction)")
    parser.add_argument("--speed", metavar="HZ", type=in_hertz, help="rotor speed (default: the first of the scene)")
    parser.add_argument("--speeds", metavar="FROM:TO:NUMBER", help="table over rotor speeds (Campbell) with critical speeds")
    text = "with --speeds: Campbell diagram, or its table as .csv; without: drawing and mode shapes of a shaft model"
    parser.add_argument("-o", "--output", metavar="FILE", help=text)
    parser.add_argument("--force", action="store_true", help=FORCE)
    parser.add_argument("--json", action="store_true", help=JSON)
    add_units(parser)


def modes_command(options: argparse.Namespace) -> int:
    from rsc.analysis.alone.modes import modes
    from rsc.show.pictures.modes import SHOWN, campbell_text, modes_text
    from rsc.show.words.text import plain
    from rsc.show.words.wording import sentence_in_units
    from rsc.study.prediction.predictions import turned_forward
    from rsc.study.prediction.reductions import mode_remarks

    if options.scene.lower().endswith(".npz"):
        return _of_model(options)
    scene = load(options.scene)
    if options.speed is not None and options.speeds is not None:
        raise SolverError("--speeds: cannot be combined with --speed")
    if options.speeds is None:
        _refuse_output(options)
        _refuse_shapeless(scene, options)
        speed = scene.drive.speed[0] if options.speed is None else options.speed
        scene, (speed,) = turned_forward(scene, [speed], note)
        made = modes(scene, speed)
        told = [] if options.json else mode_remarks(scene, made, SHOWN)
        texts = [modes_text(made, scene.title), *map(sentence_in_units, told)]
        print(json.dumps(plain(made)) if options.json else "\n\n".join(texts))
        if options.output is not None:
            _draw(scene, speed, options)
        return OK
    speeds = _speeds(options.speeds)
    _refuse_output(options)
    scene, speeds = turned_forward(scene, speeds, note)
    over = modes(scene, speeds)
    plains = {"modes": [plain(each) for each in over], "critical speeds": list(over.criticals)} if options.json else {}
    print(json.dumps(plains) if options.json else campbell_text(over, scene.title))
    if options.output is not None:
        _write(over, options, scene.title)
    return OK


def _of_model(options: argparse.Namespace) -> int:
    """The modes of an imported model without reduction."""
    from rsc.machine.imports.store import load_model
    from rsc.machine.model.modes import slowest_modes
    from rsc.show.pictures.modes import SHOWN, model_text
    from rsc.show.words.text import plain

    if options.speeds is not None or options.output is not None:
        raise SolverError(f"{options.scene}: an imported model needs a single --speed; give a scene for --speeds")
    model, _ = load_model(options.scene)
    speed = model.slowest_speed if options.speed is None else options.speed
    slowest = slowest_modes(model, speed, 2 * SHOWN)
    print(json.dumps([plain(mode._asdict()) for mode in slowest]) if options.json else model_text(slowest, model, speed))
    return OK


def _refuse_shapeless(scene: Any, options: argparse.Namespace) -> None:
    """SolverError for an output without --speeds, unless it is the drawing of a shaft model."""
    from rsc.show.pictures.drawing import shaft_of

    if options.output is not None and (_is_table(options.output) or shaft_of(scene) is None):
        raise SolverError("--output: requires --speeds, or a scene with a shaft model for a drawing")


def _draw(scene: Any, speed: float, options: argparse.Namespace) -> None:
    """Draw a shaft with its lowest mode shapes."""
    from rsc.machine.model.modes import slowest_shapes
    from rsc.show.pictures.drawing import SHAPES, drawing, shapes
    from rsc.show.pictures.plots import save, stacked

    model = scene.reductions[0].model
    oscillating = [one for one in slowest_shapes(model, speed, 4 * SHAPES) if one[0].frequency]
    panels = [drawing(scene), *shapes(model, oscillating[:SHAPES])]
    save(stacked([panel for panel in panels if panel is not None], scene.title), options.output, options.force)
    print(f"written: {options.output}", file=sys.stderr)


def _is_table(path: str) -> bool:
    return path.lower().endswith(".csv")


def _refuse_output(options: argparse.Namespace) -> None:
    """DataError for an output that cannot be written, before anything is computed."""
    if options.output is None:
        return
    if _is_table(options.output):
        target(options.output, CSV, options.force)
    else:
        from rsc.show.pictures.plots import picture_target

        picture_target(options.output, options.force)


def _write(over, options, title):  # type: ignore[no-untyped-def]
    path = options.output
    if _is_table(path):
        over.table().to_csv(path, options.force)
    else:
        from rsc.show.pictures.modes import campbell_picture
        from rsc.show.pictures.plots import save

        save(campbell_picture(over, title), path, options.force)
    print(f"written: {path}", file=sys.stderr)


def _speeds(text: str) -> list[float]:
    """Evenly spaced speeds in Hz of "FROM:TO:NUMBER"; a single unit applies to both ends."""
    from rsc.units.together import spread

    parts = text.split(":")
    wanted = f"FROM:TO:NUMBER, two rotor speeds and how many (2 to {MOST}), as in 0:100:51 or \"0:6000 rpm:61\""
    try:
        (first, last), number = map(in_hertz, spread(parts[:2], ends=True)), int(parts[2])
    except (ValueError, IndexError, argparse.ArgumentTypeError):
        raise SceneError("modes", "--speeds", shown(text), wanted) from None
    if len(parts) != 3 or not 2 <= number <= MOST or not first != last:
        raise SceneError("modes", "--speeds", shown(text), wanted)
    return [first + (last - first) * i / (number - 1) for i in range(number)]
