"""Two hours of machine time into a file: memory and speed along the run; read meanwhile, stopped, resumed, verified, drawn.

    python bench/two_hours.py --write              7,200 s of a rotor and a stator of two coordinates each at 2 kHz, 1.5 GB
    python bench/two_hours.py --duration 600

Every second of wall time: memory of the process that runs (VmRSS), samples that another process can read in its file, and its
processor time. At half of the run it gets a SIGTERM and is resumed. Exit code 1 when memory grows by a tenth, the last quarter
takes half as much processor time again as the first, a sample that was read while the run went on is another one in the end, or
a command fails.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tools"), str(ROOT / "tests" / "support")]

from pages import RESULTS, write_page  # noqa: E402

RATE = 2000.0  # Hz
TICKS = os.sysconf("SC_CLK_TCK")


def scene_of(duration):
    """A gyroscopic disk in a stator of two masses at constant speed, which costs the same all along: a few touches, then none."""
    import rsc
    from scenes import SCENES

    disk, chains = SCENES["gyroscopic disk"], SCENES["chains"]
    tables = {"drive": {"speed": 30.0, "duration": duration}, "output": {"rate": RATE}}
    contact = disk["contact"] | {"stator_coordinate": 1}
    return rsc.Scene.from_dict({**disk, "stator": chains["stator"], "contact": contact, **tables, "title": "Two hours"})


def command(folder, *words):
    """A command of rsc, begun."""
    return subprocess.Popen(
        [sys.executable, "-m", "rsc", *words], cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip


def resident(process, key="VmRSS:"):
    """Memory of a process in MB; 0 when it has ended."""
    try:
        lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
        return next((int(line.split()[1]) / 1e3 for line in lines if line.startswith(key)), 0.0)
    except OSError:
        return 0.0


def spent(process):
    """Processor time of a process so far, s."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def watched(process, path, stop_at, seen):
    """[(samples, processor s, MB)] of a run once a second, by a reader of its file; at `stop_at` samples it gets a SIGTERM.

    seen : dict, filled with number of a row -> its rotor displacement as it was read while the run went on
    """
    from rsc.errors import DataError
    from rsc.results.result_file import ResultFile, part_of

    found = []
    while process.poll() is None:
        time.sleep(1.0)
        try:
            checkpoint, _ = ResultFile(part_of(path)).checkpoint()
            if checkpoint is None:
                continue
            rows = int(checkpoint["rows"][0])
            if rows:
                seen[rows - 1] = ResultFile(part_of(path)).rows(rows - 1, rows)["rotor"][0].copy()
            found.append((rows, spent(process), resident(process)))
        except (DataError, OSError):  # not made yet, or it has its name already
            continue
        if rows >= stop_at:
            process.send_signal(signal.SIGTERM)
            stop_at = np.inf
    return found


def timed(folder, *words):
    """(exit code, processor s, peak MB, output) of a command."""
    before, process, peak = os.times(), command(folder, *words), 0.0
    while process.poll() is None:
        peak = max(peak, resident(process, "VmHWM:"))
        time.sleep(0.02)
    output, after = process.stdout.read(), os.times()
    return process.returncode, after[2] + after[3] - before[2] - before[3], peak, output


def pace(found):
    """Processor time of 1,000 s of the run, in its first and in its last quarter."""
    rows, seconds = np.array([row[0] for row in found]), np.array([row[1] for row in found])
    ends = np.interp(np.linspace(rows[0], rows[-1], 5), rows, seconds)
    each = 1000.0 * RATE / ((rows[-1] - rows[0]) / 4.0)
    return each * (ends[1] - ends[0]), each * (ends[4] - ends[3])


def measured(duration, folder):
    """(lines of the table, whether all is as it should be)."""
    import rsc
    from rsc.results.result_file import ResultFile

    path, seen = folder / "run.h5", {}
    (folder / "scene.toml").write_text(scene_of(duration).to_toml())
    lines, good = ["| what | found |", "|---|---|"], True
    for words, stop_at, wanted in ((("run",), duration * RATE / 2.0, 130), (("run", "--resume"), np.inf, 0)):
        process = command(folder, words[0], "scene.toml", "-o", path.name, *words[1:])
        found = watched(process, path, stop_at, seen)
        good &= process.wait() == wanted
        memory, (first, last) = [row[2] for row in found[1:]], pace(found)
        good &= max(memory) < 1.1 * memory[0] and last < 1.5 * first
        name = "run to its half" if wanted else "resumed run"
        memories = f"memory {memory[0]:.0f} MB in the beginning, {max(memory):.0f} MB at most"
        paces = f"{first:.1f} s of processor time for 1,000 s in the first quarter, {last:.1f} s in the last"
        lines.append(f"| {name} | {memories}; {paces} |")
    result = rsc.load(path)
    samples = ResultFile(path)
    same = all(np.array_equal(samples.rows(row, row + 1)["rotor"][0], value) for row, value in seen.items())
    good &= same and result.status == "finished"
    size, count = path.stat().st_size, round(duration * RATE) + 1
    lines.append(f"| file | {count:,} samples, {size / 1e6:.0f} MB; {result.status}; {result.steps:,} steps |")
    lines.append(f"| read while it was written | {len(seen)} times, up to its last block; the values of the end: {same} |")
    for text in ("info run.h5", "verify run.h5", "verify run.h5 --block 0", "plot run.h5 -o pictures"):
        words = text.split(" ")
        code, seconds, peak, output = timed(folder, *words)
        good &= code == 0 and (words[0] != "verify" or "the same bits" in output)
        lines.append(f"| rsc {text} | exit {code}, {seconds:.1f} s of processor time, {peak:.0f} MB at most |")
    lines.append(f"| all as it should be | {'yes' if good else 'no'} |")
    return lines, good


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--duration", type=float, default=7200.0, help="s of machine time")
    parser.add_argument("--write", action="store_true", help="keep the table in bench/results")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rsc-two-hours-") as folder:
        lines, good = measured(options.duration, Path(folder))
    text = "\n".join(lines)
    print(text)
    if options.write:
        write_page(RESULTS / "two_hours.md", "Two hours of machine time", "python bench/two_hours.py --write", text)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
