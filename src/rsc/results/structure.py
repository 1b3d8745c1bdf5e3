"""Opening a result file: is it the result of a run? The gate's table for results, and what its arrays must have in common."""

import contextlib
import ctypes
import os
from dataclasses import fields
from pathlib import Path

import h5py
import numpy as np

from rsc.errors import DataError, one_line
from rsc.files import gate
from rsc.files.content import refuse_special
from rsc.files.gate import F8, I8, TEXT, Array
from rsc.files.output import place, refuse_foreign
from rsc.measure.stretches import COLUMNS, OF_CLEARANCE
from rsc.operating_system import hdf5_library, read_at
from rsc.results.result_format import (
    AXES,
    BLOCKS,
    CHECKPOINT,
    CHECKPOINT_ROWS,
    CHUNK_ROWS,
    FED,
    FORMAT,
    HEAD,
    MOTIONS,
    NOT_ALWAYS,
    OF_CONTACT,
    SERIES,
    STRETCHES,
    Guard,
    digest,
    moving_body,
    sample_arrays,
)
from rsc.results.summary import Summary
from rsc.scene.tables.clearances import MAX_CLEARANCES
from rsc.scene.tables.contacts import MAX_CONTACTS

READ_ATTEMPTS = 24  # 2^24 ns in all
UNWRITTEN_BYTES = 64 * 2**20
SIGNATURE = b"\x89HDF\r\n\x1a\n"
NO_FORMAT, OLDER = "none", "an older one, rsc-result-1 to 3"
# bytes that the text of a scene may have, and for every pair of coordinates
SCENE_BYTES, MATRIX_BYTES = 4 * 2**20, 300
# numbers of an array in a checkpoint beyond four for every coordinate (older kernels kept more): what they mean and how many this
# version wants is for `rsc.simulation.checkpoint` to say
CHECKPOINT_NUMBERS = MAX_CONTACTS * (64 + 2 * MAX_CLEARANCES)
_SUMMARY = [*(item.name for item in fields(Summary)), *FED]  # of a run that has ended
_KNOWN = dict.fromkeys((*HEAD, *_SUMMARY), ()) | {"ledger": (7,)}
_COORDINATES = {axis: name for name, axis in AXES.items()}  # axes for other readers
_AXIS = np.array(["y", "z"], dtype="S1")
_GROUPS = ("checkpoint", *(name.partition("/")[0] for name in (BLOCKS, STRETCHES)))


def refuse_other_structure(path, file):
    """Look at an open file.

    Raises
    ------
    DataError
        Of another format.
    ValueError
        With what no run has written.
    """
    shown = _format_of(file)
    if shown != repr(FORMAT):
        raise DataError(path, f"is no result of this version (its format is {shown}, this rsc reads {FORMAT!r})")
    names = gate.members(file, {"time", *SERIES, *NOT_ALWAYS, *MOTIONS, "axis", "contact", *_COORDINATES, *_GROUPS})
    bodies = [gate.dataset(file, name) for name in names & set(AXES)]
    counts = {data.name[1:]: data.shape[1] for data in bodies if data.ndim == 3}
    attrs = gate.attributes(file, _KNOWN, SCENE_BYTES + MATRIX_BYTES * sum(counts.values()) ** 2, _SUMMARY)
    if attrs.get("checksum") != digest(attrs):
        raise ValueError("its scene or summary was changed")
    complete = "status" in attrs
    marks = gate.members(file["checkpoint"]) if "checkpoint" in names else set()
    table = _table(file, names, marks, (complete, sum(counts.values())))
    lengths = gate.look_at(file, table, path.stat().st_size, 0 if complete else UNWRITTEN_BYTES)
    for name in sorted({"axis", "contact", *_COORDINATES} & names):
        count = file[OF_CONTACT[0]].shape[-1] if name == "contact" else counts.get(_COORDINATES.get(name, ""), 0)
        if np.any(file[name][()] != (_AXIS if name == "axis" else np.arange(count))):
            raise ValueError(f"{name} is not that of the samples")
    if complete and lengths["row"] != (file[BLOCKS][-1, 0] if lengths["block"] else 0):
        raise ValueError("its blocks are not those of its samples")


