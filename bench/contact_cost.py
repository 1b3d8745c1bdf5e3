"""What a step costs with one contact, now and before several contacts came, and with two contacts beside one.

    python bench/contact_cost.py [--before 0c99566~1] [--starts 5] [--repeats 9] [--attempts 50000] [--write]

The sources of the commit before are taken from git into a folder of their own, and each program runs in a process of its own.
Both take turns on every problem of problems.py, from its start to its end as often as 0.1 s take. Of each repetition the
processor times are compared, and the programs are started anew some times, since where code and data happen to lie moves a ratio
by some percent: the ratio told is the median of all ratios, with their quartiles; beside it whether both end in the
same bits, which they reach by the same steps. Two contacts are those of a pump on its whirl at both
(tests/support/two_seals.py); it is compared with the same machine with one of them, on its whirl there, and once more with the
second too far away to be touched.
--write: the page bench/results/contact_cost.md.
"""

import argparse
import hashlib
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "support")]

BEFORE = "0c99566~1"  # its child simulates several contacts
METHODS = "rk45", "taylor8"
PUMPS = "one contact, in whirl there", "two contacts, one of them far", "two contacts, in whirl at both"
LEAST = 0.1  # s of processor time in a repetition
WHOLE = 10**9  # attempts that end a run


def pump_scene(name):
    """The pump on a whirl with one contact, with one far away, or with both pressed."""
    import rsc
    from two_seals import PUMP, pump

    scene = pump()
    if name != PUMPS[2]:
        alone = rsc.Scene.from_dict({**PUMP, "contact": PUMP["contact"][0]})
        scene = alone if name == PUMPS[0] else pump(bush={"gap": 0.1})
    pressed = ("seal", "bush") if name == PUMPS[2] else ("seal",)
    chosen = [w for w in rsc.predict(scene) if w.growth_rate < 0.0 and getattr(w, "pressed", ("seal",)) == pressed]
    whirl = max(chosen, key=lambda one: one.normal_force)
    turn, start = 2j * np.pi * whirl.frequency, {}
    for part, shape in (("rotor", whirl.rotor_shape), ("stator", whirl.stator_shape)):
        start[f"start.{part}"], start[f"start.{part}_velocity"] = plain(shape), plain(turn * shape)
    return scene.with_values(start | {"start.allow_penetration": True, "drive.duration": 1e3})


def plain(shape):
    """Complex numbers as a scene has them."""
    return [[float(value.real), float(value.imag)] for value in shape]


def worker():
    """Answer lines [problem, method, attempts, rounds] with [s of processor time a round, hash of the last state]."""
    from problems import NAMES, scene_of
    from rsc.simulation.shot import Shot, packed_for_shots
    from rsc.study.run.start import initial_state
    from rsc.system.assemble import assemble

    made = {}
    for line in sys.stdin:
        name, method, attempts, rounds = json.loads(line)
        if (name, method) not in made:
            scene = scene_of(name) if name in NAMES else pump_scene(name)
            scene = scene.with_values({"solver.method": method, "solver.rtol": 1e-6})
            system = assemble(scene)
            made[name, method] = packed_for_shots(system, scene, 1.0), initial_state(scene, system)
        took = 0.0
        for _ in range(rounds):
            shot = Shot(*made[name, method])
            begin = time.process_time()
            goes_on = shot.advance(attempts)
            took += time.process_time() - begin
            assert goes_on == (attempts < WHOLE), "a run of another length"
        state = shot.state()
        parts = (state.rotor, state.rotor_velocity, state.stator, state.stator_velocity)
        digest = hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()
        print(json.dumps([took / rounds, digest]), flush=True)


