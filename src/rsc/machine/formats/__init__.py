"""Readers for matrix files of finite-element programs; the format is recognised from the content, not the file name.

Each format has a small reader of its own. They depend on NumPy, SciPy and h5py only; sparse matrices stay sparse, duplicate
entries are summed, and damaged or too large files are refused with a one-line message.
"""

import os
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from rsc.errors import DataError, one_line
from rsc.files.content import content_of, unusable
from rsc.files.memory import MOST_FILE as MOST_FILE_BYTES
from rsc.files.memory import TooLarge
from rsc.machine.formats import abaqus, dmig, harwell_boeing, matlab, matrix_market, npz, op4
from rsc.machine.formats.entries import MOST_BYTES, BadMatrix

_HEAD = 4096  # bytes from which the format is recognised

Matrix: TypeAlias = NDArray[np.float64] | scipy.sparse.csc_array


class Matrices(NamedTuple):
    """Content of a file: matrices by name, and labels by the same names if the format has them.

    A matrix is an ndarray or scipy.sparse.csc_array of float64. Labels are an (n, 2) int array of node and direction (1 to 3
    along x, y, z, 4 to 6 about them) of each row.
    """

    matrices: dict[str, Matrix]
    labels: dict[str, NDArray[np.int64]]


def read_matrices(path: str | os.PathLike[str], most_file: int = MOST_FILE_BYTES, most: int = MOST_BYTES) -> Matrices:
    """Read all matrices of a file.

    Matrix Market, Harwell-Boeing, MAT-files of level 5 and 7.3 (struct fields as "model.K"), .npz and .npy, Nastran OUTPUT4 as
    text and punched DMIG, matrix output of Abaqus and CalculiX (.sti and .mas, with labels from the .dof file next to them). A
    single unnamed matrix gets the name of the file.

    Parameters
    ----------
    path : str or path
    most_file, most : int
        Largest allowed size in bytes of the file, and of all its matrices when unpacked.

    Raises
    ------
    DataError
        Not readable, not a regular file, larger than `most_file`, of another format, damaged, with NaN or infinite entries, or
        with more than 2,000,000 rows or columns; one line that names the file and the reason.
    """
    path = Path(path)
    try:
        matrices, labels = _read(content_of(path, most_file), path, most)
        if not matrices:
            raise BadMatrix("it contains no real matrix")
        return Matrices({name: _checked(name, matrix) for name, matrix in matrices.items()}, labels)
    except (BadMatrix, TooLarge) as error:
        raise DataError(one_line(path), one_line(error)) from None
    except OSError as error:
        raise DataError(one_line(path), unusable(error)) from None
    except (MemoryError, RecursionError):
        raise DataError(one_line(path), "its matrices do not fit into memory") from None


def _read(content: bytes, path: Path, most: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """(matrices, labels) by the first reader that recognises the content."""
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
        "unknown format (known: Matrix Market, Harwell-Boeing, MAT-file, npz, OUTPUT4 as text, DMIG, Abaqus or CalculiX output)"
    )


def _directions_beside(path: Path, matrices: dict[str, Any]) -> dict[str, Any]:
    """Labels from CalculiX's .dof file in the same folder as its .sti or .mas file."""
    beside = path.with_suffix(".dof")
    if path.suffix.lower() not in (".sti", ".mas") or not beside.exists():
        return {}
    labels = abaqus.read_directions(content_of(beside, MOST_FILE_BYTES))
    for matrix in matrices.values():
        if len(labels) != matrix.shape[0]:
            raise BadMatrix(f"it has {matrix.shape[0]} rows but {beside.name} has {len(labels)}")
    return dict.fromkeys(matrices, labels)


def _checked(name: str, matrix: Any) -> Any:
    """The matrix in float64; BadMatrix if an entry is NaN or infinite."""
    matrix = matrix.astype(np.float64)
    if not np.all(np.isfinite(matrix.data if scipy.sparse.issparse(matrix) else matrix)):
        raise BadMatrix(f"an entry of {one_line(name)} is nan or infinite")
    return matrix
