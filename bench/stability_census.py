"""Predicted stability of the whirls of random scenes beside the simulator: verdict and growth rate.

    python bench/stability_census.py [SCENES]      prints one line per disagreement and the counts

Random rotors of 1 to 3 and stators of 1 or 2 coordinates without unbalance and contact damping (the law is smooth in
contact). Each whirl is started off by 0.1 % of its penetration along its fastest mode, with 0.2 % of that at random.
"""

import sys

import numpy as np

import rsc
from rsc.assemble import assemble
from rsc.modes import small_motion
from rsc.predict import predict_system
from rsc.stability import whirl_growth

TWO_PI = 2.0 * np.pi
SPEED = 50.0
# a verdict needs a growth rate that shows within the longest run
LEAST_RATE, LONGEST = 0.2, 12.0
_RANDOM = 0.002
# growth rates are compared where they are this large against the whirl frequency in rad/s
CLEAR = 0.05


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


def disturbed(content, system, whirl, rng, run):
    """Times and distances from the whirl of a run (duration, share of the penetration) started off it: simulated, predicted."""
    duration, share = run
    n_rotor = system.n_rotor
    shape = np.concatenate([whirl.rotor_shape, whirl.stator_shape])
    Psi = TWO_PI * whirl.frequency
    mode = small_motion(system, Psi, whirl.normal_force, TWO_PI * SPEED)
    size = share * whirl.normal_force / system.contact_stiffness
    rates = np.array([mode.eigenvalue, np.conj(mode.eigenvalue)])
    lines = mode.lines * (1.0 if mode.eigenvalue.imag else np.array([[1.0], [0.0]]))
    off, off_rate = lines.sum(axis=0), rates @ lines
    scale = size / np.abs(off).max()
    x = shape + scale * off + _RANDOM * size * (rng.normal(size=len(shape)) + 1j * rng.normal(size=len(shape)))
    v = 1j * Psi * x + scale * off_rate
    parts = {"rotor": x[:n_rotor], "stator": x[n_rotor:], "rotor_velocity": v[:n_rotor], "stator_velocity": v[n_rotor:]}
    start = {key: [[float(z.real), float(z.imag)] for z in part] for key, part in parts.items()}
    scene = {**content, "start": {**start, "allow_penetration": True}, "drive": {"speed": SPEED, "duration": duration}}
    scene["output"] = {"rate": max(2000.0, 1000.0 / duration)}
    result = rsc.simulate(rsc.Scene.from_dict(scene))
    motion = np.hstack([result.rotor, result.stator])
    predicted = shape + scale * np.exp(np.outer(result.time, rates)) @ lines
    return result.time, _distance(motion, shape), _distance(predicted, shape)


def _distance(motion, shape):
    """Distance of motions (n_time, n) from a circular motion of this shape, whatever its phase."""
    overlap = motion @ shape.conj()
    return np.linalg.norm(motion - (overlap / np.abs(overlap))[:, None] * shape, axis=1)


def slope(time, distance):
    """Growth rate of a distance, by a straight line through its logarithm after the first fifth."""
    late = time >= 0.2 * time[-1]
    return np.polyfit(time[late], np.log(distance[late]), 1)[0]


def judged(content, system, whirl, rng, share=1e-3):
    """(simulated rate, predicted rate), or None where the rate is too small to see."""
    Psi = TWO_PI * whirl.frequency
    rate = whirl_growth(system, Psi, whirl.normal_force, TWO_PI * SPEED).rate
    if abs(rate) < LEAST_RATE:
        return None
    # growing: stay at small motions; decaying: stay above the tolerance
    duration = min(2.5 / abs(rate), LONGEST)
    time, distance, of_mode = disturbed(content, system, whirl, rng, (duration, share))
    # both wave alike within the mode's own periods
    return slope(time, distance) - slope(time, of_mode) + rate, rate


def main():
    """Count agreements."""
    n_scenes = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    rng = np.random.default_rng(20)
    names = ("whirls", "too slow", "verdict agrees", "verdict differs", "rates compared", "within 2 %", "after a tenth")
    counts = dict.fromkeys(names, 0)
    scenes = 0
    while scenes < n_scenes:
        content = random_scene(rng)
        system = assemble(rsc.Scene.from_dict(content))
        whirls = [w for w in predict_system(system, SPEED) if w.frequency < 0.0]
        scenes += bool(whirls)
        for whirl in whirls:
            counts["whirls"] += 1
            found = judged(content, system, whirl, rng)
            if found is None:
                counts["too slow"] += 1
                continue
            same = (found[0] > 0.0) == (found[1] > 0.0)
            counts["verdict agrees" if same else "verdict differs"] += 1
            line = f"scene {scenes}: {whirl.frequency:.3f} Hz, rate {found[0]:.4g}, predicted {found[1]:.4g}"
            if not same:
                print("differs:", line, flush=True)
            if abs(found[1]) > CLEAR * TWO_PI * abs(whirl.frequency):
                counts["rates compared"] += 1
                close = abs(found[0] / found[1] - 1.0) < 0.02
                counts["within 2 %"] += close
                if not close:  # by what is not linear, if a tenth of the disturbance settles it
                    again = judged(content, system, whirl, rng, 1e-4)
                    counts["after a tenth"] += abs(again[0] / again[1] - 1.0) < 0.02
                    print("rate off:", line, f"with a tenth of the disturbance {again[0]:.4g}", flush=True)
    print(", ".join(f"{name} {value}" for name, value in {"scenes": scenes, **counts}.items()))


if __name__ == "__main__":
    main()
