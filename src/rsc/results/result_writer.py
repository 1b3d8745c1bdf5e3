"""Writing the HDF5 file of a run, block by block, in HDF5's single-writer form, and giving it its name at the end."""

import contextlib
from dataclasses import asdict
from pathlib import Path

import h5py
import numpy as np

from rsc.errors import DataError, WriteError
from rsc.files.gate import values_of
from rsc.files.held_back import HeldBack
from rsc.measure.stretches import COLUMNS, OF_CLEARANCE
from rsc.results.claims import claimed, part_of
from rsc.results.result_format import (
    AXES,
    BLOCKS,
    CHECKPOINT,
    CHECKPOINT_ROWS,
    CHUNK_ROWS,
    FED,
    FORMAT,
    MOTIONS,
    NOT_ALWAYS,
    OF_CONTACT,
    SERIES,
    STRETCHES,
    UNWRITTEN,
    Guard,
    checkpoint_checksum,
    checksum,
    digest,
    moving_body,
    put,
    sample_arrays,
    whole_blocks,
    with_sums,
    without_sums,
)
from rsc.results.structure import reading, refuse_other_file

LAYOUT = ("v110", "v110")  # of HDF5 1.10, the first with a single-writer form: HDF5 2 by default writes what 1.14 cannot read


def _no_stretches(scene):
    """The facts of no stretch of a run."""
    return np.empty((0, len(scene.contacts) * (len(COLUMNS) + len(OF_CLEARANCE) * len(scene.clearances))))


