"""Bodies that nothing holds, or next to nothing: the shift of their stiffness, and their slow motions.

K is singular for a body with rigid-body motions, and useless if its bearings are too soft: a force then moves the whole body, and
rounding hides how it bends. Solutions of K + w^2 M are used instead, those for a force that grows like e^{w t}. The slow motions
themselves are kept in the reduced body, exactly, and receptances are compared from a lowest frequency on.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse.linalg
from numpy.typing import NDArray

from rsc.errors import ReductionError
from rsc.machine.reduction.body import ADVICE, by_parts, static_solver
from rsc.machine.reduction.feedback import growing
from rsc.system.body import Body, Matrix

FloatArray = NDArray[np.float64]

# relative to the highest frequency of the band: natural frequency below which a body counts as not held, w of the shift, and the
# lowest frequency at which receptances are compared
SOFT, SHIFTED, LEAST = 1e-3, 0.05, 2e-3
_MOTIONS, _ITERATIONS = 8, 16  # of the subspace iteration for the slow motions
_INDEFINITE = -1e-6  # w^2 of a motion relative to that of the shift


class Shift(NamedTuple):
    """square: w^2 in (rad/s)^2, 0 for a body that is held; least: lowest frequency that is compared, rad/s; 0 for one that is
    held and has no first-order states, since integrators have no finite response at 0."""

    square: float
    least: float

    def stiffness(self, body: Body) -> Matrix:
        """K + w^2 M, or K itself if the body is held."""
        return body.stiffness + self.square * body.mass if self.square else body.stiffness

    def off_zero(self, frequencies: Any) -> Any:
        """Frequencies in rad/s, those below the lowest one moved to it."""
        if not self.least:
            return frequencies
        return np.where(np.abs(frequencies) < self.least, np.copysign(self.least, frequencies), frequencies)

    @property
    def loading(self) -> float:
        """The frequency at which the constant load is compared, rad/s."""
        return float(np.sqrt(self.square)) or self.least


HELD = Shift(0.0, 0.0)


def shift_of(body: Body, reach: float) -> Shift:
    """The shift for a body and a band up to `reach` in rad/s: none if a static force at a contact does not move it like a body
    that is hardly held."""
    shift = Shift((SHIFTED * reach) ** 2, LEAST * reach)
    held = Shift(0.0, shift.least) if body.n_states else HELD
    try:
        static = static_solver(body)(np.atleast_2d(body.contact).T)
    except ReductionError:
        return shift if reach else held
    square = np.einsum("ij,ij->j", np.atleast_2d(body.contact).T, static) / np.einsum("ij,ij->j", static, body.mass @ static)
    return shift if square.min() < (SOFT * reach) ** 2 else held


def shifted_solver(body: Body, shift: Shift) -> Callable[[NDArray[Any]], NDArray[Any]]:
    """Function (n, k) -> (K + w^2 M)^-1 (n, k).

    Raises
    ------
    ReductionError
        The body buckles, or has a motion without stiffness and mass.
    """
    return static_solver(replace(body, stiffness=shift.stiffness(body)) if shift.square else body)


def loop_solver(body: Body, reach: float) -> Callable[[NDArray[Any]], NDArray[Any]]:
    """Function (n, k) -> A^-1 (n, k) of a body with first-order states, for forces that grow like e^{w t} with w of the shift.

    Raises
    ------
    ReductionError
        Its controller resonates with just that growth.
    """
    rate = SHIFTED * reach
    matrix = growing(body, rate, Shift(rate**2, 0.0).stiffness(body))
    try:
        if scipy.sparse.issparse(matrix):
            return by_parts(scipy.sparse.linalg.splu(scipy.sparse.csc_array(matrix)).solve)
        inverse = np.linalg.inv(matrix)
    except (np.linalg.LinAlgError, RuntimeError):
        raise ReductionError(f"its first-order states let it grow at {rate:.4g} 1/s") from None
    return lambda columns: inverse @ columns


def slow_motions(body: Body, static: Callable[[NDArray[Any]], NDArray[Any]], shift: Shift) -> FloatArray:
    """(n, k) motions of a body, without gyroscopic effects and damping, that are slower than `Shift.least`.

    Raises
    ------
    ReductionError
        The stiffness is indefinite.
    """
    count = min(_MOTIONS, body.n_coordinates)
    motions = np.random.default_rng(1).normal(size=(body.n_coordinates, count))
    for _ in range(_ITERATIONS):
        motions = np.linalg.qr(static(body.mass @ motions))[0]
    whole, heavy = motions.T @ (shift.stiffness(body) @ motions), motions.T @ (body.mass @ motions)
    shares, turn = scipy.linalg.eigh(0.5 * (heavy + heavy.T), 0.5 * (whole + whole.T))  # 1/(Psi^2 + w^2)
    slow = shares * (shift.least**2 + shift.square) > 1.0
    if (1.0 - shift.square * shares[slow] < _INDEFINITE).any():
        raise ReductionError(f"the stiffness is indefinite: {ADVICE}")
    return np.asarray(motions @ turn[:, slow])
