"""Bodies of machines (`Body` of any size, dense or sparse): checks before a reduction, and solutions of A(Psi, Omega) x = input.

With coefficients interpolated between knots of the rotor speed, A is the sum of constant terms and of the matrices of the knots,
each with its weight at that speed (`terms_of`, `factors_of`): a basis is projected, and a residual formed, term by term.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from numpy.typing import ArrayLike, NDArray

from rsc.errors import ReductionError
from rsc.machine.reduction.feedback import STIFFNESS, in_loop, projected_states, responding, slope_in_loop
from rsc.system.body import Body, Matrix, factors, slope_factors
from rsc.system.knots import Knots

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

# coordinates up to which every point is solved exactly; beyond which a factorization would exceed 2 GB
FEW, MOST = 300, 60_000
# pivot of the stiffness, scaled to a unit diagonal, below which a motion counts as free: rounding leaves 1e-11 in a free body of
# 50,000 coordinates, and a shaft of 3,000 elements on soft bearings has 1e-9
_FREE = 3e-11
_ASYMMETRY = 1e-9  # allowed asymmetry of a matrix relative to its largest entry
_BLOCK = 4 * 2**20  # bytes of dynamic stiffnesses solved at a time, such that they stay in the cache
_CORRECTIONS = 2  # iterative refinements of a sparse solution


Term = str | tuple[str, int]  # a matrix of the body by name, or by name and index of a knot


def n_contacts(body: Body) -> int:
    """Number of contact locations of a body."""
    return 1 if body.contact.ndim == 1 else len(body.contact)


def terms_of(body: Body) -> dict[Term, Matrix]:
    """The matrices that act on r by term, including those of the knots and the stiffness of first-order states."""
    terms: dict[Term, Matrix] = {name: matrix for name, matrix in body.terms.items()}
    if body.n_states:
        terms[STIFFNESS] = body.state_stiffness
    if body.knots is not None:
        terms |= {(name, i): matrix for name, part in body.knots.parts.items() for i, matrix in enumerate(part)}
    return terms


def factors_of(body: Body, Psi: ArrayLike, Omega: ArrayLike, of: Callable[..., dict[str, Any]] = factors) -> dict[Term, Any]:
    """Factor of each term in A(Psi, Omega), or in its slope (of = slope_factors); absent terms are omitted."""
    factor = of(Psi, Omega)
    made: dict[Term, Any] = {name: factor[name] for name in body.terms if name in factor}
    if body.n_states and "stiffness" in factor:
        made[STIFFNESS] = factor["stiffness"]
    if body.knots is not None:
        shares = body.knots.shares(Omega)
        made |= {
            (name, i): factor[name] * shares[..., i] for name in body.knots.parts if name in factor for i in
            range(shares.shape[-1])
        }
    return made


def dynamic_stiffness(body: Body, Psi: ArrayLike, Omega: ArrayLike) -> Matrix:
    """A(Psi, Omega) in N/m, rad/s, with the coefficients at that speed; Psi and Omega broadcast if the matrices are ndarrays."""
    matrix = _sum(factors_of(body, Psi, Omega), terms_of(body))
    return matrix - in_loop(body, Psi) if body.n_states else matrix


def slope(body: Body, Psi: ArrayLike, Omega: ArrayLike) -> Matrix:
    """dA/dPsi at constant Omega, N s/m."""
    matrix = _sum(factors_of(body, Psi, Omega, slope_factors), terms_of(body))
    return matrix - slope_in_loop(body, Psi) if body.n_states else matrix


def _sum(factor: dict[Term, Any], terms: dict[Term, Matrix]) -> Matrix:
    if scipy.sparse.issparse(terms["mass"]):
        return sum(share * terms[name] for name, share in factor.items())
    return sum(np.asarray(share)[..., None, None] * terms[name] for name, share in factor.items())


def projected(body: Body, basis: FloatArray, images: dict[Term, Any] | None = None) -> Body:
    """The body projected on a basis (n, r): a Body of r coordinates; images: products matrix @ basis, by term."""
    images = images or {name: matrix @ basis for name, matrix in terms_of(body).items()}
    matrices = {name: _even(basis.T @ image) for name, image in images.items()}
    knots = None
    if body.knots is not None:
        numbers = range(len(body.knots.speed))
        knots = replace(body.knots, parts={name: np.array([matrices[name, i] for i in numbers]) for name in body.knots.parts})
    return Body(
        **{name: matrix for name, matrix in matrices.items() if isinstance(name, str)},
        **projected_states(body, basis),
        knots=knots,
        contact=(basis.T @ body.contact.T).T,
        unbalance=basis.T @ body.unbalance,
        load=basis.T @ body.load,
        observers=body.observers @ basis,
    )


def _even(matrix: Any) -> Any:
    return 0.5 * (matrix + matrix.T)


def checked(body: Body) -> Body:
    """The body with float matrices, all sparse or, for few coordinates, all ndarrays.

    Raises
    ------
    ReductionError
        Too many coordinates, a wrong shape, a non-finite number, an asymmetric matrix, no contact, or fields that are reduced
        separately (directions.Unequal).
    """
    n = body.n_coordinates
    if not body.isotropic or body.unbalance_euler.size:
        raise ReductionError("anisotropic matrices and unbalance_euler must not be part of a body to be reduced")
    if n > MOST:
        raise ReductionError(f"{n} complex coordinates are too many (at most {MOST}); reduce them in the program that made them")
    as_sparse = any(scipy.sparse.issparse(matrix) for matrix in body.terms.values()) and n > FEW
    if not as_sparse and n > 10 * FEW:
        raise ReductionError(f"{n} complex coordinates need sparse matrices (ndarrays: at most {10 * FEW})")
    fields: dict[str, Any] = {name: _matrix(name, matrix, n, as_sparse) for name, matrix in body.terms.items()}
    if body.n_states:
        own = _matrix(STIFFNESS, body.state_stiffness, n, as_sparse)
        fields[STIFFNESS] = 0.0 * fields["stiffness"] if own is None else own
    if fields["mass"].diagonal().min() < 0.0 or not fields["mass"].diagonal().any():
        raise ReductionError("mass has a negative diagonal entry, or only zeros")
    rows = (n,) if np.ndim(body.contact) == 1 else (-1, n)
    shapes = {"contact": rows, "unbalance": (n, -1), "load": (n,), "observers": (-1, n)}
    empty = {"unbalance": np.zeros((n, 0)), "load": np.zeros(n), "observers": np.zeros((0, n))}
    kinds = {"contact": float, "unbalance": complex, "load": complex, "observers": float}
    for name, shape in shapes.items():
        values = np.asarray(getattr(body, name))
        if name in empty and not values.size:
            values = empty[name]
        if values.ndim != len(shape) or any(size not in (-1, have) for size, have in zip(shape, values.shape, strict=True)):
            raise ReductionError(f"{name} has shape {values.shape}, which does not fit {n} coordinates")
        fields[name] = _finite(name, values).astype(kinds[name])
    if body.knots is not None:
        fields["knots"] = _checked_knots(body.knots, n, as_sparse)
    if not fields["contact"].any(axis=-1).all():
        raise ReductionError("contact is zero: the body has no contact location")
    return replace(body, **fields)


def _checked_knots(knots: Knots, n: int, as_sparse: bool) -> Knots:
    """The knots with all matrices sparse or dense, without parts that are zero at every knot."""
    parts = {}
    for name, part in knots.parts.items():
        matrices = [_matrix(f"{name} of a knot", matrix, n, as_sparse) for matrix in part]
        if any(matrix is not None for matrix in matrices):
            zero = scipy.sparse.csc_array((n, n)) if as_sparse else np.zeros((n, n))
            whole = [zero if matrix is None else matrix for matrix in matrices]
            parts[name] = whole if as_sparse else np.array(whole)
    return Knots(knots.speed, parts)


def _matrix(name: str, matrix: Any, n: int, as_sparse: bool) -> Any:
    """A symmetric float matrix, dense or csc; None for an optional one that is zero."""
    if matrix.shape != (n, n):
        raise ReductionError(f"{name} has shape {matrix.shape}, but the mass has {(n, n)}")
    if as_sparse:
        matrix = scipy.sparse.csc_array(matrix)
        matrix.sum_duplicates()
        entries = _finite(name, matrix.data)
    else:
        matrix = matrix.toarray() if scipy.sparse.issparse(matrix) else np.asarray(matrix)
        entries = _finite(name, matrix)
    if np.iscomplexobj(entries):
        raise ReductionError(f"{name} is complex; give its skew part as a separate matrix")
    largest = np.abs(entries).max(initial=0.0)
    if not largest:
        return matrix.astype(float) if name in ("mass", "damping", "stiffness") else None
    if np.abs(matrix - matrix.T).max() > _ASYMMETRY * largest:
        raise ReductionError(f"{name} is not symmetric")
    return _even(matrix)


def _finite(name: str, values: Any) -> Any:
    try:
        finite = np.isfinite(values).all()
    except TypeError:
        finite = False
    if not finite:
        raise ReductionError(f"{name} has an entry that is not a finite number")
    return values


def static_solver(body: Body) -> Callable[[NDArray[Any]], NDArray[Any]]:
    """Function (n, k) -> K^-1 (n, k).

    Raises
    ------
    ReductionError
        The stiffness is not positive definite: there are rigid-body motions, or the body buckles.
    """
    diagonal = np.asarray(body.stiffness.diagonal())
    if (diagonal <= 0.0).any():
        raise ReductionError(f"coordinate {int(np.argmin(diagonal))} has no stiffness: {ADVICE}")
    scale = 1.0 / np.sqrt(diagonal)
    if scipy.sparse.issparse(body.stiffness):
        try:
            factor = factored(_scaled(body.stiffness, scale))
        except RuntimeError:  # exactly singular
            raise _free() from None
        # with equal row and column permutations the pivots are those of a symmetric elimination
        _hold(factor.U.diagonal() if (factor.perm_r == factor.perm_c).all() else np.zeros(1))
        solve = by_parts(factor.solve)
        return lambda columns: scale[:, None] * solve(scale[:, None] * columns)
    try:
        triangle = scipy.linalg.cholesky(scale[:, None] * body.stiffness * scale, lower=True)
    except np.linalg.LinAlgError:
        raise _free() from None
    _hold(triangle.diagonal() ** 2)
    return lambda columns: scale[:, None] * scipy.linalg.cho_solve((triangle, True), scale[:, None] * columns)


ADVICE = "a body that buckles, or one without its bearings or foundation, cannot be reduced"


def _hold(pivots: FloatArray) -> None:
    if not (pivots > _FREE).all():
        raise _free()


def _free() -> ReductionError:
    return ReductionError(f"the stiffness is not positive definite: {ADVICE}")


def _scaled(matrix: Any, scale: FloatArray) -> Any:
    scaling = scipy.sparse.diags_array(scale)
    return scipy.sparse.csc_array(scaling @ matrix @ scaling)


def factored(matrix: Matrix) -> Any:
    """LU factors of a sparse symmetric matrix, with the symmetric pattern as far as pivots allow."""
    options = {"SymmetricMode": True}
    return scipy.sparse.linalg.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)


def by_parts(solve: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A real factorization's solution, also for complex columns."""

    def solved(columns: Any) -> Any:
        if np.iscomplexobj(columns):
            return solve(np.ascontiguousarray(columns.real)) + 1j * solve(np.ascontiguousarray(columns.imag))
        return solve(np.ascontiguousarray(columns))

    return solved


