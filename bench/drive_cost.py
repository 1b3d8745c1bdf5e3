"""What a step costs with a drive that gives way, beside that of the same motion with its speed prescribed.

    python bench/drive_cost.py [--repeats 15] [--attempts 60000] [--write]

A Laval rotor on its whirl, so heavy (1e12 kg m2) that both runs are one motion. The angle and the speed are two more numbers of
the state, which fill another vector register; so the same motion is timed with a coordinate more as well (a mass of 1e-3 kg that
nothing but its own spring touches), prescribed. All take turns; of each the least processor time counts. --write: the page
bench/results/drive_cost.md.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.append(str(ROOT / "tools"))

import rsc  # noqa: E402
from pages import RESULTS, write_page  # noqa: E402
from rsc.simulation.shot import Shot, packed_for_shots  # noqa: E402
from rsc.study.run.start import initial_state  # noqa: E402
from rsc.system.assemble import assemble  # noqa: E402

MASS, OMEGA, RATIO = 12.0, 2.0 * np.pi * 43.0, 0.02
LAVAL = {"model": "laval", "mass": MASS, "stiffness": MASS * OMEGA**2, "damping_ratio": RATIO, "eccentricity": 5e-6}
PAIR = np.diag([MASS, 1e-3])
WIDER = {
    "model": "matrices", "mass": PAIR.tolist(), "stiffness": (OMEGA**2 * PAIR).tolist(),
    "damping": (2.0 * RATIO * OMEGA * PAIR).tolist(), "eccentricity": [5e-6, 0.0],
}  # fmt: skip
STATOR = {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1}
CONTACT = {"gap": 2.5e-4, "stiffness": 5e7, "friction": 0.2, "diameter": 0.08}
STEADY = {"speed": 50.0, "duration": 100.0}
DRIVEN = {"inertia": 1e12, "torque": [[0.0, 0.0], [100.0, 0.0]], **STEADY}
CASES = {
    "speed prescribed": (LAVAL, STEADY),
    "prescribed, a coordinate more": (WIDER, STEADY),
    "drive with a torque": (LAVAL, DRIVEN),
}


METHODS = ("rk45", "taylor8")


def shot_of(method, rotor, drive):
    """A function that makes a Shot of a run that begins on the stable whirl."""
    tables = {"rotor": rotor, "stator": STATOR, "contact": CONTACT, "drive": drive, "solver": {"method": method, "rtol": 1e-6}}
    scene = rsc.Scene.from_dict(tables)
    (whirl, *_) = [whirl for whirl in rsc.predict(scene) if whirl.stable]
    scene = scene.with_values({"start.whirl": whirl.frequency})
    system = assemble(scene)
    packed, start = packed_for_shots(system, scene, 1.0), initial_state(scene, system)
    return lambda: Shot(packed, start)


def nanoseconds(shots, repeats, attempts):
    """Case -> least processor time of an attempted step in ns."""
    least = dict.fromkeys(shots, np.inf)
    for _ in range(repeats):
        for name, make in shots.items():
            shot = make()
            shot.advance(2_000)  # compiled, in the cache, past the first steps
            begin = time.process_time()
            shot.advance(attempts)
            least[name] = min(least[name], 1e9 * (time.process_time() - begin) / attempts)
    return least


def main():
    """Print the table, or write it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--attempts", type=int, default=60_000)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    rows = ["| rtol 1e-6, whirl in contact | method | ns per step | ratio |", "|---|---|---|---|"]
    for method in METHODS:
        shots = {name: shot_of(method, *case) for name, case in CASES.items()}
        least = nanoseconds(shots, options.repeats, options.attempts)
        base = least["speed prescribed"]
        rows += [f"| {name} | {method} | {value:.0f} | {value / base:.2f} |" for name, value in least.items()]
    text = "\n".join(rows)
    print(text)
    if options.write:
        command, page = "python bench/drive_cost.py --write", RESULTS / "drive_cost.md"
        write_page(page, "Cost of a step with a drive", command, text)


if __name__ == "__main__":
    main()
