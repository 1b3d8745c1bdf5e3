"""The main job from the command line, whole and phase by phase: `rsc check` of the reference run-up, its page, its pictures.

    python bench/main_job.py [--before FOLDER] [--long] [--quick] [--write]
    python bench/main_job.py --samples 1e8 [--write]

Processor times, the least of three, of commands in processes of their own, start and libraries included, whose kernel is
compiled; the phases in the order in which `rsc check` runs through them, in one process. --before measures the commands of an
older checkout as well. --long measures the page of a result of two hours at 2 kHz that was not analysed before. --quick: each
command once. --samples: only the page of a result of so many samples (10^8: nine gigabytes for a while). --write:
results/main_job.md, and results/long_page.md of --samples.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from pages import RESULTS, write_page  # noqa: E402

REFERENCE = ROOT / "data" / "reference" / "gyroscopic_figure3_right.toml"
LONG = 7200.0  # s
RATE, LONGEST = 2000.0, 40000.0  # Hz, and s up to which solver.max_steps lets the reference run go
# processor seconds, megabytes of memory and of the page that are asked for
LIMITS = {"rsc check": 3.0, "rsc check without page": 1.5, "rsc plot": 2.0}
LONG_LIMITS = 60.0, 400.0
PAGE_LIMIT = 1.1, 0.5  # MB, s
COMMAND = """
import json, sys, time
from rsc.cli import main
if "no page" in sys.argv[1]:
    import rsc.show.page
    rsc.show.page.write_page = lambda report, path: path
if "no lists" in sys.argv[1]:
    import rsc.study.report.check
    rsc.study.report.check._motions = lambda scene, features: []
code = main(sys.argv[2:])
# not getrusage: its peak is inherited from the process that started this one
peak = next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM:"))
print(json.dumps([time.process_time(), peak / 1024, code]), file=sys.stderr)
"""


def command(source, folder, *arguments, page=True, lists=True, times=3):
    """(least processor s, largest MB) of a command of the checkout `source`, run in a folder."""
    environment, runs = os.environ | {"PYTHONPATH": str(Path(source) / "src")}, []
    for _ in range(times):
        without = ["no page"] * (not page) + ["no lists"] * (not lists)
        line = [sys.executable, "-c", COMMAND, ", ".join(without), *map(str, arguments)]
        done = subprocess.run(line, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(done.stderr)
        runs.append(json.loads(done.stderr.splitlines()[-1]))
        if runs[-1][2]:
            raise SystemExit(done.stderr)
    return min(run[0] for run in runs), max(run[1] for run in runs)


def commands(source, folder, times):
    """name -> (s, MB) of the commands of a checkout."""
    check, plot = ("check", REFERENCE, "-o", "out"), ("plot", Path("out") / "result.h5", "-o", "pictures")
    command(source, folder, *check, times=1)  # compiles
    times_of = {"rsc check": command(source, folder, *check, times=times)}
    if (Path(source) / "src" / "rsc" / "show" / "page").exists():
        times_of["rsc check without page"] = command(source, folder, *check, page=False, times=times)
        times_of["rsc report"] = command(source, folder, "report", Path("out") / "result.h5", times=times)
    return times_of | {"rsc plot": command(source, folder, *plot, times=times)}


def phases(folder):
    """[(name, s)] of `rsc check` in this process, which has imported nothing of rsc yet."""
    laps = [("interpreter", time.process_time())]

    def lap(name):
        laps.append((name, time.process_time()))

    from rsc.scene.scene import load_scene

    scene = load_scene(REFERENCE)
    lap("scene, NumPy, pint")
    from rsc.study.run.simulate import simulate
    from rsc.system.blas import one_thread

    lap("Numba")
    with one_thread:
        result = simulate(scene, path=folder / "phases.h5")
        lap("kernel from its cache, and simulation")
        from rsc.study.report import check

        lap("SciPy and the analysis")
        system = check.assemble(scene)
        seen = check.observed(result, system)
        lap("prediction, spectra, lines, envelope, paths")
        report = check.compared(result, system, *seen)
        lap("harmonic balance, comparison, stability of the rub")
        from rsc.show.page import page
        from rsc.study.report.stored import write_stored

        page(report)
        lap("page")
        write_stored(report, folder / "report.json")
        lap("report.json")
    return [(name, end - begin) for (name, end), (_, begin) in zip(laps, [("", 0.0), *laps], strict=False)]


def long_page(folder, duration=LONG, rate=RATE):
    """(s, MB of memory, MB) of the page of a result of so many seconds, two hours, with so many samples a second."""
    text = REFERENCE.read_text(encoding="utf-8").replace("duration = 180.0", f"duration = {duration}")
    (folder / "long.toml").write_text(f"{text}\n[output]\nrate = {rate}\n", encoding="utf-8")
    command(ROOT, folder, "run", "long.toml", times=1)
    return *command(ROOT, folder, "report", "long.h5", times=1), (folder / "long.html").stat().st_size / 1e6


def many_samples(count, folder):
    """Lines on the page of a result of so many samples."""
    duration = min(count / RATE, LONGEST)
    seconds, megabytes, size = long_page(folder, duration, count / duration)
    written = (folder / "long.h5").stat().st_size / 1e9
    return [
        f"A result of {count:g} samples ({duration:g} s at {count / duration:g} Hz, {written:.1f} GB), not analysed before, "
        f"`rsc report`: {seconds:.0f} s of processor time, {megabytes:.0f} MB (asked: at most {LONG_LIMITS[1]:g}), a page of "
        f"{size:.2f} MB."
    ]


def table(header, rows):
    """A table in Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return ["| " + " | ".join(cells) + " |" for cells in lines] + [""]


