"""First remedies, judged: with the change that `rsc.remedy` puts first, a new list of motions has no backward one that lasts.

    python bench/remedies.py [COUNT] [--seed 1] [--first 0] [--starts 16] [--write]     default 20

The machines are those of bench/drive_outcomes.py at a prescribed speed, with a friction from 0.2 on so that most have a backward
motion that lasts. Remedies are looked for with `--starts` random impacts; the list that judges has 64 others. --write:
results/remedies.md. Exit code 1 if one of these lists has a backward motion.
"""

import argparse
import sys
import time
from pathlib import Path

sys.path += [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1] / "tools")]

import rsc
from drive_outcomes import machine
from pages import RESULTS, write_page
from rsc.show.words.remedies import remedies_text
from rsc.study.motions.remedy import harmful_of, with_remedy

JUDGE, SEED = 64, 7  # random impacts of the list that judges, and their seed
FRICTION = 0.2


def judged(seed, number, starts):
    """(text, whether the machine has something to be taken away, whether a remedy was found, whether it is false)."""
    scene = machine(seed, number)
    scene = scene.steady(scene.drive.speed[0]).with_values({"contact.friction": max(scene.contact.friction, FRICTION)})
    remedies = rsc.remedy(scene, starts=starts)
    text = remedies_text(remedies, scene.title)
    if not remedies.helping:
        return text, bool(remedies.harmful), False, False
    changed, speed = with_remedy(scene, remedies.speed, remedies.helping[0])
    left = harmful_of(rsc.motions(changed, speed, JUDGE, seed=SEED))
    said = "".join(f"\n    FALSE: {motion.motion} remains" for motion in left)
    return text + said, True, True, bool(left)


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--starts", type=int, default=16)
    parser.add_argument("--write", action="store_true", help="write the table to bench/results")
    options = parser.parse_args()
    ill, cured, false, rows = 0, 0, 0, []
    for number in range(options.first, options.first + options.count):
        begun = time.process_time()
        text, harmful, helps, wrong = judged(options.seed, number, options.starts)
        ill, cured, false = ill + harmful, cured + helps, false + wrong
        print(f"{number}: {text}\n{time.process_time() - begun:.0f} s", flush=True)
        first = next((line.strip() for line in text.splitlines() if line.startswith("  ")), "") if helps else ""
        rows.append(f"| {number} | {'yes' if harmful else 'no'} | {first} | {'yes' if wrong else ''} |")
    told = f"{options.count} machines, {ill} with a backward motion that lasts, {cured} with a remedy, {false} of these false."
    print(told)
    if options.write:
        command = f"python bench/remedies.py {options.count} --seed {options.seed} --first {options.first}"
        head = ["| machine | a backward motion lasts | first remedy | false |", "|---|---|---|---|"]
        command, text = f"{command} --starts {options.starts} --write", "\n".join([told, "", *head, *rows])
        write_page(RESULTS / "remedies.md", "First remedies, judged by a new list", command, text)
    return 1 if false else 0


if __name__ == "__main__":
    sys.exit(main())
