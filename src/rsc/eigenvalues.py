"""Eigenvalues of the real matrices of the analysis: LAPACK's, by the iteration that is fastest for their size."""

import ctypes

import numpy as np
from numba.extending import get_cython_function_address
from scipy.linalg import lapack

from rsc.blas import one_thread

# the driver behind numpy.linalg.eigvals takes a multishift iteration for more rows than the first; up to the second the
# double-shift iteration that it takes for fewer rows is faster (bench/suite/test_analysis.py)
_DRIVER, _LARGEST = 75, 250

_lapack_routine = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 14)
_double_shift = _lapack_routine(get_cython_function_address("scipy.linalg.cython_lapack", "dlahqr"))


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
    if not _DRIVER < n <= _LARGEST or not np.isfinite(matrices).all():
        return np.linalg.eigvals(matrices)
    with one_thread:
        found = [_of_one(matrix) for matrix in matrices.reshape(-1, n, n)]
    return np.array(found).reshape(matrices.shape[:-1])


def _of_one(matrix):
    """Eigenvalues (n,) of one matrix, balanced and brought to Hessenberg form first."""
    n = len(matrix)
    # the transpose lies as Fortran wants it; rows and columns outside low to high are triangular already
    balanced, low, high, _, _ = lapack.dgebal(matrix.T, permute=1, scale=1)
    hessenberg, _, _ = lapack.dgehrd(balanced, lo=low, hi=high, lwork=64 * n, overwrite_a=1)
    real, imaginary, failed = hessenberg.diagonal().copy(), np.zeros(n), ctypes.c_int(0)
    no, one, first, last, size = (ctypes.byref(ctypes.c_int(i)) for i in (0, 1, low + 1, high + 1, n))
    h, re, im = (ctypes.c_void_p(array.ctypes.data) for array in (hessenberg, real, imaginary))
    # eigenvalues alone: neither the Schur form nor its vectors
    _double_shift(no, no, size, first, last, h, size, re, im, one, size, None, one, ctypes.byref(failed))
    if failed.value:
        return np.linalg.eigvals(matrix)
    return real + 1j * imaginary
