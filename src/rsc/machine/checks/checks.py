"""What matrices of a body must fulfil: symmetry, definiteness, units that fit; that nothing moves freely: rank.py.

Numbers of negative eigenvalues are those of negative pivots (Sylvester's law of inertia). SciPy gives the pivots of a sparse
factorisation only with a copy of all its factors, which for a casing of 100,000 coordinates is more than a gigabyte. So in large
matrices negative eigenvalues are looked for by Lanczos's method, in the matrix, whose lowest are then among the first to be seen,
and in its inverse, which shows those next to zero. What is found is there; one in between may be missed.
"""

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg

from rsc.errors import DataError

SYMMETRIC = 1e-8  # largest difference across the diagonal, of the rows' sizes
_COUNTED = 20_000  # coordinates of a sparse matrix up to which pivots are counted
# steps of Lanczos's method, and the negative part of what it finds that rounding can leave, of the largest: for a matrix, and for
# a computed inverse
_LANCZOS, _LANCZOS_INVERSE = (200, 1e-9), (40, 1e-4)
_LONGEST, _LENGTHIEST = 3.0, 100.0  # m: an element, and a machine, that are more likely millimetres
_SOLID = (1e20, 1e26)  # stiffness^3 / mass of finite elements of metal in N/mm and tonnes; 1e29 and more in SI
_FREQUENCIES = (1e-2, 1e5)  # Hz, of a body's lowest mode


def symmetric(matrix, what, source, sign=1):
    """The symmetric (sign -1: skew-symmetric) part of a matrix that is that up to rounding.

    Raises
    ------
    DataError
        It is not.
    """
    difference = 0.5 * (matrix - sign * matrix.T)
    size = np.abs(matrix.data).max(initial=0.0) if scipy.sparse.issparse(matrix) else np.abs(matrix).max()
    if size > 0.0 and abs(difference).max() > SYMMETRIC * size:
        flat = abs(difference)
        i, j = np.unravel_index(flat.argmax(), matrix.shape)
        word = "symmetric" if sign > 0 else "skew-symmetric"
        raise DataError(source, f"{what} is not {word}: entries {i + 1}, {j + 1} and {j + 1}, {i + 1} differ")
    return matrix - difference


def inertia(matrix):
    """(number of negative eigenvalues, solver) of a real symmetric matrix without a zero eigenvalue.

    The solver is a function of a right-hand side; None where there are negative eigenvalues.
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
        return 1, None  # a pivot off the diagonal: there is no positive one on it
    if matrix.shape[0] > _COUNTED:
        size = np.sqrt(np.abs(matrix.diagonal()))
        inverse = has_negative(lambda x: size * sparse_factors.solve(size * x), len(size), *_LANCZOS_INVERSE)
        return int(inverse or has_negative(_scaled(matrix).dot, len(size), *_LANCZOS)), sparse_factors.solve
    return int(np.sum(sparse_factors.U.diagonal() < 0.0)), sparse_factors.solve


def has_negative(product, size, steps, rounding):
    """Whether Lanczos's method finds a negative eigenvalue of a symmetric matrix: its projection on a Krylov space has one.

    Parameters
    ----------
    product : function (n,) -> (n,)
    size, steps : int
        n, and the most dimensions of that space.
    rounding : float
        Negative part that is none, of the largest eigenvalue found.
    """
    last, vector, beta = np.zeros(size), np.random.default_rng(1).normal(size=size), 0.0
    vector /= np.linalg.norm(vector)
    diagonal, beside = [], []
    for _ in range(min(steps, size)):
        image = product(vector) - beta * last
        diagonal.append(vector @ image)
        image -= diagonal[-1] * vector
        beta = np.linalg.norm(image)
        if beta <= 1e-12 * max(map(abs, diagonal)):
            break
        beside.append(beta)
        last, vector = vector, image / beta
    values = scipy.linalg.eigvalsh_tridiagonal(diagonal, beside[: len(diagonal) - 1])
    return bool(values[0] < -rounding * np.abs(values).max())


def _scaled(matrix):
    """The sparse matrix with a diagonal of ones but for its signs; the inertia is the same."""
    scale = scipy.sparse.diags_array(1.0 / np.sqrt(np.abs(matrix.diagonal())))
    return scipy.sparse.csr_array(scale @ matrix @ scale)


def factors_of(matrix):
    """LU factors of a sparse matrix with a symmetric pattern, with pivots on its diagonal, which keeps them sparse.

    Raises
    ------
    RuntimeError
        The matrix is singular.
    """
    options = {"SymmetricMode": True}
    return scipy.sparse.linalg.splu(
        scipy.sparse.csc_array(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options
    )


def semidefinite(matrix, what, source):
    """Refuse a symmetric matrix with a negative eigenvalue; rows without entries are left aside."""
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


def proportional(damping, mass, stiffness):
    """Whether a damping matrix is a sum of shares, not negative, of mass and stiffness, and so needs no other check."""
    parts = [abs(matrix).max() for matrix in (damping, mass, stiffness)]
    c, m, k = (scipy.sparse.csc_array(matrix) / part for matrix, part in zip((damping, mass, stiffness), parts, strict=True))
    products = np.array([[(m * m).sum(), (m * k).sum()], [(m * k).sum(), (k * k).sum()]])
    shares = np.linalg.lstsq(products, np.array([(c * m).sum(), (c * k).sum()]), rcond=None)[0]
    return bool(np.all(shares >= -1e-12) and abs(c - shares[0] * m - shares[1] * k).max() < 1e-9)


def largest_of_rows(matrix):
    """Largest |entry| of every row, (n,)."""
    largest = abs(matrix).max(axis=1)
    return largest.toarray().ravel() if scipy.sparse.issparse(largest) else largest


def plausible(model, frequency):
    """Refuse a model whose numbers look like millimetres and tonnes, or whose units cannot fit each other.

    Parameters
    ----------
    model : rsc.machine.model.model.Model
    frequency : float
        Its lowest natural frequency, Hz, or infinite where it is not known.
    """
    if not _FREQUENCIES[0] <= frequency <= _FREQUENCIES[1] and np.isfinite(frequency):
        raise DataError(
            model.source, f"its lowest natural frequency is {frequency:.3g} Hz: units of mass and stiffness do not fit"
        )
    hint = "if they are millimetres, newtons, tonnes and seconds say so (units mm), otherwise confirm SI units (units m)"
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
