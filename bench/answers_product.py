"""Answers over the product of terms: which kinds of lines random scenes reach, and each of them judged by a third engine.

    python bench/answers_product.py [COUNT] [--seed 1] [--first 0] [--write]     default 40

A scene has one to three contacts and each of these terms or not: an inner race, a torque-limited drive, coefficients that
follow the speed, rotating damping, supports whose directions differ; some are one body, some slide on one side only, and the
runs of some are measured by two probes as well. `rsc.check` (`rsc.compare`) answers it, and every line of the answer is judged
by samples of the third engine (third_engine.py) from the same start: by the text at each contact (product_lines.py,
product_measured.py), and what is said of lists by runs from the states in which the motions stood, after the impacts and under
the torque (product_lists.py). A kind of line is a pattern of KINDS; the table counts how many sayings of it were judged, false,
and could not be judged, since runs of the third engine from beside the start do not agree or the witness does not know it. What
no scene reached stands at the end. --write: results/answers_product.md, anew after every four scenes. Some lists use impacts half
as large as one that just touches ("weak impacts"), which prove no safety. Scenes with a false line are saved
under out/answers/. Exit code 1 if a line is false.
"""

import argparse
import collections
import re
import sys
import time
import warnings
from pathlib import Path

sys.path += [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1] / "tools")]

import numpy as np

import rsc
from pages import RESULTS, ROOT, write_page
from product_lines import judged
from product_lists import of_list
from product_measured import of_measured
from product_scenes import product_scene
from product_witness import ProductWitness
from rsc.study.motions.random_impacts import ImpactSizes
from rsc.study.motions.settle import Settling

OUTCOMES = {
    "the drive holds it": r"the drive holds it", "brakes to": r"brakes to [\d.]+ Hz", "speeds up to": r"speeds up to [\d.]+ Hz",
    "captured": r"captured at", "stops": r"stops after", "leaves it": r"leaves it at",
    "settles elsewhere": r"settles (in|without)",
    "not settled": r"not settled|still (slowing|speeding)", "on the way": r"\(on the way",
}  # fmt: skip
BACKWARD = ("sliding", "rolling", "bouncing")
LASTING = (*BACKWARD, "forward whirl", "forward rub", "partial rub", "resting", "running away", "no contact")
SEVERITIES = ("safe", "unknown", "at risk", "rub", "whirl", "destructive")
# name -> (topic, pattern) of a line of the answer, or of a sentence on a list
KINDS = {
    **{f"verdict: {name}": ("verdict", rf"Severity: {name}") for name in SEVERITIES},
    "verdict: no contact in this run": ("verdict", "^No contact"), "verdict: none of the impacts": ("verdict", "None of"),
    "verdict: lasts, but none starts it": ("verdict", "once it is started"),
    "verdict: smallest impact": ("verdict", "smallest found"),
    "verdict: beyond the model": ("verdict", "eyond the model"), "verdict: rolls on a race": ("verdict", "on a race"),
    "verdict: assumed diameter": ("verdict", "give contact.diameter"),
    **{f"run: {name}": ("whirl", name) for name in ("no backward whirl", *LASTING, "transient contact", "not resolved")},
    "run: kinds at several contacts": ("whirl", r" at \w+ and \w+"), "frequency": ("frequency", r"Hz"),
    "vibration": ("vibration", "pk-pk"), "vibration: mean position": ("vibration", "mean position"),
    "vibration: the whirl's line": ("vibration", "whirl's line"), "closest approach: touches": ("closest approach", "touches"),
    "closest approach: free": ("closest approach", r"^\d"), "force": ("force", r"normal"), "force: heat": ("force", "heat"),
    "force: power in or lost": ("force", "power (input|lost)"), "at a contact: touches": ("at a contact", "penetration"),
    "at a contact: free": ("at a contact", "never touched"),
    "drive takes": ("drive", r"rub torque on the shaft"), "drive is given": ("drive", r"the rub drives"),
    "drive: heat and races": ("drive", r"\(heat"), "change": ("change", r""), "at the end": ("at the end", r""),
    "coverage": ("coverage", ""), "mu_min": ("mu_min", r"is [\d.]+ \("),
    "mu_min: with no friction": ("mu_min", r"with any friction"), "mu_min: runs away": ("mu_min", "runs away"),
    "mu_min: not known": ("mu_min", "is not known"), "check": ("check", r""),
    **{f"list: {name}": ("list", name) for name in LASTING}, "list: impacts that start a motion": ("impacts", ""),
    "list: smallest impact": ("smallest", ""), "list: predicted, not reached": ("left", ""),
    **{f"drive: {name}": ("held", pattern) for name, pattern in OUTCOMES.items()},
    **{f"measured: {name}": (f"measured {name}", "") for name in ("signals", "motion", "frequency", "vibration", "1X", "model",
       "would do", "force", "change", "check", "not told")},
}  # fmt: skip
SAVED = ROOT / "out" / "answers"
EVERY = 4  # scenes after which the table is written


