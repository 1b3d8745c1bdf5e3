"""How long `rsc explore` takes to answer: scripted moves of its sliders, whirls and orbit asked for as the page does.

    python bench/explore_moves.py [SCENE ...] [--moves 200] [--write]      a row for each scene: median, 95 % and largest in ms

By default four reference scenes and `rsc new compressor`. On an idle machine 95 % are to stay below 200 ms; the map follows
when nothing moves and has its own column. --write: the page bench/results/explore_moves.md.
"""

import argparse
import http.client
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.append(str(ROOT / "tools"))

import rsc  # noqa: E402
from pages import RESULTS, write_page  # noqa: E402
from rsc.scene.files.templates import template  # noqa: E402

REFERENCE = ROOT / "data" / "reference"
SCENES = ("laval", "gyroscopic_figure3_right", "mdof_2x2", "chain_10")
SEED = 1


def asked(connection, page, part, **question):
    """(ms, answer) of one question."""
    begun = time.perf_counter()
    headers = {"Content-Type": "application/json"}
    connection.request("POST", f"/{page.token}/{part}", json.dumps(question), headers)
    answer = json.loads(connection.getresponse().read())
    return 1e3 * (time.perf_counter() - begun), answer


def row(path, moves):
    """A line of the table: times of `moves` random moves of the first handles."""
    dice = np.random.default_rng(SEED)
    with rsc.explore(rsc.load_scene(path)) as page:
        handles = [handle for handle in page.live.handles if handle.first]
        took, runs, refused, values = [], [], 0, {}
        connection = http.client.HTTPConnection(page.host, timeout=300)
        asked(connection, page, "run", values={})  # compiles
        asked(connection, page, "whirls", values={})
        for _ in range(moves):
            handle = handles[dice.integers(len(handles))]
            values[handle.name] = float(dice.uniform(handle.low, handle.high))
            ms, answer = asked(connection, page, "whirls", values=values)
            took.append(ms)
            ms, run = asked(connection, page, "run", values=values)
            runs.append(ms)
            refused += "error" in answer or "error" in run
        where = {"x": "speed", "y": "contact.friction"}
        maps = [asked(connection, page, "map", values=values, **where)[0] for _ in range(5)]
    parts = [f"{np.median(each):.0f} / {np.quantile(each, 0.95):.0f} / {max(each):.0f}" for each in (took, runs)]
    both = np.mean(np.add(took, runs) < 200.0)
    return f"| {Path(path).stem} | {moves} | {parts[0]} | {parts[1]} | {np.median(maps):.0f} | {100 * both:.0f} % | {refused} |"


def main():
    """Print the table, or write it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", default=[str(REFERENCE / f"{name}.toml") for name in SCENES])
    parser.add_argument("--moves", type=int, default=200)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    rows = [
        "| scene | moves | whirls, ms: median / 95 % / largest | orbit and spectrum | map | both < 200 ms | refused in words |",
        "|---|---|---|---|---|---|---|",
    ]
    with tempfile.TemporaryDirectory() as folder:
        shaft = Path(folder) / "compressor.toml"
        shaft.write_text(template("compressor"), encoding="utf-8")
        default = options.scenes == parser.get_default("scenes")
        rows += [row(path, options.moves) for path in (*options.scenes, *([shaft] if default else []))]
    if options.write:
        command = f"python bench/explore_moves.py --moves {options.moves} --write"
        write_page(RESULTS / "explore_moves.md", "How long `rsc explore` takes to answer", command, "\n".join(rows))
    print("\n".join(rows))


if __name__ == "__main__":
    main()
