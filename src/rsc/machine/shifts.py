"""How far whirls and natural frequencies of a reduced body lie from those of the full one: one full solution for each.

The reduced body's error of the receptance is not bounded but computed: the full dynamic stiffness is solved where it matters.
"""

from collections.abc import Sequence

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from rsc.machine.body import solutions
from rsc.machine.reduction import Reduced
from rsc.system.body import Body


def receptance_error(reduced: Reduced, Psi: float, Omega: float) -> tuple[complex, complex]:
    """(H - H_r, dH/dPsi) of the contact at a frequency and a rotor speed in rad/s, in m/N and m s/N."""
    at = np.array([Psi]), np.array([Omega])
    x, y = (solutions(body, *at, body.inputs[:, :1])[0] for body in (reduced.full, reduced.body))
    slope = -x @ (reduced.full.slope(Psi, Omega) @ x)
    return complex(reduced.full.contact @ x - reduced.body.contact @ y), complex(slope)


def whirl_shift(bodies: Sequence[Reduced], Psi: float, Omega: float, friction: float) -> float:
    """Whirl frequency of the full bodies less that of the reduced ones, rad/s, to first order.

    With H the sum of the receptances and c = 1 + i mu a whirl fulfils Im(c H) = 0, so dPsi = -Im(c dH) / Im(c dH/dPsi).

    Parameters
    ----------
    bodies : sequence of Reduced
        The rotor and, unless it is rigid, the stator.
    Psi, Omega : float, rad/s
        The whirl predicted with the reduced bodies, and the rotor speed.
    friction : float
        mu.
    """
    c = 1.0 + 1j * friction
    error, slope = (c * np.sum([receptance_error(reduced, Psi, Omega) for reduced in bodies], axis=0)).imag
    return float(-error / slope)


def natural_shifts(reduced: Reduced, Omega: float) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Damped natural frequencies of the reduced body in its band, and how far those of the full body lie from them.

    A motion e^{i Psi t} decays if Im Psi > 0. With symmetric matrices alone a reduced body is as little unstable as the full one;
    skew ones can make a difference, which these shifts show.

    Returns
    -------
    Psi : (k,) complex, rad/s
        Rising by their real part.
    shift : (k,) complex, rad/s
        By one step of inverse iteration with the full matrices.
    """
    frequencies, modes = _damped(reduced.body, Omega)
    low, high = reduced.band
    inside = (frequencies.real >= low) & (frequencies.real <= high)
    frequencies, modes = frequencies[inside], modes[:, inside]
    shifts = np.empty(len(frequencies), complex)
    for i, Psi in enumerate(frequencies):
        x = reduced.basis @ modes[:, i]
        force = reduced.full.slope(Psi, Omega) @ x
        z = solutions(reduced.full, np.array([Psi]), np.array([Omega]), force[:, None])[0]
        shifts[i] = -(x @ force) / (force @ z)
    order = np.argsort(frequencies.real)
    return frequencies[order], shifts[order]


def _damped(body: Body, Omega: float):
    """All natural frequencies (2 r,) of a body of few coordinates and its modes (r, 2 r)."""
    zero = np.zeros_like(body.mass)
    terms = {"gyroscopic": zero, "skew_stiffness": zero, "skew_damping": zero} | body.terms
    damping = terms["damping"] + 1j * terms["skew_damping"] - 1j * Omega * terms["gyroscopic"]
    stiffness = terms["stiffness"] + 1j * terms["skew_stiffness"]
    r = body.n_coordinates
    lower = np.linalg.solve(body.mass, np.hstack([-stiffness, -damping]))
    values, vectors = scipy.linalg.eig(np.block([[zero, np.eye(r)], [lower]]))
    return -1j * values, vectors[:r]
