"""Whether a rotor that moves without contact can touch again.

Between contacts rotor and stator are linear: their motion is the steady one, by unbalance and load, and a sum of free vibrations
a_k v_k e^{lambda_k t}. Where none of them grows, a contact with the vectors l stays open for good if

    max |d_steady| + sum_k |a_k| |l^T v_k| <= s.
"""

from collections.abc import Sequence
from math import tau as TWO_PI

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.at_rest import static_deflection
from rsc.analysis.alone.free_vibration import matrices_of
from rsc.analysis.paper.anisotropy import unbalance_ellipse
from rsc.analysis.paper.receptance import along
from rsc.analysis.paper.states import first_order
from rsc.system.blas import one_thread
from rsc.system.body import Body
from rsc.system.system import System

_GROWS = 1e-9  # of the fastest free vibration: a growth rate that is no rounding
_ALIKE = 1e13  # condition from which on eigenvectors are no longer told apart, as those of a motion that nothing opposes


class Clear:
    """The contacts of a machine at a constant speed, without first-order states or bearings that are switched off.

    Parameters
    ----------
    system : System
    Omega : float, rad/s

    Attributes
    ----------
    known : bool, whether the criterion can be applied: nothing grows, and the steady motion touches nowhere
    """

    def __init__(self, system: System, Omega: float) -> None:
        system = system.at_speed(Omega)
        self._Omega, self._steady = Omega, (static_deflection(system), *unbalance_ellipse(system, Omega))
        self.known = not (system.n_states or system.switched) and bool(np.isfinite(self._steady[0]).all())
        if not self.known:
            return
        contacts = system.contacts
        self._room = np.array([contact.gap - _reach(self._steady, contact) for contact in contacts])
        rows = [contact.rotor for contact in contacts], [contact.stator for contact in contacts]
        pairs = zip(system.bodies, rows, strict=True)
        self._modes = [_Modes(body, Omega, np.array(own)) for body, own in pairs if body.n_coordinates]
        self.known = bool((self._room > 0.0).all()) and all(modes.bounded for modes in self._modes)

    def stays(self, parts: Sequence[NDArray[np.complex128]], turns: float) -> bool:
        """Whether a motion never touches again; parts: displacements and velocities of the rotor and of the stator; turns: of the
        shaft."""
        (static, forward, backward), turn = self._steady, np.exp(1j * TWO_PI * turns)
        rotor, rotor_dot, stator, stator_dot = parts
        steady = static + forward * turn + backward / turn
        steady_dot = 1j * self._Omega * (forward * turn - backward / turn)
        own = [(rotor - steady, rotor_dot - steady_dot), (stator, stator_dot)]
        moved = sum(modes.bound(*each) for modes, each in zip(self._modes, own, strict=False))
        return bool((moved <= self._room).all())


def _reach(steady, contact):
    """Largest |d| in m of the steady motion at a contact."""
    mean, turning, mirror = (along(part, contact.rotor) for part in steady)
    return abs(mean - contact.offset) + abs(turning + contact.ring) + abs(mirror)


class _Modes:
    """The free vibrations of a body, as seen at some contacts, whose vectors are the rows (k, n)."""

    def __init__(self, body: Body, Omega: float, rows: NDArray[np.float64]) -> None:
        matrices = matrices_of(body, Omega)
        n = body.n_coordinates
        self._both = len(matrices[0]) > n
        values, vectors = one_thread(np.linalg.eig)(first_order(body, *matrices))
        grow = bool(values.real.max() > _GROWS * np.abs(values).max())
        shapes = vectors[:n] + 1j * vectors[n : 2 * n] if self._both else vectors[:n]
        self._seen = np.abs(rows @ shapes)
        self.bounded = not grow and bool(np.linalg.cond(vectors) < _ALIKE)
        self._inverse = np.linalg.inv(vectors) if self.bounded else vectors

    def bound(self, displacement: NDArray[np.complex128], velocity: NDArray[np.complex128]) -> NDArray[np.float64]:
        """The largest motion (k,) in m that a state may grow to at the contacts."""
        state = np.concatenate([displacement, velocity])
        if self._both:
            state = np.concatenate([displacement.real, displacement.imag, velocity.real, velocity.imag])
        return self._seen @ np.abs(self._inverse @ state)
