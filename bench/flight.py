"""What flight between contacts gains: processor time and error with and without it, at equal settings of one commit.

    python bench/flight.py [--cases ross fine impacts strong rates machine] [--repeats 3] [--onsets 20] [--write]

Every case is run by rk45, by taylor8 as steps alone, and by taylor8 with flight; errors are the largest difference in gaps to a
run by steps alone of taylor8 at a tolerance of 1e-12 (judged by matrix exponentials and other programs in
tests/unit/simulation/test_flight.py and bench/work_precision.py), times the least of some repetitions of the kernel, in turns.
Ratios are taken at equal error: the time of the faster of rk45 and taylor8 alone, interpolated between their tolerances, over
that with flight. `--onsets N`: compare the first onsets of contact of N random machines with ringing modes. --write:
the page bench/results/flight.md.
"""

import argparse
import sys
import time
import tomllib
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import rsc
from ross_rotor import ross_scene
from rsc.kernel import model as kernel
from rsc.kernel.march import march
from rsc.machine.imports.ross import read_ross
from rsc.machine.imports.store import save_model
from rsc.simulation import pack
from rsc.simulation.run import new_work
from rsc.simulation.stretches import room_for
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble

ROOT = Path(__file__).resolve().parents[1]
sys.path.append(str(ROOT / "tools"))
from pages import RESULTS, write_page  # noqa: E402

TOLERANCES = 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9
EXACT = 1e-12
WHOLE = 10**9  # attempts that end a run
CALL = 200  # attempts of a call in which an onset is looked for
KINDS = {"rk45": ("rk45", False), "taylor8": ("taylor8", False), "flight": ("taylor8", True)}


def with_dampers(factor):
    """ROSS's first 5 s with other bearing dampers than its data have."""
    import ross_rotor

    kept = ross_rotor.tomllib.loads

    def loads(text):
        data = kept(text)
        for bearing in data["bearing"]:
            bearing["cxx"] *= factor
        return data

    ross_rotor.tomllib.loads = loads
    try:
        return ross_scene().with_values({"drive.speed": [0.0, 5.0], "drive.duration": 5.0})
    finally:
        ross_rotor.tomllib.loads = kept


def machine_scene(folder):
    """The two-disc rotor of data/reference/machines as rsc reduces it, on bearings whose stiffnesses differ, up to its rub."""
    data = ROOT / "data" / "reference"
    own = tomllib.loads((data / "raw" / "ross_rub_rotor.toml").read_text())
    rub, unbalance, file = own["rub"], own["unbalance"], Path(folder) / "rotor.npz"
    save_model(read_ross(data / "machines" / "ross_rub_rotor.mat", 20.0), file)
    weight = [[unbalance["node"], 1.2 * unbalance["magnitude"]]]
    return rsc.Scene.from_dict(
        {
            "rotor": {"model": "machine", "file": str(file), "contact": rub["node"], "unbalance": weight},
            "reduction": {"tolerance": 1e-3},
            "stator": {"model": "chain", "masses": [1.0, 0.3], "stiffnesses": [1e6, 1e6, 0.0], "rayleigh": [100.0, 1e-3]},
            "contact": {"stator_coordinate": 1} | {key: rub[key] for key in ("gap", "stiffness", "damping", "friction")},
            "drive": {"speed": [10.0, 30.0], "duration": 6.0},
        }
    )


def cases(folder):
    """name -> (title, scene, tolerances); folder: for files."""
    rub = {"drive.speed": [19.0, 19.0], "drive.duration": 5.0, "contact.stiffness": 1.1e8, "contact.friction": 0.02}
    ross = ross_scene()
    return {
        "ross": ("ROSS, 12 modes, 20 s", ross, TOLERANCES),
        "fine": ("ROSS, 24 modes, 20 s", ross_scene(24), (1e-5, 1e-6, 1e-8)),
        "impacts": ("ROSS at 19 Hz, k_C 1.1e8 N/m, friction 0.02, 5 s", ross.with_values(rub), TOLERANCES[:5]),
        "dampers 1": ("ROSS, first 5 s", with_dampers(1.0), TOLERANCES[2:5]),
        "dampers 10": ("the same, bearing dampers x 10", with_dampers(10.0), TOLERANCES[2:5]),
        "dampers 100": ("the same, bearing dampers x 100", with_dampers(100.0), TOLERANCES[2:5]),
        "machine": ("ROSS's rub rotor reduced, 10 to 30 Hz in 6 s", machine_scene(folder), (1e-4, 1e-6, 1e-8)),
        "rate 500": ("ROSS, first 5 s, output 500 Hz", with_dampers(1.0).with_values({"output.rate": 500.0}), (1e-6,)),
        "rate 20000": ("ROSS, first 5 s, output 20 kHz", with_dampers(1.0).with_values({"output.rate": 20000.0}), (1e-6,)),
    }


