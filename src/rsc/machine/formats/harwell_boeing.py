"""Harwell-Boeing and Rutherford-Boeing files: compressed columns in lines of fixed fields (I. S. Duff, R. G. Grimes, J. G. Lewis,
Users' Guide for the Harwell-Boeing Sparse Matrix Collection, 1992)."""

import itertools
import re

import numpy as np

from rsc.machine.formats.entries import BadMatrix, TextLines, check_shape, numbers, sparse, whole

_TYPE = re.compile(rb"([RCIPQ])([SUHZR])([AE])\s", re.IGNORECASE)
_FIELD = re.compile(rb"(\d*)\s*[IEDFG](\d+)", re.IGNORECASE)  # as in (16I5) or (1P,4D20.12)
_WIDEST = 120  # characters of the line of formats, which has 72; longer lines would take the square of their length
_LONGEST, _TOGETHER = 1000, 10_000  # characters of a line of fields, and lines that are taken apart together
_MIRRORS = {b"S": 1, b"Z": -1, b"U": 0, b"R": 0}


def recognises(head):
    """Whether the third line of a text tells the type of a matrix, as these files do."""
    lines = head.splitlines()
    return len(lines) > 3 and _TYPE.match(lines[2]) is not None and b"(" in lines[3]


def read(content, stem):
    """The matrix of the file, sparse, under the name of the file."""
    lines = TextLines(content)
    header = [lines.next() for _ in range(4)]
    counts = whole(numbers(header[1]), 0, len(content), "a number of lines")
    kind = _TYPE.match(header[2])
    if kind[1].upper() not in b"RI" or kind[3].upper() == b"E" or kind[2].upper() not in _MIRRORS:
        raise BadMatrix(f"its matrix is of type {kind[0].decode().strip()}; assembled real ones (RSA, RUA, RZA) are read")
    sizes = whole(numbers(header[2][3:]), 0, 2**53, "a size")
    if len(counts) not in (4, 5) or len(sizes) < 3:
        raise BadMatrix("its header has too few numbers")
    rows, cols, count = (int(size) for size in sizes[:3])
    check_shape(rows, cols)
    fields = _FIELD.findall(header[3][:_WIDEST])
    if len(fields) < 3:
        raise BadMatrix("its fourth line names no three formats")
    lines.text(int(len(counts) == 5 and counts[4] > 0))  # right-hand sides have a line of formats
    parts = []
    for field, n_lines, length in zip(fields, counts[1:4], (cols + 1, count, count), strict=False):
        parts.append(_fixed(lines.text(n_lines), field, length))
    starts = whole(parts[0], 1, count + 1, "a start of a column") - 1
    per_column = np.diff(starts)
    if starts[0] != 0 or starts[-1] != count or np.any(per_column < 0):
        raise BadMatrix("the starts of its columns contradict each other")
    i = whole(parts[1], 1, rows, "a row") - 1
    j = np.repeat(np.arange(cols), per_column)
    return {stem: sparse(i, j, parts[2], (rows, cols), _MIRRORS[kind[2].upper()])}


def _fixed(text, field, length):
    """`length` numbers from lines of fields, which may touch each other; scipy's fields are narrower than it announces."""
    try:
        values = numbers(text)
    except BadMatrix:
        values = np.zeros(0)
    if len(values) != length:
        values = _apart(text, int(field[0] or 1), int(field[1]), length)
    if len(values) != length:
        raise BadMatrix(f"it has {len(values)} numbers where {length} belong")
    return values


def _apart(text, per_line, width, length):
    """The numbers of a text of so many fields of one width on every line."""
    if not (0 < width <= 80 and 0 < per_line * width <= _LONGEST) or len(text) < length:
        raise BadMatrix("it is too short, or its formats fit no line")
    lines, parts, count = iter(TextLines(text)), [np.zeros(0)], 0
    while count < length and (some := list(itertools.islice(lines, _TOGETHER))):
        cells = b"".join(line[: per_line * width].ljust(per_line * width) for line in some)
        fields = np.full((len(some) * per_line, width + 1), ord(" "), np.uint8)  # a space behind every field
        fields[:, :width] = np.frombuffer(cells, np.uint8).reshape(-1, width)
        parts.append(numbers(fields.tobytes()))
        count += len(parts[-1])
    return np.concatenate(parts)
