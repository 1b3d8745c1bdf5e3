"""Check, motions, sweep, maps and page of the same machines say the same of what lasts.

    python bench/consistency.py [COUNT] [--seed 1] [--first 0] [--write]     default 40

The machines are those of bench/drive_outcomes.py at a prescribed speed, after an impact. Asked of each:
- the list of `rsc.motions` with as many impacts is that of `rsc.check`: kinds, frequencies, forces, impacts that start each;
- `lasting*` of a sweep is the first of the list and `lasting_whirl*` the first whirl in it, its class of danger fits the run and
  every motion of the list, the curves of a sweep over the friction have both;
- every motion that turns is marked in the Campbell diagram and in the table of the page, every rolling one named below the
  whirls;
- a letter is one whirl in the table of branches and in the lists;
- the verdict of the run is no less severe than what the list alone is worth, unless that is the run's own motion, and the first
  line of terminal, page and report.json is one text;
- the map of predictions has a dot for every motion of the list that was predicted to roll.
--write: results/consistency.md. Exit code 1 if there is a contradiction.
"""

import argparse
import collections
import json
import sys
import tempfile
import time
from html import escape
from pathlib import Path

import numpy as np

sys.path += [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1] / "tools")]

import rsc
from drive_outcomes import machine
from pages import RESULTS, write_page
from rsc.measure.catalogue import WHIRLING
from rsc.measure.severity import severity_of, verdict_of
from rsc.show.page import page
from rsc.show.pictures.abscissa import Abscissa
from rsc.show.pictures.lasting import EDGE
from rsc.show.pictures.pictures import campbell
from rsc.show.sweeps import pictures as sweep_pictures
from rsc.show.words.answer import answer
from rsc.show.words.motions import motions_cells
from rsc.show.words.wording import hertz
from rsc.study.prediction.predictions import surveyed
from rsc.study.report.stored import write_stored
from rsc.study.sweep.dataset import DANGER, LASTS, REACHED
from rsc.study.sweep.plan import make_plan
from rsc.study.sweep.sweep import computed
from rsc.study.sweep.vary import cases

SAME, LETTER, DRAWN = 1e-9, 0.02, 1e-3  # of figures of the same runs; of frequencies of one letter; of the width of a picture


def scene_of(seed, number):
    """A machine at its speed after an impact at the start."""
    scene, dice = machine(seed, number), np.random.default_rng([seed, number])
    scene = scene.steady(scene.drive.speed[0], 60.0 / scene.drive.speed[0])
    size = 8.0 * np.pi * scene.contact.gap * scene.drive.speed[0] * dice.uniform(0.0, 1.0) * mass_of(scene)
    angle = dice.uniform(0.0, 2.0 * np.pi)
    try:
        hit = scene.with_values({"start.running": True, "start.impulse": [size * np.cos(angle), size * np.sin(angle)]})
        rsc.simulate(hit.with_values({"drive.duration": 1e-3}))
    except rsc.RscError:  # it would touch
        return scene
    return hit


def mass_of(scene):
    """The mass in kg that touches."""
    return float(scene.rotor.mass) if scene.rotor.model == "laval" else float(scene.rotor.masses[0])


def alike(a, b):
    """Whether two numbers are one; NaN is NaN."""
    return bool((np.isnan(a) and np.isnan(b)) or abs(a - b) <= SAME * max(abs(a), abs(b)))


def lists_alike(one, other):
    """(kind, detail) of what two lists of a machine do not have in common."""
    rows = [[(str(motion.motion), motion.frequency, motion.force_max, listed.hits(motion)) for motion in listed.motions]
            for listed in (one, other)]  # fmt: skip
    same = len(rows[0]) == len(rows[1]) and all(
        a[0] == b[0] and alike(a[1], b[1]) and alike(a[2], b[2]) and a[3] == b[3] for a, b in zip(*rows, strict=True)
    )
    if not same:
        yield "check and motions", f"{rows[0]} and {rows[1]}"