class Job:
    """A scene packed for the kernel, with memory for its samples."""

    def __init__(self, scene, method, rtol, flies):
        scene = scene.with_values({"solver.method": method, "solver.rtol": rtol})
        self.system = assemble(scene)
        kept = pack.with_flight
        if not flies:
            pack.with_flight = lambda model: (model, "")
        try:
            (self.packed,) = pack.pack_all([self.system], [scene])
        finally:
            pack.with_flight = kept
        self.start = initial_state(scene, self.system)
        self.width = self.packed.model.stiffness.size
        rows = int(scene.drive.duration * scene.output.rate) + 3
        self.out = np.zeros((rows, self.width + 3 * len(self.packed.model.contacts)))

    def run(self):
        """(processor time of the kernel, that of physical coordinates, complex motion (samples, n), Work)."""
        work, rows = new_work(self.packed, self.start), room_for(self.packed.model)
        begin = time.process_time()
        code, filled = march(self.packed.model, work, self.out, rows, self.packed.width, self.packed.method, WHOLE)
        middle = time.process_time()
        parts = self.packed.physical(self.out[:filled, : self.width])
        end = time.process_time()
        assert code == kernel.FINISHED, code
        return middle - begin, end - middle, np.hstack(parts), work


def measured(scene, tolerances, repeats):
    """(rows (kind, rtol, ms, ms of coordinates, error in gaps, steps, onsets), whether it flies)."""
    exact = Job(scene, "taylor8", EXACT, False).run()[2]
    gap = min(contact.gap for contact in scene.contacts)
    rows, flies = [], False
    for rtol in tolerances:
        jobs = {name: Job(scene, method, rtol, flies) for name, (method, flies) in KINDS.items()}
        flies = flies or bool(jobs["flight"].packed.model.flight)
        done = {name: [] for name in jobs}
        for job in jobs.values():
            job.run()  # compiled, and its memory touched
        for _ in range(repeats):
            for name, job in jobs.items():
                done[name].append(job.run())
        for name, results in done.items():
            spent, mapped = (1e3 * min(result[i] for result in results) for i in range(2))
            motion, work = results[0][2:]
            onsets = int(sum(kernel.of_contacts(work.count, kernel.ONSETS)))
            rows.append((name, rtol, spent, mapped, abs(motion - exact).max() / gap, int(work.count[kernel.STEPS]), onsets))
    return rows, flies


def time_at(rows, error):
    """ms that a kind takes for an error, between its tolerances; the loosest where all are better, None where none is as good."""
    pairs = sorted((row[4], row[2]) for row in rows)
    if error < pairs[0][0]:
        return None
    errors, times = zip(*pairs, strict=True)
    return float(np.exp(np.interp(np.log(error), np.log(errors), np.log(times))))


def ratio(rows, own):
    """Time of the faster kind without flight over that of a row with it, at its error."""
    times = [time_at([row for row in rows if row[0] == name], own[4]) for name in ("rk45", "taylor8")]
    known = [spent for spent in times if spent is not None]
    return min(known) / own[2] if known else None


def table(title, rows, flies):
    """The table of a case."""
    lines = [f"## {title}", ""] + ([] if flies else ["It does not fly: both columns of taylor8 are the same code.", ""])
    lines += [
        "| rtol | rk45 ms (error) | taylor8 ms (error) | with flight ms (error) | ratio at equal error | steps | onsets |",
        "|---|---|---|---|---|---|---|",
    ]
    for rtol in sorted({row[1] for row in rows}, reverse=True):
        each = {row[0]: row for row in rows if row[1] == rtol}
        cells = [f"{each[name][2]:.1f} ({each[name][4]:.1e})" for name in KINDS]
        gain = ratio(rows, each["flight"])
        steps, onsets = (" / ".join(str(each[name][i]) for name in ("taylor8", "flight")) for i in (5, 6))
        lines.append(f"| {rtol:g} | " + " | ".join(cells) + f" | {'-' if gain is None else f'{gain:.1f}'} | {steps} | {onsets} |")
    return [*lines, ""]


