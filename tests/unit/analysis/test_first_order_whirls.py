"""First-order states in the analysis: numbers of two other programs, scans, differences, and what the simulation does."""

import numpy as np
import pytest

import rsc
from rsc.analysis.alone.at_rest import at_rest, states_at_rest
from rsc.analysis.alone.run_up import run_up_response
from rsc.analysis.balance.balance import balance
from rsc.analysis.balance.floquet import balance_growth
from rsc.analysis.follow.branches import branches
from rsc.analysis.follow.escape import pressed_frequencies
from rsc.analysis.paper.receptance import contact_receptance, receptance
from rsc.analysis.paper.roots import whirl_roots
from rsc.analysis.paper.small_motions import small_motion
from rsc.analysis.paper.stability import whirl_eigenvalues
from rsc.analysis.several.condition import pressed
from rsc.analysis.survey.remarks import scene_remarks
from rsc.errors import SolverError
from rsc.scene.scene import Scene
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from scenes import SCENES, changed
from two_seals import pump

TWO_PI = 2.0 * np.pi
CONTROLLER = {"negative_stiffness": 5e4, "proportional": 3e5, "integral": 1e6, "derivative": 200.0, "derivative_filter": 1e4,
              "amplifier": 500.0}  # fmt: skip
LEVITATED = {
    "rotor": {"model": "laval", "mass": 5.0, "stiffness": 0.0, "eccentricity": 2e-6, "magnetic_bearings": [[0, CONTROLLER]]},
    "stator": {"model": "laval", "mass": 1.5, "frequency": 180.0, "damping_ratio": 0.1},
    "contact": {"gap": 0.25e-3, "stiffness": 2e7, "friction": 0.15},
    "drive": {"speed": 20.0, "duration": 0.3}, "solver": {"rtol": 1e-8},
}  # fmt: skip
# Hz, N, 1/s of two other programs
WHIRLS = {
    0.15: [(-306.0437, 894.5, 227.65), (-65.760132, 238.0309, -0.722), (-50.1344, 70.4, 13.56)],
    0.25: [(-252.5478, 443.0, 456.36), (-76.36, 528.1, 28.51), (-42.4677, 27.2, 47.58)],
}
# a gyroscopic rotor whose sensor is not where its actuator is, and a stator on an elastomer
APART = {
    "matrix": [[-500.0, 0.0], [400.0, -900.0]], "displacement": [[2.0, 0.0], [0.0, 0.0]], "velocity": [[0.0, 0.001], [0.0, 0.0]],
    "force": [[-8e3, 0.0], [0.0, -40.0]],
}  # fmt: skip
DISK = changed(
    SCENES["gyroscopic disk"], rotor={"states": APART},
    stator={"model": "laval", "mass": 2.0, "frequency": 90.0, "damping_ratio": 0.02,
            "states": {"matrix": [[-300.0]], "velocity": [[1.0]], "force": [[-2e5]]}},
)  # fmt: skip
SYSTEMS = {"levitated": LEVITATED, "disk": DISK}


def scene_of(content, **tables):
    return Scene.from_dict(changed(content, **tables))


def system_of(name):
    return assemble(Scene.from_dict(SYSTEMS[name]))


@pytest.mark.parametrize("friction", WHIRLS)
def test_whirls_have_the_numbers_of_two_other_programs(friction):
    for whirl, (frequency, force, rate) in zip(
        rsc.predict(scene_of(LEVITATED, contact={"friction": friction})), WHIRLS[friction], strict=True
    ):
        assert whirl.frequency == pytest.approx(frequency, rel=1e-6)
        assert whirl.normal_force == pytest.approx(force, rel=1e-3)
        assert whirl.growth_rate == pytest.approx(rate, rel=1e-3)


def test_free_vibrations_have_the_numbers_of_another_program():
    controller = {**CONTROLLER, "negative_stiffness": 2e4, "proportional": 9e4, "integral": 9e5}
    rotor = {"mass": 1.0, "magnetic_bearings": [[0, controller]]}
    modes = rsc.modes(scene_of(LEVITATED, rotor=rotor)).rotor
    got = sorted((round(mode.frequency, 4), round(mode.growth_rate, 3)) for mode in modes)
    assert got == [(-40.9215, -85.297), (0.0, -10089.68), (0.0, -2868.005), (0.0, -13.315), (40.9215, -85.297)]


