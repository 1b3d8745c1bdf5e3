"""Lowest modes of a finite-element model before any reduction, alone or in the closed loop of its first-order states."""

from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg

from rsc.errors import DataError
from rsc.machine.model.model import FiniteElementModel

FEW = 300  # number of coordinates up to which all modes are computed
_STILL = 1e-6  # relative to |lambda|: smaller imaginary parts are rounding
_STRAIGHT = 1e-6  # difference of both circles of an ellipse, relative: a smaller one has no sense, and frequency > 0
_FREE = 1e-8  # of the fastest mode: what is slower is opposed by nothing but rounding
_SHIFT = 1e-3  # relative to a typical frequency: shift away from the zero eigenvalues of a free machine


class ModelMode(NamedTuple):
    """frequency : Hz, damped natural frequency, negative for backward; growth_rate : 1/s, negative if damped."""

    frequency: float
    growth_rate: float

    @property
    def decrement(self) -> float:
        """Logarithmic decrement; infinite, with its sign, without oscillation."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return float(-np.float64(self.growth_rate) / abs(self.frequency))


def slowest_modes(model: FiniteElementModel, speed: float, count: int, states: Any = None) -> list[ModelMode]:
    """The modes of `slowest_shapes` without their vectors."""
    return [mode for mode, _ in slowest_shapes(model, speed, count, states)]


def slowest_shapes(model: FiniteElementModel, speed: float, count: int, states: Any = None) -> list[tuple[ModelMode, Any]]:
    """The lowest modes of a model at a rotor speed in Hz, by |lambda|, lambda = growth_rate + 2 pi i frequency, each with its
    vector of the n coordinates z, or if anisotropic of z and its conjugate (2n).

    (M lambda^2 + D lambda + K) x = 0, with z alone or, if anisotropic, z and its conjugate as coordinates. All modes are computed
    for few coordinates, those next to 0 by inverse iteration (ARPACK) for many. states: None, or the arrays Az, Bz, Bv, Lz and
    stiffness of first-order states (`rsc.scene.bodies.states.StateMatrices`), whose own modes count as well.

    Raises
    ------
    DataError
        The iteration did not converge.
    """
    mass, damping, stiffness = model.with_conjugate(speed)
    n = model.n
    if model.isotropic:
        mass, damping, stiffness = (matrix[:n, :n] for matrix in (mass, damping, stiffness))
    matrices, modes = (mass, damping, stiffness), []
    loop = None if states is None else _looped(states, mass.shape[0] // n)
    values, vectors = _few(*matrices, loop) if mass.shape[0] <= FEW else _many(model, matrices, loop, 4 * count)
    for value, vector in zip(values, vectors.T, strict=True):
        frequency = float(value.imag) / (2.0 * np.pi)
        if abs(value.imag) <= _STILL * abs(value):
            frequency = 0.0
        elif not model.isotropic:
            if value.imag < 0.0:
                continue  # conjugate of another mode
            backward = np.linalg.norm(vector[:n]) < (1.0 - _STRAIGHT) * np.linalg.norm(vector[n : 2 * n])
            frequency = -frequency if backward else frequency
        modes.append((float(f"{abs(value):.6g}"), ModelMode(frequency, float(value.real)), vector[: mass.shape[0]]))
    return [(mode, vector) for _, mode, vector in sorted(modes, key=lambda one: one[:2])[:count]]


def _looped(states: Any, copies: int) -> tuple[Any, ...]:
    """(Az, Bz, Bv, Lz, stiffness) as sparse matrices, of z or of z and its conjugate."""
    parts = (states.matrix, states.displacement, states.velocity, states.force, states.stiffness)
    return tuple(scipy.sparse.csc_array(scipy.sparse.kron(np.eye(copies), part)) for part in parts)


def growth_in_loop(model: FiniteElementModel, speed: float, states: Any) -> ModelMode | None:
    """The mode of a small model in the loop of its states that grows fastest or decays slowest, but for motions that nothing
    opposes; None for a large model."""
    if model.n > FEW:
        return None
    modes = slowest_modes(model, speed, 6 * model.n, states)
    sizes = np.hypot([2.0 * np.pi * mode.frequency for mode in modes], [mode.growth_rate for mode in modes])
    moving = [mode for mode, size in zip(modes, sizes, strict=True) if size > _FREE * sizes.max()]
    return max(moving, key=lambda mode: mode.growth_rate)


def _few(mass: Any, damping: Any, stiffness: Any, loop: Any) -> tuple[Any, Any]:
    """Finite eigenvalues and vectors of [z, z', states]; massless coordinates have infinite ones."""
    mass, damping, stiffness = (scipy.sparse.csc_array(matrix) for matrix in (mass, damping, stiffness))
    left, right = (matrix.toarray() for matrix in _pencil(mass, damping, stiffness, loop))
    try:
        scipy.linalg.cholesky(mass.toarray())
    except np.linalg.LinAlgError:  # massless coordinates
        values, vectors = scipy.linalg.eig(left, right)
    else:  # one matrix is balanced, and its eigenvalues keep all digits
        values, vectors = np.linalg.eig(np.linalg.solve(right, left))
    return values[np.isfinite(values)], vectors[:, np.isfinite(values)]


def _pencil(mass: Any, damping: Any, stiffness: Any, loop: Any) -> tuple[Any, Any]:
    """Sparse matrices of left w = lambda right w for w = [z, z', states]."""
    one = scipy.sparse.eye_array(mass.shape[0], format="csc")
    if loop is None:
        left, right = [[None, one], [-stiffness, -damping]], [[one, None], [None, mass]]
    else:
        own, sensed, moved, force, more = loop
        left = [[None, one, None], [-stiffness - more, -damping, force], [sensed, moved, own]]
        right = [[one, None, None], [None, mass, None], [None, None, scipy.sparse.eye_array(own.shape[0], format="csc")]]
    return scipy.sparse.block_array(left, format="csc"), scipy.sparse.block_array(right, format="csc")


def _many(model: FiniteElementModel, matrices: Any, loop: Any, count: int) -> tuple[Any, Any]:
    mass, damping, stiffness = (scipy.sparse.csc_array(matrix) for matrix in matrices)
    typical = np.sqrt(np.median(np.abs(stiffness.diagonal())) / np.median(np.abs(mass.diagonal())[mass.diagonal() != 0.0]))
    left, right = _pencil(mass, damping, stiffness, loop)
    try:
        start = np.random.default_rng(0).standard_normal(left.shape[0])  # reproducible
        return scipy.sparse.linalg.eigs(left, count, right, sigma=_SHIFT * typical, v0=start)
    except (scipy.sparse.linalg.ArpackError, RuntimeError) as error:
        raise DataError(model.source, f"the eigenvalue iteration failed: {error}") from None
