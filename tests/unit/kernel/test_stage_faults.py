"""NaN and infinity in the stages of a step: a copy of the kernel whose accelerations are poisoned from an instant on.

Either in every call from the instant on, which lies between the nodes of a step, so that the step's first stages are good and
the others are not; or in one stage of a pair or one term of a series alone, so that no other tells of it. One copy for all: which
place is poisoned, with what and when is a number of the model. Runs in a process of its own, because the copy is compiled like
the kernel.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rsc.kernel.model import H
from rsc.kernel.tableau import DORMAND_PRINCE, METHODS, table_of
from rsc.scene.scene import Scene
from rsc.study.run.start import run_of
from scenes import SCENES

SOURCES = Path(__file__).parents[3] / "src"
GOOD = "    a, damped, driven, rotating, following, control = _accelerated(con, field, state, turn, pushes, weight, work)\n"
# without a contact diameter the kernel makes no use of slip_velocity: it carries the speed from which on all is NaN, or minus the
# speed from which on all is infinite; and for a stage or term alone STAGE times its number more
STAGE, END = 1e4, 20
POISONED = (
    GOOD
    + """\
    if turn.omega > abs(con.contacts[0].surfaces.slip_velocity):
        a = (math.nan if con.contacts[0].surfaces.slip_velocity > 0.0 else math.inf) * a
"""
)
ONE_STAGE = """
@inlined
def poisoned(con, turn, stage, a):
    speed = abs(con.contacts[0].surfaces.slip_velocity) - 1e4 * stage
    hit = 0.0 < speed < 1e4 and turn.omega > speed
    return (math.nan if con.contacts[0].surfaces.slip_velocity > 0.0 else math.inf) * a if hit else a


