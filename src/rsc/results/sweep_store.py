"""The store of a sweep: a folder with a plan and one file for each part, each whole or not there, read while others are written.

A file is an HDF5 image behind a user block of 512 bytes with the SHA-256 of the image: what a disk damaged is noticed before HDF5
looks at it. It is written beside its place, synced and renamed; nothing is ever changed in place.
"""

import fcntl
import hashlib
import io
import os
import re
import socket
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from math import prod
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, one_line
from rsc.files.content import opened
from rsc.results.result_format import Guard, attributes, put

FORMAT = "rsc-sweep-1"
USER_BLOCK = 512
LARGEST_FILE = 4 * 2**30  # bytes
PLAN, PARTS, LOCK = "plan.h5", "parts", "lock"


@dataclass(frozen=True)
class Axis:
    """The values that one key takes along one dimension.

    key : str, name of a value of the scene; dim : str, the key itself, or "sample", "case" or "zipped" shared by several
    values : tuple of float (SI, frequencies Hz) or str; unit, meaning : str
    """

    key: str
    dim: str
    values: tuple[Any, ...]
    unit: str
    meaning: str


@dataclass(frozen=True)
class Cases:
    """All cases of a sweep, numbered from 0; the last dimension runs fastest."""

    axes: tuple[Axis, ...]

    @cached_property
    def dims(self) -> dict[str, int]:
        """Dimensions in their order: name -> number of values."""
        return {axis.dim: len(axis.values) for axis in self.axes}

    @property
    def keys(self) -> tuple[str, ...]:
        """Names of the varied values."""
        return tuple(axis.key for axis in self.axes)

    def __len__(self) -> int:
        return prod(self.dims.values())

    def values(self, first: int, last: int) -> list[tuple[Any, ...]]:
        """The values of the keys in the cases from number `first` to `last` (exclusive)."""
        places = dict(zip(self.dims, np.unravel_index(np.arange(first, last), tuple(self.dims.values())), strict=True))
        columns = [[axis.values[i] for i in places[axis.dim].tolist()] for axis in self.axes]
        return list(zip(*columns, strict=True))


@dataclass(frozen=True)
class Plan:
    """What a sweep computes.

    scene : str, the resolved scene before anything is varied, as TOML; source : str, its name for messages
    kinds : tuple of str, what is computed; part_sizes : tuple of int, cases in a part of each kind; cases : Cases
    versions : str, versions and processor (`rsc.simulation.run.versions`)
    """

    scene: str
    source: str
    kinds: tuple[str, ...]
    part_sizes: tuple[int, ...]
    cases: Cases
    versions: str


