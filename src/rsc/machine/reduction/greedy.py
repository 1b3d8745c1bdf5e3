"""The basis of a reduction: solutions of the full body where the reduced one is worst, taken one after another.

Galerkin projection with a real basis V, orthonormal with the stiffness, keeps every matrix real and symmetric. The reduced
displacement V y leaves the residual rho = input - A V y; the error at a contact is exactly rho_l^T A^-1 rho with the residual
rho_l of its contact row, hence quadratic in the error of the basis (A is complex symmetric).
"""

from dataclasses import replace

import numpy as np

from rsc.errors import ReductionError
from rsc.machine.reduction.body import (
    FEW,
    ComplexArray,
    FloatArray,
    factors_of,
    n_contacts,
    product,
    projected,
    solutions,
    static_solver,
    terms_of,
)
from rsc.machine.reduction.points import Points, Scale
from rsc.system.body import Body

# what is left of a direction, against the whole, after what the basis has of it: below, nothing but rounding
_ROUNDING = 1e-11
MOST_COORDINATES = 200  # of a reduced body
# the largest error found is stated so many times larger: between the points there may be a larger one; of one that was estimated
SAFETY, SAFETY_ESTIMATED = 2.0, 3.0


class Basis:
    """The growing basis of a body, its projected matrices, and the error they leave at points.

    Attributes
    ----------
    scale : Scale of the errors
    vectors : (n, r) basis, orthonormal with the stiffness
    reduced : Body of r coordinates
    exact : whether every point is solved; of larger bodies errors are estimated
    safety : what errors found are multiplied with before they are stated
    contacts : how many places touch, c
    margin : what estimates are multiplied with: the largest ratio of a true error to its estimate in the last check, at least 1
    """

    def __init__(self, body: Body) -> None:
        self.body, self.static = body, static_solver(body)
        self.exact, self.margin = body.n_coordinates <= FEW, 1.0
        self.safety = SAFETY if self.exact else SAFETY_ESTIMATED
        self._inputs = self.static(body.inputs)
        self.scale = Scale(body, self._inputs, self.static(body.outputs.T))
        self.vectors = np.zeros((body.n_coordinates, 0))
        self._terms = terms_of(body)
        self._images = dict.fromkeys(self._terms, self.vectors)
        self._deflections = dict(self._images)
        self._gram: ComplexArray | None = None
        self.reduced = body
        self.contacts = n_contacts(body)
        for contact in range(self.contacts):
            self.add(self._inputs[:, contact])

    def add(self, *states: ComplexArray) -> bool:
        """Add of solutions the direction, among their real and imaginary parts, of which the basis lacks most (in energy).

        All parts at once would often be some coordinates too many; another is taken when its point is the worst again.

        Returns
        -------
        bool
            False if the basis has all solutions to rounding.
        """
        parts = np.column_stack([part for state in states for part in (state.real, state.imag)])
        whole = float(np.trace(self._energies(parts)))
        parts = self._orthogonal(self._orthogonal(parts))
        energies, turn = np.linalg.eigh(self._energies(parts))
        if energies[-1] <= _ROUNDING**2 * whole:
            return False
        # twice more: what was left may have been small against what was taken away
        vector = self._orthogonal(self._orthogonal(parts @ turn[:, -1] / np.sqrt(energies[-1])))
        self._append(vector / np.sqrt(self._energies(vector)))
        return True

    def _energies(self, columns):
        return columns.T @ product(self.body.stiffness, columns).astype(float)

    def _orthogonal(self, columns):
        return columns - self.vectors @ (self._images["stiffness"].T @ columns)

    def _append(self, vector):
        self.vectors = np.column_stack([self.vectors, vector])
        for name, matrix in self._terms.items():
            image = product(matrix, vector).astype(float)
            self._images[name] = np.column_stack([self._images[name], image])
            if not self.exact:
                deflection = vector if name == "stiffness" else self.static(image[:, None])[:, 0]
                self._deflections[name] = np.column_stack([self._deflections[name], deflection])
        self.reduced, self._gram = projected(self.body, self.vectors, self._images), None

    def errors(self, points: Points) -> FloatArray:
        """(p, c + q) relative errors; of observers NaN where the full body was not solved."""
        y = solutions(self.reduced, points.Psi, points.Omega, self.reduced.inputs[:, points.column])
        values = y @ self.reduced.outputs.T
        solved = np.isfinite(points.exact[:, 0])
        differences = np.abs(points.exact - values)
        if not solved.all():
            differences[~solved, : self.contacts] = self.margin * self._estimates(points, y)[~solved]
        return differences / self.scale.of(points, np.where(np.isfinite(points.exact), points.exact, values), values)

    def shares(self, points: Points, tolerance: float) -> FloatArray:
        """(p,) errors times `safety` against what is allowed: the tolerance at contacts, its root at observers."""
        errors = self.errors(points) / tolerance
        errors[:, self.contacts :] *= np.sqrt(tolerance)
        return self.safety * np.nan_to_num(errors, nan=0.0).max(axis=1)

    def learn(self, points: Points, places: np.ndarray) -> None:
        """Compare estimates with the truth at places that have been solved, for the margin."""
        y = solutions(self.reduced, points.Psi[places], points.Omega[places], self.reduced.inputs[:, points.column[places]])
        chosen = replace(points, **{name: getattr(points, name)[places] for name in ("Psi", "Omega", "column")})
        estimates = self._estimates(chosen, y)
        values = y @ self.reduced.outputs.T
        differences = np.abs(points.exact[places] - values)[:, : self.contacts]
        rounding = 1e-12 * self.scale.of(chosen, points.exact[places], values)[:, : self.contacts]
        ratios = differences / np.maximum(estimates, rounding)
        self.margin = float(ratios[differences > 100.0 * rounding].max(initial=1.0))

    def _estimates(self, points: Points, y: ComplexArray) -> FloatArray:
        """(p, c) |rho_l^T A^-1 rho| with K for A: what a good basis leaves out lies above the band and deflects as if static."""
        own, estimates = self._residual_energies(points, y), []
        for i in range(self.contacts):
            contact = replace(points, column=np.full_like(points.column, i))
            y_contact = solutions(self.reduced, points.Psi, points.Omega, self.reduced.inputs[:, contact.column])
            estimates.append(np.sqrt(np.abs(own * self._residual_energies(contact, y_contact))))
        return np.column_stack(estimates)

    def _residual_energies(self, points, y):
        """rho^H K^-1 rho of the residual at every point."""
        factor = factors_of(self.body, points.Psi, points.Omega)
        parts = [-factor[name][:, None] * y for name in self._images]
        coefficients = np.hstack([np.eye(self._inputs.shape[1])[points.column], *parts])
        if self._gram is None:
            forces = np.hstack([self.body.inputs, *self._images.values()])
            self._gram = forces.conj().T @ np.hstack([self._inputs, *self._deflections.values()])
        return np.einsum("pi,pi->p", coefficients.conj(), coefficients @ self._gram.T).real

    def grow(self, points: Points, tolerance: float) -> list[tuple[int, float]]:
        """Add solutions where the error is largest until none is above the tolerance; (coordinates, error) of every step."""
        if self.exact:
            unsolved = np.flatnonzero(np.isnan(points.exact[:, 0]))
            points.solve(self.body, unsolved)
        steps = []
        while True:
            shares = self.shares(points, tolerance)
            worst = int(np.argmax(shares))
            steps.append((self.vectors.shape[1], float(shares[worst] * tolerance)))
            if shares[worst] <= 1.0:
                return steps
            if worst not in points.states:
                points.solve(self.body, np.array([worst]))
                if self.shares(points, tolerance)[worst] <= 1.0:
                    continue
            self.take(points, worst, tolerance)

    def take(self, points: Points, worst: int, tolerance: float) -> None:
        """Add the solution at the worst point."""
        if worst not in points.states:
            points.solve(self.body, np.array([worst]))
        n = self.vectors.shape[1]
        if n >= MOST_COORDINATES or not self.add(points.states[worst]):
            raise unmet(tolerance, n, float(self.shares(points, tolerance)[worst]) * tolerance)


def unmet(tolerance: float, n: int, error: float) -> ReductionError:
    """The refusal of a tolerance that so many coordinates do not meet."""
    return ReductionError(f"tolerance = {tolerance:.3g} cannot be met: {n} coordinates leave a relative error of {error:.2g}")
