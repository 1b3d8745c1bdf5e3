"""`rsc plot`: pictures of results."""

import argparse
from pathlib import Path

from rsc.cli.common import OK, Commands
from rsc.errors import one_line
from rsc.files.output import folder


def add(commands: Commands) -> None:
    parser = commands("plot", plot_command, "pictures of results; runs of one scene share the amplitude picture")
    parser.add_argument("results", metavar="RESULT", nargs="+")
    parser.add_argument("-o", "--output", metavar="DIR", default=".", help="folder for the pictures")


def plot_command(options: argparse.Namespace) -> int:
    from rsc.results.trajectory import load
    from rsc.show import plots
    from rsc.show.report_pictures import amplitude, draw
    from rsc.study.check import report

    target = folder(options.output)
    reports = [report(load(path)) for path in options.results]
    written = []
    for name, run_report in zip(folders(options.results), reports, strict=True):
        written += draw(run_report, target if len(reports) == 1 else folder(target / name))
    if len(reports) > 1:
        written.append(target / "amplitude.png")
        plots.save(amplitude(reports, one_line(reports[0].result.scene.title)), written[-1])
    print("written: " + ", ".join(str(path) for path in written))
    return OK


def folders(paths: list[str]) -> list[str]:
    """A folder for each result, by its own folder and name; with a number where another result has that already."""
    names: list[str] = []
    for path in paths:
        name = f"{Path(path).parent.name}_{Path(path).stem}"
        numbered = (f"{name}_{number}" for number in range(2, len(paths) + 2))
        names.append(name if name not in names else next(other for other in numbered if other not in names))
    return names
