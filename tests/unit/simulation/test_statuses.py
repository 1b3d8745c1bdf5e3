"""How a run can end, each provoked from a scene: the status, and in its advice time, speed, state, contact and what to change."""

import re
import signal
import sys
import threading

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.simulation.run import Run
from rsc.study.run.start import run_of
from rsc.study.run.verify import verify
from scenes import SCENES, changed

SHORT_LAVAL = rsc.Scene.from_dict(changed(drive={"duration": 0.01}))

BOUNCING = SCENES["bouncing"]
BACKWARD = {"rotor": [[0.6e-3, 0.2e-3]], "rotor_velocity": [[0.3, -0.3]]}
FAR = {"rotor": [[1e100, 0.0]], "allow_penetration": True}
STATE = r"at [\d.e-]+ s \([-\d.]+ Hz, rotor at [\d.e+-]+ m, (in contact|no contact)\)"
# status -> scene, exit code, what the advice names
ENDS = {
    "diverged": (changed(SCENES["rigid wall"], contact={"friction": 0.5}, drive={"duration": 1000.0}), "contact.diameter"),
    "stiff": (
        changed(
            start={"whirl": -60.0},
            contact={"damping_ratio": None, "damping": 1e5},
            drive={"duration": 1000.0},
            solver={"max_steps": 1_000_000},
        ),
        "b_C",
    ),
    "step collapsed": (changed(BOUNCING, stator={"damping_ratio": None, "damping": 1e25}), "solver.rtol"),
    "non-finite": (changed(BOUNCING, start=FAR, contact={"gap": 1e80}, solver={"divergence": 1e100}), "overflow"),
    "too many steps": (changed(BOUNCING, solver={"max_steps": 300}), "solver.max_steps"),
}


@pytest.mark.parametrize("status", ENDS)
def test_every_way_to_stop_says_where_and_what_to_do(status, tmp_path, capsys):
    content, part = ENDS[status]
    (tmp_path / "scene.toml").write_text(rsc.Scene.from_dict(content).to_toml())
    assert main(["run", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "run.h5")]) == 3
    printed = capsys.readouterr()
    assert f"run {status} at" in printed.out and re.search(STATE, printed.err)
    result = rsc.load(tmp_path / "run.h5")
    assert result.status == status and part in result.summary.advice
    assert np.isfinite(result.rotor).all() and result.rhs_calls < 200_000
    assert len(result.tangential_velocity) == len(result.time) and verify(tmp_path / "run.h5").same


def test_a_finished_run_needs_no_advice():
    result = rsc.simulate(rsc.Scene.from_dict(BOUNCING))
    assert result.status == "finished" and result.summary.advice == ""


def test_an_interrupted_run_says_so():
    scene = rsc.Scene.from_dict(changed(BOUNCING, drive={"duration": 1000.0}, contact={"friction": 0.0}))
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt, match="interrupted " + STATE) as caught:
        rsc.simulate(scene)
    timer.join()
    result = caught.value.result
    assert len(result.time) > 100 and result.status == "interrupted" and re.search("interrupted " + STATE, result.summary.advice)


@pytest.mark.parametrize("speed", [[0.01, -20.0], 0.0])
def test_sliding_lost_for_every_diameter_is_out_of_assumptions(speed, tmp_path, capsys):
    """The one-sided law pushes forward although the surface of the rotor, of whatever diameter, moves backward."""
    scene = rsc.Scene.from_dict(changed(BOUNCING, drive={"speed": speed}))
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    assert main(["run", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "run.h5")]) == 3
    result = rsc.load(tmp_path / "run.h5")
    assert result.status == "out of assumptions" and result.summary.end_time == scene.drive.duration
    lost = np.flatnonzero((result.normal_force > 0.0) & (result.tangential_velocity <= 0.0))[0]
    assert result.summary.sliding_lost == result.time[lost] > 0.0
    assert f"from {result.time[lost]:.6g} s on" in result.summary.advice and "give contact.diameter" in result.summary.advice
    diameter = {"diameter": 0.02, "slip_velocity": 0.05}
    known = rsc.simulate(rsc.Scene.from_dict(changed(BOUNCING, drive={"speed": speed}, contact=diameter)))
    assert known.status == "finished" and known.summary.least_diameter == 0.0


def test_the_least_diameter_is_the_one_that_keeps_a_run_sliding():
    """With a larger diameter Coulomb friction moves as the one-sided law, with a smaller one it does not."""
    scene = changed(BOUNCING, drive={"speed": 20.0}, output={"rate": 1e5})
    result = rsc.simulate(rsc.Scene.from_dict(scene))
    least = result.summary.least_diameter
    assert result.status == "finished" and 1e-5 < least < 0.1
    for factor, same in ((1.02, True), (0.9, False)):
        coulomb = changed(scene, contact={"diameter": factor * least, "slip_velocity": 1e-6})
        moved = abs(rsc.simulate(rsc.Scene.from_dict(coulomb)).rotor - result.rotor).max()
        assert (moved < 1e-7) == same


def test_the_watch_goes_on_over_chunks_and_checkpoints(monkeypatch):
    scene = rsc.Scene.from_dict(changed(BOUNCING, start=BACKWARD, drive={"speed": [20.0, -20.0], "duration": 0.6}))
    whole = rsc.simulate(scene).summary
    assert whole.status == "out of assumptions" and whole.least_diameter > 0.0
    monkeypatch.setattr(sys.modules[Run.__module__], "CHUNK_STEPS", 997)
    run = run_of(scene)
    for _ in run.chunks():
        if run.time > 0.4:
            break
    again = Run.resumed(scene, run.checkpoint())
    statuses = [status for _, status in again.chunks()]
    assert again.summary(statuses[-1]) == whole


@pytest.mark.parametrize("stiffness", [1e20, 1e60, 1e100])
def test_a_run_that_cannot_reach_its_end_is_refused_at_once(stiffness):
    tables = {"rotor": {"frequency": None, "stiffness": stiffness}, "start": {"rest": True}}
    scene = rsc.Scene.from_dict(changed(**tables))
    with pytest.raises(rsc.SceneError, match=r"solver.max_steps = 1000000000: must be at least .* far out of scale"):
        rsc.simulate(scene)
    kept = rsc.simulate_many([scene, SHORT_LAVAL], on_error="keep")
    assert [str(result.status) for result in kept] == ["impossible", "finished"]
    few = rsc.simulate(scene.with_values({"solver.max_steps": 100}))  # asked for, and over soon
    assert few.status == "too many steps" and few.steps == 100
