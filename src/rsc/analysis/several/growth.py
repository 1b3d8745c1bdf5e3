"""Small motions about a whirl at several contacts: their growth, and the lines of the unbalance.

In the frame turning with Psi, y_j = l_j^T x, the force of contact j of the pressed set is, as for one contact (section 3.5 of
docs/users/physics.md), but turned by its phase,

    f_j = u_j (1 + i mu_j) [k_j Re(y_j conj u_j) + b*_j Re(y_j' conj u_j) + i F_j/|d_j| Im(y_j conj u_j)],   u_j = e^{i phi_j}.
"""

import numpy as np

from rsc.analysis.paper.receptance import dynamic_stiffness, in_both_directions
from rsc.analysis.paper.stability import eigenvalues_without_phase, growth_of, put_states
from rsc.system.body import Body
from rsc.system.system import FloatOrArray, System


def growths(system: System, own, whirls):
    """The `Growth` of each of m whirls, whose contacts slide forward; the damper of a contact counts with its mean, b_C/2.

    Parameters
    ----------
    system : System
    own : Pressed
    whirls : Whirling
    """
    bodies = system.at_speed(own.Omega).joined()
    matrices = np.array([_state_matrix(own, bodies, *whirl) for whirl in zip(*whirls, strict=True)])
    if not len(matrices):
        return []
    shapes, z = np.split(own.shapes(whirls), [bodies.n_coordinates], axis=1)
    phases = np.concatenate([-shapes.imag, shapes.real, *(_of_states(shapes, z) if own.states else ())], axis=1)
    return [growth_of(row) for row in eigenvalues_without_phase(system, matrices, phases)]


def _of_states(shapes, z):
    """The rest of the phase's state where there are first-order states: velocities, which are none, and their own change."""
    return np.zeros((len(shapes), 2 * shapes.shape[1])), -z.imag, z.real


def _state_matrix(own, whole: Body, Psi: FloatOrArray, N, phi):
    """State matrix (4 n + 2 p, 4 n + 2 p) of [Re x, Im x, Re x', Im x', Re z, Im z] about one whirl; whole: both bodies."""
    bodies, n = whole.without_states(), whole.n_coordinates
    mass, turning = bodies.mass, bodies.turning(own.Omega)
    A = dynamic_stiffness(mass, bodies.by_frequency(own.Omega), bodies.static, np.array([Psi]))[0]
    stiffness = in_both_directions(A, None)
    damping = in_both_directions(bodies.damping - 1j * turning + 2j * Psi * mass, None)
    for law, row, force, angle in zip(own.laws, own.rows[:, :n], N, phi, strict=True):
        radial, tangential = law.slopes(force)
        place = np.outer(row, row)
        stiffness += np.kron(_turned(law.friction, angle, radial, tangential), place)
        damping += np.kron(_turned(law.friction, angle, law.mean_damping, 0.0), place)
    inverse, size = np.linalg.inv(mass), 2 * n
    both = in_both_directions(inverse + 0j, None)
    matrix = np.block([[np.zeros((size, size)), np.eye(size)], [-both @ stiffness, -both @ damping]])
    if not own.states:
        return matrix
    matrix = np.pad(matrix, (0, 2 * own.states))
    put_states(matrix[None], whole, inverse, Psi)
    return matrix


def _turned(friction, angle, radial, tangential):
    """[y, z] matrix of a force along and across a direction, each with its friction."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return turn @ np.array([[radial, -friction * tangential], [friction * radial, tangential]]) @ turn.T
