"""Velocities in the output: against the sliding that a run stores, the derivative of its displacements, and a closed form."""

import numpy as np
import pytest

import rsc
from rsc.kernel.tableau import METHODS
from rsc.scene.scene import Scene
from rsc.study.run.start import run_of
from scenes import LAVAL, SCENES, changed
from sliding import error_of_sliding

ALWAYS = ("time", "speed", "rotor", "stator", "normal_force", "friction_force", "tangential_velocity")
MOTIONS = ("rotor_velocity", "stator_velocity")


def asking(scene_dict, method="rk45", **values):
    """A scene that asks for velocities."""
    return Scene.from_dict(scene_dict).with_values({"solver.method": method, "output.velocities": True, **values})


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SCENES)
def test_velocities_slide_as_the_run_says(name, method):
    """Exact but for rounding: both come from one state of the motion between the steps."""
    result = rsc.simulate(asking(SCENES[name], method))
    assert result.rotor_velocity.shape == result.rotor.shape and result.stator_velocity.shape == result.stator.shape
    assert error_of_sliding(result) < 1e-12


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SCENES)
def test_velocities_are_the_derivative_of_the_displacements(name, method):
    """Differences over five samples, 40 us, between which no contact begins or ends: what they miss is (omega h)^4/30, 1e-10 at
    the contact's 400 Hz, and where its damper acts or friction reverses a kink of the acceleration."""
    result = rsc.simulate(asking(SCENES[name], method, **{"solver.rtol": 1e-10, "output.rate": 1e5}))
    touching = result.normal_force > 0.0
    same = np.ones(len(touching) - 4, dtype=bool)
    for shift in range(4):
        same &= touching[4 - shift : len(touching) - shift] == touching[: len(touching) - 4]
    for motion, velocity in ((result.rotor, result.rotor_velocity), (result.stator, result.stator_velocity)):
        if not motion.shape[1]:
            continue
        rate = (motion[:-4] - 8.0 * motion[1:-3] + 8.0 * motion[3:-1] - motion[4:]) * result.scene.output.rate / 12.0
        error = abs(rate - velocity[2:-2])[same]
        largest = abs(velocity).max()
        assert np.median(error) < 5e-9 * largest and error.max() < 5e-6 * largest


@pytest.mark.parametrize("method", METHODS)
def test_velocities_of_a_free_vibration(method):
    """r = r_0 exp(i omega t) needs no damping and no unbalance; a step errs by rtol of a gap, over some 50 radians."""
    omega, radius = 2.0 * np.pi * 30.0, 4e-4
    free = changed(
        rotor={"damping_ratio": 0.0, "eccentricity": 0.0}, drive={"speed": 20.0, "duration": 0.25},
        start={"rotor": [[radius, 0.0]], "rotor_velocity": [[0.0, omega * radius]]},
    )  # fmt: skip
    result = rsc.simulate(asking(free, method, **{"solver.rtol": 1e-9}))
    exact = 1j * omega * radius * np.exp(1j * omega * result.time)
    assert abs(result.rotor_velocity[:, 0] - exact).max() < 1e-6 * omega * 1e-3
    assert not result.stator_velocity.any()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["whirl, unbalance, run-up", "gyroscopic disk", "chains", "rigid wall"])
def test_asking_for_velocities_changes_no_bit_of_the_others(name, method):
    scene = asking(SCENES[name], method)
    result, plain = rsc.simulate(scene), rsc.simulate(scene.with_values({"output.velocities": False}))
    for array in ALWAYS:
        assert getattr(result, array).tobytes() == getattr(plain, array).tobytes(), array
    assert repr(result.summary) == repr(plain.summary)
    with pytest.raises(rsc.SceneError, match=r"output\.velocities = False: must be true"):
        _ = plain.rotor_velocity


@pytest.mark.parametrize("method", METHODS)
def test_cases_of_an_ensemble_have_the_velocities_they_have_alone(method):
    """Some ask for velocities, some do not, prepared together."""
    base = Scene.from_dict(LAVAL).with_values({"solver.method": method})
    cases = [{"contact.gap": 1e-3 + 1e-5 * i, "output.rate": 2000 + 10 * i, "output.velocities": i % 3 > 0} for i in range(12)]
    scenes = [base.with_values(values) for values in cases]
    for scene, result in zip(scenes, rsc.simulate_many(scenes, threads=1), strict=True):
        alone = rsc.simulate(scene)
        for array in ALWAYS + (MOTIONS if scene.output.velocities else ()):
            assert getattr(result, array).tobytes() == getattr(alone, array).tobytes(), array


def test_chunks_and_their_buffer_hold_velocities(monkeypatch):
    """A run in chunks of few steps and rows has the same velocities."""
    scene = asking(SCENES["chains"])
    whole = rsc.simulate(scene)
    monkeypatch.setattr("rsc.simulation.run.CHUNK_STEPS", 300)
    monkeypatch.setattr("rsc.simulation.run.BUFFER_ROWS", 7)
    run, pieces = run_of(scene), []
    for block, _ in run.chunks():
        pieces.append(block["rotor_velocity"])
    assert len(pieces) > 50 and np.concatenate(pieces).tobytes() == whole.rotor_velocity.tobytes()
