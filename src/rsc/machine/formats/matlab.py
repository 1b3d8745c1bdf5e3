"""MAT-files: of level 5 by rsc.files.mat5, of level 7.3, which are HDF5 files, by h5py.

Fields of structs have the names of both, "model.K". Level 7.3 (MathWorks, "MAT-File Versions"): a matrix is a dataset with its
axes reversed; a sparse one a group with the attribute MATLAB_sparse (its rows) and the datasets data, ir and jc of compressed
columns; a struct a group of its fields.
"""

import h5py
import numpy as np
import scipy.sparse

from rsc.files import gate
from rsc.files.mat5 import MatError, read_mat5
from rsc.machine.formats.entries import MOST_BYTES, BadMatrix, Budgeted, check_shape

MAGIC_HDF = b"\x89HDF\r\n\x1a\n"
USER_BLOCK = 512  # MATLAB writes its own header before the HDF5 file
_DEEPEST, _MOST_NAMES = 6, 1000
_FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32}
_DENSEST = 1100  # deflate packs zeros into no less than a 1032nd
_PACKED = 1100  # times fewer bytes than they unpack to: more than the filters of HDF5 can save


def recognises_level_5(head):
    """Whether a file's first 128 bytes are those of a MAT-file of level 5."""
    return head[126:128] in (b"IM", b"MI") and not recognises_level_73(head)


def recognises_level_73(head):
    """Whether a file's first bytes are those of an HDF5 file, with MATLAB's header or without."""
    return head.startswith(MAGIC_HDF) or head[USER_BLOCK:].startswith(MAGIC_HDF)


def read_level_5(content, most=MOST_BYTES):
    """The real matrices of a MAT-file of level 5, name -> array or sparse matrix; `most`: bytes of all."""
    matrices = Budgeted(most)
    try:
        _level_5(read_mat5(content, most), matrices)
    except MatError as error:
        raise BadMatrix(str(error)) from None
    return matrices


def _level_5(variables, matrices, prefix="", depth=0):
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


def read_level_73(content, most=MOST_BYTES):
    """The real matrices of a MAT-file of level 7.3, name -> array or sparse matrix; `most`: bytes of all."""
    matrices = Budgeted(most)
    try:
        with gate.image(content) as group:
            _visit(group, "", 0, matrices, iter(range(_MOST_NAMES)))
    except BadMatrix:
        raise
    except Exception as error:  # h5py raises nearly anything for a damaged file
        raise BadMatrix(f"damaged HDF5 file: {type(error).__name__}") from None
    return matrices


def _visit(group, prefix, depth, matrices, visits):
    """Add the matrices of a group; `visits` has an item for each name that may be looked at: groups may hold themselves."""
    for name in group:
        if next(visits, None) is None or depth > _DEEPEST:
            raise BadMatrix("it holds too many arrays")
        if name.startswith("#") or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue  # what cells and structs point to; files elsewhere
        member = group[name]
        if isinstance(member, h5py.Group) and _attribute(member, "MATLAB_sparse") is not None:
            matrices[prefix + name] = _sparse(member, matrices.left)
        elif isinstance(member, h5py.Group):
            _visit(member, f"{prefix}{name}.", depth + 1, matrices, visits)
        elif _is_matrix(member):
            matrices[prefix + name] = _values(member, matrices.left).T


def _attribute(member, name):
    """Value of an attribute of fixed length, None without one: texts of any length in a damaged file can keep HDF5 for ever."""
    if name not in member.attrs:
        return None
    kind = h5py.check_string_dtype(member.attrs.get_id(name).dtype)
    fixed = kind.length is not None if kind else member.attrs.get_id(name).dtype.kind in "fiu"
    return member.attrs[name] if fixed else None


def _is_matrix(member):
    unfit = _attribute(member, "MATLAB_class") in (b"char", b"logical", b"cell")
    text_or_empty = unfit or _attribute(member, "MATLAB_empty") is not None
    return isinstance(member, h5py.Dataset) and member.ndim == 2 and member.dtype.kind in "fiu" and not text_or_empty


def _values(dataset, most):
    """All numbers of a dataset, after a look at what they take and that they are in this very file."""
    if not isinstance(dataset, h5py.Dataset) or dataset.dtype.kind not in "fiu" or dataset.external or dataset.is_virtual:
        raise BadMatrix("an array holds no numbers of its own")
    made = dataset.id.get_create_plist()
    if not {made.get_filter(i)[0] for i in range(made.get_nfilters())} <= _FILTERS:
        raise BadMatrix("an array is packed in a way that MATLAB does not use")
    if dataset.size * max(dataset.dtype.itemsize, 8) > most:
        raise BadMatrix(f"an array has {dataset.size} numbers; at most {most // 8} are read")
    if dataset.size * dataset.dtype.itemsize > _DENSEST * dataset.id.get_storage_size():
        raise BadMatrix("an array is larger than what the file holds of it")
    if dataset.nbytes > _PACKED * dataset.id.get_storage_size():
        raise BadMatrix(f"an array of {dataset.size} numbers has no place in the file for them")
    return np.asarray(dataset[()])


def _sparse(group, most):
    rows = int(_attribute(group, "MATLAB_sparse"))
    starts = _values(group["jc"], most).ravel().astype(np.int64)
    check_shape(rows, len(starts) - 1)
    empty = "ir" not in group  # how MATLAB writes a matrix without entries
    i = np.zeros(0, np.int64) if empty else _values(group["ir"], most).ravel().astype(np.int64)
    values = np.zeros(0) if empty else _values(group["data"], most).ravel().astype(float)
    fits = len(starts) > 1 and starts[0] == 0 and np.all(np.diff(starts) >= 0) and starts[-1] == len(i) == len(values)
    if not fits or np.any((i < 0) | (i >= rows)):
        raise BadMatrix("a sparse matrix contradicts itself")
    matrix = scipy.sparse.csc_array((values, i, starts), shape=(rows, len(starts) - 1))
    matrix.sum_duplicates()
    return matrix
