"""Real modes of rotor or stator alone, in which the stiffness is diagonal; every coordinate is a length.

The modes of each body are normalised to the mass of its contact coordinate. They are refined in extended precision, where
available, and rounded once at the end: errors of the eigensolver, relative to the highest frequency, would otherwise perturb the
low modes by much more than rounding.
"""

from dataclasses import dataclass

import numpy as np
import scipy

# off-diagonal entries below this fraction of the diagonal are rounding, not physics
ROUNDING = 1e-12
# number of corrections of the modes (each squares the error), and the largest entry of a valid correction
REFINEMENTS, LARGE_TURN = 2, 1e-3


@dataclass(frozen=True)
class RealModes:
    """Real modes of one body: r = shape @ x, every x a length; x = inverse @ r."""

    shape: np.ndarray  # (n, n)
    inverse: np.ndarray  # (n, n)
    stiffness: np.ndarray  # (n,) omega^2, 1/s^2
    reference_mass: float  # kg

    def rounded(self):
        """These modes in double precision."""
        parts = (np.asarray(part, dtype=float) for part in (self.shape, self.inverse, self.stiffness))
        return RealModes(*parts, self.reference_mass)


def modes_of(mass, stiffness, contact):
    """Modes of one body, normalised to the reference mass; diagonal matrices keep their coordinates."""
    n = mass.shape[0]
    if n == 0:
        return RealModes(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0), 1.0)
    if n == 1:  # the usual case in ensembles of small scenes
        return RealModes(np.ones((1, 1)), np.ones((1, 1)), stiffness[0] / mass[0], float(mass[0, 0]))
    c = int(contact.argmax())
    reference = float(mass[c, c])
    relative = mass / reference
    if _is_diagonal(mass) and _is_diagonal(stiffness):
        shape = np.diag(1.0 / np.sqrt(relative.diagonal()))
        omega2 = stiffness.diagonal() / mass.diagonal()
    else:
        omega2, shape = _refined(stiffness / reference, relative, scipy.linalg.eigh(stiffness / reference, relative)[1])
        # the zero of a rigid-body mode is computed as rounding of either sign
        omega2 = np.where(np.abs(omega2) < ROUNDING * np.abs(omega2).max(), 0.0, omega2)
    return RealModes(shape, shape.T @ relative, omega2, reference)


def with_mass(modes, mass):
    """The same modes normalised to another mass in kg."""
    size = np.sqrt(mass / modes.reference_mass)
    return RealModes(modes.shape * size, modes.inverse / size, modes.stiffness, mass)


def _refined(stiffness, mass, shape):
    """(omega^2, modes) in extended precision, from modes in double precision.

    With R = 1 - X^T M X and S = X^T K X the correction X E, E_ij = (S_ij + w_j R_ij)/(w_j - w_i), E_ii = R_ii/2, squares the
    error (Ogita and Aishima 2018). For modes so close that E_ij would be large any linear combination is as good: they are only
    made orthogonal, by E_ij = R_ij/2.
    """
    stiffness, mass, shape = (matrix.astype(np.longdouble) for matrix in (stiffness, mass, shape))
    for _ in range(REFINEMENTS):
        missing = np.eye(len(mass)) - shape.T @ mass @ shape
        energy = shape.T @ stiffness @ shape
        omega2 = energy.diagonal() / (1.0 - missing.diagonal())
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = (energy + omega2 * missing) / (omega2 - omega2[:, None])
        small = np.abs(turn) < LARGE_TURN  # false on the diagonal, which is infinite or NaN
        shape = shape + shape @ np.where(small, turn, 0.5 * missing)
    return omega2, shape


def _is_diagonal(matrix):
    return np.count_nonzero(matrix) == np.count_nonzero(matrix.diagonal())
