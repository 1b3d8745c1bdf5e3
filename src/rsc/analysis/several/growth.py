"""Small motions about a whirl at several contacts: their growth, and the lines of the unbalance.

In the frame turning with Psi, y_j = l_j^T x, the force of contact j of the pressed set is, as for one contact (section 3.5 of
docs/users/physics.md), but turned by its phase,

    f_j = u_j (1 + i mu_j) [k_j Re(y_j conj u_j) + b*_j Re(y_j' conj u_j) + i F_j/|d_j| Im(y_j conj u_j)],   u_j = e^{i phi_j}.
"""

import numpy as np

from rsc.analysis.paper.receptance import in_both_directions
from rsc.analysis.paper.stability import eigenvalues_without_phase, growth_of
from rsc.system.system import FloatOrArray, System


def growths(system: System, own, whirls):
    """The `Growth` of each of m whirls, whose contacts slide forward; the damper of a contact counts with its mean, b_C/2.

    Parameters
    ----------
    system : System
    own : Pressed
    whirls : Whirling
    """
    matrices = np.array([_state_matrix(own, *whirl) for whirl in zip(*whirls, strict=True)])
    if not len(matrices):
        return []
    shapes = own.shapes(whirls)
    phases = np.concatenate([-shapes.imag, shapes.real], axis=1)
    return [growth_of(row) for row in eigenvalues_without_phase(system, matrices, phases)]


def _state_matrix(own, Psi: FloatOrArray, N, phi):
    """State matrix (4 n, 4 n) of [Re x, Im x, Re x', Im x'] about one whirl."""
    bodies = own.bodies
    mass, turning = bodies.mass, bodies.turning(own.Omega)
    stiffness = in_both_directions(own.dynamic_stiffness(np.array([Psi]))[0], None)
    damping = in_both_directions(bodies.damping - 1j * turning + 2j * Psi * mass, None)
    for law, row, force, angle in zip(own.laws, own.rows, N, phi, strict=True):
        radial, tangential = law.slopes(force)
        place = np.outer(row, row)
        stiffness += np.kron(_turned(law.friction, angle, radial, tangential), place)
        damping += np.kron(_turned(law.friction, angle, law.mean_damping, 0.0), place)
    inverse, size = in_both_directions(np.linalg.inv(mass) + 0j, None), 2 * len(mass)
    return np.block([[np.zeros((size, size)), np.eye(size)], [-inverse @ stiffness, -inverse @ damping]])


def _turned(friction, angle, radial, tangential):
    """[y, z] matrix of a force along and across a direction, each with its friction."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return turn @ np.array([[radial, -friction * tangential], [friction * radial, tangential]]) @ turn.T
