"""Basins of attraction: in which motion the reference rotor of Figure 3 right ends at 60 Hz after a knock, and the smallest one.

    python bench/basin.py [--cells 200]

Knocks over both components, on the rotor running without contact and on whirl A, each a run of 5 s; fewer of them with a contact
diameter, with which friction turns round; then the smallest knock of 24 directions (`rsc.smallest_knock`). Processor and wall
time on as many threads as there are processors. Writes results/basin.md and a picture of each.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

import rsc
from problems import results_folder
from rsc.show import plots, sweep_pictures
from rsc.study.sweep.plan import make_plan
from rsc.study.sweep.sweep import computed

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT / "tools")]

from pages import write_page  # noqa: E402

SCENE = ROOT / "data" / "reference" / "gyroscopic_figure3_right.toml"
STEADY = {"drive.speed": 60.0, "drive.duration": 5.0, "output.rate": 500.0}
LARGEST = 2.5  # N s, of each component
# picture -> what changes in the scene, in words, share of the cells
STARTS = {
    "running": ({"start.running": True}, "running without contact", 1.0),
    "whirl": ({"start.whirl": -35.8}, "on whirl A (-35.8 Hz)", 1.0),
    "rolling": ({"start.running": True, "contact.diameter": 0.1}, "running, with a contact diameter of 0.1 m", 0.1),
}


def timed(work):
    """What a call returns, its processor time and its wall time in s."""
    begin = time.process_time(), time.perf_counter()
    value = work()
    return value, time.process_time() - begin[0], time.perf_counter() - begin[1]


def basin(scene, cells):
    """The ends of the runs after cells x cells knocks, as labelled arrays."""
    sides = {f"start.knock[{i}]": f"{-LARGEST}:{LARGEST}:{cells}" for i in (0, 1)}
    return computed(make_plan(scene, rsc.cases(scene, sides), "run"), None)


def row(text, figure, runs, processor, wall):
    """A row of the table: what the legend of the map tells of every motion, and times."""
    legend = ", ".join(text.get_text() for legend in figure.legends for text in legend.get_texts())
    return f"| {text} | {runs} | {legend} | {processor:.0f} | {wall:.0f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=200, help="knocks of each component")
    options = parser.parse_args()
    folder = results_folder(options.cells < 200)
    base = rsc.load_scene(SCENE).with_values(STEADY)
    computed_once = basin(base.with_values({"start.running": True}), 4)  # compiles
    assert set(computed_once["status"].ravel()) <= {"finished", "diverged"}
    lines = ["| start | runs | ends in | processor s | wall s |", "|---|---|---|---|---|"]
    for name, (change, text, share) in STARTS.items():
        cells = max(round(share * options.cells), 4)
        data, *times = timed(lambda change=change, cells=cells: basin(base.with_values(change), cells))
        figure = sweep_pictures.pictures(data)["motion"]
        lines.append(row(text, figure, data["motion"].size, *times))
        plots.save(figure, folder / f"basin_{name}.png")
    knocks, *times = timed(lambda: rsc.smallest_knock(base.with_values({"drive.duration": 10.0})))
    lines += [
        "",
        f"Smallest knock of {len(knocks.direction)} directions that starts a whirl (runs of 10 s): "
        f"{np.min(knocks.impulse):.4f} N s at {knocks.direction[knocks.weakest]:g} degrees; "
        f"the hardest direction takes {np.max(knocks.impulse):.4f} N s; {knocks.runs} runs, {times[0]:.1f} s of processor time.",
    ]
    command = f"python bench/basin.py --cells {options.cells}"
    write_page(folder / "basin.md", "Basins of attraction after a knock", command, "\n".join(lines))
    print("\n".join(lines))


if __name__ == "__main__":
    main()
