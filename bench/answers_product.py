"""Answers over the product of terms: which kinds of lines random scenes reach, and which of them a judge has seen.

    python bench/answers_product.py [COUNT] [--seed 1] [--first 0]     default 40

A scene has one to three contacts and each of these terms or not: an inner race, a torque-limited drive, coefficients that follow
the speed, rotating damping, supports whose directions differ. `rsc.check` answers it. A kind of line is a pattern of KINDS; the
table counts how many scenes said it and how many of these sayings were judged: those of what a drive makes of a motion by the
third engine (drive_outcomes.py), with one contact and without a race. Lines of a scene with one contact and none of the terms are
judged by bench/answers.py. What no scene reached stands at the end. Exit code 1 if a judged sentence is false.
"""

import argparse
import collections
import random
import re
import sys
import time
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parent))

import rsc
from drive_outcomes import judged
from rsc.show.words.answer import answer

TERMS = ("race", "torque", "knots", "rotating damping", "unequal supports")
OUTCOMES = {
    "the drive holds it": r"the drive holds it", "brakes to": r"brakes to [\d.]+ Hz", "speeds up to": r"speeds up to [\d.]+ Hz",
    "captured": r"captured at", "stops": r"stops after", "leaves it": r"leaves it at",
    "settles elsewhere": r"settles (in|without)",
    "not settled": r"not settled|still (slowing|speeding)", "on the way": r"\(on the way",
}  # fmt: skip
# name -> (topic, pattern) of a line of the answer; topic "" for any
KINDS = {
    **{f"drive: {name}": ("", pattern) for name, pattern in OUTCOMES.items()},
    "drive: after the trip": ("", r"after the trip"),
    "drive takes": ("drive", r"rub torque on the shaft"), "drive is given": ("drive", r"the rub drives"),
    "heat and races": ("drive", r"\(heat"),
    "no backward whirl": ("whirl", r"no backward whirl"), "sliding": ("whirl", r"sliding"), "rolling": ("whirl", r"rolling"),
    "bouncing": ("whirl", r"bouncing"), "forward rub": ("whirl", r"forward rub"), "partial rub": ("whirl", r"partial rub"),
    "forward whirl": ("whirl", r"forward whirl"), "resting": ("whirl", r"resting"), "no contact": ("whirl", r"no contact"),
    "not resolved": ("whirl", r"not resolved"), "kinds at several contacts": ("whirl", r" at \w+ and \w+"),
    "frequency": ("frequency", r"Hz"), "amplitude": ("amplitude", r"gaps"), "force": ("force", r"normal"),
    "change": ("change", r""), "at the end": ("at the end", r""),
    "also possible": ("also possible", r""), "not reached": ("not reached", r""),
    "mu_min": ("mu_min", r"is [\d.]+ \("),
    "mu_min of no friction": ("mu_min", r"with any friction|no backward whirl is predicted"),
    "check": ("check", r""),
}  # fmt: skip
JUDGED = tuple(f"drive: {name}" for name in OUTCOMES)


