"""Which share of the statements of src/rsc the tests run, by wing, and which files they run least; `--write` keeps the table.

    python tools/covered.py --write
    python tools/covered.py tests/unit/files

By default all tests but those marked `nightly`. Python code alone is counted: of the kernel, which is compiled, hardly a line.
What child processes run is not counted either.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from pages import TABLES, write_page

ROOT = Path(__file__).resolve().parent.parent
LEAST = 12  # files that are told


def counted(tests):
    """(exit code of the tests, file -> (statements, those that were run))."""
    with tempfile.TemporaryDirectory() as folder:
        found = Path(folder, "coverage.json")
        how = ["-q", "-p", "no:cacheprovider", "--numprocesses=2", "--dist=loadfile", "--cov=rsc", f"--cov-report=json:{found}"]
        command = [sys.executable, "-m", "pytest", *how, "-m", "not nightly", *tests]
        done = subprocess.run(command, cwd=ROOT, check=False)
        files = json.loads(found.read_text(encoding="utf-8"))["files"]
    sizes = {name: (own["summary"]["num_statements"], own["summary"]["covered_lines"]) for name, own in files.items()}
    return done.returncode, {name.partition("src/rsc/")[2]: size for name, size in sizes.items() if size[0]}


def table(files):
    """Lines of Markdown: wings with their statements, and the files of which the least is run."""
    every, run = Counter(), Counter()
    for name, (statements, covered) in files.items():
        wing = name.partition("/")[0] if "/" in name else "rsc"
        every[wing] += statements
        run[wing] += covered
    lines = ["| wing | statements | run |", "|---|---|---|"]
    lines += [f"| {wing} | {every[wing]} | {100.0 * run[wing] / every[wing]:.1f} % |" for wing in sorted(every)]
    lines.append(f"| all | {every.total()} | {100.0 * run.total() / every.total():.1f} % |")
    lines += ["", "| file of which the least is run | statements | run |", "|---|---|---|"]
    least = sorted(files, key=lambda name: files[name][1] / files[name][0])[:LEAST]
    return lines + [f"| {name} | {files[name][0]} | {100.0 * files[name][1] / files[name][0]:.1f} % |" for name in least]


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tests", nargs="*", help="files or folders of tests (default: all)")
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
    code, files = counted(options.tests)
    text = "\n".join(table(files))
    print(text)
    if options.write:
        command = " ".join(["python tools/covered.py", *options.tests, "--write"])
        write_page(TABLES / "coverage.md", "Statements that the tests run", command, text)
    return min(code, 1)


if __name__ == "__main__":
    sys.exit(main())
