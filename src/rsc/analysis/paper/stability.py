"""Stability of a steady whirl: eigenvalues of small motions in the frame that turns with it (physics.md section 3)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.algebra.eigenvalues import eigenvalues
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import entrywise
from rsc.analysis.paper.states import amplitudes, states_of
from rsc.analysis.paper.whirls import whirl_shapes
from rsc.system.system import FloatOrArray, System


@dataclass(frozen=True, eq=False)
class Growth:
    """Small motions about a whirl, seen in the frame turning with Psi.

    rate : float, 1/s, the largest real part; negative: stable
    frequency : float, rad/s, imaginary part >= 0 that belongs to it (0: the motion creeps away)
    eigenvalues : (4 (N + M) - 1,) complex, 1/s, largest real part first; the free phase is removed; 2 more for each state
    """

    rate: float
    frequency: float
    eigenvalues: NDArray[np.complex128]


def whirl_growth(system: System, Psi: float, F_N: float, Omega: float, b_star: float | None = None, creep: float = 0.0) -> Growth:
    """Growth rate of small disturbances of a steady whirl without unbalance.

        M x'' + (B + i Q + G + 2 i Psi M) x' + (K + i S - Psi^2 M + i Psi (B + i Q + G)) x + l f = 0
        f = (1 + i mu) [k_C Re(y) + b* Re(y') + i F_N/(s + F_N/k_C) Im(y)] + i creep [Psi Re(y) + Im(y')]
            l = [l_R, -l_S],  y = l^T x

    First-order states z in that frame add -Lz z to the left side, z' = (Az - i Psi) z + (Bz + i Psi Bv) x + Bv x'.

    The friction is taken as sliding forward (sigma = +1), also where the scene has a contact diameter, unless `creep` says how it
    follows the slip.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    Psi, F_N : float, rad/s and N
        A whirl root and its (elastic) normal force.
    Omega : float, rad/s
    b_star : float, optional, N s/m
        Contact damping that acts on small motions, between 0 and b_C; default b_C / 2, the mean of the one-sided
        damper over a small oscillation.
    creep : float, N s/m
        What friction gains with the slip: 0 for sliding, F_N mu/slip_velocity for a whirl that rolls.

    Returns
    -------
    Growth

    Raises
    ------
    ValueError
        Rigid contact (infinite contact stiffness).
    """
    return growth_of(whirl_eigenvalues(system, np.array([Psi]), np.array([F_N]), Omega, b_star, creep)[0])


def whirl_growths(
    system: System, Psi: NDArray[np.float64], F_N: NDArray[np.float64], Omega: float | NDArray[np.float64]
) -> list[Growth]:
    """Growth rates of whirls, as `whirl_growth`, for arrays (n,) of Psi and F_N; Omega a scalar or (n,), system one or a stack of
    n."""
    return [growth_of(row) for row in whirl_eigenvalues(system, Psi, F_N, Omega)]


def whirl_eigenvalues(system: System, Psi: NDArray[np.float64], F_N: FloatOrArray, Omega: FloatOrArray, b_star=None, creep=0.0):
    """Eigenvalues (n, 4 (N + M) - 1) of several whirls; the system may be a stack of n and Omega one speed each."""
    matrices = state_matrices(system, Psi, F_N, Omega, b_star, creep)
    return eigenvalues_without_phase(system, matrices, whirl_phases(system, Psi, F_N, Omega))


def eigenvalues_without_phase(system: System, matrices, phases):
    """Eigenvalues of state matrices (n, k, k), balanced, but for the 0 that belongs to a shift of the phase (n, up to k)."""
    scale = state_scale(system, matrices)
    return eigenvalues(without_phase(scale[:, :, None] * matrices / scale[:, None, :], phases * scale[:, : phases.shape[1]]))


def whirl_phases(system: System, Psi: FloatOrArray, F_N: FloatOrArray, Omega: FloatOrArray):
    """Change of every state by a shift of the phase, which moves every coordinate by i x0 and stays: the exact eigenvector of the
    eigenvalue 0, (n, 2 (N + M)) as far as it is not zero, with first-order states (n, 4 (N + M) + 2 p)."""
    shapes = np.concatenate(whirl_shapes(system, Psi, F_N, Omega), axis=1)
    phases, bodies = [-shapes.imag, shapes.real], system.at_speed(Omega).joined()
    if bodies.n_states:
        z = states_of(bodies, Psi, shapes)
        phases += [np.zeros((len(shapes), 2 * shapes.shape[1])), -z.imag, z.real]
    return np.concatenate(phases, axis=1)


def growth_of(eigenvalues):
    """The `Growth` that belongs to eigenvalues (n,) given in any order."""
    eigenvalues = eigenvalues[np.argsort(-eigenvalues.real, kind="stable")].astype(complex)
    return Growth(float(eigenvalues[0].real), float(abs(eigenvalues[0].imag)), eigenvalues)


def state_matrices(system: System, Psi: NDArray[np.float64], F_N: FloatOrArray, Omega: FloatOrArray, b_star=None, creep=0.0):
    """State matrices of small motions, before the free phase is removed.

    Parameters
    ----------
    system : System
    Psi, F_N : (n_psi,) float, rad/s and N
    Omega, b_star, creep : float, rad/s and N s/m; as in `whirl_growth`

    Returns
    -------
    (n_psi, 4n + 2p, 4n + 2p) float
        Of [Re x, Im x, Re x', Im x', Re z, Im z], n = N + M, p first-order states; not balanced.
    """
    whole, law = system.at_speed(Omega).joined(), law_of(system)
    bodies = whole.without_states()
    mu, b_star = entrywise(law.friction), entrywise(law.mean_damping if b_star is None else b_star)
    n = bodies.mass.shape[-1]
    inverse = np.linalg.inv(bodies.mass)
    damping, gyroscopic = inverse @ bodies.damping, inverse @ bodies.turning(Omega)
    contact = (inverse @ system.relative[..., None]) * system.relative[..., None, :]
    radial, tangential = (entrywise(slope) * contact for slope in law.slopes(F_N))
    Psi = entrywise(Psi)
    stiffness = inverse @ bodies.stiffness - Psi**2 * np.eye(n) + Psi * gyroscopic
    turning = gyroscopic - 2.0 * Psi * np.eye(n)
    re, im, re_dot, im_dot = (slice(i * n, (i + 1) * n) for i in range(4))
    matrix = np.zeros((len(Psi), *(4 * n + 2 * whole.n_states,) * 2))
    matrix[:, re, re_dot] = matrix[:, im, im_dot] = np.eye(n)
    matrix[:, re_dot, re] = -stiffness - radial
    matrix[:, re_dot, im] = Psi * damping + mu * tangential
    matrix[:, im_dot, re] = -Psi * damping - mu * radial - Psi * creep * contact
    matrix[:, im_dot, im] = -stiffness - tangential
    matrix[:, re_dot, re_dot] = -damping - b_star * contact
    matrix[:, re_dot, im_dot] = -turning
    matrix[:, im_dot, re_dot] = turning - mu * b_star * contact
    matrix[:, im_dot, im_dot] = -damping - creep * contact
    if bodies.skew_stiffness is not None:
        skew = inverse @ bodies.skew_stiffness
        matrix[:, re_dot, im] += skew
        matrix[:, im_dot, re] -= skew
    if whole.n_states:
        put_states(matrix, whole, inverse, Psi)
    return matrix


def put_states(matrix, bodies, inverse, Psi: FloatOrArray):
    """Write first-order states into `state_matrices`, in place."""
    n, p = bodies.n_coordinates, bodies.n_states
    re, im, re_dot, im_dot = (slice(i * n, (i + 1) * n) for i in range(4))
    z, z_im = slice(4 * n, 4 * n + p), slice(4 * n + p, 4 * n + 2 * p)
    matrix[:, re_dot, z] = matrix[:, im_dot, z_im] = inverse @ bodies.state_force
    matrix[:, z, re] = matrix[:, z_im, im] = bodies.state_displacement
    matrix[:, z, im], matrix[:, z_im, re] = -Psi * bodies.state_velocity, Psi * bodies.state_velocity
    matrix[:, z, re_dot] = matrix[:, z_im, im_dot] = bodies.state_velocity
    matrix[:, z, z] = matrix[:, z_im, z_im] = bodies.state_matrix
    matrix[:, z, z_im], matrix[:, z_im, z] = Psi * np.eye(p), -Psi * np.eye(p)


def state_scale(system: System, matrices):
    """Factors (n_psi, 4n + 2p) for states of comparable sizes: sqrt(m) x and sqrt(m) x' / omega, omega of the contact, and of
    first-order states z as much as a motion of 1 makes them."""
    masses = [np.diagonal(mass, axis1=-2, axis2=-1) for mass in (system.rotor.mass, system.stator.mass)]
    root_mass = np.sqrt(np.concatenate(masses * 2, axis=-1))
    size = root_mass.shape[-1]
    springs = root_mass[..., :, None] * matrices[:, size : 2 * size, :size] / root_mass[..., None, :]
    typical = np.sqrt(np.linalg.norm(springs, axis=(-2, -1)))[:, None]
    root_mass = np.broadcast_to(root_mass, (len(matrices), size))
    scale = np.concatenate([root_mass, root_mass / typical], axis=1)
    if scale.shape[1] == matrices.shape[1]:
        return scale
    bodies, mean = system.joined(), root_mass.mean(axis=1, keepdims=True)
    size = np.array([amplitudes(bodies.at(i), omega) for i, omega in enumerate(typical[:, 0].tolist())])
    return np.concatenate([scale, np.tile(mean / size, 2)], axis=1)


def without_phase(matrices, phases):
    """Remove the eigenvalue 0 whose eigenvector is [phase, 0]: one Householder reflection, one row and column less.

    Unlike dropping the smallest eigenvalue this stays right at a fold, where a second eigenvalue crosses zero.
    """
    n_psi, size = phases.shape
    normals = np.zeros((n_psi, matrices.shape[1]))
    normals[:, :size] = phases / np.linalg.norm(phases, axis=1)[:, None]
    # the reflection maps the phase onto the first axis; this sign avoids cancellation
    normals[:, 0] += np.where(normals[:, 0] >= 0.0, 1.0, -1.0)
    beta = (2.0 / np.sum(normals**2, axis=1))[:, None, None]
    rows, columns = normals[:, None, :], normals[:, :, None]
    matrices = matrices - beta * columns * (rows @ matrices)
    matrices = matrices - beta * (matrices @ columns) * rows
    return matrices[:, 1:, 1:]
