"""Physics that a tolerance changes: the delayed jump of a run-up, and how long and in which sense a chaotic rub is reproduced.

    python bench/stability/physics.py [--quick]

Writes results/physics_jump.csv, physics_chaos.csv and physics.png, and prints both tables.
"""

import argparse
import csv
import os
import platform
import time
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from pathlib import Path

import numpy as np
from hard_scenes import chaotic
from oracles import ks_distance
from physics_picture import picture

import rsc
from problems import results_folder
from rsc.analysis.survey.survey import survey

SCENE = Path(__file__).parents[2] / "data" / "reference" / "gyroscopic_transition.toml"
DURATIONS = (60.0, 120.0, 270.0, 480.0)
JUMP_TOLERANCES, TOLERANCES = tuple(10.0 ** -np.arange(2.0, 9.1)), tuple(10.0 ** -np.arange(2.0, 11.1))
SPEED, STATE_RATE = 60.0, 12_000.0  # Hz: of the chaotic rub, and of the samples from which its states are taken
HORIZON = 1e-2  # of the gap: beyond this difference two runs no longer agree
TURNS, DISCARDED, PER_TURN = 20_000, 500, 7  # samples per turn: a number that no short period divides
BLOCKS, DRAWS, ALARM = 32, 400, 0.01


def jumps(durations, tolerances):
    """Rows: run-up, tolerance, first seen and takes over, Hz, beside the prediction."""
    rows = []
    for duration in durations:
        scene = rsc.load_scene(SCENE).with_values({"drive.duration": duration})
        delay = survey(scene).delays["A"]
        print(f"run-up in {duration:g} s", flush=True)
        for rtol in tolerances:
            begun = time.perf_counter()
            found = rsc.check(scene.with_values({"solver.rtol": float(rtol)})).transitions
            change = found[0] if found else None
            rows.append({
                "duration_s": duration, "rate_hz_per_s": 130.0 / duration, "rtol": rtol,
                "first_seen_hz": change.first_seen if change else np.nan, "jump_hz": change.taken_over if change else np.nan,
                "changes": len(found), "predicted_first_seen_hz": delay.first_seen, "predicted_jump_hz": delay.jump,
                "crossing_hz": delay.crossing, "undisturbed_hz": delay.undisturbed, "source": delay.source,
                "seconds": time.perf_counter() - begun,
            })  # fmt: skip
    return rows


def scene_of(turns, rtol, rate, state=None, friction=None):
    """The chaotic rub; state: (r_R, r_R', r_S, r_S') complex at a full turn."""
    content = chaotic(turns)
    content["solver"]["rtol"], content["output"]["rate"] = float(rtol), rate
    if friction is not None:
        content["contact"]["friction"] = friction
    if state is not None:
        names = ("rotor", "rotor_velocity", "stator", "stator_velocity")
        content["start"] = {name: [[z.real, z.imag]] for name, z in zip(names, state, strict=True)} | {"allow_penetration": True}
    return rsc.Scene.from_dict(content)


def states_on_attractor(turns):
    """States at full turns of a long run; velocities by a sixth-order difference of dense samples."""
    result = rsc.simulate(scene_of(max(turns) + 1, 1e-8, STATE_RATE))
    found = []
    for turn in turns:
        i = round(turn / SPEED * STATE_RATE)
        state = []
        for motion in (result.rotor[:, 0], result.stator[:, 0]):
            w = motion[i - 3 : i + 4]
            state += [complex(motion[i]), complex((w @ np.array([-1, 9, -45, 0, 45, -9, 1])) / 60.0 * STATE_RATE)]
        found.append(tuple(state))
    return found


def growth_per_turn(states):
    """Lyapunov exponent per turn: mean growth of a shadow run's distance from 1e-6 to 1e-2 gaps, and the mean's error."""
    rates = []
    for state in states:
        pair = [rsc.simulate(scene_of(200, 1e-12, 600.0, (state[0] + shift, *state[1:]))) for shift in (0.0, 1e-10)]
        apart = np.abs(pair[0].rotor - pair[1].rotor)[:, 0] / 1e-3
        low, high = (int(np.argmax(apart > level)) for level in (1e-6, HORIZON))
        rates.append(np.log(apart[high] / apart[low]) / ((high - low) / 600.0 * SPEED))
    return float(np.mean(rates)), float(np.std(rates, ddof=1) / np.sqrt(len(rates)))


def horizons(states, tolerances):
    """Turns until a run differs from one at rtol 1e-13 by 1 % of the gap: rtol -> turns of every start."""
    rate, found = 600.0, {rtol: [] for rtol in tolerances}
    for state in states:
        best = rsc.simulate(scene_of(200, 1e-13, rate, state)).rotor[:, 0]
        for rtol in tolerances:
            apart = np.abs(rsc.simulate(scene_of(200, rtol, rate, state)).rotor[:, 0] - best) / 1e-3
            over = np.flatnonzero(apart > HORIZON)
            found[rtol].append((over[0] if over.size else apart.size) / rate * SPEED)
    return found


def radii(turns, rtol, friction=None):
    """|r| / gap at PER_TURN samples a turn, without the beginning."""
    result = rsc.simulate(scene_of(turns, rtol, PER_TURN * SPEED, friction=friction))
    assert result.status == "finished", result.summary.advice
    return np.abs(result.rotor[DISCARDED * PER_TURN :, 0]) / 1e-3


