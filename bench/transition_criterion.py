"""Does a whirl lose its stability towards another where its normal force falls below half of the other's?

    python bench/transition_criterion.py [CROSSINGS] [--seed 1]      default 400; writes results/transition_criterion.csv and .txt

Random rotors with gyroscopics in light stators, of 2 to 4 coordinates and 1 or 2, are searched over rotor speed for pairs of
whirls that exist together. Reported is every crossing of an eigenvalue at which whirl A begins to grow a line next to whirl B,
beside the speed at which F_A = F_B / 2 (rigid contact), and every place where the forces fulfil the criterion and no eigenvalue
crosses.

The derivation: a small line at Psi_B on the large whirl A meets H(Psi_B) + q with q = s / (2 c F_A), c = 1 + i mu, where its
mirror line at 2 Psi_A - Psi_B carries no force; the steady whirl B fulfils H(Psi_B) + s / (c F_B) = 0. Both are one where
F_A = F_B / 2. The mirror line adds -|q|^2 / (conj H(mirror) + conj q), so the error should grow with |q| / |H(mirror) + q|.
"""

import argparse
import contextlib
import csv
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from rsc.analysis.algebra.blas import one_thread
from rsc.analysis.branches import OSCILLATORY, branches
from rsc.analysis.receptance import receptance
from rsc.analysis.small_motions import small_motion
from rsc.analysis.whirls import normal_force, whirl_roots

BENCH = Path(__file__).parent
sys.path.insert(0, str(BENCH.parent / "tests" / "support"))

from systems import TWO_PI, make_system, random_body  # noqa: E402

RESULTS = BENCH / "results" / "transition_criterion"
SPEEDS = np.linspace(5.0, 200.0, 79)  # Hz
TOWARDS = 0.05  # a growing line belongs to a whirl within this share of its frequency
COLUMNS = ("scene", "n_rotor", "n_stator", "crossing_Hz", "half_Hz", "Psi_A_Hz", "Psi_B_Hz", "ratio", "mirror")


def random_rotor(rng):
    """A rotor of 2 to 4 coordinates with gyroscopics in a light, well damped stator of 1 or 2."""
    n_rotor, n_stator = int(rng.integers(2, 5)), int(rng.integers(1, 3))
    rotor = random_body(rng, n_rotor, 10.0 ** rng.uniform(-3.0, -1.7))
    mass, damping, stiffness = random_body(rng, n_stator, 10.0 ** rng.uniform(-2.0, -0.7))
    light = 10.0 ** rng.uniform(-2.0, 0.0)
    polar = np.diag(rng.uniform(0.5, 2.0, n_rotor) * np.diag(rotor[0]) * (np.arange(n_rotor) > 0))
    contact = (0, 0, rng.uniform(0.1, 0.5), 1e8)
    return make_system((*rotor, polar), (light * mass, light * damping, light * stiffness), contact)


def force_at(system, speed, near):
    """(Psi rad/s, rigid F_N) of the whirl next to a frequency; NaN where none is within 10 %."""
    roots = whirl_roots(system, TWO_PI * speed)
    force = normal_force(system, roots, TWO_PI * speed, rigid=True)
    roots, force = roots[(force > 0.0) & (roots < 0.0)], force[(force > 0.0) & (roots < 0.0)]
    if not len(roots):
        return np.nan, np.nan
    i = int(np.argmin(np.abs(roots - near)))
    return (roots[i], force[i]) if abs(roots[i] / near - 1.0) < 0.1 else (np.nan, np.nan)


def together(a, b):
    """Speeds at which two branches exist, and F_A / F_B there."""
    speeds, i, j = np.intersect1d(a.speed, b.speed, return_indices=True)
    return speeds, np.array([a.whirls[k].normal_force / b.whirls[m].normal_force for k, m in zip(i, j, strict=True)])


def half_speeds(system, a, b):
    """Speeds where F_A = F_B / 2 of two branches."""
    speeds, ratio = together(a, b)
    found = []
    for k in np.flatnonzero((ratio[:-1] - 0.5) * (ratio[1:] - 0.5) < 0.0):
        near = [TWO_PI * branch.at(speeds[k]).frequency for branch in (a, b)]

        def excess(speed, near=near):
            return force_at(system, speed, near[0])[1] / force_at(system, speed, near[1])[1] - 0.5

        if excess(speeds[k]) * excess(speeds[k + 1]) < 0.0:
            with contextlib.suppress(ValueError):  # not a number: one of the whirls moves away from where it was looked for
                found.append(brentq(excess, speeds[k], speeds[k + 1], xtol=1e-4))
    return found


def mirror_share(system, speed, Psi_a, Psi_b, F_a):
    """|q| / |H + q| of the mirror line: what the criterion leaves out."""
    q = system.gap / (2.0 * (1.0 + 1j * system.friction) * F_a)
    return abs(q) / abs(receptance(system, np.array([2.0 * Psi_a - Psi_b]), TWO_PI * speed)[0] + q)


