"""What a step of the kernel and a prediction cost over the number of coordinates, from the suite's own timings.

    pytest bench/suite --benchmark-only --benchmark-timer=time.process_time --benchmark-json=bench/results/suite.json
    python bench/coordinates_picture.py            writes bench/results/coordinates.csv and docs/images/coordinates.png

Processor time of the fastest round of each benchmark.
"""

import csv
import json
import re
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import matplotlib.ticker

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "bench" / "results"
# benchmark -> what it costs, in words of the legend; the first per step, the others per speed
COSTS = {
    "test_step": "rk45: a step of the simulation",
    "test_whirl_roots": "all whirl roots at one speed",
    "test_predict": "rsc.predict at one speed: roots, forces, stability",
}
COLOURS, MARKS = ("#c1121f", "#1d6fb8", "#3a8f3a"), "os^"


def rows_of(suite):
    """[(benchmark, complex coordinates, microseconds)] of the benchmarks that COSTS names."""
    found = []
    for entry in suite["benchmarks"]:
        match = re.fullmatch(r"(\w+)\[(\d+)-(\d+)\]", entry["name"])
        if match and match[1] in COSTS:
            per_step = entry["extra_info"].get("ns_per_step")
            spent = 1e6 * entry["stats"]["min"] if per_step is None else 1e-3 * per_step
            found.append((match[1], int(match[2]) + int(match[3]), spent))
    return sorted(found)


def picture(rows):
    """Figure with one line for each kind of cost."""
    figure, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
    for (name, words), colour, mark in zip(COSTS.items(), COLOURS, MARKS, strict=True):
        n, spent = zip(*[(n, spent) for kind, n, spent in rows if kind == name], strict=True)
        axes.plot(n, spent, color=colour, marker=mark, label=words)
    axes.set(xscale="log", yscale="log", xlabel="complex coordinates of rotor and stator together", ylabel="processor time in µs")
    axes.xaxis.set_major_locator(matplotlib.ticker.FixedLocator(sorted({n for _, n, _ in rows})))
    axes.xaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%d"))
    axes.yaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axes.minorticks_off()
    axes.grid(color="0.92", linewidth=0.6)
    axes.set_title("Chain of disks in backward whirl in a chain of stator masses", fontsize=10, loc="left")
    axes.legend(frameon=False, fontsize=9)
    return figure


def main():
    """Draw the suite's last results."""
    suite = json.loads((RESULTS / "suite.json").read_text(encoding="utf-8"))
    rows = rows_of(suite)
    with open(RESULTS / "coordinates.csv", "w", newline="", encoding="utf-8") as file:
        processor = suite["machine_info"]["cpu"].get("brand_raw", "unknown processor")
        file.write(f"# {processor}; processor time of the fastest round\n")
        writer = csv.writer(file)
        writer.writerow(["benchmark", "coordinates", "us"])
        writer.writerows((name, n, f"{spent:.4g}") for name, n, spent in rows)
    picture(rows).savefig(ROOT / "docs" / "images" / "coordinates.png", dpi=130)


if __name__ == "__main__":
    main()
