"""Suite strength: put known bugs into a copy of rsc, one by one, and see that the tests notice each.

    python tools/seeded_bugs.py                        all rows of seeded_bugs.toml, with the tests of their rooms
    python tools/seeded_bugs.py --only sign --jobs 2   rows whose name holds a word, two at a time
    python tools/seeded_bugs.py --missing --write      rows that the table does not have yet
    python tools/seeded_bugs.py --all                  the whole suite for every row
    python tools/seeded_bugs.py --write                keep the table in docs/maintainers/tables

A row is one edit of the package, found by the name of a function or class and an expression inside it (anchors.py), so that a
moved line or file mends itself. It must fit exactly once and leave Python behind, else it is stale and counts as a failure. A run
of the tests that hangs counts as noticed. Exit code 1 when a bug survives, a row is stale or the tests fail without any bug.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue

from anchors import Package, Stale
from pages import TABLES, write_page

ROOT = Path(__file__).resolve().parent.parent
ROWS = Path(__file__).with_suffix(".toml")
COPIED = ("src", "tests", "data", "docs", "bench", "pyproject.toml", "README.md", "Makefile", "CHANGELOG.md")
LIMIT = 900.0  # s, for the tests of one row
KILLED, SURVIVED, STALE = "killed", "SURVIVED", "STALE"
# what a row ends with that is no program: any test notices it, and none is shown to notice the bug
NO_PROGRAM = re.compile(r": (SyntaxError|IndentationError|NameError|(numba\.\S*)?(TypingError|LoweringError|UnsupportedError))\b")


def copy_to(folder):
    """A copy of the repository without environments and caches."""
    for name in COPIED:
        source, ignored = ROOT / name, shutil.ignore_patterns("__pycache__", "*.egg-info")
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=ignored)
        elif source.exists():
            shutil.copy(source, folder / name)
    return folder


def run_tests(copy, tests):
    """(exit code, name of the first failing test, "" for sources that do not compile) of pytest in a copy.

    Compiled kernels stay inside the copy.
    """
    environment = os.environ | {"PYTHONPATH": str(copy / "src"), "XDG_CACHE_HOME": str(copy / "cache"), "MPLBACKEND": "Agg"}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--tb=line", "-p", "no:cacheprovider", *tests]
    try:
        done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return 1, "(the tests hang)"
    if NO_PROGRAM.search(done.stdout):
        return 1, ""
    failed = [line.split(" - ")[0].split(" ", 1)[1] for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    if done.returncode not in (0, 1, 2):
        raise SystemExit(f"pytest could not run {tests}:\n{done.stdout}{done.stderr}")
    return done.returncode, failed[0] if failed else "(collection)" if done.returncode else ""


def seed(copy, bug):
    """Apply a row to a copy; returns the file and its original text.

    Raises
    ------
    Stale
        The row does not fit exactly once.
    """
    path, text = Package(copy / "src" / "rsc").edited(bug["place"], bug["old"], bug["new"])
    original = path.read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8")
    return path, original


def try_row(copies, bug, tests):
    """(verdict, first failing test, seconds) of one row."""
    copy, started = copies.get(), time.perf_counter()
    try:
        try:
            path, original = seed(copy, bug)
        except Stale as error:
            return STALE, str(error), 0.0
        # one call of pytest each: it would drop a test that a later argument names as well
        code, failed = next((found for found in (run_tests(copy, part) for part in tests) if found[0]), (0, ""))
        path.write_text(original, encoding="utf-8")
        shutil.rmtree(copy / "cache", ignore_errors=True)
        verdict = (KILLED if failed else STALE) if code else SURVIVED
        return verdict, failed, time.perf_counter() - started
    finally:
        copies.put(copy)


def tests_of(bug, rooms, everything):
    """Groups of tests of a row: the one expected to notice, then those of its file (the longest key that begins it); or all."""
    if everything:
        return [["tests"]]
    room = max((prefix for prefix in rooms if bug["file"].startswith(prefix)), key=len, default="src/rsc/")
    return [*([[bug["first"]]] if "first" in bug else []), rooms[room]]


def table(results, bugs, before):
    """Markdown: the count, then every row of the list; rows that were not run now keep what `before`, the old table, says."""
    cells = told(before)
    for bug, verdict, failed, _ in results:
        test = failed.removeprefix("tests/").split("[")[0].replace("|", " ")
        cells[_cells(bug)] = test if verdict == KILLED else f"**{verdict}**"
    rows = [(*_cells(bug), cells.get(_cells(bug), "**not run**")) for bug in bugs]
    noticed = sum(not row[2].startswith("**") for row in rows)
    lines = [f"{noticed} of {len(rows)} seeded bugs are noticed by the tests of their room.", ""]
    lines += ["| bug | file | noticed by |", "|---|---|---|", *("| " + " | ".join(row) + " |" for row in rows)]
    return "\n".join(lines)


def told(page):
    """(bug, file) -> what a table says of it."""
    rows = (line.strip("| ").split(" | ") for line in page.splitlines())
    return {tuple(row[:2]): row[2] for row in rows if len(row) == 3}


def _cells(bug):
    return bug["why"], bug["file"].removeprefix("src/rsc/")


def read_rows():
    """The list of bugs and the tests of each part of the package; every row with the `file` that it fits, "" if it is stale."""
    content, package = tomllib.loads(ROWS.read_text(encoding="utf-8")), Package(ROOT / "src" / "rsc")
    for bug in content["bug"]:
        fits = package.fits(bug["place"], bug["old"])
        bug["file"] = fits[0].path.relative_to(ROOT).as_posix() if len(fits) == 1 else ""
    return content


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="rows whose file, place or description holds this text")
    parser.add_argument("--missing", action="store_true", help="rows that the table does not have, or not as noticed")
    parser.add_argument("--all", action="store_true", help="the whole suite for every row")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    parser.add_argument("--no-baseline", action="store_true", help="do not first run the tests without any bug")
    options = parser.parse_args()
    content = read_rows()
    bugs = [bug for bug in content["bug"] if options.only in " ".join((bug["file"], bug["place"], bug["why"]))]
    page = TABLES / "seeded_bugs.md"
    before = page.read_text(encoding="utf-8")
    if options.missing:
        bugs = [bug for bug in bugs if told(before).get(_cells(bug), "**").startswith("**")]
    plans = [tests_of(bug, content["rooms"], options.all) for bug in bugs]
    with tempfile.TemporaryDirectory(prefix="rsc-seeded-") as folder:
        copies = Queue()
        for i in range(options.jobs):
            copies.put(copy_to(Path(folder, f"copy{i}")))
        if not options.no_baseline:
            copy = copies.get()
            code, failed = run_tests(copy, sorted({test.split("::")[0] for plan in plans for part in plan for test in part}))
            copies.put(copy)
            if code:
                raise SystemExit(f"the tests fail without any bug: {failed}")
        results = []
        with ThreadPoolExecutor(options.jobs) as pool:
            found = pool.map(lambda row: try_row(copies, *row), zip(bugs, plans, strict=True))
            for bug, (verdict, failed, seconds) in zip(bugs, found, strict=True):
                results.append((bug, verdict, failed, seconds))
                print(f"{verdict:8s} {seconds:5.0f} s  {bug['why']:60s} {failed}", flush=True)
    counts = {v: sum(r[1] == v for r in results) for v in (KILLED, SURVIVED, STALE)}
    print(f"{counts[KILLED]} killed, {counts[SURVIVED]} survived, {counts[STALE]} stale")
    if options.write:
        text = table(results, content["bug"], before)
        write_page(page, "Seeded bugs", "python tools/seeded_bugs.py --write", text)
    return 0 if counts[KILLED] == len(results) else 1


if __name__ == "__main__":
    sys.exit(main())
