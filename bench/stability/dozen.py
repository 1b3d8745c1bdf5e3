"""The hard dozen: twelve scenes where methods fail, and what happened to each method.

    python bench/stability/dozen.py [--quick] [--scenes S1 S8]

Every attempt is a row of results/dozen.csv and a field of docs/images/dozen.png; an attempt is judged by the oracle of its scene
(oracles.py), never by another method. All methods get rtol 1e-6 or their fixed step and the same limit of processor time.
"""

import argparse
import contextlib
import csv
import os
import platform
import signal
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from importlib.metadata import version
from typing import NamedTuple

import numba
import numpy as np
import scipy
from fixed_step import SCIPY, Attempt, Plain, fixed_step, plain, scipy_run
from hard_scenes import SCENES, SETTINGS
from oracles import ORACLES

import rsc
from problems import pictures_folder, results_folder
from rsc.kernel.tableau import METHODS
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from rsc.system.blas import one_thread

RSC = tuple(f"rsc {method}" for method in METHODS)
FIXED = ("RK4", "Newmark")
LIMIT, QUICK_LIMIT = 4.0, 0.5
# of these scenes the setting of that number
QUICK = {"S1": -1, "S3": -1, "S7": -1, "S8": 1, "S12": 0}
# fixed steps promise no tolerance: one per cent of the motion counts as right
FIXED_LIMIT = 1e-2
# of the largest true displacement
BLOW_UP = 1e3

RIGHT, WRONG, HONEST, NAN, BLOWN, TIME, REFUSED, STIFF = "right", "wrong", "honest", "nan", "blow-up", "time", "refused", "stiff"
CLASSES = {
    WRONG: ("W", "wrong answer reported as success"),
    NAN: ("N", "NaN"),
    BLOWN: ("B", "blow-up"),
    HONEST: ("H", "stopped with a reason"),
    TIME: ("T", "time limit"),
    STIFF: ("S", "refused: stiff"),
    REFUSED: ("R", "refused before the start"),
    RIGHT: ("", "right"),
}


class Case(NamedTuple):
    """A setting made ready; scene is None where rsc refuses it, refusal says why."""

    setting: object
    scene: object
    refusal: str
    system: object
    plain: Plain
    start: np.ndarray  # (2n,) complex
    grid: tuple  # rate Hz, rows
    time: np.ndarray
    rtol: float


def make(setting):
    """Case of a setting."""
    scene, refusal = rsc.Scene.from_dict(setting.tables), ""
    system = assemble(scene)
    state = initial_state(scene, system)
    rtol, gap = scene.solver.rtol, system.contact.gap
    if setting.zero_gap:
        system = replace(system, contacts=(replace(system.contact, gap=0.0),))
        try:
            scene = scene.with_values({"contact.gap": 0.0})
        except rsc.SceneError as error:
            scene, refusal = None, str(error)
    rate = setting.tables["output"]["rate"]
    rows = round(system.schedule_time[-1] * rate) + 1
    start = np.concatenate([state.rotor, state.stator, state.rotor_velocity, state.stator_velocity])
    p = plain(system)
    assert setting.zero_gap or p.gap == gap
    return Case(setting, scene, refusal, system, p, start, (rate, rows), np.arange(rows) / rate, rtol)


def classify(end, complete, motion, error, oracle_scale, limit):
    """The class of an attempt.

    end : "finished", "time limit", "refused", "stiff", or why the method itself stopped
    complete : whether every row of the output was reached
    motion : largest |displacement| reached, m (NaN when any is not finite)
    error, limit : of the oracle's measure; oracle_scale : m
    """
    if end in ("refused", "stiff"):
        return end
    if not np.isfinite(motion) or end == "NaN":
        return NAN
    if end == "blow-up" or (motion > BLOW_UP * oracle_scale and end in ("finished", "time limit")):
        return BLOWN
    if end == "time limit":
        return TIME
    if end != "finished" or not complete:
        return HONEST
    # written so that a NaN is wrong
    return RIGHT if error <= limit else WRONG


@contextlib.contextmanager
def stopped_after(seconds):
    """Interrupt rsc as Ctrl-C would, after so many seconds of processor time."""
    before = signal.signal(signal.SIGPROF, lambda *_: signal.raise_signal(signal.SIGINT))
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def run_rsc(case, method, limit):
    """Attempt by rsc."""
    if case.scene is None:
        return Attempt("refused", np.zeros((0, case.start.size), complex), 0, 0.0, case.refusal)
    scene = case.scene.with_values({"solver.method": method})
    rsc.simulate(scene.with_values({"drive.speed": scene.drive.speed[0], "drive.duration": 1e-3}))  # compiled before the clock
    begun = time.process_time()
    with stopped_after(limit):
        try:
            result = rsc.simulate(scene)
        except KeyboardInterrupt as stop:
            result = stop.result
    spent = time.process_time() - begun
    motion = np.hstack([result.rotor, result.stator])
    end = "time limit" if result.status == "interrupted" else str(result.status)
    return Attempt(end, motion, result.rhs_calls, spent, result.summary.advice)