class Program:
    """rsc of some sources, in a process of its own."""

    def __init__(self, sources):
        environment = os.environ | {"PYTHONPATH": str(sources), "OMP_NUM_THREADS": "1"}
        self._process = subprocess.Popen(
            [sys.executable, __file__, "--worker"], env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def asked(self, *question):
        """[s, hash of the state in the end]."""
        self._process.stdin.write(json.dumps(question) + "\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())

    def close(self):
        self._process.stdin.close()
        self._process.wait()


def sources_of(commit, folder):
    """The folder src of a commit, in a folder."""
    archive = subprocess.run(["git", "-C", str(ROOT), "archive", commit, "src"], check=True, stdout=subprocess.PIPE).stdout
    with tarfile.open(fileobj=io.BytesIO(archive)) as file:
        file.extractall(folder, filter="data")
    return Path(folder) / "src"


def in_turns(questions, repeats):
    """(processor times s (repeats, 2), whether the bits are the same) of two (program, name, method, attempts), in turns."""
    for program, *question in 2 * questions:  # the first time compiles
        first, _ = program.asked(*question, 1)
    rounds, times, digests = int(np.ceil(LEAST / first)), [], set()
    for i in range(repeats):
        order = (0, 1) if i % 2 else (1, 0)
        pair = dict(zip(order, (questions[k][0].asked(*questions[k][1:], rounds) for k in order), strict=True))
        times.append([pair[0][0], pair[1][0]])
        digests |= {digest for _, digest in pair.values()}
    return np.array(times), len(digests) == 1


def row(name, method, times, more=""):
    """A line of a table: both times in words, and the ratio of the second to the first."""
    low, middle, high = np.percentile(times[:, 1] / times[:, 0], (25, 50, 75))
    first, second = np.median(times, axis=0)
    return f"| {name} | {method} | {first:.4g} | {second:.4g} | {middle:.3f} | {low:.3f} to {high:.3f} |{more}"


def main():
    """Print the tables, or write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--before", default=BEFORE)
    parser.add_argument("--starts", type=int, default=5, help="times that the programs are started")
    parser.add_argument("--repeats", type=int, default=9, help="repetitions after each start")
    parser.add_argument("--attempts", type=int, default=50_000)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        worker()
        return
    from pages import RESULTS, write_page
    from problems import NAMES

    asked = {}
    for name in NAMES:
        asked |= {(name, method): ((name, 0), (name, 1), WHOLE) for method in METHODS}
    for name in PUMPS[1:]:
        asked |= {(name, method): ((PUMPS[0], 1), (name, 1), options.attempts) for method in METHODS}
    times, same = {key: [] for key in asked}, dict.fromkeys(asked, True)
    with tempfile.TemporaryDirectory() as folder:
        sources = sources_of(options.before, folder), ROOT / "src"
        for _ in range(options.starts):
            programs = [Program(place) for place in sources]
            for (name, method), (*both, attempts) in asked.items():
                questions = [(programs[which], problem, method, attempts) for problem, which in both]
                more, as_before = in_turns(questions, options.repeats)
                times[name, method].append(more)
                same[name, method] &= as_before
                print(row(name, method, more), flush=True)
            for program in programs:
                program.close()
    lines = ["| problem | method | before, ms a run | now | ratio | quartiles | bits |", "|---|---|---|---|---|---|---|"]
    for key in asked:
        if key == (PUMPS[1], METHODS[0]):
            lines += ["", "| pump | method | one contact, ns a step | two | ratio | quartiles |", "|---|---|---|---|---|---|"]
        alone = key[0] in NAMES
        factor, bits = (1e3, " same |" if same[key] else " other |") if alone else (1e9 / options.attempts, "")
        lines.append(row(*key, factor * np.concatenate(times[key]), bits))
    print("\n".join(lines))
    if options.write:
        counts = " ".join(f"--{name} {getattr(options, name)}" for name in ("starts", "repeats", "attempts"))
        command = f"python bench/contact_cost.py {counts} --write"
        head = f"rtol 1e-6; before: commit {options.before}. Processor times in turns. Asked of one contact: at most 1.02; "
        head += "of two: at most 1.6 times one.\n\n"
        write_page(RESULTS / "contact_cost.md", "Cost of a step with one and with two contacts", command, head + "\n".join(lines))


if __name__ == "__main__":
    main()
