"""`reduce`: a body of a machine with as few coordinates as a tolerance of its contact receptance allows.

The basis grows (greedy.py) until the receptance over the band of whirls and the unbalance response over the speeds are within the
tolerance; both are then compared with the full body at points not used for the basis. The first of the new coordinates is the
displacement at the contact; all have the same mass, and the others are the modes with the contact fixed. With several contacts
each has a coordinate, and their masses are coupled.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from rsc.errors import ReductionError
from rsc.machine.model.model import FiniteElementModel
from rsc.machine.reduction.body import FloatArray, checked, highest_frequency, n_contacts, projected
from rsc.machine.reduction.greedy import Basis, unmet
from rsc.machine.reduction.points import Points, closer, points
from rsc.system.blas import one_thread
from rsc.system.body import Body

# relative position of the points of each check between those of the basis; after the last failed one `reduce` gives up
OFFSETS = (0.5, 0.25, 0.75, 0.37, 0.62, 0.12)
_CHECKED = 6  # points of a check that are solved exactly if not all are
SMALLEST, LARGEST = 1e-10, 0.1  # limits of the tolerance
_ALIKE = 1e-9  # least eigenvalue of the contacts' compliances, scaled to a diagonal of ones


@dataclass(frozen=True)
class Check:
    """Largest relative error of one response at points not used for the basis; with several contacts the whole matrix of their
    receptances counts as one response at one place."""

    response: str  # "receptance", "unbalance 0", ... or "load"
    place: str  # "contact" or "observer 0", ...
    error: float  # relative to `points.Scale`, the largest one found times `Basis.safety`
    Psi: float  # rad/s, where it is largest
    Omega: float  # rad/s
    estimated: bool  # from the residual; the full body was solved at some points only


@dataclass(frozen=True, eq=False)
class Reduced:
    """A reduced body with its origin and its errors.

    The mass is the identity times the effective mass at the contact, the contact row (1, 0, ..., 0), and the stiffness diagonal
    except for its first row and column. From coordinates of unit mass this is a rotation times one factor: condition number 1.
    With c contacts the contact rows are those of the identity, the first c masses a matrix, and c rows and columns of the
    stiffness full.
    """

    body: Body  # of r coordinates
    full: Body  # of n
    basis: FloatArray  # (n, r): full displacements = basis @ reduced ones
    band: tuple[float, float]  # rad/s
    speeds: tuple[float, float]  # rad/s
    tolerance: float
    checks: tuple[Check, ...]
    steps: tuple[tuple[int, float], ...]  # (coordinates, error) while the basis grew
    highest_before: float  # rad/s, undamped natural frequency at standstill
    highest_after: float
    error: float  # largest of the checks at the contact
    model: FiniteElementModel | None = None  # for a scene: the full machine with all its bearings
    states: Any = None  # and its `rsc.scene.bodies.states.StateMatrices`, None without first-order states

    def recover(self, displacements: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Displacements, or velocities, (..., r) of the reduced body -> (..., n) of the full one."""
        return displacements @ self.basis.T


