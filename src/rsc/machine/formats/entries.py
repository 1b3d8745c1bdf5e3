"""What the readers of text share: numbers from text, and sparse matrices from (row, column, value).

Every size is held against the length of the file or a cap before anything is allocated.
"""

import warnings

import numpy as np
import scipy.sparse

MOST_COORDINATES = 2_000_000  # rows or columns of a matrix
MOST_BYTES = 2**30  # of all numbers of one matrix
_EXPONENTS = bytes.maketrans(b"Dd", b"Ee")  # Fortran's


class BadMatrix(ValueError):
    """Why a file holds no matrix that can be used, in one line without the file's name."""


def numbers(text):
    """All numbers of a text (bytes), separated by white space, as float64.

    Raises
    ------
    BadMatrix
        Anything else than numbers stands there.
    """
    if b"D" in text or b"d" in text:
        text = text.translate(_EXPONENTS)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy before 2.3 warned of what it now refuses
        try:
            return np.fromstring(text, sep=" ")
        except (ValueError, DeprecationWarning):
            raise BadMatrix("something that is no number stands among its numbers") from None


def columns(text, width):
    """Numbers of a text as (lines, width), which need not stand on lines of their own."""
    values = numbers(text)
    if len(values) % width:
        raise BadMatrix(f"its {len(values)} numbers are no lines of {width}")
    return values.reshape(-1, width)


def whole(values, least, most, what):
    """Numbers as int64 after a check that they are whole and from least to most."""
    values = np.asarray(values)
    with np.errstate(invalid="ignore"):
        fit = np.all((values >= least) & (values <= most)) and np.all(values == np.floor(values))
    if not fit:
        raise BadMatrix(f"{what} is no whole number from {least} to {most}")
    return values.astype(np.int64)


def check_shape(rows, columns):
    """Refuse a matrix that is empty or too large before it is made."""
    if not (0 < rows <= MOST_COORDINATES and 0 < columns <= MOST_COORDINATES):
        raise BadMatrix(f"its size is {rows} x {columns}; at most {MOST_COORDINATES} coordinates are read")


def sparse(i, j, values, shape, mirror=0):
    """Sparse matrix from its entries, those at one place added up.

    Parameters
    ----------
    i, j : (n,) int array, from 0
    values : (n,) float array
    shape : (rows, columns)
    mirror : int
        1 where the entries are one triangle of a symmetric matrix, -1 of a skew-symmetric one, 0 where they are all of it.

    Returns
    -------
    scipy.sparse.csc_array
    """
    check_shape(*shape)
    if mirror:
        if shape[0] != shape[1]:
            raise BadMatrix(f"its size is {shape[0]} x {shape[1]} and it is called symmetric")
        off = i != j
        if np.any(i[off] > j[off]) and np.any(i[off] < j[off]):
            raise BadMatrix("it is called symmetric and has entries on both sides of its diagonal")
        i, j, values = np.concatenate([i, j[off]]), np.concatenate([j, i[off]]), np.concatenate([values, mirror * values[off]])
    matrix = scipy.sparse.coo_array((values, (i, j)), shape=shape).tocsc()
    matrix.sum_duplicates()
    matrix.eliminate_zeros()
    return matrix
