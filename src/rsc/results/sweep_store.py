"""The store of a sweep: a folder with a plan and one file for each part, each whole or not there, read while others are written.

A file is an HDF5 image behind a user block of 512 bytes with the SHA-256 of the image: what a disk damaged is noticed before HDF5
looks at it, and what somebody forged by the gate. It is written as `rsc.files.whole` tells, and never changed in place. No link
in the folder is followed.
"""

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
from rsc.files import gate
from rsc.files.content import content_of
from rsc.files.gate import F8, I1, I8, TEXT, Array
from rsc.files.whole import clear_abandoned, entered, inside, is_file, is_private, kind_of, write_whole
from rsc.operating_system import Folder, is_own, lock
from rsc.presented import Brief
from rsc.results.result_format import Guard, put
from rsc.scene.scene import Scene
from rsc.scene.values import value_of

FORMAT = "rsc-sweep-2"
USER_BLOCK = 512
LARGEST_PLAN, LARGEST_PART = 2**30, 2**26  # bytes
MOST_AXES, MOST_CASES = 1000, 128  # of a plan; of a part
LARGEST_COUNT = 2**53  # of the cases of a plan
SAMPLE, CASE, ZIPPED = SHARED = ("sample", "case", "zipped")  # dimensions that are no key
PLAN, PARTS, LOCK = "plan.h5", "parts", "lock"
_OWNER = re.compile(rb"process \d+(?: o?| on| on [^\n]{0,180})?")  # what the lock holds, or the part written before a kill
_PLAN_HEAD = dict.fromkeys(("format", "scene", "source", "kinds", "part_sizes", "versions"), ())
_ENTRIES = f"{F8} {I8} {I1} {TEXT}"  # I1: true or false


# what every part tells of its origin: what was computed, by which versions, and the SHA-256 of all that defines its cases
ORIGIN = ("kind", "versions", "cases")


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


