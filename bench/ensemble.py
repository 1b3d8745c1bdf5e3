"""P3: a thousand variants of P1 (2 s each, rtol 1e-6), case by case, on threads and in SIMD lanes: seconds and error.

    python bench/ensemble.py [--quick] [--cases 1000] [--repeats 3]

Every way runs the same cases and writes the same 2 kHz output; "simulate" and "simulate_many" begin with scenes and end with
results, the other ways are the integration alone; wall and processor time, the ways interleaved, least of the
repeats (on a busy machine only the processor time of the single-threaded ways means anything).
Error: largest displacement error in gaps of 20 of the cases against bench/reference.py. Writes ensemble.csv.
"""

import argparse
import csv
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import rsc
from peers.common import Absent, Outcome
from peers.own import Naive, PlainC, Rsc
from problems import RATE, VARIANTS, problem_of, results_folder, variants
from reference import solution

TOLERANCE = 1e-6
CHECKED = 20


def one_by_one(methods):
    """Outcomes of all cases, one after the other."""
    return [method(TOLERANCE) for method in methods]


def on_two_threads(methods):
    """Outcomes of all cases on two threads: compiled code lets go of the interpreter's lock."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(lambda method: method(TOLERANCE), methods, chunksize=16))


def ways(cases):
    """{name: function without arguments that runs every case}, and remarks on what is absent."""
    runs, remarks = {}, []
    ours = [Rsc(case) for case in cases]
    series = [Rsc(case, "taylor8") for case in cases]
    naive = [Naive(case) for case in cases]
    runs["rsc, one by one"] = lambda: one_by_one(ours)
    runs["rsc, two threads"] = lambda: on_two_threads(ours)
    runs["rsc taylor8, one by one"] = lambda: one_by_one(series)
    runs["naive Numba DP5, one by one"] = lambda: one_by_one(naive)
    try:
        plain = [PlainC(case) for case in cases]
        runs["plain C, one by one"] = lambda: one_by_one(plain)
    except Absent as cause:
        remarks.append(f"plain C absent: {cause}")
    scenes = [case.scene.with_values({"solver.rtol": TOLERANCE, "output.rate": RATE}) for case in cases]
    runs["simulate, one by one"] = lambda: [rsc.simulate(scene) for scene in scenes]
    for threads in (1, 2):
        runs[f"simulate_many, {threads} thread(s)"] = lambda threads=threads: rsc.simulate_many(scenes, threads=threads)
    # one at a time on a thread: the series does not go in lanes
    by_series = [scene.with_values({"solver.method": "taylor8"}) for scene in scenes]
    runs["simulate_many taylor8, 1 thread(s)"] = lambda: rsc.simulate_many(by_series, threads=1)
    return runs, remarks


def motion_of(outcome):
    """(samples, N + M) complex displacements of an Outcome or a Trajectory."""
    return outcome.motion if isinstance(outcome, Outcome) else np.hstack([outcome.rotor, outcome.stator])


def worst_error(outcomes, cases):
    """Largest error in gaps over the checked cases."""
    chosen = range(0, len(cases), max(len(cases) // CHECKED, 1))
    return max(float(abs(motion_of(outcomes[i]) - solution(cases[i]).motion).max() / cases[i].matrices.gap) for i in chosen)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="16 cases, once")
    parser.add_argument("--cases", type=int, default=VARIANTS)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    if options.quick:
        options.cases, options.repeats = 16, 1
    began = time.perf_counter()
    cases = [problem_of("P3", scene) for scene in variants(options.cases)]
    runs, remarks = ways(cases)
    spent = {name: [] for name in runs}
    errors = {}
    for name, run in runs.items():
        errors[name] = worst_error(run(), cases)  # compiles as well
    for _ in range(options.repeats):
        for name, run in runs.items():
            begun = time.perf_counter(), time.process_time()
            run()
            spent[name].append((time.perf_counter() - begun[0], time.process_time() - begun[1]))
    least = {name: np.array(pairs).min(axis=0).tolist() for name, pairs in spent.items()}
    base = least["rsc, one by one"]
    with open(results_folder(options.quick) / "ensemble.csv", "w", newline="") as file:
        for remark in remarks:
            file.write(f"# {remark}\n")
        writer = csv.writer(file)
        writer.writerow(["way", "cases", "wall_s", "processor_s", "wall_ratio", "processor_ratio", "largest_error_gaps"])
        for name, (wall, processor) in least.items():
            row = [name, len(cases), wall, processor, wall / base[0], processor / base[1], errors[name]]
            writer.writerow(f"{item:.6g}" if isinstance(item, float) else item for item in row)
            ratios = f"{row[4]:.3f} and {row[5]:.3f} of rsc one by one"
            print(f"{name:30} wall {wall:8.3f} s, processor {processor:8.3f} s, {ratios}, error {errors[name]}")
    print("\n".join([*remarks, f"{time.perf_counter() - began:.0f} s"]))


if __name__ == "__main__":
    main()
