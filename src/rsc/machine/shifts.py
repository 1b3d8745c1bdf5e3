"""How far whirls of a reduced body lie from those of the full one: one full solution for each.

The reduced body's error of the receptance is not bounded but computed: the full dynamic stiffness is solved where it matters.
"""

from collections.abc import Sequence

import numpy as np

from rsc.machine.body import slope, solutions
from rsc.machine.reduction import Reduced


def receptance_error(reduced: Reduced, Psi: float, Omega: float) -> tuple[complex, complex]:
    """(H - H_r, dH/dPsi) of the contact at a frequency and a rotor speed in rad/s, in m/N and m s/N."""
    at = np.array([Psi]), np.array([Omega])
    x, y = (solutions(body, *at, body.inputs[:, :1])[0] for body in (reduced.full, reduced.body))
    moved = -x @ (slope(reduced.full, Psi, Omega) @ x)
    return complex(reduced.full.contact @ x - reduced.body.contact @ y), complex(moved)


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
