"""What the readers of text share: lines and numbers from text, and sparse matrices from (row, column, value).

Every size is held against the length of the file or a cap before anything is allocated. A list of all lines is never made: short
lines would take fifty times their bytes.
"""

import io
import re
import warnings

import numpy as np
import scipy.sparse

from rsc.errors import one_line
from rsc.files import memory
from rsc.files.memory import Memory

MOST_BYTES = memory.MOST  # of all numbers of one matrix
MOST_COORDINATES = 2_000_000  # rows or columns of a matrix
MOST_NUMBERS = 60_000_000  # of one matrix in a text: 3 GB while they become a matrix
_BLOCK = 2**19  # bytes of a text that are looked at together
_SPACE = re.compile(rb"\s")
_INT32 = 2**31 - 1
_EXPONENTS = bytes.maketrans(b"Dd", b"Ee")  # Fortran's


class BadMatrix(ValueError):
    """Why a file holds no matrix that can be used, in one line without the file's name."""


class Budgeted(dict):
    """Matrices by name, which take no more than `most` bytes together in float64, but for the last one before it becomes that."""

    def __init__(self, most):
        super().__init__()
        self.memory = Memory(most)

    def __setitem__(self, name, matrix):
        parts = (matrix.data, matrix.indices, matrix.indptr) if scipy.sparse.issparse(matrix) else (matrix,)
        for part in parts:
            self.memory.take(one_line(name)[:40], part.size, part.itemsize)
        super().__setitem__(name, matrix)


class TextLines:
    """The lines of a text (bytes), one after another, without their ends."""

    def __init__(self, content):
        self._content, self._file = content, io.BytesIO(content)

    def next(self):
        """The next line.

        Raises
        ------
        BadMatrix
            There is none.
        """
        line = self._file.readline()
        if not line:
            raise BadMatrix("it is cut off")
        return line.rstrip(b"\r\n")

    def text(self, count):
        """The next `count` lines as they are, fewer at the end of the text."""
        start = self._file.tell()
        for _ in range(count):
            if not self._file.readline():
                break
        return self._content[start : self._file.tell()]

    def __iter__(self):
        """The lines that are left."""
        return (line.rstrip(b"\r\n") for line in self._file)


def blocks(text, ends=re.compile(rb"\n")):
    """A text in pieces of some megabytes, cut behind the ends of lines, or where else a pattern fits."""
    place = 0
    while place < len(text):
        border = ends.search(text, place + _BLOCK)
        end = border.end() if border else len(text)
        yield text[place:end]
        place = end


def without(text, lines):
    """The text without the lines that a pattern matches."""
    kept = bytearray()
    for block in blocks(text):
        kept += lines.sub(b"", block)
    return bytes(kept)


def numbers(text):
    """All numbers of a text (bytes), separated by white space, as float64.

    Raises
    ------
    BadMatrix
        Anything else than numbers stands there, or more than `MOST_NUMBERS`.
    """
    if len(text) > _BLOCK:
        parts, count = [], 0
        for block in blocks(text, _SPACE):
            parts.append(_numbers(block))
            count += len(parts[-1])
            if count > MOST_NUMBERS:
                raise BadMatrix(f"it has more than {MOST_NUMBERS} numbers; write such matrices as .npz or MAT-file")
        return np.concatenate(parts)
    return _numbers(text)


def _numbers(text):
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
    """Numbers as integers, of 64 bits where `most` needs them, after a check that they are whole and from least to most."""
    values = np.asarray(values)
    with np.errstate(invalid="ignore"):
        fit = np.all((values >= least) & (values <= most)) and np.all(values == np.floor(values))
    if not fit:
        raise BadMatrix(f"{what} is no whole number from {least} to {most}")
    return values.astype(np.int64 if most > _INT32 else np.int32)


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
