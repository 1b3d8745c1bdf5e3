"""What an integration takes from a free vibration without damping: energy lost per cycle, over tolerance and method.

    python bench/energy.py [--quick] [--write]

A disk without damping swings freely inside its gap at 30 Hz. The energy that is missing in the end, over the number of cycles, is
numerical damping. As a damping ratio (loss per cycle over 4 pi) it should be small beside that of the machine. The last row is a
chain of two masses, 30 Hz and 3 kHz, whose motion between contacts is computed exactly. With --write: results/energy.md.
"""

import argparse
import math
import sys
import time
from pathlib import Path

import rsc

sys.path[:0] = [str(Path(__file__).parents[1] / "tools")]
from pages import RESULTS, write_page  # noqa: E402

FREQUENCY, AMPLITUDE, GAP = 30.0, 2e-4, 1e-3  # Hz, m, m
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
CYCLES, MANY = 3000, 1_000_000
FAST = 100.0  # times, the second mode of the chain
RATE = 250.0  # Hz; exact motion goes from sample to sample


def disk(method, rtol, cycles):
    """A point mass."""
    rotor = {"model": "laval", "mass": 1.0, "frequency": FREQUENCY, "damping": 0.0}
    return _scene(rotor, [[AMPLITUDE, 0.0]], method, rtol, cycles)


def chain(method, rtol, cycles):
    """Two masses on the ground and between them, in its slow mode, in which both move alike."""
    slow = (2.0 * math.pi * FREQUENCY) ** 2
    springs = [slow, 0.5 * slow * (FAST**2 - 1.0), slow]
    rotor = {"model": "chain", "masses": [1.0, 1.0], "stiffnesses": springs, "damping_ratio": 0.0}
    return _scene(rotor, [[AMPLITUDE, 0.0]] * 2, method, rtol, cycles)


def _scene(rotor, start, method, rtol, cycles):
    return rsc.Scene.from_dict({
        "rotor": rotor, "stator": {"model": "rigid"},
        "contact": {"gap": GAP, "friction": 0.1, "stiffness": 1e6, "damping": 0.0},
        "drive": {"speed": 1.0, "duration": cycles / FREQUENCY},
        "start": {"rotor": start}, "solver": {"method": method, "rtol": rtol, "max_steps": 10**9},
        "output": {"rate": RATE, "velocities": True},
    })  # fmt: skip


def lost(scene, cycles):
    """(relative energy lost per cycle, processor time in s), by the amplitude of the slow mode in the end."""
    begun = time.process_time()
    result = rsc.simulate(scene)
    x, v = result.rotor[-1].mean(), result.rotor_velocity[-1].mean()
    energy = (abs(x) ** 2 + abs(v / (2.0 * math.pi * FREQUENCY)) ** 2) / AMPLITUDE**2
    return -math.log(energy) / cycles, time.process_time() - begun


def rows(tolerances, cycles, many):
    """Cells of the table."""
    made = []
    for method in ("rk45", "taylor8"):
        lost(disk(method, 1e-6, 10), 10)  # compiles
        for rtol in tolerances:
            loss, seconds = lost(disk(method, rtol, cycles), cycles)
            made.append((f"disk, {method}", rtol, cycles, loss, seconds))
    lost(chain("rk45", 1e-6, 10), 10)
    made.append(("chain, exact between contacts", 1e-6, many, *lost(chain("rk45", 1e-6, many), many)))
    return made


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few cycles")
    parser.add_argument("--write", action="store_true", help="write results/energy.md")
    options = parser.parse_args()
    made = rows(TOLERANCES[1:2], 100, 1000) if options.quick else rows(TOLERANCES, CYCLES, MANY)
    lines = ["| scene | rtol | cycles | energy lost per cycle | as a damping ratio | processor time, s |", "|" + "---|" * 6]
    lines += [f"| {name} | {rtol:.0e} | {cycles:,} | {loss:.1e} | {loss / (4.0 * math.pi):.1e} | {seconds:.2f} |"
              for name, rtol, cycles, loss, seconds in made]  # fmt: skip
    text = "\n".join(lines)
    print(text)
    if options.write and not options.quick:
        title = "Energy that an integration takes from a free vibration"
        write_page(RESULTS / "energy.md", title, "python bench/energy.py --write", text)


if __name__ == "__main__":
    main()
