"""Sweeps: 10,000 cases; a loop and a naive pool; dask beside threads; a killed worker; the memory of `rsc sweep collect`.

    python bench/sweep.py [--only map,naive,dask,collect] [--quick] [--repeats 2]

Timings are processor time of all processes that work on it, and wall time with the load of the machine beside it: on a busy
machine only the processor time means anything. "per core" is the processor time over the two threads: the wall time of an idle
machine with two cores at best. The ways of a section take turns; medians of the repeats. Writes sweep.csv, in which a section
replaces its own rows, and bench/results/sweep.md from it.
"""

import argparse
import csv
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

import rsc
from main_job import COMMAND
from problems import results_folder

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tools"))

from pages import write_page  # noqa: E402

FIELDS = ("section", "what", "cases", "repeats", "processor_s", "wall_s", "load", "remark")
TITLES = {
    "map": "A map of the Laval scene over friction and rotor speed, in this process on two threads",
    "naive": "Cases of that map by ways without a sweep",
    "dask": "Cases of 20 ms on the two threads of this process and on two local workers of dask",
    "collect": "What collecting takes of memory, in processes of their own",
}
THREADS = 2
START = {"rotor": [[2.55e-3, 0.0]], "rotor_velocity": [[0.0, -0.972]], "stator": [[1.5e-3, 0.0]],
         "stator_velocity": [[0.0, -0.57]], "allow_penetration": True}  # fmt: skip


def laval(duration=2.0, rate=2000.0):
    """The reference scene from an explicit start near its whirl, so that every case of a map can run."""
    content = rsc.load_scene(ROOT / "data" / "reference" / "laval.toml").to_dict()
    content |= {"start": START, "output": {"rate": rate}, "drive": {"speed": 50.0, "duration": duration}}
    return rsc.Scene.from_dict(content, "laval.toml")


def timed(run, workers=lambda: 0.0):
    """(processor s of this process, its children and the workers, wall s, what the call returned)."""
    before, begin = _processor() + workers(), time.perf_counter()
    value = run()
    return _processor() + workers() - before, time.perf_counter() - begin, value


def _processor():
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def rows_of(section, ways, repeats, workers=lambda: 0.0):
    """Rows of the table from {what: (cases, call, remark)}, the ways taking turns after an untimed round."""
    spent, values = {what: [] for what in ways}, {}
    for repeat in range(-1, repeats):
        for what, (_, call, _) in ways.items():
            processor, wall, values[what] = timed(call, workers)
            print(section, what, repeat, f"{processor:.2f} {wall:.2f}", file=sys.stderr, flush=True)
            if repeat >= 0:
                spent[what].append((processor, wall))
    load = os.getloadavg()[0]
    return [
        [section, what, cases, repeats, *np.median(spent[what], axis=0).tolist(), load, remark(values[what])]
        for what, (cases, _, remark) in ways.items()
    ]


def statuses(data):
    """How the cases of a dataset ended."""
    words, counts = np.unique(data.status, return_counts=True)
    return ", ".join(f"{count} {word}" for word, count in zip(words, counts, strict=True))


def map_rows(quick, options):
    """10,000 cases by prediction and by runs."""
    n = 10 if quick else 100
    scene, vary = laval(), {"contact.friction": f"0.05:0.4:{n}", "drive.speed": f"20:100:{n}"}

    def way(kind):
        return n * n, lambda: rsc.sweep(scene, vary, kind, threads=THREADS), statuses

    return rows_of("map", {kind: way(kind) for kind in ("predict", "run")}, options.repeats)


def alone(values):
    """One case as somebody would write it: a scene, a run, three numbers."""
    friction, speed = values
    result = rsc.simulate(laval().with_values({"contact.friction": friction, "drive.speed": speed}))
    return str(result.status), float(abs(result.contact_rotor()).max()), float(result.normal_force.max())


def naive_rows(quick, options):
    """The same runs in a loop over `rsc.simulate` and in a process pool case by case, beside a sweep of as many."""
    n = 5 if quick else 20
    scene, vary = laval(), {"contact.friction": f"0.05:0.4:{n}", "drive.speed": f"20:100:{n}"}
    pairs = [(f, s) for f in np.linspace(0.05, 0.4, n).tolist() for s in np.linspace(20.0, 100.0, n).tolist()]

    def loop():
        return [alone(pair) for pair in pairs]

    def pool():
        with ProcessPoolExecutor(THREADS) as workers:
            return list(workers.map(alone, pairs))

    def ended(results):
        return f"{sum(status == 'finished' for status, _, _ in results)} finished"

    ways = {
        "rsc.sweep, run": (n * n, lambda: rsc.sweep(scene, vary, "run", threads=THREADS), statuses),
        "loop over rsc.simulate": (n * n, loop, ended),
        "process pool, case by case": (n * n, pool, ended),
    }
    return rows_of("naive", ways, options.repeats)


def files(folder):
    """name -> content of the parts of a store."""
    return {path.name: path.read_bytes() for path in Path(folder, "parts").iterdir()}