@pytest.mark.parametrize("name", SYSTEMS)
def test_roots_are_those_of_a_scan(name):
    """Every sign change of Im cH over a fine grid, with A from the feedback itself, not from states as coordinates."""
    system, Omega = system_of(name), 60.0 * TWO_PI
    Psi = -TWO_PI * np.geomspace(0.5, 5000.0, 20_000)
    value = ((1.0 + 1j * system.law.friction) * receptance(system, Psi, Omega)).imag
    changes = np.flatnonzero(value[:-1] * value[1:] < 0.0)
    roots = whirl_roots(system, Omega)
    inside = np.sort(roots[(roots < Psi[0]) & (roots > Psi[-1])])[::-1]
    assert len(changes) and len(changes) == len(inside)
    assert all(Psi[i + 1] <= root <= Psi[i] for i, root in zip(changes, inside, strict=True))


@pytest.mark.parametrize("name", SYSTEMS)
def test_derivatives_by_frequency_are_differences(name):
    """With the left vector, since A is not symmetric."""
    system, Omega, Psi, step = system_of(name), 300.0, np.array([-280.0, 170.0]), 0.01
    H, first, second = contact_receptance(system, Omega, Psi)
    turn = 1.0 + 1j * system.law.friction
    assert np.allclose(H, turn * receptance(system, Psi, Omega), rtol=1e-10)
    before, after = (contact_receptance(system, Omega, Psi + shift)[:2] for shift in (-step, step))
    assert first == pytest.approx((after[0] - before[0]) / (2.0 * step), rel=1e-5)
    assert second == pytest.approx((after[1] - before[1]) / (2.0 * step), rel=1e-5)
    own = pressed(system, Omega, (0,))
    assert own.receptances(Psi)[1][:, 0, 0] * turn == pytest.approx(first, rel=1e-10)


@pytest.mark.nightly  # half a minute with its kernel
def test_growth_is_that_of_a_disturbed_run():
    """The unstable whirl at -50.13 Hz of the levitated rotor: how fast a run that starts on it leaves it."""
    content = changed(LEVITATED, rotor={"eccentricity": 0.0}, drive={"duration": 0.6},
                      start={"whirl": -50.1344, "impulse": [1e-6, 0.0]},
                      solver={"rtol": 1e-11, "method": "taylor8"}, output={"rate": 4000.0})  # fmt: skip
    scene = Scene.from_dict(content)
    (whirl,) = [each for each in rsc.predict(scene) if abs(each.frequency + 50.1344) < 0.1]
    result = rsc.simulate(scene)
    turned = result.rotor[:, 0] * np.exp(-2j * np.pi * whirl.frequency * result.time)
    distance = np.abs(np.abs(turned) - whirl.rotor_amplitude) / whirl.rotor_amplitude
    size = np.array([distance[i : i + 400].max() for i in range(0, len(distance) - 400, 400)])
    growing = np.flatnonzero((size > 1e-6) & (size < 1e-3))
    assert len(growing) >= 3
    rate = np.polyfit(0.1 * growing, np.log(size[growing]), 1)[0]
    assert rate == pytest.approx(whirl.growth_rate, rel=0.05)


def test_a_start_on_a_whirl_stays_on_it():
    scene = scene_of(LEVITATED, rotor={"eccentricity": 0.0}, start={"whirl": "backward"})
    result = rsc.simulate(scene)
    phase = np.unwrap(np.angle(result.rotor[:, 0]))
    assert (phase[-1] - phase[0]) / TWO_PI / result.time[-1] == pytest.approx(-65.760132, abs=1e-5)
    assert result.normal_force == pytest.approx(np.full(result.n_time, 238.0309), abs=1e-3)
    backwards = rsc.simulate(scene.with_values({"drive.speed": -20.0}))
    assert np.angle(backwards.rotor[1, 0] / backwards.rotor[0, 0]) == pytest.approx(TWO_PI * 65.760132 / 2000.0, abs=1e-6)


def test_a_start_in_the_steady_motion_stays_in_it():
    """With weight, which the integral of the controller carries, and unbalance."""
    rotor = {"gravity": 9.81, "eccentricity": [15e-6, 30.0]}
    for start in ({"running": True}, {"rest": True}):
        scene = scene_of(LEVITATED, rotor=rotor, start=start, drive={"speed": 30.0 if "running" in start else 0.0})
        result = rsc.simulate(scene)
        turn = np.exp(2j * np.pi * scene.drive.speed[0] * result.time)
        assert abs(result.rotor[:, 0] - result.rotor[0, 0] * turn).max() < 1e-5 * scene.contact.gap
        assert abs(result.rotor_states[0, 1]) == pytest.approx(9.81 * 5.0 / 1e6, rel=0.2)


