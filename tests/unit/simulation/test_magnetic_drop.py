"""Magnetic bearings that fail during a run, against a program of its own; predictions, files, and what is refused."""

import numpy as np
import pytest

import rsc
from levitated import motion
from rsc.errors import SceneError
from rsc.scene.scene import Scene
from rsc.simulation.run import Run
from rsc.study.prediction.predictions import predictions
from rsc.study.run.start import run_of
from rsc.system.assemble import assemble
from scenes import changed
from tiers import nightly

KEYS = {"negative_stiffness": 5e4, "proportional": 3e5, "integral": 1e6, "derivative": 200.0, "derivative_filter": 4e3,
        "amplifier": 400.0}  # fmt: skip
OTHER = {**KEYS, "proportional": 2e5, "derivative": 300.0}
GAP = 0.2e-3
ROTOR = {"masses": [3.0, 2.0], "eccentricity": 10e-6, "stiffness": 4e6, "gravity": 9.81}
STATOR = {"mass": 1.5, "stiffness": 2e6, "damping": 400.0}
CONTACT = {"gap": GAP, "stiffness": 1e7, "friction": 0.15, "diameter": 0.06, "slip_velocity": 0.05}
SPEED, START = 40.0, [[2e-5, 0.0], [3e-5, -1e-5]]


def levitated(first=0.03, second=0.05, **tables):
    """Two masses in magnetic bearings: those at coordinates 0 and 1 fail, the one at 0 first; a third, also at 0, stays on."""
    bearings = [[1, {**KEYS, "off": second}], [0, {**OTHER, "off": first}], [0, {**OTHER, "proportional": 4e4, "integral": 1e5}]]
    content = {
        "rotor": {
            "model": "chain", "masses": ROTOR["masses"], "stiffnesses": [0.0, ROTOR["stiffness"], 0.0],
            "eccentricity": ROTOR["eccentricity"], "gravity": ROTOR["gravity"], "magnetic_bearings": bearings,
        },
        "stator": {"model": "laval", **STATOR},
        "contact": {**CONTACT, "rotor_coordinate": 1},
        "drive": {"speed": SPEED, "duration": 0.08}, "start": {"rotor": START}, "output": {"rate": 10000.0},
    }  # fmt: skip
    return changed(content, **tables)


@pytest.fixture(scope="module")
def scene():
    return Scene.from_dict(levitated(solver={"rtol": 1e-10}))


@pytest.mark.parametrize("method", ["taylor8", nightly("rk45")])
def test_the_drop_is_that_of_another_program_and_the_ledger_closes(scene, method):
    result = rsc.simulate(scene.with_values({"solver.method": method}))
    bearings = levitated()["rotor"]["magnetic_bearings"]
    own = motion({**ROTOR, "bearings": bearings}, STATOR, CONTACT, SPEED, result.time, START)
    assert abs(result.rotor - (own[..., 0] + 1j * own[..., 1])).max() < 1e-8 * GAP
    assert result.normal_force[result.time > 0.05].max() > 100.0
    assert abs(result.ledger.residual) < 1e-8 * result.ledger.turnover
    assert result.rotor_states.shape == (len(result.time), 9)  # the states of a bearing go on


def test_a_run_resumed_before_and_after_the_failures_has_the_same_bits(scene, monkeypatch):
    monkeypatch.setattr("rsc.simulation.run.CHUNK_STEPS", 60)
    run, kept = run_of(scene), []
    for _ in run.chunks():
        kept.append(run.checkpoint())
    times = [float(one["real"][0]) for one in kept]
    for low, high in ((0.0, 0.03), (0.03, 0.05), (0.05, 0.08)):
        chosen = next(one for one, time in zip(kept, times, strict=True) if low < time < high)
        again = Run.resumed(scene, {name: values.copy() for name, values in chosen.items()})
        for _ in again.chunks():
            pass
        assert np.array_equal(again.work.x, run.work.x) and np.array_equal(again.work.v, run.work.v)


def test_predictions_are_those_without_the_bearing_and_modes_those_with_it():
    scene = Scene.from_dict(levitated())
    content = levitated()
    content["rotor"]["magnetic_bearings"] = content["rotor"]["magnetic_bearings"][2:]
    without = Scene.from_dict(content)
    for bearing in (content := levitated())["rotor"]["magnetic_bearings"]:
        bearing[1].pop("off", None)
    held = Scene.from_dict(content)
    system, end = assemble(scene), assemble(without)
    assert system.n_states == end.n_states == 3 and system.at_start.n_states == assemble(held).n_states == 9
    np.testing.assert_array_equal(system.rotor.state_force, end.rotor.state_force)
    np.testing.assert_allclose(system.at_start.rotor.stiffness, assemble(held).rotor.stiffness)
    np.testing.assert_array_equal(system.at_time(0.04).rotor.state_force, assemble(held).rotor.state_force[:, [0, 1, 2, 6, 7, 8]])
    numbers = [[whirl.frequency for whirl in rsc.predict(one, SPEED)] for one in (scene, without)]
    assert numbers[0] == numbers[1] != []
    modes = [[mode.frequency for mode in rsc.modes(one, SPEED).rotor] for one in (scene, held)]
    assert modes[0] == modes[1]
    (at_speed,) = predictions(scene, [SPEED])
    assert any("switched off at 0.03 s, 0.05 s" in line for line in at_speed.remarks)


def test_the_scene_is_read_back_steady_and_mirrored():
    start = {"rotor_states": [[i * 1e-6, 0.0] for i in range(9)]}
    scene = Scene.from_dict(levitated(start={**levitated()["start"], **start}))
    assert Scene.from_toml(scene.to_toml()) == scene and scene.mirrored().mirrored() == scene
    steady = scene.steady(30.0)
    assert steady.rotor.switched_at == () and steady.start.rotor_states == (6e-6, 7e-6, 8e-6)
    later = scene.with_values({"rotor.magnetic_bearings[0].off": "60 ms"})
    assert later.rotor.switched_at == (0.03, 0.06)


def test_a_drop_in_the_mirror_image():
    scene = Scene.from_dict(levitated())  # the weight acts along -z in any image
    assert np.array_equal(rsc.simulate(scene.mirrored()).rotor, -rsc.simulate(scene).rotor.conj())


@pytest.mark.parametrize(
    ("off", "words"),
    [
        (0.1, "magnetic_bearings[1].off = 0.1: must be before the end of the run at 0.08 s"),
        (-0.1, "magnetic_bearings[1].off = -0.1: must be a number > 0"),
        ([0.01, 0.02], "magnetic_bearings[1].off = [0.01, 0.02]: must be a number in s"),
        ("20 m", "magnetic_bearings[1].off"),
    ],
)
def test_times_that_cannot_be_are_refused_in_one_line(off, words):
    with pytest.raises(SceneError) as error:
        Scene.from_dict(levitated(first=off))
    assert words in str(error.value) and "\n" not in str(error.value)


def test_a_stator_and_a_torque_do_not_lose_bearings():
    with pytest.raises(SceneError, match="only bearings of the rotor can be switched off"):
        Scene.from_dict(levitated(stator={"magnetic_bearings": [[0, {**KEYS, "off": 0.01}]]}))
    drive = {"speed": SPEED, "duration": 0.08, "inertia": 0.1, "torque": [[0.0, 1.0], [100.0, 1.0]]}
    with pytest.raises(SceneError, match=r"rotor\.magnetic_bearings = .*off = 0\.03.*: must be without off where a torque"):
        Scene.from_dict(levitated(drive=drive))
