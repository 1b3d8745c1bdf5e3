"""`rsc plot`: pictures of results and sweeps."""

import argparse
from pathlib import Path

from rsc.cli.common import OK, Commands, loaded_result, names_of
from rsc.errors import one_line
from rsc.files.output import folder


def add(commands: Commands) -> None:
    text = "pictures of results; runs of one scene share the amplitude picture; maps of sweeps"
    parser = commands("plot", plot_command, text)
    text = "a result of `rsc check` or `rsc run`, or the sweep.nc of a sweep"
    parser.add_argument("results", metavar="RESULT", nargs="+", help=text)
    parser.add_argument("-o", "--output", metavar="DIR", default=".", help="folder for the pictures")
    parser.add_argument("--animate", action="store_true", help="write the orbit along the run as well (GIF)")


def plot_command(options: argparse.Namespace) -> int:
    from rsc.results.labelled import Labelled
    from rsc.show.pictures import plots, report_pictures

    target = folder(options.output)
    loaded = [loaded_result(path) for path in options.results]
    written: list[Path] = []
    for name, result in zip(names_of(options.results), loaded, strict=True):
        own = target if len(loaded) == 1 else folder(target / name)
        if isinstance(result, Labelled):
            from rsc.show.sweeps import pictures as sweep_pictures  # only here: runs need none of it

            written += sweep_pictures.draw(result, own)
            continue
        written += report_pictures.draw(result, own)
        if options.animate:
            written.append(report_pictures.animation(result, own / "orbit.gif"))
    reports = [result for result in loaded if not isinstance(result, Labelled)]
    if len(reports) > 1:
        written.append(target / "amplitude.png")
        plots.save(report_pictures.amplitude(reports, one_line(reports[0].result.scene.title)), written[-1])
    print("written: " + ", ".join(str(path) for path in written))
    return OK
