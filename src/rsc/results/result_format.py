"""Structure of a result file, its checksums, and opening it for reading: nothing is taken from a file that no run wrote."""

import ctypes
import hashlib
import os
import re
import zlib
from pathlib import Path

import h5py
import numpy as np

from rsc.errors import DataError, one_line
from rsc.files.output import HDF5, target

FORMAT = "rsc-result-4"
OLDER = "an older one"
CHUNK_ROWS = 4096
CHECKPOINT_ROWS = 16
UNWRITTEN_BYTES = 64 * 2**20
READ_ATTEMPTS = 24  # 2^24 ns in all

# name -> (unit, description); complex displacements are stored with a last dimension (y, z)
SERIES = {
    "speed": ("Hz", "rotor speed"),
    "normal_force": ("N", "contact normal force F_N"),
    "friction_force": ("N", "contact friction force mu sigma F_N"),
    "tangential_velocity": ("m s-1", "tangential velocity of the contact deflection, without the rotor's own turning"),
}
DISPLACEMENTS = {"rotor": "rotor displacements", "stator": "stator displacements"}
CHECKPOINT = "checkpoint/"
# a row of numbers a block of samples: where it ends, then the CRC-32 of its part of every array. HDF5's own Fletcher sums do not
# tell zeros from ones in 16 bits, and take a block of zeros, sums and all, for a whole one
BLOCKS = "blocks/checksums"


def put(attrs, values):
    """Write attributes, texts among them with a fixed length: those of any length go to a heap without a checksum."""
    for name, value in values.items():
        if isinstance(value, str):
            text = value.encode()
            attrs.create(name, np.bytes_(text), dtype=h5py.string_dtype("utf-8", max(len(text), 1)))
        else:
            attrs[name] = value


def attributes(file):
    """name -> value of a file's attributes, texts as str.

    Raises ValueError for an attribute that no run writes; a text of any length is not even looked at, because HDF5 may search a
    damaged heap for it for ever.
    """
    values = {}
    for name in file.attrs:
        kind = file.attrs.get_id(name).get_type()
        text = kind.get_class() == h5py.h5t.STRING
        if kind.is_variable_str() if text else kind.get_class() not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT):
            raise ValueError(f"attribute {one_line(name)[:40]!r} is of another kind than a run writes")
        value = file.attrs[name]
        values[name] = value.decode() if isinstance(value, bytes) else value
    return values


def digest(values):
    """SHA-256 of the values of a file's attributes."""
    digest = hashlib.sha256()
    for name in sorted(set(values) - {"checksum"}):
        value = values[name]
        digest.update(name.encode() + b"=" + (value.encode() if isinstance(value, str) else np.asarray(value).tobytes()) + b"\n")
    return digest.hexdigest()


def sample_arrays(file):
    """Names of a file's (or dict's) arrays over time, in the order of their checksums."""
    return [name for name in ("time", *SERIES, *DISPLACEMENTS) if name in file]


def checksum(values):
    """CRC-32 of a block of an array as it is stored."""
    return zlib.crc32(np.ascontiguousarray(values))


def checkpoint_checksum(arrays):
    """CRC-32 over all arrays (name -> array) of one checkpoint."""
    total = 0
    for name in sorted(set(arrays) - {"checksum"}):
        total = zlib.crc32(np.ascontiguousarray(arrays[name]), total)
    return total


def checked(file, name, column=None, rows=None):
    """The samples of one array (or of one coordinate of it) in all blocks that are whole, or in the rows (first, last, exclusive)
    of them; ValueError when one is damaged."""
    data, marks, i = file[name], file[BLOCKS][...], 1 + sample_arrays(file).index(name)
    ends = np.concatenate([[0], marks[:, 0]])
    if np.any(np.diff(ends) <= 0) or ends[-1] > data.shape[0]:
        raise ValueError("its blocks contradict each other")
    first, last = (0, int(ends[-1])) if rows is None else rows
    values = np.empty((last - first, *(data.shape[1:] if column is None else data.shape[2:])))
    block = int(np.searchsorted(ends, first, side="right")) - 1
    while block < len(marks) and ends[block] < last:
        begin = ends[block]
        after = max(block + 1, int(np.searchsorted(ends, begin + CHUNK_ROWS, side="right")) - 1)  # small blocks together
        piece = data[begin : ends[after]]
        for k in range(block, after):
            if checksum(piece[ends[k] - begin : ends[k + 1] - begin]) != marks[k, i]:
                raise ValueError(f"{name} is damaged between samples {ends[k]} and {ends[k + 1]}")
        inside = slice(max(begin, first), min(ends[after], last))
        piece = piece[inside.start - begin : inside.stop - begin]
        values[inside.start - first : inside.stop - first] = piece if column is None else piece[:, column]
        block = after
    return values


