"""What each trick of the kernel is worth: the sources with one trick taken out, timed beside the sources as they are.

    python bench/ablation.py [--problems P1 P1c] [--tol 1e-6] [--only NAME ...]

Prints nanoseconds per attempted step (least of 9 runs, in rounds, so that another load on the machine hits all alike), steps and
error; writes results/ablation.csv. A patch that no longer fits the sources is an error.
"""

import argparse
import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
RESULTS = Path(__file__).parent / "results"

LIBRARY_SINE = """    c, s = vec.spread(0.0, phase), vec.spread(0.0, phase)
    for i in range(8 if vec.width(phase) == 8 else 1):
        if 3 < i < 7:  # Dormand-Prince has four nodes inside the step; the end is lane 7
            continue
        c = vec.put(c, i, math.cos(TWO_PI * vec.lane(phase, i)))
        s = vec.put(s, i, math.sin(TWO_PI * vec.lane(phase, i)))
    return c, s
"""

# name: [(file, text, text instead), ...]
PATCHES = {
    "as it is": [],
    "sine and cosine by the library in every stage": [
        ("turn.py", "    halves = vec.whole(2.0 * phase)\n", LIBRARY_SINE + "    halves = vec.whole(2.0 * phase)\n")
    ],
    "step-size power by the library": [
        ("control.py", "max(log2_roughly(error2), -40.0)", "max(math.log2(error2), -40.0)"),
        ("control.py", "_exp2(min(max(power, -2.3), 2.3))", "2.0 ** min(max(power, -2.3), 2.3)"),
        ("control.py", "from rsc.kernel import vec\n", "import math\n\nfrom rsc.kernel import vec\n"),
    ],
    "force waits for the velocity in every mode": [("rhs.py", "separating = law.b > 0.0", "separating = law.b >= 0.0")],
    "division by the scale after the errors": [
        ("step.py", "pair_square(e_x) * weight_x", "pair_square(e_x) * one / (one / weight_x)"),
        ("step.py", "pair_square(e_v) * weight_v", "pair_square(e_v) * one / (one / weight_v)"),
    ],
    "no energy ledger": [
        ("step.py", "        if weight != 0.0:\n", "        if weight > 1e9:\n"),
    ],
    "switches passed over": [
        ("switches.py", "    if g_end < 0.0:\n", "    if g_end < 2.0:\n        return 0.0\n    if g_end < 0.0:\n")
    ],
    "switches met to rounding": [("switches.py", "if defect2 <= tol2:", "if defect2 <= 1e-12 * tol2:")],
    "a step length about right is not kept": [("march.py", "KEEP_FROM, KEEP_TO = 0.2, 0.6", "KEEP_FROM, KEEP_TO = 1.0, 0.0")],
    "controller without memory": [("control.py", "BETA = 0.04", "BETA = 0.0")],
    "one step length for contact and free flight": [("march.py", "Pace(pace.h_other, pace.h, ", "Pace(pace.h, pace.h, ")],
}

WORKER = """
import json, sys
sys.path.insert(0, sys.argv[1])
import numpy as np
from problems import RATE, displacements, problem
from reference import reference_run
from speed import Rsc
cases = {}
for line in sys.stdin:
    name, tol = json.loads(line)
    if name not in cases:
        case = problem(name)
        cases[name] = Rsc(case), displacements(reference_run(case, RATE, 12)[0], case), case.matrices.gap
    run, exact, gap = cases[name]
    try:
        spent, motion, steps, repeated = run(tol)
    except AssertionError:
        print(json.dumps([float("nan"), 1, 0, float("nan")]), flush=True)
        continue
    error = float(abs(motion - exact).max() / gap)
    print(json.dumps([spent, steps, repeated, error]), flush=True)
"""


def patched(folder, patches):
    """A copy of src/ with patches applied to the kernel."""
    shutil.copytree(ROOT / "src", folder)
    for name, old, new in patches:
        path = folder / "rsc" / "kernel" / name
        text = path.read_text()
        if old not in text:
            raise SystemExit(f"the patch {old!r} does not fit {name}")
        path.write_text(text.replace(old, new))
    return folder


class Worker:
    """A process that runs one variant of the kernel."""

    def __init__(self, folder):
        environment = {**os.environ, "PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}
        command = [sys.executable, "-c", WORKER, str(Path(__file__).parent)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)

    def ask(self, name, tol):
        print(json.dumps([name, tol]), file=self.process.stdin, flush=True)

    def answer(self):
        return json.loads(self.process.stdout.readline())

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--problems", nargs="+", default=["P1", "P1c"])
    parser.add_argument("--tol", type=float, default=1e-6)
    parser.add_argument("--only", nargs="+")
    options = parser.parse_args()
    names = [name for name in PATCHES if name == "as it is" or not options.only or name in options.only]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        workers = {name: Worker(patched(Path(folder) / str(i), PATCHES[name])) for i, name in enumerate(names)}
        for case in options.problems:
            # all compile at once
            for worker in workers.values():
                worker.ask(case, options.tol)
            for worker in workers.values():
                worker.answer()
            found = {name: [] for name in names}
            for _ in range(9):
                for name, worker in workers.items():
                    worker.ask(case, options.tol)
                    found[name].append(worker.answer())
            for name, results in found.items():
                seconds, (_, steps, repeated, error) = min(row[0] for row in results), results[0]
                rows.append((case, name, options.tol, seconds, steps, repeated, error))
                each = 1e9 * seconds / (steps + repeated)
                counts = f"{steps:7} + {repeated:6} steps  {seconds:.4f} s  error {error:.1e}"
                print(f"{case:4}{name:48}{each:6.0f} ns  {counts if error == error else 'diverged'}", flush=True)
        for worker in workers.values():
            worker.close()
    RESULTS.mkdir(exist_ok=True)
    with open(RESULTS / "ablation.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["problem", "variant", "tolerance", "seconds", "steps", "repeated", "error_gaps"])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
