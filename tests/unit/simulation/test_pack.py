"""The kernel's coordinates: real modes, rounded once from eigenvectors in many digits."""


import mpmath as mp
import numpy as np
import pytest

import systems
from rsc.scene.scene import Scene
from rsc.simulation.pack import pack
from rsc.system.assemble import assemble
from scenes import LAVAL, changed

EPS = np.finfo(float).eps
N = 8


def graded_chain():
    """(M, K) of a chain of disks, springs graded over four decades, masses coupled."""
    k = np.logspace(4, 8, N + 1)
    stiffness = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    mass = np.diag(np.linspace(1.0, 2.0, N)) + 0.1 * (np.eye(N, k=1) + np.eye(N, k=-1))
    return mass, stiffness


def exact_modes(mass, stiffness):
    """(omega^2, rising; modes normalised to X^T M X = 1, their largest entry positive) of K x = omega^2 M x in 40 digits."""
    with mp.workdps(40):
        inverse = mp.cholesky(mp.matrix(mass.tolist())) ** -1
        omega2, vectors = mp.eigsy(inverse * mp.matrix(stiffness.tolist()) * inverse.T)
        shapes = np.array((inverse.T * vectors).tolist(), dtype=object)
        return list(omega2), _turned(shapes)


def _turned(shapes):
    """Modes whose largest entry is positive."""
    return np.array([column * (1 if column[np.argmax(abs(column))] > 0 else -1) for column in shapes.T]).T


def packed_chain():
    mass, stiffness = graded_chain()
    scene = Scene.from_dict(LAVAL)
    zero, one = np.zeros((N, N)), np.eye(N)[:, 0]
    system = systems.changed(
        assemble(scene), mass_r=mass, stiffness_r=stiffness, damping_r=zero, gyroscopic_r=zero, contact_r=one,
        unbalance=one * 1e-5 + 0j, unbalance_euler=one * 1e-5 + 0j, load=zero[0] + 0j,
    )  # fmt: skip
    return mass, stiffness, pack(system, scene.solver, 1000.0)


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="no extended precision on this machine")
def test_modes_of_a_rotor_with_soft_and_stiff_springs_are_exact_to_rounding():
    mass, stiffness, packed = packed_chain()
    omega2, shapes = exact_modes(mass, stiffness)
    assert max(abs(mp.mpf(float(found)) / true - 1) for found, true in zip(packed.rotor.stiffness, omega2, strict=True)) < EPS
    errors = _turned(packed.rotor.shape) - np.sqrt(packed.rotor.reference_mass) * shapes.astype(float)
    assert abs(errors).max() < 2 * EPS


def test_modes_diagonalise_the_mass_and_invert():
    mass, _, packed = packed_chain()
    shape, reference = packed.rotor.shape, packed.rotor.reference_mass
    assert np.allclose(shape.T @ mass @ shape, reference * np.eye(N), rtol=0, atol=20 * EPS * reference)
    assert np.allclose(packed.rotor.inverse @ shape, np.eye(N), rtol=0, atol=20 * EPS)


def test_matrices_begin_on_a_cache_line():
    """Registers of eight numbers would else lie across two lines (ROSS took 15 % longer)."""
    rng = np.random.default_rng(0)
    for n in (2, 3, 5, 12):
        part = rng.normal(size=(n, n))
        matrices = {"mass": np.eye(n).tolist(), "stiffness": (1e5 * np.eye(n)).tolist(), "damping": (part @ part.T).tolist()}
        rotor = {"model": "matrices", **matrices, "gyroscopic": np.diag(np.arange(n) / n).tolist()}
        scene = Scene.from_dict(LAVAL | {"rotor": rotor, "start": {}})
        model = pack(assemble(scene), scene.solver, 2000.0).model
        for columns in (model.damping_columns, model.gyroscopic_columns):
            assert len(columns) and columns.ctypes.data % 64 == 0


@pytest.mark.parametrize("speed", [[0.1, 0.2], [20.0, 900.0], [900.0, 20.0], [-500.0, 30.0]])
def test_no_step_is_longer_than_a_quarter_of_a_turn(speed):
    """The polynomials of the rotations of a step's stages reach no further."""
    scene = Scene.from_dict(changed(drive={"speed": speed}, output={"rate": 8000.0}))
    model = pack(assemble(scene), scene.solver, scene.output.rate).model
    assert model.h_max * max(abs(f) for f in speed) <= 0.25 * (1.0 + EPS)