def ringing_scene(seed):
    """A random rotor whose fast modes ring, several times between two samples, while it comes near its gap."""
    rng = np.random.default_rng(seed)
    frequencies = np.array([rng.uniform(15.0, 60.0), 10.0 ** rng.uniform(2.3, 3.4), 10.0 ** rng.uniform(3.5, 3.9)])
    omega, gap = 2.0 * np.pi * frequencies, float(rng.uniform(4e-5, 1.5e-4))
    turn = np.linalg.qr(np.eye(3) + 0.3 * rng.standard_normal((3, 3)))[0]
    stiffness, damping = (turn @ np.diag(values) @ turn.T for values in (omega**2, 2.0 * rng.uniform(1e-3, 1e-2, 3) * omega))
    # of the gap, at the contact: the slow mode just inside, the fast ones with what they need to touch, or less
    size = gap * np.array([rng.uniform(0.8, 0.99), 0.05 * rng.random(), 0.2 * rng.random()])
    start = turn @ (size / turn[0] * np.exp(2j * np.pi * rng.random(3)))
    return rsc.Scene.from_dict(
        {
            "rotor": {
                "model": "matrices", "mass": np.eye(3).tolist(), "tilt_coordinates": [],
                "eccentricity": (0.1 * gap * rng.random(3)).tolist(),
                "stiffness": (0.5 * (stiffness + stiffness.T)).tolist(), "damping": (0.5 * (damping + damping.T)).tolist(),
            },
            "stator": {"model": "rigid"},
            "contact": {"gap": gap, "friction": 0.1, "stiffness": 1e6, "damping": 10.0},
            "drive": {"speed": [0.7 * frequencies[0], frequencies[0]], "duration": 1.0},
            "start": {"rotor": np.column_stack([start.real, start.imag]).tolist(), "allow_penetration": True},
            "output": {"rate": 2000.0},
        }
    )  # fmt: skip


def onset_of(scene, rtol, flies):
    """(time in s of the first onset of contact, inf for none, whether the scene flies): a call in which a contact began is made
    again in calls of one step, which change no bit."""
    job = Job(scene, "taylor8", rtol, flies)
    model, work, at_once, code = job.packed.model, new_work(job.packed, job.start), CALL, kernel.RUNNING
    while code in (kernel.RUNNING, kernel.BUFFER_FULL):
        before = kernel.Work(*(values.copy() for values in work))
        code, _ = march(model, work, job.out, room_for(model), job.packed.width, job.packed.method, at_once)
        if work.count[kernel.ONSETS] > 0:
            if at_once == 1:
                return float(work.real[kernel.T_HI]), bool(model.flight)
            work, at_once, code = before, 1, kernel.RUNNING
    return np.inf, bool(model.flight)


def onsets(count):
    """Lines on the first onsets of random machines, with flight at 1e-10 and by steps at 1e-11."""
    flown, touched, wrong, worst = 0, 0, 0, 0.0
    for seed in range(count):
        scene = ringing_scene(seed)
        (own, flies), (wanted, _) = onset_of(scene, 1e-10, True), onset_of(scene, 1e-11, False)
        flown, touched = flown + flies, touched + np.isfinite(wanted)
        if np.isfinite(own) != np.isfinite(wanted):
            wrong += 1
        elif np.isfinite(own):
            worst = max(worst, abs(own - wanted))
    return [
        "## First onsets of contact", "",
        f"{count} random machines with modes that ring (damping 0.1 to 1 %): {flown} fly, {touched} touch; onsets missed or",
        f"invented: {wrong}; first onsets differ by {worst:.1e} s at most (flight at rtol 1e-10, steps at 1e-11).", "",
    ]  # fmt: skip


def packing(repeats=20):
    """A line on the time that a scene takes to be packed."""
    lines = ["## Packing", ""]
    for modes in (12, 24):
        scene = ross_scene(modes)
        system, kept, spent = assemble(scene), pack.with_flight, {}
        for name, make in (("with", kept), ("without", lambda model: (model, ""))):
            pack.with_flight = make
            times = []
            for _ in range(repeats):
                begin = time.process_time()
                pack.pack_all([system], [scene])
                times.append(time.process_time() - begin)
            spent[name] = 1e3 * min(times)
        pack.with_flight = kept
        lines.append(f"{modes} modes: {spent['without']:.2f} ms without the weights of flight, {spent['with']:.2f} ms with them.")
    return [*lines, ""]


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", nargs="*", help="names of cases; all without")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--onsets", type=int, default=20, help="random machines whose first onsets are compared")
    parser.add_argument("--write", action="store_true", help="write bench/results/flight.md")
    options = parser.parse_args()
    lines = [f"Processor time of the kernel, least of {options.repeats}; errors in gaps. See the docstring of the command.", ""]
    with TemporaryDirectory() as folder:
        for name, (title, scene, tolerances) in cases(folder).items():
            if options.cases is None or name in options.cases:
                made = table(title, *measured(scene, tolerances, options.repeats))
                print("\n".join(made), flush=True)
                lines += made
    lines += (onsets(options.onsets) if options.onsets else []) + packing()
    text = "\n".join(lines)
    print(text)
    if options.write:
        command = f"python bench/flight.py --onsets {options.onsets} --write"
        write_page(RESULTS / "flight.md", "Flight between contacts", command, text)


if __name__ == "__main__":
    main()
