"""`rsc plot`: pictures of results."""

import argparse
from pathlib import Path

from rsc.cli.common import OK, Commands, folder


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
    for path, run_report in zip(options.results, reports, strict=True):
        subfolder = target if len(reports) == 1 else folder(target / f"{Path(path).parent.name}_{Path(path).stem}")
        written += draw(run_report, subfolder)
    if len(reports) > 1:
        written.append(target / "amplitude.png")
        plots.save(amplitude(reports, reports[0].result.scene.title), written[-1])
    print("written: " + ", ".join(str(path) for path in written))
    return OK
