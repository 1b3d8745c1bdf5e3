"""Eigenvalues of the real matrices of the analysis, by the routines that are fastest for their size."""

import numpy as np
import scipy

from rsc.analysis.algebra.double_shift import hessenberg_eigenvalues
from rsc.system.blas import one_thread

# for fewer rows our own iteration gains less than its compilation and loading cost; for more LAPACK's driver, which takes a
# multishift iteration from 76 rows on, catches up (measured)
_LEAST, _MOST = 40, 500
_TINY, _HUGE = 1e-100, 1e100  # the driver scales matrices whose squares could leave the range of numbers


def eigenvalues(matrices):
    """Eigenvalues of real square matrices.

    Parameters
    ----------
    matrices : (..., n, n) float

    Returns
    -------
    (..., n) complex, or float where numpy.linalg.eigvals gives such; in no order

    Raises
    ------
    numpy.linalg.LinAlgError
        Numbers that are not finite, or no convergence.
    """
    n = matrices.shape[-1]
    if not _LEAST <= n <= _MOST:
        return np.linalg.eigvals(matrices)
    with one_thread:
        values = [_large_eigenvalues(matrix) for matrix in matrices.reshape(-1, n, n)]
    return np.array(values).reshape(matrices.shape[:-1])


def _large_eigenvalues(matrix):
    """Eigenvalues (n,) of one matrix, balanced and brought to Hessenberg form first."""
    n = len(matrix)
    if not _TINY < np.abs(matrix).max() < _HUGE:  # also without finite numbers
        return np.linalg.eigvals(matrix)
    # the transpose lies as Fortran wants it; rows and columns outside low to high are triangular already
    balanced, low, high, _, _ = scipy.linalg.lapack.dgebal(matrix.T, permute=1, scale=1)
    reduced, _, _ = scipy.linalg.lapack.dgehrd(balanced, lo=low, hi=high, lwork=64 * n, overwrite_a=1)
    values, inner = reduced.diagonal().astype(complex), slice(low, high + 1)
    block_values = hessenberg_eigenvalues(np.triu(np.ascontiguousarray(reduced[inner, inner]), -1))
    if block_values is None:
        return np.linalg.eigvals(matrix)
    values[inner] = block_values
    return values
