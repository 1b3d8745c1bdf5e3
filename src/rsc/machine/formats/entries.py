"""Shared by the text readers: lines and numbers from text, sparse matrices from (row, column, value).

Every size is checked against the length of the file or a limit before memory is allocated. No list of all lines is ever made:
short lines would take fifty times their bytes.
"""

import io
import re
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
import scipy.sparse

from rsc.errors import one_line
from rsc.files import memory
from rsc.files.memory import Memory

MOST_BYTES = memory.MOST  # for all numbers of one matrix
MOST_COORDINATES = 2_000_000  # rows or columns of a matrix
MOST_NUMBERS = 60_000_000  # of one matrix in a text: 3 GB while being converted
_BLOCK = 2**19  # bytes of a text processed at a time
_SPACE = re.compile(rb"\s")
_INT32 = 2**31 - 1
_EXPONENTS = bytes.maketrans(b"Dd", b"Ee")  # Fortran exponents


class BadMatrix(ValueError):
    """A file without a usable matrix; the message gives the reason in one line, without the file name."""


class Budgeted(dict):
    """Matrices by name, limited to `most` bytes in total; the last one is counted in its own type, before conversion to
    float64."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self.memory = Memory(most)

    def __setitem__(self, name: str, matrix: Any) -> None:
        parts = (matrix.data, matrix.indices, matrix.indptr) if scipy.sparse.issparse(matrix) else (matrix,)
        for part in parts:
            self.memory.take(one_line(name)[:40], part.size, part.itemsize)
        super().__setitem__(name, matrix)


class TextLines:
    """Iterator over the lines of a text (bytes), without line ends."""

    def __init__(self, content: bytes) -> None:
        self._content, self._file = content, io.BytesIO(content)

    def next(self) -> bytes:
        """The next line.

        Raises
        ------
        BadMatrix
            At the end of the text.
        """
        line = self._file.readline()
        if not line:
            raise BadMatrix("it is cut off")
        return line.rstrip(b"\r\n")

    def text(self, count: int) -> bytes:
        """The next `count` lines unchanged, fewer at the end of the text."""
        start = self._file.tell()
        for _ in range(count):
            if not self._file.readline():
                break
        return self._content[start : self._file.tell()]

    def __iter__(self) -> Iterator[bytes]:
        """The remaining lines."""
        return (line.rstrip(b"\r\n") for line in self._file)


def blocks(text: bytes, ends: re.Pattern[bytes] = re.compile(rb"\n")) -> Iterator[bytes]:
    """A text in blocks of at least `_BLOCK` bytes, cut after line ends or after matches of another pattern."""
    place = 0
    while place < len(text):
        border = ends.search(text, place + _BLOCK)
        end = border.end() if border else len(text)
        yield text[place:end]
        place = end


def without(text: bytes, lines: re.Pattern[bytes]) -> bytes:
    """The text without the lines that match a pattern."""
    kept = bytearray()
    for block in blocks(text):
        kept += lines.sub(b"", block)
    return bytes(kept)


def numbers(text: bytes) -> Any:
    """All numbers of a text (bytes), separated by white space, as float64.

    Raises
    ------
    BadMatrix
        It contains anything else, or more than `MOST_NUMBERS` numbers.
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


def _numbers(text: bytes) -> Any:
    if b"D" in text or b"d" in text:
        text = text.translate(_EXPONENTS)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy before 2.3 warned about what it now refuses
        try:
            return np.fromstring(text, sep=" ")
        except (ValueError, DeprecationWarning):
            raise BadMatrix("there is something other than a number among its numbers") from None


def columns(text: bytes, width: int) -> Any:
    """Numbers of a text as (lines, width); actual line breaks do not matter."""
    values = numbers(text)
    if len(values) % width:
        raise BadMatrix(f"its {len(values)} numbers do not form lines of {width}")
    return values.reshape(-1, width)


def whole(values: Any, least: int, most: int, what: str) -> Any:
    """Numbers as integers (64-bit if `most` requires it); BadMatrix if one is not an integer from least to most."""
    values = np.asarray(values)
    with np.errstate(invalid="ignore"):
        fit = np.all((values >= least) & (values <= most)) and np.all(values == np.floor(values))
    if not fit:
        raise BadMatrix(f"{what} is not an integer from {least} to {most}")
    return values.astype(np.int64 if most > _INT32 else np.int32)


def check_shape(rows: int, columns: int) -> None:
    """BadMatrix for the shape of an empty or too large matrix, before it is created."""
    if not (0 < rows <= MOST_COORDINATES and 0 < columns <= MOST_COORDINATES):
        raise BadMatrix(f"its size is {rows} x {columns}; at most {MOST_COORDINATES} coordinates are read")


def sparse(i: Any, j: Any, values: Any, shape: tuple[int, ...], mirror: int = 0) -> Any:
    """Sparse matrix from its entries; duplicates are summed.

    Parameters
    ----------
    i, j : (n,) int array, zero-based
    values : (n,) float array
    shape : (rows, columns)
    mirror : int
        1 if the entries are one triangle of a symmetric matrix, -1 of a skew-symmetric one, 0 for the full matrix.

    Returns
    -------
    scipy.sparse.csc_array
    """
    check_shape(*shape)
    if mirror:
        if shape[0] != shape[1]:
            raise BadMatrix(f"its size is {shape[0]} x {shape[1]} but it is declared symmetric")
        off = i != j
        if np.any(i[off] > j[off]) and np.any(i[off] < j[off]):
            raise BadMatrix("it is declared symmetric but has entries on both sides of its diagonal")
        i, j, values = np.concatenate([i, j[off]]), np.concatenate([j, i[off]]), np.concatenate([values, mirror * values[off]])
    matrix = scipy.sparse.coo_array((values, (i, j)), shape=shape).tocsc()
    matrix.sum_duplicates()
    matrix.eliminate_zeros()
    return matrix
