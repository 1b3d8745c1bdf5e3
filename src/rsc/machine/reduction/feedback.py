"""First-order states of a body to be reduced: magnetic bearings with their controllers close a loop around it.

    z' = Az z + Bz r + Bv r',   force Lz z - K_z r

In a body to be reduced the stiffness K_z that belongs to the states (the negative stiffness of the magnets) is not part of its
stiffness, which stays semidefinite, but a term of its own. Then A(Psi) = A_open(Psi) + K_z - Lz R(Psi) with the states
R(Psi) = (i Psi - Az)^-1 (Bz + i Psi Bv) of unit displacements. It is not symmetric where a sensor is not at its actuator.
"""

from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse
from numpy.typing import ArrayLike, NDArray

from rsc.system.body import Body, Matrix

STIFFNESS = "state_stiffness"  # name of its term


def resolvent(body: Body, growth: ArrayLike) -> NDArray[np.complex128]:
    """(growth - Az)^-1, (..., p, p), for motions e^{growth t}, 1/s; real for real ones."""
    states: Any = body
    growth = np.asarray(growth)[..., None, None]
    return np.asarray(np.linalg.inv(growth * np.eye(body.n_states) - states.state_matrix))


def responding(body: Body, Psi: ArrayLike) -> NDArray[np.complex128]:
    """R(Psi), (..., p, n), for frequencies in rad/s."""
    states: Any = body
    turning = 1j * np.asarray(Psi)
    return resolvent(body, turning) @ (states.state_displacement + turning[..., None, None] * states.state_velocity)


def in_loop(body: Body, Psi: ArrayLike) -> Matrix:
    """Lz R(Psi), N/m; (..., n, n) where the matrices are ndarrays."""
    return _acting(body, responding(body, Psi))


def slope_in_loop(body: Body, Psi: ArrayLike) -> Matrix:
    """Its derivative by Psi, N s/m."""
    states: Any = body
    within = resolvent(body, 1j * np.asarray(Psi))
    return _acting(body, 1j * within @ (states.state_velocity - responding(body, Psi)))


def growing(body: Body, rate: float, shifted: Matrix) -> Matrix:
    """A(-i rate) for a motion that grows like e^{rate t}, real; shifted: K + rate^2 M."""
    states: Any = body
    motion = resolvent(body, rate) @ (states.state_displacement + rate * states.state_velocity)
    return shifted + states.state_stiffness - _acting(body, motion)


def _acting(body: Body, motion: Any) -> Matrix:
    """Force of states (..., p, n)."""
    if scipy.sparse.issparse(body.mass):
        return scipy.sparse.csc_array(body.state_force) @ scipy.sparse.csc_array(motion)
    return body.state_force @ motion


def state_columns(body: Body) -> NDArray[np.float64]:
    """(n, 3 p) forces of the states, Lz, and in the transposed equation Bz^T and Bv^T; (n, 0) without states."""
    states: Any = body
    if not body.n_states:
        return np.zeros((body.n_coordinates, 0))
    return np.hstack([states.state_force, states.state_displacement.T, states.state_velocity.T])


def state_coefficients(reduced: Body, Psi: NDArray[np.float64], y: NDArray[np.complex128], left: bool) -> NDArray[np.complex128]:
    """(m, 3 p) coefficients of `state_columns` in the forces of the states for reduced displacements y (m, r) at m frequencies;
    left: in the transposed equation."""
    states: Any = reduced
    if not reduced.n_states:
        return np.zeros((len(y), 0), complex)
    turning, none = 1j * Psi[:, None], np.zeros((len(y), reduced.n_states))
    if not left:
        return np.hstack([(responding(reduced, Psi) @ y[..., None])[..., 0], none, none])
    driven = (resolvent(reduced, 1j * Psi).swapaxes(1, 2) @ (y @ states.state_force)[..., None])[..., 0]
    return np.hstack([none, driven, turning * driven])


def projected_states(body: Body, basis: NDArray[np.float64]) -> dict[str, Any]:
    """The states' arrays in the coordinates of a basis (n, r) but their stiffness, which is a term; empty without states."""
    states: Any = body
    if not body.n_states:
        return {}
    sensed = {name: getattr(states, name) @ basis for name in ("state_displacement", "state_velocity")}
    return {"state_matrix": states.state_matrix, "state_force": basis.T @ states.state_force, **sensed}


def loop_frequencies(body: Body, Omega: float) -> NDArray[np.float64]:
    """Signed damped natural frequencies of a small closed loop at a speed, rad/s."""
    body = body.at_speed(Omega)
    states: Any = body
    n, p = body.n_coordinates, body.n_states
    terms = body.terms
    damping = terms["damping"] - 1j * Omega * terms.get("gyroscopic", 0.0) + 1j * terms.get("skew_damping", 0.0)
    stiffness = terms["stiffness"] + states.state_stiffness + 1j * terms.get("skew_stiffness", 0.0)
    forces = np.linalg.solve(body.mass, np.hstack([-stiffness, -damping, states.state_force]))
    rates = np.hstack([np.zeros((n, n)), np.eye(n), np.zeros((n, p))])
    own = np.hstack([states.state_displacement, states.state_velocity, states.state_matrix])
    return np.asarray(scipy.linalg.eigvals(np.vstack([rates, forces, own])).imag)
