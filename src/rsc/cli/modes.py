"""`rsc modes`: natural frequencies, decrements, critical speeds and mode shapes."""

import argparse
import json
import sys
from collections.abc import Callable
from typing import Any

from rsc.cli.common import FORCE, JSON, OK, Commands, add_units, in_hertz, load
from rsc.cli.progress import note
from rsc.errors import SceneError, SolverError, one_line, shown
from rsc.files.mark import CSV
from rsc.files.output import target
from rsc.units import quantity

MOST = 10_000  # speeds


def add(commands: Commands) -> None:
    parser = commands("modes", modes_command, "damped natural frequencies, logarithmic decrements and critical speeds")
    parser.add_argument("scene", metavar="SCENE", help="a scene, or the .npz of `rsc import` (the full model without reduction)")
    parser.add_argument("--speed", metavar="HZ", type=in_hertz, help="rotor speed (default: the highest of the scene)")
    parser.add_argument("--speeds", metavar="FROM:TO:NUMBER", help="table over rotor speeds (Campbell) with critical speeds")
    text = "undamped critical speeds over the stiffness of the bearings of a shaft model in N/m (default: about the actual ones)"
    parser.add_argument("--stiffness", metavar="FROM:TO:NUMBER", nargs="?", const="", help=text)
    text = "with --stiffness: names of the bearings to vary, separated by commas (default: all)"
    parser.add_argument("--bearings", metavar="NAMES", help=text)
    text = "with --speeds: Campbell diagram, with --stiffness: map, or its table as .csv; else drawing and mode shapes of a shaft"
    parser.add_argument("-o", "--output", metavar="FILE", help=text)
    parser.add_argument("--force", action="store_true", help=FORCE)
    parser.add_argument("--json", action="store_true", help=JSON)
    add_units(parser)


def modes_command(options: argparse.Namespace) -> int:
    from rsc.analysis.alone.modes import modes
    from rsc.show.pictures.modes import SHOWN, campbell, campbell_text, modes_text
    from rsc.show.words.machine import machine_lines
    from rsc.show.words.plain import plain
    from rsc.show.words.wording import sentence_in_units
    from rsc.study.prediction.predictions import turned_forward
    from rsc.study.prediction.reductions import mode_remarks

    if options.scene.lower().endswith(".npz"):
        return _of_model(options)
    scene = load(options.scene)
    if options.speed is not None and options.speeds is not None:
        raise SolverError("--speeds: cannot be combined with --speed")
    if options.stiffness is not None:
        return _critical_map(scene, options)
    if options.bearings is not None:
        raise SolverError("--bearings: requires --stiffness")
    if options.speeds is None:
        _refuse_output(options)
        _refuse_shapeless(scene, options)
        speed = max(scene.drive.speed, key=abs) if options.speed is None else options.speed
        scene, (speed,) = turned_forward(scene, [speed], note)
        made = modes(scene, speed)
        told = [] if options.json else mode_remarks(scene, made, SHOWN)
        texts = [modes_text(made, scene.title, machine=machine_lines(scene)), *map(sentence_in_units, told)]
        print(json.dumps(plain(made)) if options.json else "\n\n".join(texts))
        if options.output is not None:
            _draw(scene, made, options)
        return OK
    speeds = _speeds(options.speeds)
    _refuse_output(options)
    scene, speeds = turned_forward(scene, speeds, note)
    over = modes(scene, speeds)
    plains = {"modes": [plain(each) for each in over], "critical speeds": list(over.criticals)} if options.json else {}
    print(json.dumps(plains) if options.json else campbell_text(over, scene.title))
    if options.output is not None:
        _save(over, campbell, options, scene.title)
    return OK


def _of_model(options: argparse.Namespace) -> int:
    """The modes of an imported model without reduction."""
    from rsc.machine.imports.store import load_model
    from rsc.machine.model.modes import slowest_modes
    from rsc.show.pictures.modes import SHOWN, model_text
    from rsc.show.words.plain import plain

    if options.speeds is not None or options.output is not None:
        raise SolverError(f"{options.scene}: an imported model needs a single --speed; give a scene for --speeds")
    model, _ = load_model(options.scene)
    speed = model.slowest_speed if options.speed is None else options.speed
    slowest = slowest_modes(model, speed, 2 * SHOWN)
    print(json.dumps([plain(mode._asdict()) for mode in slowest]) if options.json else model_text(slowest, model, speed))
    return OK


