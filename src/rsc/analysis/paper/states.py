"""First-order states in the analysis: magnetic bearings with controllers, lags, viscoelastic supports (physics.md section 2).

    z' = Az z + Bz r + Bv r',   force Lz z:   A(Psi) gains -Lz (i Psi - Az)^-1 (Bz + i Psi Bv)

Where A is needed as a polynomial in Psi the states count as coordinates without mass (`Body.with_states`); free motions are those
of one first-order equation of [x, x', z].
"""

import numpy as np

from rsc.system.system import FloatOrArray


def feedback(body, Psi: FloatOrArray):
    """Lz (i Psi - Az)^-1 (Bz + i Psi Bv) of a body or a stack, in N/m, for every Psi in rad/s."""
    turning = 1j * np.asarray(Psi)[..., None, None]
    resolvent = turning * np.eye(body.n_states) - body.state_matrix
    return body.state_force @ np.linalg.solve(resolvent, body.state_displacement + turning * body.state_velocity)


def states_of(body, Psi: FloatOrArray, motion):
    """States (..., p) of a motion (..., n) e^{i Psi t} of a body."""
    turning = 1j * np.asarray(Psi)[..., None, None]
    sensed = (body.state_displacement + turning * body.state_velocity) @ np.asarray(motion)[..., None]
    return np.linalg.solve(turning * np.eye(body.n_states) - body.state_matrix, sensed)[..., 0]


def first_order(body, mass, damping, stiffness):
    """Matrix (2 n + p, 2 n + p) of [r, r', z] of a body without contact, whose other matrices are given; where these are of the
    components [y, z] so is it."""
    n, p, twice = len(mass), body.n_states, len(mass) // body.n_coordinates
    matrix = np.zeros((2 * n + twice * p,) * 2, dtype=np.result_type(damping, stiffness, float))
    matrix[:n, n : 2 * n] = np.eye(n)
    lower = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    matrix[n : 2 * n, : 2 * n] = lower
    if p:
        each = np.eye(twice)
        matrix[n : 2 * n, 2 * n :] = np.linalg.solve(mass, np.kron(each, body.state_force))
        parts = (body.state_displacement, body.state_velocity, body.state_matrix)
        matrix[2 * n :] = np.hstack([np.kron(each, part) for part in parts])
    return matrix


def free_matrix(body, Omega: FloatOrArray):
    """`first_order` of a body at a rotor speed in rad/s."""
    plain = body.without_states()
    return first_order(body, plain.mass, -1j * plain.by_frequency(Omega), plain.static)


def typical(body):
    """A typical frequency of a body, rad/s, to scale its unknowns."""
    squares = np.abs(np.diagonal(body.stiffness) / np.diagonal(body.mass))
    return float(np.sqrt(squares.max(initial=0.0))) or 1.0


def amplitudes(body, omega):
    """(p,) sizes of the states for a motion of all coordinates by 1 at a frequency in rad/s, to scale them; 1 of one that nothing
    drives."""
    sensed = body.state_displacement + omega * body.state_velocity
    size = np.abs(np.linalg.solve(omega * np.eye(body.n_states) - body.state_matrix, sensed)).sum(axis=-1)
    return np.where(size > 0.0, size, 1.0)
