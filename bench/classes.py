"""What coordinates at rest cost that fill a reduced scene up to its class, and what a first call of a class takes.

    python bench/classes.py            prints the table
    python bench/classes.py --write    keeps it in bench/results/classes.md

A rotor of full random matrices with gyroscopics and springs that differ by direction, which is what a reduction leaves of a rotor
on unequal bearings, in a stator of one mass, at one speed from rest. Processor seconds of one process: the first call of every
number of coordinates in an empty folder of compiled code, then the least of some runs.
"""

import argparse
import os
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

os.environ["XDG_CACHE_HOME"] = tempfile.mkdtemp(prefix="rsc-classes-")  # before rsc looks for compiled code

import numpy as np

import rsc
from rsc.simulation.lines import filled, size_of_class
from rsc.simulation.pack import pack
from rsc.simulation.run import Run
from rsc.study.start import initial_state
from rsc.system.assemble import assemble

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "tools")]

from pages import RESULTS, write_page  # noqa: E402

RUNS, DURATION = 9, 10.0
SIZES = (5, 7, 9, 10, 13, 14, 15, 17, 19, 21, 22, 25, 29, 33)


def matrix(rng, n, size):
    """A positive definite matrix (n, n)."""
    part = rng.normal(size=(n, n))
    return size * (part @ part.T / n + np.eye(n))


def scene_of(n, method):
    """A scene of n coordinates."""
    rng, n_rotor = np.random.default_rng(n), n - 1
    sizes = {"stiffness": 1e6, "damping": 50.0, "gyroscopic": 0.05}
    rotor = {name: matrix(rng, n_rotor, size).tolist() for name, size in sizes.items()}
    rotor |= {"anisotropic_stiffness": [[[x, 0.0] for x in row] for row in matrix(rng, n_rotor, 1e4).tolist()]}
    rotor |= {"model": "reduced", "mass": 10.0, "origin": "random", "coordinates_before": 99, "tolerance": 1e-4, "error": 0.0}
    rotor |= {"band": [-500.0, 500.0], "speeds": [0.0, 100.0], "highest_before": 1.0, "highest_after": 1.0}
    rotor |= {"unbalance": [[1e-3, 0.0]] + (n_rotor - 1) * [[0.0, 0.0]], "load": n_rotor * [[0.0, 0.0]]}
    return rsc.Scene.from_dict(
        {
            "rotor": rotor,
            "stator": {"model": "laval", "mass": 3.0, "frequency": 60.0, "damping_ratio": 0.05},
            "contact": {"gap": 1e-4, "friction": 0.1, "stiffness": 1e7, "damping_ratio": 0.05},
            "drive": {"speed": 45.0, "duration": DURATION},
            "solver": {"method": method, "rtol": 1e-7},
            "output": {"rate": 500.0},
            "start": {"rest": True},
        }
    )


def seconds(scene, fill):
    """First call in s, and a step in microseconds, of processor time; by itself or filled."""
    system = assemble(scene)
    packed = pack(system, scene.solver, scene.output.rate)
    packed = replace(packed, model=filled(packed.model)) if fill else packed
    begun = time.process_time()
    Run(scene, system, packed, initial_state(scene, system)).compile()
    first, best = time.process_time() - begun, float("inf")
    for _ in range(RUNS):
        run = Run(scene, system, packed, initial_state(scene, system))
        begun = time.process_time()
        for _ in run.chunks():
            pass
        best = min(best, time.process_time() - begun)
    return first, 1e6 * best / run.summary("finished").steps


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    lines = [
        "| method | coordinates | first call, s | a step, us | filled to | first call, s | a step, us | ratio |",
        "|---" * 8 + "|",
    ]
    for method in ("rk45", "taylor8"):
        for n in SIZES:
            own, other = (seconds(scene_of(n, method), fill) for fill in (False, True))
            lines.append(
                f"| {method} | {n} | {own[0]:.2f} | {own[1]:.2f} | {size_of_class(n)} | {other[0]:.2f} | {other[1]:.2f} | "
                f"{other[1] / own[1]:.2f} |"
            )
            print(lines[-1], flush=True)
    if options.write:
        command = "python bench/classes.py --write"
        write_page(RESULTS / "classes.md", "Classes of numbers of coordinates", command, "\n".join(lines))


if __name__ == "__main__":
    main()