def _critical_map(scene: Any, options: argparse.Namespace) -> int:
    """The undamped critical speed map."""
    from rsc.analysis.alone.critical_map import critical_map
    from rsc.show.pictures.critical_map import critical_speeds, map_text
    from rsc.show.words.plain import plain

    if options.speed is not None or options.speeds is not None:
        raise SolverError("--stiffness: cannot be combined with --speed or --speeds, it concerns the speeds at resonance")
    _refuse_output(options)
    stiffness = _stiffnesses(options.stiffness) if options.stiffness else None
    names = None if options.bearings is None else [name.strip() for name in options.bearings.split(",")]
    made = critical_map(scene, stiffness, names)
    print(json.dumps(plain(made)) if options.json else map_text(made, scene.title))
    if options.output is not None:
        _save(made, critical_speeds, options, scene.title)
    return OK


def _refuse_shapeless(scene: Any, options: argparse.Namespace) -> None:
    """SolverError for an output without --speeds, unless it is the drawing of a shaft model."""
    from rsc.show.pictures.drawing import drawing

    if options.output is not None and (_is_table(options.output) or drawing(scene) is None):
        raise SolverError("--output: requires --speeds, or a scene with a shaft model for a drawing")


def _draw(scene: Any, made: Any, options: argparse.Namespace) -> None:
    """Draw a shaft with its lowest mode shapes."""
    from rsc.show.pictures.drawing import drawing
    from rsc.show.pictures.plots import save, stacked
    from rsc.show.pictures.shapes import oscillating, shape

    panels = [drawing(scene), *(shape(made, number) for number in oscillating(made))]
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


def _save(made: Any, described: Any, options: argparse.Namespace, title: str) -> None:
    """Write a Campbell diagram or a map as a picture, or its table; described: (made) -> one description or several."""
    path = options.output
    if _is_table(path):
        made.table().to_csv(path, options.force)
    else:
        from rsc.show.pictures.plots import save, stacked

        pictures = described(made)
        save(stacked(pictures if isinstance(pictures, list) else [pictures], one_line(title)), path, options.force)
    print(f"written: {path}", file=sys.stderr)


def _stiffnesses(text: str) -> list[float]:
    """Stiffnesses in N/m of "FROM:TO:NUMBER", evenly spaced on a logarithmic axis."""
    wanted = f"FROM:TO:NUMBER, two stiffnesses > 0 and how many (2 to {MOST}), as in 1e6:1e9:61 or \"1:1000 MN/m:61\""
    first, last, number = _range("--stiffness", text, wanted, lambda part: quantity(part, "stiffness"))
    if not 0.0 < first < last:
        raise SceneError("modes", "--stiffness", shown(text), wanted)
    return [first * (last / first) ** (i / (number - 1)) for i in range(number)]


def _speeds(text: str) -> list[float]:
    """Evenly spaced speeds in Hz of "FROM:TO:NUMBER"."""
    wanted = f"FROM:TO:NUMBER, two rotor speeds and how many (2 to {MOST}), as in 0:100:51 or \"0:6000 rpm:61\""
    first, last, number = _range("--speeds", text, wanted, in_hertz)
    return [first + (last - first) * i / (number - 1) for i in range(number)]


def _range(option: str, text: str, wanted: str, read: Callable[[str], float]) -> tuple[float, float, int]:
    """Both ends and the number of steps of "FROM:TO:NUMBER"; a single unit applies to both ends."""
    from rsc.units.together import spread

    parts = text.split(":")
    try:
        (first, last), number = map(read, spread(parts[:2], ends=True)), int(parts[2])
    except (ValueError, IndexError, argparse.ArgumentTypeError):
        raise SceneError("modes", option, shown(text), wanted) from None
    if len(parts) != 3 or not 2 <= number <= MOST or not first != last:
        raise SceneError("modes", option, shown(text), wanted)
    return first, last, number
