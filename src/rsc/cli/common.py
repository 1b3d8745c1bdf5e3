"""Shared by several commands: scene arguments, folders, notes, exit codes."""

import argparse
import contextlib
import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rsc.cli.progress import signs_of_life
from rsc.errors import SceneError

if TYPE_CHECKING:
    from rsc.results.summary import Summary
    from rsc.results.trajectory import Trajectory
    from rsc.scene.scene import Scene

OK, BAD_INPUT, NUMERICS, DISK, SOME_FAILED, INTERRUPTED = 0, 2, 3, 4, 5, 130
JSON = "print JSON instead of a table"
FORCE = "overwrite files that rsc did not write or that were changed since"
# (name, function of the options, help) -> the parser of the command
Commands = Callable[[str, Callable[[argparse.Namespace], int], str], argparse.ArgumentParser]


def print_summary(result: "Trajectory", options: argparse.Namespace, more: str = "") -> None:
    from rsc.show.words.plain import plain
    from rsc.show.words.text import result_text

    print(json.dumps(plain(result.summary) | clearances_plain(result)) if options.json else result_text(result) + more)


def clearances_plain(result: "Trajectory") -> dict[str, Any]:
    """The clearances of a run for JSON; nothing without any."""
    from rsc.show.words.clearances import watched

    return {"clearances": watched(result.scene, result.stretches())} if result.scene.clearances else {}


def add_units(parser: argparse.ArgumentParser) -> None:
    """Add `--units` to a command that prints or draws numbers."""
    text = "display units: si, metric (um, mm, rpm) or us (mil, in, lbf, rpm); default: [report] of the scene"
    parser.add_argument("--units", choices=("si", "metric", "us"), help=text)


def add_largest(parser: argparse.ArgumentParser) -> None:
    """Add `--largest` to a command that makes lists of motions."""
    text = "largest impulse of a random impact, e.g. \"5 N s\" (default: ten times what just touches, up to 3 m/s of the rotor)"
    parser.add_argument("--largest", metavar="NS", type=in_si("impulse"), help=text)


def load(path: str) -> "Scene":
    """The scene of a file; its display units are used unless `--units` was given."""
    from rsc.scene.scene import load_scene
    from rsc.show.words.units import prefer

    scene = load_scene(path)
    prefer(scene)
    return scene


def add_scene_and_measured(parser: argparse.ArgumentParser) -> None:
    """Add the two file arguments SCENE and MEASURED; they are distinguished by their content."""
    parser.add_argument("scene", metavar="SCENE")
    text = "TOML file with the table [measured], or the data file if the TOML file has the same name"
    parser.add_argument("measured", metavar="MEASURED", help=text)


def scene_and_measured(options: argparse.Namespace, command: str) -> tuple["Scene", str]:
    """The scene, and the name of the measured run, of two files in either order."""
    files = options.scene, options.measured
    measured = [file for file in files if _is_measured(file)]
    if len(measured) != 1:
        what = "both are measured runs" if measured else "neither has a table [measured]"
        raise SceneError(command, "SCENE MEASURED", " ".join(files), "a scene and a measured run", what)
    (scene,) = (file for file in files if file != measured[0])
    return load(scene), measured[0]


def _is_measured(path: str) -> bool:
    """Whether a file is the table of a measured run, or, as everything that is no TOML, its data."""
    if not path.lower().endswith(".toml"):
        return True
    from rsc.scene.files.toml_file import tables_of, text_of

    return "measured" in tables_of(text_of(Path(path), "a scene or a measurement", "docs/users/measured.md shows one"), path)


def loaded_result(path: str) -> Any:
    """The report of a result, or the labelled arrays of a sweep."""
    from rsc.results.labelled import is_labelled
    from rsc.results.trajectory import load
    from rsc.study.report.stored import report_of

    if is_labelled(path):
        from rsc.study.sweep.dataset import load_dataset

        return load_dataset(path)
    with signs_of_life():
        return report_of(load(path), path)


def code(summary: "Summary", told: bool = False) -> int:
    """The exit code of a run, whose advice goes to standard error unless it was told."""
    finished = summary.status == "finished"
    if summary.advice and not (told and finished):
        took = f" (this command took {time.process_time():.1f} s of processor time)" if finished else ""
        print(f"rsc: {summary.advice}{took}", file=sys.stderr)
    return {"finished": OK, "interrupted": INTERRUPTED}.get(str(summary.status), NUMERICS)


def in_si(dimension: str) -> Callable[[str], float]:
    """What reads an option: a plain number in SI, of frequencies Hz, or a number with a unit as everywhere else."""

    def read(text: str) -> float:
        from rsc.units import QuantityError, quantity

        try:
            return float(text)  # whether it can be is for the command to say
        except ValueError as no_number:
            try:
                return quantity(text, dimension)
            except QuantityError as error:
                raise argparse.ArgumentTypeError(f"{text!r} {error}") from no_number

    return read


in_hertz = in_si("frequency")  # a rotor speed from "50" or "3000 rpm"


def refuse_shared(command: str, inputs: Sequence[str | Path], outputs: Sequence[str | Path]) -> None:
    """SceneError for an output that is an input, or another output, of the same command."""
    for i, output in enumerate(outputs):
        if any(_is_same(output, other) for other in (*inputs, *outputs[:i])):
            raise SceneError(command, "output", str(output), "another file than those of the command")


def _is_same(one: str | Path, other: str | Path) -> bool:
    """Whether two names are those of one file, which need not be there."""
    with contextlib.suppress(OSError, ValueError):
        return Path(one).samefile(other)
    return os.path.abspath(one) == os.path.abspath(other)


class RotorSpeeds(argparse.Action):
    """Rotor speeds in Hz, none of them without a unit beside one in another unit than Hz."""

    def __call__(self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: Any = None) -> None:
        from rsc.units import QuantityError
        from rsc.units.together import refuse_mixed

        try:
            speeds = [in_hertz(text) for text in values]
            refuse_mixed(values, "frequency")
        except (argparse.ArgumentTypeError, QuantityError) as error:
            raise argparse.ArgumentError(self, str(error)) from None
        setattr(namespace, self.dest, speeds)


def names_of(paths: list[str]) -> list[str]:
    """A name for what is made of each result, by its own folder and name; with a number where another result has that already."""
    names: list[str] = []
    for path in paths:
        name = f"{Path(path).parent.name}_{Path(path).stem}"
        numbered = (f"{name}_{number}" for number in range(2, len(paths) + 2))
        names.append(name if name not in names else next(other for other in numbered if other not in names))
    return names
