"""Supports whose coefficients depend on the frequency of the vibration, fitted by a rational function: first-order states.

The dynamic stiffness D(s) = k + s c at s = i omega is fitted by

    D(s) = d + h s + sum_j r_j / (s - a_j),   Re a_j <= 0, h >= 0,

with real coefficients: vector fitting, B. Gustavsen and A. Semlyen, "Rational approximation of frequency domain responses by
vector fitting", IEEE Transactions on Power Delivery 14 (1999) 1052-1061, weighted by 1/|D|. A pole that leaves the left half
plane is mirrored into it. The poles are the eigenvalues of Az of `[rotor.states]`, driven by the velocity of the support, so that
the stiffness beside them is the static one; those that are much slower than the table (an integrator) by its displacement.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray

from rsc.errors import DataError

TOLERANCE, MOST_STATES = 1e-3, 8
FARTHEST = 0.1  # error of a fit that describes nothing
_ROUNDS = 30  # in which poles move
_LEAST = 0.01  # of the largest |D|: smaller ones count as this
_NEARLY = 1.2  # times the least error: with fewer states it is taken
_SLOW = 1e-3  # of the lowest frequency: slower poles are those of an integrator
_BEYOND, _GRID = 100.0, 2000  # how far beyond the table, and at how many frequencies, damping is looked at
Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SupportStates:
    """A support with first-order states z, alike in both directions: the force -k r - c r' + Lz z on its place, with
    z' = Az z + Bz r + Bv r' from the displacement r there.

    stiffness, damping : float, k in N/m and c >= 0 in N s/m
    matrix : (p, p) Az, 1/s; displacement, velocity : (p,) Bz and Bv; force : (p,) Lz
    error : float, largest |D - D of the table| over |D|, where |D| counts as at least a hundredth of its largest value
    low, high : float Hz, of the table: beyond it nothing is known
    driving : float Hz or None, where the fit has the most negative damping although the table has none
    """

    stiffness: float
    damping: float
    matrix: Floats
    displacement: Floats
    velocity: Floats
    force: Floats
    error: float
    low: float
    high: float
    driving: float | None = None

    def dynamic_stiffness(self, frequency: ArrayLike) -> Complex:
        """D = k(f) + 2 pi i f c(f), N/m, at frequencies in Hz (array or number)."""
        s = 2j * np.pi * np.asarray(frequency, dtype=float)
        driven = self.displacement + s[..., None] * self.velocity
        z = np.linalg.solve(s[..., None, None] * np.eye(len(self.matrix)) - self.matrix, driven[..., None])[..., 0]
        return np.asarray(self.stiffness + s * self.damping - z @ self.force)

    def states(self, coordinate: int = 0, n_coordinates: int = 1) -> dict[str, Any]:
        """The table `states` of a body with `n_coordinates`, with the support at `coordinate`; stiffness and damping are given
        separately."""
        at = np.eye(n_coordinates)[coordinate]
        driven = {name: np.outer(getattr(self, name), at).tolist() for name in ("displacement", "velocity")}
        return {"matrix": self.matrix.tolist(), **driven, "force": np.outer(at, self.force).tolist()}


def fit_states(
    frequency: ArrayLike,
    stiffness: ArrayLike,
    damping: ArrayLike | None = None,
    *,
    tolerance: float = TOLERANCE,
    most: int = MOST_STATES,
) -> SupportStates:
    """Fit coefficients over the frequency of the vibration by as few first-order states as meet a tolerance.

    Parameters
    ----------
    frequency : (m,) Hz, >= 0, all different
    stiffness : (m,) N/m
    damping : (m,) N s/m, default: none
    tolerance : float, wanted `error`; where it cannot be met the fewest states whose error is next to the least
    most : int, largest number of states

    Returns
    -------
    SupportStates
        Its `error` is that of the table, whatever the tolerance.

    Raises
    ------
    DataError
        Not such arrays, or no fit within `FARTHEST`.

    Examples
    --------
    >>> f = np.linspace(1.0, 200.0, 40)  # an elastomer ring: a spring beside a spring and a dashpot in series
    >>> D = 1e6 + 2e5 * 2j * np.pi * f / (2j * np.pi * f + 300.0)
    >>> fit = fit_states(f, D.real, D.imag / (2.0 * np.pi * f))
    >>> print(f"{fit.stiffness:.0f} N/m, {fit.force[0]:.0f} N/m, {fit.matrix[0, 0]:.0f} 1/s")
    1000000 N/m, -200000 N/m, -300 1/s
    """
    f, D = _checked(frequency, stiffness, damping)
    unit, size = float(np.sqrt(f[f > 0.0].min() * f.max())) * 2.0 * np.pi, float(np.abs(D).max())
    s, scaled = np.asarray(2j * np.pi * f / unit), np.asarray(D / size)
    tried: list[_Sum] = []
    for order in range(min(most, len(f) - 1) + 1):
        tried += [made for damped in (False, True) if (made := _fitted(s, scaled, order, damped)) is not None]
        if min((one.error for one in tried), default=np.inf) <= tolerance:
            break
    least = min((one.error for one in tried), default=np.inf)
    if not least <= FARTHEST:
        off = f"off by {100.0 * least:.0f} %, more than {100.0 * FARTHEST:g} %"
        problem = f"with {most} stable states the fit of its coefficients is {off}"
        raise DataError("support", problem)
    chosen = next(one for one in tried if one.error <= max(tolerance, _NEARLY * least))
    return _realised(chosen, unit, size, f, D)


def joined_states(supports: Sequence[tuple[Any, SupportStates]]) -> dict[str, Any]:
    """The table `states` of a machine with supports at places, each its own sensor and actuator."""
    places = [place for place, _ in supports]
    blocks = {name: [getattr(fit, name)[:, None] for _, fit in supports] for name in ("displacement", "velocity")}
    made = {name: scipy.linalg.block_diag(*parts) for name, parts in blocks.items()}
    matrix = scipy.linalg.block_diag(*(fit.matrix for _, fit in supports))
    force = scipy.linalg.block_diag(*(fit.force[None] for _, fit in supports))
    return {"sensors": places, "actuators": places, "matrix": matrix, **made, "force": force}


@dataclass(frozen=True, eq=False)
class _Sum:
    """Poles, conjugate ones next to each other, the coefficients of their basis, d and h, and the error."""

    poles: Complex
    residues: Floats
    d: float
    h: float
    error: float


def _checked(frequency: ArrayLike, stiffness: ArrayLike, damping: ArrayLike | None) -> tuple[Floats, Complex]:
    try:
        f, k = np.asarray(frequency, dtype=float), np.asarray(stiffness, dtype=float)
        c = np.zeros_like(k) if damping is None else np.asarray(damping, dtype=float)
    except (TypeError, ValueError):
        raise DataError("support", "frequencies, stiffness and damping must be numbers") from None
    if f.ndim != 1 or not len(f) or not f.shape == k.shape == c.shape:
        raise DataError("support", "frequencies, stiffness and damping must be lists of one length")
    if not (np.isfinite(f).all() and np.isfinite(k).all() and np.isfinite(c).all()):
        raise DataError("support", "frequencies, stiffness and damping must be finite")
    if f.min() < 0.0 or f.max() == 0.0 or len(np.unique(f)) < len(f):
        raise DataError("support", "frequencies must be different, and not negative")
    order = np.argsort(f)
    D = (k + 2j * np.pi * f * c)[order]
    if not np.abs(D).max() > 0.0:
        raise DataError("support", "its coefficients are all zero")
    return f[order], D


def _basis(poles: Complex, s: Complex) -> Complex:
    """(m, n): 1/(s - a) of a real pole; of a pair 1/(s - a) + 1/(s - a*) and i/(s - a) - i/(s - a*), with real coefficients."""
    columns, i = [], 0
    while i < len(poles):
        one = 1.0 / (s - poles[i])
        if poles[i].imag == 0.0:
            columns.append(one)
            i += 1
        else:
            other = 1.0 / (s - poles[i].conj())
            columns += [one + other, 1j * (one - other)]
            i += 2
    return np.array(columns).reshape(len(poles), len(s)).T


def _blocks(poles: Complex) -> tuple[Floats, Floats]:
    """Real A and b with 1 (sI - A)^-1 b the basis: its coefficients c give c (sI - A)^-1 b."""
    blocks, b, i = [], [], 0
    while i < len(poles):
        a = poles[i]
        if a.imag == 0.0:
            blocks.append(np.array([[a.real]]))
            b.append(1.0)
            i += 1
        else:
            blocks.append(np.array([[a.real, a.imag], [-a.imag, a.real]]))
            b += [2.0, 0.0]
            i += 2
    return np.asarray(scipy.linalg.block_diag(*blocks)).reshape(len(poles), len(poles)), np.array(b)


def _least_squares(columns: Complex, wanted: Complex, weight: Floats) -> Floats:
    """Real coefficients of columns (m, n) next to values (m,)."""
    rows = np.vstack([(weight[:, None] * columns).real, (weight[:, None] * columns).imag])
    values = np.concatenate([weight * wanted.real, weight * wanted.imag])
    size = np.linalg.norm(rows, axis=0)
    size[size == 0.0] = 1.0
    return np.asarray(np.linalg.lstsq(rows / size, values, rcond=None)[0] / size)


def _rest(s: Complex, damped: bool) -> Complex:
    return np.column_stack([np.ones_like(s), s] if damped else [np.ones_like(s)])


def _moved(poles: Complex, s: Complex, D: Complex, weight: Floats, damped: bool) -> Complex:
    """Poles after one round, in the left half plane."""
    basis = _basis(poles, s)
    own = _least_squares(np.hstack([basis, _rest(s, damped), -D[:, None] * basis]), D, weight)[-len(poles) :]
    A, b = _blocks(poles)
    moved = np.linalg.eigvals(A - np.outer(b, own)).astype(complex)
    moved = -np.abs(moved.real) + 1j * moved.imag
    pairs = moved[moved.imag > 0.0]
    return np.concatenate([moved[moved.imag == 0.0], np.column_stack([pairs, pairs.conj()]).ravel()])


def _fitted(s: Complex, D: Complex, order: int, damped: bool) -> _Sum | None:
    """The best sum of an order, with h or without, from two sets of poles to begin with; None where h would be negative."""
    weight = 1.0 / np.maximum(np.abs(D), _LEAST * np.abs(D).max())
    known = np.abs(s[s != 0.0])
    spread = np.geomspace(known.min(), known.max(), max(order, 2))[:order]
    beta = np.geomspace(known.min(), known.max(), max(order // 2, 2))[: order // 2]
    pairs = np.column_stack([-0.01 * beta + 1j * beta, -0.01 * beta - 1j * beta]).ravel()
    best = None
    for begin in (-spread.astype(complex), np.concatenate([-spread[: order % 2].astype(complex), pairs])):
        poles = begin
        for _ in range(_ROUNDS if order else 1):
            if order:
                poles = _moved(poles, s, D, weight, damped)
            columns = np.hstack([_basis(poles, s), _rest(s, damped)])
            values = _least_squares(columns, D, weight)
            error = float((weight * np.abs(columns @ values - D)).max())
            h = float(values[-1]) if damped else 0.0
            if h >= 0.0 and (best is None or error < best.error):
                best = _Sum(poles, values[:order], float(values[order]), h, error)
    return best


def _realised(best: _Sum, unit: float, size: float, f: Floats, D: Complex) -> SupportStates:
    """The states of a sum in units: of s, rad/s, and of D, N/m."""
    A, b = _blocks(best.poles * unit)
    C, k = best.residues * size * unit, best.d * size
    p = len(b)
    slow = np.abs(best.poles) * unit < _SLOW * 2.0 * np.pi * f[f > 0.0].min()
    fast = ~slow
    force, displacement, velocity = -C.copy(), np.where(slow, b, 0.0), np.where(fast, b, 0.0)
    if fast.any():
        by_velocity = np.linalg.solve(A[np.ix_(fast, fast)].T, C[fast])
        force[fast] = -by_velocity
        k -= float(by_velocity @ b[fast])
    made = (k, best.h * size / unit, A.reshape(p, p), displacement, velocity, force)
    fit = SupportStates(*made, best.error, float(f.min()), float(f.max()))
    grid = np.geomspace(f[f > 0.0].min() / _BEYOND, f.max() * _BEYOND, _GRID)
    loss = fit.dynamic_stiffness(grid).imag / np.abs(fit.dynamic_stiffness(grid))
    if D.imag.min() < 0.0 or loss.min() >= -best.error - 1e-9:
        return fit
    return SupportStates(*made, fit.error, fit.low, fit.high, float(grid[loss.argmin()]))
