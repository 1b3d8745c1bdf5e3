"""Tiny cases without end: whether memory or open files of one process grow with the number of runs (F16).

    python tools/tiny_cases.py --write                          100,000 runs a way (1/50 of them to a file), some 8 min
    python tools/tiny_cases.py --most 10000 --way simulate      fewer, one way

A tiny case: a rotor of one coordinate in a rigid stator, 2 ms with an impact: 15 steps, 5 samples. Each way in a process of its
own; its resident memory (VmRSS) and its open files are read after 1 %, 10 % and all of its runs. Exit code 1 when memory grows by
1 % or more from the second reading to the last, or files do at all. Before the second, Python and HDF5 fill what they keep.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pages import TABLES, write_page

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests" / "support")]
PORTION = 500


def simulate(scene, count):
    """Runs in memory, one by one."""
    import rsc

    for _ in range(count):
        assert rsc.simulate(scene).status == "finished"


def simulate_to_a_file(scene, count):
    """Runs to one file, each read when it is whole."""
    import rsc

    with tempfile.TemporaryDirectory() as folder:
        for _ in range(count):
            assert len(rsc.simulate(scene, path=Path(folder, "run.h5")).rotor) == 5


def simulate_many(scene, count):
    """Runs in portions, and many on two threads."""
    import rsc

    for done in range(0, count, PORTION):
        rsc.simulate_many([scene] * min(PORTION, count - done), threads=2)


WAYS = {"simulate": (simulate, 1), "simulate to a file": (simulate_to_a_file, 50), "simulate_many": (simulate_many, 1)}


def used():
    """(resident memory in kB, open files) of this process."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("VmRSS:")).split()[1]), len(os.listdir("/proc/self/fd"))


def readings(way, most):
    """[(runs, memory in kB, open files)] after 1 %, 10 % and all of the runs, and the processor time of one in s."""
    import rsc
    from scenes import SCENES, changed

    run, part = WAYS[way]
    scene = rsc.Scene.from_dict(changed(SCENES["rigid wall"], drive={"duration": 0.002}))
    counts, found, done = [most // part // share for share in (100, 10, 1)], [], 0
    begun = time.process_time()
    for count in counts:
        run(scene, count - done)
        done = count
        found.append((count, *used()))
        print(way, found[-1], file=sys.stderr, flush=True)
    return found, (time.process_time() - begun) / done


def row(way, most):
    """(cells of the table, whether nothing grew) of a way, in a process of its own."""
    command = [sys.executable, __file__, "--most", str(most), "--readings", way]
    found, seconds = json.loads(subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout)
    growth = found[-1][1] / found[1][1] - 1.0
    cells = [f"{count:,}: {memory / 1e3:.1f} MB, {files}" for count, memory, files in found]
    return [way, *cells, f"{100.0 * growth:+.2f} %", f"{1e3 * seconds:.1f}"], growth < 0.01 and found[-1][2] <= found[0][2]


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=int, default=100_000, help="runs of a way")
    parser.add_argument("--way", choices=WAYS, help="only this one")
    parser.add_argument("--readings", choices=WAYS, help=argparse.SUPPRESS)
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
    if options.readings:
        print(json.dumps(readings(options.readings, options.most)))
        return 0
    lines = ["| way | runs: memory, open files | | | growth | processor ms a run |", "|---|---|---|---|---|---|"]
    kept = True
    for way in [options.way] if options.way else WAYS:
        cells, flat = row(way, options.most)
        lines.append("| " + " | ".join(cells) + " |")
        kept = kept and flat
    text = "\n".join(lines)
    print(text)
    if options.write:
        write_page(TABLES / "tiny_cases.md", "Tiny cases", "python tools/tiny_cases.py --write", text)
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
