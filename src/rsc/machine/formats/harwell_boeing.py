"""Harwell-Boeing and Rutherford-Boeing files: compressed columns in lines of fixed fields (I. S. Duff, R. G. Grimes, J. G. Lewis,
Users' Guide for the Harwell-Boeing Sparse Matrix Collection, 1992)."""

import re

import numpy as np

from rsc.machine.formats.entries import BadMatrix, check_shape, numbers, sparse, whole

_TYPE = re.compile(rb"([RCIPQ])([SUHZR])([AE])\s", re.IGNORECASE)
_FIELD = re.compile(rb"(\d*)\s*[IEDFG](\d+)", re.IGNORECASE)  # as in (16I5) or (1P,4D20.12)
_MIRRORS = {b"S": 1, b"Z": -1, b"U": 0, b"R": 0}


def recognises(head):
    """Whether the third line of a text tells the type of a matrix, as these files do."""
    lines = head.splitlines()
    return len(lines) > 3 and _TYPE.match(lines[2]) is not None and b"(" in lines[3]


def read(content, stem):
    """The matrix of the file, sparse, under the name of the file."""
    lines = content.splitlines()
    counts = whole(numbers(lines[1]), 0, len(lines), "a number of lines")
    kind = _TYPE.match(lines[2])
    if kind[1].upper() not in b"RI" or kind[3].upper() == b"E" or kind[2].upper() not in _MIRRORS:
        raise BadMatrix(f"its matrix is of type {kind[0].decode().strip()}; assembled real ones (RSA, RUA, RZA) are read")
    sizes = whole(numbers(lines[2][3:]), 0, 2**53, "a size")
    if len(counts) not in (4, 5) or len(sizes) < 3:
        raise BadMatrix("its header has too few numbers")
    rows, cols, count = (int(size) for size in sizes[:3])
    check_shape(rows, cols)
    fields = _FIELD.findall(lines[3])
    if len(fields) < 3:
        raise BadMatrix("its fourth line names no three formats")
    place = 4 + bool(len(counts) == 5 and counts[4])  # right-hand sides have a line of formats
    parts = []
    for field, n_lines, length in zip(fields, counts[1:4], (cols + 1, count, count), strict=False):
        parts.append(_fixed(lines[place : place + n_lines], field, length))
        place += int(n_lines)
    starts = whole(parts[0], 1, count + 1, "a start of a column") - 1
    per_column = np.diff(starts)
    if starts[0] != 0 or starts[-1] != count or np.any(per_column < 0):
        raise BadMatrix("the starts of its columns contradict each other")
    i = whole(parts[1], 1, rows, "a row") - 1
    j = np.repeat(np.arange(cols), per_column)
    return {stem: sparse(i, j, parts[2], (rows, cols), _MIRRORS[kind[2].upper()])}


def _fixed(lines, field, length):
    """`length` numbers from lines of fields, which may touch each other; scipy's fields are narrower than it announces."""
    try:
        values = numbers(b"\n".join(lines))
    except BadMatrix:
        values = np.zeros(0)
    if len(values) != length:
        values = numbers(_apart(lines, int(field[0] or 1), int(field[1]), length))
    if len(values) != length:
        raise BadMatrix(f"it has {len(values)} numbers where {length} belong")
    return values


def _apart(lines, per_line, width, length):
    """The text with a space behind every field."""
    if not (0 < width <= 80 and 0 < per_line * width <= 1000) or len(lines) * per_line < length:
        raise BadMatrix("it is too short, or its formats fit no line")
    text = b"".join(line[: per_line * width].ljust(per_line * width) for line in lines)
    fields = np.full((len(lines) * per_line, width + 1), ord(" "), np.uint8)
    fields[:, :width] = np.frombuffer(text, np.uint8).reshape(-1, width)
    return fields.tobytes()
