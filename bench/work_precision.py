"""Work-precision diagrams: error against running time and against right-hand-side calls, all methods interleaved in one run.

    python bench/work_precision.py [--problems P1 P1c P2 gyro ROSS pump] [--quick] [--only NAME ...] [--repeats 5] [--limit 2]

Error: largest displacement error on the 2 kHz grid, in gaps, against bench/reference.py. Time: processor time of the integration
alone, with output on the grid, median of the repeats (of a point that failed: one run); the first call's compilation apart. A
point over the limit ends as T; tighter settings of that method are then not begun and drawn as T as well.
Writes work_precision_NAME.csv and .png for each problem and work_precision.txt, the table that is printed at the end.
"""

import argparse
import csv
import multiprocessing
import platform
import subprocess
import sys
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np

import work_precision_report
from entrants import entrants, versions
from peers.common import Absent
from peers.own import RSC_METHODS, Rsc
from problems import NAMES, problem, results_folder
from reference import solution

sys.path.append(str(Path(__file__).resolve().parents[1] / "tools"))
from pages import machine

# shares of the duration in a short run; both run on one compiled kernel: larger ones, if asked for, spend their time on compiling
QUICK_SHARE, OTHER_SHARE = {"P1": 0.1, "P1c": 0.3}, 0.1
WRONG, BLOWN = 1e3, 1e6  # times the tolerance: W; gaps: B


class Point(NamedTuple):
    """A row of the table."""

    problem: str
    method: str
    family: str
    setting: float  # relative tolerance, or steps between two output times
    cause: str  # empty: it succeeded; else a letter of the legend, or "absent"
    error: float  # gaps
    seconds: float  # median
    seconds_min: float
    seconds_max: float
    repeats: int
    calls: int
    setup: float  # s, compilation before this point
    reference_error: float  # gaps
    remark: str


def judge(outcome, entrant, setting, exact, gap):
    """(cause, error in gaps) of a run."""
    if outcome.cause or outcome.motion is None:
        return outcome.cause or "C", float("nan")
    with np.errstate(invalid="ignore", over="ignore"):
        error = float(abs(outcome.motion - exact).max() / gap)
    if not np.isfinite(error):
        return "N", float("nan")
    if error > BLOWN:
        return "B", error
    wrong = error > 1.0 if entrant.fixed else error > WRONG * setting
    return "W" if wrong else "", error


def first_call(job):
    """Processor seconds of the first call of a method of rsc, or of the reference; job = (problem, method or None).

    The kernel and the reference stay on disk.
    """
    name, method = job
    begun = time.process_time()
    if method:
        Rsc(problem(name, 0.002), method)(1e-6)
    else:
        solution(problem(name))
    return time.process_time() - begun


def first_calls(names):
    """{(problem, label): seconds} of rsc's kernels, on all processors before anything is measured."""
    jobs = [(name, method) for name in names for method in (*RSC_METHODS, None)]
    with ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")) as pool:
        return {(name, f"rsc {method}"): spent for (name, method), spent in zip(jobs, pool.map(first_call, jobs), strict=True)}