@inlined
def _pair_step(con,"""
ONE_TERM = """
def poisoned(con, turn, term, a):
    builder, zero = a.builder, ir.Constant(ir.DoubleType(), 0.0)
    size = con.contacts[0].surfaces.slip_velocity
    positive = builder.fcmp_ordered(">", size.code, zero)
    speed = Emitted(builder, size.kind, builder.select(positive, size.code, (size * -1.0).code)) - 1e4 * term
    hit = builder.fcmp_ordered(">", speed.code, zero)
    hit = builder.and_(hit, builder.fcmp_ordered("<", speed.code, ir.Constant(zero.type, 1e4)))
    hit = builder.and_(hit, builder.fcmp_ordered(">", turn.omega.code, speed.code))
    bad = builder.select(positive, ir.Constant(zero.type, math.nan), ir.Constant(zero.type, math.inf))
    return a * Emitted(builder, size.kind, builder.select(hit, bad, ir.Constant(zero.type, 1.0)))


def _expand(con,"""
CHANGES = {
    "rhs": {GOOD: POISONED},
    "step": {  # the slope of the end is that of the next step's first stage
        "\n@inlined\ndef _pair_step(con,": ONE_STAGE,
        "weight_of_next(method, slopes), work)\n": "weight_of_next(method, slopes), work)\n"
        "    a = poisoned(con, turn, len(slopes) + 1, a)\n",
        "places, 1.0, no_powers(con))\n": f"places, 1.0, no_powers(con))\n    a = poisoned(con, turn, {END}, a)\n",
    },
    "series": {
        "\ndef _expand(con,": ONE_TERM,
        "        v.append(a)\n": "        v.append(poisoned(con, clock, k + 1, a))\n",
        "from numba import types\n": "from llvmlite import ir\nfrom numba import types\n",
    },
}

WORKER = """
import json, sys
import numpy as np
import rsc
from rsc.results.trajectory import MemoryBlocks
from rsc.study.run.start import run_of

def at(tables, speed):
    run = run_of(rsc.Scene.from_dict(tables))
    packed = run.packed
    contact = packed.model.contacts[0]
    contact = contact._replace(surfaces=contact.surfaces._replace(slip_velocity=speed))
    object.__setattr__(packed, "model", packed.model._replace(contacts=(contact,)))
    sink = MemoryBlocks()
    for block, status in run.chunks():
        sink.append(block)
    rotor = sink.series("rotor")
    summary = run.summary(status)
    finite = bool(np.isfinite(run.work.x).all() and np.isfinite(run.work.v).all() and np.isfinite(rotor).all())
    return {"status": summary.status, "calls": summary.rhs_calls, "end": summary.end_time, "finite": finite,
            "advice": summary.advice, "samples": int(rotor.shape[0])}

print(json.dumps([at(tables, speed) for tables, speed in json.load(sys.stdin)]))
"""


def tables_of(method):
    """A bouncing rotor, started up."""
    return {**SCENES["bouncing"], "solver": {"rtol": 1e-6, "method": method}}


def speed_at(times):
    """Rotor speed in rad/s of the bouncing rotor."""
    drive = SCENES["bouncing"]["drive"]
    return 2 * np.pi * (drive["speed"][0] + np.subtract(*drive["speed"][::-1]) * np.array(times) / drive["duration"])


LATER = (0.01, 0.03, 0.05)  # s, after many steps and in contact


def places_of(method):
    """Numbers of the stages or terms after the first, which is the end of the step before."""
    table = table_of(METHODS[method])
    return [*range(2, len(table.nodes) + 1), END] if table else range(1, len(METHODS[method]) + 1)


def alone():
    """(method, place, time, speed from which on it is poisoned) of every place poisoned alone."""
    found = [(method, place, time) for method in METHODS for place in places_of(method) for time in LATER]
    return [(*case, sign * (speed_at(case[2]) + STAGE * case[1])) for case in found for sign in (1, -1)]


def all_at_once():
    """(time, speed from which on it is poisoned) of runs whose every acceleration is."""
    nodes = np.unique(DORMAND_PRINCE.nodes)
    inside = 0.5 * (nodes[1:] + nodes[:-1])  # between the stages of the first step: 2, 3, 4, 5 and the last ones are hit first
    times = [*run_of(Scene.from_dict(tables_of("rk45"))).work.real[H] * inside, *LATER]
    return [(time, sign * speed_at(time)) for time in times for sign in (1, -1)]


@pytest.fixture(scope="module")
def ends(tmp_path_factory):
    """What all poisoned runs come to, by (method, speed); in one process, which compiles each method once."""
    folder = tmp_path_factory.mktemp("poisoned")
    shutil.copytree(SOURCES / "rsc", folder / "rsc", ignore=shutil.ignore_patterns("__pycache__"))
    for name, changes in CHANGES.items():
        source = folder / "rsc" / "kernel" / f"{name}.py"
        text = source.read_text()
        for good, bad in changes.items():
            assert text.count(good) == 1
            text = text.replace(good, bad)
        source.write_text("import math\n" + text)
    runs = [(method, speed) for method, *_, speed in alone()] + [("rk45", speed) for _, speed in all_at_once()]
    environment = os.environ | {"PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}
    work = json.dumps([(tables_of(method), float(speed)) for method, speed in runs])
    command = [sys.executable, "-c", WORKER]
    done = subprocess.run(command, env=environment, input=work, capture_output=True, text=True, timeout=400, check=False)
    assert done.returncode == 0, done.stderr
    return dict(zip(runs, json.loads(done.stdout), strict=True))


def ended_well(end):
    """Whether a run ended at once and honestly, with samples up to its last good state."""
    assert end["status"] in ("non-finite", "step collapsed") and end["advice"]
    assert end["finite"] and end["calls"] < 10_000
    assert end["samples"] == int(end["end"] * 2000.0) + 1
    return True


@pytest.mark.nightly  # compiles two kernels with a fault
@pytest.mark.parametrize("method", METHODS)
def test_a_poisoned_stage_or_term_ends_the_run_at_the_last_good_state(method, ends):
    table = table_of(METHODS[method])
    for _, place, time, speed in (case for case in alone() if case[0] == method):
        end = ends[method, speed]
        # the last good step may end beyond the instant when its poisoned stage lies before; later stages hold it back
        held = table and (place == END or table.nodes[place - 1] == 1.0)
        assert ended_well(end) and 0.999 * time <= end["end"] <= time + (1e-10 if held else 5e-3)


def test_accelerations_poisoned_from_an_instant_on_end_the_run_there(ends):
    for time, speed in all_at_once():
        end = ends["rk45", speed]
        # the run gets near to the instant and never beyond; a speed of 314 rad/s tells it to 4e-16 s
        assert ended_well(end) and 0.999 * time <= end["end"] <= time + 1e-14
