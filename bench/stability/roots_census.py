"""Whirl roots of random scenes compared with scans of the whirl condition.

    python bench/stability/roots_census.py [SCENES]            prints the table, default 1000 scenes
    python bench/stability/roots_census.py [SCENES] --write    keeps it in bench/results

The pencil of docs/users/physics.md finds all roots at once; a scan finds what changes sign between its points.
"""

import sys
from pathlib import Path

import numpy as np

from rsc.analysis.paper.receptance import receptance
from rsc.analysis.paper.roots import whirl_roots

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT / "tools")]

from pages import RESULTS, write_page  # noqa: E402
from systems import TWO_PI, beside_scan, random_system, scan_grid  # noqa: E402

POINTS = (1000, 10_000, 100_000)  # of the scans
LISTED = 10_000  # unseen roots of scans with so many points are listed


def census(n_scenes):
    """Roots and scans on random scenes of 1 to 6 coordinates each side, as Markdown."""
    rng, grids = np.random.default_rng(7), [scan_grid(n) for n in POINTS]
    n_roots, worst, wrong, unseen, rows = 0, 0.0, [0] * len(POINTS), [0] * len(POINTS), []
    for number in range(1, n_scenes + 1):
        system, Omega = random_system(rng, least_stator=1), TWO_PI * rng.uniform(0.0, 100.0)
        roots = whirl_roots(system, Omega)
        cH = (1.0 + 1j * system.law.friction) * receptance(system, roots, Omega)
        worst = max(worst, np.abs(cH.imag / cH).max(initial=0.0))
        n_roots += len(roots)
        for i, grid in enumerate(grids):
            lost, odd, missed = beside_scan(system, Omega, roots, grid)
            wrong[i] += len(lost) + len(odd)
            unseen[i] += len(missed)
            if len(missed) and POINTS[i] >= LISTED:
                pair, mu = ", ".join(f"{Psi / TWO_PI:.6f}" for Psi in missed), system.law.friction
                rows.append(f"| {number} | {system.n_rotor} + {system.n_stator} | {mu:.4f} | {POINTS[i]} | {pair} |")
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


def main():
    """Print the table, or keep it."""
    numbers = [int(item) for item in sys.argv[1:] if item.isdigit()]
    text = census(numbers[0] if numbers else 1000)
    if "--write" in sys.argv[1:]:
        title = "Whirl roots of random scenes"
        write_page(RESULTS / "roots_census.md", title, "python bench/stability/roots_census.py --write", text)
    else:
        print(text)


if __name__ == "__main__":
    main()
