"""Whirl roots of random scenes beside scans, and what the roots of large rotors cost.

    python bench/roots_census.py [SCENES]            prints both tables, default 1000 scenes
    python bench/roots_census.py [SCENES] --write    keeps them in bench/results

The timing is processor time.
"""

import itertools
import sys
import time
from pathlib import Path

import numpy as np

from rsc.analysis.paper.receptance import joined
from rsc.analysis.paper.whirls import _candidates, receptance, whirl_roots
from rsc.system.blas import one_thread

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT / "tools")]

from pages import RESULTS, write_page  # noqa: E402
from systems import TWO_PI, beside_scan, make_system, random_body, random_system, reference, scan_grid  # noqa: E402

SPEED = 60.0  # Hz, of the timed systems
POINTS = (1000, 10_000, 100_000)  # of the scans
LISTED = 10_000  # unseen roots of scans with so many points are listed


def census(n_scenes):
    """Roots and scans on random scenes of 1 to 6 coordinates each side, as Markdown."""
    rng, grids = np.random.default_rng(7), [scan_grid(n) for n in POINTS]
    n_roots, worst, wrong, unseen, rows = 0, 0.0, [0] * len(POINTS), [0] * len(POINTS), []
    for number in range(1, n_scenes + 1):
        system, Omega = random_system(rng, least_stator=1), TWO_PI * rng.uniform(0.0, 100.0)
        roots = whirl_roots(system, Omega)
        cH = (1.0 + 1j * system.friction) * receptance(system, roots, Omega)
        worst = max(worst, np.abs(cH.imag / cH).max(initial=0.0))
        n_roots += len(roots)
        for i, grid in enumerate(grids):
            lost, odd, missed = beside_scan(system, Omega, roots, grid)
            wrong[i] += len(lost) + len(odd)
            unseen[i] += len(missed)
            if len(missed) and POINTS[i] >= LISTED:
                pair = ", ".join(f"{Psi / TWO_PI:.6f}" for Psi in missed)
                rows.append(f"| {number} | {system.n_rotor} + {system.n_stator} | {system.friction:.4f} | {POINTS[i]} | {pair} |")
    lines = [
        f"{n_scenes} scenes, {n_roots} roots, largest residual {worst:.0e}.",
        "",
        "| points of the scan | its sign changes without a root, and roots against it | roots that it does not see |",
        "|---|---|---|",
        *(f"| {points} | {wrong[i]} | {unseen[i]} |" for i, points in enumerate(POINTS)),
        "",
        f"The unseen ones (pairs within one cell) of the scans with {LISTED} points and more:",
        "",
        "| scene | N + M | mu | points | roots Hz |",
        "|---|---|---|---|---|",
        *(rows or ["| none | | | | |"]),
    ]
    return "\n".join(lines)


def chain(n):
    """A shaft of n masses, every second one a disk, with a stator of two coordinates at its middle."""
    stiffness = 2e6 * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    rotor = np.eye(n), 1e-5 * stiffness + 2.0 * np.eye(n), stiffness, np.diag(np.where(np.arange(n) % 2, 0.5, 0.0))
    stator = 3.0 * np.eye(2), 30.0 * np.eye(2), 9e4 * np.array([[2.0, -1.0], [-1.0, 1.0]])
    return make_system(rotor, stator, (n // 2, 0, 0.3, 1e7))


def full(n, rng):
    """Full random matrices with a stator of two coordinates."""
    rotor = random_body(rng, n, 0.02)
    polar = np.diag(rng.uniform(0.0, 2.0, n) * np.diag(rotor[0]) * (np.arange(n) > 0))
    return make_system((*rotor, polar), random_body(rng, 2, 0.02), (0, 0, 0.3, 1e7))


@one_thread
def timing():
    """Processor time of all roots at one speed, as Markdown: least of 40 rounds of five calls each."""
    rng = np.random.default_rng(3)
    cases = [("mdof_2x2", reference("mdof_2x2"))]
    cases += [(f"{n} + 2, full matrices", full(n, rng)) for n in (10, 20, 40)] + [("40 + 2, shaft", chain(40))]
    best = np.full((len(cases), 2), np.inf)
    for _ in range(40):
        for i, (_, system) in enumerate(cases):
            both = joined(system)
            parts = (
                lambda system=system: whirl_roots(system, TWO_PI * SPEED),
                lambda system=system, both=both: _candidates(both, system.friction, TWO_PI * SPEED),
            )
            for part, _ in itertools.product(range(2), range(5)):  # five calls as in a sweep: with the caches warm
                begun = time.process_time()
                parts[part]()
                best[i, part] = min(best[i, part], time.process_time() - begun)
    lines = ["| system | roots | ms | of it the eigenvalue problem | over mdof_2x2 |", "|---|---|---|---|---|"]
    for (name, system), (spent, eigen) in zip(cases, best, strict=True):
        n_roots = len(whirl_roots(system, TWO_PI * SPEED))
        lines.append(f"| {name} | {n_roots} | {1e3 * spent:.2f} | {1e3 * eigen:.2f} | {spent / best[0, 0]:.0f} |")
    return "\n".join(lines)


def main():
    """Print both tables, or keep them."""
    numbers = [int(item) for item in sys.argv[1:] if item.isdigit()]
    text = f"{census(numbers[0] if numbers else 1000)}\n\n## Processor time\n\n{timing()}"
    if "--write" in sys.argv[1:]:
        title = "Whirl roots of random scenes, and their time"
        write_page(RESULTS / "roots_census.md", title, "python bench/roots_census.py --write", text)
    else:
        print(text)


if __name__ == "__main__":
    main()
