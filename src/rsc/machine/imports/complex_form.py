"""Real matrices of x, y, rx and ry as matrices of complex coordinates.

At every node u = x + i y and, if it has tilts, phi = ry - i rx, which equals u' along the axis. With the rows of T (1 at x and i
at y; 1 at ry and -i at rx) the coordinates are z = T q, their forces T f, and q = (T^H z + T^T conj z) / 2 because T T^H = 2 I.
Hence

    T A q = A_z z + A_c conj z,    A_z = T A T^H / 2,    A_c = T A T^T / 2.

A_z acts equally in all directions; its real part is the mean of both directions, its imaginary part their cross-coupling. A_c is
the difference between the directions.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from rsc.errors import DataError
from rsc.machine.formats import Matrix
from rsc.machine.imports.coordinates import Coordinates

DECOUPLED = 1e-10  # relative to the largest entries of the rows


@dataclass(frozen=True)
class Pairs:
    """The complex coordinates of a table, sorted by node, displacement before tilt."""

    node: NDArray[np.int64]  # (n,)
    kind: NDArray[np.str_]  # (n,) "displacement" or "tilt"
    first: NDArray[np.int64]  # (n,) rows of x or ry
    second: NDArray[np.int64]  # (n,) rows of y or rx
    sign: NDArray[np.float64]  # (n,) z = q[first] + i sign q[second]: 1 for displacements, -1 for tilts
    others: NDArray[np.int64]  # rows that belong to no pair


class Parts(NamedTuple):
    """A matrix in complex coordinates: A_z = real + i imaginary, A_c = anisotropic; each (n, n)."""

    real: Matrix
    imaginary: Matrix
    anisotropic: Matrix


def pairs(coordinates: Coordinates, source: str) -> Pairs:
    """Find the complex coordinates.

    Raises
    ------
    DataError
        A node has only one direction of a pair, or no node has any.
    """
    rows: dict[tuple[int, str], int] = {}
    for row, (node, direction) in enumerate(zip(coordinates.node.tolist(), coordinates.direction.tolist(), strict=True)):
        if direction != "other":
            rows[node, direction] = row
    coordinates_of = []
    for node in sorted({node for node, _ in rows}):
        for kind, one, other, sign in (("displacement", "x", "y", 1.0), ("tilt", "ry", "rx", -1.0)):
            if ((node, one) in rows) != ((node, other) in rows):
                present, missing = (one, other) if (node, one) in rows else (other, one)
                raise DataError(
                    source, f"node {node} has direction {present} but not {missing}; together they form a complex coordinate"
                )
            if (node, one) in rows:
                coordinates_of.append((node, kind, rows[node, one], rows[node, other], sign))
    if not coordinates_of:
        raise DataError(source, "no node has the directions x and y")
    nodes, kinds, first, second, signs = zip(*coordinates_of, strict=True)
    others = np.flatnonzero(coordinates.direction == "other")
    return Pairs(np.array(nodes), np.array(kinds), np.array(first), np.array(second), np.array(signs), others)


def coupling(matrix: Matrix, places: Pairs) -> float:
    """Largest entry between pairs and other rows, relative to the geometric mean of the largest entries of its row and column."""
    if places.others.size == 0:
        return 0.0
    size = _largest(matrix)
    kept = np.concatenate([places.first, places.second])
    blocks = (matrix[kept][:, places.others], kept, places.others), (matrix[places.others][:, kept], places.others, kept)
    return max(relative(block, size[rows], size[columns]) for block, rows, columns in blocks)


def fold(matrix: Matrix, places: Pairs) -> Parts:
    """The matrix in complex coordinates; parts below 1e-9 of the largest entries become exactly zero. Sparse stays sparse."""
    p, q = places.first, places.second
    sign = scipy.sparse.diags_array(places.sign)
    same, turned = matrix[p][:, p], sign @ matrix[q][:, q] @ sign
    down, up = sign @ matrix[q][:, p], matrix[p][:, q] @ sign
    size = _largest(matrix)
    size = np.maximum(size[p], size[q])

    def kept(part: Any) -> Any:
        return part if relative(part, size, size) > 1e-9 else part * 0.0

    mean, crosswise, different = 0.5 * (same + turned), 0.5 * (down - up), 0.5 * ((same - turned) + 1j * (down + up))
    return Parts(kept(mean), kept(crosswise), kept(different))


def relative(block: Matrix, rows: NDArray[np.float64], columns: NDArray[np.float64]) -> float:
    """Largest |entry| of a block divided by the geometric mean of the sizes of its row and column."""
    if 0 in block.shape:
        return 0.0
    left, right = (scipy.sparse.diags_array(1.0 / np.sqrt(size)) for size in (rows, columns))
    return float(abs(left @ block @ right).max())


def _largest(matrix: Any) -> Any:
    """Largest |entry| of row i and column i, for each i; 1 if they are empty."""
    largest = [abs(matrix).max(axis=axis) for axis in (0, 1)]
    size = np.maximum(*(part.toarray().ravel() if scipy.sparse.issparse(part) else part for part in largest))
    return np.where(size > 0.0, size, 1.0)