@one_thread
def reduce(
    body: Body,
    band: tuple[float, float],
    speeds: tuple[float, float],
    tolerance: float = 1e-4,
    begin: FloatArray | None = None,
) -> Reduced:
    """Reduce a body.

    Parameters
    ----------
    body : Body
        With contact row or rows, unbalances, load and observers. Up to 300 coordinates every point is solved; for a larger body,
        with sparse matrices, only those of the basis and a few more, and errors elsewhere are estimated from the residual.
    band : (float, float), rad/s
        Lowest and highest whirl frequency Psi; backward whirls are negative.
    speeds : (float, float), rad/s
        Lowest and highest rotor speed Omega.
    tolerance : float
        Largest relative error of the contact receptance over the band (several contacts: of the matrix of receptances between
        them), and of its response to each unbalance over the speeds and to the load. Observers are held to its square root: the
        error at the contact is quadratic in that of the basis, elsewhere it is linear.
    begin : (n, k), optional
        Motions that the reduced body contains in any case.

    Returns
    -------
    Reduced

    Raises
    ------
    ReductionError
        A body that cannot be reduced, or a tolerance that cannot be met.
    """
    band, speeds = _range("band", band, least_width=True), _range("speeds", speeds)
    if not SMALLEST <= tolerance <= LARGEST:
        raise ReductionError(f"tolerance = {tolerance:.3g} must be {SMALLEST:g} to {LARGEST:g}")
    body = checked(body)
    basis = Basis(body, max(map(abs, band)))
    for motion in () if begin is None else begin.T:
        basis.add(motion)
    training = points(body, basis.reduced, band, speeds, 0.0, basis.shift)
    steps = []
    for offset in OFFSETS:
        steps += basis.grow(training, tolerance)
        fresh = _compared(basis, points(body, basis.reduced, band, speeds, offset, basis.shift), tolerance)
        if basis.exact:
            around = closer(fresh, basis.shares(fresh, tolerance), band, speeds, basis.shift)
            fresh = fresh.joined(_compared(basis, around, tolerance))
        shares = basis.shares(fresh, tolerance)
        if shares.max() <= 1.0:
            checks = checks_at(body, fresh, basis.safety * basis.errors(fresh), not basis.exact)
            return _finished(basis, band, speeds, tolerance, checks, tuple(steps))
        basis.take(fresh, int(np.argmax(shares)), tolerance)
        training = training.joined(fresh)
    raise unmet(tolerance, steps[-1][0], tolerance * float(shares.max()))


def _range(name: str, ends: tuple[float, float], least_width: bool = False) -> tuple[float, float]:
    low, high = (float(end) for end in ends)
    if not (np.isfinite([low, high]).all() and (low < high if least_width else low <= high)):
        raise ReductionError(f"{name} = {low:g} to {high:g} rad/s must be two finite numbers, the lower one first")
    return low, high


def _compared(basis: Basis, fresh: Points, tolerance: float) -> Points:
    """New points, solved; for a large body only the worst of each input and some others."""
    if basis.exact:
        fresh.solve(basis.body, np.arange(len(fresh.Psi)))
        return fresh
    guesses = basis.errors(fresh)[:, : basis.contacts].max(axis=1)
    of_column = [np.flatnonzero(fresh.column == column) for column in np.unique(fresh.column)]
    chosen = [int(places[np.argmax(guesses[places])]) for places in of_column]
    others = np.linspace(0, np.sum(fresh.column < basis.contacts) - 1, max(_CHECKED - len(chosen), 2)).astype(int)
    fresh.solve(basis.body, np.unique([*chosen, *others]))
    for _ in range(_CHECKED):
        basis.learn(fresh, np.flatnonzero(np.isfinite(fresh.exact[:, 0])))
        shares = basis.shares(fresh, tolerance)
        worst = int(np.argmax(shares))
        if shares[worst] <= 1.0 or worst in fresh.states:
            break
        fresh.solve(basis.body, np.array([worst]))  # an overly cautious margin is no reason for more coordinates
    return fresh


def checks_at(body: Body, places: Points, errors: FloatArray, estimated: bool) -> tuple[Check, ...]:
    """The largest error of every response at the contacts and at every observer; errors (p, c + q), NaN where unknown."""
    c = places.n_contacts
    last = body.unbalance.shape[1] + c
    errors = np.column_stack([errors[:, :c].max(axis=1), errors[:, c:]])
    inputs = np.maximum(places.column - c + 1, 0)
    checks = []
    for column in np.unique(inputs):
        response = "receptance" if column == 0 else "load" if column == last - c + 1 else f"unbalance {column - 1}"
        for i in range(errors.shape[1]):
            seen = np.flatnonzero((inputs == column) & np.isfinite(errors[:, i]))
            if seen.size:
                worst = seen[np.argmax(errors[seen, i])]
                place = "contact" if i == 0 else f"observer {i - 1}"
                where = (float(places.Psi[worst]), float(places.Omega[worst]))
                checks.append(Check(response, place, float(errors[worst, i]), *where, estimated))
    return tuple(checks)


