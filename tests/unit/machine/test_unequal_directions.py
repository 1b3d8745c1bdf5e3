"""Machines whose directions differ: the reduced rotor vibrates as the full one, which the mean of the directions does not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
from threadpoolctl import threadpool_limits

from machines import on_unequal_bearings, random_machine
from rsc.analysis.alone.free_vibration import free_vibrations
from rsc.errors import ReductionError
from rsc.machine.imports.ross import read_ross
from rsc.machine.imports.store import save_model
from rsc.machine.model.contact import Unbalance, body_of
from rsc.machine.reduction.body import checked
from rsc.machine.reduction.directions import BOTH_LINES, FrequencyPoint, Unequal, doubled_inputs, reduce_unequal, responses
from rsc.machine.reduction.reduction import reduce
from rsc.scene.scene import Scene
from rsc.study.prediction.reductions import reduction_remarks
from rsc.system.assemble import assemble
from systems import quantity

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists())
FOLDER = ROOT / "data" / "reference" / "machines"
TWO_PI = 2.0 * np.pi


@pytest.fixture(autouse=True)
def one_thread():
    """Threads of the linear algebra cost more than they give here."""
    with threadpool_limits(1):
        yield


def scene_of(folder, model, node, speed, band, tolerance):
    """A scene of a model; stator and contact do not matter here."""
    save_model(model, folder / "model.npz")
    return Scene.from_dict(
        {
            "rotor": {"model": "machine", "file": str(folder / "model.npz"), "contact": node, "unbalance": [[node, 1e-4]]},
            "reduction": {"tolerance": tolerance, "band": band},
            "stator": {"model": "rigid"},
            "contact": {"gap": 1e-4, "friction": 0.1, "stiffness": 1e7},
            "drive": {"speed": [0.0, speed], "duration": 1.0},
        }
    )


def full_eigenvalues(model, speed, low, high):
    """Eigenvalues of all coordinates with damped frequencies from low to high, Hz, of weak damping; by frequency."""
    mass, damping, stiffness = model.with_conjugate(speed)
    n = len(mass)
    lower = -scipy.linalg.solve(mass, np.hstack([stiffness, damping]))
    values = scipy.linalg.eigvals(np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower]))
    chosen = (values.imag > 2.0 * np.pi * low) & (values.imag < 2.0 * np.pi * high) & (values.real > -0.5 * values.imag)
    return values[chosen][np.argsort(values[chosen].imag)]


def reduced_eigenvalues(scene, speed, low, high):
    """The same of the reduced rotor, frequencies without their sense."""
    found = [v for v in free_vibrations(assemble(scene), speed) if low < abs(v.frequency) < high]
    values = np.array([v.growth_rate + 2j * np.pi * abs(v.frequency) for v in found])
    return values[np.argsort(values.imag)]


@pytest.mark.parametrize(
    ("skew", "backward", "forward"), [(True, 1.77, 0.73), (False, 1.21, 1.28)], ids=["as it is", "without cross-coupling"]
)
def test_decrements_of_the_compressor(tmp_path, skew, backward, forward):
    """Logarithmic decrements of the first bending mode of ROSS's compressor at 9,000 rpm, full and reduced."""
    model = read_ross(FOLDER / "ross_compressor.mat", 150.0)
    if not skew:  # k_xy and k_yx of all bearings and seals are zero
        symmetric = {name: getattr(model, name).real + 0j for name in ("anisotropic_stiffness", "anisotropic_damping")}
        model = replace(model, skew_stiffness=None, skew_damping=None, **symmetric)
    scene = scene_of(tmp_path, model, 27, 150.0, ["-500 Hz", "250 Hz"], 1e-3)
    assert scene.rotor.n_coordinates <= 12
    for values in (full_eigenvalues(model, 150.0, 100.0, 220.0), reduced_eigenvalues(scene, 150.0, 100.0, 220.0)):
        decrements = -2.0 * np.pi * values.real / values.imag
        assert decrements == pytest.approx([backward, forward], abs=0.01)  # the backward one has the lower frequency
    senses = [v.frequency > 0.0 for v in free_vibrations(assemble(scene), 150.0) if 100.0 < abs(v.frequency) < 220.0]
    assert senses == [False, True]


