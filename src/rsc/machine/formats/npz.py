"""NumPy's .npz and .npy: arrays, and sparse matrices as scipy.sparse.save_npz writes them; nothing is ever unpickled."""

import io
import math
import zipfile

import numpy as np
import scipy.sparse

from rsc.errors import one_line
from rsc.files.memory import Memory, TooLarge
from rsc.machine.formats.entries import MOST_BYTES, BadMatrix, check_shape

MAGIC_ZIP, MAGIC_ARRAY = b"PK\x03\x04", b"\x93NUMPY"
_MOST_MEMBERS, _MEMBER = 200, b"PK\x01\x02"  # and how each of them begins in the archive's directory


def read(content, stem, most=MOST_BYTES):
    """Matrices of the archive; a sparse one, which has no name in it, under the name of the file. `most`: bytes of all arrays."""
    memory = Memory(most)
    if content.startswith(MAGIC_ARRAY):
        array = array_of(content, memory, stem)
        return {stem: array} if array is not None and array.ndim == 2 else {}
    try:
        arrays = arrays_of(content, memory)
    except (BadMatrix, TooLarge):
        raise
    except Exception as error:  # zipfile raises nearly anything for a damaged archive
        raise BadMatrix(f"damaged archive: {type(error).__name__}") from None
    if "format" in arrays:
        return {stem: _sparse(arrays)}
    return {name: array for name, array in arrays.items() if array is not None and array.ndim == 2}


def arrays_of(content, memory, wanted=None):
    """Arrays of numbers in the bytes of an archive, by name; None in the place of those with other entries.

    Parameters
    ----------
    content : bytes
    memory : Memory
        Where they are counted before they are read: a small archive can unpack to anything.
    wanted : collection of str, optional
        Names of those that are read; by default all.
    """
    return {
        name: _array(file, size, "SU" if name == "format" else "fiu", memory, name)
        for name, file, size in _members(content)
        if wanted is None or name in wanted
    }


def array_of(content, memory, name):
    """The array of the bytes of a .npy file, None where it holds no numbers; its name is for messages."""
    return _array(io.BytesIO(content), len(content), "fiu", memory, name)


def shapes_of(content):
    """Name -> shape of each array in the bytes of an archive, None of one that holds no numbers; no array is read."""
    return {name: (head and head[0]) for name, file, _ in _members(content) for head in [_head(file, "fiu")]}


def shape_of(content):
    """Shape of the array in the bytes of a .npy file, None where it holds no numbers."""
    head = _head(io.BytesIO(content), "fiu")
    return head and head[0]


def _members(content):
    """(name, open file, bytes that the archive announces) of each array."""
    if content.count(_MEMBER) > 2 * _MOST_MEMBERS:  # before a list of them is made, of ten times their bytes
        raise BadMatrix("it has too many members")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = [member for member in archive.infolist() if member.filename.endswith(".npy")]
        if len(members) > _MOST_MEMBERS:
            raise BadMatrix(f"it has {len(members)} arrays")
        for member in members:
            with archive.open(member) as file:
                yield member.filename[:-4], file, member.file_size


def _head(file, kinds):
    """(shape, whether in the order of Fortran, type) from the header of a .npy file; None for other kinds of entries."""
    try:
        version = np.lib.format.read_magic(file)
        header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, fortran, dtype = header(file, max_header_size=2000)
    except OSError:
        raise
    except Exception:  # NumPy raises nearly anything for a damaged one
        raise BadMatrix("an array has no header that can be read") from None
    if any(type(length) is not int for length in shape):
        raise BadMatrix("an array has no header that can be read")
    return None if dtype.hasobject or dtype.kind not in kinds else (shape, fortran, dtype)


def _array(file, size, kinds, memory, name):
    """The array of a .npy file of so many bytes after a look at its header; None for what holds another kind of entries."""
    head = _head(file, kinds)
    if head is None:
        return None
    shape, fortran, dtype = head
    wanted = math.prod(shape) * dtype.itemsize
    if min(shape, default=0) < 0 or wanted > size:
        announced = f"an array of shape {shape} takes {wanted} bytes" if len(shape) <= 4 else "an array has many axes"
        raise BadMatrix(f"{announced} and the file has {size} for it")
    memory.take(one_line(name)[:40], math.prod(shape), dtype.itemsize)
    values = file.read(wanted)
    if len(values) != wanted:
        raise BadMatrix("an array is cut off")
    return np.frombuffer(values, dtype).reshape(shape, order="F" if fortran else "C")


def _sparse(arrays):
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
        raise BadMatrix("its sparse matrix contradicts itself, or is none of csc, csr, bsr and coo") from None
    matrix.sum_duplicates()
    return matrix
