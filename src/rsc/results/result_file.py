"""Reading the HDF5 file of a run: netCDF-4 axes and units, checksummed blocks, checkpoints; readable after any kill.

While a run goes on its file is called NAME.part and is written in HDF5's single-writer form: flushed samples stay readable
whatever happens to the writer. Every block of samples carries a checkpoint, from which the run continues bit for bit.
"""

import contextlib
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError
from rsc.files.gate import values_of
from rsc.measure.stretches import COLUMNS, OF_CLEARANCE, Stretches
from rsc.results.agreement import (
    refuse_impossible,
    refuse_other_end,
    refuse_other_scene_than_samples,
    refuse_other_stretches,
    refuse_other_times,
)
from rsc.results.result_format import (
    CHECKPOINT,
    FED,
    MOTIONS,
    NOT_ALWAYS,
    OF_CONTACT,
    STRETCHES,
    TURNED,
    block_ends,
    checked,
    checkpoint_checksum,
    checksum,
    motions_of,
    sample_arrays,
    series_of,
    whole_blocks,
    without_sums,
)
from rsc.results.structure import reading
from rsc.results.summary import Ledger, Status, Summary
from rsc.scene.scene import Scene


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