def dask_rows(quick, options):
    """Threads of this process and two workers of dask, by turns; then with a worker killed in the middle."""
    import distributed

    n = 8 if quick else 32
    scene, vary = laval(25.0, 500.0), {"contact.friction": f"0.05:0.4:{n}", "drive.speed": f"20:100:{n}"}
    how = {"threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50, "memory_limit": 0}
    with distributed.LocalCluster(THREADS, **how) as cluster, distributed.Client(cluster) as client, _folder() as folder:
        count = iter(range(1000))

        def stored(**how):
            path = Path(folder, str(next(count)))
            return path, rsc.sweep(scene, vary, "run", path=path, **how)

        def told(pair):
            return statuses(pair[1])

        ways = {
            "threads": (n * n, lambda: stored(threads=THREADS), told),
            "dask, two workers": (n * n, lambda: stored(executor=client), told),
        }
        rows = rows_of("dask", ways, options.repeats, lambda: sum(client.run(time.process_time).values()))
        victim, expected = next(iter(client.run(os.getpid).values())), files(Path(folder, "0"))
        at = Path(folder, "killed", "parts")
        killer = threading.Thread(target=_kill_when, args=(victim, at, len(expected) // 2))
        killer.start()
        path = Path(folder, "killed")
        data = rsc.sweep(scene, vary, "run", path=path, executor=client)
        killer.join()
        same = "the same files" if files(path) == expected else "OTHER FILES"
        rows.append(["dask", "dask, one worker killed -9", n * n, 1, "", "", "", f"{statuses(data)}; {same} as without"])
    return rows


def collect_rows(quick, options):
    """Two sizes, from whose difference follows what a case takes; the memory that is told and the largest that was taken."""
    rows = []
    with _folder() as folder:
        scene = Path(folder, "laval.toml")
        scene.write_text(laval().to_toml())
        for n in (20, 40) if quick else (100, 200):
            store, grid = str(Path(folder, str(n))), (f"contact.friction=0.05:0.4:{n}", f"drive.speed=20:100:{n}")
            command = [sys.executable, "-m", "rsc", "sweep"]
            vary = ["--vary", grid[0], "--vary", grid[1], "--compute", "predict"]
            subprocess.run([*command, str(scene), *vary, "-o", store, "--threads", str(THREADS)], check=True, capture_output=True)
            collect = [sys.executable, "-c", COMMAND, "", "sweep", "collect", store]
            said = subprocess.run(collect, check=True, capture_output=True, text=True).stderr
            told = re.search(r"([\d.]+ [MG]B) of memory at most", said)[1]
            seconds, peak, _ = json.loads(said.splitlines()[-1])
            remark = f"{peak * 1.048576:.1f} MB taken, {told} told"
            rows.append(["collect", f"rsc sweep collect, {n * n}", n * n, 1, seconds, "", "", remark])
    return rows


def _folder():
    return tempfile.TemporaryDirectory(prefix="rsc-bench-sweep-", ignore_cleanup_errors=True)


def _kill_when(victim, parts, count):
    """Kill a process when a folder holds so many parts."""
    while not parts.exists() or len(list(parts.glob("*.h5"))) < count:
        time.sleep(0.01)
    os.kill(victim, signal.SIGKILL)


SECTIONS = {"map": map_rows, "naive": naive_rows, "dask": dask_rows, "collect": collect_rows}


HEAD = "| what | cases | repeats | processor s | ms a case | per core s | wall s | load | |\n" + "|---" * 9 + "|"


def page(rows):
    """The table of all sections, and what follows from it."""
    lines = []
    for section, title in TITLES.items():
        own = [dict(zip(FIELDS, row, strict=True)) for row in rows if row[0] == section]
        if own:
            lines += [f"## {title}", "", HEAD, *map(_line, own), "", *_ratios(section, own)]
    return "\n".join(lines)


def _line(row):
    """A row of the table."""
    times = ["", "", ""]
    if row["processor_s"]:
        spent = float(row["processor_s"])
        times = [f"{spent:.2f}", f"{1e3 * spent / int(row['cases']):.3f}", f"{spent / THREADS:.1f}"]
    wall = [f"{float(row[name]):.1f}" if row[name] else "" for name in ("wall_s", "load")]
    return f"| {' | '.join([row['what'], row['cases'], row['repeats'], *times, *wall, row['remark']])} |"


def _ratios(section, rows):
    """What a section shows."""
    spent = {row["what"]: float(row["processor_s"]) / int(row["cases"]) for row in rows if row["processor_s"]}
    if section == "naive":
        base = spent.pop("rsc.sweep, run")
        return [f"{what}: {value / base:.1f} times the processor time of the sweep.\n" for what, value in spent.items()]
    if section == "dask":
        walls = {row["what"]: float(row["wall_s"]) for row in rows if row["wall_s"]}
        ratios = [pair["dask, two workers"] / pair["threads"] for pair in (spent, walls)]
        return [f"dask over threads: {ratios[0]:.3f} in processor time, {ratios[1]:.3f} in wall time.\n"]
    if section == "collect":
        sizes = [int(row["cases"]) for row in rows]
        taken, told = (np.diff([float(row["remark"].split(" MB")[i].split()[-1]) for row in rows])[0] for i in (0, 1))
        each = 1e6 / (sizes[1] - sizes[0])
        return [f"A case takes {taken * each:.0f} bytes, told are {told * each:.0f}.\n"]
    return []


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default=",".join(SECTIONS), help="sections, separated by commas")
    parser.add_argument("--quick", action="store_true", help="few cases, once, into out/bench/")
    parser.add_argument("--repeats", type=int, default=2)
    options = parser.parse_args()
    options.repeats = 1 if options.quick else options.repeats
    wanted, path = options.only.split(","), results_folder(options.quick) / "sweep.csv"
    rows = []
    if path.exists():
        with open(path, newline="", encoding="utf-8") as file:
            rows = [row for row in list(csv.reader(file))[1:] if row[0] not in wanted]
    for section in wanted:
        rows += SECTIONS[section](options.quick, options)
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(FIELDS)
        writer.writerows([f"{item:.5g}" if isinstance(item, float) else item for item in row] for row in rows)
    with open(path, newline="", encoding="utf-8") as file:
        write_page(path.with_suffix(".md"), "Sweeps", "python bench/sweep.py", page(list(csv.reader(file))[1:]))
    print(path.with_suffix(".md").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
