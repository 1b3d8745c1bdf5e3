"""The HDF5 file of a run: netCDF-4 axes and units, checksummed blocks, checkpoints; readable to its last block after any kill.

While a run goes on its file is called NAME.part and is written in HDF5's single-writer form: flushed samples stay readable
whatever happens to the writer. Every block of samples carries a checkpoint, from which the run continues bit for bit.
"""

import contextlib
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, WriteError
from rsc.files.gate import values_of
from rsc.files.held_back import HeldBack
from rsc.measure.stretches import COLUMNS, OF_CLEARANCE, Stretches
from rsc.results.agreement import (
    refuse_impossible,
    refuse_other_end,
    refuse_other_scene_than_samples,
    refuse_other_stretches,
    refuse_other_times,
)
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
    TURNED,
    UNWRITTEN,
    Guard,
    block_ends,
    checked,
    checkpoint_checksum,
    checksum,
    digest,
    motions_of,
    moving_body,
    put,
    sample_arrays,
    series_of,
    whole_blocks,
    with_sums,
    without_sums,
)
from rsc.results.structure import reading, refuse_other_file
from rsc.results.summary import Ledger, Status, Summary
from rsc.scene.scene import Scene

LAYOUT = ("v110", "v110")  # of HDF5 1.10, the first with a single-writer form: HDF5 2 by default writes what 1.14 cannot read


