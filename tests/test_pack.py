"""The kernel's coordinates: real modes, rounded once from eigenvectors in many digits."""

from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest

from rsc.assemble import assemble
from rsc.pack import pack
from rsc.scene import Scene
from scenes import LAVAL

EPS = np.finfo(float).eps


def graded_chain(n):
    """(M, K) of a chain of disks, springs graded over four decades, masses coupled."""
    k = np.logspace(4, 8, n + 1)
    stiffness = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    mass = np.diag(np.linspace(1.0, 2.0, n)) + 0.1 * (np.eye(n, k=1) + np.eye(n, k=-1))
    return mass, stiffness


def exact_modes(mass, stiffness):
    """omega^2, rising, of K x = omega^2 M x in 40 digits."""
    with mp.workdps(40):
        lower = mp.cholesky(mp.matrix(mass.tolist()))
        inverse = lower**-1
        values = mp.eigsy(inverse * mp.matrix(stiffness.tolist()) * inverse.T, eigvals_only=True)
        return sorted(values)


def packed_chain(n=8):
    mass, stiffness = graded_chain(n)
    scene = Scene.from_dict(LAVAL)
    system = assemble(scene)
    zero, one = np.zeros((n, n)), np.eye(n)[:, 0]
    system = replace(
        system, mass_r=mass, stiffness_r=stiffness, damping_r=zero, gyroscopic_r=zero, contact_r=one,
        unbalance=one * 1e-5 + 0j, unbalance_euler=one * 1e-5 + 0j, load=zero[0] + 0j,
    )  # fmt: skip
    return mass, stiffness, pack(system, scene.solver, 1000.0)


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="no extended precision on this machine")
def test_low_modes_of_a_stiff_rotor_are_exact_to_rounding():
    mass, stiffness, packed = packed_chain()
    exact = exact_modes(mass, stiffness)
    # stiffness in the kernel is per reference mass: omega^2 as it is
    errors = [abs(mp.mpf(float(found)) / true - 1) for found, true in zip(np.sort(packed.rotor.stiffness), exact, strict=True)]
    assert max(errors) < EPS


def test_modes_diagonalise_and_invert():
    mass, _, packed = packed_chain()
    shape, reference = packed.rotor.shape, packed.rotor.reference_mass
    assert np.allclose(shape.T @ mass @ shape, reference * np.eye(8), rtol=0, atol=20 * EPS * reference)
    assert np.allclose(packed.rotor.inverse @ shape, np.eye(8), rtol=0, atol=20 * EPS)
