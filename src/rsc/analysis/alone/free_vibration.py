"""Free vibrations of the rotor without contact: damped natural frequencies and logarithmic decrements at a rotor speed.

In complex form M r'' + (B + i Q - i Omega G) r' + (K + i S) r + C conj(r') + E conj(r) = 0. Where all directions are alike (no C,
no E) every eigenvalue is a circular motion, forward or backward by its sign. Where they are not, the equations of y and z, twice
as many, are solved; a vibration is an ellipse.
"""

import itertools
from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np
import scipy
from numpy.typing import NDArray

from rsc.analysis.paper.receptance import in_both_directions
from rsc.analysis.paper.states import first_order
from rsc.system.blas import one_thread
from rsc.system.body import Body
from rsc.system.system import FloatOrArray, System

_FREE = 1e-7  # of the fastest motion: an eigenvalue 0, which is double where nothing damps it and then comes out so inaccurate
_SPEEDS = 290  # between a thousandth and a hundred times the largest natural frequency, 4 % apart
_STRAIGHT = 1e-6  # difference of both circles of an ellipse over their sum, below which it has no sense
_ALIKE = 1e-8  # difference of two eigenvalues over their size, below which they are one
_UNDAMPED = 1e-13  # of the fastest motion: a growth rate that is the rounding of it


@dataclass(frozen=True, eq=False)
class FreeVibration:
    """One free vibration of the rotor; real motion r = (shape e^{i w t} + mirror_shape e^{-i w t}) e^{growth_rate t}.

    frequency : float Hz, damped, w/2 pi; negative: backward; of an ellipse its larger circle, of a straight line positive
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
        2 N of them, by rising frequency, and one more for each first-order state; where directions differ each that does not
        oscillate counts for half a one.
    """
    return vibrations_of(system.rotor, speed)


def vibrations_of(body: Body, speed: float) -> list[FreeVibration]:
    """`free_vibrations` of any body that has coordinates."""
    matrices = matrices_of(body, TWO_PI * float(speed))
    values, vectors = np.linalg.eig(first_order(body, *matrices))
    n = body.n_coordinates
    if len(matrices[0]) == n:
        none = np.zeros(n)
        vibrations = [_vibration(body.mass, value, vector[:n], none) for value, vector in zip(values, vectors.T, strict=True)]
    else:  # of the real equations: an eigenvalue with its conjugate is one real motion y, z
        half = values.imag >= 0.0
        circles = np.vstack([vectors[:n] + 1j * vectors[n : 2 * n], vectors[:n] - 1j * vectors[n : 2 * n]])[:, half]
        own = zip(values[half], _separated(body.mass, values[half], circles).T, strict=True)
        vibrations = [_vibration(body.mass, value, circle[:n], circle[n:].conj()) for value, circle in own]
    return sorted(vibrations, key=lambda vibration: vibration.frequency)


def _separated(mass, values, circles):
    """Ellipses as columns of circles forward and backward (2 N, v), those of one frequency as circular as they can be: of a rotor
    with unequal directions that some of its modes do not feel, any mixture of two circles is a mode of these.

    They are the stationary ones of the energy forward less that backward over the sum of both.
    """
    circles, single = circles.copy(), np.ones(len(values), bool)
    weighted = np.vstack([mass @ part for part in np.split(circles, 2)])
    for i in np.flatnonzero(values.imag > 0.0):
        if single[i]:
            alike = np.flatnonzero(np.abs(values - values[i]) <= _ALIKE * abs(values[i]))
            single[alike] = False
            if len(alike) > 1:
                own, other = (np.split(part[:, alike], 2) for part in (circles, weighted))
                forward, backward = (one.conj().T @ two for one, two in zip(own, other, strict=True))
                circles[:, alike] = circles[:, alike] @ scipy.linalg.eigh(forward - backward, forward + backward)[1]
    return circles


def _vibration(mass, value, shape, mirror):
    sizes = [np.sqrt((part.conj() @ mass @ part).real) for part in (shape, mirror)]
    if max(sizes) == 0.0:  # of first-order states alone, without motion
        return FreeVibration(float(value.imag) / TWO_PI, float(value.real), shape, mirror)
    if sizes[1] - sizes[0] > _STRAIGHT * (sizes[0] + sizes[1]):
        value, shape, mirror, sizes = value.conjugate(), mirror, shape, sizes[::-1]
    return FreeVibration(float(value.imag) / TWO_PI, float(value.real), shape / sizes[0], mirror / sizes[0])


def free_growth(system: System, Omega: float) -> float:
    """Largest growth rate of the free vibrations of rotor and stator without contact, 1/s; Omega in rad/s. 0 where the least
    stable is a motion that nothing opposes, or that nothing damps."""
    bodies = [body for body in system.bodies if body.n_coordinates]
    values = np.concatenate([np.linalg.eigvals(first_order(body, *matrices_of(body, Omega))) for body in bodies])
    fastest = values[values.real.argmax()]
    largest = np.abs(values).max()
    return 0.0 if abs(fastest) <= _FREE * largest or abs(fastest.real) <= _UNDAMPED * largest else float(fastest.real)


def threshold_speed(system: System) -> float:
    """Lowest rotor speed in rad/s at which the rotor, turning forward without contact, becomes unstable.

    Returns
    -------
    float
        0 for a rotor that is unstable at standstill, infinite for one that is stable up to a hundred times the largest of its
        natural frequencies. A range of instability narrower than a 25th of its speed may be missed.
    """
    knots = system.knot_speed[system.knot_speed > 0.0]
    bodies = [system.rotor.at_speed(Omega) for Omega in (0.0, *knots)]
    squares = [np.linalg.eigvals(np.linalg.solve(body.mass, body.stiffness)) for body in bodies]
    largest = float(np.sqrt(np.abs(squares).max(initial=0.0)))
    grid = np.concatenate([[0.0], largest * np.geomspace(1e-3, 1e2, _SPEEDS)]) if largest else np.zeros(1)
    grid = np.union1d(grid, knots)

    def growth(Omega: FloatOrArray):
        return float(np.linalg.eigvals(first_order(system.rotor, *rotor_matrices(system, Omega))).real.max())

    if growth(0.0) > _UNDAMPED * largest:
        return 0.0
    for low, high in itertools.pairwise(grid):
        if growth(high) > _UNDAMPED * largest:
            if growth(low) >= 0.0:
                return float(low)
            return float(scipy.optimize.brentq(growth, low, high, xtol=1e-13 * high, rtol=1e-13))
    return np.inf


def rotor_matrices(system: System, Omega: FloatOrArray):
    """Mass, damping with gyroscopics and stiffness of the rotor at Omega, rad/s: (N, N) complex, or (2 N, 2 N) of [y, z] where
    directions differ."""
    return matrices_of(system.rotor, Omega)


def matrices_of(body, Omega: FloatOrArray):
    """Mass, damping with gyroscopics and stiffness of one body, complex; real and of [y, z] where its directions differ."""
    body = body.at_speed(Omega).without_states()
    damping = body.damping - 1j * Omega * body.gyroscopic
    damping = damping if body.skew_damping is None else damping + 1j * body.skew_damping
    if not _anisotropic(body.anisotropic_damping, body.anisotropic_stiffness):
        return body.mass, damping, body.static
    pairs = (body.mass, None), (damping, body.anisotropic_damping), (body.static, body.anisotropic_stiffness)
    return tuple(in_both_directions(*pair) for pair in pairs)


def _anisotropic(*parts):
    return any(part is not None and part.any() for part in parts)
