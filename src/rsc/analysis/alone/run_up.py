"""Motion of the rotor without contact while its speed changes: past a resonance it lags, overshoots and beats.

Without contact the equation is linear. With r = x e^{i phi}, in the frame of the shaft,

    M x'' + (D + 2 i phi' M) x' + (K - phi'^2 M + i phi'' M + i phi' D) x = unbalance phi'^2 - i unbalance_euler phi'',

D = B + i Q - i phi' G: its coefficients change as slowly as the speed does. Over a short step they are constant, and the motion
is an exponential.
"""

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.alone.free_vibration import rotor_matrices
from rsc.analysis.paper.states import amplitudes, first_order, states_of
from rsc.analysis.paper.synchronous import unbalance_response
from rsc.system.blas import one_thread
from rsc.system.system import System

BLOCK = 256  # steps whose matrices are held at a time


@one_thread
def run_up_response(system: System, time: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Deflection of the rotor at the contact by its unbalance along the speed schedule, in the frame of the shaft.

    Parameters
    ----------
    system : System
        All directions alike; a constant load is left out.
    time : (n,) s, rising in equal steps
        Short beside the time in which the speed changes by the width of a resonance.

    Returns
    -------
    (n,) complex m
        Steady at the first instant.
    """
    speed, step = np.asarray(system.speed_at(time)), float(time[1] - time[0])
    middle, rate = 0.5 * (speed[1:] + speed[:-1]), np.diff(speed) / step
    n, rotor, scale = system.n_rotor, system.rotor, _scale(system, speed[0])
    state: NDArray[np.complex128] = np.zeros((len(time), 2 * n + rotor.n_states + 1), dtype=complex)
    state[0, :n], state[0, -1] = unbalance_response(system, speed[0])[0], 1.0
    if rotor.n_states:
        state[0, 2 * n : -1] = states_of(rotor, speed[0], state[0, :n]) / scale[2 * n : -1]
    for first in range(0, len(middle), BLOCK):
        own = zip(middle[first : first + BLOCK], rate[first : first + BLOCK], strict=True)
        carried = scipy.linalg.expm(step * np.array([_augmented(system, *at) * scale / scale[:, None] for at in own]))
        for i, matrix in enumerate(carried, first):
            state[i + 1] = matrix @ state[i]
    return state[:, :n] @ rotor.contact


def _augmented(system: System, Omega, rate):
    """Matrix (2 N + p + 1, 2 N + p + 1) of w' = A w for w = [x, x', z, 1], z the p first-order states."""
    mass, damping, stiffness = rotor_matrices(system, Omega)
    turning = stiffness + (1j * rate - Omega**2) * mass + 1j * Omega * damping
    n, force = len(mass), system.rotor.unbalance * Omega**2 - 1j * system.rotor.unbalance_euler * rate
    rotor = system.rotor
    matrix = np.zeros((2 * n + rotor.n_states + 1,) * 2, dtype=complex)
    matrix[:-1, :-1] = first_order(rotor, mass, damping + 2j * Omega * mass, turning)
    if rotor.n_states:
        matrix[2 * n : -1, :n] += 1j * Omega * rotor.state_velocity
        matrix[2 * n : -1, 2 * n : -1] -= 1j * Omega * np.eye(rotor.n_states)
    matrix[n : 2 * n, -1] = np.linalg.solve(mass, force)
    return matrix


def _scale(system: System, Omega: float):
    """Sizes of [x, x', z, 1] that are alike, with a typical frequency."""
    mass, _, stiffness = rotor_matrices(system, Omega)
    n, rotor = len(mass), system.rotor
    typical = np.sqrt(np.linalg.norm(np.linalg.solve(mass, stiffness), 2)) or 1.0
    sizes = amplitudes(rotor, typical) if rotor.n_states else np.zeros(0)
    return np.concatenate([np.ones(n), np.full(n, typical), sizes, np.ones(1)])
