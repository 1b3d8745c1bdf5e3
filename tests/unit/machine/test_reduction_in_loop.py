"""Reduction of bodies in the closed loop of first-order states: errors, derivatives and left solutions of many coordinates."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse

from rsc.machine.reduction.body import dynamic_stiffness, slope, solutions
from rsc.machine.reduction.reduction import reduce
from rsc.machine.reduction.shifts import receptance_error
from rsc.system.body import Body

N, BAND, SPEEDS = 304, (-2500.0, 2500.0), (0.0, 600.0)
SENSORS, ACTUATORS = (20, 280), (40, 250)


def chain(sparse=True, damping=2e-6):
    """A free chain of masses between two magnetic bearings whose sensors are elsewhere, with a weight and an unbalance."""
    link = scipy.sparse.diags_array([[-1.0] * (N - 1), [1.0] + [2.0] * (N - 2) + [1.0], [-1.0] * (N - 1)], offsets=[-1, 0, 1])
    stiffness = scipy.sparse.csc_array(4e8 * link)
    mass = scipy.sparse.csc_array(scipy.sparse.eye_array(N) * 0.05)
    row, unbalance = np.zeros(N), np.zeros((N, 1), complex)
    row[150], unbalance[200] = 1.0, 1e-4
    p, force, sensed, own = 6, np.zeros((N, 6)), np.zeros((6, N)), np.zeros((6, 6))
    direct = scipy.sparse.lil_array((N, N))
    for i, (sensor, actuator) in enumerate(zip(SENSORS, ACTUATORS, strict=True)):
        part, corner, lag = slice(3 * i, 3 * i + 3), 2e4, 1e4
        own[part, part] = [[-corner, 0.0, 0.0], [0.0, 0.0, 0.0], [-lag * 900.0 * corner, lag * 1e7, -lag]]
        sensed[part, sensor] = corner, 1.0, lag * (3e6 + 900.0 * corner)
        force[actuator, 3 * i + 2] = -1.0
        direct[actuator, actuator] = -5e5
    body = Body(
        mass=mass, damping=damping * stiffness, stiffness=stiffness, contact=row, unbalance=unbalance, load=-0.5j * np.ones(N),
        observers=np.zeros((0, N)), state_matrix=own, state_displacement=sensed, state_velocity=np.zeros((p, N)),
        state_force=force, state_stiffness=scipy.sparse.csc_array(direct),
    )  # fmt: skip
    if sparse:
        return body
    dense = {name: getattr(body, name).toarray() for name in ("mass", "damping", "stiffness", "state_stiffness")}
    return replace(body, **dense)


def written_out(body, Psi):
    """A(Psi), term by term."""
    A = body.stiffness.toarray() - Psi**2 * body.mass.toarray() + 1j * Psi * body.damping.toarray()
    for i, (sensor, actuator) in enumerate(zip(SENSORS, ACTUATORS, strict=True)):
        s, corner, lag = 1j * Psi, 2e4, 1e4
        A[actuator, actuator] -= 5e5
        A[actuator, sensor] += lag / (s + lag) * (3e6 + 1e7 / s + 900.0 * corner * s / (s + corner))
        assert body.state_force[actuator, 3 * i + 2] == -1.0
    return A


def test_the_loop_is_what_is_written_out():
    Psi, Omega = np.array([-900.0, 350.0, 2100.0]), np.zeros(3)
    sparse, dense = chain(), chain(sparse=False)
    forces = np.repeat(sparse.inputs[:, :1], 3, axis=1)
    for left in (False, True):
        matrices = [written_out(sparse, w) for w in Psi]
        exact = [np.linalg.solve(matrix.T if left else matrix, sparse.contact) for matrix in matrices]
        for body in (sparse, dense):
            np.testing.assert_allclose(solutions(body, Psi, Omega, forces, left=left), exact, rtol=1e-8)
    h = 1e-3
    around = [dynamic_stiffness(dense, np.array([350.0 + step]), np.zeros(1))[0] for step in (-h, h)]
    np.testing.assert_allclose(slope(dense, 350.0, 0.0), (around[1] - around[0]) / (2.0 * h), rtol=1e-5, atol=1e-3)


def test_the_stated_error_holds_where_it_is_estimated():
    body = chain()
    reduced = reduce(body, BAND, SPEEDS, 1e-5)
    assert reduced.body.n_coordinates < 30 and reduced.error <= 1e-5
    Psi = np.random.default_rng(2).uniform(*BAND, 25)
    exact = np.array([np.linalg.solve(written_out(body, w), body.contact) @ body.contact for w in Psi])
    small = solutions(reduced.body, Psi, np.zeros(25), np.repeat(reduced.body.inputs[:, :1], 25, axis=1)) @ reduced.body.contact
    share = np.abs(small - exact) / np.maximum(np.abs(exact), 1e-2 * np.abs(exact).max())
    assert 0.0 < share.max() < reduced.error
    errors, slopes = receptance_error(reduced, 700.0, 0.0)
    at = [np.linalg.solve(written_out(body, w), body.contact) @ body.contact for w in (699.99, 700.01, 700.0)]
    assert slopes[0, 0] == pytest.approx((at[1] - at[0]) / 0.02, rel=1e-4)
    own = solutions(reduced.body, np.array([700.0]), np.zeros(1), reduced.body.inputs[:, :1])[0] @ reduced.body.contact
    assert errors[0, 0] == pytest.approx(at[2] - own, abs=1e-3 * reduced.error * abs(own))