def test_a_rotor_whose_load_the_controller_cannot_carry_lies_on_the_stator():
    """Without an integral: F = (k + k_c) x at the contact."""
    controller = {**CONTROLLER, "integral": 0.0}
    system = assemble(scene_of(LEVITATED, rotor={"magnetic_bearings": [[0, controller]], "load": [[0.0, -100.0]]}))
    rotor, _ = at_rest(system)
    z = states_at_rest(system)
    assert abs(rotor[0]) > 0.25e-3
    assert z[1] == pytest.approx(3e5 * rotor[0])  # u in the steady state
    start = initial_state(scene_of(LEVITATED, rotor={"magnetic_bearings": [[0, controller]], "load": [[0.0, -100.0]]}), system)
    assert np.array_equal(start.states, z)


def test_small_motions_and_branches_follow_one_matrix():
    system = system_of("levitated")
    Omega = 20.0 * TWO_PI
    whirl = rsc.predict(Scene.from_dict(LEVITATED))[1]
    Psi, F_N = TWO_PI * whirl.frequency, whirl.normal_force
    values = whirl_eigenvalues(system, np.array([Psi]), np.array([F_N]), Omega)[0]
    assert len(values) == 4 * 2 + 2 * 3 - 1
    assert small_motion(system, Psi, F_N, Omega).eigenvalue.real == pytest.approx(values.real.max(), rel=1e-6)
    found = branches(system, np.linspace(20.0, 80.0, 5))
    assert any(abs(branch.at(50.0).frequency - whirl.frequency) < 1e-9 for branch in found if branch.at(50.0))


def test_motions_pressed_by_a_spring_are_zeros_of_their_determinant():
    system, Omega = system_of("disk"), 60.0 * TWO_PI
    Psi = pressed_frequencies(system, Omega, 0.2)
    assert len(Psi) == 2 * 3 + 3
    fine = Psi[np.abs(Psi.real) > 1.0]
    H = receptance(system, fine, Omega)
    assert abs(1.0 + (1.0 + 0.2j) * system.law.stiffness * H) == pytest.approx(np.zeros(len(fine)), abs=1e-6)


def test_run_up_response_is_that_of_the_run():
    content = changed(LEVITATED, rotor={"eccentricity": 15e-6}, start={"running": True}, contact={"gap": 1e-3},
                      drive={"speed": None, "duration": None, "schedule": [[0.0, 20.0], [0.5, 70.0]]})  # fmt: skip
    scene = Scene.from_dict(content)
    result = rsc.simulate(scene)
    expected = run_up_response(assemble(scene), result.time)
    turn = np.exp(2j * np.pi * (20.0 * result.time + 50.0 * result.time**2))
    assert abs(result.rotor[:, 0] - expected * turn).max() < 1e-3 * abs(expected).max()


def test_growth_with_the_unbalance_tends_to_that_without():
    scene = Scene.from_dict(LEVITATED)
    system, whirl = assemble(scene), rsc.predict(scene)[1]
    growth = balance_growth(system, balance(system, whirl.frequency, 20.0))
    assert growth.rate == pytest.approx(whirl.growth_rate, rel=0.02)


def test_an_unstable_controller_is_a_remark():
    system = assemble(scene_of(LEVITATED, rotor={"magnetic_bearings": [[0, {**CONTROLLER, "derivative": 0.0}]]}))
    (remark,) = [text for text in scene_remarks(system, []) if "unstable" in text]
    assert remark.startswith("the rotor is unstable without contact at a rotor speed of 20 Hz: it vibrates at")
    assert not any("unstable" in text or "no damping" in text for text in scene_remarks(system_of("levitated"), []))


def test_whirls_of_many_scenes_are_those_of_each():
    scenes = [scene_of(LEVITATED, contact={"friction": friction}) for friction in WHIRLS]
    many = rsc.predict_many(scenes, [20.0, 60.0])
    for i, friction in enumerate(WHIRLS):
        assert many.frequency[i, 1] == pytest.approx([row[0] for row in WHIRLS[friction]], rel=1e-6)
        assert many.growth_rate[i, 1] == pytest.approx([row[2] for row in WHIRLS[friction]], rel=1e-3)


def test_what_is_not_predicted_with_states_is_refused_in_one_line():
    sealed = pump().to_dict()
    sealed["rotor"]["magnetic_bearings"] = [[1, CONTROLLER]]
    sealed["rotor"]["supports"] = [[0, [2e4, 0.0, 0.0, 1e4]]]
    directed = changed(LEVITATED, rotor={"supports": [[0, [2e4, 0.0, 0.0, 1e4]]]})
    for content in (sealed, directed):
        with pytest.raises(SolverError, match="directions differ") as error:
            rsc.predict(Scene.from_dict(content), 50.0)
        assert "magnetic_bearings" in str(error.value) and "\n" not in str(error.value)
    with pytest.raises(SolverError, match="first-order states"):
        rsc.equations(Scene.from_dict(LEVITATED))
