"""Skew and anisotropic stiffness and damping: the slow twin, closed forms, what the ledger books where, exactness."""

import sys

import numpy as np
import pytest
from scipy.linalg import expm

import systems
from directions import assembled, directed, of_bearing
from naive import integrate
from rsc.kernel.tableau import METHODS
from rsc.scene.scene import Scene
from rsc.simulation.run import Run
from rsc.simulation.stiffness import fastest, stable_steps
from rsc.study.run.ensemble import simulate_many
from rsc.study.run.simulate import simulate
from rsc.study.run.start import initial_state, run_of
from scenes import SCENES, changed
from tiers import alternating, nightly

run_module = sys.modules["rsc.simulation.run"]
BUMP = np.sin(np.pi * np.arange(1, 7) / 7)
SIX = changed(
    rotor={"model": "chain", "masses": [1.0] * 6, "stiffnesses": [1.8e5] * 7, "damping_ratio": 0.02,
           "eccentricity": (3e-4 * BUMP).tolist()},
    stator={"model": "chain", "masses": [0.5, 0.4], "stiffnesses": [6e5, 4e5, 0.0], "dampings": [30.0, 10.0, 0.0]},
    contact={"rotor_coordinate": 2, "stator_coordinate": 1},
    drive={"duration": 0.2}, start={"rotor": [[0.0, 0.0]] * 6, "rotor_velocity": [[0.4 * b, -0.1 * b] for b in BUMP]},
)  # fmt: skip
CONTACTS = {
    "1 + 0": SCENES["rigid wall"],
    "1 + 1": SCENES["bouncing"],
    "2 + 1, gyroscopic": SCENES["gyroscopic disk"],
    "3 + 2": changed(SCENES["chains"], drive={"duration": 0.15}),  # each contact makes errors larger
    "6 + 2": SIX,
}
SLOW = ("1 + 0", "2 + 1, gyroscopic", "6 + 2")  # a kernel for each
# a Laval rotor of 1 kg, 40 Hz if alike in all directions, that nothing touches
STIFFNESS, DAMPING, SPEED = [[5e4, 1.2e4], [-0.3e4, 8e4]], [[12.0, 3.0], [5.0, 25.0]], 37.0
FREE = changed(
    stator={"model": "rigid"},
    rotor={"mass": 1.0, "frequency": 40.0, "damping_ratio": 0.0, "eccentricity": 5e-5},
    contact={"gap": 0.02},
    drive={"speed": SPEED, "duration": 0.3},
    start={"rotor": [[1e-3, 0.4e-3]], "rotor_velocity": [[0.05, -0.3]]},
)
QUIET = changed(FREE, rotor={"eccentricity": 0.0})


def scene_of(tables, rtol=1e-9, method="rk45"):
    return Scene.from_dict({**tables, "solver": {"rtol": rtol, "method": method}})


@pytest.mark.parametrize(("name", "method"), alternating(CONTACTS, METHODS, SLOW))
def test_motion_in_contact_equals_the_slow_twin(name, method, monkeypatch):
    """All eight matrices, full; the twin's own error is near 1e-7 gaps."""
    system_of, scene = assembled(monkeypatch, directed), scene_of(CONTACTS[name], method=method)
    result = simulate(scene)
    rotor, stator = integrate(system_of(scene), initial_state(scene, system_of(scene)), result.time, rtol=1e-9)
    assert result.contact_onsets > 1
    assert abs(result.rotor - rotor).max() < 1e-5 * scene.contact.gap
    assert abs(result.stator - stator).max(initial=0.0) < 1e-5 * scene.contact.gap
    assert abs(result.ledger.residual) < 30 * 1e-9 * result.ledger.turnover


@pytest.mark.parametrize("method", METHODS)
def test_free_motion_of_an_anisotropic_rotor_is_that_of_its_two_by_two_matrices(method, monkeypatch):
    """Two natural frequencies, tilted axes and the elliptic orbit of the unbalance, by a matrix exponential in y and z."""
    assembled(monkeypatch, lambda system: of_bearing(system, STIFFNESS, DAMPING))
    result = simulate(scene_of(FREE, method=method))
    omega, rate = 2.0 * np.pi * SPEED, np.zeros((6, 6))  # of y, z, y', z', cos(omega t), sin(omega t)
    rate[:2, 2:4], rate[2:4, :2], rate[2:4, 2:4] = np.eye(2), -np.array(STIFFNESS), -np.array(DAMPING)
    rate[2:4, 4:], rate[4:, 4:] = 5e-5 * omega**2 * np.eye(2), [[0.0, -omega], [omega, 0.0]]
    exact = np.array([expm(rate * t) @ [1e-3, 0.4e-3, 0.05, -0.3, 1.0, 0.0] for t in result.time])
    assert abs(exact[-200:, 0]).max() > 1.2 * abs(exact[-200:, 1]).max()
    assert abs(result.rotor[:, 0] - exact[:, 0] - 1j * exact[:, 1]).max() < 50 * 1e-9 * 0.02