def test_a_bearing_stiff_in_one_direction_only(tmp_path):
    """ROSS's rub rotor: one of its bearings is 115 times as stiff in y as in x, and no mean of both moves like it."""
    model = read_ross(FOLDER / "ross_rub_rotor.mat", 20.0)
    scene = scene_of(tmp_path, model, 12, 20.0, ["-500 Hz", "250 Hz"], 1e-3)
    full = full_eigenvalues(model, 20.0, 20.0, 150.0)
    assert len(full) == 4 and scene.rotor.n_coordinates <= 10
    assert reduced_eigenvalues(scene, 20.0, 20.0, 150.0) == pytest.approx(full, rel=1e-4)


@pytest.fixture(scope="module")
def rub_rotor():
    """ROSS's rub rotor, the mean of its directions and what it lacks; band and speeds, rad/s."""
    model = read_ross(FOLDER / "ross_rub_rotor.mat", 20.0)
    body = checked(body_of(model, [12], [Unbalance(12, 1e-4)], gravity=9.81, observers=[30]))
    unequal = Unequal(model.anisotropic_stiffness, model.anisotropic_damping)
    return model, body, unequal, (-TWO_PI * 500.0, TWO_PI * 250.0), (0.0, TWO_PI * 20.0)


def test_both_lines_fulfil_the_equations_of_the_doubled_matrices(rub_rotor):
    model, body, unequal, *_ = rub_rotor
    Psi, Omega = TWO_PI * 35.0, TWO_PI * 20.0
    mass, damping, stiffness = model.with_conjugate(20.0)
    inputs = doubled_inputs(body)
    assert inputs.shape == (2 * model.n, 4)
    motions = responses(body, unequal, FrequencyPoint(Psi, Omega, [0, 1, 2, 3]))
    assert np.abs((stiffness - Psi**2 * mass + 1j * Psi * damping) @ motions - inputs).max() < 1e-9 * np.abs(inputs).max()
    sparse = replace(body, **{name: scipy.sparse.csc_array(matrix) for name, matrix in body.terms.items()})
    across = Unequal(*(scipy.sparse.csc_array(matrix) for matrix in (unequal.stiffness, unequal.damping)))
    assert np.allclose(responses(sparse, across, FrequencyPoint(Psi, Omega, [0, 1, 2, 3])), motions, rtol=1e-7, atol=0.0)


def contact_lines(model, reduced, Psi, Omega, mirror):
    """Displacements at the contact at Psi and -Psi under a force at one of both, of the full matrices and reduced ones."""
    mass, damping, stiffness = model.with_conjugate(Omega / TWO_PI)
    twice = np.kron(np.eye(2), reduced.full.contact)
    matrix = stiffness - Psi**2 * mass + 1j * Psi * damping
    basis = np.kron(np.eye(2), reduced.basis)
    small = np.linalg.solve(basis.T @ matrix @ basis, basis.T @ twice[mirror])
    return twice @ np.linalg.solve(matrix, twice[mirror]), twice @ (basis @ small)


def test_the_error_stated_holds_with_directions_as_they_are(rub_rotor):
    """At random places, with the matrices as they were read; the mean of the directions alone would be all wrong."""
    model, body, unequal, band, speeds = rub_rotor
    rng = np.random.default_rng(1)
    mean, reduced = reduce(body, band, speeds, 1e-3), reduce_unequal(body, unequal, band, speeds, 1e-3)
    (stated,) = (check.error for check in reduced.checks if check.response == BOTH_LINES)
    assert 0.0 < stated <= reduced.error <= 1e-3 and reduced.body.n_coordinates <= 12
    worst = {}
    for name, one in (("mean", mean), ("both", reduced)):
        errors = []
        for Psi, Omega in zip(rng.uniform(0.0, -band[0], 200), rng.uniform(*speeds, 200), strict=True):
            exact, small = contact_lines(model, one, Psi, Omega, int(rng.integers(0, 2)))
            errors.append(np.abs(exact - small).max() / np.abs(exact).max())
        worst[name] = max(errors)
    assert worst["both"] < stated and worst["mean"] > 0.1


