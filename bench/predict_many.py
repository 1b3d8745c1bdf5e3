"""Whirls of many scenes at many speeds: `rsc.predict_many` against `rsc.predict` one by one; one whirl against all branches.

    python bench/predict_many.py [--quick] [--repeats 5]

Variants of data/reference/gyroscopic_transition.toml (2 rotor and 1 stator coordinates) in unbalance, gyroscopics, stator mass,
friction and gap, at 24 speeds each. "two wanted" are the whirls next to two frequencies, "all" every whirl. Processor
time a scene on one thread, the ways interleaved: least, median and largest of the repeats. One by one only the first 50 scenes
are predicted; these are also compared number by number. Then fold, crossing and delay of one whirl of a reference scene, beside
all branches over the same speeds. Writes predict_many.txt.
"""

import argparse
import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy is loaded

import sys
import time
from pathlib import Path

import numpy as np

import rsc
from problems import results_folder
from rsc.analysis.lines.branches import branches
from rsc.system.assemble import assemble

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "tools")]

from pages import machine  # noqa: E402

SCENE = ROOT / "data" / "reference" / "gyroscopic_transition.toml"
SPEEDS = np.linspace(20.0, 150.0, 24)  # Hz
NEAR = np.array([-30.0, -48.0])  # Hz
WHOLE, QUICK, ALONE = 1000, 60, 50  # scenes


def variants(count):
    """Scenes that differ in what a search changes."""
    rng, base = np.random.default_rng(1), rsc.load_scene(SCENE)
    varied = {
        "rotor.eccentricity": abs(complex(base.rotor.eccentricity)), "rotor.polar_inertia": base.rotor.polar_inertia,
        "stator.mass": base.stator.mass, "contact.friction": base.contact.friction, "contact.gap": base.contact.gap,
    }  # fmt: skip
    factors = rng.uniform(0.8, 1.25, (count, len(varied)))
    return [base.with_values(dict(zip(varied, row * [*varied.values()], strict=True))) for row in factors]


def seconds(run):
    """Processor time of a call in s, and what it returns."""
    begin = time.process_time()
    value = run()
    return time.process_time() - begin, value


def differences(arrays, lists):
    """Largest relative difference of the numbers of all whirls of scenes predicted one by one."""
    names = ("frequency", "normal_force", "rotor_amplitude", "stator_amplitude", "growth_rate")
    largest = 0.0
    for i, of_speeds in enumerate(lists):
        for j, whirls in enumerate(of_speeds):
            for name in names:
                alone = np.array([getattr(whirl, name) for whirl in whirls])
                largest = max(largest, np.abs(getattr(arrays, name)[i, j, : len(whirls)] / alone - 1.0).max(initial=0.0))
    return largest


def of_one_whirl(repeats):
    """Lines on the processor time of a question about one whirl, and of all branches over as many speeds."""
    pair = rsc.load_scene(SCENE.with_name("gyroscopic_disk_very_light.toml"))
    transition = rsc.load_scene(SCENE)
    down, up, run = np.linspace(60.0, 10.0, 33), np.linspace(20.0, 150.0, 33), np.linspace(20.0, 150.0, 201)
    questions = {
        "fold": (lambda: rsc.fold(pair, -48.8, (60.0, 10.0)), lambda: branches(assemble(pair), down)),
        "crossing": (lambda: rsc.crossing(transition, -38.8, (20.0, 150.0)), lambda: branches(assemble(transition), up)),
        "delay": (lambda: rsc.delay(transition, -38.8), lambda: branches(assemble(transition), run)),
    }
    lines = ["one whirl, and all branches over as many speeds: least processor time in ms"]
    for name, ways in questions.items():
        alone, together = (1e3 * min(seconds(way)[0] for _ in range(repeats + 1)) for way in ways)
        lines.append(f"  {name}: {alone:.1f}, {together:.1f}; 1/{together / alone:.1f}")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="few scenes, once, into out/bench/")
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    scenes = variants(QUICK if options.quick else WHOLE)
    alone = scenes[: 5 if options.quick else ALONE]
    ways = {
        "one by one": (len(alone), lambda: [rsc.predict(scene, SPEEDS) for scene in alone]),
        "stacked, all": (len(scenes), lambda: rsc.predict_many(scenes, SPEEDS)),
        "stacked, two wanted": (len(scenes), lambda: rsc.predict_many(scenes, SPEEDS, NEAR)),
    }
    times, values = {name: [] for name in ways}, {}
    for repeat in range(-1, 1 if options.quick else options.repeats):  # the first round loads code and is not timed
        for name, (count, run) in ways.items():
            spent, values[name] = seconds(run)
            if repeat >= 0:
                times[name].append(1e3 * spent / count)
    size = f"{len(scenes)} scenes of 2 + 1 coordinates at {len(SPEEDS)} speeds, {len(times['one by one'])} repeats"
    lines = [f"{size}; {machine()}"]
    lines.append("processor time a scene in ms: least, median, largest")
    for name, spent in times.items():
        gain = min(times["one by one"]) / min(spent)
        lines.append(f"  {name}: {min(spent):.2f}, {np.median(spent):.2f}, {max(spent):.2f}; 1/{gain:.1f} of one by one")
    largest = differences(values["stacked, all"], values["one by one"])
    lines.append(f"largest relative difference from one by one, {len(alone)} scenes: {largest:.1e}")
    lines += of_one_whirl(1 if options.quick else options.repeats)
    text = "\n".join(lines) + "\n"
    print(text, end="")
    (results_folder(options.quick) / "predict_many.txt").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