def attempt(case, method, limit):
    """Attempt by any method."""
    if method.startswith("rsc "):
        return run_rsc(case, method.removeprefix("rsc "), limit)
    if method in FIXED:
        return fixed_step(method, case.plain, case.start, case.setting.h, case.grid, limit)
    scale = case.plain.gap or case.setting.tables["contact"]["gap"]
    return scipy_run(method, case.plain, case.start, case.rtol, case.grid, limit, scale)


def judge(case, method, oracle, found):
    """Row of the table."""
    n, rows = case.start.size // 2, case.grid[1]
    motion = found.states[:, :n]
    complete = len(motion) >= rows
    with np.errstate(all="ignore"):
        error = oracle.error(motion[:rows]) if complete else np.nan
        size = np.abs(motion).max(initial=0.0)
    limit = max(oracle.limit, FIXED_LIMIT) if method in FIXED else oracle.limit
    verdict = classify(found.end, complete, size, error, oracle.scale, limit)
    reached = (len(motion) - 1) / case.grid[0] if len(motion) else 0.0
    return {
        "scene": case.setting.scene, "name": SCENES[case.setting.scene], "setting": case.setting.label, "method": method,
        "class": verdict, "letter": CLASSES[verdict][0], "error": error, "limit": limit, "oracle": oracle.name,
        "oracle_error": oracle.own_error, "end": found.end, "reached_s": reached, "duration_s": case.time[-1],
        "calls": found.calls, "seconds": found.seconds, "note": found.note,
    }  # fmt: skip


@one_thread  # others would wait for work on the processors of other settings, and their time counts
def attempts(job):
    """Rows of all methods on one setting; job = (its number, limit in s of processor time)."""
    number, limit = job
    case = make(SETTINGS[number])
    oracle = ORACLES[case.setting.oracle](case, **case.setting.options)
    return [judge(case, method, oracle, attempt(case, method, limit)) for method in (*RSC, *SCIPY, *FIXED)]


def compile_fixed():
    """Compile the fixed-step methods before any clock runs."""
    case = make(SETTINGS[0])
    for method in FIXED:
        fixed_step(method, case.plain, case.start, 2e-5, (case.grid[0], 11), 1.0)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one setting of five scenes, short time limit")
    parser.add_argument("--scenes", nargs="+", default=list(SCENES))
    options = parser.parse_args()
    begun, limit = time.perf_counter(), QUICK_LIMIT if options.quick else LIMIT
    settings = [s for s in SETTINGS if s.scene in options.scenes]
    if options.quick:
        settings = [[s for s in SETTINGS if s.scene == name][i] for name, i in QUICK.items() if name in options.scenes]
    rows = []
    # nothing here is timed but for the limit, so every processor may take a setting
    with ProcessPoolExecutor(initializer=compile_fixed) as pool:
        for mine in pool.map(attempts, [(SETTINGS.index(setting), limit) for setting in settings]):
            rows += mine
            told = ", ".join(f"{r['method']} {r['letter'] or 'right'} {r['error']:.0e}" for r in mine)
            place = "{scene} {setting} ({oracle}, own error {oracle_error:.0e})".format_map(mine[0])
            print(f"{place}: {told}", flush=True)
    write(rows, options.quick, limit)
    wrong = [r for r in rows if r["class"] == WRONG and r["method"] in RSC]
    print(f"{len(rows)} attempts in {time.perf_counter() - begun:.0f} s; rsc: {len(wrong)} wrong answers reported as success")
    for row in wrong:
        print(f"  {row['method']} {row['scene']} {row['setting']}: error {row['error']:.2e}, allowed {row['limit']:.0e}")


def write(rows, quick, limit):
    """CSV and picture of all attempts."""
    from dozen_picture import picture

    host = f"{platform.machine()}, {os.cpu_count()} cores, python {platform.python_version()}, numba {numba.__version__}"
    versions = f"rsc {version('rotor-stator-contact')}, scipy {scipy.__version__}, numpy {np.__version__}, {host}"
    with open(results_folder(quick) / "dozen.csv", "w", newline="") as file:
        file.write(f"# {versions}; limit {limit:g} s of processor time an attempt\n")
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    picture(rows, CLASSES, pictures_folder(quick) / "dozen.png", f"{versions}; limit {limit:g} s of processor time an attempt")


if __name__ == "__main__":
    main()