class ResultWriter:
    """Streams blocks into NAME.part, which takes its name when the run has ended.

    versions : str, versions and processor of the run (`rsc.simulation.run.versions`)
    overwrite : bool, also in the place of a file that rsc did not write
    locked : bool, whether a second writer would be refused

    Raises DataError when the file cannot be written or another run writes it.
    """

    def __init__(self, path, scene, versions, overwrite=False):
        self._overwrite = overwrite
        self.path, self._file, self._rows, self._nothing = Path(path), None, 0, _no_stretches(scene)
        self._head = {"format": FORMAT, "title": scene.title, "scene": scene.to_toml(), "versions": versions}
        self._part = part_of(path)
        self._claim = claimed(self.path, self._part, overwrite)
        self.locked = bool(self._claim.held)
        self._has_samples = False

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        # after a failed write HDF5 can neither close the file nor forget it; samples flushed before stay readable
        if self._file and not isinstance(error, WriteError):
            self._file.close()
        if not self._has_samples:
            self._claim.discard()
        self._claim.close()

    def append(self, block, checkpoint=None, stretches=None):
        """Append a block of samples (name -> array, motions complex), the checkpoint that follows it (name -> array) and the
        facts (`rsc.measure.stretches.Stretches`) of the stretches that ended in it."""
        arrays = {STRETCHES: with_sums(self._nothing if stretches is None else stretches)}
        for name, values in block.items():
            if name not in MOTIONS:
                arrays[name] = values
            elif values.shape[1]:
                arrays[name] = values.view(float).reshape(*values.shape, 2)
        if checkpoint is not None:
            for name, values in (checkpoint | {"checksum": np.array([checkpoint_checksum(checkpoint)])}).items():
                arrays[CHECKPOINT + name] = values[None, :]
        self._append(arrays)
        self._has_samples = self._has_samples or len(block["time"]) > 0

    def _writing(self):
        return Guard(self.path, "cannot be written", WriteError)

    def _create(self, arrays):
        """Make the file with all its datasets: in single-writer form none can be added later."""
        file = h5py.File(self._part, "w", libver=LAYOUT, locking=False)
        self._file = file
        put(file.attrs, self._head | {"checksum": digest(self._head)})
        for name, values in arrays.items():
            row_shape = values.shape[1:]
            rows = CHECKPOINT_ROWS if "/" in name else CHUNK_ROWS
            data = file.create_dataset(
                name, (0, *row_shape), values.dtype, maxshape=(None, *row_shape), chunks=(rows, *row_shape), fletcher32=True,
                fillvalue=np.nan if values.dtype == float else UNWRITTEN,
            )  # fmt: skip
            if "/" not in name:
                unit, text = {"time": ("s", "time"), **SERIES, **NOT_ALWAYS, **MOTIONS}[name]
                put(data.attrs, {"units": unit, "long_name": text})
        _name_axes(file)
        file.swmr_mode = True

    def copy(self, source, rows, n_stretches):
        """Begin with the first `rows` samples, all checkpoints up to them and the first stretches of another result file."""
        with reading(source) as old:
            marks = [CHECKPOINT + name for name in old["checkpoint"]]
            n_checkpoints = int(np.searchsorted(old[CHECKPOINT + "rows"][:, 0], rows, side="right"))
            names, first, ends = sample_arrays(old), 0, whole_blocks(old)
            empty = {name: old[name][:0] for name in (*names, *marks, STRETCHES)}
            stretches = old[STRETCHES][:n_stretches]
            if len(without_sums(stretches)) < n_stretches:
                raise DataError(source, f"has fewer stretches than its last checkpoint, {n_stretches}")
            for last, *sums in ends[ends[:, 0] <= rows]:
                block = {name: old[name][first:last] for name in names}
                if [checksum(values) for values in block.values()] != sums:
                    raise DataError(source, f"is damaged between samples {first} and {last}")
                self._append(empty | block)
                first = last
            self._append(empty | {name: old[name][:n_checkpoints] for name in marks} | {STRETCHES: stretches})

    def _append(self, arrays):
        names = sample_arrays(arrays)
        sums = [[len(arrays["time"]), *(checksum(arrays[name]) for name in names)]]
        arrays[BLOCKS] = np.array(sums if len(arrays["time"]) else np.empty((0, 1 + len(names))), dtype=np.int64)
        arrays[BLOCKS][:, 0] += self._rows
        self._rows += len(arrays["time"])
        with self._writing():
            if self._file is None:
                self._create(arrays)
            self._put(STRETCHES, arrays.pop(STRETCHES))
            self._file[STRETCHES].flush()  # on the disk before the checkpoint that counts them, wherever a kill falls
            for name, values in arrays.items():
                self._put(name, values)
            self._file.flush()

    def _put(self, name, values):
        data = self._file[name]
        rows = data.shape[0]
        data.resize(rows + values.shape[0], axis=0)
        data[rows:] = values

    def finish(self, summary, stretches=None):
        """Write the last stretches and the summary, close the file and give it its name. Wherever a kill falls, the part can be
        continued."""
        with self._writing():
            if stretches is not None:
                self._put(STRETCHES, with_sums(stretches))
            self._file.close()
            with contextlib.closing(HeldBack(self._part)) as part:
                with h5py.File(part, "r+", libver=LAYOUT) as file:
                    values = asdict(summary)
                    fed = {name: values["ledger"].pop(name) for name in FED}
                    put(file.attrs, values | {"ledger": [float(v) for v in values["ledger"].values()]})
                    put(file.attrs, {name: value for name, value in fed.items() if value})
                    put(file.attrs, {"checksum": digest(values_of(file))})
                part.apply()
            self._file, self._has_samples = None, True
            self._refuse_what_came_meanwhile()
            self._claim.publish(self.path)

    def _refuse_what_came_meanwhile(self):
        """DataError for a file that somebody has put in the place of the result since the run began."""
        try:
            refuse_other_file(self.path, self._overwrite)
        except DataError as error:
            raise DataError(self.path, f"{error.problem}; the whole run is in {self._part.name}") from None


def _name_axes(file):
    """Name the axes as netCDF-4 readers expect."""
    file["time"].make_scale("time")
    axis = file.create_dataset("axis", data=np.array(["y", "z"], dtype="S1"))
    axis.make_scale("axis")
    for name in filter(file.__contains__, (*SERIES, *NOT_ALWAYS)):
        file[name].dims[0].attach_scale(file["time"])
    several = [name for name in OF_CONTACT if name in file and file[name].ndim > 1]
    if several:
        index = file.create_dataset("contact", data=np.arange(file[several[0]].shape[1]))
        index.make_scale("contact")
        for name in several:
            file[name].dims[1].attach_scale(index)
    for body in filter(file.__contains__, AXES):
        index = file.create_dataset(AXES[body], data=np.arange(file[body].shape[1]))
        index.make_scale(AXES[body])
    for name in filter(file.__contains__, MOTIONS):
        for i, scale in enumerate((file["time"], file[AXES[moving_body(name)]], axis)):
            file[name].dims[i].attach_scale(scale)
