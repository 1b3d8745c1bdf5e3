"""`predict`: what a user gets, in Hz, at one speed and at many."""

import dataclasses
import time

import numpy as np
import pytest

from rsc.analysis.paper.predict import Whirl, predict_system
from rsc.analysis.paper.roots import whirl_roots
from rsc.analysis.paper.stability import whirl_growth
from rsc.analysis.paper.synchronous import synchronous_response
from rsc.analysis.paper.whirls import normal_force, side_conditions
from rsc.analysis.several.predict import predict
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from systems import TWO_PI, changed, expected, jeffcott, reference, reference_scene

DESIGNED = {
    "frequency", "rotor_amplitude", "stator_amplitude", "normal_force", "rotor_shape", "stator_shape", "growth_rate",
    "stable", "admissible", "conditions", "synchronous", "speed", "growth_frequency",
}


def test_every_value_of_a_whirl():
    system, speed = reference("mdof_2x2"), 17.0
    Omega = TWO_PI * speed
    found = predict_system(system, speed)
    Psi = whirl_roots(system, Omega)
    F_N = normal_force(system, Psi, Omega)
    Psi, F_N = Psi[F_N > 0.0], F_N[F_N > 0.0]
    assert len(found) == len(Psi) == 5
    consistent, printed = synchronous_response(system, Psi, F_N, Omega)
    for i, whirl in enumerate(found):
        growth = whirl_growth(system, Psi[i], F_N[i], Omega)
        assert whirl.speed == speed
        assert whirl.frequency == pytest.approx(Psi[i] / TWO_PI, rel=1e-12)
        assert whirl.normal_force == pytest.approx(F_N[i], rel=1e-9)
        assert whirl.rotor_amplitude == pytest.approx(abs(whirl.rotor_shape[0]))
        assert whirl.stator_amplitude == pytest.approx(abs(whirl.stator_shape[0]))
        distance = whirl.rotor_shape[0] - whirl.stator_shape[0]
        assert distance == pytest.approx(system.contact.gap + F_N[i] / system.law.stiffness, rel=1e-9)
        assert whirl.growth_rate == pytest.approx(growth.rate, rel=1e-9, abs=1e-9)
        assert whirl.growth_frequency == pytest.approx(growth.frequency / TWO_PI, rel=1e-9, abs=1e-9)
        assert whirl.stable == (growth.rate < 0.0)
        part = whirl.synchronous
        assert part.mirror_frequency == pytest.approx(2.0 * whirl.frequency - speed)
        assert part.consistent.force == pytest.approx(abs(consistent.force[i]))
        assert part.consistent.mirror_force == pytest.approx(abs(consistent.mirror_force[i]))
        assert part.consistent.mirror_amplitude == pytest.approx(consistent.mirror_line[i])
        assert part.printed.amplitude == pytest.approx(printed.line[i])
        assert part.printed.envelope == pytest.approx((printed.low[i], printed.high[i]))
        assert part.consistent.envelope[0] < whirl.rotor_amplitude < part.consistent.envelope[1]
        conditions = side_conditions(system, Psi[i], F_N[i], Omega, consistent.force[i])
        assert set(whirl.conditions) == set(conditions)
        for name, condition in conditions.items():
            assert whirl.conditions[name] == pytest.approx(float(condition.margin), rel=1e-6)
            assert (name in whirl.violated) != condition.holds
        assert whirl.admissible == (not whirl.violated)


def test_verdicts_of_the_2x2_scene_at_the_papers_frequencies():
    # paper, Figure 5: Psi_1 = -9.47 Hz unstable, Psi_2 = -12.9 Hz the most critical, Psi_3 with smaller amplitude
    found = predict_system(reference("mdof_2x2"), 10.0)
    usable = {round(whirl.frequency, 1): whirl.rotor_amplitude for whirl in found if whirl.stable and whirl.admissible}
    assert sorted(usable) == [-38.0, -12.9]
    assert usable[-12.9] > usable[-38.0]
    assert not min(found, key=lambda whirl: abs(whirl.frequency + 9.47)).stable