@pytest.mark.parametrize(("method", "order"), [("rk45", 5.0), ("taylor8", 8.0)])
def test_error_falls_with_the_order_of_the_method(method, order, monkeypatch):
    assembled(monkeypatch, lambda system: of_bearing(system, STIFFNESS, DAMPING))
    exact, rows = simulate(scene_of(FREE, 1e-13, "taylor8")), []
    for rtol in (1e-7, 1e-8, 1e-9, 1e-10):
        result = simulate(scene_of(FREE, rtol, method))
        rows.append((np.log(result.steps), np.log(abs(result.rotor - exact.rotor).max())))
    assert -np.polyfit(*np.transpose(rows), 1)[0] == pytest.approx(order, abs=0.4)


@pytest.mark.parametrize("method", METHODS)
def test_skew_stiffness_drives_forward_whirl_and_is_booked_as_energy_put_in(method, monkeypatch):
    """From a start on the growing root of m L^2 + c L + k + i S = 0 the motion is r_0 e^{L t}, and so are all energies."""
    mass, damping, stiffness, skew = 1.0, 10.0, 4e4, -4000.0
    assembled(monkeypatch, lambda system: of_bearing(system, [[stiffness, -skew], [skew, stiffness]], damping * np.eye(2)))
    root = max(np.roots([mass, damping, stiffness + 1j * skew]), key=np.real)
    assert root.real > 4.0 and root.imag > 0.0  # forward
    start, velocity = 1e-3, 1e-3 * root
    tables = changed(QUIET, start={"rotor": [[start, 0.0]], "rotor_velocity": [[velocity.real, velocity.imag]]})
    result = simulate(scene_of(tables, method=method))
    assert abs(result.rotor[:, 0] - start * np.exp(root * result.time)).max() < 50 * 1e-9 * 0.02
    squares = start**2 * np.expm1(2.0 * root.real * 0.3) / (2.0 * root.real)  # integral of |r|^2
    ledger = result.ledger
    assert ledger.energy_in == pytest.approx(-skew * root.imag * squares, rel=1e-6)
    assert ledger.rotor_damping == pytest.approx(damping * abs(root) ** 2 * squares, rel=1e-6)
    assert abs(ledger.residual) < 20 * 1e-9 * ledger.turnover


@pytest.mark.parametrize(
    ("body", "n", "method"), [("r", 3, "rk45"), nightly("s", 2, "rk45"), nightly("r", 3, "taylor8"), nightly("s", 2, "taylor8")]
)
def test_each_matrix_is_booked_where_it_belongs(body, n, method, monkeypatch):
    """Anisotropic springs store, skew damping takes nothing, anisotropic damping takes from its body alone."""
    tables = changed(
        SCENES["chains"], rotor={"eccentricity": [0.0] * 3, "damping_ratio": 0.0}, stator={"dampings": [0.0] * 3},
        contact={"gap": 0.02, "damping_ratio": None, "damping": 0.0},
        start={"rotor": [[1e-3, 0.0], [9e-4, 0.0], [0.0, 1e-4]], "rotor_velocity": [[0.0, -0.4], [0.3, -0.3], [0.0, 0.0]],
               "stator": [[0.0, 1e-4], [2e-4, 0.0]], "stator_velocity": [[0.1, 0.0], [0.2, 0.1]]},
    )  # fmt: skip
    full = np.array([[2.0, 1.0, 0.0], [1.0, 3.0, 0.5], [0.0, 0.5, 1.0]])[:n, :n]

    def ledger(**matrices):
        assembled(monkeypatch, lambda system: systems.changed(system, **{f"{name}_{body}": m for name, m in matrices.items()}))
        found = simulate(scene_of(tables, 1e-11, method)).ledger
        assert abs(found.residual) < 1e-7 * stored
        return found

    stored = 0.1  # J, about what the start holds
    still = ledger(anisotropic_stiffness=(500.0 + 800.0j) * full, skew_damping=full)
    assert max(abs(part) for part in vars(still).values()) < 1e-7 * stored
    damped = ledger(anisotropic_damping=(1.0 + 2.0j) * full)
    own, other = (damped.rotor_damping, damped.stator_damping) if body == "r" else (damped.stator_damping, damped.rotor_damping)
    assert abs(own) > 1e-3 * stored and other == 0.0 and abs(damped.energy_in) < 1e-7 * stored


