"""NumPy's .npz and .npy: arrays, and sparse matrices as scipy.sparse.save_npz writes them; nothing is ever unpickled."""

import io
import math
import zipfile

import numpy as np
import scipy.sparse

from rsc.machine.formats.entries import MOST_BYTES, BadMatrix, check_shape

MAGIC_ZIP, MAGIC_ARRAY = b"PK\x03\x04", b"\x93NUMPY"
_MOST_MEMBERS, _MEMBER = 200, b"PK\x01\x02"  # and how each of them begins in the archive's directory


def read(content, stem, most=MOST_BYTES):
    """Matrices of the archive; a sparse one, which has no name in it, under the name of the file. `most`: bytes of all arrays."""
    if content.startswith(MAGIC_ARRAY):
        arrays = {stem: _array(io.BytesIO(content), len(content), most)}
        return {name: array for name, array in arrays.items() if array is not None and array.ndim == 2}
    try:
        arrays = arrays_of(content, most)
    except BadMatrix:
        raise
    except Exception as error:  # zipfile raises nearly anything for a damaged archive
        raise BadMatrix(f"damaged archive: {type(error).__name__}") from None
    if "format" in arrays:
        return {stem: _sparse(arrays)}
    return {name: array for name, array in arrays.items() if array is not None and array.ndim == 2}


def arrays_of(content, most=MOST_BYTES):
    """Arrays of numbers in the bytes of an archive, by name; None in the place of those with other entries.

    BadMatrix where they would take more than `most` bytes together: a small archive can unpack to anything.
    """
    if content.count(_MEMBER) > 2 * _MOST_MEMBERS:  # before a list of them is made, of ten times their bytes
        raise BadMatrix("it has too many members")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = [member for member in archive.infolist() if member.filename.endswith(".npy")]
        if len(members) > _MOST_MEMBERS:
            raise BadMatrix(f"it has {len(members)} arrays")
        arrays = {}
        for member in members:
            kinds = "SU" if member.filename == "format.npy" else "fiu"
            with archive.open(member) as file:
                array = arrays[member.filename[:-4]] = _array(file, member.file_size, most, kinds)
                most -= 0 if array is None else array.nbytes
    return arrays


def _array(file, size, most, kinds="fiu"):
    """The array of a .npy file after a look at its header; None for what holds another kind of entries."""
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
    if dtype.hasobject or dtype.kind not in kinds:
        return None
    wanted = math.prod(shape) * dtype.itemsize
    if min(shape, default=0) < 0 or wanted > min(size, most):
        announced = f"an array of shape {shape} takes {wanted} bytes" if len(shape) <= 4 else "an array has many axes"
        raise BadMatrix(f"{announced} and the file has {size} for it; at most {most} are read")
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