def alarm_level(values):
    """KS distance exceeded with probability ALARM by two runs of the same process: blocks of the pooled runs, drawn again."""
    generator = np.random.default_rng(1)
    blocks = [piece for run in values for piece in np.array_split(run, BLOCKS)]
    drawn = []
    for _ in range(DRAWS):
        one, two = (np.concatenate([blocks[i] for i in generator.integers(0, len(blocks), BLOCKS)]) for _ in range(2))
        drawn.append(ks_distance(one[::5], two[::5]))
    return float(np.quantile(drawn, 1.0 - ALARM))


def period_of(values):
    """Turns after which the motion repeats to 1e-3 gaps at the end of a run (1 to 12), or 0: the label of the attractor."""
    last = values[-200 * PER_TURN :]
    for turns in range(1, 13):
        if np.abs(last[turns * PER_TURN :] - last[: -turns * PER_TURN]).max() < 1e-3:
            return turns
    return 0


def chaos(tolerances, turns, starts):
    """(rows per tolerance, facts)."""
    print("chaotic rub", flush=True)
    states = states_on_attractor([600 + 37 * k for k in range(starts)])
    growth, spread = growth_per_turn(states)
    agreement = horizons(states, tolerances)
    runs = {rtol: radii(turns, rtol) for rtol in tolerances}
    level = alarm_level([runs[rtol] for rtol in tolerances if rtol <= 1e-4])
    best = runs[min(tolerances)]
    rows = [
        {
            "rtol": rtol, "horizon_turns": np.median(agreement[rtol]), "horizon_least": min(agreement[rtol]),
            "horizon_most": max(agreement[rtol]), "rule_turns": np.log(HORIZON / rtol) / growth,
            "mean_gaps": runs[rtol].mean(), "std_gaps": runs[rtol].std(), "ks_to_tightest": ks_distance(runs[rtol], best),
            "alarm_level": level, "attractor_period_turns": period_of(runs[rtol]),
        }
        for rtol in tolerances
    ]  # fmt: skip
    other = radii(turns, 1e-6, friction=0.12)
    changed = ks_distance(other, best)
    facts = {"growth_per_turn": growth, "growth_error": spread, "alarm_level": level, "ks_friction_20_percent": changed}
    facts["turns"] = turns
    return rows, facts


def write(path, rows, note):
    """One CSV."""
    with open(path, "w", newline="") as file:
        file.write(f"# {note}\n")
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)


def report(jump_rows, chaos_rows, facts):
    """Both tables in Markdown."""
    durations = list(dict.fromkeys(row["duration_s"] for row in jump_rows))
    print("| rtol | " + " | ".join(f"{d:g} s" for d in durations) + " |\n|---|" + "---|" * len(durations))
    for rtol in dict.fromkeys(row["rtol"] for row in jump_rows):
        cells = [f"{row['jump_hz']:.1f}" for row in jump_rows if row["rtol"] == rtol]
        print(f"| {rtol:.0e} | " + " | ".join(cells) + " |")
    cells = [next(row for row in jump_rows if row["duration_s"] == d) for d in durations]
    print("| predicted | " + " | ".join(f"{row['predicted_jump_hz']:.1f} ({row['source']})" for row in cells) + " |\n")
    print(f"chaotic rub: growth {facts['growth_per_turn']:.3f} +- {facts['growth_error']:.3f} per turn; KS of friction +20 %: "
          f"{facts['ks_friction_20_percent']:.4f}; alarm level {facts['alarm_level']:.4f}, {facts['turns']} turns")  # fmt: skip
    print("| rtol | agrees for (turns, median; range) | ln(0.01/rtol)/growth | mean abs(r)/gap | std | KS to tightest | period |")
    print("|---|---|---|---|---|---|---|")
    for row in chaos_rows:
        print(f"| {row['rtol']:.0e} | {row['horizon_turns']:.0f} ({row['horizon_least']:.0f} to {row['horizon_most']:.0f}) | "
              f"{row['rule_turns']:.0f} | {row['mean_gaps']:.4f} | {row['std_gaps']:.4f} | {row['ks_to_tightest']:.4f} | "
              f"{row['attractor_period_turns'] or 'none'} |")  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one run-up, three tolerances, short statistics")
    options = parser.parse_args()
    begun = time.perf_counter()
    # nothing here is timed: both at a time
    with ThreadPoolExecutor(2) as pool:
        jumping = pool.submit(jumps, *(((60.0,), (1e-3, 1e-6)) if options.quick else (DURATIONS, JUMP_TOLERANCES)))
        chaotic = pool.submit(chaos, *(((1e-3, 1e-5, 1e-7), 2500, 2) if options.quick else (TOLERANCES, TURNS, 12)))
        jump_rows, (chaos_rows, facts) = jumping.result(), chaotic.result()
    note = f"rsc {version('rotor-stator-contact')}, numpy {np.__version__}, {platform.machine()}, {os.cpu_count()} cores"
    folder = results_folder(options.quick)
    write(folder / "physics_jump.csv", jump_rows, note)
    told = ", ".join(f"{name} {value:.4g}" for name, value in facts.items())
    write(folder / "physics_chaos.csv", chaos_rows, f"{note}; {told}")
    picture(jump_rows, chaos_rows, facts, folder / "physics.png", note)
    report(jump_rows, chaos_rows, facts)
    print(f"{time.perf_counter() - begun:.0f} s")


if __name__ == "__main__":
    main()
