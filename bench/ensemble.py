"""P3: a thousand variants of P1 (2 s each, rtol 1e-6), case by case and on threads: seconds and error.

    python bench/ensemble.py [--quick] [--cases 1000] [--repeats 3] [--give-back]

Every way runs the same cases and writes the same 2 kHz output. "simulate" and "simulate_many" begin with scenes and end with
results; "march" is the integration alone, by the compiled code that these two call; naive and C as well, with their few
preparations. Wall and processor time, the ways interleaved, least of the repeats (on a busy machine only the processor time of
the single-threaded ways means anything).
Error: largest displacement error in gaps of 20 of the cases, in a first untimed run, against bench/reference.py. Writes
ensemble.csv.
"""

import argparse
import csv
import ctypes
import time
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

import rsc
from peers.common import Absent, Outcome
from peers.own import Naive, PlainC, Rsc
from problems import RATE, VARIANTS, problem_of, results_folder, variants
from reference import solution

TOLERANCE = 1e-6
CHECKED = 20
# of glibc's mallopt: sizes in bytes above which memory comes apart (M_MMAP_THRESHOLD), above which free memory is given back
# (M_TRIM_THRESHOLD); arenas (M_ARENA_MAX)
M_KEPT = {-3: 2**25, -1: 2**31 - 1, -8: 1}
# the faster way and the slower one whose processor (one thread) or wall time (two) it is compared with
GAINS = (
    ("march, 2 threads", "march, 1 thread", "wall"),
    ("march taylor8, 1 thread", "march, 1 thread", "processor"),
    ("simulate_many, 1 thread", "simulate, one by one", "processor"),
    ("simulate_many, 2 threads", "simulate_many, 1 thread", "wall"),
)


class Way(NamedTuple):
    """A way to run all cases: what is not timed, then what is; `results` turns what that returns into motions, case by case."""

    prepare: object
    run: object
    results: object


def on_threads(threads, function, items):
    """Results of a function, on some threads: compiled code lets go of the interpreter's lock."""
    if threads == 1:
        return [function(item) for item in items]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, items))


def from_scenes(run):
    """A way that begins with scenes and ends with results."""
    return Way(lambda: None, lambda _: run(), lambda outcomes: [motion_of(outcome) for outcome in outcomes])


def marching(methods, threads):
    """The kernel alone, case by case."""
    motions = [method.problem.times.size for method in methods]

    def run(prepared):
        on_threads(threads, lambda pair: pair[0].march(pair[1]), list(zip(methods, prepared, strict=True)))
        return prepared

    def results(done):
        return [np.hstack(packed.physical(out[:rows, :-3])) for (packed, _, out), rows in zip(done, motions, strict=True)]

    return Way(lambda: [method.prepared(TOLERANCE) for method in methods], run, results)


def ways(cases):
    """{name: Way}, and remarks on what is absent."""
    runs, remarks = {}, []
    ours, series = [Rsc(case) for case in cases], [Rsc(case, "taylor8") for case in cases]
    scenes = [case.scene.with_values({"solver.rtol": TOLERANCE, "output.rate": RATE}) for case in cases]
    runs["march, 1 thread"] = marching(ours, 1)
    runs["march, 2 threads"] = marching(ours, 2)
    runs["march taylor8, 1 thread"] = marching(series, 1)
    by_series = [scene.with_values({"solver.method": "taylor8"}) for scene in scenes]
    naive = [Naive(case) for case in cases]
    runs["naive Numba DP5, one by one"] = from_scenes(lambda: [method(TOLERANCE) for method in naive])
    try:
        plain = [PlainC(case) for case in cases]
        runs["plain C, one by one"] = from_scenes(lambda: [method(TOLERANCE) for method in plain])
    except Absent as cause:
        remarks.append(f"plain C absent: {cause}")
    runs["simulate, one by one"] = from_scenes(lambda: [rsc.simulate(scene) for scene in scenes])
    for threads, name in ((1, "simulate_many, 1 thread"), (2, "simulate_many, 2 threads")):
        runs[name] = from_scenes(lambda threads=threads: rsc.simulate_many(scenes, threads=threads))
    runs["simulate_many taylor8, 1 thread"] = from_scenes(lambda: rsc.simulate_many(by_series, threads=1))
    return runs, remarks


def motion_of(outcome):
    """(samples, N + M) complex displacements of an Outcome or a Trajectory."""
    return outcome.motion if isinstance(outcome, Outcome) else np.hstack([outcome.rotor, outcome.stator])


def worst_error(motions, cases):
    """Largest error in gaps over cases."""
    pairs = zip(motions, cases, strict=True)
    return max(float(abs(motion - solution(case).motion).max() / case.matrices.gap) for motion, case in pairs)


def timed(way):
    """(wall s, processor s) of a way, and what it made."""
    prepared = way.prepare()
    begun = time.perf_counter(), time.process_time()
    done = way.run(prepared)
    return (time.perf_counter() - begun[0], time.process_time() - begun[1]), done


def keep_memory():
    """Have the C library keep what is freed, in one arena: a virtual machine's host may take free pages back and give them again
    at a high price, which is the cost of no way; from the second repeat on all ways use what the first got."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):  # not glibc
        return
    for setting, value in M_KEPT.items():
        mallopt(setting, value)


def write(least, errors, n_cases, remarks, folder):
    """The table as CSV and on the screen."""
    base = least["march, 1 thread"]
    with open(folder / "ensemble.csv", "w", newline="") as file:
        writer = csv.writer(file)
        for remark in remarks:
            file.write(f"# {remark}\n")
        writer.writerow(["way", "cases", "wall_s", "processor_s", "wall_ratio", "processor_ratio", "largest_error_gaps"])
        for name, (wall, processor) in least.items():
            row = [name, n_cases, wall, processor, wall / base[0], processor / base[1], errors[name]]
            writer.writerow(f"{item:.6g}" if isinstance(item, float) else item for item in row)
            ratios = f"{row[4]:.3f} and {row[5]:.3f} of march, 1 thread"
            print(f"{name:32} wall {wall:8.3f} s, processor {processor:8.3f} s, {ratios}, error {errors[name]:.2g}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="16 cases, once")
    parser.add_argument("--cases", type=int, default=VARIANTS)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--give-back", action="store_true", help="let the C library give freed memory back, as it does by itself")
    options = parser.parse_args()
    if options.quick:
        options.cases, options.repeats = 16, 1
    began = time.perf_counter()
    if not options.give_back:
        keep_memory()
    cases = [problem_of("P3", scene) for scene in variants(options.cases)]
    # the first time compiles as well
    checked = cases[:: max(len(cases) // CHECKED, 1)]
    errors = {name: worst_error(way.results(timed(way)[1]), checked) for name, way in ways(checked)[0].items()}
    runs, remarks = ways(cases)
    spent = {name: [] for name in runs}
    for _ in range(options.repeats):
        for name, way in runs.items():
            spent[name].append(timed(way)[0])
    least = {name: np.array(pairs).min(axis=0).tolist() for name, pairs in spent.items()}
    for faster, slower, clock in GAINS:
        k = 0 if clock == "wall" else 1
        remarks.append(f"{faster}: {least[slower][k] / least[faster][k]:.2f} times as fast as {slower} ({clock} time)")
    write(least, errors, len(cases), remarks, results_folder(options.quick))
    print("\n".join([*remarks, f"{time.perf_counter() - began:.0f} s"]))


if __name__ == "__main__":
    main()