class ResultFile:
    """The samples of a run in its file, read when asked for."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self._scene: Scene | None = None
        self._file: h5py.File | None = None

    @contextlib.contextmanager
    def kept_open(self) -> Iterator[None]:
        """Inside, the file is opened and looked at once, and not again with every question."""
        before = self._file
        with self._reading() as self._file:
            try:
                yield
            finally:
                self._file = before

    def _reading(self):
        return reading(self.path, self._file)

    def series(self, name: str) -> NDArray[np.float64]:
        """One array over time."""
        scene = self.scene()
        with self._reading() as file:
            values = checked(file, name)
            if name in ("time", "speed", *TURNED):
                refuse_other_times(scene, name, values)
            return values

    def motion(self, name: str, column: int | None = None) -> NDArray[np.complex128]:
        """Complex displacements or velocities, all or one column."""
        with self._reading() as file:
            if name not in file:  # a rigid stator has no coordinates to store
                return np.zeros((file["time"].shape[0], 0), dtype=complex)
            return checked(file, name, column).view(complex)[..., 0]

    def digest(self) -> str:
        """SHA-256 over scene, summary and versions."""
        with self._reading() as file:
            return str(values_of(file)["checksum"])

    def n_time(self) -> int:
        """Number of samples."""
        with self._reading() as file:
            return _samples(file)

    def at_contact(self, columns: Mapping[str, int], rows: tuple[int, int]) -> dict[str, np.ndarray]:
        """Every array over time, and of `rotor` and `stator` one coordinate each, in the rows first to last (exclusive)."""
        scene = self.scene()
        with self._reading() as file:
            block = {name: checked(file, name, rows=rows) for name in ("time", *series_of(scene))}
            motions = {name: checked(file, name, column, rows) for name, column in columns.items()}
            for name in ("time", "speed", *(name for name in TURNED if name in block)):
                refuse_other_times(scene, name, block[name], rows[0])
        return block | {name: values.view(complex)[..., 0] for name, values in motions.items()}

    def block(self) -> dict[str, np.ndarray]:
        """All samples as one block."""
        values = {name: self.series(name) for name in ("time", *series_of(self.scene()))}
        return values | {name: self.motion(name) for name in motions_of(self.scene())}

    def scene(self) -> Scene:
        """The resolved scene that the run was made with."""
        if self._scene is None:
            with self._reading() as file:
                attrs = values_of(file)
                scene = Scene.from_stored(str(attrs["scene"]), f"{self.path} (stored scene)")
                if attrs["title"] != scene.title:
                    raise ValueError("its title is not that of the stored scene")
                if {name for name in NOT_ALWAYS if name in file} != set(NOT_ALWAYS) & set(series_of(scene)):
                    raise ValueError("its series are not those of a run of the stored scene")
                counts = {name: file[name].shape[1] if name in file else 0 for name in MOTIONS}
                refuse_other_scene_than_samples(scene, counts, _samples(file))
                several = (len(scene.contacts),) if len(scene.contacts) > 1 else ()
                if any(file[name].shape[1:] != several for name in OF_CONTACT if name in file):
                    raise ValueError("its forces are not those of the contacts of the stored scene")
            self._scene = scene
        return self._scene

    def facts(self) -> NDArray[np.float64]:
        """Facts of the stretches of the run, those of several contacts side by side."""
        scene = self.scene()
        with self._reading() as file:
            facts = without_sums(file[STRETCHES][...])
            width = len(COLUMNS) + len(OF_CLEARANCE) * len(scene.clearances)
            if facts.shape[1] != width * len(scene.contacts):
                raise ValueError("its stretches are not those of its contacts and clearances")
            for i in range(len(scene.contacts)):
                refuse_other_stretches(scene, Stretches(facts[:, i * width : (i + 1) * width]), _summary(self.path, file))
            return facts

    def summary(self) -> Summary:
        """The Summary of a finished (or stopped) run; DataError when there is none."""
        scene = self.scene()
        with self._reading() as file:
            summary = _summary(self.path, file)
            refuse_other_end(scene, summary, _samples(file))
        return summary

    def rows(self, first, last):
        """The samples from row first to last (exclusive) as a block."""
        with self._reading() as file:
            block = {name: file[name][first:last] for name in sample_arrays(file)}
        return {n: np.ascontiguousarray(v).view(complex)[..., 0] if n in MOTIONS else v for n, v in block.items()}

    def checkpoint_rows(self):
        """(n,) numbers of samples at the checkpoints of a whole file, from 0 on; empty without any."""
        with self._reading() as file:
            if CHECKPOINT + "rows" not in file:
                return np.zeros(0, dtype=int)
            rows = file[CHECKPOINT + "rows"][:, 0]
            if len(rows) and rows[0] != 0:
                raise ValueError("its checkpoints do not begin at its start")
            return block_ends(rows[1:], _samples(file))[: len(rows)]

    def checkpoint_at(self, i):
        """name -> array of checkpoint i."""
        with self._reading() as file:
            return _checkpoint(file, i)

    def versions(self):
        """Versions and processor that the run was made with so far (`rsc.simulation.run.versions`)."""
        with self._reading() as file:
            return str(values_of(file)["versions"])

    def checkpoint(self):
        """(name -> array of the last checkpoint that is whole, with all samples before it, the same of the one before that); None
        for what there is not.

        `rows` is the number of samples that belong to it. A kill or a full disk may fall between the samples of a block and its
        checkpoint, or inside either.
        """
        with self._reading() as file:
            if CHECKPOINT + "rows" not in file:
                return None, None
            complete = min(file[CHECKPOINT + name].shape[0] for name in file["checkpoint"])
            for i in range(complete - 1, -1, -1):
                try:
                    candidate = _checkpoint(file, i)
                    if _is_whole(file, int(candidate["rows"][0])):
                        return candidate, _checkpoint(file, i - 1) if i else None
                except (OSError, ValueError):
                    continue
        return None, None

    def has_stretches(self, n):
        """Whether the facts of the first n stretches can be read: a write that was torn at their end destroys those before it."""
        try:
            with self._reading() as file:
                return len(without_sums(file[STRETCHES][:n])) == n
        except DataError:
            return False


def _samples(file):
    """Samples in the blocks of a file."""
    blocks = whole_blocks(file)
    return int(blocks[-1, 0]) if len(blocks) else 0


def _checkpoint(file, i):
    """name -> array of a checkpoint; ValueError when it is damaged."""
    arrays = {name: file[CHECKPOINT + name][i] for name in file["checkpoint"]}
    if checkpoint_checksum(arrays) != int(arrays.pop("checksum")[0]):
        raise ValueError(f"checkpoint {i} is damaged")
    return arrays


def _is_whole(file, rows):
    """Whether the block of samples that ends at `rows` was really written, in every array; earlier ones were flushed before it.

    A chunk with a wrong sum of its own raises OSError, one that was never written reads as NaN.
    """
    blocks = whole_blocks(file)
    ends = blocks[:, 0]
    if rows == 0:
        return True
    matches = np.flatnonzero(ends == rows)
    if not len(matches):
        return False
    sums, first = blocks[matches[0], 1:], int(ends[matches[0] - 1]) if matches[0] else 0
    pairs = zip(sample_arrays(file), sums, strict=True)
    return all(file[name].shape[0] >= rows and checksum(file[name][first:rows]) == expected for name, expected in pairs)


def read_summary(path: str | os.PathLike[str]) -> Summary:
    """The Summary of a finished (or stopped) run; DataError when the file is none or holds none."""
    with reading(path) as file:
        return _summary(path, file)


def _summary(path, file):
    attrs = values_of(file)
    if "status" not in attrs:
        raise DataError(path, "holds a run that did not end (rsc run --resume continues it)")
    kinds = {name: kind for name, kind in Summary.__annotations__.items() if kind in (int, float, str)}
    plain = {name: attrs[name] if kind is str else kind(attrs[name]) for name, kind in kinds.items()}
    if not all(isinstance(plain[name], kind) for name, kind in kinds.items()):
        raise ValueError("a text of the summary is none")
    ledger = Ledger(*(float(v) for v in attrs["ledger"]), **{name: float(attrs.get(name, 0.0)) for name in FED})
    summary = Summary(status=Status(attrs["status"]), ledger=ledger, **plain)
    refuse_impossible(summary)
    return summary


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
