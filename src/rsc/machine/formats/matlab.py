"""MAT-files: level 5 via rsc.files.mat5, level 7.3 (HDF5 files) via h5py.

Fields of structs are named like "model.K". Level 7.3 (MathWorks, "MAT-File Versions"): a full matrix is a dataset with its axes
reversed; a sparse one a group with attribute MATLAB_sparse (its number of rows) and datasets data, ir and jc of compressed
columns; a struct a group of its fields.
"""

from collections.abc import Iterator
from typing import Any

import h5py
import numpy as np
import scipy.sparse

from rsc.files import gate
from rsc.files.mat5 import MatError, read_mat5
from rsc.files.memory import Memory, TooLarge
from rsc.machine.formats.entries import MOST_BYTES, BadMatrix, Budgeted, check_shape

MAGIC_HDF = b"\x89HDF\r\n\x1a\n"
USER_BLOCK = 512  # MATLAB's header before the HDF5 data
_DEEPEST, _MOST_NAMES = 6, 1000


def recognises_level_5(head: bytes) -> bool:
    """Whether a file's first 128 bytes are those of a MAT-file of level 5."""
    return head[126:128] in (b"IM", b"MI") and not recognises_level_73(head)


def recognises_level_73(head: bytes) -> bool:
    """Whether a file's first bytes are those of an HDF5 file, with or without MATLAB's header."""
    return head.startswith(MAGIC_HDF) or head[USER_BLOCK:].startswith(MAGIC_HDF)


def read_level_5(content: bytes, most: int = MOST_BYTES) -> dict[str, Any]:
    """The real matrices of a MAT-file of level 5, name -> array or sparse matrix; `most`: limit of bytes in total."""
    matrices = Budgeted(most)
    try:
        _level_5(read_mat5(content, most), matrices)
    except MatError as error:
        raise BadMatrix(str(error)) from None
    return matrices


def _level_5(variables: Any, matrices: Budgeted, prefix: str = "", depth: int = 0) -> None:
    for name, (shape, read) in variables.items():
        if shape is not None:
            if min(shape) > 0:
                check_shape(*shape)
                matrices[prefix + name] = read()
        elif depth < _DEEPEST:
            try:
                fields = read()
            except MatError:  # text, cells, complex numbers
                continue
            _level_5(fields, matrices, f"{prefix}{name}.", depth + 1)


def read_level_73(content: bytes, most: int = MOST_BYTES) -> dict[str, Any]:
    """The real matrices of a MAT-file of level 7.3, name -> array or sparse matrix; `most`: limit of bytes in total."""
    matrices = Budgeted(most)
    try:
        with gate.image(content) as group:
            _visit(group, "", 0, matrices, iter(range(_MOST_NAMES)))
    except (BadMatrix, TooLarge):
        raise
    except Exception as error:  # h5py may raise almost anything for a damaged file
        raise BadMatrix(f"damaged HDF5 file: {type(error).__name__}") from None
    return matrices


def _visit(group: Any, prefix: str, depth: int, matrices: Budgeted, visits: Iterator[int]) -> None:
    """Add the matrices of a group; `visits` limits the number of names visited, since groups may contain themselves."""
    for name in group:
        if next(visits, None) is None or depth > _DEEPEST:
            raise BadMatrix("it contains too many arrays")
        if name.startswith("#") or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue  # targets of cells and structs; external files
        member = group[name]
        if isinstance(member, h5py.Group) and gate.short_attribute(member, "MATLAB_sparse") is not None:
            matrices[prefix + name] = _sparse(member, prefix + name, Memory(matrices.memory.left))
        elif isinstance(member, h5py.Group):
            _visit(member, f"{prefix}{name}.", depth + 1, matrices, visits)
        elif _is_matrix(member):
            matrices[prefix + name] = _values(member, prefix + name, Memory(matrices.memory.left)).T


def _is_matrix(member: Any) -> bool:
    unfit = gate.short_attribute(member, "MATLAB_class") in (b"char", b"logical", b"cell")
    text_or_empty = unfit or gate.short_attribute(member, "MATLAB_empty") is not None
    return isinstance(member, h5py.Dataset) and member.ndim == 2 and member.dtype.kind in "fiu" and not text_or_empty


def _values(dataset: Any, name: str, memory: Memory) -> Any:
    """All numbers of a dataset, after checking its size and that it is stored in this file."""
    try:
        return gate.numbers(dataset, name, memory)
    except TooLarge:
        raise
    except ValueError as error:
        raise BadMatrix(str(error)) from None


def _sparse(group: Any, name: str, memory: Memory) -> Any:
    rows = int(gate.short_attribute(group, "MATLAB_sparse"))
    starts = _values(group["jc"], name, memory).ravel().astype(np.int64)
    check_shape(rows, len(starts) - 1)
    empty = "ir" not in group  # a matrix without entries
    i = np.zeros(0, np.int64) if empty else _values(group["ir"], name, memory).ravel().astype(np.int64)
    values = np.zeros(0) if empty else _values(group["data"], name, memory).ravel().astype(float)
    fits = len(starts) > 1 and starts[0] == 0 and np.all(np.diff(starts) >= 0) and starts[-1] == len(i) == len(values)
    if not fits or np.any((i < 0) | (i >= rows)):
        raise BadMatrix("a sparse matrix is inconsistent")
    matrix = scipy.sparse.csc_array((values, i, starts), shape=(rows, len(starts) - 1))
    matrix.sum_duplicates()
    return matrix