@dataclass(frozen=True, repr=False)
class Cases(Brief):
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

    Raises DataError when something in it cannot be read or written, or is not what a sweep writes.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)

    @property
    def exists(self) -> bool:
        """Whether there is a plan."""
        return os.path.lexists(self.folder / PLAN)

    @property
    def holds_nothing(self) -> bool:
        """Whether the folder is new or empty, but for what a process leaves that died before its plan was written."""
        if not self.folder.is_dir():
            return not os.path.lexists(self.folder)
        with entered(self.folder) as folder:
            return all(name == LOCK or is_private(name) for name in folder.names())

    def plan(self) -> Plan:
        """The plan of the sweep."""
        if not self.folder.is_dir() or not self.exists:
            raise DataError(self.folder, "is no store of a sweep (it has no plan)")
        path = self.folder / PLAN
        with entered(self.folder) as folder, _image(path, folder, LARGEST_PLAN) as (file, size):
            head = gate.attributes(file, _PLAN_HEAD, gate.LONGEST_SCENE)
            scene, source, versions, kinds, sizes = (
                str(head[name]) for name in ("scene", "source", "versions", "kinds", "part_sizes")
            )
            gate.refuse_unprintable("its head", source, versions, kinds, sizes)
            part_sizes = tuple(int(size) for size in sizes.split(",")[:MOST_AXES])
            if not all(1 <= size <= MOST_CASES for size in part_sizes) or len(part_sizes) != kinds.count(",") + 1:
                raise ValueError(f"part_sizes = {sizes[:40]}")
            axes = _axes(Scene.from_stored(scene, source), file, size)
        return Plan(scene, source, tuple(kinds.split(",")), part_sizes, Cases(axes), versions)

    def write_plan(self, plan: Plan) -> None:
        """Make the folder and its plan; the plan of another sweep that was there stays beside it under another name."""
        path = self.folder / PLAN
        head = {name: getattr(plan, name) for name in ("scene", "source", "versions")}
        head |= {"kinds": ",".join(plan.kinds), "part_sizes": ",".join(map(str, plan.part_sizes))}
        arrays, own = {}, {}
        for i, axis in enumerate(plan.cases.axes):
            words = any(isinstance(value, str) for value in axis.values)
            values = np.array([str(value).encode() for value in axis.values] if words else axis.values)
            arrays[f"axis{i:03d}"] = values.astype("i1") if values.dtype == bool else values
            own[f"axis{i:03d}"] = {"key": axis.key, "dim": axis.dim}
        with entered(self.folder, make=True) as folder:
            if self.exists:
                earlier = content_of(path, LARGEST_PLAN, folder)
                with Guard(path, "cannot be written"):
                    write_whole(folder, f"plan-{hashlib.sha256(earlier).hexdigest()[:12]}.h5", [earlier])
            _write(path, folder, arrays, head, own)

    def parts(self) -> list[str]:
        """Names of the parts that are there, of all plans."""
        if not os.path.lexists(self.folder / PARTS):
            return []
        with self._parts() as folder:
            return sorted(name.removesuffix(".h5") for name in folder.names() if name.endswith(".h5"))

    def has(self, name: str) -> bool:
        """Whether a part is there."""
        if not os.path.lexists(self.folder / PARTS):
            return False
        with self._parts() as folder:
            return is_file(folder, f"{name}.h5")

    def read(self, name: str, table: Mapping[str, Array], origin: Mapping[str, str]) -> dict[str, NDArray]:
        """The arrays of a part, as a table of the gate tells.

        Raises
        ------
        DataError
            Damaged, forged, or not of this origin: a file is not believed by its name.
        """
        path = self.folder / PARTS / f"{name}.h5"
        with self._parts() as folder, _image(path, folder, LARGEST_PART) as (file, size):
            own = gate.attributes(file, dict.fromkeys(("format", *ORIGIN), ()), gate.LONGEST_TEXT)
            if any(own[word] != wanted for word, wanted in origin.items()):
                raise ValueError("it was computed of other cases, or by other versions, than its name says")
            gate.look_at(file, table, size)
            return {column: gate.read(file, column) for column in table}

    def write(self, name: str, rows: Mapping[str, NDArray], origin: Mapping[str, str]) -> None:
        """Add a part: its file takes its name when it is whole and on the disk."""
        with self._parts(make=True) as folder:
            _write(self.folder / PARTS / f"{name}.h5", folder, rows, origin, {})

    @contextmanager
    def _parts(self, make: bool = False) -> Iterator[Folder]:
        """The folder of the parts, open."""
        with entered(self.folder) as folder, inside(folder, PARTS, self.folder / PARTS, make) as parts:
            yield parts

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the store for this process alone, and remove what processes that died left half written; the lock dies with the
        process. A disk without locks has none."""
        path, problem = self.folder / LOCK, "cannot be used as a lock"
        with entered(self.folder, make=True) as folder:
            with Guard(path, problem):
                handle = folder.open(LOCK, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                with Guard(path, problem):
                    self._hold(handle)
                    clear_abandoned(folder)
                if os.path.lexists(self.folder / PARTS):
                    with inside(folder, PARTS, self.folder / PARTS) as parts, Guard(self.folder / PARTS, "cannot be used"):
                        clear_abandoned(parts)
                yield
            finally:
                os.close(handle)

    def _hold(self, handle: int) -> None:
        """Lock an open file, once it is seen to be the user's own and no other name's, and write into it who holds it."""
        status = os.fstat(handle)
        if (what := kind_of(status)) or status.st_nlink != 1 or not is_own(status):
            raise OSError(None, f"it {what or 'has another name or another owner'}")
        owner = os.read(handle, 200)
        if lock(handle) is False:
            raise DataError(self.folder, f"is being written by another sweep ({one_line(owner.decode(errors='replace'))})")
        if not (b"process ".startswith(owner) or _OWNER.fullmatch(owner)):
            raise OSError(None, "a file of another kind has this name")
        os.lseek(handle, 0, os.SEEK_SET)
        os.ftruncate(handle, 0)
        os.write(handle, f"process {os.getpid()} on {socket.gethostname()}".encode())


def _axes(scene: Scene, file: h5py.File, size: int) -> tuple[Axis, ...]:
    """The axes of a plan, whose keys are values of its scene."""
    names = sorted(gate.members(file, most=MOST_AXES))
    own = {name: gate.attributes(gate.dataset(file, name), {"key": (), "dim": ()}, gate.LONGEST_TEXT) for name in names}
    gate.look_at(file, {name: Array(_ENTRIES, (own[name]["dim"],)) for name in names}, size, most=MOST_AXES)
    axes = [axis_of(scene, own[name]["key"], own[name]["dim"], gate.read(file, name)) for name in names]
    if len({axis.key for axis in axes}) < len(axes) or not axes or prod(Cases(tuple(axes)).dims.values()) > LARGEST_COUNT:
        raise ValueError("its keys are not those of a sweep")
    return tuple(axes)


def axis_of(scene: Scene, key: str, dim: str, values: NDArray) -> Axis:
    """The axis of some stored values; what its key means the scene knows. ValueError for values that no axis has."""
    value, numbers = value_of(scene, key), values.dtype.kind != "S"
    if dim not in (key, *SHARED) or (numbers and not np.isfinite(values).all()):
        raise ValueError(f"{key} is no axis of a sweep")
    if dim in (key, ZIPPED) and len(np.unique(values)) < len(values):
        raise ValueError(f"{key} has the same value twice")
    values = values.astype(bool) if values.dtype == np.int8 else values
    listed = values.tolist() if numbers else [word.decode() for word in values.tolist()]
    return Axis(key, dim, tuple(listed), value.unit, value.meaning)


def _write(
    path: Path, folder: Folder, arrays: Mapping[str, NDArray], head: Mapping[str, Any], own: Mapping[str, Mapping[str, Any]]
) -> None:
    """Write arrays and attributes to a file in an open folder, whole or not at all. HDF5 works in memory: a full disk is an error
    of this call."""
    image = io.BytesIO()
    with h5py.File(image, "w", userblock_size=USER_BLOCK) as file:
        put(file.attrs, {"format": FORMAT, **head})
        for name, values in arrays.items():
            put(file.create_dataset(name, data=values).attrs, own.get(name, {}))
    content = image.getbuffer()[USER_BLOCK:]
    block = f"{FORMAT}\n{hashlib.sha256(content).hexdigest()}\n".encode().ljust(USER_BLOCK, b"\0")
    with Guard(path, "cannot be written"):
        write_whole(folder, path.name, [block, content])


@contextmanager
def _image(path: Path, folder: Folder, most: int) -> Iterator[tuple[h5py.File, int]]:
    """The HDF5 image of a file in an open folder, and its size, once its sum is right."""
    content = content_of(path, most, folder)
    lines = content[:USER_BLOCK].split(b"\n")
    if lines[0] != FORMAT.encode():
        raise DataError(path, f"is no file of a sweep of this version (this rsc reads {FORMAT!r})")
    if len(lines) < 2 or hashlib.sha256(memoryview(content)[USER_BLOCK:]).hexdigest().encode() != lines[1]:
        raise DataError(path, "is damaged (its checksum is another)")
    with Guard(path, "is no file that a sweep writes"), gate.image(content) as file:
        yield file, len(content)