def _table(file, names, marks, run):
    """What the gate lets pass: the arrays of a run that has ended have one length, those of one that a kill ended their own."""
    complete, n_coordinates = run

    def rows(axis, name):
        return axis if complete else f"{axis} of {name}"

    motions = [name for name in MOTIONS if name in names]  # in this order, so that the same array is named every time
    series = ("time", *SERIES, *(name for name in NOT_ALWAYS if name in names))
    table = {name: Array(F8, (rows("row", name),), CHUNK_ROWS) for name in series}
    for name in OF_CONTACT:
        shape = gate.dataset(file, name).shape if name in names else ()
        if len(shape) == 2 and 1 < shape[1] <= MAX_CONTACTS:
            table[name] = Array(F8, (rows("row", name), shape[1]), CHUNK_ROWS)
    table |= {name: Array(F8, (rows("row", name), moving_body(name), 2), CHUNK_ROWS) for name in motions}
    table |= {STRETCHES: Array(F8, ("stretch", _facts_in_a_row(file, names)), CHECKPOINT_ROWS)}
    table |= {BLOCKS: Array(I8, ("block", 1 + len(sample_arrays(file))), CHECKPOINT_ROWS)}
    if marks and not marks >= {"rows", "checksum"}:
        raise ValueError("its checkpoints are not those of a run")
    most = 4 * n_coordinates + CHECKPOINT_NUMBERS
    for name in sorted(marks):
        data = gate.dataset(file["checkpoint"], name)
        length = 1 if name in ("rows", "checksum") else (0, *data.shape)[-1]
        if not 0 < length <= most:
            raise ValueError(f"{CHECKPOINT}{name} has another shape than rsc writes")
        whole = name in ("rows", "checksum") or data.dtype.kind == "i"
        table[CHECKPOINT + name] = Array(I8 if whole else F8, (rows("checkpoint", name), length), CHECKPOINT_ROWS)
    if "contact" in names:
        table["contact"] = Array(I8, (table[OF_CONTACT[0]].shape[-1],))
    return table | {name: Array(TEXT if name == "axis" else I8, (2,) if name == "axis" else (_COORDINATES[name],))
                    for name in ("axis", *_COORDINATES) if name in names}  # fmt: skip


def _facts_in_a_row(file, names):
    """Numbers of a stretch, the sum behind them: those of every contact, with clearances some more for each; how many of both the
    scene has is asked later."""
    group, _, name = STRETCHES.partition("/")
    least = len(COLUMNS) + 1
    if group not in names or name not in gate.members(file[group]):
        return least
    shape = gate.dataset(file[group], name).shape
    each = [len(COLUMNS) + k * len(OF_CLEARANCE) for k in range(MAX_CLEARANCES + 1)]
    allowed = {n * width + 1 for n in range(1, MAX_CONTACTS + 1) for width in each}
    return shape[1] if len(shape) == 2 and shape[1] in allowed else least


def _format_of(file):
    """The format a file names, for a message."""
    if "format" in file.attrs:
        kind = file.attrs.get_id("format").get_type()
        if kind.get_class() == h5py.h5t.STRING and kind.is_variable_str():
            return OLDER  # up to number 3, and not to be looked at, see `gate.attributes`
    name = gate.text_of(file, "format")
    return NO_FORMAT if name is None else repr(one_line(name)[:40])


def refuse_other_file(path, overwrite=False):
    """DataError unless a result may be written there: a new name, or that of a result of this version whose scene, summary, names
    and shapes are as rsc wrote them. The samples, which may be many, are not read for that.

    overwrite : bool, also in the place of any other file
    """
    path = place(path)
    if overwrite or not path.exists() or not os.path.getsize(path):
        return
    try:
        with reading(path):
            pass
    except DataError:
        refuse_foreign(path)


def refuse_other_part(file):
    """DataError for a file in the place of one that a run writes or left, which no run has written: one of another kind, or an
    HDF5 file of another format. Of a run that was killed not even the beginning may be there, or nothing that can be read."""
    head = b""
    if not os.path.isfile(file) or os.path.islink(file):  # refused by whoever claims it
        return
    with contextlib.suppress(PermissionError), open(file, "rb") as opened:  # on Windows another run has it open
        head = opened.read(len(SIGNATURE))
    if head.strip(b"\0") and (head != SIGNATURE or _is_of_another(file)):
        refuse_foreign(file)


def _is_of_another(file):
    """Whether an HDF5 file can be read, and holds something that no run has written."""
    with contextlib.suppress(OSError, ValueError, RuntimeError, DataError), reading(file).opened() as opened:
        return not _format_of(opened).startswith("'rsc-result-") and bool(has_format(opened) or len(opened))
    return False


def has_format(file):
    """Whether an open file names a format."""
    return _format_of(file) != NO_FORMAT


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
        with open(self._path, "rb") as file:
            gate.refuse_endless(lambda place, count: read_at(file.fileno(), place, count), self._path.stat().st_size)
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
        library = hdf5_library(h5py.defs.__file__)
        library.H5Pset_metadata_read_attempts(ctypes.c_int64(access.id), ctypes.c_uint(READ_ATTEMPTS))
        return h5py.File(h5py.h5f.open(os.fsencode(self._path), h5py.h5f.ACC_RDONLY | h5py.h5f.ACC_SWMR_READ, access))

    def __exit__(self, kind, error, trace):
        if self._closes:
            self._file.close()
        super().__exit__(kind, error, trace)
