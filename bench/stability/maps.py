"""Stability maps: contact stiffness against step size (RK4, Newmark) and against tolerance (rsc).

    python bench/stability/maps.py [--quick]

Two scenes of the hard dozen, impacts on a rigid wall (S1) and a sustained rub (S2), over contact stiffnesses of 10 to 1e7 rotor
stiffnesses; the oracles are those of the dozen. Every attempt is a row of results/maps.csv; the pictures are
docs/images/map_fixed_step.png and results/map_rsc.png.
"""

import argparse
import csv
import os
import platform
import time
from importlib.metadata import version

import numpy as np
from dozen import RSC, classify, compile_fixed, make
from fixed_step import fixed_step
from hard_scenes import K_R, RIGID, Setting, tables
from maps_picture import fixed_picture, rsc_picture
from oracles import ORACLES

import rsc
from problems import pictures_folder, results_folder

RATE = 1000.0  # output grid, 1/s
IMPACTS, SUSTAINED = "impacts", "sustained rub"
ZETA = 0.05  # of the contact
# coefficients of the stability polynomial of Dormand-Prince 5(4): the propagating solution
DP5 = (1.0, 1.0, 1 / 2, 1 / 6, 1 / 24, 1 / 120, 1 / 600)
RK4 = (1.0, 1.0, 1 / 2, 1 / 6, 1 / 24)


def stability_limit(polynomial, eigenvalue):
    """Largest h in s for which |R(h lambda)| <= 1, scanned from 0 on."""
    h = np.linspace(0.0, 4.0, 40_001)[1:] / abs(eigenvalue)
    outside = np.flatnonzero(np.abs(np.polyval(polynomial[::-1], h * eigenvalue)) > 1.0 + 1e-12)
    return float(h[outside[0]]) if outside.size else float(h[-1])


def contact_mode(case):
    """Eigenvalue, 1/s, of the fastest oscillation with the contact closed and half of its damper."""
    s = case.system
    n = s.n_rotor + s.n_stator
    row = s.relative
    mass, damping, stiffness = (np.zeros((n, n)) for _ in range(3))
    for name, whole in (("mass", mass), ("damping", damping), ("stiffness", stiffness)):
        whole[: s.n_rotor, : s.n_rotor] = getattr(s.rotor, name)
        whole[s.n_rotor :, s.n_rotor :] = getattr(s.stator, name)
    stiffness += s.law.stiffness * np.outer(row, row)
    damping += 0.5 * s.law.damping * np.outer(row, row)
    inverse = np.linalg.inv(mass)
    matrix = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    values = np.linalg.eigvals(matrix)
    return values[np.argmax(abs(values))]


def setting_of(scene, ratio):
    """Setting of a scene at k_C / k_R."""
    k_c = ratio * K_R
    if scene == IMPACTS:
        content = tables(
            stator=RIGID, start={"rotor_velocity": [[0.6, 0.0]]}, rotor__eccentricity=0.0, contact__friction=0.0,
            contact__stiffness=k_c, contact__damping=2.0 * ZETA * np.sqrt(k_c), drive__speed=0.0, drive__duration=0.05,
            output__rate=RATE,
        )  # fmt: skip
        return Setting("S1", f"{ratio:.3g}", content, "line")
    fastest = np.sqrt(k_c / 0.2)
    content = tables(
        start={"whirl": -60.66}, contact__stiffness=k_c, contact__damping=2.0 * ZETA * np.sqrt(k_c * 0.2), drive__duration=0.05,
        output__rate=RATE,
    )  # fmt: skip
    return Setting("S2", f"{ratio:.3g}", content, "reference", options={"fastest": max(fastest, 5e3)})


