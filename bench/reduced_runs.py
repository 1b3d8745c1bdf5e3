"""Simulations of random machines, reduced and with all their coordinates, in and out of contact.

    python bench/reduced_runs.py [MACHINES] [--seed 1] [--write]      default 10; --write keeps it in bench/results

Asked: the motions at the contact differ by no more than ten times the tolerance of the reduction. The band of each reduction
reaches beyond the frequency with which the contact vibrates. The rotor runs up from rest: an unbalance that acts at once would
excite every frequency of the full body. Full bodies are brought to coordinates of equal mass whose first is the displacement at
the contact, as reduced ones are, so that both are scenes of the same form.

Beside the difference stand two more, each of which asks why it is large. One is of the full machine alone, with an unbalance
larger by the tolerance: what a motion makes of a change of that size. The other is again reduced against full, both without the
contact's damper: its force jumps when contact begins, which excites frequencies beyond every band.
"""

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import rsc
from rsc.errors import ReductionError
from rsc.machine.body import checked
from rsc.machine.reduction import contact_coordinates, reduce, turned
from rsc.study.start import run_of
from rsc.system.blas import one_thread

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "support")]

from machines import random_machine  # noqa: E402
from pages import RESULTS, write_page  # noqa: E402

# turns of the rotor while it runs up and in all; contact stiffness over that of both bodies in series
TOLERANCE, RUN_UP, TURNS, STIFFER = 1e-4, 5.0, 20.0, 10.0
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


def scene_of(bodies, machine, stiffness, gap, damping_ratio=0.1):
    """Scene of two bodies that run up to the highest speed, with a gap in m."""
    rotor, stator = (table(body, machine.band, machine.speeds, i == 0) for i, body in enumerate(bodies))
    speed = machine.speeds[1] / TWO_PI
    return rsc.Scene.from_dict(
        {
            "rotor": rotor,
            "stator": stator,
            "contact": {"gap": gap, "friction": 0.1, "stiffness": stiffness, "damping_ratio": damping_ratio, "diameter": 0.1},
            "drive": {"schedule": [[0.0, 0.0], [RUN_UP / speed, speed], [TURNS / speed, speed]]},
            "solver": {"method": "taylor8", "rtol": 1e-8},
            "output": {"rate": 200.0 * speed},
        }
    )


def exact(body):
    """The body in contact coordinates, all of them."""
    body = checked(body)
    turn, mass = contact_coordinates(body)
    return turned(body, turn, mass)


def difference(one, other):
    """Largest difference of two motions at the contact over the largest motion of the other."""
    a, b = one.contact_rotor(), other.contact_rotor()
    n = min(len(a), len(b))
    return float(np.abs(a[:n] - b[:n]).max() / np.abs(b).max())


def row_of(number, machine):
    """A line of the table, and the three differences."""
    full = [exact(body) for body in machine[:2]]
    compliance = sum(float(np.linalg.solve(body.stiffness, body.contact) @ body.contact) for body in full)
    stiffness = STIFFER / compliance
    vibrates = np.sqrt(stiffness / min(body.mass[0, 0] for body in full))
    band = (min(machine.band[0], -REACH * vibrates), max(machine.band[1], REACH * vibrates))
    machine = machine._replace(band=band)
    small = [reduce(body, band, machine.speeds, TOLERANCE).body for body in machine[:2]]
    gap = CLOSER * np.abs(rsc.simulate(scene_of(small, machine, stiffness, 1.0)).contact_rotor()).max()

    def runs(damping_ratio, *pairs):
        return [rsc.simulate(scene_of(bodies, machine, stiffness, gap, damping_ratio)) for bodies in pairs]

    more = [replace(full[0], unbalance=full[0].unbalance * (1.0 + TOLERANCE)), full[1]]
    for bodies in (small, full):
        run_of(scene_of(bodies, machine, stiffness, gap)).compile()
    seconds, damped = [], []
    for bodies in (small, full):
        begun = time.process_time()
        damped += runs(0.1, bodies)
        seconds.append(time.process_time() - begun)
    found = difference(*damped), difference(*runs(0.1, more), damped[1]), difference(*runs(0.0, small, full))
    sizes = [sum(body.n_coordinates for body in bodies) for bodies in (full, small)]
    texts = " | ".join(f"{one:.1e}" for one in found)
    first = f"| {number} | {sizes[0]} | {sizes[1]} | {damped[1].contact_onsets} | {texts} |"
    return f"{first} {damped[1].steps} | {damped[0].steps} | {seconds[1] / seconds[0]:.0f} |", found


def counted(found, machines):
    """Sentences on all machines."""
    asked, sensitive, undamped = np.array(found).T
    limit = 10.0 * TOLERANCE
    close, others = asked <= limit, asked > limit
    times = asked / np.maximum(sensitive, TOLERANCE)
    return [
        f"{np.sum(close)} of {machines} motions at the contact differ by at most {limit:g} of the motion, "
        f"{np.sum(times <= 10.0)} by at most ten times what the larger unbalance changes; the largest of these ratios is "
        f"{times.max():.1f}, the median {np.median(times):.2f}.",
        f"Of the {np.sum(others)} others {np.sum(undamped[others] <= limit)} are within it without the contact's damper, "
        f"{np.sum(sensitive[others] > limit)} are changed by more than that by the larger unbalance alone.",
        f"Without the damper {np.sum(undamped <= limit)} of {machines} are within it.",
    ]


@one_thread
def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("machines", nargs="?", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    lines = [
        "| machine | coordinates | reduced | contacts | difference | by a larger unbalance | without damper | steps | reduced | "
        "times as fast |",
        "|---" * 10 + "|",
    ]
    found = []
    for number in range(options.machines):
        machine = random_machine(rng, least=6, most=20)
        try:
            line, differences = row_of(number, machine)
            found.append(differences)
        except (rsc.RscError, ReductionError) as error:
            line = f"| {number} | refused: {error} |" + 8 * " |"
        lines.append(line)
        print(line, flush=True)
    lines += ["", *counted(found, options.machines)]
    print("\n".join(lines[-3:]))
    if options.write:
        command = f"python bench/reduced_runs.py {options.machines} --seed {options.seed} --write"
        write_page(RESULTS / "reduced_runs.md", "Random machines, reduced and not", command, "\n".join(lines))


if __name__ == "__main__":
    main()
