"""The smallest impulse of the verdict beside a bisection in 48 directions.

    python bench/smallest_impulses.py [COUNT] [--seed 1] [--first 0] [--directions 48] [--write]     default 20

The machines are those of bench/lists_coverage.py on which random impacts start a whirl of a rotor that runs without contact:
COUNT of them. The verdict prints the smallest impulse that its few directions and bisections found: once for the list that
`rsc.motions` makes, of 64 impacts, once for that of `rsc.check`, of 16. It must be within 10 % of the smallest over all
directions of `rsc.smallest_impulse`, or the sentence must call it an upper bound, and then it is no more than twice that; and
it must start a whirl: where it is below the bisection by more than the 1 % that may lie between two directions, a run of
`rsc.simulate` after that impulse decides.
--write: results/smallest_impulses.md, anew after every machine. Exit code 1 if an impulse is false.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path += [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1] / "tools")]

import rsc
from lists_coverage import machine
from pages import RESULTS, write_page
from rsc.measure.catalogue import WHIRLING
from rsc.measure.final import final_motion
from rsc.measure.severity import verdict_of
from rsc.show.words.verdict import verdict_text
from rsc.study.motions.motions import STARTS
from rsc.study.sweep.compute import STARTS as OF_CHECK

NEAR, BELOW, PERIODS = 0.1, 0.01, 600.0  # of impulses; of a run that decides, of the slower of shaft and free vibration
FAR = 2.0  # times the smallest impulse of the bisection, from which on an upper bound misleads
WIDER = 1.2  # times the smallest impulse of the verdict: largest of the bisection, which begins at a hundredth of it


def starts_a_whirl(scene, impulse, direction):
    """Whether a run after an impulse in N s in a direction in degrees ends in a whirl."""
    hit = impulse * np.exp(1j * np.deg2rad(direction))
    length = PERIODS / min(scene.drive.speed[0], scene.rotor.frequency)
    values = {"start.running": True, "start.impulse": [hit.real, hit.imag], "drive.duration": length, "output.rate": 1e3}
    return final_motion(rsc.simulate(scene.with_values(values)), False).motion in WHIRLING


def judged(scene, listed, smallest):
    """(ratio of the verdict's impulse to the smallest of a bisection, what is false of it or "") of a list of motions."""
    one, text = listed.smallest, verdict_text(verdict_of(None, None, (), [listed]))
    ratio = one.impulse / smallest
    if ratio < 1.0 - BELOW and not starts_a_whirl(scene, one.impulse, one.direction):
        return ratio, "starts no whirl"
    if ratio > 1.0 + NEAR and "an upper bound" not in text:
        return ratio, "is not called an upper bound"
    if ratio > FAR:
        return ratio, "is no bound to act on"
    return ratio, ""


def row_of(scene, directions):
    """(row of the table, [ratio of each list], what is false) of a machine; None where no impact starts a whirl."""
    lists = [rsc.motions(scene, starts=starts, threads=1) for starts in (STARTS, OF_CHECK)]
    if lists[0].smallest is None:
        return None
    largest = WIDER * min(listed.smallest.impulse for listed in lists if listed.smallest)
    try:
        found = rsc.smallest_impulse(scene, directions=directions, largest=largest, threads=1)
    except rsc.SceneError:  # it touches while it runs
        return None
    if found.undisturbed in WHIRLING:
        return None
    if found.weakest is None:
        return f"none | none up to {largest:.4g} | | | | starts no whirl |", [np.nan, np.nan], ["starts no whirl"]
    smallest = float(found.impulse[found.weakest])
    told = [judged(scene, listed, smallest) if listed.smallest else None for listed in lists]
    cells = [f"{listed.smallest.impulse:.4g} ({own[0]:.2f})" if own else "none" for listed, own in zip(lists, told, strict=True)]
    harder = np.nanmax(found.impulse) / smallest
    false = [own[1] for own in told if own and own[1]]
    row = f"{found.motion[found.weakest]} | {smallest:.4g} | {harder:.2f} | {' | '.join(cells)} | {', '.join(false)} |"
    return row, [own[0] if own else np.nan for own in told], false


def lines_of(rows, ratios, false):
    """Lines of Markdown."""
    text = f"{len(rows)} machines, {false} false impulses. "
    for i, starts in enumerate((STARTS, OF_CHECK)):
        own = np.array([pair[i] for pair in ratios])
        known = own[np.isfinite(own)]
        text += f"List of {starts} impacts: {(np.abs(known - 1.0) <= NEAR).sum()} of {len(known)} within 10 % of the bisection, "
        text += f"median {np.median(known):.2f}, largest {known.max():.2f} times it; " if len(known) else "none found; "
    head = "| machine | starts | bisection, N s | hardest over weakest direction | verdict of 64 impacts | of 16 | false |"
    return [text.rstrip("; ") + ".", "", head, "|---|---|---|---|---|---|---|", *rows]


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", nargs="?", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--directions", type=int, default=48)
    parser.add_argument("--write", action="store_true", help="write the table to bench/results")
    options = parser.parse_args()
    rows, ratios, wrong, number = [], [], 0, options.first
    while len(rows) < options.count:
        begun = time.process_time()
        told = row_of(machine(options.seed, number), options.directions)
        if told is not None:
            row, own, false = told
            rows.append(f"| {number} | {row}")
            ratios.append(own)
            wrong += len(false)
            print(f"{rows[-1]} {time.process_time() - begun:.0f} s", flush=True)
            if options.write:
                command = f"python bench/smallest_impulses.py {len(rows)} --seed {options.seed} --first {options.first}"
                command, text = f"{command} --directions {options.directions} --write", "\n".join(lines_of(rows, ratios, wrong))
                write_page(RESULTS / "smallest_impulses.md", "The smallest impulse of the verdict", command, text)
        number += 1
    print(lines_of(rows, ratios, wrong)[0])
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
