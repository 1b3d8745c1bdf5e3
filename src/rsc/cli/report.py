"""`rsc report`: pages of results and sweeps."""

import argparse
from pathlib import Path

from rsc.cli.common import FORCE, OK, Commands, add_units, loaded_result, names_of
from rsc.files.mark import HTML
from rsc.files.output import folder, put_all, target


def add(commands: Commands) -> None:
    text = "write a page for each result, which also shows the amplitudes of the others"
    parser = commands("report", report_command, text)
    parser.add_argument("results", metavar="RESULT", nargs="+")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder of the pages (default: that of each result)")
    add_units(parser)
    parser.add_argument("--force", action="store_true", help=FORCE)


def report_command(options: argparse.Namespace) -> int:
    from rsc.results.labelled import Labelled
    from rsc.show.page import page_file
    from rsc.show.sweeps.page import sweep_page_file

    targets = [target(path, HTML, options.force) for path in _targets(options.results, options.output)]
    loaded = [loaded_result(path) for path in options.results]
    reports = [result for result in loaded if not isinstance(result, Labelled)]
    files = []
    for path, own in zip(targets, loaded, strict=True):
        if isinstance(own, Labelled):
            files.append(sweep_page_file(own, path))
        else:
            files.append(page_file(own, path, [other for other in reports if other is not own]))
    put_all(files, options.force)
    print("written: " + ", ".join(map(str, targets)))
    return OK


def _targets(results: list[str], output: str | None) -> list[Path]:
    """Where the page of each result goes: beside it, or into one folder."""
    paths = [Path(result) for result in results]
    if output is None:
        return [folder(path.parent) / ("report.html" if path.stem == "result" else f"{path.stem}.html") for path in paths]
    names = names_of(results) if len(results) > 1 else ["report"]
    return [folder(output) / f"{name}.html" for name in names]