def of_sweep(scene, listed):
    """(kind, detail) of what a sweep over two frictions, the first that of the scene, says otherwise than a list of it."""
    friction = scene.contact.friction
    varied = cases(scene, {"contact.friction": f"{friction!r},{1.01 * friction!r}"})
    data = computed(make_plan(scene, varied, "predict,run,motions"), None)
    if not listed.motions:
        return
    worst = listed.motions[0]
    if data["lasting"][0] != worst.motion:
        yield "sweep and list", f"lasting {data['lasting'][0]!r}, list {worst.motion!r}"
        return
    own = {"frequency": worst.frequency, "amplitude": worst.amplitude_max, "force": worst.force_max, "power": worst.power}
    for name, value in (own if worst.bounded else {}).items():
        if not alike(float(data[f"lasting_{name}"][0]), value):
            yield "sweep and list", f"lasting_{name} {data[f'lasting_{name}'][0]:.6g}, list {value:.6g}"
    whirls = any(motion.motion in WHIRLING for motion in listed.motions)
    danger = int(data["danger"][0])
    if whirls and danger < LASTS:
        yield "class of danger", f"{DANGER[danger]}, list has {[str(motion.motion) for motion in listed.motions]}"
    if str(data["motion"][0]) in WHIRLING and danger != REACHED:
        yield "class of danger", f"{DANGER[danger]}, the run ends in {data['motion'][0]}"
    panels = {panel.quantity: panel for panel in sweep_pictures._panels(data, "contact.friction", "line")}
    drawn = [float(curve.values[0]) for curve in panels["normal force"].curves if curve.name.startswith("most dangerous")]
    first = next((motion for motion in listed.motions if motion.motion in WHIRLING), None)
    if str(data["lasting_whirl"][0]) != (first.motion if first else ""):
        yield "sweep and list", f"lasting_whirl {data['lasting_whirl'][0]!r}, list {[str(one.motion) for one in listed.motions]}"
    started = sum(listed.hits(motion) for motion in listed.motions if motion.motion in WHIRLING) / listed.starts
    if first and not alike(float(data["lasting_whirl_share"][0]), started):
        yield "sweep and list", f"lasting_whirl_share {data['lasting_whirl_share'][0]:.6g}, list {started:.6g}"
    for motion in (own for own in (worst, first) if own is not None and own.bounded):
        if not any(alike(force, motion.force_max) for force in drawn):
            yield "curves", f"{drawn}, list {motion.force_max:.6g} N"


def of_page(report):
    """(kind, detail) of lasting motions that the page does not show, and of first lines that differ."""
    text, marks = page(report), campbell(report, Abscissa(report))["data"]
    at = np.concatenate([np.ravel(trace["x"]) for trace in marks if trace.get("name") == "lasts, from a list of motions"] or [[]])
    edge = np.abs(campbell(report, Abscissa(report))["layout"]["xaxis"]["range"]).max()
    for listed in report.motions:
        for row, motion in zip(motions_cells(listed)[1], listed.motions, strict=True):
            if escape(row[-1]) not in text:
                yield "page", f"{row[-1]} is not in its table"
            turns = motion.bounded and np.isfinite(motion.frequency)
            place = float(np.clip(motion.frequency, -EDGE * edge, EDGE * edge)) if turns else 0.0
            if turns and not any(abs(x - place) < DRAWN * edge for x in at):
                yield "Campbell diagram", f"{motion.motion} at {motion.frequency:.5g} Hz has no mark"
            rolls = motion.predicted is not None and motion.predicted.label == "roll"
            if rolls and f"{hertz(motion.frequency)} Hz" not in text.partition("What can last")[0]:
                yield "whirls of the page", f"rolling at {motion.frequency:.5g} Hz is not named"
    first = dict(answer(report)).get("verdict", "")
    with tempfile.TemporaryDirectory() as folder:
        write_stored(report, Path(folder) / "report.json")
        stored = json.loads((Path(folder) / "report.json").read_text(encoding="utf-8"))
    if escape(first) not in text or " ".join(stored["verdict"]["sentences"]) != first:
        yield "first line", first