ON_A_POLE = "the body is undamped and the band starts, ends or has a point at one of its natural frequencies"
# factor to avoid a frequency that equals an undamped natural frequency; the change of 1/H is negligible
OFF_THE_POLE = 1.0 + 1e-12


def solutions(
    body: Body, Psi: FloatArray, Omega: FloatArray, columns: ComplexArray, moved: float = 1.0, left: bool = False
) -> ComplexArray:
    """A(Psi, Omega)^-1 column for every point: (p,), (p,) and (n, p) -> (p, n); left: those of its transpose, which is A itself
    without first-order states.

    A point exactly on a natural frequency of an undamped body is moved slightly; moved: factor of the frequencies.

    Raises
    ------
    ReductionError
        There is no solution there either.
    """
    Psi = moved * Psi
    n = body.n_coordinates
    result = np.empty((len(Psi), n), complex)
    try:
        if scipy.sparse.issparse(body.mass):
            for i in range(len(Psi)):
                result[i] = _sparse_solution(body, Psi[i], Omega[i], columns[:, i], left)
        else:
            step = max(1, _BLOCK // (16 * n * n))
            for i in range(0, len(Psi), step):
                part = slice(i, i + step)
                matrices = dynamic_stiffness(body, Psi[part], Omega[part])
                matrices = matrices.swapaxes(1, 2) if left else matrices
                result[part] = np.linalg.solve(matrices, columns.T[part, :, None])[..., 0]
        finite = bool(np.isfinite(result).all())
    except (np.linalg.LinAlgError, RuntimeError):
        finite = False
    if finite:
        return result
    if moved > 1.0:
        raise ReductionError(ON_A_POLE)
    return solutions(body, Psi, Omega, columns, OFF_THE_POLE, left)


def _sparse_solution(body: Body, Psi: float, Omega: float, column: ComplexArray, left: bool) -> ComplexArray:
    """One solution with iterative refinement: elimination without row exchanges loses digits."""
    states: Any = body
    motion = responding(body, Psi) if body.n_states else None
    scale = 1.0 / np.sqrt(body.stiffness.diagonal())
    factor = factored(_scaled(dynamic_stiffness(body, Psi, Omega), scale))
    terms = terms_of(body)
    x, residual = np.zeros(len(column), complex), column
    for _ in range(1 + _CORRECTIONS):
        x = x + scale * factor.solve(scale * residual, "T" if left else "N")
        forces = sum(share * product(terms[name], x) for name, share in factors_of(body, Psi, Omega).items())
        if motion is not None:
            forces = forces - (motion.T @ (states.state_force.T @ x) if left else states.state_force @ (motion @ x))
        residual = (column - forces).astype(complex)
    return x


def product(matrix: Matrix, columns: NDArray[Any]) -> NDArray[Any]:
    """matrix @ columns in extended precision, where available.

    The forces of a smooth deflection are small differences of large numbers: with a fine mesh its stiffness would otherwise be
    known only up to rounding times the squared ratio of the highest natural frequency to its own.
    """
    return matrix.astype(np.longdouble) @ columns.astype(np.clongdouble if np.iscomplexobj(columns) else np.longdouble)


def highest_frequency(body: Body, shift: float = 0.0) -> float:
    """Highest undamped natural frequency at standstill, rad/s; infinite if a coordinate has no mass. shift: (rad/s)^2, such that
    K + shift M is positive definite."""
    if not scipy.sparse.issparse(body.mass):
        slowness = scipy.linalg.eigvalsh(body.mass, body.stiffness + shift * body.mass if shift else body.stiffness).min()
        if not slowness > 0.0:
            return float("inf")
        return float(np.sqrt(1.0 / slowness - shift)) if shift else float(1.0 / np.sqrt(slowness))
    diagonal = body.mass.diagonal()
    if (diagonal <= 0.0).any():
        return float("inf")
    scale = 1.0 / np.sqrt(diagonal)
    mass, stiffness = _scaled(body.mass, scale), _scaled(body.stiffness, scale)
    try:
        inverse = scipy.sparse.linalg.LinearOperator(mass.shape, matvec=factored(mass).solve)
    except RuntimeError:
        return float("inf")
    start = np.cos(np.arange(len(diagonal)))  # reproducible
    options = {"which": "LM", "tol": 1e-3, "v0": start, "return_eigenvectors": False}
    square = scipy.sparse.linalg.eigsh(stiffness, 1, M=mass, Minv=inverse, **options)
    return float(np.sqrt(square[0]))
