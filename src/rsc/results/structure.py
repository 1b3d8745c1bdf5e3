"""Opening a result file: is it the result of a run? Names, links, kinds, shapes and sizes are looked at before anything is read.

A checksum says that nothing was damaged, not who wrote it: whoever forges a file writes the checksums as well. So a file is
taken for a result only if it holds what a run writes and nothing else, and takes no more memory than it has bytes. Nothing
outside it is opened: links, virtual and external arrays and foreign filters are refused.
"""

import ctypes
import math
import os
from dataclasses import fields
from pathlib import Path

import h5py
import numpy as np

from rsc.errors import DataError, one_line
from rsc.files.content import refuse_special
from rsc.files.output import HDF5, target
from rsc.results.result_format import (
    BLOCKS,
    CHECKPOINT,
    CHECKPOINT_ROWS,
    CHUNK_ROWS,
    DISPLACEMENTS,
    FORMAT,
    HEAD,
    MOTIONS,
    SERIES,
    Guard,
    attributes,
    digest,
    moving_body,
    sample_arrays,
)
from rsc.results.summary import Summary

READ_ATTEMPTS = 24  # 2^24 ns in all
UNWRITTEN_BYTES = 64 * 2**20
OLDER = "an older one, rsc-result-1 to 3"
MOST_NAMES = 64  # of arrays or attributes; a run writes some twenty
# bytes that the text of a scene may have, and for every pair of coordinates
SCENE_BYTES, MATRIX_BYTES = 4 * 2**20, 300
# numbers of an array in a checkpoint beyond four for every coordinate (older kernels kept more): what they mean and how many this
# version wants is for `rsc.simulation.checkpoint` to say
CHECKPOINT_NUMBERS = 64
_AXES = ("axis", *(f"{name}_coordinate" for name in DISPLACEMENTS))  # for other readers
_KNOWN = {*HEAD, *(item.name for item in fields(Summary))}


def refuse_other_structure(path, file):
    """Look at an open file.

    Raises
    ------
    DataError
        Of another format.
    ValueError
        With what no run has written.
    """
    n_attributes = h5py.h5a.get_num_attrs(file.id)
    if n_attributes > MOST_NAMES:
        raise ValueError(f"it has {n_attributes} attributes")
    shown = _format_of(file)
    if shown != repr(FORMAT):
        raise DataError(path, f"is no result of this version (its format is {shown}, this rsc reads {FORMAT!r})")
    size = path.stat().st_size
    names = _names(file)
    counts = {name: _array(file, name).shape[1] if name in names else 0 for name in DISPLACEMENTS}
    attrs = _attributes(file, sum(counts.values()))
    complete = "status" in attrs
    marks = _checkpoint_arrays(file, names)
    motions = names & set(MOTIONS)
    n_arrays = 1 + len(SERIES) + len(motions)
    for name in ("time", *SERIES):
        _refuse_foreign(file, name, (), h5py.h5t.IEEE_F64LE, complete, size)
    for name in motions:
        _refuse_foreign(file, name, (counts[moving_body(name)], 2), h5py.h5t.IEEE_F64LE, complete, size)
    for name in names & set(_AXES):
        body = name.partition("_")[0]
        _refuse_other_axis(file, name, np.arange(counts[body]) if body in counts else np.array(["y", "z"], dtype="S1"))
    _refuse_foreign(file, BLOCKS, (1 + n_arrays,), h5py.h5t.STD_I64LE, complete, size)
    for name in marks:
        row_shape = (1,) if name in ("rows", "checksum") else _array(file, CHECKPOINT + name).shape[1:]
        if len(row_shape) != 1 or not 0 < row_shape[0] <= 4 * sum(counts.values()) + CHECKPOINT_NUMBERS:
            raise ValueError(f"{CHECKPOINT}{name} has another shape than a run writes")
        whole = name in ("rows", "checksum") or file[CHECKPOINT + name].dtype.kind == "i"
        kind = h5py.h5t.STD_I64LE if whole else h5py.h5t.IEEE_F64LE
        _refuse_foreign(file, CHECKPOINT + name, row_shape, kind, complete, size)
    if complete:
        _refuse_unequal(file, marks)


def _names(file):
    """Names of what a file holds: those of a run, each in the file itself."""
    names = _members(file, {"time", *SERIES, *MOTIONS, *_AXES, "checkpoint", BLOCKS.partition("/")[0]})
    missing = {"time", *SERIES} - names
    if missing:
        raise ValueError(f"{min(missing)} is no array of a run")
    return names


def _members(group, known=None):
    """Names in a group, none but the known ones (if any are told), none of them a link to another place."""
    if not isinstance(group, h5py.Group) or len(group) > MOST_NAMES:
        raise ValueError("its groups are not those of a run")
    names = set(group)
    for name in names:
        if known is not None and name not in known:
            raise ValueError(f"{one_line(name)[:40]!r} is nothing that a run writes")
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"{one_line(name)[:40]!r} is a link")
    return names


def _array(file, name):
    """A dataset that can have rows; its name is known to be no link."""
    data = file.get(name)
    if not isinstance(data, h5py.Dataset) or data.ndim < 1:
        raise ValueError(f"{name} is no array of a run")
    if name in MOTIONS and data.ndim != 3:
        raise ValueError(f"{name} has another shape than a run writes")
    return data


