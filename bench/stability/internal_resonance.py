"""Bouncing without friction: where internal resonance lets an unbalanced rotor bounce on a rigid ring.

    python bench/stability/internal_resonance.py [--quick] [--write]

Shaw, Champneys and Friswell (Proc. R. Soc. A 472 (2016) 20160303): seen from the rotating frame, an unbalanced rotor stands still
and its free vibrations have the frequencies w_i - W. Where two of them are nearly p : q it can bounce on the ring, whose contacts
move both frequencies away from 0. Here the motions that last are looked for at many speeds and dampings (`rsc.motions`), one
impact that ends in each bouncing motion is simulated again, and the ratio of its two strongest lines is set beside the speed at
which the free vibrations have this ratio. With --write: bench/results/internal_resonance.md.
"""

import argparse
import itertools
import math
import sys
from pathlib import Path

import numpy as np

import rsc
from rsc.measure.kinds import Kind

sys.path[:0] = [str(Path(__file__).parents[2] / "tools")]
from pages import RESULTS, write_page  # noqa: E402

GAP = 1e-3
SCENE = {
    "title": "A disk overhung in a rigid ring, without friction",
    "rotor": {"model": "disk", "mass": 1.0, "diametral_inertia": 0.010, "polar_inertia": 0.016,
              "stiffness": [[70e3, -3200.0], [-3200.0, 1300.0]], "damping_ratio": 0.002, "eccentricity": 1e-4},
    "stator": {"model": "rigid"},
    "contact": {"gap": GAP, "friction": 0.0, "stiffness": 7e5, "damping_ratio": 0.0},
    "drive": {"speed": 50.0, "duration": 8.0},
    "start": {"running": True},
}  # fmt: skip
DAMPINGS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05)
SPEEDS = np.arange(50.0, 151.0, 4.0)  # Hz
STARTS = 16
LARGEST = 5  # of p and q
TAIL = 2.0  # s of the end of a run that is measured


def bouncing(scene, speed):
    """(motion, its two strongest lines in Hz, seen from the rotating frame) of the bouncing motions that impacts start."""
    found, kept = rsc.motions(scene, speed, starts=STARTS), []
    for number, motion in enumerate(found):
        hits = np.flatnonzero(found.ended == number)
        if motion.motion == Kind.PARTIAL_RUB and 0.0 < motion.contact_share < 1.0 and hits.size:
            start = {"drive.speed": speed, "start.impulse": found.impulse[hits[0]].tolist()}
            kept.append((motion, lines(rsc.simulate(scene.with_values(start)), speed)))
    return kept


def lines(result, speed):
    """The two strongest lines of the end of a run, seen from the rotating frame, in Hz."""
    last = result.time > result.time[-1] - TAIL
    turning = result.contact_rotor()[last] * np.exp(-2j * np.pi * speed * result.time[last])
    size = np.abs(np.fft.fft((turning - turning.mean()) * np.hanning(turning.size)))
    frequency = np.fft.fftfreq(turning.size, result.time[1] - result.time[0])
    first = int(np.argmax(size))
    size[np.abs(frequency - frequency[first]) < 4.0 / TAIL] = 0.0
    return frequency[first], frequency[int(np.argmax(size))]


def family(first, second):
    """(p, q) of two lines whose ratio is that of small numbers, None of others."""
    low, high = sorted((abs(first), abs(second)))
    p, q = min(((p, q) for q in range(2, LARGEST + 1) for p in range(1, q) if math.gcd(p, q) == 1),
               key=lambda pair: abs(low / high - pair[0] / pair[1]))  # fmt: skip
    return (p, q) if abs(low / high - p / q) < 1.0 / (TAIL * high) else None


def resonances(scene, speeds):
    """(p, q) -> rotor speed in Hz at which the first forward and the first backward vibration are p : q."""
    first = []
    for speed in speeds:
        modes = [mode.frequency for mode in rsc.modes(scene, float(speed)).rotor]
        first.append((min(f for f in modes if f > 0.0), min(modes)))  # the lower backward one is the disk's tilting
    forward, backward = np.array(first).T
    share = (speeds - forward) / (speeds - backward)
    pairs = [(p, q) for q in range(2, LARGEST + 1) for p in range(1, q) if math.gcd(p, q) == 1]
    return {(p, q): float(np.interp(p / q, share, speeds)) for p, q in pairs if share.min() < p / q < share.max()}


def found_at(dampings, speeds):
    """Rows (damping, speed, motion, lines) of every bouncing motion."""
    rows = []
    for damping, speed in itertools.product(dampings, speeds):
        scene = rsc.Scene.from_dict(SCENE).with_values({"rotor.damping_ratio": damping})
        rows += [(damping, speed, motion, pair) for motion, pair in bouncing(scene, float(speed))]
    return rows


def table(rows, expected, dampings):
    """The text of the page."""
    told = ["| ratio | speed of the relation, Hz | " + " | ".join(f"damping ratio {damping:g}" for damping in dampings) + " |",
             "|" + "---|" * (2 + len(dampings))]  # fmt: skip
    for pair, speed in expected.items():
        at = [[row[1] for row in rows if row[0] == damping and family(*row[3]) == pair] for damping in dampings]
        cells = [f"{min(each):g} to {max(each):g} Hz" if each else "-" for each in at]
        told.append(f"| {pair[0]} : {pair[1]} | {speed:.1f} | " + " | ".join(cells) + " |")
    others = [row for row in rows if family(*row[3]) not in expected]
    told += ["", f"{len(rows)} bouncing motions, {len(others)} of them with other lines.", ""]
    told += ["| damping ratio | W, Hz | |r|/gap | in contact | lines, Hz | ratio |", "|---|---|---|---|---|---|"]
    for damping, speed, motion, (first, second) in rows:
        own = family(first, second)
        sizes = f"{motion.amplitude_min / GAP:.2f} .. {motion.amplitude_max / GAP:.2f} | {100.0 * motion.contact_share:.0f} %"
        ratio = f"{own[0]} : {own[1]}" if own else f"{min(abs(first), abs(second)) / max(abs(first), abs(second)):.3f}"
        told.append(f"| {damping:g} | {speed:g} | {sizes} | {first + speed:.1f} and {second + speed:.1f} | {ratio} |")
    return "\n".join(told) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one damping, two speeds")
    parser.add_argument("--write", action="store_true", help="write bench/results/internal_resonance.md")
    options = parser.parse_args()
    dampings, speeds = (DAMPINGS[1:2], SPEEDS[20:22]) if options.quick else (DAMPINGS, SPEEDS)
    expected = resonances(rsc.Scene.from_dict(SCENE), SPEEDS)
    text = table(found_at(dampings, speeds), expected, dampings)
    print(text)
    if options.write and not options.quick:
        command = "python bench/stability/internal_resonance.py --write"
        write_page(RESULTS / "internal_resonance.md", "Bouncing without friction", command, text)


if __name__ == "__main__":
    main()
