"""Simulations of random machines, reduced and with all their coordinates, in and out of contact.

    python bench/reduced_runs.py [MACHINES] [--seed 1] [--write]      default 10; --write keeps it in bench/results

Asked: the motions at the contact differ by no more than ten times the tolerance of the reduction. The band of each reduction
reaches beyond the frequency with which the contact vibrates. Full bodies are brought to coordinates of equal mass whose first is
the displacement at the contact, as reduced ones are, so that both are scenes of the same form.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

import rsc
from rsc.errors import ReductionError
from rsc.machine.body import checked
from rsc.machine.reduction import contact_coordinates, reduce, turned
from rsc.system.blas import one_thread

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "support")]

from machines import random_machine  # noqa: E402
from pages import RESULTS, write_page  # noqa: E402

TOLERANCE, TURNS, STIFFER = 1e-4, 15.0, 10.0  # turns of the rotor in a run; contact stiffness over that of both bodies in series
REACH = 6.0  # band over the frequency with which the contact vibrates
CLOSER = 0.7  # gap over the largest motion without contact
TWO_PI = 2.0 * np.pi


def table(body, band, speeds, rotor):
    """[rotor] or [stator] of a body in contact coordinates."""
    matrices = {name: getattr(body, name) for name in ("stiffness", "damping", "skew_stiffness", "skew_damping")}
    matrices |= {"gyroscopic": body.gyroscopic} if rotor else {}
    content = {name: matrix.tolist() for name, matrix in matrices.items() if matrix is not None}
    content |= {"model": "reduced", "mass": float(body.mass[0, 0]), "origin": "random", "coordinates_before": 1}
    content |= {"tolerance": TOLERANCE, "error": 0.0, "band": [f / TWO_PI for f in band], "speeds": [f / TWO_PI for f in speeds]}
    content |= {"highest_before": 1.0, "highest_after": 1.0}
    if rotor:
        pairs = ([[float(v.real), float(v.imag)] for v in vector] for vector in (body.unbalance.sum(axis=1), 0.0 * body.load))
        content |= dict(zip(("unbalance", "load"), pairs, strict=True))
    return content


def scene_of(bodies, machine, stiffness, gap):
    """Scene of two bodies at the highest speed, from rest, with a gap in m."""
    rotor, stator = (table(body, machine.band, machine.speeds, i == 0) for i, body in enumerate(bodies))
    speed = machine.speeds[1] / TWO_PI
    return rsc.Scene.from_dict(
        {
            "rotor": rotor,
            "stator": stator,
            "contact": {"gap": gap, "friction": 0.1, "stiffness": stiffness, "damping_ratio": 0.1, "diameter": 0.1},
            "drive": {"speed": speed, "duration": TURNS / speed},
            "solver": {"method": "taylor8", "rtol": 1e-8},
            "output": {"rate": 200.0 * speed},
        }
    )


def exact(body):
    """The body in contact coordinates, all of them."""
    body = checked(body)
    turn, mass = contact_coordinates(body)
    return turned(body, turn, mass)


def row_of(number, machine):
    """A line of the table, and whether the two motions are as close as asked."""
    full = [exact(body) for body in machine[:2]]
    compliance = sum(float(np.linalg.solve(body.stiffness, body.contact) @ body.contact) for body in full)
    stiffness = STIFFER / compliance
    vibrates = np.sqrt(stiffness / min(body.mass[0, 0] for body in full))
    band = (min(machine.band[0], -REACH * vibrates), max(machine.band[1], REACH * vibrates))
    machine = machine._replace(band=band)
    small = [reduce(body, band, machine.speeds, TOLERANCE).body for body in machine[:2]]
    free = np.abs(rsc.simulate(scene_of(small, machine, stiffness, 1.0)).contact_rotor()).max()
    runs, seconds = [], []
    for bodies in (small, full):
        scene = scene_of(bodies, machine, stiffness, CLOSER * free)
        rsc.simulate(scene.with_values({"drive.duration": 1e-3 * scene.drive.duration}))  # compiles
        begun = time.process_time()
        runs.append(rsc.simulate(scene))
        seconds.append(time.process_time() - begun)
    a, b = (run.contact_rotor() for run in runs)
    n = min(len(a), len(b))
    difference = float(np.abs(a[:n] - b[:n]).max() / np.abs(b).max())
    sizes = [sum(body.n_coordinates for body in bodies) for bodies in (full, small)]
    steps = [run.steps for run in runs]
    line = f"| {number} | {sizes[0]} | {sizes[1]} | {runs[1].contact_releases} | {difference:.1e} | {steps[1]} | {steps[0]} | "
    return f"{line}{seconds[1] / seconds[0]:.0f} |", difference <= 10.0 * TOLERANCE


@one_thread
def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("machines", nargs="?", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    lines = [
        "| machine | coordinates | reduced | contacts | difference | steps | reduced | times as fast |",
        "|---|---|---|---|---|---|---|---|",
    ]
    close = 0
    for number in range(options.machines):
        machine = random_machine(rng, least=6, most=20)
        try:
            line, fine = row_of(number, machine)
        except (rsc.RscError, ReductionError) as error:
            line, fine = f"| {number} | refused: {error} | | | | | | |", False
        close += fine
        lines.append(line)
        print(line, flush=True)
    lines += ["", f"{close} of {options.machines} motions at the contact differ by at most {10 * TOLERANCE:g} of the motion."]
    print(lines[-1])
    if options.write:
        command = f"python bench/reduced_runs.py {options.machines} --seed {options.seed} --write"
        write_page(RESULTS / "reduced_runs.md", "Random machines, reduced and not", command, "\n".join(lines))


if __name__ == "__main__":
    main()
