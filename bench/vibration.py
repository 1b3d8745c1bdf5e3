"""Vibration peak to peak of random loaded runs against the extents of samples at ten times their rate.

    python bench/vibration.py [RUNS] [--seed N]      -> bench/results/vibration.txt

Rotors whose weight deflects them by up to four fifths of the gap, in a soft or a stiff stator, at speeds from sub- to
supercritical, from rest or after a blow, with both methods. The extents that the steps count (`Facts.peak_to_peak`) are those of
the whole run and of its last quarter; the witness are 1000 samples a period of the rotor.
"""

import argparse
from pathlib import Path

import numpy as np

import rsc

RESULT = Path(__file__).parent / "results" / "vibration.txt"
ALLOWED = 0.01


def scene_of(rng: np.random.Generator) -> rsc.Scene:
    """A random loaded rotor in its stator."""
    frequency, gap = float(rng.uniform(10.0, 60.0)), float(10.0 ** rng.uniform(-3.7, -2.8))
    sag = float(rng.uniform(0.05, 0.8)) * gap
    tables = {
        "rotor": {
            "model": "laval", "mass": float(10.0 ** rng.uniform(0.0, 3.0)), "frequency": frequency,
            "damping_ratio": float(rng.uniform(0.005, 0.08)), "eccentricity": float(rng.uniform(0.01, 0.2)) * gap,
            "gravity": sag * (2.0 * np.pi * frequency) ** 2,
        },
        "stator": {
            "model": "laval", "mass": float(10.0 ** rng.uniform(0.0, 2.0)), "frequency": frequency * float(rng.uniform(1.0, 5.0)),
            "damping_ratio": float(rng.uniform(0.02, 0.2)),
        },
        "contact": {
            "gap": gap, "friction": float(rng.uniform(0.05, 0.3)), "stiffness": float(10.0 ** rng.uniform(6.0, 8.0)),
            "damping_ratio": 0.05, "diameter": float(rng.uniform(20.0, 200.0)) * gap,
        },
        "drive": {"speed": frequency * float(rng.uniform(0.3, 2.5)), "duration": 40.0 / frequency},
        "solver": {"method": str(rng.choice(["rk45", "taylor8"]))},
        "output": {"rate": 1000.0 * frequency},
    }  # fmt: skip
    if rng.random() < 0.5:
        velocity = rng.uniform(-2.0, 2.0, 2) * gap * 2.0 * np.pi * frequency
        tables["start"] = {"rotor": [[0.0, -sag]], "rotor_velocity": [velocity.tolist()]}
    return rsc.Scene.from_dict(tables)


def extent(motion: np.ndarray) -> float:
    """The larger extent in y and z, m."""
    return float(max(np.ptp(motion.real), np.ptp(motion.imag)))


def errors(scene: rsc.Scene) -> list[float]:
    """Relative differences of the extents of the whole run and of its last quarter."""
    result = rsc.simulate(scene)
    stretches, rotor = result.stretches(), result.contact_rotor()
    first = int(np.searchsorted(stretches.begin, 0.75 * stretches.end[-1]))
    begin = result.time >= stretches.begin[first]
    pairs = (stretches.whole(), rotor), (stretches.of(first, len(stretches)), rotor[begin])
    return [abs(facts.peak_to_peak / extent(motion) - 1.0) for facts, motion in pairs]


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs="?", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    found = np.array([errors(scene_of(rng)) for _ in range(options.runs)])
    text = (
        f"{options.runs} loaded runs (seed {options.seed}): peak to peak of the steps against samples, whole and last quarter\n"
        f"largest difference {100.0 * found.max():.3f} %, median {100.0 * np.median(found):.5f} %, "
        f"{int((found > ALLOWED).sum())} of {found.size} above {100.0 * ALLOWED:g} %\n"
    )
    RESULT.write_text(text, encoding="utf-8")
    print(text, end="")


if __name__ == "__main__":
    main()
