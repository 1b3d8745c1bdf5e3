"""`rsc report`: pages of results and sweeps."""

import argparse
from pathlib import Path

from rsc.cli.common import OK, Commands, loaded_result, names_of
from rsc.files.output import folder


def add(commands: Commands) -> None:
    text = "a page for each result: answer, pictures, tables, scene; each shows the amplitudes of the others"
    parser = commands("report", report_command, text)
    parser.add_argument("results", metavar="RESULT", nargs="+")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for the pages (default: beside each result)")


def report_command(options: argparse.Namespace) -> int:
    from rsc.results.labelled import Labelled
    from rsc.show.page import write_page
    from rsc.show.sweeps.page import write_sweep_page

    targets = _targets(options.results, options.output)
    loaded = [loaded_result(path) for path in options.results]
    reports = [result for result in loaded if not isinstance(result, Labelled)]
    for target, own in zip(targets, loaded, strict=True):
        if isinstance(own, Labelled):
            write_sweep_page(own, target)
        else:
            write_page(own, target, [other for other in reports if other is not own])
    print("written: " + ", ".join(str(target) for target in targets))
    return OK


def _targets(results: list[str], output: str | None) -> list[Path]:
    """Where the page of each result goes: beside it, or into one folder."""
    paths = [Path(result) for result in results]
    if output is None:
        return [folder(path.parent) / ("report.html" if path.stem == "result" else f"{path.stem}.html") for path in paths]
    names = names_of(results) if len(results) > 1 else ["report"]
    return [folder(output) / f"{name}.html" for name in names]
