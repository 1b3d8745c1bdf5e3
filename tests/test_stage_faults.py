"""NaN and infinity in the stages of a step: a copy of the kernel whose accelerations are poisoned from an instant on.

Either in every call from the instant on, which lies between the nodes of a step, so that the step's first stages are good and
the others are not; or in one stage alone, so that no other tells of it. Runs in a process of its own, because the copy is
compiled like the kernel.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

from rsc.kernel.model import H
from rsc.kernel.tableau import DORMAND_PRINCE
from rsc.run import Run
from rsc.scene import Scene
from scenes import SCENES

SOURCES = Path(__file__).parents[1] / "src"
GOOD = "    a = vec.fma(field.stiffness, x, imposed) + damping\n"
# without a contact diameter the kernel makes no use of slip_velocity: it carries the speed from which on all is NaN, or minus the
# speed from which on all is infinite; and for a stage alone STAGE times its number more
STAGE = 1e4
POISONED = GOOD + """\
    if turn.omega > abs(con.slip_velocity):
        a = (math.nan if con.slip_velocity > 0.0 else math.inf) * a
"""
ONE = """
@inlined
def poisoned(con, turn, stage, a):
    speed = abs(con.slip_velocity) - 1e4 * stage
    hit = 0.0 < speed < 1e4 and turn.omega > speed
    return (math.nan if con.slip_velocity > 0.0 else math.inf) * a if hit else a


@inlined
def _pair_step(con,"""
STAGES = {  # of step.py; the slope of the end is that of the next step's first stage
    "\n@inlined\ndef _pair_step(con,": ONE,
    "v, pick(turns, lane))\n": "v, pick(turns, lane))\n        a = poisoned(con, pick(turns, lane), i + 1, a)\n",
    "v_new, pick(turns, END))\n": "v_new, pick(turns, END))\n    a_new = poisoned(con, pick(turns, END), 7, a_new)\n",
}

WORKER = """
import json, sys
import numpy as np
import rsc
from rsc.kernel import model as kernel
from rsc.run import Run
from rsc.trajectory import MemoryBlocks

scene = rsc.Scene.from_dict(json.loads(sys.argv[1]))

def at(speed):
    run = Run(scene)
    packed = run.packed
    object.__setattr__(packed, "model", packed.model._replace(slip_velocity=speed))
    sink = MemoryBlocks()
    for block, status in run.chunks():
        sink.append(block)
    rotor = sink.series("rotor")
    summary = run.summary(status)
    finite = bool(np.isfinite(run.work.x).all() and np.isfinite(run.work.v).all() and np.isfinite(rotor).all())
    return {"status": summary.status, "calls": summary.rhs_calls, "end": summary.end_time, "finite": finite,
            "advice": summary.advice, "samples": int(rotor.shape[0])}

print(json.dumps([at(float(speed)) for speed in sys.argv[2:]]))
"""


def poisoned_runs(folder, tables, speeds):
    """What runs of a scene come to that are poisoned from rotor speeds (rad/s) on."""
    shutil.copytree(SOURCES / "rsc", folder / "rsc", ignore=shutil.ignore_patterns("__pycache__"))
    for name, changes in (("rhs", {GOOD: POISONED}), ("step", STAGES)):
        source = folder / "rsc" / "kernel" / f"{name}.py"
        text = source.read_text()
        for good, bad in changes.items():
            assert text.count(good) == 1
            text = text.replace(good, bad)
        source.write_text("import math\n" + text)
    environment = os.environ | {"PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}
    command = [sys.executable, "-c", WORKER, json.dumps(tables), *map(str, speeds)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_poisoned_stage_ends_the_run_at_the_last_good_state(tmp_path):
    tables = {**SCENES["bouncing"], "solver": {"rtol": 1e-6}}
    run = Run(Scene.from_dict(tables))
    h, (f_0, f_1) = run.work.real[H], run.packed.model.corner_speed
    nodes = np.unique(DORMAND_PRINCE.nodes)
    inside = 0.5 * (nodes[1:] + nodes[:-1])  # between the stages of the first step: 2, 3, 4, 5 and the last ones are hit first
    later = np.array([0.01, 0.03, 0.05])  # s, after hundreds of steps and in contact
    times = np.concatenate([h * inside, later])
    speeds = 2 * np.pi * (f_0 + (f_1 - f_0) * times / tables["drive"]["duration"])
    alone = [speed + STAGE * stage for stage in range(2, 8) for speed in speeds[-len(later) :]]
    ends = poisoned_runs(tmp_path, tables, [*speeds, *-speeds, *alone, *np.negative(alone)])
    assert {end["status"] for end in ends} <= {"non-finite", "step collapsed"}
    both, ends_alone = ends[: 2 * len(times)], ends[2 * len(times) :]
    for i, end in enumerate(ends_alone):
        time, stage = later[i % len(later)], 2 + i // len(later) % 6
        assert end["finite"] and end["calls"] < 10_000
        # the last good step may end beyond the instant when its poisoned stage lies before; later stages hold it back
        beyond = 1e-3 if stage < 6 else 1e-10
        assert 0.999 * time <= end["end"] <= time + beyond and end["advice"]
    for time, end in zip([*times, *times], both, strict=True):
        assert end["finite"] and end["calls"] < 10_000
        # the run gets near to the instant and never beyond; a speed of 314 rad/s tells it to 4e-16 s
        assert 0.999 * time <= end["end"] <= time + 1e-14
        assert end["samples"] == int(end["end"] * 2000.0) + 1 and end["advice"]
