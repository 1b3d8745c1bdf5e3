"""Free vibrations of the rotor without contact: damped natural frequencies and logarithmic decrements at a rotor speed.

In complex form M r'' + (B + i Q - i Omega G) r' + (K + i S) r + C conj(r') + E conj(r) = 0. Where all directions are alike (no C,
no E) every eigenvalue is a circular motion, forward or backward by its sign. Where they are not, the equations of y and z, twice
as many, are solved; a vibration is an ellipse.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.paper.receptance import in_both_directions
from rsc.system.blas import one_thread
from rsc.system.system import System

_TWO_PI = 2.0 * np.pi
_FREE = 1e-7  # of the fastest motion: an eigenvalue 0, which is double where nothing damps it and then comes out so inaccurate
_UNDAMPED = 1e-13  # of the fastest motion: a growth rate that is the rounding of it


@dataclass(frozen=True, eq=False)
class FreeVibration:
    """One free vibration of the rotor; real motion r = (shape e^{i w t} + mirror_shape e^{-i w t}) e^{growth_rate t}.

    frequency : float Hz, damped, w/2 pi; negative: backward; of an ellipse its larger circle
    growth_rate : float, 1/s; negative: it dies away
    shape, mirror_shape : (N,) complex, at frequency and at its negative (zero where all directions are alike); scaled to a
        kinetic energy, |shape|_M, of 1
    """

    frequency: float
    growth_rate: float
    shape: NDArray[np.complex128]
    mirror_shape: NDArray[np.complex128]

    @property
    def decrement(self) -> float:
        """Logarithmic decrement -2 pi Re(lambda)/|Im(lambda)|; infinite, with its sign, where nothing oscillates."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return float(-np.float64(self.growth_rate) / abs(self.frequency))


@one_thread
def free_vibrations(system: System, speed: float) -> list[FreeVibration]:
    """Find the free vibrations of the rotor, without contact, at one rotor speed.

    Parameters
    ----------
    system : System
        Exact also where directions differ.
    speed : float, Hz

    Returns
    -------
    list of FreeVibration
        2 N of them, by rising frequency; where directions differ each that does not oscillate counts for half a one.
    """
    values, vectors = np.linalg.eig(state_matrix(*rotor_matrices(system, _TWO_PI * float(speed))))
    n, vibrations = system.n_rotor, []
    for value, vector in zip(values, vectors.T, strict=True):
        if len(values) == 2 * n:
            vibrations.append(_vibration(system, value, vector[:n], np.zeros(n)))
        elif value.imag >= 0.0:  # of the real equations: with its conjugate one real motion y, z
            y, z = vector[:n], vector[n : 2 * n]
            vibrations.append(_vibration(system, value, y + 1j * z, y.conj() + 1j * z.conj()))
    return sorted(vibrations, key=lambda vibration: vibration.frequency)


def _vibration(system, value, shape, mirror):
    sizes = [np.sqrt((part.conj() @ system.mass_r @ part).real) for part in (shape, mirror)]
    if sizes[1] > sizes[0]:
        value, shape, mirror, sizes = value.conjugate(), mirror, shape, sizes[::-1]
    return FreeVibration(float(value.imag) / _TWO_PI, float(value.real), shape / sizes[0], mirror / sizes[0])


def free_growth(system: System, Omega: float) -> float:
    """Largest growth rate of the free vibrations of rotor and stator without contact, 1/s; Omega in rad/s. 0 where the least
    stable is a motion that nothing opposes, or that nothing damps."""
    bodies = [rotor_matrices(system, Omega)]
    if system.n_stator:
        bodies.append(_body(system.mass_s, system.damping_s, system.stiffness_s, system.skew_damping_s, system.skew_stiffness_s,
                            system.anisotropic_damping_s, system.anisotropic_stiffness_s))  # fmt: skip
    values = np.concatenate([np.linalg.eigvals(state_matrix(*body)) for body in bodies])
    fastest = values[values.real.argmax()]
    largest = np.abs(values).max()
    return 0.0 if abs(fastest) <= _FREE * largest or abs(fastest.real) <= _UNDAMPED * largest else float(fastest.real)


def rotor_matrices(system, Omega):
    """Mass, damping with gyroscopics and stiffness of the rotor at Omega, rad/s: (N, N) complex, or (2 N, 2 N) of [y, z] where
    directions differ."""
    damping = system.damping_r - 1j * Omega * system.gyroscopic_r
    return _body(system.mass_r, damping, system.stiffness_r, system.skew_damping_r, system.skew_stiffness_r,
                 system.anisotropic_damping_r, system.anisotropic_stiffness_r)  # fmt: skip


def _body(mass, damping, stiffness, skew_damping, skew_stiffness, anisotropic_damping, anisotropic_stiffness):
    """Mass, damping and stiffness of one body, complex; real and of [y, z] where its directions differ."""
    damping = damping if skew_damping is None else damping + 1j * skew_damping
    stiffness = stiffness if skew_stiffness is None else stiffness + 1j * skew_stiffness
    if not _anisotropic(anisotropic_damping, anisotropic_stiffness):
        return mass, damping, stiffness
    pairs = (mass, None), (damping, anisotropic_damping), (stiffness, anisotropic_stiffness)
    return tuple(in_both_directions(*pair) for pair in pairs)


def _anisotropic(*parts):
    return any(part is not None and part.any() for part in parts)


def state_matrix(mass, damping, stiffness):
    """Matrix of [r, r'] of M r'' + D r' + K r = 0."""
    n = len(mass)
    lower = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    return np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])
