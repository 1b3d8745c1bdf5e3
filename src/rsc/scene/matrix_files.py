"""Matrices of a scene: from nested lists or from .npz, .mat and Matrix Market files, and their checks.

Files are opened without pickle, and sizes are read from the headers before any data are.
"""

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.sparse

from rsc.errors import one_line
from rsc.files.mat5 import MatError, read_mat5
from rsc.scene.keys import MAX_COORDINATES, Number, as_list
from rsc.scene.units import LARGEST, SMALLEST

MAX_FILE_BYTES = 64 * 2**20


@dataclass(frozen=True)
class MatrixReader:
    """A square matrix as nested lists, or the name of a matrix file.

    `entries` gives a reader per entry where the units are known (the 2 x 2 disk); otherwise entries are SI.
    """

    entries: tuple | None = None

    @property
    def wanted(self):
        """The allowed forms in words."""
        if self.entries:
            return f"a {len(self.entries)} x {len(self.entries)} matrix as nested lists"
        return "a square matrix as nested lists, or a .npz, .mat or .mtx file"

    def read(self, table, key, raw):
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


def read_matrix_file(table, key, name):
    """Read one square matrix from a file.

    Parameters
    ----------
    table : rsc.scene.keys.Table
        The scene's table, for its folder and for refusals.
    key : str
        Key of the table; also the name of the array in a .npz or .mat file.
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
    path = (table.folder or Path()) / name
    read = {".npz": _read_npz, ".mat": _read_mat, ".mtx": _read_mtx}.get(path.suffix.lower())
    if read is None:
        table.refuse(key, name, MatrixReader().wanted)
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise _WrongMatrix(f"the file is larger than {MAX_FILE_BYTES // 2**20} MB")
        matrix = read(path, key)
    except OSError as error:
        table.refuse(key, name, "a readable matrix file", one_line(error.strerror or "not readable").lower())
    except Exception as error:  # the readers of numpy raise nearly anything for a damaged file
        reason = one_line(error) if isinstance(error, MatError) else type(error).__name__
        hint = one_line(error) if isinstance(error, _WrongMatrix) else f"damaged or another format: {reason}"
        table.refuse(key, name, f"a file with a real square matrix \"{key}\"", hint)
    return tuple(tuple(row) for row in matrix.tolist())


class _WrongMatrix(Exception):
    """A file whose content is no real square finite matrix."""


def _refuse_name(names):
    shown = [one_line(name) for name in sorted(names)[:5]]
    raise _WrongMatrix("its arrays are named " + ", ".join(shown) if shown else "it holds no arrays")


def _check_header(shape, kind="f"):
    if len(shape) != 2 or shape[0] != shape[1] or not 0 < shape[0] <= MAX_COORDINATES:
        raise _WrongMatrix(f"its shape is {tuple(shape)}")
    if kind not in "fiu":
        raise _WrongMatrix("its entries are not real numbers")


def _as_real(matrix):
    matrix = np.asarray(matrix)
    _check_header(matrix.shape, matrix.dtype.kind)
    matrix = matrix.astype(np.float64)
    sizes = np.abs(matrix[matrix != 0.0])
    if not np.all((sizes >= SMALLEST) & (sizes <= LARGEST)):  # nan is nowhere inside
        raise _WrongMatrix(f"an entry is nan or its magnitude is not 0 or {SMALLEST:g} to {LARGEST:g}")
    return matrix


def _read_npz(path, key):
    with zipfile.ZipFile(path) as archive:
        if f"{key}.npy" not in archive.namelist():
            _refuse_name(archive.namelist())
        # the header says how much memory the array would take: read it before the array
        with archive.open(f"{key}.npy") as member:
            version = np.lib.format.read_magic(member)
            if version not in ((1, 0), (2, 0)):
                raise _WrongMatrix("its array format is unknown")
            formats = np.lib.format
            read = formats.read_array_header_1_0 if version == (1, 0) else formats.read_array_header_2_0
            shape, _, dtype = read(member)
    _check_header(shape, dtype.kind)
    with np.load(path, allow_pickle=False) as arrays:
        return _as_real(arrays[key])


def _read_mat(path, key):
    variables = read_mat5(path.read_bytes())
    if key not in variables:
        _refuse_name(variables)
    shape, read = variables[key]
    if shape is None:
        raise _WrongMatrix("its entries are not real numbers, or it is no matrix")
    _check_header(shape)
    matrix = read()
    return _as_real(matrix.toarray() if scipy.sparse.issparse(matrix) else matrix)


def _read_mtx(path, key):
    """A Matrix Market file; read here because scipy 1.17 (mmread) can crash the process on a damaged one."""
    lines = path.read_text(encoding="ascii", errors="replace").splitlines()
    words = lines[0].lower().split() if lines else []
    if len(words) != 5 or words[:2] != ["%%matrixmarket", "matrix"]:
        raise _WrongMatrix("it does not start with %%MatrixMarket matrix")
    layout, kind, symmetry = words[2:]
    allowed = layout in ("array", "coordinate") and symmetry in ("general", "symmetric")
    if not allowed or kind not in ("real", "double", "integer"):
        raise _WrongMatrix(f"its kind is {one_line(' '.join(words[2:]))}, not real general or symmetric")
    body = [line.split() for line in lines[1:] if line.strip() and not line.lstrip().startswith("%")]
    size = [int(word) for word in body[0]]
    _check_header(size[:2])
    matrix = np.zeros(size[:2])
    if layout == "array":
        # column by column; of a symmetric matrix the lower triangle
        places = [(i, j) for j in range(size[1]) for i in range(j if symmetry == "symmetric" else 0, size[0])]
        values = [float(word) for (word,) in body[1:]]
    else:
        places = [(int(i) - 1, int(j) - 1) for i, j, _ in body[1:]]
        values = [float(word) for _, _, word in body[1:]]
        if len(values) != size[2] or any(not 0 <= i < size[0] or not 0 <= j < size[1] for i, j in places):
            raise _WrongMatrix("its number of entries or an index does not fit its header")
    for (i, j), value in zip(places, values, strict=True):
        matrix[i, j] = value
        if symmetry == "symmetric":
            matrix[j, i] = value
    return _as_real(matrix)


def refuse_asymmetric(table, key, rows, size=None):
    """Refuse a matrix that is not symmetric to 1e-9 of its largest entry, or not of the given size."""
    matrix = np.array(rows)
    if size is not None and len(rows) != size:
        table.refuse(key, rows, f"a {size} x {size} matrix like the mass matrix")
    worst = np.max(np.abs(matrix - matrix.T))
    if worst > 1e-9 * np.max(np.abs(matrix)):
        i, j = np.unravel_index(np.argmax(np.abs(matrix - matrix.T)), matrix.shape)
        table.refuse(key, rows, "a symmetric matrix", f"entries [{i}][{j}] and [{j}][{i}] differ")


def is_definite(rows, strictly):
    """Whether a symmetric matrix is positive definite (strictly) or semidefinite, to rounding.

    Rows and columns are first scaled by the roots of the diagonal, so that kg beside kg m^2 does no harm.
    """
    matrix = np.array(rows)
    diagonal = np.diag(matrix)
    if np.any(diagonal < 0.0) or (strictly and np.any(diagonal == 0.0)):
        return False
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    largest = np.max(np.abs(matrix), initial=0.0)
    empty = diagonal == 0.0
    if np.any(np.abs(matrix[empty]) > 1e-12 * largest):
        return False
    lowest = np.linalg.eigvalsh(0.5 * (matrix + matrix.T) / np.outer(scale, scale))[0]
    return bool(lowest > 1e-12) if strictly else bool(lowest >= -1e-9)