class SweepStore:
    """The folder of a sweep.

    Raises DataError when something in it cannot be read or written.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)

    @property
    def exists(self) -> bool:
        """Whether there is a plan."""
        return (self.folder / PLAN).exists()

    @property
    def holds_nothing(self) -> bool:
        """Whether the folder is new or empty, but for what a process leaves that died before its plan was written."""
        if not self.folder.exists():
            return True
        return self.folder.is_dir() and all(_begins(path.name) for path in self.folder.iterdir())

    def plan(self) -> Plan:
        """The plan of the sweep."""
        path = self.folder / PLAN
        if not self.folder.is_dir() or not path.exists():
            raise DataError(self.folder, "is no store of a sweep (it has no plan)")
        with _image(path) as file:
            attrs = attributes(file)
            axes = []
            for name in sorted(file):
                own = attributes(file[name])
                values = tuple(v.decode() if isinstance(v, bytes) else v for v in file[name][()].tolist())
                axes.append(Axis(own["key"], own["dim"], values, own["unit"], own["meaning"]))
            scene, source, versions = (str(attrs[name]) for name in ("scene", "source", "versions"))
            kinds = tuple(str(attrs["kinds"]).split(","))
            sizes = tuple(int(size) for size in str(attrs["part_sizes"]).split(","))
            return Plan(scene, source, kinds, sizes, Cases(tuple(axes)), versions)

    def write_plan(self, plan: Plan) -> None:
        """Make the folder and its plan; the plan of another sweep that was there stays beside it under another name."""
        path = self.folder / PLAN
        with Guard(self.folder, "cannot be written"):
            self.folder.mkdir(parents=True, exist_ok=True)
            if path.exists():
                earlier = path.read_bytes()
                path.with_name(f"plan-{hashlib.sha256(earlier).hexdigest()[:12]}.h5").write_bytes(earlier)
        head = {name: getattr(plan, name) for name in ("scene", "source", "versions")}
        head |= {"kinds": ",".join(plan.kinds), "part_sizes": ",".join(map(str, plan.part_sizes))}
        arrays, own = {}, {}
        for i, axis in enumerate(plan.cases.axes):
            words = any(isinstance(value, str) for value in axis.values)
            values = [str(value).encode() for value in axis.values] if words else axis.values
            arrays[f"axis{i:03d}"] = np.array(values)
            own[f"axis{i:03d}"] = {name: getattr(axis, name) for name in ("key", "dim", "unit", "meaning")}
        _write(path, arrays, head, own)

    def parts(self) -> list[str]:
        """Names of the parts that are there, of all plans."""
        folder = self.folder / PARTS
        return sorted(path.stem for path in folder.glob("*.h5")) if folder.is_dir() else []

    def has(self, name: str) -> bool:
        """Whether a part is there."""
        return self._part(name).exists()

    def read(self, name: str) -> dict[str, NDArray]:
        """The arrays of a part."""
        with _image(self._part(name)) as file:
            return {column: file[column][()] for column in file}

    def write(self, name: str, rows: Mapping[str, NDArray]) -> None:
        """Add a part: its file takes its name when it is whole and on the disk."""
        with Guard(self.folder, "cannot be written"):
            (self.folder / PARTS).mkdir(exist_ok=True)
        _write(self._part(name), rows, {}, {})

    def clear(self) -> None:
        """Remove what processes of this machine that died left half written."""
        own = re.compile(rf".+\.{re.escape(socket.gethostname())}-(\d+)\.tmp")
        for path in [*self.folder.glob("*.tmp"), *(self.folder / PARTS).glob("*.tmp")]:
            match = own.fullmatch(path.name)
            if match and not _runs(int(match[1])):
                path.unlink(missing_ok=True)

    def _part(self, name: str) -> Path:
        return self.folder / PARTS / f"{name}.h5"

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the store for this process alone; the lock dies with the process. A disk without locks has none."""
        path = self.folder / LOCK
        with Guard(self.folder, "cannot be written"):
            self.folder.mkdir(parents=True, exist_ok=True)
            handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            owner = one_line(os.read(handle, 200).decode(errors="replace"))
            os.close(handle)
            raise DataError(self.folder, f"is being written by another sweep ({owner})") from None
        except OSError:
            pass
        try:
            os.truncate(handle, 0)
            os.write(handle, f"process {os.getpid()} on {socket.gethostname()}".encode())
            yield
        finally:
            os.close(handle)


def _begins(name: str) -> bool:
    """Whether a file is the lock or a plan half written."""
    return name == LOCK or (name.startswith(f"{PLAN}.") and name.endswith(".tmp"))


def _runs(process: int) -> bool:
    """Whether there is a process with this number."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True


def _write(path: Path, arrays: Mapping[str, NDArray], head: Mapping[str, Any], own: Mapping[str, Mapping[str, Any]]) -> None:
    """Write arrays and attributes to a file, whole or not at all. HDF5 works in memory: a full disk is an error of this call."""
    image = io.BytesIO()
    with h5py.File(image, "w", userblock_size=USER_BLOCK) as file:
        put(file.attrs, {"format": FORMAT, **head})
        for name, values in arrays.items():
            put(file.create_dataset(name, data=values).attrs, own.get(name, {}))
    content = image.getvalue()[USER_BLOCK:]
    block = f"{FORMAT}\n{hashlib.sha256(content).hexdigest()}\n".encode().ljust(USER_BLOCK, b"\0")
    beside = path.with_name(f"{path.name}.{socket.gethostname()}-{os.getpid()}.tmp")
    with Guard(path, "cannot be written"):
        try:
            with open(beside, "wb") as stream:
                stream.write(block + content)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(beside, path)
        except BaseException:
            beside.unlink(missing_ok=True)
            raise
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


@contextmanager
def _image(path: Path) -> Iterator[h5py.File]:
    """The HDF5 image of a file, once its sum is right."""
    with opened(path, LARGEST_FILE) as stream:
        content = stream.read()
    lines = content[:USER_BLOCK].split(b"\n")
    if lines[0] != FORMAT.encode():
        raise DataError(path, f"is no file of a sweep of this version (this rsc reads {FORMAT!r})")
    if len(lines) < 2 or hashlib.sha256(content[USER_BLOCK:]).hexdigest().encode() != lines[1]:
        raise DataError(path, "is damaged (its checksum is another)")
    with Guard(path, "cannot be read as a part of a sweep"), h5py.File(io.BytesIO(content), "r") as file:
        yield file