def test_whirl_has_the_designed_attributes_and_is_frozen():
    assert {field.name for field in dataclasses.fields(Whirl)} >= DESIGNED
    whirl = predict_system(reference("laval"), 50.0)[0]
    with pytest.raises(dataclasses.FrozenInstanceError):
        whirl.stable = True


def test_laval_reference():
    ((frequency, amplitude),) = expected("laval")["whirl"]["table"]
    system = reference("laval")
    (whirl,) = [whirl for whirl in predict_system(system, 50.0) if whirl.stable and whirl.admissible]
    assert whirl.frequency == pytest.approx(frequency, abs=1e-4)
    assert whirl.rotor_amplitude / system.contact.gap == pytest.approx(amplitude, abs=1e-4)


def test_speeds_of_predict():
    scene = reference_scene("gyroscopic_transition")
    first = predict(scene)
    assert [whirl.speed for whirl in first] == [scene.drive.speed[0]] * len(first)
    assert [whirl.frequency for whirl in predict(scene, 20)] == [whirl.frequency for whirl in first]
    many = predict(scene, np.array([20.0, 60.0]))
    assert [whirl.frequency for whirl in many[0]] == [whirl.frequency for whirl in first]
    assert {whirl.speed for whirl in many[1]} == {60.0}
    assert predict(scene, []) == []
    for whirls in many:
        frequencies = [whirl.frequency for whirl in whirls]
        assert frequencies == sorted(frequencies) and len(frequencies) > 0
        assert all(whirl.normal_force > 0.0 for whirl in whirls)


def test_no_friction_no_whirl():
    assert predict(reference_scene("laval").with_values({"contact.friction": 0.0}), 50.0) == []


def test_rigid_stator():
    system = changed(jeffcott(), contact_stiffness=1e7)
    (whirl,) = predict_system(system, 50.0)
    assert whirl.stator_amplitude == 0.0 and whirl.stator_shape.shape == (0,)
    assert whirl.rotor_amplitude == pytest.approx(system.contact.gap + whirl.normal_force / 1e7)


def test_rolling_is_not_admissible():
    plain = reference("laval")
    whirl = next(whirl for whirl in predict_system(plain, 50.0) if whirl.admissible)
    for diameter, holds in ((2e-3, False), (0.1, True)):
        system = changed(plain, diameter=diameter, slip_velocity=1e-4)
        other = min(predict_system(system, 50.0), key=lambda item: abs(item.frequency - whirl.frequency))
        assert other.frequency == whirl.frequency and other.admissible == holds
        assert ("sliding" in other.violated) != holds


def test_a_prediction_takes_few_milliseconds():
    system, best = reference("mdof_2x2"), np.inf
    for _ in range(30):
        begin = time.process_time()
        predict_system(system, 40.0)
        best = min(best, time.process_time() - begin)
    assert best < 0.01  # 1.6 ms measured; stability maps ask for 10^4 to 10^5 of them


def test_a_start_on_the_backward_whirl_takes_the_largest_stable_one():
    """At 100 Hz an unstable whirl (-48 Hz) is larger than the stable one (-17 Hz)."""
    scene = reference_scene("gyroscopic_disk_very_light").with_values({"drive.speed": 100.0, "start.whirl": "backward"})
    backward = [whirl for whirl in predict(scene) if whirl.frequency < 0.0]
    largest = max(backward, key=lambda whirl: whirl.rotor_amplitude)
    wanted = max((whirl for whirl in backward if whirl.stable), key=lambda whirl: whirl.rotor_amplitude)
    assert not largest.stable
    start = initial_state(scene, assemble(scene))
    assert np.array_equal(start.rotor, wanted.rotor_shape)
    assert np.allclose(start.rotor_velocity, 2j * np.pi * wanted.frequency * wanted.rotor_shape, rtol=1e-14)
