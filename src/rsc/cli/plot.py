"""`rsc plot`: pictures of results and sweeps."""

import argparse
from pathlib import Path
from typing import Any

from rsc.cli.common import OK, Commands
from rsc.errors import one_line
from rsc.files.output import folder


def add(commands: Commands) -> None:
    text = "pictures of results; runs of one scene share the amplitude picture; maps of sweeps"
    parser = commands("plot", plot_command, text)
    text = "a result of `rsc check` or `rsc run`, or the sweep.nc of a sweep"
    parser.add_argument("results", metavar="RESULT", nargs="+", help=text)
    parser.add_argument("-o", "--output", metavar="DIR", default=".", help="folder for the pictures")


def plot_command(options: argparse.Namespace) -> int:
    from rsc.results.labelled import Labelled
    from rsc.show import plots, report_pictures, sweep_pictures

    target = folder(options.output)
    loaded = [_loaded(path) for path in options.results]
    written: list[Path] = []
    for name, result in zip(folders(options.results), loaded, strict=True):
        own = target if len(loaded) == 1 else folder(target / name)
        written += (sweep_pictures if isinstance(result, Labelled) else report_pictures).draw(result, own)
    reports = [result for result in loaded if not isinstance(result, Labelled)]
    if len(reports) > 1:
        written.append(target / "amplitude.png")
        plots.save(report_pictures.amplitude(reports, one_line(reports[0].result.scene.title)), written[-1])
    print("written: " + ", ".join(str(path) for path in written))
    return OK


def _loaded(path: str) -> Any:
    """The report of a result, or the dataset of a sweep."""
    from rsc.results.labelled import is_labelled, load_labelled
    from rsc.results.trajectory import load
    from rsc.study.check import report

    return load_labelled(path) if is_labelled(path) else report(load(path))


def folders(paths: list[str]) -> list[str]:
    """A folder for each result, by its own folder and name; with a number where another result has that already."""
    names: list[str] = []
    for path in paths:
        name = f"{Path(path).parent.name}_{Path(path).stem}"
        numbered = (f"{name}_{number}" for number in range(2, len(paths) + 2))
        names.append(name if name not in names else next(other for other in numbered if other not in names))
    return names