def fixed_rows(scene, case, oracle, steps, common):
    """Attempts of RK4 and Newmark over the step sizes."""
    for method in ("RK4", "Newmark"):
        for every in steps:
            h = 1.0 / (RATE * every)
            found = fixed_step(method, case.plain, case.start, h, case.grid, 20.0)
            motion = found.states[:, : case.start.size // 2]
            complete = len(motion) == case.grid[1]
            with np.errstate(all="ignore"):
                error = oracle.error(motion) if complete else np.nan
                verdict = classify(found.end, complete, np.abs(motion).max(), error, oracle.scale, 1e-2)
            yield {**common, "method": method, "h_s": h, "rtol": "", "class": verdict, "error": error, "steps": found.calls,
                   "onsets": "", "seconds": found.seconds}  # fmt: skip


def rsc_rows(scene, case, oracle, tolerances, common):
    """Attempts of rsc over the tolerances."""
    for rtol in tolerances:
        begun = time.perf_counter()
        result = rsc.simulate(case.scene.with_values({"solver.rtol": float(rtol), "solver.max_steps": 20_000_000}))
        motion = np.hstack([result.rotor, result.stator])
        complete = len(motion) == case.grid[1]
        error = oracle.error(motion) if complete else np.nan
        end = str(result.status)
        verdict = classify(end, complete, np.abs(motion).max(initial=0.0), error, oracle.scale, 1e3 * rtol)
        mean = case.time[-1] / result.steps if scene == SUSTAINED else result.summary.contact_time / result.steps
        yield {**common, "method": RSC[0], "h_s": mean, "rtol": rtol, "class": verdict, "error": error, "steps": result.steps,
               "onsets": result.contact_onsets, "seconds": time.perf_counter() - begun}  # fmt: skip


def measure(scene, ratios, steps, tolerances):
    """All rows of one scene."""
    rows = []
    for ratio in ratios:
        case = make(setting_of(scene, ratio))
        oracle = ORACLES[case.setting.oracle](case, **case.setting.options)
        mode = contact_mode(case)
        common = {
            "scene": scene, "stiffness_ratio": ratio, "contact_frequency_rad_s": abs(mode), "oracle_error": oracle.own_error,
            "limit_rk4_s": stability_limit(RK4, mode), "limit_dp5_s": stability_limit(DP5, mode),
        }  # fmt: skip
        rows += fixed_rows(scene, case, oracle, steps, common)
        rows += rsc_rows(scene, case, oracle, tolerances, common)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a coarse map")
    options = parser.parse_args()
    begun = time.perf_counter()
    ratios = np.logspace(1, 7, 5 if options.quick else 19)
    steps = np.unique(np.round(np.logspace(0, 3 if options.quick else 3.3, 7 if options.quick else 25))).astype(int)
    tolerances = np.logspace(-12, -2, 6 if options.quick else 21)
    compile_fixed()
    rows = [row for scene in (IMPACTS, SUSTAINED) for row in measure(scene, ratios, steps, tolerances)]
    folder = results_folder(options.quick)
    caption = f"rsc {version('rotor-stator-contact')}, numpy {np.__version__}, {platform.machine()}, {os.cpu_count()} cores"
    with open(folder / "maps.csv", "w", newline="") as file:
        file.write(f"# {caption}\n")
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    fixed_picture(rows, (IMPACTS, SUSTAINED), pictures_folder(options.quick) / "map_fixed_step.png", caption)
    rsc_picture(rows, (IMPACTS, SUSTAINED), RSC[0], folder / "map_rsc.png", caption)
    print(f"{len(rows)} attempts in {time.perf_counter() - begun:.0f} s")
    for method in (*RSC[:1], "RK4", "Newmark"):
        mine = [row["class"] for row in rows if row["method"] == method]
        told = ", ".join(f"{mine.count(name)} {name}" for name in dict.fromkeys(mine))
        print(f"  {method}: {told}, of {len(mine)}")
    for row in rows:
        if row["method"] == RSC[0] and row["class"] != "right":
            where = f"{row['scene']}, k_C/k_R {row['stiffness_ratio']:.3g}, rtol {row['rtol']:.1e}"
            print(f"  rsc {row['class']}: {where}: error {row['error']:.1e}")


if __name__ == "__main__":
    main()
