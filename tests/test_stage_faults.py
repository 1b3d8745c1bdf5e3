"""NaN and infinity in single stages of a step: a copy of the kernel whose accelerations are poisoned from an instant on.

The instant lies between the nodes of a step, so that the step's first stages are good and the others are not. Runs in a process
of its own, because the copy is compiled like the kernel.
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
# speed from which on all is infinite
POISONED = GOOD + """\
    if turn.omega > abs(con.slip_velocity):
        a = (math.nan if con.slip_velocity > 0.0 else math.inf) * a
"""

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
    rhs = folder / "rsc" / "kernel" / "rhs.py"
    text = rhs.read_text()
    assert text.count(GOOD) == 1
    rhs.write_text("import math\n" + text.replace(GOOD, POISONED))
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
    ends = poisoned_runs(tmp_path, tables, [*speeds, *-speeds])
    assert {end["status"] for end in ends} <= {"non-finite", "step collapsed"}
    for time, end in zip([*times, *times], ends, strict=True):
        assert end["finite"] and end["calls"] < 10_000
        # the run gets near to the instant and never beyond; a speed of 314 rad/s tells it to 4e-16 s
        assert 0.999 * time <= end["end"] <= time + 1e-14
        assert end["samples"] == int(end["end"] * 2000.0) + 1 and end["advice"]
