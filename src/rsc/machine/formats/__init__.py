"""Matrices from the files that finite-element programs write; the format is told from the content, not from the name.

Each format has a small reader of its own, told what it reads in its first lines. None depends on more than NumPy, SciPy and h5py,
sparse matrices stay sparse, entries at one place add up, and what is damaged or too large is refused in one line.
"""

import os
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from rsc.errors import DataError, one_line
from rsc.files.content import content_of, unusable
from rsc.files.memory import MOST_FILE as MOST_FILE_BYTES
from rsc.files.memory import TooLarge
from rsc.machine.formats import abaqus, dmig, harwell_boeing, matlab, matrix_market, npz, op4
from rsc.machine.formats.entries import MOST_BYTES, BadMatrix

_HEAD = 4096  # bytes that tell the format

Matrix: TypeAlias = NDArray[np.float64] | scipy.sparse.csc_array


class Matrices(NamedTuple):
    """What a file holds: matrices by name, and labels by the same names where the format has them.

    A matrix is an ndarray or a scipy.sparse.csc_array of float64. Labels are an (n, 2) int array of node and direction (1 to 3
    along x, y, z, 4 to 6 about them) of each row.
    """

    matrices: dict[str, Matrix]
    labels: dict[str, NDArray[np.int64]]


def read_matrices(path: str | os.PathLike[str], most_file: int = MOST_FILE_BYTES, most: int = MOST_BYTES) -> Matrices:
    """Read all matrices of a file.

    Matrix Market, Harwell-Boeing, MAT-files of level 5 and 7.3 (of structs the fields, as "model.K"), .npz and .npy, Nastran
    OUTPUT4 as text and punched DMIG, the matrix output of Abaqus and of CalculiX (.sti and .mas; labels from the .dof file beside
    them). A single matrix without a name has that of the file.

    Parameters
    ----------
    path : str or path
    most_file, most : int
        Largest size of the file, and of all its matrices where they may be packed, in bytes.

    Raises
    ------
    DataError
        Not readable, no regular file, larger than `most_file`, of another format, damaged, with nan or infinite entries, with
        more than 2,000,000 rows or columns: one line that names the file and the reason.
    """
    path = Path(path)
    try:
        matrices, labels = _read(content_of(path, most_file), path, most)
        if not matrices:
            raise BadMatrix("it holds no real matrix")
        return Matrices({name: _checked(name, matrix) for name, matrix in matrices.items()}, labels)
    except (BadMatrix, TooLarge) as error:
        raise DataError(one_line(path), one_line(error)) from None
    except OSError as error:
        raise DataError(one_line(path), unusable(error)) from None
    except (MemoryError, RecursionError):
        raise DataError(one_line(path), "its matrices do not fit into memory") from None


def _read(content, path, most):
    """(matrices, labels) by the first reader that knows the content."""
    head = content[:_HEAD]
    if matlab.recognises_level_73(head):
        return matlab.read_level_73(content, most), {}
    if matlab.recognises_level_5(head):
        return matlab.read_level_5(content, most), {}
    if head.startswith((npz.MAGIC_ZIP, npz.MAGIC_ARRAY)):
        return npz.read(content, path.stem, most), {}
    if head.startswith(matrix_market.MAGIC):
        return matrix_market.read(content, path.stem), {}
    if harwell_boeing.recognises(head):
        return harwell_boeing.read(content, path.stem), {}
    if op4.recognises(head):
        return op4.read(content, most), {}
    if op4.recognises_binary(head):
        raise BadMatrix("OUTPUT4 in binary form; write it as text (ASSIGN OUTPUT4='K.op4',UNIT=11,FORM=FORMATTED)")
    if abaqus.recognises(head if len(content) <= _HEAD else head[: head.rfind(b"\n")]):
        matrices, labels = abaqus.read(content, path.stem)
        return matrices, labels or _directions_beside(path, matrices)
    if dmig.recognises(content):
        return dmig.read(content)
    raise BadMatrix(
        "no known format (Matrix Market, Harwell-Boeing, MAT-file, npz, OUTPUT4 as text, DMIG, output of Abaqus or CalculiX)"
    )


def _directions_beside(path, matrices):
    """Labels from the .dof file of CalculiX beside its .sti or .mas file."""
    beside = path.with_suffix(".dof")
    if path.suffix.lower() not in (".sti", ".mas") or not beside.exists():
        return {}
    labels = abaqus.read_directions(content_of(beside, MOST_FILE_BYTES))
    for matrix in matrices.values():
        if len(labels) != matrix.shape[0]:
            raise BadMatrix(f"it has {matrix.shape[0]} rows and {beside.name} beside it {len(labels)}")
    return dict.fromkeys(matrices, labels)


def _checked(name, matrix):
    """The matrix in float64, refused where an entry is nan or infinite."""
    matrix = matrix.astype(np.float64)
    if not np.all(np.isfinite(matrix.data if scipy.sparse.issparse(matrix) else matrix)):
        raise BadMatrix(f"an entry of {one_line(name)} is nan or infinite")
    return matrix
