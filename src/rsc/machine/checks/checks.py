"""Checks of the matrices of a body: symmetry, definiteness, plausible units; for rigid-body motions see rank.py.

The number of negative eigenvalues equals that of negative pivots (Sylvester's law of inertia). SciPy returns the pivots of a
sparse factorisation only with a copy of all factors, more than a gigabyte for a casing of 100,000 coordinates. In large matrices
negative eigenvalues are therefore searched for by Lanczos iteration, with the matrix, which shows its lowest eigenvalues first,
and with its inverse, which shows those near zero. Those found exist; one in between may be missed.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg

from rsc.errors import DataError
from rsc.machine.model.model import FiniteElementModel

SYMMETRIC = 1e-8  # largest difference across the diagonal, relative to the largest entry
_COUNTED = 20_000  # coordinates up to which the pivots of a sparse matrix are counted
# Lanczos steps, and the largest negative eigenvalue due to rounding, relative to the largest one: for a matrix, and for
# a computed inverse
_LANCZOS, _LANCZOS_INVERSE = (200, 1e-9), (40, 1e-4)
_LONGEST, _LENGTHIEST = 3.0, 100.0  # m: beyond, lengths of an element and of a machine are more likely millimetres
_SOLID = (1e20, 1e26)  # stiffness^3 / mass of finite elements of metal in N/mm and tonnes; 1e29 and more in SI
_FREQUENCIES = (1e-2, 1e5)  # Hz, plausible range of a body's lowest mode


def symmetric(matrix: Any, what: str, source: str, sign: int = 1) -> Any:
    """The symmetric (sign -1: skew-symmetric) part of a matrix that is symmetric up to rounding.

    Raises
    ------
    DataError
        It is not symmetric.
    """
    difference = 0.5 * (matrix - sign * matrix.T)
    size = np.abs(matrix.data).max(initial=0.0) if scipy.sparse.issparse(matrix) else np.abs(matrix).max()
    if size > 0.0 and abs(difference).max() > SYMMETRIC * size:
        flat = abs(difference)
        i, j = np.unravel_index(flat.argmax(), matrix.shape)
        word = "symmetric" if sign > 0 else "skew-symmetric"
        raise DataError(source, f"{what} is not {word}: entries {i + 1}, {j + 1} and {j + 1}, {i + 1} differ")
    return matrix - difference


def inertia(matrix: Any) -> tuple[int, Any]:
    """(number of negative eigenvalues, solver) of a nonsingular real symmetric matrix.

    The solver is a function of the right-hand side; None if there are negative eigenvalues.
    """
    if not scipy.sparse.issparse(matrix):
        try:
            factors = scipy.linalg.cho_factor(matrix, check_finite=False)
        except np.linalg.LinAlgError:
            return int(np.sum(scipy.linalg.eigvalsh(matrix) < 0.0)), None
        return 0, lambda force: scipy.linalg.cho_solve(factors, force)
    try:
        sparse_factors = factors_of(matrix)
    except RuntimeError:  # singular
        return 1, None
    if not np.array_equal(sparse_factors.perm_r, sparse_factors.perm_c):
        return 1, None  # an off-diagonal pivot: there was no positive diagonal one
    if matrix.shape[0] > _COUNTED:
        size = np.sqrt(np.abs(matrix.diagonal()))
        inverse = has_negative(lambda x: size * sparse_factors.solve(size * x), len(size), *_LANCZOS_INVERSE)
        return int(inverse or has_negative(_scaled(matrix).dot, len(size), *_LANCZOS)), sparse_factors.solve
    return int(np.sum(sparse_factors.U.diagonal() < 0.0)), sparse_factors.solve


def has_negative(product: Callable[[Any], Any], size: int, steps: int, rounding: float) -> bool:
    """Whether Lanczos iteration finds a negative eigenvalue of a symmetric matrix (of its projection on a Krylov space).

    Parameters
    ----------
    product : function (n,) -> (n,)
    size, steps : int
        n, and the largest dimension of the Krylov space.
    rounding : float
        Negative eigenvalues smaller than this, relative to the largest, count as zero.
    """
    last, vector, beta = np.zeros(size), np.random.default_rng(1).normal(size=size), 0.0
    vector /= np.linalg.norm(vector)
    diagonal, off_diagonal = [], []
    for _ in range(min(steps, size)):
        image = product(vector) - beta * last
        diagonal.append(vector @ image)
        image -= diagonal[-1] * vector
        beta = float(np.linalg.norm(image))
        if beta <= 1e-12 * max(map(abs, diagonal)):
            break
        off_diagonal.append(beta)
        last, vector = vector, image / beta
    values = scipy.linalg.eigvalsh_tridiagonal(diagonal, off_diagonal[: len(diagonal) - 1])
    return bool(values[0] < -rounding * np.abs(values).max())


def _scaled(matrix: Any) -> Any:
    """The sparse matrix scaled to a diagonal of +-1; its inertia is unchanged."""
    scale = scipy.sparse.diags_array(1.0 / np.sqrt(np.abs(matrix.diagonal())))
    return scipy.sparse.csr_array(scale @ matrix @ scale)


def factors_of(matrix: Any) -> Any:
    """LU factors of a sparse matrix with symmetric pattern, with diagonal pivots, which keeps the factors sparse.

    Raises
    ------
    RuntimeError
        The matrix is singular.
    """
    options = {"SymmetricMode": True}
    return scipy.sparse.linalg.splu(
        scipy.sparse.csc_array(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options
    )


def semidefinite(matrix: Any, what: str, source: str) -> None:
    """DataError for a symmetric matrix with a negative eigenvalue; empty rows are ignored."""
    used = np.flatnonzero(largest_of_rows(matrix))
    if used.size == 0:
        return
    part, size = matrix[used][:, used], largest_of_rows(matrix)[used]
    diagonal = part.diagonal()
    if np.all(diagonal > 0.0) and abs(part).sum() == diagonal.sum():  # lumped
        return
    scale = scipy.sparse.diags_array(1.0 / np.sqrt(size))
    scaled = scale @ part @ scale
    if scipy.sparse.issparse(matrix) and used.size > _COUNTED:
        if has_negative(scipy.sparse.csr_array(scaled).dot, used.size, *_LANCZOS):
            raise DataError(source, f"{what} is indefinite: it has negative eigenvalues")
        return
    floor = 1e-9 * (scipy.sparse.eye_array(used.size, format="csc") if scipy.sparse.issparse(matrix) else np.eye(used.size))
    if np.any(diagonal < 0.0) or inertia(scaled + floor)[0]:
        raise DataError(source, f"{what} is indefinite: it has negative eigenvalues")


def proportional(damping: Any, mass: Any, stiffness: Any) -> bool:
    """Whether a damping matrix is alpha M + beta K with nonnegative alpha and beta, and so needs no further check."""
    parts = [abs(matrix).max() for matrix in (damping, mass, stiffness)]
    c, m, k = (scipy.sparse.csc_array(matrix) / part for matrix, part in zip((damping, mass, stiffness), parts, strict=True))
    products = np.array([[(m * m).sum(), (m * k).sum()], [(m * k).sum(), (k * k).sum()]])
    shares = np.linalg.lstsq(products, np.array([(c * m).sum(), (c * k).sum()]), rcond=None)[0]
    return bool(np.all(shares >= -1e-12) and abs(c - shares[0] * m - shares[1] * k).max() < 1e-9)


def largest_of_rows(matrix: Any) -> Any:
    """Largest |entry| of every row, (n,)."""
    largest = abs(matrix).max(axis=1)
    return largest.toarray().ravel() if scipy.sparse.issparse(largest) else largest


def plausible(model: FiniteElementModel, frequency: float) -> None:
    """DataError for a model that looks like millimetres and tonnes, or whose units are inconsistent.

    Parameters
    ----------
    model : rsc.machine.model.model.Model
    frequency : float
        Its lowest natural frequency, Hz; infinite if unknown.
    """
    if not _FREQUENCIES[0] <= frequency <= _FREQUENCIES[1] and np.isfinite(frequency):
        raise DataError(
            model.source, f"its lowest natural frequency is {frequency:.3g} Hz: units of mass and stiffness are inconsistent"
        )
    hint = "if the units are millimetres, newtons, tonnes and seconds state that (units mm), otherwise confirm SI units (units m)"
    stiff, tilts = model.stiffness.diagonal(), model.kind == "tilt"
    nodes = {node: i for i, node in enumerate(model.node.tolist()) if model.kind[i] == "displacement"}
    both = [(stiff[i], stiff[nodes[node]]) for i, node in enumerate(model.node.tolist()) if tilts[i] and node in nodes]
    ratios = [tilt / displacement for tilt, displacement in both if displacement > 0.0]
    if ratios:
        length = np.sqrt(np.median(ratios))
        if length > _LONGEST:
            raise DataError(model.source, f"its elements look {length:.3g} m long: {hint}")
    elif model.n > 300:
        heavy = (model.mass.diagonal() > 0.0) & (stiff > 0.0)
        solid = np.median(stiff[heavy] ** 3 / model.mass.diagonal()[heavy])
        if _SOLID[0] < solid < _SOLID[1]:
            raise DataError(model.source, f"its elements are too soft for their mass: {hint}")
    span = max(model.position.values(), default=0.0) - min(model.position.values(), default=0.0)
    if span > _LENGTHIEST:
        raise DataError(model.source, f"it is {span:.3g} m long: {hint}")
