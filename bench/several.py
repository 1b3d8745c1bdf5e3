"""Whirls at several contacts, predicted against simulated: random stable ones at two and three contacts, growth of unstable ones.

    python bench/several.py [--pairs 22] [--triples 8] [--unstable 6] [--write]

A stable whirl is begun beside itself, every velocity 0.1 % off, and run for fourteen of the times in which small motions about it
decay by e; then frequency, deflections and normal forces are those of the prediction, or not. About an unstable one the deviation
of the motion grows by e^{growth t}. Neither program knows the other. --write: the page of it in bench/results
"""

import argparse
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "support")]

import rsc  # noqa: E402
from pages import write_page  # noqa: E402
from several_systems import random_several  # noqa: E402

TWO_PI, SPEED, OFF = 2.0 * np.pi, 40.0, 1e-3
DECAYS, LONGEST = 14.0, 6.0  # times of decay that are waited, and s at most


def scene_of(system):
    """The scene of a System of `random_several`, without unbalance."""
    bodies = {}
    for name, body in (("rotor", system.rotor), ("stator", system.stator)):
        bodies[name] = {"model": "matrices"} | {
            key: getattr(body, key).tolist() for key in ("mass", "stiffness", "damping")
        }
    bodies["rotor"] |= {"gyroscopic": system.rotor.gyroscopic.tolist(), "eccentricity": [0.0] * system.n_rotor}
    contacts = [
        {"name": own.name, "rotor_coordinate": int(own.rotor.argmax()), "stator_coordinate": int(own.stator.argmax()),
         "gap": own.gap, "stiffness": own.law.stiffness, "damping": own.law.damping, "friction": own.law.friction}
        for own in system.contacts
    ]  # fmt: skip
    drive, solver = {"speed": SPEED, "duration": 1.0}, {"rtol": 1e-10}
    return rsc.Scene.from_dict(bodies | {"contact": contacts, "drive": drive, "solver": solver})


def run_beside(scene, whirl, duration, off):
    """The run that begins on a whirl with every velocity off by a share."""
    turn = 1j * TWO_PI * whirl.frequency * (1.0 + off)
    parts = {"rotor": whirl.rotor_shape, "stator": whirl.stator_shape}
    start = {name: pairs(part) for name, part in parts.items()}
    start |= {f"{name}_velocity": pairs(turn * part) for name, part in parts.items()} | {"allow_penetration": True}
    rate = max(40.0 * abs(whirl.frequency), 4.0 * SPEED)
    own = {"start": start, "drive": {"speed": SPEED, "duration": duration}, "output": {"rate": rate}}
    return rsc.simulate(rsc.Scene.from_dict(scene.to_dict() | own))


def pairs(shape):
    return [[float(value.real), float(value.imag)] for value in shape]


def deflections(scene, result):
    """(n_time, n_contacts) complex m."""
    contacts = scene.contacts
    return np.column_stack([own.of_rotor(result.rotor) - result.stator[:, own.stator_coordinate] for own in contacts])


def errors(scene, whirl):
    """(share of frequency, of a deflection, of a force) by which the end of a run beside a stable whirl is off, the largest."""
    duration = min(DECAYS / -whirl.growth_rate, LONGEST)
    result = run_beside(scene, whirl, duration, OFF)
    last = result.time > result.time[-1] - min(20.0 / abs(whirl.frequency), 0.2 * duration)
    d, off = deflections(scene, result)[last], []
    for i, own in enumerate(whirl.contacts.values()):
        if own.pressed:
            slope = np.polyfit(result.time[last], np.unwrap(np.angle(d[:, i])), 1)[0] / TWO_PI
            force = result.normal_force[last, i].mean()
            off.append((slope / whirl.frequency, np.abs(d[:, i]).mean() / own.deflection, force / own.normal_force))
    return np.abs(np.array(off) - 1.0).max(axis=0)


def growth(scene, whirl):
    """Growth rate in 1/s with which a run leaves an unstable whirl."""
    result = run_beside(scene, whirl, min(12.0 / whirl.growth_rate, LONGEST), 1e-7)
    d, turn = deflections(scene, result), np.exp(-1j * TWO_PI * whirl.frequency * result.time)
    steady, pressed = np.array([(own.deflection, own.pressed) for own in whirl.contacts.values()]).T
    away = np.abs(np.abs(d * turn[:, None]) - steady)[:, pressed > 0.0].max(axis=1) / steady.max()
    count = max(round(result.time.size / (result.time[-1] * abs(whirl.frequency))), 1)  # samples of a turn
    largest = np.array([away[i : i + 4 * count].max() for i in range(0, away.size - 4 * count, 4 * count)])
    inside = np.flatnonzero((largest > 1e-6) & (largest < 3e-4))
    if inside.size <= 4:
        return np.nan
    return np.polyfit(inside * 4.0 * count / result.scene.output.rate, np.log(largest[inside]), 1)[0]


def whirls(seed):
    """(scene, whirl) at all contacts of random systems, endlessly: systems of two contacts, every fourth of three."""
    rng, number = np.random.default_rng(seed), 0
    while True:
        system, number = random_several(rng, 3 if number % 4 == 3 else 2), number + 1
        scene = scene_of(system)
        for whirl in rsc.predict(scene):
            if len(whirl.pressed) == len(scene.contacts) and not whirl.touches:
                yield scene, whirl


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, number in (("--pairs", 22), ("--triples", 8), ("--unstable", 6)):
        parser.add_argument(name, type=int, default=number)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    left = {2: options.pairs, 3: options.triples, "unstable": options.unstable}
    lines = ["| contacts | Psi Hz | growth 1/s | off in frequency | in deflection | in force |", "|---|---|---|---|---|---|"]
    for scene, whirl in whirls(3):
        if not any(left.values()):
            break
        n = len(whirl.pressed)
        head = f"| {n} | {whirl.frequency:.4f} | {whirl.growth_rate:.4f} |"
        if whirl.stable and left[n] and whirl.growth_rate < -DECAYS / LONGEST:
            left[n] -= 1
            lines.append(head + " | ".join(f" {value:.1e}" for value in errors(scene, whirl)) + " |")
        elif 2.0 < whirl.growth_rate < 100.0 and left["unstable"]:
            measured = growth(scene, whirl)
            if not np.isfinite(measured):
                continue  # its instability has not the size of the range looked at
            left["unstable"] -= 1
            off = 100.0 * abs(measured / whirl.growth_rate - 1.0)
            lines.append(head + f" grows by {measured:.4f} 1/s, {off:.2f} % off | | |")
        else:
            continue
        print(lines[-1], flush=True)
    if options.write:
        command, page = "python bench/several.py --write", ROOT / "bench" / "results" / "several.md"
        write_page(page, "Whirls at several contacts", command, "\n".join(lines))


if __name__ == "__main__":
    main()
