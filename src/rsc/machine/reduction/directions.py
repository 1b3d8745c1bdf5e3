"""Reduction of anisotropic bodies: refined until both coupled lines are within the tolerance.

A bearing stiffer in y than in z couples a line at Psi with its mirror line at -Psi. With r = x e^{i Psi t} + conj(z) e^{-i Psi t}

    [ A(Psi)                  E + i Psi C      ] [ x ]   [ input at Psi           ]
    [ conj(E) + i Psi conj(C) conj(A(-Psi))    ] [ z ] = [ conj of input at -Psi  ]

with the dynamic stiffness A of the isotropic mean (body.py). Motions of the machine may differ from all motions of the mean: a
bearing may be soft in one direction but not on average. So the basis that `reduce` finds for the mean is extended by solutions of
both lines where the reduced body is worst, and the remaining error is determined at points not used for the basis.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse
from numpy.typing import NDArray

from rsc.errors import ReductionError
from rsc.machine.reduction.body import (
    OFF_THE_POLE,
    ON_A_POLE,
    ComplexArray,
    FloatArray,
    checked,
    dynamic_stiffness,
    factored,
    n_contacts,
)
from rsc.machine.reduction.greedy import Basis, unmet
from rsc.machine.reduction.points import (
    BESIDE,
    N_CLOSER,
    N_FINE,
    N_FREQUENCIES,
    N_SPEEDS,
    N_SYNCHRONOUS,
    N_WORST,
    Points,
    between,
    compared_speeds,
)
from rsc.machine.reduction.reduction import OFFSETS, Check, Reduced, reduce
from rsc.system.blas import one_thread
from rsc.system.body import Body, Matrix
from rsc.system.knots import ANISOTROPIC, Knots

BOTH_LINES = "both lines"  # name of the check
_SPARSER = 5  # factor by which points are fewer in a body that is not solved at every point


@dataclass(frozen=True, eq=False)
class Unequal:
    """Matrices of a body that act on the conjugate of its displacements: complex symmetric (n, n), E in N/m and C in N s/m, plus
    speed-dependent parts under the names `ANISOTROPIC`."""

    stiffness: Matrix
    damping: Matrix
    knots: Knots | None = None

    def projected(self, basis: FloatArray) -> "Unequal":
        """The matrices in the coordinates of a basis (n, r)."""
        return self._each(lambda matrix: congruent(matrix, basis))

    def at_speed(self, Omega: float) -> "Unequal":
        """The matrices at a rotor speed in rad/s."""
        if self.knots is None:
            return self
        more = self.knots.at(Omega)
        constant = zip((self.stiffness, self.damping), ANISOTROPIC, strict=True)
        return Unequal(*(matrix + more[name] if name in more else matrix for matrix, name in constant))

    def dense(self) -> "Unequal":
        """The matrices as ndarrays."""
        return self._each(lambda matrix: matrix.toarray() if scipy.sparse.issparse(matrix) else matrix)

    def _each(self, made: Callable[[Any], Any]) -> "Unequal":
        knots = self.knots
        if knots is not None:
            knots = Knots(knots.speed, {name: np.array([made(matrix) for matrix in part]) for name, part in knots.parts.items()})
        return Unequal(made(self.stiffness), made(self.damping), knots)


def congruent(matrix: Matrix, basis: FloatArray) -> NDArray[Any]:
    """A symmetric matrix projected on a basis (n, r), V^T matrix V."""
    small = basis.T @ (matrix @ basis)
    return 0.5 * (small + small.T)


class FrequencyPoint(NamedTuple):
    """A frequency and a speed in rad/s, and the inputs there as columns of `doubled_inputs`."""

    Psi: Any
    Omega: float
    columns: list[int]


Known = list[tuple[FrequencyPoint, ComplexArray]]  # places with the solutions of the full body


def doubled_inputs(body: Body) -> ComplexArray:
    """(2n, 2c + m + 1): for every contact a force at Psi and one at -Psi, the unbalances, and the load, which is its own
    mirror."""
    none, load = np.zeros(body.n_coordinates), body.load
    forces = [pair for contact in np.atleast_2d(body.contact) for pair in ((contact, none), (none, contact))]
    pairs = [*forces, *((b, none) for b in body.unbalance.T), (load, load.conj())]
    return np.array([np.concatenate(pair) for pair in pairs], complex).T


def responses(body: Body, unequal: Unequal, place: FrequencyPoint, moved: float = 1.0) -> ComplexArray:
    """x and z, (2n, k), for the inputs of a place; (p, 2n, k) for p frequencies if the body has ndarrays.

    moved : factor applied to its frequencies

    Raises
    ------
    ReductionError
        On a pole of an undamped body, even if moved slightly.
    """
    Psi, Omega = moved * np.asarray(place.Psi), place.Omega
    direct, mirror = dynamic_stiffness(body, Psi, Omega), dynamic_stiffness(body, -Psi, Omega).conj()
    unequal = unequal.at_speed(Omega)
    inputs = doubled_inputs(body)[:, place.columns]
    try:
        if scipy.sparse.issparse(body.mass):
            across = [unequal.stiffness + 1j * w * unequal.damping for w in (Psi, -Psi)]
            return factored(scipy.sparse.block_array([[direct, across[0]], [across[1].conj(), mirror]])).solve(inputs)
        across = [unequal.stiffness + 1j * np.multiply.outer(w, unequal.damping) for w in (Psi, -np.asarray(Psi))]
        return np.asarray(np.linalg.solve(np.block([[direct, across[0]], [across[1].conj(), mirror]]), inputs), complex)
    except (np.linalg.LinAlgError, RuntimeError):  # exactly on a pole of an undamped body
        if moved > 1.0:
            raise ReductionError(ON_A_POLE) from None
        return responses(body, unequal, place, OFF_THE_POLE)


def antiresonances(body: Body, unequal: Unequal, ends: tuple[float, float], Omega: float) -> FloatArray:
    """Frequencies between two at which the contact of a small body hardly moves in one of the lines, rad/s."""
    grid = np.linspace(*ends, N_FINE)
    forces = list(range(2 * n_contacts(body)))
    moved = np.kron(np.eye(2), body.contact) @ responses(body, unequal, FrequencyPoint(grid, Omega, forces))
    size = np.abs(moved).max(axis=1)
    lowest = (size[1:-1] < size[:-2]) & (size[1:-1] < size[2:])
    return grid[1:-1][lowest.any(axis=1)]


def natural_frequencies(body: Body, unequal: Unequal, Omega: float) -> FloatArray:
    """Damped natural frequencies of a small body, rad/s, positive; each has lines at both signs."""
    body, unequal = body.at_speed(Omega), unequal.at_speed(Omega)
    n, terms, zero = body.n_coordinates, body.terms, np.zeros_like(body.mass)
    damping = terms["damping"] + 1j * terms.get("skew_damping", zero) - 1j * Omega * terms.get("gyroscopic", zero)
    stiffness = terms["stiffness"] + 1j * terms.get("skew_stiffness", zero)
    rows = [
        np.linalg.solve(np.kron(np.eye(2), body.mass), -np.block([[own, other], [other.conj(), own.conj()]]))
        for own, other in ((stiffness, unequal.stiffness), (damping, unequal.damping))
    ]
    values = scipy.linalg.eigvals(np.block([[np.zeros((2 * n, 2 * n)), np.eye(2 * n)], rows]))
    return np.unique(values.imag[values.imag > 0.0])


class _Comparison:
    """Comparison of an anisotropic body with reduced ones at places."""

    def __init__(self, body: Body, unequal: Unequal, basis: Basis) -> None:
        self.body, self.unequal = body, unequal
        self.safety, self.exact, self.scale, self.contacts = basis.safety, basis.exact, basis.scale, basis.contacts
        self.shift = basis.shift

    def places(self, basis: Basis, band: tuple[float, float], speeds: tuple[float, float], offset: float) -> list[FrequencyPoint]:
        """Places in the band, its mirror image and at the speeds: equally spaced, and at extrema of the reduced body's
        response."""
        reach, fewer, places = max(map(abs, band)), 1 if self.exact else _SPARSER, []
        forces = 2 * self.contacts
        small = basis.reduced, self.unequal.projected(basis.vectors)
        for Omega in compared_speeds(self.body, speeds, max(N_SPEEDS // fewer, 2), offset):
            natural = natural_frequencies(*small, Omega) * (1.0 + BESIDE * (1.0 + offset))
            narrow = antiresonances(*small, (self.shift.least, reach), Omega) if self.exact else np.zeros(0)
            Psi = np.concatenate([between((0.0, reach), N_FREQUENCIES // fewer, offset), natural[natural < reach], narrow])
            Psi = self.shift.off_zero(Psi)
            places += [FrequencyPoint(float(one), float(Omega), list(range(forces))) for one in Psi]
        last = forces + self.body.unbalance.shape[1]
        if last > forces:
            synchronous = self.shift.off_zero(between(speeds, N_SYNCHRONOUS // fewer, offset)).tolist()
            places += [FrequencyPoint(Omega, Omega, list(range(forces, last))) for Omega in synchronous]
        loaded = compared_speeds(self.body, speeds, 2, offset).tolist() if self.body.knots is not None else [speeds[0]]
        return places + [FrequencyPoint(self.shift.loading, Omega, [last]) for Omega in loaded if self.body.load.any()]

    def closer(
        self, known: Known, shares: FloatArray, band: tuple[float, float], speeds: tuple[float, float]
    ) -> list[FrequencyPoint]:
        """Places increasingly close to the worst ones, like `points.closer`."""
        steps, places = 0.5 ** np.arange(1, N_CLOSER + 1), []
        for i in np.argsort(shares.max(axis=1))[::-1][: N_WORST if self.exact else 1]:
            Psi, Omega, columns = known[i][0]
            synchronous, reach = columns[0] >= 2 * self.contacts, max(map(abs, band))
            low, high, count = (*speeds, N_SYNCHRONOUS) if synchronous else (0.0, reach, N_FREQUENCIES)
            around = np.clip(Psi + (high - low) / (count - 1) * np.concatenate([-steps, steps]), low, high)
            around = self.shift.off_zero(around)
            places += [FrequencyPoint(one, one if synchronous else Omega, columns) for one in around.tolist() if Psi != 0.0]
        return places

    def solved(self, places: list[FrequencyPoint]) -> Known:
        """The places with the solutions of the full body."""
        return [(place, responses(self.body, self.unequal, place)) for place in places]

    def errors(self, basis: Basis, known: Known) -> FloatArray:
        """(p, k, c + q) relative errors at contacts and observers for each input; NaN at places with fewer inputs."""
        small, n = (basis.reduced, self.unequal.projected(basis.vectors)), self.body.n_coordinates
        r, outputs = basis.reduced.n_coordinates, self.body.outputs
        errors = np.full((len(known), max(len(place.columns) for place, _ in known), len(outputs)), np.nan)
        for i, (place, exact) in enumerate(known):
            y = responses(*small, place)
            true = np.array([outputs @ exact[:n], outputs @ exact[n:]])
            small_ones = np.array([basis.reduced.outputs @ y[:r], basis.reduced.outputs @ y[r:]])
            forces = np.array(place.columns)  # both forces at a contact are one input of `Scale`
            columns = np.where(forces < 2 * self.contacts, forces // 2, forces - self.contacts)
            at = Points(np.full(columns.shape, place.Psi), np.full(columns.shape, place.Omega), columns, true, {})
            scale = self.scale.of(at, abs(true).max(axis=0).T, abs(small_ones).max(axis=0).T)
            errors[i, : len(columns)] = abs(true - small_ones).max(axis=0).T / scale
        return errors

    def shares(self, errors: FloatArray, tolerance: float) -> FloatArray:
        """(p, k) errors relative to the allowed ones, as in `Basis.shares`."""
        allowed = np.where(np.arange(errors.shape[2]) < self.contacts, tolerance, np.sqrt(tolerance))
        return self.safety * np.nan_to_num(errors / allowed).max(axis=2)

    def grow(self, basis: Basis, known: Known, tolerance: float) -> None:
        """Add solutions where the reduced body is worst until it is within the tolerance at all known places."""
        n = self.body.n_coordinates
        while True:
            shares = self.shares(self.errors(basis, known), tolerance)
            i, k = np.unravel_index(np.argmax(shares), shares.shape)
            if shares[i, k] <= 1.0:
                return
            motion = known[i][1][:, k]
            if not basis.add(motion[:n], motion[n:]):
                raise unmet(tolerance, basis.reduced.n_coordinates, float(shares[i, k]) * tolerance)


@one_thread
def reduce_unequal(
    body: Body,
    unequal: Unequal,
    band: tuple[float, float],
    speeds: tuple[float, float],
    tolerance: float = 1e-4,
    begin: FloatArray | None = None,
) -> Reduced:
    """Reduce an anisotropic body.

    Parameters
    ----------
    body : Body
        The isotropic mean.
    unequal : Unequal
        The anisotropic matrices, in its coordinates.
    band, speeds, tolerance, begin
        As for `reduce`. The tolerance holds for the mean, and for the anisotropic body: for both lines of the contact receptance
        at frequencies of the band and their mirror images, unbalance responses and static deflection.

    Returns
    -------
    Reduced
        Its last check, `BOTH_LINES`, is that of the anisotropic body.

    Raises
    ------
    ReductionError
        As for `reduce`.
    """
    body = checked(body)
    if not scipy.sparse.issparse(body.mass):
        unequal = unequal.dense()
    result = reduce(body, band, speeds, tolerance, begin)
    reach = max(map(abs, band))
    basis = _basis(body, result.basis, reach)
    comparison = _Comparison(body, unequal, basis)
    known = comparison.solved(comparison.places(basis, band, speeds, 0.0))
    for offset in OFFSETS:
        before = basis.reduced.n_coordinates
        comparison.grow(basis, known, tolerance)
        if basis.reduced.n_coordinates > before:
            result = reduce(body, band, speeds, tolerance, basis.vectors)
            basis = _basis(body, result.basis, reach)
        fresh = comparison.solved(comparison.places(basis, band, speeds, offset))
        around = comparison.closer(fresh, comparison.shares(comparison.errors(basis, fresh), tolerance), band, speeds)
        fresh += comparison.solved(around)
        errors = comparison.errors(basis, fresh)
        if comparison.shares(errors, tolerance).max() <= 1.0:
            check = _worst(comparison.safety * errors[:, :, : basis.contacts].max(axis=2), fresh)
            return replace(result, checks=(*result.checks, check), error=max(result.error, check.error))
        known += fresh
    raise unmet(tolerance, basis.reduced.n_coordinates, tolerance * float(comparison.shares(errors, tolerance).max()))


def _basis(body: Body, vectors: NDArray[np.float64], reach: float) -> Basis:
    basis = Basis(body, reach)
    for vector in vectors.T:
        basis.add(vector)
    return basis


def _worst(errors: FloatArray, places: Known) -> Check:
    i, k = np.unravel_index(np.nanargmax(errors), errors.shape)
    Psi, Omega, _ = places[i][0]
    return Check(BOTH_LINES, "contact", float(errors[i, k]), Psi, Omega, False)
