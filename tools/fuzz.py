"""Mutated scenes, damaged results, matrices and imports, forged reports and measured files by the thousand: refusals, no hang.

    python tools/fuzz.py --write           a page each for imports, reports, measured files and the others
    python tools/fuzz.py --scenes 1 --results 0 --matrices 0 --imports 0 --reports 0 --measured 0 --first 4711    one case again

The cases run in child processes of some hundreds each, so that a crash of the interpreter or of a library names its case. An
interrupt ends them; the table tells how many there were. Exit code 1 when a case fails.
"""

import argparse
import collections
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pages import TABLES, write_page

ROOT = Path(__file__).resolve().parent.parent
BATCH = 1000
CHILD = """
import faulthandler, json, signal, sys, tempfile
sys.path.insert(0, sys.argv[1])
import forge_measured, forge_reports, fuzz_cases as fuzz, import_fuzz, matrix_fuzz, rsc
from scenes import SCENES

kind, first, count = sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
numbers = range(first, first + count)
faulthandler.register(signal.SIGPROF, chain=True)


def begun():
    for number in numbers:
        # a hang inside a library is not interrupted by a signal of Python; on a busy machine only processor time tells one
        signal.setitimer(signal.ITIMER_PROF, 30.0)
        faulthandler.dump_traceback_later(600.0, exit=True)
        print(json.dumps(["begin", number]), flush=True)
        yield number


def peak():
    line = next(line for line in open("/proc/self/status") if line.startswith("VmHWM:"))
    return int(line.split()[1]) * 1024


with tempfile.TemporaryDirectory() as folder:
    if kind == "scenes":
        cases = fuzz.scenes(begun(), folder)
    elif kind == "matrices":
        cases = matrix_fuzz.files(begun(), folder)
    elif kind == "imports":
        cases = import_fuzz.imports(begun(), folder)
    elif kind == "measured":
        cases = forge_measured.measurements(begun(), folder)
    elif kind == "reports":
        cases = forge_reports.reports(begun(), folder)
    else:
        cases = fuzz.results(begun(), folder, rsc.Scene.from_dict(SCENES["chains"]))
    for case in cases:
        print(json.dumps(["end", *case]), flush=True)
    print(json.dumps(["peak", peak()]), flush=True)
"""


class Tally:
    """What became of the cases of one kind."""

    def __init__(self):
        self.outcomes, self.failures = collections.Counter(), []
        self.slowest, self.peak = 0.0, 0

    def batch(self, kind, first, count):
        """Run cases in a child; after a failure the rest of them in another one."""
        support = str(ROOT / "tests" / "support")
        command = [sys.executable, "-X", "faulthandler", "-c", CHILD, support, kind, str(first), str(count)]
        environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
        with tempfile.TemporaryFile("w+") as errors:
            child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=environment)
            output = child.communicate()[0]
            errors.seek(0)
            tail = errors.read()
        begun = None
        for kind_of, *rest in (json.loads(line) for line in output.splitlines()):
            if kind_of == "begin":
                begun = rest[0]
            elif kind_of == "end":
                self.outcomes[rest[1]] += 1
                self.slowest = max(self.slowest, rest[2])
            else:
                self.peak = max(self.peak, rest[0])
        if child.returncode:
            if begun is None:
                raise SystemExit(f"the fuzz could not start:\n{tail}")
            self.failures.append((begun, child.returncode, tail))
            print(f"case {begun} of {kind} FAILED (exit {child.returncode}):\n{tail}", flush=True)
            if begun + 1 < first + count:
                self.batch(kind, begun + 1, first + count - begun - 1)


def table(tallies):
    """Markdown: outcomes and their numbers."""
    lines = ["| cases | outcome | number |", "|---|---|---|"]
    for kind, tally in tallies:
        count = sum(tally.outcomes.values()) + len(tally.failures)
        for outcome, number in sorted(tally.outcomes.items(), key=lambda item: -item[1]):
            lines.append(f"| {count} {kind} | {outcome} | {number} |")
        lines.append(f"| {count} {kind} | traceback, crash, hang or wrong value | {len(tally.failures)} |")
        worst = f"slowest {1e3 * tally.slowest:.0f} ms, peak memory {tally.peak / 1e6:.0f} MB"
        lines.append(f"| {count} {kind} | {worst} | |")
    return "\n".join(lines)


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=20_000)
    parser.add_argument("--results", type=int, default=5_000)
    parser.add_argument("--matrices", type=int, default=18_000)
    parser.add_argument("--imports", type=int, default=60_000)
    parser.add_argument("--reports", type=int, default=5_000)
    parser.add_argument("--measured", type=int, default=20_000)
    parser.add_argument("--first", type=int, default=100_000, help="number of the first case")
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
    started = time.perf_counter()
    kinds = (
        ("scenes", "mutated scenes", options.scenes),
        ("results", "damaged results", options.results),
        ("matrices", "damaged matrix files", options.matrices),
        ("imports", "imports with a damaged file", options.imports),
        ("reports", "forged report.json", options.reports),
        ("measured", "forged measured files", options.measured),
    )
    tallies = {label: Tally() for _, label, _ in kinds}
    with contextlib.suppress(KeyboardInterrupt):
        for kind, label, count in kinds:
            for first in range(options.first, options.first + count, BATCH):
                tallies[label].batch(kind, first, min(BATCH, options.first + count - first))
                number, failed = sum(tallies[label].outcomes.values()), len(tallies[label].failures)
                print(f"{label}: {number}, {failed} failed", file=sys.stderr, flush=True)
    print(f"{time.perf_counter() - started:.0f} s", file=sys.stderr)
    *others, imports, reports, measured = tallies.items()
    pages = (
        ("fuzz.md", "Fuzz", others), ("import_fuzz.md", "Fuzz of imports", [imports]),
        ("report_fuzz.md", "Forged reports", [reports]), ("measured_fuzz.md", "Forged measured files", [measured]),
    )  # fmt: skip
    for name, title, page in pages:
        page = [(label, tally) for label, tally in page if tally.outcomes or tally.failures]
        print(table(page))
        if options.write and page:
            numbers = " ".join(f"--{kind} {count}" for kind, _, count in kinds)
            write_page(TABLES / name, title, f"python tools/fuzz.py {numbers} --write", table(page))
    return 1 if any(tally.failures for tally in tallies.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
