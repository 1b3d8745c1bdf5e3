"""A checkpoint that is not a possible state of a run of its scene is refused before the compiled kernel, which trusts it runs"""

import numpy as np
import pytest

import rsc
from rsc.errors import SolverError
from rsc.kernel import model as kernel
from rsc.simulation.run import Run
from rsc.study.run.start import run_of
from scenes import SCENES

SCENE = rsc.Scene.from_dict(SCENES["bouncing"])


@pytest.fixture
def checkpoint(monkeypatch):
    monkeypatch.setattr("rsc.simulation.run.CHUNK_STEPS", 500)
    run = run_of(SCENE)
    next(run.chunks())
    return run.checkpoint()


def put(name, place, value):
    def change(checkpoint):
        checkpoint[name][place] = value

    return change


def wider(name, kind=None):
    def change(checkpoint):
        checkpoint[name] = np.zeros(checkpoint[name].size + 2, kind or checkpoint[name].dtype)

    return change


def other_kind(checkpoint):
    checkpoint["x"] = checkpoint["x"].astype("f4")


def without_step(checkpoint):
    del checkpoint["real"]


def another(checkpoint):
    checkpoint["more"] = np.zeros(1)


def samples(number):
    def change(checkpoint):
        checkpoint["count"][kernel.SAMPLES] = checkpoint["rows"][0] = number

    return change


VECTORS = ("x", "v", "ledger_damping", "ledger_input", "real", "count", "sliding")
OTHER_VERSION = {f"{name} wider": wider(name) for name in VECTORS}
OTHER_VERSION |= {"x narrower": lambda c: c.update(x=c["x"][:1]), "x as f4": other_kind, "no real": without_step, "more": another}
IMPOSSIBLE = {
    f"count {i} {value}": put("count", i, value)
    for i in range(kernel.N_COUNT)
    for value in ((-(2**63), 2**63 - 1) if i not in (kernel.NORMAL, kernel.FRICTION) else (-7, 7, 2**62))
}
IMPOSSIBLE |= {
    f"real {name} {value}": put("real", i, value)
    for name, i in {"step": kernel.H, "time": kernel.T_HI, "rest of time": kernel.T_LO, "phase": kernel.PHASE}.items()
    for value in (np.nan, np.inf, -1e9, 1e9)
}
IMPOSSIBLE |= {f"{name} {value}": put(name, 0, value) for name in ("x", "v", "energy_start") for value in (np.nan, np.inf)}
IMPOSSIBLE |= {f"code {value}": put("code", 0, value) for value in (-1, 99, 2**62)}
IMPOSSIBLE |= {f"samples {number}": samples(number) for number in (-1, 0, 1, 2**40)}
IMPOSSIBLE |= {"no step": put("real", kernel.H, 0.0), "sliding": put("sliding", 0, np.nan), "no time": put("sliding", 1, -1.0)}


def test_the_unchanged_checkpoint_continues(checkpoint):
    assert len(next(Run.resumed(SCENE, checkpoint).chunks())[0]["time"])


@pytest.mark.parametrize("change", [pytest.param(c, id=name) for name, c in OTHER_VERSION.items()])
def test_other_shapes_and_kinds_are_those_of_another_version(checkpoint, change):
    change(checkpoint)
    with pytest.raises(SolverError, match="only that version can continue it"):
        Run.resumed(SCENE, checkpoint)


@pytest.mark.parametrize("change", [pytest.param(c, id=name) for name, c in IMPOSSIBLE.items()])
def test_numbers_that_no_run_has_are_refused(checkpoint, change):
    change(checkpoint)
    with pytest.raises(SolverError, match="not a possible state of a run of this scene"):
        Run.resumed(SCENE, checkpoint)


def test_the_checkpoint_of_another_scene_is_refused(checkpoint):
    other = SCENE.with_values({"output.rate": SCENE.output.rate / 2.0})
    with pytest.raises(SolverError, match="not a possible state of a run of this scene"):
        Run.resumed(other, checkpoint)


def test_a_checkpoint_stays_what_it_is_while_its_run_goes_on(checkpoint):
    before = {name: values.copy() for name, values in checkpoint.items()}
    next(Run.resumed(SCENE, checkpoint).chunks())
    assert all(np.array_equal(values, checkpoint[name]) for name, values in before.items())
