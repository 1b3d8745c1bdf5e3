"""`rsc plot`: plots of results and sweeps."""

import argparse
from pathlib import Path

from rsc.cli.common import FORCE, OK, Commands, add_units, loaded_result, names_of
from rsc.errors import one_line
from rsc.files.mark import GIF, PNG
from rsc.files.output import folder, put_all, target


def add(commands: Commands) -> None:
    text = "draw plots of results (several runs share the amplitude plot) and maps of sweeps"
    parser = commands("plot", plot_command, text)
    text = "result of `rsc check` or `rsc run`, or sweep.nc of a sweep"
    parser.add_argument("results", metavar="RESULT", nargs="+", help=text)
    parser.add_argument("-o", "--output", metavar="DIR", default=".", help="folder of the plots")
    parser.add_argument("--animate", action="store_true", help="also write the orbit along the run as an animation (GIF)")
    add_units(parser)
    parser.add_argument("--force", action="store_true", help=FORCE)


def plot_command(options: argparse.Namespace) -> int:
    from rsc.results.labelled import Labelled
    from rsc.show.pictures import plots, report_pictures

    folders = _folders(options)
    _refuse_targets(options, folders)
    loaded = [loaded_result(path) for path in options.results]
    files = []
    for own, result in zip(folders, loaded, strict=True):
        if isinstance(result, Labelled):
            from rsc.show.sweeps import pictures as sweep_pictures  # only here: runs need none of it

            files += sweep_pictures.picture_files(result, own)
            continue
        files += report_pictures.picture_files(result, own)
        if options.animate:
            files.append(report_pictures.animation(result, own / report_pictures.ANIMATION))
    reports = [result for result in loaded if not isinstance(result, Labelled)]
    if len(reports) > 1:
        shared = report_pictures.amplitude(reports, one_line(reports[0].result.scene.title))
        files.append(plots.picture_file(shared, Path(options.output) / "amplitude.png"))
    put_all(files, options.force)
    print("written: " + ", ".join(str(file.path) for file in files))
    return OK


def _folders(options: argparse.Namespace) -> list[Path]:
    """Where the pictures of each result go: into one folder for each of several."""
    shared = folder(options.output)
    return [shared] if len(options.results) == 1 else [folder(shared / name) for name in names_of(options.results)]


def _refuse_targets(options: argparse.Namespace, folders: list[Path]) -> None:
    """DataError for a name that a picture of a run may have and that cannot be written, before anything is analysed; what a
    sweep has pictures of is known only when they are drawn."""
    from rsc.results.labelled import is_labelled
    from rsc.show.pictures.report_pictures import ANIMATION, names

    for path, own in zip(options.results, folders, strict=True):
        if not is_labelled(path):
            for name in names(options.animate):
                target(own / name, GIF if name == ANIMATION else PNG, options.force)
    if len(folders) > 1:
        target(Path(options.output) / "amplitude.png", PNG, options.force)