def told(options, folder):
    """Lines of the table."""
    times = 1 if options.quick else 3
    now = commands(ROOT, folder, times)
    phase_rows = [[name, f"{seconds:.2f}"] for name, seconds in phases(folder)]  # after them: the kernel is compiled
    before = commands(Path(options.before).resolve(), folder, times) if options.before else {}
    rows = []
    for name, (seconds, megabytes) in now.items():
        old = f"{before[name][0]:.2f}" if name in before else ""
        limit = f"{LIMITS[name]:.1f}" if name in LIMITS else ""
        rows.append([f"`{name}`" if " without " not in name else name, old, f"{seconds:.2f}", limit, f"{megabytes:.0f}"])
    page, writing = (folder / "out" / "report.html").stat().st_size / 1e6, dict(phase_rows)["page"]
    lines = table(["command", "before, s", "now, s", "asked: at most", "memory, MB"], rows)
    lines += [f"The page has {page:.2f} MB (at most {PAGE_LIMIT[0]:g}), written in {writing} s (at most {PAGE_LIMIT[1]:g}).", ""]
    lines += table(["phase of `rsc check`", "s"], phase_rows)
    if options.long:
        seconds, megabytes, size = long_page(folder)
        lines.append(
            f"A result of {LONG:g} s at 2 kHz, not analysed before, `rsc report`: {seconds:.1f} s (at most {LONG_LIMITS[0]:g}), "
            f"{megabytes:.0f} MB (at most {LONG_LIMITS[1]:g}), a page of {size:.2f} MB."
        )
    return lines


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--before", metavar="FOLDER", help="an older checkout, measured as well")
    parser.add_argument("--long", action="store_true", help="a result of two hours as well")
    parser.add_argument("--samples", type=float, metavar="N", help="only the page of a result of so many samples")
    parser.add_argument("--quick", action="store_true", help="each command once")
    parser.add_argument("--write", action="store_true", help="keep the table in bench/results")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        lines = many_samples(options.samples, Path(name)) if options.samples else told(options, Path(name))
    print("\n".join(lines))
    if options.write and options.samples:
        by = f"python bench/main_job.py --samples {options.samples:g} --write"
        write_page(RESULTS / "long_page.md", "The page of a result of many samples", by, "\n".join(lines))
    elif options.write:
        arguments = " ".join(["--quick"] * options.quick + ["--long"] * options.long + ["--before FOLDER"] * bool(options.before))
        write_page(RESULTS / "main_job.md", "The main job", f"python bench/main_job.py {arguments} --write", "\n".join(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
