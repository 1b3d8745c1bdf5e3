"""NumPy's .npz and .npy: arrays, and sparse matrices from scipy.sparse.save_npz; nothing is ever unpickled."""

import io
import math
import zipfile
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np
import scipy.sparse

from rsc.errors import one_line
from rsc.files.memory import Memory, TooLarge
from rsc.machine.formats.entries import MOST_BYTES, BadMatrix, check_shape

MAGIC_ZIP, MAGIC_ARRAY = b"PK\x03\x04", b"\x93NUMPY"
_MOST_MEMBERS, _MEMBER = 200, b"PK\x01\x02"  # and the signature of each in the archive's directory


def read(content: bytes, stem: str, most: int = MOST_BYTES) -> dict[str, Any]:
    """Matrices of an archive; a sparse one, which is unnamed, under the name of the file. `most`: limit of bytes in total."""
    memory = Memory(most)
    if content.startswith(MAGIC_ARRAY):
        array = array_of(content, memory, stem)
        return {stem: array} if array is not None and array.ndim == 2 else {}
    try:
        arrays = arrays_of(content, memory)
    except (BadMatrix, TooLarge):
        raise
    except Exception as error:  # zipfile may raise almost anything for a damaged archive
        raise BadMatrix(f"damaged archive: {type(error).__name__}") from None
    if "format" in arrays:
        return {stem: _sparse(arrays)}
    return {name: array for name, array in arrays.items() if array is not None and array.ndim == 2}


def arrays_of(content: bytes, memory: Memory, wanted: Collection[str] | None = None) -> dict[str, Any]:
    """Numeric arrays in the bytes of an archive, by name; None for arrays of another type.

    Parameters
    ----------
    content : bytes
    memory : Memory
        Checked before reading: a small archive can unpack to any size.
    wanted : collection of str, optional
        Names of the arrays to read; by default all.
    """
    return {
        name: _array(file, size, "SU" if name == "format" else "fiu", memory, name)
        for name, file, size in _members(content)
        if wanted is None or name in wanted
    }


def array_of(content: bytes, memory: Memory, name: str) -> Any:
    """The array in the bytes of a .npy file; None if it is not numeric. name: for messages."""
    return _array(io.BytesIO(content), len(content), "fiu", memory, name)


def shapes_of(content: bytes) -> dict[str, Any]:
    """Name -> shape of each array in the bytes of an archive, None if it is not numeric; only headers are read."""
    return {name: (head and head[0]) for name, file, _ in _members(content) for head in [_head(file, "fiu")]}


def shape_of(content: bytes) -> Any:
    """Shape of the array in the bytes of a .npy file, None if it is not numeric."""
    head = _head(io.BytesIO(content), "fiu")
    return head and head[0]


def _members(content: bytes) -> Iterator[tuple[str, Any, int]]:
    """(name, open file, size declared by the archive) of each array."""
    if content.count(_MEMBER) > 2 * _MOST_MEMBERS:  # before listing them, which takes ten times their bytes
        raise BadMatrix("it has too many members")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = [member for member in archive.infolist() if member.filename.endswith(".npy")]
        if len(members) > _MOST_MEMBERS:
            raise BadMatrix(f"it has {len(members)} arrays")
        for member in members:
            with archive.open(member) as file:
                yield member.filename[:-4], file, member.file_size


def _head(file: Any, kinds: str) -> tuple[Any, bool, Any] | None:
    """(shape, whether in Fortran order, dtype) from the header of a .npy file; None if the dtype is not of these kinds."""
    try:
        version = np.lib.format.read_magic(file)
        header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, fortran, dtype = header(file, max_header_size=2000)
    except OSError:
        raise
    except Exception:  # NumPy may raise almost anything for a damaged one
        raise BadMatrix("an array has no readable header") from None
    if any(type(length) is not int for length in shape):
        raise BadMatrix("an array has no readable header")
    return None if dtype.hasobject or dtype.kind not in kinds else (shape, fortran, dtype)


def _array(file: Any, size: int, kinds: str, memory: Memory, name: str) -> Any:
    """The array of a .npy file of `size` bytes, after checking its header; None if its dtype is not of these kinds."""
    head = _head(file, kinds)
    if head is None:
        return None
    shape, fortran, dtype = head
    wanted = math.prod(shape) * dtype.itemsize
    if min(shape, default=0) < 0 or wanted > size:
        announced = f"an array of shape {shape} takes {wanted} bytes" if len(shape) <= 4 else "an array has many axes"
        raise BadMatrix(f"{announced} but the file has {size} for it")
    memory.take(one_line(name)[:40], math.prod(shape), dtype.itemsize)
    values = file.read(wanted)
    if len(values) != wanted:
        raise BadMatrix("an array is cut off")
    return np.frombuffer(values, dtype).reshape(shape, order="F" if fortran else "C")


def _sparse(arrays: dict[str, Any]) -> Any:
    try:
        kind = str(arrays["format"].astype(str).item())
        shape = tuple(int(n) for n in arrays["shape"])
        check_shape(*shape)
        if kind == "coo":
            matrix = scipy.sparse.coo_array((arrays["data"], (arrays["row"], arrays["col"])), shape=shape)
        else:
            made = {"csc": scipy.sparse.csc_array, "csr": scipy.sparse.csr_array, "bsr": scipy.sparse.bsr_array}[kind]
            matrix = made((arrays["data"], arrays["indices"], arrays["indptr"]), shape=shape)
            matrix.check_format(full_check=True)
        matrix = matrix.astype(float).tocsc()
    except BadMatrix:
        raise
    except (KeyError, ValueError, TypeError, AttributeError, IndexError):
        raise BadMatrix("its sparse matrix is inconsistent, or not of format csc, csr, bsr or coo") from None
    matrix.sum_duplicates()
    return matrix
