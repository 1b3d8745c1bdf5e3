"""First remedies, judged: with the change that `rsc.remedy` puts first, a new list of motions has no backward one that lasts.

    python bench/remedies.py [COUNT] [--seed 1] [--first 0] [--starts 16] [--write]     default 20

Every other machine is one of bench/drive_outcomes.py at a prescribed speed, the others are those of bench/lists_coverage.py, half
of them without a contact diameter; friction from 0.2 on, so that most have a backward motion that lasts. Remedies are looked for
with `--starts` random impacts; the list that judges has 64 others. --write: results/remedies.md, with the number of remedies of
each machine and, where there is none, the furthest that values were changed. Exit code 1 if one of these lists has a backward
motion.
"""

import argparse
import sys
import time
from pathlib import Path

sys.path += [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1] / "tools")]

import rsc
from drive_outcomes import machine
from lists_coverage import machine as coverage_machine
from pages import RESULTS, write_page
from rsc.show.words.remedies import remedies_text
from rsc.study.motions.remedy import harmful_of, with_remedy

JUDGE, SEED = 64, 7  # random impacts of the list that judges, and their seed
FRICTION = 0.2


def judged(seed, number, starts):
    """(Remedies, their text, whether the first is false) of a machine."""
    scene = (machine, coverage_machine)[number % 2](seed, number)
    scene = scene.steady(scene.drive.speed[0]).with_values({"contact.friction": max(scene.contact.friction, FRICTION)})
    remedies = rsc.remedy(scene, starts=starts)
    text = remedies_text(remedies, scene.title)
    if not remedies.helping:
        return remedies, text, False
    changed, speed = with_remedy(scene, remedies.speed, remedies.helping[0])
    left = harmful_of(rsc.motions(changed, speed, JUDGE, seed=SEED))
    said = "".join(f"\n    FALSE: {motion.motion} remains" for motion in left)
    return remedies, text + said, bool(left)


def row_of(number, remedies, wrong):
    """A row of the table."""
    lasts = ", ".join(dict.fromkeys(str(motion.motion) for motion in remedies.harmful)) or "none"
    told = remedies.helping[:1] or remedies.others if remedies.harmful else ()
    changes = ", ".join(f"{own.name} {'times' if own.factor >= 1.0 else 'divided by'} {own.size:.3g}" for own in told)
    first = changes if remedies.helping or not changes else f"none; tried as far as {changes}"
    others = ", ".join(own.name for own in remedies.helping[1:])
    return f"| {number} | {lasts} | {first} | {others} | {'yes' if wrong else ''} |"


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--starts", type=int, default=16)
    parser.add_argument("--write", action="store_true", help="write the table to bench/results, anew after every machine")
    options = parser.parse_args()
    ill, cured, several, false, rows = 0, 0, 0, 0, []
    for number in range(options.first, options.first + options.count):
        begun = time.process_time()
        remedies, text, wrong = judged(options.seed, number, options.starts)
        ill, cured, false = ill + bool(remedies.harmful), cured + bool(remedies.helping), false + wrong
        several += len(remedies.helping) > 1
        print(f"{number}: {text}\n{time.process_time() - begun:.0f} s", flush=True)
        rows.append(row_of(number, remedies, wrong))
        told = f"{len(rows)} machines, {ill} with a backward motion that lasts or runs away, {cured} of them with a remedy, "
        told += f"{several} with more than one; {false} first remedies false."
        if options.write:
            command = f"python bench/remedies.py {len(rows)} --seed {options.seed} --first {options.first}"
            head = ["| machine | backward motions | first remedy | further ones | false |", "|---|---|---|---|---|"]
            command, text = f"{command} --starts {options.starts} --write", "\n".join([told, "", *head, *rows])
            write_page(RESULTS / "remedies.md", "First remedies, judged by a new list", command, text)
    print(told)
    return 1 if false else 0


if __name__ == "__main__":
    sys.exit(main())
