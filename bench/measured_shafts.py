"""Random shafts of measured runs: is their speed met, and where it is not, is that said?

    python bench/measured_shafts.py [--shafts 200] [--write]

The shafts are those of tests/support/shafts.py: run-ups, coast-downs, stops and constant speeds, from rest and to rest, wheels of
1 to 60 teeth of which some lack one or two, noise, square edges of 20 samples a tooth and more, and in every other one a loss of
pulses of 0.02 to 3 s. Asked: where the shaft is called known, its speed within 0.5 % of the largest one, but for one turn beside
a sharp corner of the speed. --write: the page bench/results/shafts.md.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path += [str(ROOT / "tests" / "support"), str(ROOT / "tools")]

import pages  # noqa: E402
from rsc.measured.shaft import shaft_of  # noqa: E402
from shafts import apart_from_corners, shaft  # noqa: E402

ASKED = 0.005


def tried(number):
    """(largest error away from corners, largest error, shares of time known, wrongly unknown, whether the mark is as it is)."""
    one = shaft(np.random.default_rng([0, number]))
    seen = shaft_of(one.time, one.pulses, one.teeth)
    if seen is None:
        return 0.0, 0.0, 0.0, float(one.lost is None), True
    off = np.where(seen.known, np.abs(seen.speed - one.speed), 0.0) / one.speed.max()
    away = apart_from_corners(one)
    marked = seen.marked == (one.teeth == 1 or one.lacking > 0)
    turning = seen.known & (one.speed > 0.05 * one.speed.max())
    if seen.marked and turning.any():
        marked &= bool(np.abs((seen.turns - one.turns + 0.5) % 1.0 - 0.5)[turning].max() < 0.02)
    wrongly = 0.0 if one.lost is not None else 1.0 - seen.known.mean()
    return float(off[away].max()), float(off.max()), float(seen.known.mean()), float(wrongly), marked


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shafts", type=int, default=200)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    away, off, known, wrongly, marked = (np.array(values) for values in zip(*map(tried, range(options.shafts)), strict=True))
    rows = [
        f"| shafts | {options.shafts} |",
        f"| speed within {100 * ASKED:g} % of the largest, or called unknown | {int((away <= ASKED).sum())} |",
        f"| largest error away from corners | {100 * away.max():.2f} % |",
        f"| the same, one turn beside sharp corners too | {int((off <= ASKED).sum())}, largest error {100 * off.max():.2f} % |",
        f"| share of time that is known, mean and least | {100 * known.mean():.1f} %, {100 * known.min():.0f} % |",
        f"| shafts without a loss of which some is unknown | {int((wrongly > 0.0).sum())} |",
        f"| mark found within 0.02 turns where there is one, and none elsewhere | {int(marked.sum())} |",
    ]
    print("\n".join(rows))
    if options.write:
        command, title = f"python bench/measured_shafts.py --shafts {options.shafts} --write", "Random shafts of measured runs"
        text = "\n".join(["| what | measured |", "|---|---|", *rows])
        pages.write_page(pages.RESULTS / "shafts.md", title, command, text)


if __name__ == "__main__":
    main()
