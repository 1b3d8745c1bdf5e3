"""Predicted stability of the whirls of random scenes beside the simulator: verdict and growth rate.

    python bench/stability/stability_census.py [SCENES]           counts, and a line for each disagreement with its cause
    python bench/stability/stability_census.py [SCENES] --write    keeps both in bench/results

Random rotors of 1 to 3 and stators of 1 or 2 coordinates without unbalance and contact damping (the law is smooth in
contact). Each whirl is started off by 0.1 % of its penetration along its fastest mode, with 0.2 % of that at random.
The simulated growth rate is the slope of the logarithm of the distance from the whirl, without what the fastest mode alone
would show. A disagreement is looked at in two ways that share nothing: the linear motion of the same start with all of its
modes, and a run started on the fastest mode alone with a tenth of the disturbance.
"""

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

import rsc
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.small_motions import small_motion
from rsc.analysis.paper.stability import state_matrices, whirl_growth
from rsc.system.assemble import assemble

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tools")]

from pages import RESULTS, write_page  # noqa: E402

TWO_PI = 2.0 * np.pi
SPEED = 50.0
# a verdict needs a growth rate that shows within the longest run
LEAST_RATE, LONGEST = 0.2, 12.0
_RANDOM = 0.002
# growth rates are compared where they are this large against the whirl frequency in rad/s
CLEAR = 0.05
CLOSE = 0.02
NAMES = ("whirls", "too slow", "verdict agrees", "verdict differs", "rates compared", "within 2 %")


def random_scene(rng):
    """A scene of the matrices model with a random body on either side."""
    bodies = {}
    ratio = 10.0 ** rng.uniform(-2.5, -1.0)
    for name, n in (("rotor", rng.integers(1, 4)), ("stator", rng.integers(1, 3))):
        mass = np.diag(10.0 ** rng.uniform(-0.7, 0.7, n))
        omega = TWO_PI * 10.0 ** rng.uniform(1.0, 2.3, n)
        shape = np.sqrt(mass) @ np.linalg.qr(rng.normal(size=(n, n)))[0]
        damping, stiffness = (shape @ np.diag(d) @ shape.T for d in (2.0 * ratio * omega, omega**2))
        matrices = {"mass": mass, "damping": 0.5 * (damping + damping.T), "stiffness": 0.5 * (stiffness + stiffness.T)}
        bodies[name] = {"model": "matrices", **{key: m.tolist() for key, m in matrices.items()}}
    n = len(bodies["rotor"]["mass"])
    polar = np.diag(rng.uniform(0.0, 1.5, n) * np.diag(bodies["rotor"]["mass"]) * (np.arange(n) > 0))
    bodies["rotor"] |= {"gyroscopic": polar.tolist(), "eccentricity": [0.0] * n}
    contact = {"gap": 1e-3, "friction": float(10.0 ** rng.uniform(-1.3, -0.1)), "stiffness": 3e6, "damping": 0.0}
    drive = {"speed": SPEED, "duration": 1.0}
    return {**bodies, "contact": contact, "drive": drive, "solver": {"rtol": 1e-10}, "output": {"rate": 2000.0}}


class Run(NamedTuple):
    """Distances (n_time,) from a whirl of one run: simulated, of the fastest mode, and of all modes of its start."""

    time: np.ndarray
    simulated: np.ndarray
    of_mode: np.ndarray
    of_all: np.ndarray


def disturbed(content, system, whirl, noise, run):
    """A Run of (duration, share of the penetration), started off the whirl by its fastest mode and noise * share."""
    duration, share = run
    n_rotor = system.n_rotor
    shape = np.concatenate([whirl.rotor_shape, whirl.stator_shape])
    Psi = TWO_PI * whirl.frequency
    mode = small_motion(system, Psi, whirl.normal_force, TWO_PI * SPEED)
    size = share * whirl.normal_force / system.law.stiffness
    rates = np.array([mode.eigenvalue, np.conj(mode.eigenvalue)])
    lines = mode.lines * (1.0 if mode.eigenvalue.imag else np.array([[1.0], [0.0]]))
    off, off_rate = lines.sum(axis=0), rates @ lines
    scale = size / np.abs(off).max()
    dx, dv = scale * off + size * noise, scale * off_rate
    x, v = shape + dx, 1j * Psi * (shape + dx) + dv
    parts = {"rotor": x[:n_rotor], "stator": x[n_rotor:], "rotor_velocity": v[:n_rotor], "stator_velocity": v[n_rotor:]}
    start = {key: [[float(z.real), float(z.imag)] for z in part] for key, part in parts.items()}
    scene = {**content, "start": {**start, "allow_penetration": True}, "drive": {"speed": SPEED, "duration": duration}}
    scene["output"] = {"rate": max(2000.0, 1000.0 / duration)}
    result = rsc.simulate(rsc.Scene.from_dict(scene))
    motion = np.hstack([result.rotor, result.stator])
    of_mode = scale * np.exp(np.outer(result.time, rates)) @ lines
    of_all = linear_motion(system, whirl, dx, dv, result.time)
    return Run(result.time, *(_distance(rows, shape) for rows in (motion, shape + of_mode, shape + of_all)))


