"""Reduction of bodies that nothing holds, or next to nothing: rigid motions kept, receptances within the tolerance."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

from machines import beam
from rsc.errors import ReductionError
from rsc.machine.reduction.body import FEW, solutions
from rsc.machine.reduction.directions import FrequencyPoint, Unequal, reduce_unequal, responses
from rsc.machine.reduction.reduction import reduce
from rsc.machine.reduction.shift import HELD, shift_of
from rsc.system.body import Body

TWO_PI = 2.0 * np.pi
BAND, SPEEDS = (-TWO_PI * 1500.0, TWO_PI * 750.0), (0.0, TWO_PI * 200.0)
N_NODES = 31


def rotor(stiffness=0.0, nodes=(5, 25)):
    """A shaft with two discs and a bearing of a stiffness near both ends; contacts at two nodes."""
    n = 2 * N_NODES
    matrices = [np.zeros((n, n)) for _ in range(3)]
    for i in range(N_NODES - 1):
        rows = slice(2 * i, 2 * i + 4)
        for whole, part in zip(matrices, beam(1.2 / (N_NODES - 1), 0.05), strict=True):
            whole[rows, rows] += part
    K, M, G = matrices
    for node in (12, 18):
        M[2 * node, 2 * node] += 10.0
        M[2 * node + 1, 2 * node + 1] += 0.05
        G[2 * node + 1, 2 * node + 1] += 0.09
    damping = 1e-6 * K
    for node in (3, 27):
        K[2 * node, 2 * node] += stiffness
    contact = np.eye(n)[[2 * node for node in nodes]]
    unbalance = np.zeros((n, 1), complex)
    unbalance[24] = 20e-6
    load = -9.81j * (M @ np.tile([1.0, 0.0], N_NODES))
    return Body(M, damping, K, contact, G, unbalance=unbalance, load=load, observers=np.eye(n)[[30]])


def worst(body, result, Psi):
    """Largest relative difference of the receptances between the contacts at frequencies in rad/s."""
    Psi, Omega = np.asarray(Psi), np.full(len(Psi), SPEEDS[1])
    differences = []
    for i in range(len(body.contact)):
        full, small = (
            solutions(one, Psi, Omega, np.repeat(one.inputs[:, [i]], len(Psi), axis=1)) @ one.contact.T
            for one in (body, result.body)
        )
        differences.append(np.abs(full - small).max(axis=1) / np.abs(full).max(axis=1))
    return np.max(differences)


@pytest.mark.parametrize("stiffness", [0.0, 1.0, 100.0, 1e4, 1e6])
def test_softer_and_softer_bearings_reduce_alike(stiffness):
    body = rotor(stiffness)
    result = reduce(body, BAND, SPEEDS, 1e-4)
    assert (shift_of(body, max(map(abs, BAND))) == HELD) == (stiffness > 100.0)
    assert result.body.n_coordinates <= 20 and result.error <= 1e-4
    assert worst(body, result, TWO_PI * np.array([-1400.0, -300.0, -50.0, -5.0, 3.0, 40.0, 700.0])) < 1e-4


def test_the_rigid_motions_of_a_free_rotor_are_kept():
    """Mass and moment of inertia, to rounding: an impulse turns and moves both in the same way for ever."""
    body = rotor()
    result = reduce(body, BAND, SPEEDS, 1e-3)
    squares = scipy.linalg.eigvalsh(result.body.stiffness, result.body.mass)
    elastic = scipy.linalg.eigvalsh(body.stiffness, body.mass)[2]
    assert np.abs(squares[:2]).max() < 1e-9 * elastic and squares[2] == pytest.approx(elastic, rel=1e-3)
    rigid = np.array([np.tile([1.0, 0.0], N_NODES), np.stack([0.04 * np.arange(N_NODES), np.ones(N_NODES)]).T.ravel()]).T
    coordinates, *_ = np.linalg.lstsq(result.basis, rigid, rcond=None)
    np.testing.assert_allclose(result.basis @ coordinates, rigid, atol=1e-8)
    np.testing.assert_allclose(coordinates.T @ result.body.mass @ coordinates, rigid.T @ body.mass @ rigid, rtol=1e-8)


def test_a_large_free_body_is_reduced_by_estimates():
    n = FEW + 100
    chain = scipy.sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n)).tolil()
    chain[0, 0] = chain[n - 1, n - 1] = 1.0
    stiffness = 1e9 * chain.tocsc()
    body = Body(scipy.sparse.eye_array(n), 1e-6 * stiffness, stiffness, np.eye(n)[[3, 300]])
    result = reduce(body, (-2000.0, 2000.0), (0.0, 50.0))
    dense = replace(body, **{name: getattr(body, name).toarray() for name in ("mass", "damping", "stiffness")})
    dense = replace(dense, unbalance=np.zeros((n, 0)), load=np.zeros(n), observers=np.zeros((0, n)))
    assert result.body.n_coordinates < 60 and worst(dense, result, [-1900.0, -400.0, -40.0, 7.0, 90.0, 1300.0]) < 1e-4


def test_both_lines_of_a_rotor_on_one_bearing_that_is_none_in_one_direction():
    """A bearing that holds y and not z: the mean has a stiffness, the machine a free motion, and the other end nothing."""
    body = rotor()
    n = body.n_coordinates
    stiffness, unequal = body.stiffness.copy(), np.zeros((n, n), complex)
    stiffness[6, 6] += 1e6
    unequal[6, 6] = 1e6
    body, matrices = replace(body, stiffness=stiffness), Unequal(unequal, np.zeros((n, n), complex))
    result = reduce_unequal(body, matrices, BAND, SPEEDS, 1e-4)
    small = matrices.projected(result.basis)
    for Psi in TWO_PI * np.array([1300.0, 150.0, 20.0, 4.0]):
        place, c = FrequencyPoint(Psi, SPEEDS[1], [0, 1, 2, 3]), np.kron(np.eye(2), body.contact)
        full = c @ responses(body, matrices, place)
        reduced = np.kron(np.eye(2), result.body.contact) @ responses(result.body, small, place)
        assert np.abs(full - reduced).max() < 1e-4 * np.abs(full).max()


def test_what_buckles_is_refused_however_it_is_held():
    body = rotor()
    stiffness = body.stiffness.copy()
    stiffness[30, 30] -= 1e4
    with pytest.raises(ReductionError, match="indefinite: a body that buckles"):
        reduce(replace(body, stiffness=stiffness), BAND, SPEEDS, 1e-4)
