"""Error against running time: rsc's kernel and the naive yardstick, interleaved, on P1, P1c and P2.

    python bench/speed.py [--repeats 5] [--problems P1 P1c P2] [--label NAME]

Error: the largest displacement error over the 2 kHz output grid, in gaps, against bench/reference.py (own error printed).
Time: processor time of the marching alone, medians; compilation happens before. Writes results/speed_LABEL.csv and prints the
ratios at equal error: time at error e, by log-log interpolation on the worst error of this or any tighter tolerance.
"""

import argparse
import csv
import platform
import subprocess
import time
from pathlib import Path

import numpy as np

from naive_kernel import naive_run
from problems import RATE, displacements, problem
from reference import reference_run
from rsc.assemble import assemble
from rsc.kernel import model as kernel
from rsc.kernel.march import march
from rsc.kernel.tableau import METHODS
from rsc.pack import pack
from rsc.run import _new_work
from rsc.start import initial_state

RESULTS = Path(__file__).parent / "results"
TOLERANCES = 10.0 ** -np.arange(2.0, 12.1, 0.5)
TARGETS = (1e-3, 1e-4, 1e-6, 1e-8)
CHUNK_STEPS = 20_000


class Rsc:
    """The kernel on a problem: everything but the marching is done before the clock starts."""

    def __init__(self, problem):
        self.problem, self.system = problem, assemble(problem.scene)
        self.start = initial_state(problem.scene, self.system)

    def __call__(self, tol):
        solver = self.problem.scene.solver
        packed = pack(self.system, type(solver)(**{**solver.__dict__, "rtol": tol, "max_steps": 10**9}), RATE)
        work = _new_work(packed, self.start)
        out = np.zeros((round(self.problem.duration * RATE) + 8, work.x.size + 3))
        begun = time.process_time()
        filled, code = 0, kernel.RUNNING
        while code == kernel.RUNNING:
            code, rows = march(packed.model, work, out[filled:], packed.lanes, METHODS[solver.method], CHUNK_STEPS)
            filled += rows
        spent = time.process_time() - begun
        assert code == kernel.FINISHED, code
        rows = round(self.problem.duration * RATE) + 1
        motion = np.hstack(packed.physical(out[:rows, :-3])) if filled >= rows else None
        count = work.count
        return spent, motion, int(count[kernel.STEPS]), int(count[kernel.RHS_CALLS] // 6 - count[kernel.STEPS])


class Naive:
    """The yardstick on a problem."""

    def __init__(self, problem):
        self.problem = problem

    def __call__(self, tol):
        begun = time.process_time()
        rows, accepted, rejected = naive_run(self.problem, tol, RATE)
        return time.process_time() - begun, displacements(rows, self.problem), accepted, rejected


def measure(name, repeats, solvers):
    """Rows (problem, solver, tolerance, error, seconds, steps, repeated steps) of one problem."""
    case = problem(name)
    reference = [displacements(reference_run(case, RATE, n)[0], case) for n in (12, 16)]
    gap = case.matrices.gap
    own = abs(reference[0] - reference[1]).max() / gap
    print(f"{name}: the reference's own error is {own:.1e} gaps")
    rows = []
    running = {label: make(case) for label, make in solvers.items()}
    for run in running.values():
        run(1e-2)
    for tol in TOLERANCES:
        found = {label: [] for label in running}
        for _ in range(repeats):
            for label, run in running.items():
                found[label].append(run(tol))
        for label, results in found.items():
            _, motion, steps, repeated = results[0]
            error = abs(motion - reference[1]).max() / gap
            seconds = float(np.median([result[0] for result in results]))
            rows.append((name, label, tol, error, seconds, steps, repeated, own))
    return rows


def time_at(rows, label, target):
    """Seconds at an error, or None when no tolerance reaches it."""
    mine = [row for row in rows if row[1] == label and np.isfinite(row[3])]
    error = np.maximum.accumulate([row[3] for row in mine][::-1])[::-1]
    seconds = np.array([row[4] for row in mine])
    below = np.flatnonzero(error <= target)
    if below.size == 0:
        return None
    i = below[0]
    if i == 0 or error[i] == error[i - 1]:
        return seconds[i]
    share = np.log(error[i - 1] / target) / np.log(error[i - 1] / error[i])
    return float(seconds[i - 1] * (seconds[i] / seconds[i - 1]) ** share)


def report(rows, labels, yardstick="naive"):
    """Print seconds of the yardstick and the ratios of the others at equal error."""
    for name in dict.fromkeys(row[0] for row in rows):
        mine = [row for row in rows if row[0] == name]
        for target in TARGETS:
            base = time_at(mine, yardstick, target)
            line = f"{name:4} at {target:.0e}: {yardstick} " + (f"{base:.4f} s" if base else "never")
            for label in labels:
                spent = time_at(mine, label, target)
                if label != yardstick and spent:
                    line += f", {label} {spent:.4f} s" + (f" = {spent / base:.3f}" if base else "")
            print(line)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--problems", nargs="+", default=["P1", "P1c", "P2"])
    parser.add_argument("--label", default="core")
    options = parser.parse_args()
    solvers = {"naive": Naive, "rsc": Rsc}
    rows = [row for name in options.problems for row in measure(name, options.repeats, solvers)]
    RESULTS.mkdir(exist_ok=True)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    with open(RESULTS / f"speed_{options.label}.csv", "w", newline="") as file:
        file.write(f"# commit {commit}, {platform.processor() or platform.machine()}, python {platform.python_version()}\n")
        writer = csv.writer(file)
        writer.writerow(["problem", "solver", "tolerance", "error_gaps", "seconds", "steps", "repeated", "reference_error"])
        writer.writerows(rows)
    report(rows, list(solvers))


if __name__ == "__main__":
    main()
