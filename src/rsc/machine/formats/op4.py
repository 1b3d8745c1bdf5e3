"""Nastran OUTPUT4 files written as text (FORMATTED): dense columns, and sparse ones as strings, plain and BIGMAT.

MSC Nastran DMAP Programmer's Guide, OUTPUT4: a header of columns, rows (negative: BIGMAT), form, type and name in fields of 8 and
the format of the numbers; then for each column that is not empty a line (column, first row or 0, words) and its numbers. The
sparse forms have 0 as the first row and then strings: L + 1 and the row on a line (BIGMAT), or row + 65536 (L + 1), where a
double takes L = 2 words; then the numbers of the string. A column behind the last one ends the matrix.
"""

import re
from array import array

import numpy as np

from rsc.machine.formats.entries import (
    MOST_BYTES,
    MOST_NUMBERS,
    BadMatrix,
    Budgeted,
    TextLines,
    check_shape,
    numbers,
    sparse,
    whole,
)

_HEADER = re.compile(rb" *\d+ *-?\d+ +\d+ +[1-4][A-Z][\w ]{0,7}((1P,)?\d*[ED]\d+\.\d+)?(\|I16)? *\r?$", re.IGNORECASE)
_FORMAT = re.compile(rb"(?:1P,)?(\d*)[ED](\d+)\.\d+", re.IGNORECASE)
_SYMMETRIC = 6  # form
_WIDEST = 120  # characters of a header: what is longer would take the square of its length
_TOGETHER = 10_000  # lines of numbers that are taken apart together


def recognises(head):
    """Whether a text begins with the header of a matrix."""
    return _HEADER.match(head.split(b"\n", 1)[0][:_WIDEST]) is not None


def recognises_binary(head):
    """Whether a file begins as OUTPUT4 in binary form: a Fortran record of six whole numbers of 4 or 8 bytes."""
    marks = {head[:4], head[28:32]}, {head[:4], head[52:56]}
    pairs = zip(marks, (24, 48), strict=True)
    return any(mark == {length.to_bytes(4, order)} for mark, length in pairs for order in ("little", "big"))


def read(content, most=MOST_BYTES):
    """All real matrices of the file, name -> scipy.sparse.csc_array; `most`: bytes of all."""
    lines, matrices = TextLines(content), Budgeted(most)
    for line in lines:
        if not line.strip():
            break
        name, matrix = _matrix(line, lines)
        if matrix is not None:
            matrices[name] = matrix
    return matrices


def _integers(text, count, width=8):
    """`count` integers from fields of one width."""
    values = [text[i : i + width] for i in range(0, count * width, width)]
    try:
        return [int(value) for value in values]
    except ValueError:
        raise BadMatrix(f"the line '{text[:60].decode('ascii', 'replace').strip()}' is no header of a column or string") from None


class _Numbers:
    """The numbers of one matrix, which stand in fields that may touch each other, so many on a line."""

    def __init__(self, lines, per_line, width):
        self._lines, self._per_line, self._width = lines, per_line, width

    def next(self, count):
        """The next `count` numbers."""
        parts = [np.zeros(0)]
        for begin in range(0, count, _TOGETHER * self._per_line):
            some = min(count - begin, _TOGETHER * self._per_line)
            lines = self._lines.text(-(-some // self._per_line)).splitlines()
            cells = [line[i : i + self._width] for line in lines for i in range(0, self._per_line * self._width, self._width)]
            parts.append(numbers(b" ".join(cells[:some])))
            if len(parts[-1]) != some:
                raise BadMatrix("a column or string is cut off")
        return np.concatenate(parts)


class _Runs:
    """Entries of a matrix as runs down its columns, in arrays that grow: a matrix may have millions of short ones."""

    def __init__(self):
        self._places, self._values = array("q"), array("d")

    def add(self, row, column, values):
        """Values of a column from a row on, both counted from 1."""
        self._places.extend((row - 1, column - 1, len(values)))
        self._values.frombytes(values.tobytes())
        if len(self._values) > MOST_NUMBERS:
            raise BadMatrix(f"it has more than {MOST_NUMBERS} numbers; write such matrices as .npz or MAT-file")

    def entries(self):
        """(rows, columns, values)."""
        first, columns, lengths = np.array(self._places).reshape(-1, 3).T
        before = np.cumsum(lengths) - lengths
        rows = np.arange(len(self._values)) - np.repeat(before - first, lengths)
        return rows, np.repeat(columns, lengths), np.array(self._values)


def _matrix(header, lines):
    """(name, matrix) of a header and the lines behind it; None for the matrix where it is complex."""
    header = header.rstrip()
    width = 16 if header.endswith(b"|I16") else 8
    sizes = _integers(header, 2, width)
    form, kind = _integers(header[2 * width :], 2)
    columns, rows, big = sizes[0], abs(sizes[1]), sizes[1] < 0
    name = header[2 * width + 16 : 2 * width + 24].decode("ascii", "replace").strip()
    layout = _FORMAT.search(header[2 * width + 24 : _WIDEST])
    check_shape(rows, columns)
    per_line, digits = (int(layout[1] or 1), int(layout[2])) if layout else (5, 16)
    if kind not in (1, 2, 3, 4) or not 0 < per_line * digits <= 400:
        raise BadMatrix(f"the matrix {name} has an unknown type, or its format fits no line")
    fields, runs = _Numbers(lines, per_line, digits), _Runs()
    while True:
        column, first, words = _integers(lines.next(), 3, width)
        if column > columns:
            fields.next(1)
            break
        if column < 1 or words < 1 or first < 0:
            raise BadMatrix(f"the matrix {name} has a column {column} of {words} words")
        strings = [(first, fields.next(words))] if first else _strings(lines, fields, words, (2 - kind % 2, big, width))
        for row, values in strings:
            if kind <= 2:
                runs.add(row, column, values)
    if kind > 2:
        return name, None
    i, j, values = runs.entries()
    i = whole(i, 0, rows - 1, "a row")
    half = form == _SYMMETRIC and bool(np.all(i >= j) or np.all(i <= j)) and bool(np.any(i != j))
    return name, sparse(i, j, values, (rows, columns), int(half))


def _strings(lines, fields, words, form):
    """(row, values) of the strings of a sparse column.

    form : (words that a number takes: 1 or, double, 2; whether it is BIGMAT; width of whole numbers)
    """
    per_number, big, width = form
    while words > 0:
        if big:
            length, row = _integers(lines.next(), 2, width)
        else:
            (packed,) = _integers(lines.next(), 1, 2 * width)
            length, row = packed >> 16, packed & 0xFFFF
        if length < 2 or (length - 1) % per_number:
            raise BadMatrix("a string has a length that does not fit its type")
        words -= length + big
        yield row, fields.next((length - 1) // per_number)
