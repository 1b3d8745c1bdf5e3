"""Flight between contacts: exact by matrix exponentials and the slow twin, as good as steps, same bits however it is cut."""

from dataclasses import astuple

import numpy as np
import pytest
import scipy.linalg

import rsc
from flying import FLYING, KINDS, grounded, matrices
from naive import integrate
from rsc.kernel import model as kernel
from rsc.scene.scene import Scene
from rsc.simulation.flight import with_flight
from rsc.simulation.run import Run
from rsc.study.run.start import initial_state, run_of
from rsc.system.assemble import assemble
from scenes import SCENES, changed
from tiers import nightly

SLOW = ("no coupling", "springs by component")  # two kernels for each
RATES = {"500 Hz": 500.0, "2000 Hz": 2000.0, "20 kHz": 20000.0}


def scene_of(scene=FLYING, **values):
    return Scene.from_dict(scene).with_values({name.replace("__", "."): value for name, value in values.items()})


def same(a, b):
    """Whether two runs have the same bits: samples, counts, ledger and facts."""
    for name in ("time", "rotor", "stator", "normal_force", "tangential_velocity"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    for name in ("steps", "rejected", "rhs_calls", "contact_releases", "contact_onsets"):
        assert getattr(a, name) == getattr(b, name), name
    assert a.summary == b.summary
    # of a Taylor series the accelerations at a step's end are not those that a call begins with
    facts = {"rtol": 0.0, "atol": 0.0} if a.scene.solver.method == "rk45" else {"rtol": 1e-7, "atol": 1e-12}
    np.testing.assert_allclose(a.source.facts(), b.source.facts(), **facts)


def at_constant_speed(system, start, times):
    """Rotor (k, N) of a rotor alone at a constant speed: one matrix exponential of all components, of unbalance and load."""
    rotor, n, omega = system.rotor, system.n_rotor, system.schedule_speed[0]
    zero, mass = np.zeros((n, n)), np.linalg.inv(rotor.mass)
    skew, anisotropic = (
        np.zeros((n, n)) if part is None else part for part in (rotor.skew_stiffness, rotor.anisotropic_stiffness)
    )
    stiffness = np.block(
        [
            [rotor.stiffness + anisotropic.real, anisotropic.imag - skew],
            [anisotropic.imag + skew, rotor.stiffness - anisotropic.real],
        ]
    )
    gyroscopic = zero if rotor.gyroscopic is None else omega * rotor.gyroscopic
    damping = np.block([[rotor.damping, gyroscopic], [-gyroscopic, rotor.damping]])
    both = scipy.linalg.block_diag(mass, mass)
    matrix = np.zeros((4 * n + 3, 4 * n + 3))
    matrix[: 2 * n, 2 * n : 4 * n] = np.eye(2 * n)
    matrix[2 * n : 4 * n, : 2 * n], matrix[2 * n : 4 * n, 2 * n : 4 * n] = -both @ stiffness, -both @ damping
    forces = omega**2 * rotor.unbalance  # times cos + i sin
    matrix[2 * n : 4 * n, 4 * n] = both @ np.concatenate([forces.real, forces.imag])
    matrix[2 * n : 4 * n, 4 * n + 1] = both @ np.concatenate([-forces.imag, forces.real])
    matrix[2 * n : 4 * n, 4 * n + 2] = both @ np.concatenate([np.real(rotor.load), np.imag(rotor.load)])
    matrix[4 * n, 4 * n + 1], matrix[4 * n + 1, 4 * n] = -omega, omega
    step = scipy.linalg.expm(matrix * times[1])
    states = np.empty((len(times), len(matrix)))
    states[0] = np.concatenate(
        [start.rotor.real, start.rotor.imag, start.rotor_velocity.real, start.rotor_velocity.imag, [1.0, 0.0, 1.0]]
    )
    for k in range(1, len(times)):
        states[k] = step @ states[k - 1]
    return states[:, :n] + 1j * states[:, n : 2 * n]


@pytest.mark.parametrize("name", ["full matrices", nightly("no coupling"), nightly("springs by component")])
def test_motion_at_constant_speed_equals_a_matrix_exponential(name):
    """Of all coordinates at once in the scene's own, and with fewer steps than stability asks for."""
    scene = scene_of(KINDS[name], drive__speed=12.0, drive__duration=2.0, contact__gap=1e-3, solver__rtol=1e-8)
    result, stable = rsc.simulate(scene), run_of(scene).packed.model.stable_open
    assert result.contact_onsets == 0
    assert result.steps < 0.6 * scene.drive.duration / stable
    system = assemble(scene)
    wanted = at_constant_speed(system, initial_state(scene, system), result.time)
    assert abs(result.rotor - wanted).max() < 1e-7 * scene.contact.gap


@pytest.mark.parametrize("name", [nightly(name) if name in SLOW else name for name in KINDS])
def test_run_up_equals_the_slow_twin(name):
    scene = scene_of(KINDS[name], drive__duration=0.06, solver__rtol=1e-9, contact__gap=1e-3)
    assert run_of(scene).packed.model.flight
    system, result = assemble(scene), rsc.simulate(scene)
    rotor, stator = integrate(system, initial_state(scene, system), result.time, rtol=1e-9)
    assert abs(result.rotor - rotor).max() < 2e-7 * scene.contact.gap
    assert abs(result.stator - stator).max(initial=0.0) < 2e-7 * scene.contact.gap


@pytest.mark.parametrize("name", [nightly(name) if name in SLOW else name for name in KINDS])
def test_flight_is_as_good_as_steps(name):
    """Motion, contacts, ledger and facts of a run with contacts, against one by steps alone at a tighter tolerance."""
    scene = scene_of(KINDS[name], solver__rtol=1e-8)
    flown = rsc.simulate(scene)
    with grounded():
        stepped, exact = rsc.simulate(scene), rsc.simulate(scene.with_values({"solver.rtol": 1e-11}))
    assert flown.steps < 0.9 * stepped.steps and flown.contact_onsets == exact.contact_onsets > 0
    error, error_of_steps = (abs(run.rotor - exact.rotor).max() / scene.contact.gap for run in (flown, stepped))
    assert error < 2.0 * error_of_steps
    assert flown.summary.contact_time == pytest.approx(exact.summary.contact_time, rel=1e-5)
    turnover = exact.ledger.turnover
    for own, wanted in zip(astuple(flown.ledger), astuple(exact.ledger), strict=True):
        assert abs(own - wanted) < 1e-6 * turnover
    assert abs(flown.ledger.residual) < 2.0 * abs(stepped.ledger.residual) + 1e-9 * turnover


@pytest.mark.parametrize("rate", RATES.values(), ids=RATES)
def test_rate_of_output_changes_little(rate):
    """Samples divide into units, or units into blocks; the samples of 500 Hz are among all."""
    scene, slow = (scene_of(output__rate=each, solver__rtol=1e-9) for each in (rate, 500.0))
    assert run_of(scene).packed.model.flight
    result = rsc.simulate(scene)
    with grounded():
        wanted = rsc.simulate(slow.with_values({"solver.rtol": 1e-11}))
    assert len(result.time) == round(scene.drive.duration * rate) + 1
    assert abs(result.rotor[:: round(rate / 500.0)] - wanted.rotor).max() < 1e-7 * scene.contact.gap


@pytest.mark.parametrize("steps", [12, 130, 4000])
@pytest.mark.parametrize(("name", "method"), [("full matrices", "taylor8"), ("ring, stator, load", "rk45")])
def test_calls_of_any_length_give_the_same_bits(name, method, steps, monkeypatch):
    scene = scene_of(KINDS[name], solver__method=method)
    whole = rsc.simulate(scene)
    monkeypatch.setattr("rsc.simulation.run.CHUNK_STEPS", steps)
    monkeypatch.setattr("rsc.simulation.run.BUFFER_ROWS", 11)
    same(whole, rsc.simulate(scene))


def test_a_run_goes_on_from_every_checkpoint(monkeypatch):
    """Each time by a Run of its own: what only a running call knows would be lost."""
    scene = scene_of()
    whole = rsc.simulate(scene)
    monkeypatch.setattr("rsc.simulation.run.CHUNK_STEPS", 90)
    run, rows, lengths = run_of(scene), [], set()
    while True:
        block, status = next(run.chunks())
        rows.append(block["rotor"])
        lengths.add(float(run.work.real[kernel.FLIGHT]))
        if status is not None:
            break
        run = Run.resumed(scene, run.checkpoint())
    np.testing.assert_array_equal(np.concatenate(rows), whole.rotor)
    assert astuple(run.summary(status).ledger) == astuple(whole.ledger)
    assert len(lengths) > 2  # calls ended in flights


def test_file_and_threads_give_the_same_bits(tmp_path):
    scenes = [scene_of(contact__gap=gap) for gap in (1.9e-4, 2e-4, 2.1e-4)]
    alone = [rsc.simulate(scene) for scene in scenes]
    for one, many in zip(alone, rsc.simulate_many(scenes, threads=2), strict=True):
        same(one, many)
    rsc.simulate(scenes[0], path=tmp_path / "run.h5")
    same(alone[0], rsc.load(tmp_path / "run.h5"))


def test_a_quarter_turn_changes_no_bit():
    start = FLYING["start"]["rotor"]
    turned = changed(
        FLYING, start={"rotor": [[-z, y] for y, z in start]}, rotor={"eccentricity": [[-0.0, 3e-5], [0.0, 1e-5], [0.0, 0.0]]}
    )
    turned["rotor"]["eccentricity"] = [[3e-5, 90.0], [1e-5, 90.0], [0.0, 0.0]]
    a, b = rsc.simulate(Scene.from_dict(FLYING)), rsc.simulate(Scene.from_dict(turned))
    assert a.steps == b.steps
    np.testing.assert_allclose(b.rotor, 1j * a.rotor, atol=1e-12 * abs(a.rotor).max())


def test_energy_of_an_undamped_rotor_stays():
    """60,000 cycles of its fastest mode, without a force."""
    rotor = {
        "damping": [[0.0] * 3] * 3,
        "gyroscopic": None,
        "eccentricity": [0.0, 0.0, 0.0],
        "stiffness": matrices()["stiffness"],
    }
    scene = scene_of(
        changed(FLYING, rotor=rotor, start={"rotor": [[5e-5, 0.0], [0.0, 2e-5], [0.0, 0.0]]}),
        drive__duration=20.0,
        drive__speed=10.0,
        solver__rtol=1e-12,
    )
    run = run_of(scene)
    assert run.packed.model.flight
    *_, (_, status) = run.chunks()
    ledger = run.summary(status).ledger
    assert abs(ledger.change) < 1e-9 * run.energy_start
    assert abs(ledger.rotor_damping) < 1e-9 * run.energy_start


@pytest.mark.parametrize("name", [name for name in SCENES])
def test_scenes_without_a_fast_mode_do_not_fly(name):
    packed = run_of(Scene.from_dict(SCENES[name])).packed
    assert packed.model.flight == () and packed.grounded == ""


BAD = {
    "rate": (changed(FLYING, output={"rate": 1e6}), "output.rate"),
    "coupling": (changed(FLYING, rotor=matrices(coupled=50000.0)), "couple"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_fly_is_told_in_a_remark(name):
    scene, why = BAD[name]
    packed = run_of(Scene.from_dict(changed(scene, drive={"duration": 0.01}))).packed
    assert packed.model.flight == () and why in packed.grounded


def test_the_remark_stands_in_the_summary():
    result = rsc.simulate(Scene.from_dict(changed(BAD["coupling"][0], drive={"duration": 0.02})))
    assert result.status == "finished" and "not in closed form" in result.summary.advice


def test_a_slow_rate_still_flies():
    flight = run_of(scene_of(output__rate=113.0)).packed.model.flight
    assert flight.per_sample > 4 and flight.unit_rate == 113.0 * flight.per_sample


def test_a_mode_that_grows_does_not_fly_far():
    """A growing motion limits no step, so the model is made to say that it does: its weights would be lost in what grows."""
    model = run_of(scene_of()).packed.model._replace(flight=())
    stiffness = model.stiffness.copy()
    stiffness[2:4] *= -9.0
    flying, why = with_flight(model._replace(stiffness=stiffness))
    assert flying.flight == () and "grows" in why


def test_a_contact_that_rings_between_two_units_is_not_missed():
    """A mode of 8 kHz, whose period is a quarter of a unit, brings the deflection to the gap while it rings down. Where it starts
    inwards it is at rest and far from the gap at every unit, and a cubic through two of them sees nothing of it."""
    fast = np.diag([(2.0 * np.pi * f) ** 2 for f in (25.0, 8000.0, 8100.0)])
    turned = np.array([[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    damping = np.diag([3.0, 10.0, 10.0])
    rotor = {name: (turned @ part @ turned.T).tolist() for name, part in (("stiffness", fast), ("damping", damping))}
    for share in (0.9, 0.99, 1.01, 1.1, -0.9, -0.99, -1.01, -1.1, -1.5):  # of the gap that is left, at which the mode rings
        start = turned @ np.array([1e-4, 0.0, 0.0]) / 0.8 + turned @ np.array([0.0, share * 1e-4, 0.0]) / 0.6
        still = changed(
            FLYING, rotor={**rotor, "gyroscopic": None, "eccentricity": [0.0] * 3}, drive={"speed": 0.5, "duration": 0.05},
            start={"rotor": [[value, 0.0] for value in start]},
        )  # fmt: skip
        scene = Scene.from_dict(still)
        assert run_of(scene).packed.model.flight
        flown = rsc.simulate(scene)
        with grounded():
            stepped = rsc.simulate(scene)
        assert flown.contact_onsets == stepped.contact_onsets and bool(stepped.contact_onsets) == (abs(share) > 1.0)