def kinds_said(lines):
    """Names of the KINDS that lines (topic, text) of an answer say."""
    return {
        name for name, (wanted, pattern) in KINDS.items()
        if any(wanted == topic and re.search(pattern, text) for topic, text in lines)
    }  # fmt: skip


def sayings(scene, terms):
    """(topic, text, [what is false, "" or "skipped"]) of all that is said of a scene."""
    largest = _weak(scene) if "weak impacts" in terms else None
    report = rsc.check(scene, largest=largest)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the judge
        witness = ProductWitness(report, scene)
        yield from judged(report, witness)
        for listed in report.motions:
            for topic, text, problem in of_list(report.result.scene, listed, scene if "torque" in terms else None, largest):
                yield topic, text, [problem]
        if "measured" in terms:
            yield from of_measured(report.result, witness.runs.of(0)[0])


def _weak(scene):
    """Half of the impulse in N s that just touches, from the centre and at the contact where the least does."""
    sizes = ImpactSizes(Settling(scene, scene.drive.speed[0]))
    angles = np.linspace(0.0, np.pi, 24)
    return 0.5 * min(float(sizes.touching(place, angles).min()) for place in range(len(scene.contacts)))


class Table:
    """How often each kind of line was said, false, and not judged."""

    def __init__(self):
        self.said, self.false, self.skipped = collections.Counter(), collections.Counter(), collections.Counter()
        self.scenes, self.wrong, self.lines, self.reached = 0, 0, 0, collections.Counter()

    def add(self, told, terms):
        """The sayings of a scene with its terms."""
        self.scenes, self.lines = self.scenes + 1, self.lines + len(told)
        self.reached.update(terms)
        false = [problem for *_, problems in told for problem in problems if problem not in ("", "skipped")]
        self.wrong += len(false)
        for topic, text, problems in told:
            kinds = kinds_said([(topic, text)])
            self.said.update(kinds)
            if any(problem not in ("", "skipped") for problem in problems):
                self.false.update(kinds)
            elif "skipped" in problems:
                self.skipped.update(kinds)
        return false

    def text(self):
        """Lines of Markdown."""
        unreached = [name for name in KINDS if not self.said[name]]
        terms = ", ".join(f"{count} {term}" for term, count in sorted(self.reached.items()))
        rows = [f"| {name} | {n} | {n - self.skipped[name] - self.false[name]} | {self.false[name]} | {self.skipped[name]} |"
                for name in KINDS if (n := self.said[name])]  # fmt: skip
        head = f"{self.scenes} scenes ({terms}), {self.lines} lines and sentences, {self.wrong} false."
        return [head, "", "| kind of line | said | true | false | not judged |", "|---|---|---|---|---|", *rows, "",
                f"Reached by no scene: {', '.join(unreached) or 'none'}."]  # fmt: skip


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--write", action="store_true", help="write the table to bench/results")
    options = parser.parse_args()
    table = Table()
    for number in range(options.first, options.first + options.count):
        begun = time.process_time()
        scene, terms = product_scene(options.seed, number)
        told = list(sayings(scene, terms))
        false = table.add(told, terms)
        print(f"{scene.title}: {len(told)} lines, {time.process_time() - begun:.1f} s", flush=True)
        for topic, text, problems in told:
            for problem in problems:
                if problem:
                    print(f"    {'' if problem == 'skipped' else 'FALSE '}{topic}: {problem}: {text}", flush=True)
        if false:
            SAVED.mkdir(parents=True, exist_ok=True)
            comment = "".join(f"# {one}\n" for one in false)
            (SAVED / f"product_{options.seed}_{number}.toml").write_text(comment + scene.to_toml(), encoding="utf-8")
        if options.write and (table.scenes % EVERY == 0 or table.scenes == options.count):
            command = f"python bench/answers_product.py {table.scenes} --seed {options.seed} --first {options.first} --write"
            title = "Answers over the product of terms, judged by a third engine"
            write_page(RESULTS / "answers_product.md", title, command, "\n".join(table.text()))
    print("\n".join(table.text()))
    return 1 if table.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