@pytest.mark.parametrize("seed", range(4))
def test_random_rotors_are_within_what_is_stated(seed):
    rng = np.random.default_rng([3, seed])
    machine = random_machine(np.random.default_rng(seed), least=8, most=14)
    body, unequal = on_unequal_bearings(rng, machine.rotor)
    reduced = reduce_unequal(body, unequal, machine.band, machine.speeds, 1e-4)
    small = unequal.projected(reduced.basis)
    for Psi in rng.uniform(0.0, -machine.band[0], 100):
        place = FrequencyPoint(Psi, rng.uniform(*machine.speeds), [0, 1])
        exact, ours = responses(reduced.full, unequal, place), responses(reduced.body, small, place)
        true, found = (np.kron(np.eye(2), row) @ x for row, x in ((body.contact, exact), (reduced.body.contact, ours)))
        assert (np.abs(true - found).max(axis=0) < reduced.error * np.abs(true).max(axis=0)).all()


def _beside(copies, matrix):
    return scipy.sparse.csc_array(scipy.sparse.block_diag(copies * [scipy.sparse.coo_array(matrix)]))


def test_large_bodies_are_solved_at_fewer_places(rub_rotor):
    """Sparse matrices of more coordinates than `FEW`: many rotors beside each other, of which one touches."""
    _, body, unequal, band, speeds = rub_rotor
    copies = 5
    big = {name: _beside(copies, matrix) for name, matrix in body.terms.items()}
    first = np.eye(copies)[0]
    vectors = {"contact": np.kron(first, body.contact), "load": np.kron(first, body.load)}
    rows = {"unbalance": np.kron(first[:, None], body.unbalance), "observers": np.kron(first, body.observers)}
    across = Unequal(*(_beside(copies, part) for part in (unequal.stiffness, unequal.damping)))
    reduced = reduce_unequal(replace(body, **big, **vectors, **rows), across, band, speeds, 1e-3)
    assert reduced.full.n_coordinates == 340 and reduced.body.n_coordinates <= 12 and reduced.error <= 1e-3


def test_a_tolerance_that_cannot_be_met(rub_rotor):
    _, body, unequal, band, speeds = rub_rotor
    with pytest.raises(ReductionError, match=r"tolerance = 1e-10 cannot be met"):
        reduce_unequal(body, Unequal(1e3 * unequal.stiffness, unequal.damping), band, speeds, 1e-10)


def test_a_scene_tells_the_error_with_directions_as_they_differ(tmp_path):
    model = read_ross(FOLDER / "ross_rub_rotor.mat", 20.0)
    scene = scene_of(tmp_path, model, 12, 20.0, ["-500 Hz", "250 Hz"], 1e-3)
    assert 0.0 < scene.rotor.directions_error <= scene.rotor.error <= 1e-3
    (remark,) = (text for text in reduction_remarks(scene) if "reduced" in text)
    assert f"{scene.rotor.directions_error:.1e} with its directions as they differ" in remark
    assert Scene.from_dict(scene.to_dict()).rotor == scene.rotor
    mirror = scene.mirrored()
    assert mirror.mirrored() == scene and mirror.rotor.band == (-250.0, 500.0)
    found, wanted = assemble(mirror), assemble(scene).mirrored()
    for name in ("anisotropic_stiffness_r", "anisotropic_damping_r", "skew_stiffness_r", "unbalance", "load", "schedule_speed"):
        if quantity(wanted, name) is not None:
            np.testing.assert_array_equal(quantity(found, name), quantity(wanted, name))
    alike = replace(model, anisotropic_stiffness=None, anisotropic_damping=None)
    rotor = scene_of(tmp_path, alike, 12, 20.0, ["-500 Hz", "250 Hz"], 1e-3).rotor
    assert rotor.directions_error is None and rotor.anisotropic_stiffness is None