def of_letters(report):
    """(kind, detail) of whirls that have one letter in the table of branches and another one in a list."""
    for listed in report.motions:
        known = [*listed.not_reached, *listed.leaving, *(motion.predicted for motion in listed.motions if motion.predicted)]
        for branch in report.branches:
            whirl = branch.at(listed.speed)
            for one in known if whirl is not None else []:
                if one.label == branch.label and abs(one.frequency / whirl.frequency - 1.0) > LETTER:
                    yield "letters", f"whirl {one.label} at {one.frequency:.5g} and {whirl.frequency:.5g} Hz"


def of_verdict(report, listed):
    """(kind, detail) of a verdict that is less severe than run or list are."""
    alone, own = verdict_of(None, None, (), [listed]), report.verdict
    shown = max((severity_of(str(kind)) for kind in report.features.kind), key=lambda severity: severity.level)
    if own.severity.level < shown.level:
        yield "verdict", f"{own.severity}, the run is {shown}"
    itself = alone.impact is not None and alone.impact.motion in {str(kind) for kind in report.features.kind}
    if alone.impact is not None and alone.impact.hits and own.severity.level < alone.severity.level and not itself:
        yield "verdict", f"{own.severity}, the list alone {alone.severity}"


def of_map(scene, listed):
    """(kind, detail) of listed motions that were predicted to roll and have no dot in the map of predictions."""
    rolls = [roll.Psi / (2.0 * np.pi) for own in surveyed(scene).rolls.values() for roll in own]
    for motion in listed.motions:
        known = motion.predicted is not None and motion.predicted.label == "roll"
        if known and not any(abs(roll / motion.predicted.frequency - 1.0) < 1e-6 for roll in rolls):
            yield "map", f"rolling at {motion.predicted.frequency:.5g} Hz is not among {rolls}"


def contradictions(scene):
    """(kind, detail) of all that is said in two ways of a scene, and how many motions last."""
    report = rsc.check(scene)
    (listed,) = report.motions
    found = [*lists_alike(listed, rsc.motions(scene, listed.speed, listed.starts)), *of_sweep(scene, listed), *of_page(report)]
    found += of_letters(report)
    return [*found, *of_verdict(report, listed), *of_map(scene, listed)], [str(motion.motion) for motion in listed.motions]


def table_of(count, kinds, found):
    """Lines of Markdown on so many machines, a Counter of their motions, (kind, detail) of what contradicts."""
    counted = ", ".join(f"{n} {kind}" for kind, n in kinds.most_common())
    lines = [f"{count} machines, {kinds.total()} motions that last ({counted}): {len(found)} contradictions."]
    if found:
        between = collections.Counter(kind for kind, _ in found)
        lines += ["", "| between | contradictions |", "|---|---|", *(f"| {kind} | {n} |" for kind, n in between.items())]
    return "\n".join(lines)


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--write", action="store_true", help="write the table to bench/results, anew after every machine")
    options = parser.parse_args()
    found, kinds = [], collections.Counter()
    for number in range(options.first, options.first + options.count):
        begun = time.process_time()
        own, lasting = contradictions(scene_of(options.seed, number))
        kinds.update(lasting)
        found += own
        print(f"{number}: {', '.join(lasting)}; {time.process_time() - begun:.1f} s", flush=True)
        for kind, detail in own:
            print(f"    CONTRADICTION {kind}: {detail}", flush=True)
        if options.write:
            count = number - options.first + 1
            command = f"python bench/consistency.py {count} --seed {options.seed} --first {options.first} --write"
            title = "Do all doors say the same of what lasts?"
            write_page(RESULTS / "consistency.md", title, command, table_of(count, kinds, found))
    print(table_of(options.count, kinds, found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
