"""Motion of the rotor without contact while its speed changes: past a resonance it lags, overshoots and beats.

Without contact the equation is linear. With r = x e^{i phi}, in the frame of the shaft,

    M x'' + (D + 2 i phi' M) x' + (K - phi'^2 M + i phi'' M + i phi' D) x = unbalance phi'^2 - i unbalance_euler phi'',

D = B + i Q - i phi' G: its coefficients change as slowly as the speed does. Over a short step they are constant, and the motion
is an exponential.
"""

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.alone.free_vibration import rotor_matrices, state_matrix
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
    size = 2 * system.n_rotor + 1
    state: NDArray[np.complex128] = np.zeros((len(time), size), dtype=complex)
    state[0, : system.n_rotor], state[0, -1] = unbalance_response(system, speed[0])[0], 1.0
    for first in range(0, len(middle), BLOCK):
        own = zip(middle[first : first + BLOCK], rate[first : first + BLOCK], strict=True)
        carried = scipy.linalg.expm(step * np.array([_augmented(system, *at) for at in own]))
        for i, matrix in enumerate(carried, first):
            state[i + 1] = matrix @ state[i]
    return state[:, : system.n_rotor] @ system.rotor.contact


def _augmented(system, Omega, rate):
    """Matrix (2 N + 1, 2 N + 1) of z' = A z for z = [x, x' / w, 1], w a typical frequency in 1/s."""
    mass, damping, stiffness = rotor_matrices(system, Omega)
    turning = stiffness + (1j * rate - Omega**2) * mass + 1j * Omega * damping
    n, force = len(mass), system.rotor.unbalance * Omega**2 - 1j * system.rotor.unbalance_euler * rate
    matrix = np.zeros((2 * n + 1, 2 * n + 1), dtype=complex)
    matrix[: 2 * n, : 2 * n] = state_matrix(mass, damping + 2j * Omega * mass, turning)
    matrix[n : 2 * n, -1] = np.linalg.solve(mass, force)
    typical = np.sqrt(np.linalg.norm(np.linalg.solve(mass, stiffness), 2))
    scale = np.concatenate([np.ones(n), np.full(n, typical), np.ones(1)])
    return matrix * scale / scale[:, None]