@pytest.mark.parametrize("method", METHODS)
def test_runs_are_exact(method, monkeypatch):
    """A resumed run has the bits of an undisturbed one; the output rate changes none."""
    assembled(monkeypatch, directed)
    scene = scene_of(SCENES["bouncing"], 1e-6, method)
    whole, sparse = simulate(scene), simulate(scene.with_values({"output.rate": 500.0}))
    assert np.array_equal(sparse.rotor, whole.rotor[:: round(scene.output.rate / 500)])
    monkeypatch.setattr(run_module, "CHUNK_STEPS", 50)
    run = run_of(scene)
    for _ in range(3):
        next(run.chunks())
    run = Run.resumed(scene, run.checkpoint())
    *_, (_, status) = run.chunks()
    assert run.summary(status) == whole.summary


def test_stable_steps_are_those_of_the_matrices(monkeypatch):
    """Stiff in one of two tilted directions only; and skew terms with gyroscopics, whose complex matrices say the same."""
    stiff, turn = 1e10, np.exp(1j * np.deg2rad(30.0))
    axes = np.array([[turn.real, -turn.imag], [turn.imag, turn.real]])
    assembled(monkeypatch, lambda system: of_bearing(system, axes @ np.diag([stiff, 4e4]) @ axes.T, 10.0 * np.eye(2)))
    model = run_of(scene_of(QUIET)).packed.model
    steps, eigenvalues = fastest([model], METHODS["rk45"])
    assert abs(eigenvalues[0, 0]) == pytest.approx(np.sqrt(stiff))

    def skewed(system):
        return systems.changed(system, skew_stiffness_r=5e3 * np.eye(2), skew_damping_r=np.array([[3.0, 0.1], [0.1, 0.02]]))

    system = assembled(monkeypatch, skewed)(scene := scene_of(changed(SCENES["gyroscopic disk"], stator={"model": "rigid"})))
    model = run_of(scene).packed.model
    steps, eigenvalues = fastest([model], METHODS["rk45"])
    mass, omega = np.linalg.inv(system.rotor.mass), system.schedule_speed.max()
    below = system.rotor.stiffness + 1j * system.rotor.skew_stiffness
    beside = system.rotor.damping - 1j * omega * system.rotor.gyroscopic + 1j * system.rotor.skew_damping
    rates = np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-mass @ below, -mass @ beside]]))
    assert abs(np.append(rates, rates.conj()) - eigenvalues[0, 0]).min() < 1e-9 * abs(eigenvalues[0, 0])
    assert steps[0, 0] == pytest.approx(stable_steps(rates, METHODS["rk45"]).min())


@pytest.mark.parametrize("first", [0, 1])
def test_such_scenes_and_others_go_together(first, monkeypatch):
    """With the bits they have alone, whatever the first scene is."""
    assembled(monkeypatch, lambda system: directed(system) if system.contact.gap > 1e-3 else system)
    tables = changed(SCENES["bouncing"], drive={"duration": 0.05})
    scenes = [scene_of(changed(tables, contact={"gap": 1e-3 * (1.0 + 1e-3 * ((i + first) % 2))}), 1e-6) for i in range(8)]
    for scene, result in zip(scenes, simulate_many(scenes, threads=1), strict=True):
        alone = simulate(scene)
        assert np.array_equal(result.rotor, alone.rotor) and result.summary == alone.summary


def test_a_run_that_skew_stiffness_drives_out_says_so(monkeypatch):
    assembled(monkeypatch, lambda system: of_bearing(system, [[4e4, 8e3], [-8e3, 4e4]], np.eye(2)))
    result = simulate(scene_of(changed(QUIET, contact={"gap": 1e-3, "friction": 0.0}, drive={"duration": 10.0}), 1e-6))
    assert result.status == "diverged" and "skew stiffness" in result.summary.advice
    assert result.ledger.energy_in > 0.5 * result.ledger.turnover - abs(result.ledger.residual)
