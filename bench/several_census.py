"""Census of random systems with two contacts: does the scan over Psi miss a whirl that Newton's method finds from many starts?

    python bench/several_census.py [--systems 1000] [--first 0] [--write]

Every system is `random_several` of its own number, at a rotor speed from 3 to 200 Hz. Newton's method on (W) of
docs/users/physics.md starts from the eigenvalues of 441 pairs of secant stiffnesses, whether they grow fast or not; the scan
knows none of these starts. A whirl is missed where none of the scan has its frequency within 1e-6 and its forces within 1e-3.
--write: the page bench/results/several_census.md, as it grows.
"""

import argparse
import itertools
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "support")]

from pages import RESULTS, write_page  # noqa: E402
from rsc.analysis.several.condition import Whirling, pressed, settled  # noqa: E402
from rsc.analysis.several.pairs import pair_candidates  # noqa: E402
from rsc.analysis.several.starts import ranges, secant_eigenvalues  # noqa: E402
from several_systems import random_several  # noqa: E402

TWO_PI, EVERY = 2.0 * np.pi, 50  # systems between two lines, and two pages
# secant stiffness over the contact's, from a touch to a deep one
SHARES = 1.0 / (1.0 + np.logspace(5.0, -4.0, 21))


def many_starts(own, bounds):
    """Candidates from every pair of secant stiffnesses: each eigenvalue within the ranges, with forces that belong to it."""
    kappa = np.array(list(itertools.product(SHARES, repeat=2))) * own.stiffness
    values, shapes = secant_eigenvalues(own, kappa)
    i, mode = np.nonzero(np.any([(values.real > low) & (values.real < high) for low, high in bounds], axis=0))
    d = shapes[i, mode] @ own.rows.T
    N = kappa[i] * own.gap / (1.0 - kappa[i] / own.stiffness)
    return Whirling(values.real[i, mode], N, np.angle(d / d[:, :1]))


def compared(number):
    """(whirls of the scan, those of many starts, frequencies in Hz of whirls that the scan misses, of those that only it has)."""
    rng = np.random.default_rng(number)
    own = pressed(random_several(rng), TWO_PI * 10.0 ** rng.uniform(0.5, 2.3), (0, 1))
    bounds = ranges(own, False)
    scanned, wanted = (settled(own, start(own, bounds), bounds) for start in (pair_candidates, many_starts))
    return len(scanned.Psi), len(wanted.Psi), absent(wanted, scanned), absent(scanned, wanted)


def absent(some, others):
    """Frequencies in Hz of those whirls that are not among others."""
    return [
        Psi / TWO_PI
        for Psi, N in zip(some.Psi, some.N, strict=True)
        if not ((np.abs(others.Psi / Psi - 1.0) < 1e-6) & (np.abs(others.N / N - 1.0).max(axis=1) < 1e-3)).any()
    ]


def main():
    """Print a line for every few systems, and for each that has a missed whirl."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--systems", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    totals, lost, begin = np.zeros(4, dtype=int), [], time.process_time()
    for count in range(1, options.systems + 1):
        number = options.first + count - 1
        scanned, wanted, missed, more = compared(number)
        totals += scanned, wanted, len(missed), len(more)
        for frequency in missed:
            lost.append(f"system {number} at {frequency:.6f} Hz")
            print("missed:", lost[-1], flush=True)
        if count % EVERY == 0 or count == options.systems:
            text = table(count, totals, lost)
            print(text.splitlines()[-1 - (len(lost) + 1 if lost else 0)], f"{time.process_time() - begin:.0f} s", flush=True)
            if options.write:
                command = f"python bench/several_census.py --systems {options.systems} --write"
                write_page(RESULTS / "several_census.md", "Whirls at two contacts: the scan against many starts", command, text)


def table(count, totals, lost):
    """The census so far."""
    lines = [
        "| systems | whirls of the scan | of Newton's method from 441 starts | missed by the scan | found by the scan alone |",
        "|---|---|---|---|---|",
        f"| {count} | " + " | ".join(map(str, totals)) + " |",
    ]
    return "\n".join(lines + (["", "Missed: " + "; ".join(lost) + "."] if lost else []))


if __name__ == "__main__":
    main()