def product_scene(seed, number):
    """(scene, its terms) of a number: terms go through all combinations before the dice."""
    dice, count = random.Random(f"product {seed}/{number}"), 1 + number % 3
    terms = {term for i, term in enumerate(TERMS) if (number // 3) >> i & 1}

    def log(low, high):
        return float(np.exp(dice.uniform(np.log(low), np.log(high))))

    mass, gap = log(2.0, 10.0), log(1e-4, 4e-4)
    stiffness = mass * (2.0 * np.pi * log(20.0, 45.0)) ** 2
    n = max(count, 1)
    damping = 0.04 * np.sqrt(mass * stiffness)
    rotor = {
        "model": "chain", "masses": [mass * dice.uniform(0.8, 1.5) for _ in range(n)],
        "stiffnesses": [stiffness * dice.uniform(0.5, 1.5) for _ in range(n + 1)], "dampings": [damping] * (n + 1),
        "eccentricity": [gap * log(0.02, 0.4)] + [0.0] * (n - 1),
    }  # fmt: skip
    if "rotating damping" in terms:
        rotor["rotating_damping"] = [0.1 * damping] * (n + 1)
    support = 0.15 * stiffness
    if "unequal supports" in terms:
        rotor["supports"] = [[0, [support, 0.0, 0.0, 0.5 * support], [0.0, 0.0, 0.0, 0.0]]]
    if "knots" in terms:
        laws = [[hz, [rise * support, 0.0, 0.0, rise * support], [1.0, 0.0, 0.0, 1.0]] for hz, rise in ((10.0, 0.5), (80.0, 1.5))]
        rotor["supports_by_speed"] = [[0, laws]]
    stator = {"model": "laval", "mass": 0.7 * mass, "frequency": log(80.0, 160.0), "damping_ratio": 0.06}
    speed, contacts = log(20.0, 70.0), []
    for i in range(count):
        diameter = log(0.02, 0.08)
        contacts.append({
            "name": ("seal", "bush", "ring")[i], "rotor_coordinate": i, "stator_coordinate": 0,
            "gap": gap * dice.uniform(0.8, 1.3), "friction": log(0.05, 0.35), "stiffness": stiffness * log(20.0, 100.0),
            "damping_ratio": 0.1, "diameter": diameter,
            "slip_velocity": 0.05 * np.pi * speed * diameter,
        })  # fmt: skip
    if "race" in terms:
        contacts[0] |= {"race_inertia": 1e-4, "race_drag": 1e-5}
    drive = {"speed": speed, "duration": 1.0}
    if "torque" in terms:
        inertia = 0.02 * mass * 0.05
        strong = inertia * 2.0 * np.pi * speed / log(0.3, 3.0)
        drive |= {"inertia": inertia, "torque": [[0.0, strong], [speed, 0.2 * strong], [1.2 * speed, -0.3 * strong]]}
        drive |= {"trip": 0.7, "coast": [[0.0, -0.05 * strong]]} if dice.random() < 0.4 else {}
    angle = dice.uniform(0.0, 2.0 * np.pi)
    moving = [[gap * 2.0 * np.pi * speed * 2.0 * np.cos(angle), gap * 2.0 * np.pi * speed * 2.0 * np.sin(angle)]]
    start = {"rotor": [[0.0, 0.0]] * n, "rotor_velocity": moving + [[0.0, 0.0]] * (n - 1),
             "stator": [[0.0, 0.0]], "stator_velocity": [[0.0, 0.0]]}  # fmt: skip
    title = f"product {seed}/{number}: {count} contacts, {', '.join(sorted(terms)) or 'no more'}"
    tables = {"title": title, "rotor": rotor, "stator": stator, "contact": contacts if count > 1 else contacts[0]}
    return rsc.Scene.from_dict({**tables, "drive": drive, "start": start, "output": {"rate": 4000.0}}), terms


def kinds_said(lines):
    """Names of the KINDS that lines (topic, text) of an answer say."""
    return {
        name for name, (wanted, pattern) in KINDS.items()
        if any(wanted in ("", topic) and re.search(pattern, text) for topic, text in lines)
    }  # fmt: skip


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    said, seen, false = collections.Counter(), collections.Counter(), 0
    for number in range(options.first, options.first + options.count):
        begun = time.process_time()
        scene, terms = product_scene(options.seed, number)
        said.update(kinds_said(answer(rsc.check(scene))))
        if "torque" in terms and "race" not in terms and len(scene.contacts) == 1:
            for _, sentence, wrong, skipped in judged(scene, scene.drive.speed[0]):
                seen.update(kinds_said([("", sentence)]) if not skipped else ())
                false += bool(wrong) and not skipped
                print(f"    {sentence}" + (f": FALSE, {wrong}" if wrong and not skipped else ""), flush=True)
        print(f"{scene.title}: {time.process_time() - begun:.1f} s", flush=True)
    print("\n".join(["| kind of line | scenes that said it | judged here |", "|---|---|---|"]))
    for name in KINDS:
        print(f"| {name} | {said[name]} | {seen[name] if name in JUDGED else '-'} |")
    print(f"false: {false}; reached by no scene: {', '.join(name for name in KINDS if not said[name] + seen[name]) or 'none'}")
    return 1 if false else 0


if __name__ == "__main__":
    sys.exit(main())
