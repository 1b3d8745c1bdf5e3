"""How large an impulse must be for the rotor to reach its stator: the linear response of the rotor without contact.

After an impulse J in a direction u at a contact with the vector l the rotor that rests in the centre of the gap moves by
r(t) = J E(t) M^-1 l u, where E is the solution of the equations of `free_vibration` for a unit velocity at t = 0. A contact
touches once |l^T r| is its gap.
"""

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.alone.free_vibration import rotor_matrices
from rsc.analysis.paper.states import first_order
from rsc.system.blas import one_thread
from rsc.system.system import System

_STEPS = 256  # in which the response is known
_SMALL = 1e-300  # m, of a response: a contact that the impulse does not move is never reached


@one_thread
def touching_impulses(
    system: System, Omega: float, place: int, duration: float, angles: Sequence[float] | NDArray[np.float64]
) -> NDArray[np.float64]:
    """The smallest impulses at a contact after which each contact touches within a time.

    Parameters
    ----------
    system : System
    Omega : float, rad/s
    place : int, number of the contact at which the rotor is hit
    duration : float, s
    angles : (k,) rad, of the impulse, from y towards z

    Returns
    -------
    (k, n_contacts) N s
    """
    responses = _responses(system, Omega, place, duration)
    directions = np.array([np.cos(angles), np.sin(angles)])
    largest = np.abs(responses @ directions).max(axis=0)
    gaps = np.array([[contact.gap] for contact in system.contacts])
    return np.asarray((gaps / np.maximum(largest, _SMALL)).T)


def _responses(system: System, Omega: float, place: int, duration: float) -> NDArray[np.complex128]:
    """Displacement (steps, n_contacts, 2) in m of the rotor at every contact after an impulse of 1 N s in y and of one in z."""
    rotor = system.rotor
    matrices = rotor_matrices(system, Omega)
    matrix, n, both = first_order(rotor, *matrices), rotor.n_coordinates, len(matrices[0]) > rotor.n_coordinates
    change = np.linalg.solve(rotor.mass, system.contacts[place].rotor)
    states = np.zeros((len(matrix), 2), dtype=matrix.dtype)
    if both:  # the equations are those of y and z
        states[2 * n : 3 * n, 0] = states[3 * n : 4 * n, 1] = change
    else:
        states[n : 2 * n] = np.outer(change, [1.0, 1j])
    step = scipy.linalg.expm(duration / _STEPS * matrix)
    contacts = np.array([contact.rotor for contact in system.contacts])
    moved = np.empty((_STEPS, len(contacts), 2), dtype=complex)
    for own in moved:
        states = step @ states
        own[:] = contacts @ (states[:n] + 1j * states[n : 2 * n] if both else states[:n])
    return moved
