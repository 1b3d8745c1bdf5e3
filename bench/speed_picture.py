"""One light picture of speed for README and docs: five lines from the results that bench/work_precision.py left.

    python bench/speed_picture.py       writes docs/images/speed.png

rsc's two methods and three peers, on P1, a Laval rotor in backward whirl: those that are the fastest at an error of the table,
then those that come next at 1e-6 gaps.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import matplotlib.ticker
import numpy as np

import work_precision
from work_precision_report import TARGETS, attempted, is_peer, ranking

ROOT = Path(__file__).resolve().parents[1]
PROBLEM, OWN, PEERS = "P1", ("rsc rk45", "rsc taylor8"), 3
COLOURS = ("#c1121f", "#7b2cbf", "#1d6fb8", "#d98a00", "#3a8f3a")
MARKS = "osD^v"


def best_peers(rows):
    """Names of the fastest peers."""
    peers = {error: [label for label in ranking(rows, PROBLEM, error) if is_peer(label)] for error in TARGETS}
    return list(dict.fromkeys([*(labels[0] for labels in peers.values()), *peers[1e-6]]))[:PEERS]


def line(rows, label):
    """(error in gaps, processor time in s) of a method's points that did not fail, in the order of their error."""
    done = [row for row in attempted(rows, PROBLEM, label) if not row.cause and np.isfinite(row.error)]
    return np.array(sorted((row.error, row.seconds) for row in done)).T


def picture(rows):
    """Figure with one line per method, its name at the line's end."""
    figure, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
    for label, colour, mark in zip([*OWN, *best_peers(rows)], COLOURS, MARKS, strict=True):
        error, seconds = line(rows, label)
        axes.plot(error, seconds, color=colour, marker=mark, markersize=4.5, linewidth=2.4 if label in OWN else 1.3, label=label)
    axes.set(xscale="log", yscale="log", xlim=(1e-11, 1.0), xlabel="largest error of the displacement, in gaps")
    axes.set_ylabel("processor time in s")
    axes.yaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axes.minorticks_off()
    axes.grid(color="0.92", linewidth=0.6)
    axes.set_title("Laval rotor in backward whirl, 30 s run-up; lower left is better", fontsize=10, loc="left")
    axes.legend(frameon=False, fontsize=9, loc="upper right")
    return figure


def main():
    """Draw the committed results."""
    rows = work_precision.read(PROBLEM, ROOT / "bench" / "results")[0]
    picture(rows).savefig(ROOT / "docs" / "images" / "speed.png", dpi=130)


if __name__ == "__main__":
    main()