def _finished(basis: Basis, band: Any, speeds: Any, tolerance: float, checks: tuple[Check, ...], steps: Any) -> Reduced:
    # separate code for one contact: all masses are equal, and results of earlier versions keep their bits
    turn, mass = (contact_coordinates if basis.contacts == 1 else several_coordinates)(basis.reduced)
    body = turned(basis.reduced, turn, mass)
    return Reduced(
        body=body,
        full=basis.body,
        basis=basis.vectors @ turn,
        band=band,
        speeds=speeds,
        tolerance=tolerance,
        checks=checks,
        steps=steps,
        highest_before=highest_frequency(basis.body, basis.shift.square),
        highest_after=highest_frequency(body, basis.shift.square),
        error=max(check.error for check in checks if check.place == "contact"),
    )


def contact_coordinates(body: Body) -> tuple[FloatArray, float]:
    """Coordinates of equal mass: the first is the displacement at the contact, the others are modes with the contact fixed.

    With coordinates of unit mass and the contact row phi in them, a rotation whose first column is phi/|phi| and the factor
    1/|phi| make the row (1, 0, ..., 0) and every mass 1/|phi|^2: the effective mass at the contact.

    Returns
    -------
    turn : (r, r)
        Old coordinates = turn @ new coordinates.
    mass : float, kg
    """
    triangle = _triangle(body)
    phi = scipy.linalg.solve_triangular(triangle, body.contact, lower=True)
    mass = 1.0 / float(phi @ phi)
    rotation = np.linalg.qr(phi[:, None], mode="complete")[0]
    rotation[:, 0] = phi * np.sqrt(mass)
    basis = scipy.linalg.solve_triangular(triangle, rotation, lower=True, trans="T") * np.sqrt(mass)
    held = basis[:, 1:]
    _, modes = np.linalg.eigh(held.T @ body.stiffness @ held)
    return np.column_stack([basis[:, 0], held @ modes]), mass


def several_coordinates(body: Body) -> tuple[FloatArray, FloatArray]:
    """Coordinates: the first c are the displacements at c contacts, the others modes with all contacts fixed.

    With coordinates of unit mass and the contact rows Phi (c, r) in them, the motions Phi^T (Phi Phi^T)^-1 move one contact each;
    their masses (Phi Phi^T)^-1 are coupled with each other but not with the fixed-contact modes, which have the mass of the
    first.

    Returns
    -------
    turn : (r, r)
        Old coordinates = turn @ new coordinates.
    mass : (r, r), kg

    Raises
    ------
    ReductionError
        Contacts that move together in all motions of the basis.
    """
    triangle = _triangle(body)
    phi = scipy.linalg.solve_triangular(triangle, body.contact.T, lower=True)
    c, compliance = phi.shape[1], phi.T @ phi
    scale = 1.0 / np.sqrt(compliance.diagonal())
    if np.linalg.eigvalsh(scale[:, None] * compliance * scale).min() < _ALIKE:
        raise ReductionError("two contacts move together in every motion of the band: put them at one node, or widen the band")
    masses = np.linalg.inv(compliance)
    masses = 0.5 * (masses + masses.T)
    held = np.linalg.qr(phi, mode="complete")[0][:, c:] * np.sqrt(masses[0, 0])
    basis = scipy.linalg.solve_triangular(triangle, np.column_stack([phi @ masses, held]), lower=True, trans="T")
    moving, held = basis[:, :c], basis[:, c:]
    _, modes = np.linalg.eigh(held.T @ body.stiffness @ held)
    mass = masses[0, 0] * np.eye(len(basis))
    mass[:c, :c] = masses
    return np.column_stack([moving, held @ modes]), mass


def _triangle(body: Body) -> FloatArray:
    """Cholesky factor of the mass, lower."""
    try:
        return scipy.linalg.cholesky(body.mass, lower=True)
    except np.linalg.LinAlgError:
        raise ReductionError("the mass matrix is not positive definite in the reduced coordinates") from None


def turned(body: Body, turn: FloatArray, mass: float | FloatArray) -> Body:
    """The body in `contact_coordinates` or `several_coordinates`, with their exact mass and contact rows, free of rounding."""
    r, c = turn.shape[1], n_contacts(body)
    mass = mass if np.ndim(mass) else mass * np.eye(r)
    return replace(projected(body, turn), mass=mass, contact=np.eye(r)[0] if body.contact.ndim == 1 else np.eye(r)[:c])
