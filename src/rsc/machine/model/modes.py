"""Lowest modes of a finite-element model before any reduction."""

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


def slowest_modes(model: FiniteElementModel, speed: float, count: int) -> list[ModelMode]:
    """The modes of `slowest_shapes` without their vectors."""
    return [mode for mode, _ in slowest_shapes(model, speed, count)]


def slowest_shapes(model: FiniteElementModel, speed: float, count: int) -> list[tuple[ModelMode, Any]]:
    """The lowest modes of a model at a rotor speed in Hz, by |lambda|, lambda = growth_rate + 2 pi i frequency, each with its
    vector of the n coordinates z, or if anisotropic of z and its conjugate (2n).

    (M lambda^2 + D lambda + K) x = 0, with z alone or, if anisotropic, z and its conjugate as coordinates. All modes are computed
    for few coordinates, those next to 0 by inverse iteration (ARPACK) for many.

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
    values, vectors = _few(*matrices) if mass.shape[0] <= FEW else _many(model, matrices, 4 * count)
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


def _few(mass: Any, damping: Any, stiffness: Any) -> tuple[Any, Any]:
    """Finite eigenvalues and vectors of [z, z']; massless coordinates have infinite ones."""
    mass, damping, stiffness = (m.toarray() if scipy.sparse.issparse(m) else m for m in (mass, damping, stiffness))
    zero, one = np.zeros_like(mass), np.eye(len(mass))
    values, vectors = scipy.linalg.eig(np.block([[zero, one], [-stiffness, -damping]]), np.block([[one, zero], [zero, mass]]))
    return values[np.isfinite(values)], vectors[:, np.isfinite(values)]


def _many(model: FiniteElementModel, matrices: Any, count: int) -> tuple[Any, Any]:
    mass, damping, stiffness = (scipy.sparse.csc_array(matrix) for matrix in matrices)
    size = mass.shape[0]
    typical = np.sqrt(np.median(np.abs(stiffness.diagonal())) / np.median(np.abs(mass.diagonal())[mass.diagonal() != 0.0]))
    one = scipy.sparse.eye_array(size, format="csc")
    left = scipy.sparse.block_array([[None, one], [-stiffness, -damping]], format="csc")
    right = scipy.sparse.block_array([[one, None], [None, mass]], format="csc")
    try:
        start = np.random.default_rng(0).standard_normal(2 * size)  # reproducible
        return scipy.sparse.linalg.eigs(left, count, right, sigma=_SHIFT * typical, v0=start)
    except (scipy.sparse.linalg.ArpackError, RuntimeError) as error:
        raise DataError(model.source, f"the eigenvalue iteration failed: {error}") from None
