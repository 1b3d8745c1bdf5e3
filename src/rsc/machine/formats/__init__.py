"""Readers for matrix files of finite-element programs; the format is recognised from the content, not the file name.

Each format has a small reader of its own. They depend on NumPy, SciPy and h5py only; sparse matrices stay sparse, duplicate
entries are summed, and damaged or too large files are refused with a one-line message.
"""

import os
from collections.abc import Callable
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


# matrices and labels of a file, as in `Matrices`, before the numbers are checked
Found: TypeAlias = tuple[dict[str, Any], dict[str, Any]]


class MatrixFormat(NamedTuple):
    """One format: its name in messages, whether a content has it, and (content, path, most bytes) -> what it holds."""

    name: str
    recognises: Callable[[bytes], bool]
    read: Callable[[bytes, Path, int], Found]


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
        content = content_of(path, most_file)
        matrices, labels = reader_of(content).read(content, path, most)
        if not matrices:
            raise BadMatrix("it contains no real matrix")
        return Matrices({name: _checked(name, matrix) for name, matrix in matrices.items()}, labels)
    except (BadMatrix, TooLarge) as error:
        raise DataError(one_line(path), one_line(error)) from None
    except OSError as error:
        raise DataError(one_line(path), unusable(error)) from None
    except (MemoryError, RecursionError):
        raise DataError(one_line(path), "its matrices do not fit into memory") from None


def reader_of(content: bytes) -> MatrixFormat:
    """The first reader that recognises a file; BadMatrix, which names all formats, if none does."""
    for reader in READERS:
        if reader.recognises(content):
            return reader
    raise BadMatrix(f"unknown format (known: {', '.join(dict.fromkeys(reader.name for reader in READERS))})")


def _whole_lines(content: bytes) -> bytes:
    """The head of a file without a line that is cut off."""
    head = content[:_HEAD]
    return head if len(content) <= _HEAD else head[: head.rfind(b"\n")]


def _op4(content: bytes, path: Path, most: int) -> Found:
    if op4.recognises_binary(content[:_HEAD]):
        raise BadMatrix("OUTPUT4 in binary form; write it as text (ASSIGN OUTPUT4='K.op4',UNIT=11,FORM=FORMATTED)")
    return op4.read(content, most), {}


def _abaqus(content: bytes, path: Path, most: int) -> Found:
    matrices, labels = abaqus.read(content, path.stem)
    return matrices, labels or _directions_beside(path, matrices)


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


# in this order: the first that recognises a content reads it
READERS = (
    MatrixFormat(
        "MAT-file", lambda content: matlab.recognises_level_73(content[:_HEAD]),
        lambda content, _, most: (matlab.read_level_73(content, most), {}),
    ),
    MatrixFormat(
        "MAT-file", lambda content: matlab.recognises_level_5(content[:_HEAD]),
        lambda content, _, most: (matlab.read_level_5(content, most), {}),
    ),
    MatrixFormat(
        "npz", lambda content: content.startswith((npz.MAGIC_ZIP, npz.MAGIC_ARRAY)),
        lambda content, path, most: (npz.read(content, path.stem, most), {}),
    ),
    MatrixFormat(
        "Matrix Market", lambda content: content.startswith(matrix_market.MAGIC),
        lambda content, path, _: (matrix_market.read(content, path.stem), {}),
    ),
    MatrixFormat(
        "Harwell-Boeing", lambda content: harwell_boeing.recognises(content[:_HEAD]),
        lambda content, path, _: (harwell_boeing.read(content, path.stem), {}),
    ),
    MatrixFormat(
        "OUTPUT4 as text", lambda content: op4.recognises(content[:_HEAD]) or op4.recognises_binary(content[:_HEAD]), _op4,
    ),
    MatrixFormat(
        "Abaqus or CalculiX output", lambda content: abaqus.recognises(_whole_lines(content)), _abaqus,
    ),
    MatrixFormat("DMIG", dmig.recognises, lambda content, *_: dmig.read(content)),
)  # fmt: skip
