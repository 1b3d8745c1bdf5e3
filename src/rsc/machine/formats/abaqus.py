"""Text matrices of Abaqus and CalculiX. Abaqus names its files .mtx, but they are not Matrix Market files.

Abaqus (*MATRIX OUTPUT, Keywords Reference Guide): formats MATRIX INPUT and LABELS have lines "node, direction, node, direction,
value", COORDINATE "row, column, value". CalculiX (SOLVER=MATRIXSTORAGE, User's Manual) writes lines "row column value" of one
triangle to .sti and .mas, and the node.direction of every row to .dof.
"""

import re
from typing import Any

import numpy as np

from rsc.machine.formats.dmig import keys_of, labelled, places_of
from rsc.machine.formats.entries import MOST_COORDINATES, BadMatrix, columns, numbers, sparse, whole, without

_KEYWORDS = re.compile(rb"^[ \t]*\*.*$", re.MULTILINE)
_UNSYMMETRIC = re.compile(rb"^[ \t]*\*.*TYPE *= *UNSYMMETRIC", re.MULTILINE | re.IGNORECASE)


def recognises(head: bytes) -> bool:
    """Whether the first line that is not a keyword or comment has three or five numbers."""
    for line in head.splitlines()[:1000]:
        if line.strip() and not line.lstrip().startswith(b"*"):
            try:
                return len(numbers(line.replace(b",", b" "))) in (3, 5)
            except BadMatrix:
                return False
    return False


def read(content: bytes, stem: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """(matrices, labels) with the single matrix under the name of the file; labels (n, 2) if it has nodes and directions."""
    unsymmetric = _UNSYMMETRIC.search(content) is not None
    body = without(content, _KEYWORDS) if b"*" in content else content
    first = body.lstrip().partition(b"\n")[0]
    width = len(numbers(first.replace(b",", b" ")))
    if width not in (3, 5):
        raise BadMatrix(f"its first line has {width} numbers instead of 3 (row, column, value) or 5 (with nodes and directions)")
    entries = columns(body.replace(b",", b" "), width)
    if width == 3:
        i, j = (whole(entries[:, k], 1, MOST_COORDINATES, "a row or column") - 1 for k in (0, 1))
        size = int(max(i.max(), j.max())) + 1
        return {stem: sparse(i, j, entries[:, 2], (size, size), _half(i, j, unsymmetric))}, {}
    if np.any(entries[:, [0, 2]] < 1):
        raise BadMatrix("it has unnumbered nodes, which Abaqus adds for Lagrange multipliers; omit those constraints")
    rows, cols = (keys_of(entries[:, k], entries[:, k + 1]) for k in (0, 2))
    matrix, labels = labelled(rows, cols, entries[:, 4], _half(rows, cols, unsymmetric))
    return {stem: matrix}, {stem: labels}


def _half(i: Any, j: Any, unsymmetric: bool) -> int:
    """1 if the entries are one triangle of a symmetric matrix, else 0."""
    return int(not unsymmetric and not (np.any(i > j) and np.any(i < j)))


def read_directions(content: bytes) -> Any:
    """Nodes and directions of a .dof file of CalculiX as an (n, 2) int array."""
    places = columns(content.replace(b".", b" "), 2)
    return places_of(keys_of(*places.T))
