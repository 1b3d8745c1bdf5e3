"""Matrix Market: a header line, comments, a line of sizes, then entries (R. F. Boisvert et al., NISTIR 5935, 1996).

Not read by SciPy, since the fast reader of SciPy 1.17 crashed on damaged files.
"""

import re
from typing import Any

import numpy as np

from rsc.machine.formats.entries import BadMatrix, check_shape, columns, numbers, sparse, whole, without

MAGIC = b"%%MatrixMarket"
_MIRRORS = {b"general": 0, b"symmetric": 1, b"skew-symmetric": -1}
_COMMENT = re.compile(rb"^[ \t]*%.*$", re.MULTILINE)


def read(content: bytes, stem: str) -> dict[str, Any]:
    """The matrix of the file under the name of the file: sparse for coordinate format, otherwise dense."""
    head, _, body = content.partition(b"\n")
    words = head.lower().split()
    if len(words) != 5 or words[1] != b"matrix" or words[2] not in (b"array", b"coordinate"):
        raise BadMatrix("its first line is not that of a Matrix Market matrix")
    if words[3] not in (b"real", b"double", b"integer") or words[4] not in _MIRRORS:
        raise BadMatrix(f"its entries are {words[3].decode('ascii', 'replace')} {words[4].decode('ascii', 'replace')}, not real")
    if b"%" in body:
        body = without(body, _COMMENT)
    sizes, _, body = body.lstrip().partition(b"\n")
    read_body = _coordinate if words[2] == b"coordinate" else _array
    return {stem: read_body(whole(numbers(sizes), 0, 2**53, "a size"), body, _MIRRORS[words[4]])}


def _coordinate(sizes: Any, body: bytes, mirror: int) -> Any:
    if len(sizes) != 3:
        raise BadMatrix("its line of sizes does not have three numbers")
    rows, cols, count = (int(size) for size in sizes)
    check_shape(rows, cols)
    entries = columns(body, 3)
    if len(entries) != count:
        raise BadMatrix(f"it has {len(entries)} entries but declares {count}")
    i, j = whole(entries[:, 0], 1, rows, "a row"), whole(entries[:, 1], 1, cols, "a column")
    return sparse(i - 1, j - 1, entries[:, 2], (rows, cols), mirror)


def _array(sizes: Any, body: bytes, mirror: int) -> Any:
    if len(sizes) != 2:
        raise BadMatrix("its line of sizes does not have two numbers")
    rows, cols = (int(size) for size in sizes)
    check_shape(rows, cols)
    if mirror and rows != cols:
        raise BadMatrix(f"its size is {rows} x {cols} but it is declared symmetric")
    count = {0: rows * cols, 1: rows * (rows + 1) // 2, -1: rows * (rows - 1) // 2}[mirror]
    if 2 * count > len(body) + 1:  # a number takes at least a digit and a space
        raise BadMatrix(f"it is too short for the {count} entries that it declares")
    values = numbers(body)
    if len(values) != count:
        raise BadMatrix(f"it has {len(values)} entries but declares {count}")
    if not mirror:
        return values.reshape((rows, cols), order="F")
    matrix = np.zeros((rows, cols))
    j, i = np.triu_indices(rows, 0 if mirror == 1 else 1)  # the lower triangle, column by column
    matrix[j, i] = mirror * values
    matrix[i, j] = values
    return matrix
