"""Nastran OUTPUT4 files written as text (FORMATTED): dense columns, and sparse ones as strings, plain and BIGMAT.

MSC Nastran DMAP Programmer's Guide, OUTPUT4: a header of columns, rows (negative: BIGMAT), form, type and name in fields of 8 and
the format of the numbers; then for each column that is not empty a line (column, first row or 0, words) and its numbers. The
sparse forms have 0 as the first row and then strings: L + 1 and the row on a line (BIGMAT), or row + 65536 (L + 1), where a
double takes L = 2 words; then the numbers of the string. A column behind the last one ends the matrix.
"""

import re

import numpy as np

from rsc.machine.formats.entries import BadMatrix, check_shape, numbers, sparse, whole

_HEADER = re.compile(rb" *\d+ *-?\d+ +\d+ +[1-4][A-Z][\w ]{0,7}((1P,)?\d*[ED]\d+\.\d+)?(\|I16)? *\r?$", re.IGNORECASE)
_FORMAT = re.compile(rb"(?:1P,)?(\d*)[ED](\d+)\.\d+", re.IGNORECASE)
_SYMMETRIC = 6  # form


def recognises(head):
    """Whether a text begins with the header of a matrix."""
    return _HEADER.match(head.split(b"\n", 1)[0]) is not None


def read(content):
    """All real matrices of the file, name -> scipy.sparse.csc_array."""
    lines, place, matrices = content.splitlines(), 0, {}
    while place < len(lines) and lines[place].strip():
        matrix, name, place = _matrix(lines, place)
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


class _Lines:
    """The lines of one matrix, read from the place on."""

    def __init__(self, lines, place, per_line, width):
        self._lines, self.place, self._per_line, self._width = lines, place, per_line, width

    def next(self):
        if self.place >= len(self._lines):
            raise BadMatrix("a matrix is cut off")
        self.place += 1
        return self._lines[self.place - 1]

    def numbers(self, count):
        """The next `count` numbers, which stand in fields that may touch each other."""
        n_lines = -(-count // self._per_line)
        lines = self._lines[self.place : self.place + n_lines]
        self.place += n_lines
        cells = [line[i : i + self._width] for line in lines for i in range(0, self._per_line * self._width, self._width)]
        values = numbers(b" ".join(cells[:count]))
        if len(values) != count:
            raise BadMatrix("a column or string is cut off")
        return values


def _matrix(lines, place):
    """(matrix or None for a complex one, name, place of the next one)."""
    header = lines[place].rstrip()
    width = 16 if header.endswith(b"|I16") else 8
    sizes = _integers(header, 2, width)
    form, kind = _integers(header[2 * width :], 2)
    columns, rows, big = sizes[0], abs(sizes[1]), sizes[1] < 0
    name = header[2 * width + 16 : 2 * width + 24].decode("ascii", "replace").strip()
    layout = _FORMAT.search(header[2 * width + 24 :])
    check_shape(rows, columns)
    per_line, digits = (int(layout[1] or 1), int(layout[2])) if layout else (5, 16)
    if kind not in (1, 2, 3, 4) or not 0 < per_line * digits <= 400:
        raise BadMatrix(f"the matrix {name} has an unknown type, or its format fits no line")
    text, parts = _Lines(lines, place + 1, per_line, digits), []
    while True:
        column, first, words = _integers(text.next(), 3, width)
        if column > columns:
            text.numbers(1)
            break
        if column < 1 or words < 1:
            raise BadMatrix(f"the matrix {name} has a column {column} of {words} words")
        for row, values in [(first, text.numbers(words))] if first else _strings(text, words, 2 - kind % 2, big, width):
            parts.append((row - 1 + np.arange(len(values)), np.full(len(values), column - 1), values))
    if kind > 2:
        return None, name, text.place
    i, j, values = (
        (np.concatenate(part) for part in zip(*parts, strict=True)) if parts else (np.zeros(0, int),) * 2 + (np.zeros(0),)
    )
    i = whole(i, 0, rows - 1, "a row")
    half = form == _SYMMETRIC and bool(np.all(i >= j) or np.all(i <= j)) and bool(np.any(i != j))
    return sparse(i, j, values, (rows, columns), int(half)), name, text.place


def _strings(text, words, per_number, big, width):
    """(row, values) of the strings of a sparse column whose numbers take 1 word or, double, 2."""
    while words > 0:
        if big:
            length, row = _integers(text.next(), 2, width)
        else:
            (packed,) = _integers(text.next(), 1, 2 * width)
            length, row = packed >> 16, packed & 0xFFFF
        if length < 2 or (length - 1) % per_number:
            raise BadMatrix("a string has a length that does not fit its type")
        words -= length + big
        yield row, text.numbers((length - 1) // per_number)