def refuse_other_structure(path, file):
    """DataError for a file of another format; ValueError for arrays that no run wrote, before any memory is taken for them."""
    shown = _format_of(file)
    if shown != repr(FORMAT):
        raise DataError(path, f"is no result of this version (its format is {shown}, this rsc reads {FORMAT!r})")
    attrs = attributes(file)
    if attrs.get("checksum") != digest(attrs):
        raise ValueError("its scene or summary was changed")
    complete = "status" in attrs
    marks = [BLOCKS, *(CHECKPOINT + name for name in file.get("checkpoint", ()))]
    for name in ("time", *SERIES, *(name for name in DISPLACEMENTS if name in file), *marks):
        data = file[name] if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
        axes = 3 if name in DISPLACEMENTS else 2 if name in marks else 1
        kinds = "fi" if name in marks else "f"
        if not isinstance(data, h5py.Dataset) or data.dtype.kind not in kinds or data.dtype.itemsize != 8 or data.ndim != axes:
            raise ValueError(f"{name} is no array of a run")
        if data.shape[2:] not in ((), (2,)) or (complete and axes != 2 and data.shape[0] != file["time"].shape[0]):
            raise ValueError(f"{name} has another shape than a run writes")
        # as much as is stored; of a run that a kill ended the last block may be declared and not yet written
        stored = data.id.get_storage_size() if complete else 2 * path.stat().st_size + UNWRITTEN_BYTES
        if data.chunks is None or data.compression or not data.fletcher32 or data.nbytes > stored:
            raise ValueError(f"{name} was not written by a run")
    rows, blocks = file["time"].shape[0], file[BLOCKS]
    if blocks.shape[1] != 1 + len(sample_arrays(file)) or (complete and rows != (blocks[-1, 0] if len(blocks) else 0)):
        raise ValueError("its blocks are not those of its samples")


def refuse_other_file(path):
    """DataError unless a result may be written there: a new name, or one that a result has, of whatever version."""
    if not target(path, HDF5).exists() or not os.path.getsize(path):
        return
    problem = "cannot be written: what has this name cannot be read as a result; remove it, or choose another name"
    with Guard(path, problem), reading(path).opened() as file:
        name = _format_of(file)
    if name != OLDER and not name.startswith("'rsc-result-"):
        raise DataError(path, "cannot be written (an HDF5 file of another kind has this name)")


def _format_of(file):
    """The format a file names, for a message."""
    if "format" not in file.attrs:
        return "none"
    kind = file.attrs.get_id("format").get_type()
    if kind.get_class() != h5py.h5t.STRING:
        return "none"
    if kind.is_variable_str():
        return OLDER  # up to number 3, and not to be looked at, see `attributes`
    name = file.attrs["format"]
    return repr(one_line(name.decode())[:40]) if isinstance(name, bytes) else "none"


class Guard:
    """Turns the failures of a block of file operations into one DataError."""

    def __init__(self, path, problem, error=DataError):
        self._path, self._problem, self._error = path, problem, error

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        # h5py reports a full disk or damage as OSError, RuntimeError, KeyError or ValueError, by the layer that met it
        if kind is not None and issubclass(kind, (OSError, RuntimeError, KeyError, ValueError, TypeError)):
            raise self._error(self._path, f"{self._problem} ({_reason(error)})") from None


def _reason(error):
    """In one line: what the operating system said where HDF5 tells that among addresses and sizes, else its first line."""
    lines, system = str(error).strip().splitlines(), re.search(r"error message = '([^']+)'", str(error))
    return one_line(system[1].lower() if system else lines[0] if lines else type(error).__name__)


class reading(Guard):
    """Open an HDF5 file for reading, also one that a run is writing or was killed in; failures become a DataError."""

    def __init__(self, path):
        super().__init__(Path(path), "cannot be read as a result")
        self._file = None

    def __enter__(self):
        with Guard(self._path, self._problem):
            if not self._path.exists():
                raise DataError(self._path, "does not exist")
            if not self._path.is_file():
                kind = "is a directory" if self._path.is_dir() else "is not a regular file"
                raise DataError(self._path, f"{kind}, wanted: a result file")
            self._file = self.opened()
        try:
            with Guard(self._path, self._problem):
                refuse_other_structure(self._path, self._file)
        except DataError:
            self._file.close()
            raise
        return self._file

    def opened(self):
        """The file, of whatever content."""
        try:
            return h5py.File(self._path, "r", locking=False)
        except OSError as error:
            # a run that goes on or was killed left its mark in the file, and a full disk less of it than it declares; only such a
            # file is read as one that may still grow
            full = "truncated file" in str(error) and self._path.suffix in (".part", ".left")
            if not full and "consistency flags" not in str(error):
                raise
        access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
        access.set_file_locking(False, True)
        # HDF5 waits for damaged metadata to become whole, twice as long at every attempt; the default, 100 attempts, has no end
        library = ctypes.CDLL(h5py.defs.__file__)
        library.H5Pset_metadata_read_attempts(ctypes.c_int64(access.id), ctypes.c_uint(READ_ATTEMPTS))
        return h5py.File(h5py.h5f.open(os.fsencode(self._path), h5py.h5f.ACC_RDONLY | h5py.h5f.ACC_SWMR_READ, access))

    def __exit__(self, kind, error, trace):
        self._file.close()
        super().__exit__(kind, error, trace)
