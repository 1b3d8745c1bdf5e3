"""Matrices of a scene: from nested lists or from .npz, .mat and Matrix Market files, and their checks.

Files are read by `rsc.machine.formats`: without pickle, with sizes checked before memory is allocated; duplicate entries of a
sparse matrix are summed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from rsc.errors import DataError, one_line
from rsc.scene.keys.keys import RawTable
from rsc.scene.keys.readers import MAX_COORDINATES, Number, as_list
from rsc.units import LARGEST, SMALLEST

MAX_FILE_BYTES = 64 * 2**20


@dataclass(frozen=True)
class MatrixReader:
    """A square matrix as nested lists, or the name of a matrix file.

    `entries` has a reader per entry if units are known (the 2 x 2 disk); otherwise entries are in SI.
    """

    entries: tuple | None = None

    @property
    def wanted(self) -> str:
        """The allowed forms in words."""
        if self.entries:
            return f"a {len(self.entries)} x {len(self.entries)} matrix as nested lists"
        return "a square matrix as nested lists, or a .npz, .mat or .mtx file"

    def read(self, table: RawTable, key: str, raw: Any) -> tuple[tuple[float, ...], ...]:
        """The matrix as a tuple of rows."""
        if isinstance(raw, str) and not self.entries:
            return read_matrix_file(table, key, raw)
        rows = as_list(raw)
        if not rows:
            table.refuse(key, raw, self.wanted)
        rows = [as_list(row) for row in rows]
        size = len(self.entries or rows)
        square = len(rows) == size and all(row is not None and len(row) == size for row in rows)
        if not square or size > MAX_COORDINATES:
            table.refuse(key, raw, self.wanted)
        number = Number("dimensionless")
        return tuple(
            tuple(
                (self.entries[i][j] if self.entries else number).read(table, f"{key}[{i}][{j}]", entry)
                for j, entry in enumerate(row)
            )
            for i, row in enumerate(rows)
        )


def read_matrix_file(table: RawTable, key: str, name: str) -> tuple[tuple[float, ...], ...]:
    """Read one square matrix from a file.

    Parameters
    ----------
    table : rsc.scene.keys.keys.Table
        The scene's table, for its folder and for error messages.
    key : str
        Key of the table; also the name of the matrix in files with named matrices.
    name : str
        File name, relative to the scene's folder.

    Returns
    -------
    tuple of tuple of float

    Raises
    ------
    SceneError
        Unreadable or wrong file, no such array, not a real square matrix, too large.
    """
    from rsc.machine.formats import read_matrices  # takes a while to load, and few scenes name files

    if table.folder is None:
        table.refuse(key, name, "a matrix written out", "the scene of a result cannot refer to files")
    path = table.folder / name
    if path.suffix.lower() not in (".npz", ".mat", ".mtx"):
        table.refuse(key, name, MatrixReader().wanted)
    try:
        matrices = read_matrices(path, MAX_FILE_BYTES, MAX_FILE_BYTES).matrices
    except DataError as error:
        table.refuse(key, name, f"a file with a real square matrix \"{key}\"", error.problem)
    matrix: Any = matrices.get(key, matrices.get(path.stem) if len(matrices) == 1 else None)  # some formats have no names
    problem = _problem_of(matrix, matrices)
    if problem:
        table.refuse(key, name, f"a file with a real square matrix \"{key}\"", problem)
    matrix = matrix.toarray() if scipy.sparse.issparse(matrix) else matrix
    sizes = np.abs(matrix[matrix != 0.0])
    if not np.all((sizes >= SMALLEST) & (sizes <= LARGEST)):
        wanted = f"a matrix whose entries are 0 or of magnitude {SMALLEST:g} to {LARGEST:g}"
        table.refuse(key, name, wanted)
    return tuple(tuple(row) for row in matrix.tolist())


def _problem_of(matrix: Any, matrices: Mapping[str, Any]) -> str:
    """Why a matrix (None: not found) of a file's matrices is unsuitable; "" if it is suitable."""
    if matrix is None:
        return "its real matrices are named " + ", ".join(one_line(name) for name in sorted(matrices)[:5])
    if len(set(matrix.shape)) != 1 or not 0 < matrix.shape[0] <= MAX_COORDINATES:
        return f"its shape is {matrix.shape}"
    return ""


def refuse_asymmetric(table: RawTable, key: str, rows: Any, size: int | None = None) -> None:
    """SceneError for a matrix that is not symmetric within 1e-9 of its largest entry, or not of the given size."""
    matrix = np.array(rows)
    if size is not None and len(rows) != size:
        table.refuse(key, rows, f"a {size} x {size} matrix like the mass matrix")
    worst = np.max(np.abs(matrix - matrix.T))
    if worst > 1e-9 * np.max(np.abs(matrix)):
        i, j = np.unravel_index(np.argmax(np.abs(matrix - matrix.T)), matrix.shape)
        table.refuse(key, rows, "a symmetric matrix", f"entries [{i}][{j}] and [{j}][{i}] differ")


_ROUNDING = 1e-15  # of an entry relative to the largest one


def is_definite(rows: Any, strictly: bool) -> bool:
    """Whether a symmetric matrix is positive definite (strictly) or semidefinite, up to rounding.

    Rows and columns are first scaled by the square roots of the diagonal, so that mixed units (kg, kg m^2) do not matter.
    """
    matrix = np.array(rows)
    largest, empty = np.max(np.abs(matrix), initial=0.0), np.diag(matrix) == 0.0
    if np.any(np.abs(matrix[empty]) > 1e-12 * largest):
        return False
    if not strictly:  # of a motion that nothing opposes every entry is rounding
        matrix = matrix + _ROUNDING * largest * np.eye(len(matrix))
    diagonal = np.diag(matrix)
    if np.any(diagonal < 0.0) or (strictly and np.any(empty)):
        return False
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    lowest = np.linalg.eigvalsh(0.5 * (matrix + matrix.T) / np.outer(scale, scale))[0]
    return bool(lowest > 1e-12) if strictly else bool(lowest >= -1e-9)