def crossings(system, a, found):
    """(speed, branch B) of every eigenvalue crossing of branch A whose growing line lies next to another whirl."""
    for event in (event for event in a.events if event.cause == OSCILLATORY):
        Psi, _ = force_at(system, event.value, TWO_PI * event.frequency)
        force = normal_force(system, np.array([Psi]), TWO_PI * event.value)[0]
        motion = small_motion(system, Psi, force, TWO_PI * event.value)
        lines = [Psi + sign * abs(motion.eigenvalue.imag) for sign in (-1.0, 1.0)]
        others = [(b, b.at(event.value)) for b in found if b is not a]
        near = [(abs(line / (TWO_PI * w.frequency) - 1.0), b) for b, w in others if w is not None for line in lines]
        distance, b = min(near, key=lambda pair: pair[0], default=(np.inf, None))
        if distance < TOWARDS and b.speed.min() <= event.value <= b.speed.max():
            yield event.value, b


def rows_of(number, system):
    """A row for every crossing, and for every place where the forces alone fulfil the criterion."""
    found = [b for b in branches(system, SPEEDS) if len(b.whirls) > 1]
    for a in found:
        used = set()
        for speed, b in crossings(system, a, found):
            (Psi_a, F_a), (Psi_b, F_b) = (force_at(system, speed, TWO_PI * x.at(speed).frequency) for x in (a, b))
            halves = half_speeds(system, a, b)
            half = min(halves, key=lambda value: abs(value - speed), default=np.nan)
            used.add((b.label, half))
            share = mirror_share(system, speed, Psi_a, Psi_b, F_a)
            yield (number, system.n_rotor, system.n_stator, speed, half, Psi_a / TWO_PI, Psi_b / TWO_PI, F_a / F_b, share)
        for b in (b for b in found if b is not a):
            for half in half_speeds(system, a, b):
                if (b.label, half) not in used and a.at(half).stable:
                    (Psi_a, F_a), (Psi_b, _) = (force_at(system, half, TWO_PI * x.at(half).frequency) for x in (a, b))
                    share = mirror_share(system, half, Psi_a, Psi_b, F_a)
                    yield (number, system.n_rotor, system.n_stator, np.nan, half, Psi_a / TWO_PI, Psi_b / TWO_PI, 0.5, share)


def quantiles(values):
    """The 10th, 50th, 90th and 99th percentile, as text."""
    return ", ".join(f"{value:.3g}" for value in np.quantile(values, (0.1, 0.5, 0.9, 0.99))) if len(values) else "none"


def report(table, tried):
    """What the rows say, as lines of text."""
    crossing, half, ratio, mirror = (table[:, COLUMNS.index(name)] for name in ("crossing_Hz", "half_Hz", "ratio", "mirror"))
    crossed, met = np.isfinite(crossing), np.isfinite(crossing) & np.isfinite(half)
    error, off = np.abs(half - crossing), np.abs(2.0 * ratio - 1.0)
    scenes = len(np.unique(table[crossed, 0]))
    lines = [
        f"{tried} random scenes, {crossed.sum()} crossings of whirl A towards a whirl B that exists there, in {scenes} scenes",
        f"F_A / F_B at the crossing (criterion: 0.5), 10, 50, 90, 99 %: {quantiles(ratio[crossed])}",
        f"F_A = F_B / 2 somewhere on the pair: {met.sum()} of {crossed.sum()}",
        f"|half - crossing| in Hz, 10, 50, 90, 99 %: {quantiles(error[met])}",
        f"forces fulfil the criterion on a stable A and nothing crosses: {(~crossed).sum()}",
        "by the share of the mirror line |q| / |H + q|:",
    ]
    for low, high in ((0.0, 0.03), (0.03, 0.1), (0.1, 0.3), (0.3, 1.0), (1.0, np.inf)):
        inside = (mirror >= low) & (mirror < high)
        lines.append(
            f"  {low:g} to {high:g}: {(inside & crossed).sum()} crossings, |ratio / 0.5 - 1| {quantiles(off[inside & crossed])}; "
            f"|half - crossing| Hz {quantiles(error[inside & met])}; {(inside & ~crossed).sum()} without crossing"
        )
    return lines


@one_thread
def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("crossings", type=int, nargs="?", default=400)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng, rows, tried = np.random.default_rng(options.seed), [], 0
    while sum(np.isfinite(row[3]) for row in rows) < options.crossings:
        tried += 1
        rows.extend(rows_of(tried, random_rotor(rng)))
    lines = report(np.array(rows), tried)
    print("\n".join(lines))
    RESULTS.with_suffix(".txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    with open(RESULTS.with_suffix(".csv"), "w", encoding="utf-8", newline="") as stream:
        csv.writer(stream).writerows([COLUMNS, *([f"{value:.6g}" for value in row] for row in rows)])


if __name__ == "__main__":
    main()
