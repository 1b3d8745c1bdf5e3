"""Greedy basis of a reduction: solutions of the full body are added where the reduced body is worst.

Galerkin projection with a real basis V, orthonormal with the stiffness, keeps every matrix real and symmetric. The reduced
displacement V y leaves the residual rho = input - A V y; the error at a contact is exactly rho_l^T A^-1 rho with the residual
rho_l of its contact row, hence quadratic in the error of the basis. A is complex symmetric but for first-order states, where
rho_l is that of A^T and the solutions of A^T belong to the basis as well.
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
    terms_of,
)
from rsc.machine.reduction.feedback import state_coefficients, state_columns
from rsc.machine.reduction.points import Points, Scale
from rsc.machine.reduction.shift import loop_solver, shift_of, shifted_solver, slow_motions
from rsc.system.body import Body

# a direction whose remainder after orthogonalisation is below this fraction is in the basis up to rounding
_ROUNDING = 1e-11
MOST_COORDINATES = 200  # limit for a reduced body
# factors on the largest error found, since errors between the points may be larger; the second for estimated errors
SAFETY, SAFETY_ESTIMATED = 2.0, 3.0


class Basis:
    """The growing basis of a body, its projected matrices, and the error they leave at points.

    Attributes
    ----------
    shift : Shift of the stiffness, for a body that is hardly held; "stiffness" means the shifted one in what follows
    scale : Scale of the errors
    vectors : (n, r) basis, orthonormal with respect to the stiffness
    reduced : Body of r coordinates
    exact : whether every point is solved; for larger bodies errors are estimated
    safety : factor on the errors found before they are stated
    contacts : number of contact locations c
    margin : factor on estimates: the largest ratio of true error to estimate in the last check, at least 1
    """

    def __init__(self, body: Body, reach: float = 0.0) -> None:
        self.body, self.shift = body, shift_of(body, reach)
        self.static = shifted_solver(body, self.shift)
        self.exact, self.margin = body.n_coordinates <= FEW, 1.0
        self.safety = SAFETY if self.exact else SAFETY_ESTIMATED
        self._inputs = self.static(body.inputs)
        typical = loop_solver(body, reach) if body.n_states else self.static
        self.scale = Scale(body, typical(body.inputs), typical(body.outputs.T))
        self.vectors = np.zeros((body.n_coordinates, 0))
        self._terms = terms_of(body)
        self._images = dict.fromkeys(self._terms, self.vectors)
        self._deflections = dict(self._images)
        self._gram: ComplexArray | None = None
        self._by_states = state_columns(body)
        self.reduced = body
        self.contacts = n_contacts(body)
        for motion in slow_motions(body, self.static, self.shift).T if self.shift.square else ():
            self.add(motion)
        for contact in range(self.contacts):
            self.add(self._inputs[:, contact])
        if self.shift.square and body.load.any():
            self.add(self._inputs[:, -1])

    def add(self, *states: ComplexArray) -> bool:
        """Add to the basis the direction, among real and imaginary parts of solutions, that it lacks most (in energy).

        Adding all parts at once would often be too many coordinates; further ones follow when the point is worst again.

        Returns
        -------
        bool
            False if the basis contains all solutions up to rounding.
        """
        parts = np.column_stack([part for state in states for part in (state.real, state.imag)])
        whole = float(np.trace(self._energies(parts)))
        parts = self._orthogonal(self._orthogonal(parts))
        energies, turn = np.linalg.eigh(self._energies(parts))
        if energies[-1] <= _ROUNDING**2 * whole:
            return False
        # orthogonalise twice again: the remainder may have been small compared with what was subtracted
        vector = self._orthogonal(self._orthogonal(parts @ turn[:, -1] / np.sqrt(energies[-1])))
        self._append(vector / np.sqrt(self._energies(vector)))
        return True

    def _energies(self, columns: FloatArray) -> FloatArray:
        forces = product(self.body.stiffness, columns).astype(float)
        if self.shift.square:
            forces += self.shift.square * product(self.body.mass, columns).astype(float)
        return columns.T @ forces

    def _orthogonal(self, columns: FloatArray) -> FloatArray:
        forces = self._images["stiffness"]
        if self.shift.square:
            forces = forces + self.shift.square * self._images["mass"]
        return columns - self.vectors @ (forces.T @ columns)

    def _append(self, vector: FloatArray) -> None:
        self.vectors = np.column_stack([self.vectors, vector])
        for name, matrix in self._terms.items():
            image = product(matrix, vector).astype(float)
            self._images[name] = np.column_stack([self._images[name], image])
            if not self.exact:
                held = name == "stiffness" and not self.shift.square
                deflection = vector if held else self.static(image[:, None])[:, 0]
                self._deflections[name] = np.column_stack([self._deflections[name], deflection])
        self.reduced, self._gram = projected(self.body, self.vectors, self._images), None

    def errors(self, points: Points) -> FloatArray:
        """(p, c + q) relative errors; NaN at observers where the full body was not solved."""
        y = solutions(self.reduced, points.Psi, points.Omega, self.reduced.inputs[:, points.column])
        values = y @ self.reduced.outputs.T
        solved = np.isfinite(points.exact[:, 0])
        differences = np.abs(points.exact - values)
        if not solved.all():
            differences[~solved, : self.contacts] = self.margin * self._estimates(points, y)[~solved]
        return differences / self.scale.of(points, np.where(np.isfinite(points.exact), points.exact, values), values)

    def shares(self, points: Points, tolerance: float) -> FloatArray:
        """(p,) errors times `safety` relative to the allowed ones: the tolerance at contacts, its square root at observers."""
        errors = self.errors(points) / tolerance
        errors[:, self.contacts :] *= np.sqrt(tolerance)
        return self.safety * np.nan_to_num(errors, nan=0.0).max(axis=1)

    def learn(self, points: Points, places: np.ndarray) -> None:
        """Update the margin by comparing estimates with true errors at solved points."""
        y = solutions(self.reduced, points.Psi[places], points.Omega[places], self.reduced.inputs[:, points.column[places]])
        chosen = replace(points, **{name: getattr(points, name)[places] for name in ("Psi", "Omega", "column")})
        estimates = self._estimates(chosen, y)
        values = y @ self.reduced.outputs.T
        differences = np.abs(points.exact[places] - values)[:, : self.contacts]
        rounding = 1e-12 * self.scale.of(chosen, points.exact[places], values)[:, : self.contacts]
        ratios = differences / np.maximum(estimates, rounding)
        self.margin = float(ratios[differences > 100.0 * rounding].max(initial=1.0))

    def _estimates(self, points: Points, y: ComplexArray) -> FloatArray:
        """(p, c) |rho_l^T A^-1 rho| with K for A: what a good basis omits is above the band and responds quasi-statically."""
        energies, estimates = self._residual_energies(points, y), []
        for i in range(self.contacts):
            contact = replace(points, column=np.full_like(points.column, i))
            columns = self.reduced.inputs[:, contact.column]
            y_contact = solutions(self.reduced, points.Psi, points.Omega, columns, left=bool(self.body.n_states))
            estimates.append(np.sqrt(np.abs(energies * self._residual_energies(contact, y_contact, left=True))))
        return np.column_stack(estimates)

    def _residual_energies(self, points: Points, y: ComplexArray, left: bool = False) -> FloatArray:
        """(p,) rho^H K^-1 rho of the residual at every point; left: of the transposed equation."""
        factor = factors_of(self.body, points.Psi, points.Omega)
        parts = [-factor[name][:, None] * y for name in self._images]
        parts.append(state_coefficients(self.reduced, points.Psi, y, left))
        coefficients = np.hstack([np.eye(self._inputs.shape[1])[points.column], *parts])
        if self._gram is None:
            forces = np.hstack([self.body.inputs, *self._images.values(), self._by_states])
            deflections = [self._inputs, *self._deflections.values(), self.static(self._by_states)]
            self._gram = forces.conj().T @ np.hstack(deflections)
        return np.einsum("pi,pi->p", coefficients.conj(), coefficients @ self._gram.T).real

    def grow(self, points: Points, tolerance: float) -> list[tuple[int, float]]:
        """Add solutions where the error is largest until all are within the tolerance; returns (coordinates, error) of each
        step."""
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
        """Add the solution at the worst point, or with first-order states one of the transposed equation there."""
        if worst not in points.states:
            points.solve(self.body, np.array([worst]))
        n, solved = self.vectors.shape[1], [points.states[worst]]
        if self.body.n_states:
            one = np.full(self.contacts, points.Psi[worst]), np.full(self.contacts, points.Omega[worst])
            solved += list(solutions(self.body, *one, self.body.inputs[:, : self.contacts], left=True))
        if n >= MOST_COORDINATES or not self.add(*solved):
            raise unmet(tolerance, n, float(self.shares(points, tolerance)[worst]) * tolerance)


def unmet(tolerance: float, n: int, error: float) -> ReductionError:
    """The error for a tolerance that n coordinates do not meet."""
    return ReductionError(f"tolerance = {tolerance:.3g} cannot be met: {n} coordinates leave a relative error of {error:.2g}")