def linear_motion(system, whirl, dx, dv, time):
    """Small motion (n_time, n) about a whirl, in its frame, from dx with the rate dv, with all modes."""
    n, Psi = len(dx), TWO_PI * whirl.frequency
    matrix = state_matrices(system, np.array([Psi]), np.array([whirl.normal_force]), TWO_PI * SPEED, 0.0)[0]
    rates, modes = np.linalg.eig(matrix)
    parts = np.linalg.solve(modes, np.concatenate([dx.real, dx.imag, dv.real, dv.imag]) + 0j)
    state = np.exp(np.outer(time, rates)) @ (parts * modes).T
    return state[:, :n].real + 1j * state[:, n : 2 * n].real


def _distance(motion, shape):
    """Distance of motions (n_time, n) from a circular motion of this shape, whatever its phase."""
    overlap = motion @ shape.conj()
    return np.linalg.norm(motion - (overlap / np.abs(overlap))[:, None] * shape, axis=1)


def slope(time, distance):
    """Growth rate of a distance, by a straight line through its logarithm after the first fifth."""
    late = time >= 0.2 * time[-1]
    return np.polyfit(time[late], np.log(distance[late]), 1)[0]


def judged(content, system, whirl, noise):
    """(simulated rate, predicted rate, None or the cause of their difference), or None where the rate is too small to see."""
    Psi = TWO_PI * whirl.frequency
    rate = whirl_growth(system, Psi, whirl.normal_force, TWO_PI * SPEED).rate
    if abs(rate) < LEAST_RATE:
        return None
    # growing: stay at small motions; decaying: stay above the tolerance
    duration = min(2.5 / abs(rate), LONGEST)
    run = disturbed(content, system, whirl, noise, (duration, 1e-3))
    # both wave alike within the mode's own periods
    ripple = rate - slope(run.time, run.of_mode)
    found = slope(run.time, run.simulated) + ripple
    if abs(rate) <= CLEAR * abs(Psi) or abs(found / rate - 1.0) < CLOSE:
        return found, rate, None
    alone = disturbed(content, system, whirl, 0.0 * noise, (duration, 1e-4))
    of_alone = slope(alone.time, alone.simulated) - slope(alone.time, alone.of_mode) + rate
    middle = len(run.time) // 2
    others = abs(run.of_all[middle] / run.of_mode[middle] - 1.0)
    return found, rate, (slope(run.time, run.of_all) + ripple, of_alone, others)


def cause(found, rate, proof):
    """In words what a disagreement is from: (all modes, fastest mode alone, other modes' effect on the distance) prove it."""
    of_all, of_alone, _ = proof
    if abs(of_alone / rate - 1.0) > 0.1 * CLOSE:
        return "not explained"
    if abs(found - of_all) < 0.5 * abs(found - rate):
        return "other modes, started by the random part"
    return "not linear"


def main():
    """Count agreements and explain the disagreements."""
    numbers = [int(item) for item in sys.argv[1:] if item.isdigit()]
    n_scenes = numbers[0] if numbers else 200
    rng = np.random.default_rng(20)
    counts, lines = dict.fromkeys(NAMES, 0), []
    scenes = 0
    while scenes < n_scenes:
        content = random_scene(rng)
        system = assemble(rsc.Scene.from_dict(content))
        whirls = [w for w in predict_system(system, SPEED) if w.frequency < 0.0]
        scenes += bool(whirls)
        for whirl in whirls:
            counts["whirls"] += 1
            n = len(whirl.rotor_shape) + len(whirl.stator_shape)
            found = judged(content, system, whirl, _RANDOM * (rng.normal(size=n) + 1j * rng.normal(size=n)))
            if found is None:
                counts["too slow"] += 1
                continue
            simulated, rate, proof = found
            same = (simulated > 0.0) == (rate > 0.0)
            counts["verdict agrees" if same else "verdict differs"] += 1
            clear = abs(rate) > CLEAR * TWO_PI * abs(whirl.frequency)
            counts["rates compared"] += clear
            counts["within 2 %"] += clear and proof is None
            if proof is not None or not same:
                figures = (rate, simulated, *(proof or (np.nan,) * 3)[:2])
                cells = [f"{scenes}", f"{whirl.frequency:.3f}", *(f"{value:.3f}" for value in figures)]
                cells += [f"{100 * proof[2]:.0f} %", cause(*found)] if proof else ["", "verdict differs"]
                lines.append(f"| {' | '.join(cells)} |")
                print(lines[-1], file=sys.stderr, flush=True)
    text = ", ".join(f"{name} {value}" for name, value in {"scenes": scenes, **counts}.items())
    head = "| scene | whirl Hz | predicted 1/s | simulated | all modes | fastest mode alone | other modes | cause |"
    text = "\n".join([text + ".", "", head, "|---|---|---|---|---|---|---|---|", *lines])
    if "--write" in sys.argv[1:]:
        title = "Stability of random whirls, predicted and simulated"
        write_page(RESULTS / "stability_census.md", title, "python bench/stability/stability_census.py --write", text)
    else:
        print(text)


if __name__ == "__main__":
    main()