def _attributes(file, n_coordinates):
    """The attributes of a file, as `rsc.results.result_format.attributes`: known, of bearable size and with the right sum."""
    for name in file.attrs:
        if name not in _KNOWN:
            raise ValueError(f"attribute {one_line(name)[:40]!r} is nothing that a run writes")
        attribute = file.attrs.get_id(name)
        shape = (7,) if name == "ledger" else ()
        if attribute.shape != shape:
            raise ValueError(f"attribute {name} has another shape than a run writes")
        if attribute.get_type().get_size() > SCENE_BYTES + MATRIX_BYTES * n_coordinates**2:
            raise ValueError(f"attribute {name} is too large")
    attrs = attributes(file)
    if attrs.get("checksum") != digest(attrs):
        raise ValueError("its scene or summary was changed")
    return attrs


def _checkpoint_arrays(file, names):
    """Names of what the checkpoints hold; none in a result saved from memory."""
    if BLOCKS.partition("/")[0] not in names or _members(file["blocks"], {"checksums"}) != {"checksums"}:
        raise ValueError(f"{BLOCKS} is no array of a run")
    if "checkpoint" not in names:
        return set()
    marks = _members(file["checkpoint"])
    if not marks >= {"rows", "checksum"}:
        raise ValueError("its checkpoints are not those of a run")
    return marks


def _refuse_other_axis(file, name, values):
    """ValueError for an axis, which only other readers look at, that has other values or is not in the file itself."""
    data = _array(file, name)
    made = data.id.get_create_plist()
    if made.get_layout() != h5py.h5d.CONTIGUOUS or made.get_external_count():
        raise ValueError(f"{name} was not written by a run")
    if data.shape != values.shape or data.dtype != values.dtype or np.any(data[...] != values):
        raise ValueError(f"{name} is not that of the samples")


def _refuse_foreign(file, name, row_shape, kind, complete, size):
    """ValueError for an array that was not written by a run: another kind, shape, layout or filter, or larger than the file."""
    data = _array(file, name)
    if data.shape[1:] != row_shape:
        raise ValueError(f"{name} has another shape than a run writes")
    if not data.id.get_type().equal(kind):
        raise ValueError(f"{name} is no array of a run")
    made = data.id.get_create_plist()
    chunk = (CHECKPOINT_ROWS if "/" in name else CHUNK_ROWS, *row_shape)
    filters = [made.get_filter(i)[0] for i in range(made.get_nfilters())]
    if made.get_layout() != h5py.h5d.CHUNKED or made.get_external_count() or made.get_chunk() != chunk:
        raise ValueError(f"{name} was not written by a run")
    if filters != [h5py.h5z.FILTER_FLETCHER32]:
        raise ValueError(f"{name} was not written by a run")
    # of a run that a kill ended the last block may be declared and not yet written
    stored = min(data.id.get_storage_size(), size) if complete else min(data.id.get_storage_size(), size) + UNWRITTEN_BYTES
    if 8 * math.prod(data.shape) > stored:
        raise ValueError(f"{name} is larger than the file")


def _refuse_unequal(file, marks):
    """ValueError where the arrays of a whole file do not have the same number of rows."""
    rows, blocks = file["time"].shape[0], file[BLOCKS]
    if any(file[name].shape[0] != rows for name in sample_arrays(file)):
        raise ValueError("its arrays are not of one length")
    if rows != (blocks[-1, 0] if len(blocks) else 0):
        raise ValueError("its blocks are not those of its samples")
    if len({file[CHECKPOINT + name].shape[0] for name in marks}) > 1:
        raise ValueError("its checkpoints are not of one length")


def _format_of(file):
    """The format a file names, for a message."""
    if "format" not in file.attrs:
        return "none"
    attribute = file.attrs.get_id("format")
    kind = attribute.get_type()
    if kind.get_class() != h5py.h5t.STRING or attribute.shape != () or kind.get_size() > 1000:
        return "none"
    if kind.is_variable_str():
        return OLDER  # up to number 3, and not to be looked at, see `attributes`
    name = file.attrs["format"]
    return repr(one_line(name.decode("utf-8", "replace"))[:40]) if isinstance(name, bytes) else "none"


def refuse_other_file(path):
    """DataError unless a result may be written there: a new name, or one that a result has, of whatever version."""
    if not target(path, HDF5).exists() or not os.path.getsize(path):
        return
    problem = "cannot be written: what has this name cannot be read as a result; remove it, or choose another name"
    with Guard(path, problem), reading(path).opened() as file:
        name = _format_of(file)
    if name != OLDER and not name.startswith("'rsc-result-"):
        raise DataError(path, "cannot be written (an HDF5 file of another kind has this name)")


class reading(Guard):
    """Open an HDF5 file for reading, also one that a run is writing or was killed in; failures become a DataError.

    file : h5py.File, optional, the file where it is open already; it is left open
    """

    def __init__(self, path, file=None):
        super().__init__(Path(path), "cannot be read as a result")
        self._file, self._closes = file, file is None

    def __enter__(self):
        if not self._closes:
            return self._file
        with Guard(self._path, self._problem):
            if not self._path.exists():
                raise DataError(self._path, "does not exist")
            if self._path.is_dir():
                raise DataError(self._path, "is a directory, wanted: a result file")
            refuse_special(self._path, os.stat(self._path))  # a pipe or a device might never answer
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
        if self._closes:
            self._file.close()
        super().__exit__(kind, error, trace)