def prepared(name, chosen, known):
    """{label: (entrant, method)}, warmed up on a short piece of the problem, and rows with the seconds of each first call.

    known : {(problem, label): seconds} of those that were called before.
    """
    short, whole = problem(name, 0.002), problem(name)
    methods, rows = {}, []
    for entrant in chosen:
        begun = time.perf_counter()
        try:
            entrant.make(short)(entrant.settings[len(entrant.settings) // 2], 60.0)
            methods[entrant.label] = (entrant, entrant.make(whole))
        except Absent as cause:
            print(f"{name}: {entrant.label} is absent: {cause}")
            rows.append(_empty(name, entrant, float("nan"), "absent", str(cause)))
            continue
        first = known.get((name, entrant.label), time.perf_counter() - begun)
        rows.append(_empty(name, entrant, float("nan"), "first call", "")._replace(setup=first))
    return methods, rows


def _empty(name, entrant, setting, cause, remark):
    nan = float("nan")
    return Point(name, entrant.label, entrant.family, setting, cause, nan, nan, nan, nan, 0, 0, 0.0, nan, remark)


def measure(name, chosen, repeats, limit, known, share=1.0):
    """All points of a problem; known: see `prepared`."""
    case = problem(name, share)
    begun = time.perf_counter()
    exact = solution(case)
    print(
        f"{name}: {exact.how}, own error {exact.error:.1e} gaps, {exact.switches} switches, {time.perf_counter() - begun:.0f} s",
        flush=True,
    )
    methods, rows = prepared(name, chosen, known)
    if share < 1.0:
        methods = {label: (entrant, entrant.make(case)) for label, (entrant, _) in methods.items()}
    over = set()
    for i in range(max(len(entrant.settings) for entrant in chosen)):
        running = {}
        for repeat in range(repeats):
            for label, (entrant, run) in methods.items():
                if i >= len(entrant.settings) or (repeat and repeat >= running[label][1]):
                    continue
                setting = entrant.settings[i]
                if label in over:
                    running[label] = ([], 0, None)
                    rows.append(_empty(name, entrant, setting, "T", "not begun: a looser setting was over the limit"))
                    continue
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    outcome = run(setting, limit)
                if repeat == 0:
                    verdict = judge(outcome, entrant, setting, exact.motion, case.matrices.gap)
                    if verdict[0] == "T" or outcome.seconds > limit:
                        over.add(label)
                    # a failure stands on its rail, no median is made of its times
                    running[label] = ([], 1 if verdict[0] or label in over else repeats, (outcome, *verdict))
                running[label][0].append((outcome.seconds, outcome.setup))
        for label, (times, _, first) in running.items():
            if first is not None:
                rows.append(_point(name, methods[label][0], methods[label][0].settings[i], times, first, exact))
    return rows


def _point(name, entrant, setting, times, first, exact):
    outcome, cause, error = first
    seconds = [item[0] for item in times]
    remark = "" if np.isnan(error) or error >= 100.0 * exact.error else "below 100 times the reference's own error"
    spread = (float(np.median(seconds)), min(seconds), max(seconds))
    setup = max(item[1] for item in times)
    told = name, entrant.label, entrant.family, setting, cause, error
    return Point(*told, *spread, len(seconds), outcome.calls, setup, exact.error, remark)


def write(name, rows, notes, folder):
    """The CSV of a problem, a row for each point."""
    with open(folder / f"work_precision_{name}.csv", "w", newline="") as file:
        for note in notes:
            file.write(f"# {note}\n")
        writer = csv.writer(file)
        writer.writerow(Point._fields)
        for row in rows:
            writer.writerow(f"{item:.6g}" if isinstance(item, float) else item for item in row)


def read(name, folder):
    """(points, notes) of a CSV written by `write`."""
    lines = (folder / f"work_precision_{name}.csv").read_text().splitlines()
    notes = [line[2:] for line in lines if line.startswith("# ")]
    kinds = Point.__annotations__
    rows = csv.DictReader(line for line in lines if not line.startswith("# "))
    return [Point(**{key: kinds[key](text) for key, text in row.items()}) for row in rows], notes


def host():
    """One line on the machine."""
    return f"{machine()}, {platform.system()}, Python {platform.python_version()}"


def run(name, options, known):
    """Measure a problem and write its CSV; known: see `prepared`."""
    begun = time.perf_counter()
    chosen = [entrant for entrant in entrants(options.quick) if entrant.label.startswith(tuple(options.only))]
    repeats = 1 if options.quick else options.repeats
    rows = measure(name, chosen, repeats, options.limit, known, QUICK_SHARE.get(name, OTHER_SHARE) if options.quick else 1.0)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    notes = [
        f"commit {commit or 'unknown'}; {host()}; {versions()}",
        f"medians of {repeats} (points that failed: one run); "
        f"time limit {options.limit:g} s of processor time per point",
        "relative tolerance tol, absolute tol x gap for displacements and tol x 300 gap/s for velocities; rsc: its own norm",
        f"measured in {(time.perf_counter() - begun) / 60.0:.1f} min",
    ]
    write(name, rows, notes, options.output)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--problems", nargs="+", default=None, choices=NAMES)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--limit", type=float, default=2.0, help="processor seconds a point may take")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", nargs="+", default=[""], help="methods whose names begin so")
    parser.add_argument(
        "--redraw", action="store_true", help="measure nothing: text and pictures from the CSV files that are there"
    )
    parser.add_argument("--output", type=Path, help="default: bench/results, of a short run out/bench")
    options = parser.parse_args()
    options.output = options.output or results_folder(options.quick)
    options.output.mkdir(parents=True, exist_ok=True)
    names = options.problems or (list(QUICK_SHARE) if options.quick else NAMES)
    known = {} if options.quick or options.redraw else first_calls(names)
    rows, notes = [], {}
    for name in names:
        if not options.redraw:
            run(name, options, known)
        mine, notes[name] = read(name, options.output)
        picture = work_precision_report.picture(name, mine, notes[name], options.limit)
        picture.savefig(options.output / f"work_precision_{name}.png", dpi=130)
        rows += mine
    text = work_precision_report.report(rows, notes)
    (options.output / "work_precision.txt").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
