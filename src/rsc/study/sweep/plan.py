"""The parts of a sweep: their cases and names, and which of them a store holds."""

import hashlib
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import comb
from typing import Any

from rsc.analysis.several.search import MOST
from rsc.errors import DataError, SolverError, nearest, one_line
from rsc.files.output import refuse_name_of_file
from rsc.results.agreement import refuse_other_scene
from rsc.results.budget import COPIES, row_bytes
from rsc.results.sweep_store import PARTS, Cases, Plan, SweepStore
from rsc.scene.names import at_contacts
from rsc.scene.scene import Scene
from rsc.scene.values import value_of
from rsc.study.sweep.compute import KINDS, OF_ONE_CONTACT, Part, base_of, own_versions, scene_hash, scenes_of
from rsc.study.sweep.rows import Rows, table

LARGEST_PART, SMALLEST_PART = 128, 8  # cases: what comes before the steps of a run is done for many at once
FEWEST_PARTS = 8  # so that several workers have something to do
PART_BYTES = 256e6  # of the samples of the runs of a part
SIMULATING = ("run", "check")
Label = tuple[str, int]  # kind and number of a part


def make_plan(scene: Scene, cases: Cases, compute: str | Sequence[str]) -> Plan:
    """The plan of a sweep.

    Raises
    ------
    SolverError
        Something to compute that is none of `KINDS`, nothing, or what is not known at several contacts.
    """
    kinds = tuple(word.strip() for word in compute.split(",")) if isinstance(compute, str) else tuple(compute)
    for kind in kinds:
        if kind not in KINDS:
            raise SolverError(f"compute = {kind!r}: must be one or more of {', '.join(KINDS)} ({nearest(kind, KINDS)})")
    if not kinds or len(set(kinds)) < len(kinds):
        raise SolverError(f"compute = {compute!r}: must be different ones of {', '.join(KINDS)}")
    for kind in kinds:
        if kind in OF_ONE_CONTACT and len(scene.contacts) > 1:
            known = ", ".join(word for word in KINDS if word not in OF_ONE_CONTACT)
            raise SolverError(f"compute = {kind!r}: the scene has {len(scene.contacts)} contacts: must be one or more of {known}")
    sizes = tuple(_part_size(len(cases), bytes_of_a_run(scene, cases) if kind in SIMULATING else 0.0) for kind in kinds)
    return Plan(scene.to_toml(), scene.source, kinds, sizes, cases, own_versions())


def bytes_of_a_run(scene: Scene, cases: Cases) -> float:
    """Memory that the samples of the longest run of a sweep take."""
    largest = {"drive.duration": scene.drive.duration, "output.rate": scene.output.rate}
    for axis in cases.axes:
        if axis.key in largest:
            largest[axis.key] = max(axis.values)
    return COPIES * largest["drive.duration"] * largest["output.rate"] * row_bytes(scene)


def _part_size(count: int, bytes_each: float) -> int:
    """Cases in a part: the same on every machine, whatever memory it has, since parts are found again by their cases."""
    size = min(LARGEST_PART, max(SMALLEST_PART, math.ceil(count / FEWEST_PARTS / SMALLEST_PART) * SMALLEST_PART))
    return min(size, max(1, int(PART_BYTES / bytes_each))) if bytes_each else size


class labels(Sequence[Label]):
    """Kind and number of every part, in the order in which they are computed; none is kept in memory."""

    def __init__(self, plan: Plan) -> None:
        self._counts = {kind: -(-len(plan.cases) // size) for kind, size in zip(plan.kinds, plan.part_sizes, strict=True)}

    def __len__(self) -> int:
        return sum(self._counts.values())

    def __getitem__(self, place: Any) -> Any:
        for kind, count in self._counts.items():
            if place < count:
                return kind, place
            place -= count
        raise IndexError(place)

    def index(self, label: Any, *_: Any) -> int:
        kinds = list(self._counts)
        return sum(self._counts[kind] for kind in kinds[: kinds.index(label[0])]) + label[1]

    def __contains__(self, label: object) -> bool:
        return isinstance(label, tuple) and 0 <= label[1] < self._counts.get(label[0], 0)


def span(plan: Plan, label: Label) -> tuple[int, int]:
    """Range of the case numbers of a part: first, and last + 1."""
    kind, i = label
    size = plan.part_sizes[plan.kinds.index(kind)]
    return i * size, min((i + 1) * size, len(plan.cases))


def part_of(plan: Plan, label: Label) -> Part:
    """The cases of a part."""
    values = tuple(plan.cases.values(*span(plan, label)))
    return Part(label[0], plan.scene, plan.source, plan.cases.keys, values, plan.versions)


def origin_of(part: Part) -> dict[str, str]:
    """The origin stored in the file of a part: its cases and the versions that computed them."""
    content = repr((part.kind, part.scene, part.keys, part.values, part.versions))
    return {"kind": part.kind, "versions": part.versions, "cases": hashlib.sha256(content.encode()).hexdigest()}


def name_of(part: Part, i: int) -> str:
    """Name of a part in the store."""
    return f"{part.kind}-{i:06d}-{origin_of(part)['cases'][:16]}"


def write_rows(store: SweepStore, part: Part, i: int, rows: Rows) -> None:
    """Keep the rows of a part."""
    store.write(name_of(part, i), rows, origin_of(part))


def read_rows(store: SweepStore, part: Part, i: int) -> Rows:
    """The rows of a part from its file, which is not believed by its name: origin and number of cases must be those of the part,
    and the hash of the scene in the first, the last and a case between. DataError where they are not."""
    name, count = name_of(part, i), len(part.values)
    rows = store.read(name, table(part.kind, count), origin_of(part))
    if "frequency" in rows and rows["frequency"].shape[1] > most_whirls(part.scene, part.source):
        raise DataError(store.folder / PARTS / f"{name}.h5", f"holds {rows['frequency'].shape[1]} whirls of a case")
    for place in {0, count // 2, count - 1}:
        if rows["scene_hash"][place] != _hash_of(replace(part, values=(part.values[place],))):
            raise DataError(store.folder / PARTS / f"{name}.h5", f"case {place} of it was computed of another scene")
    return rows


def most_whirls(scene: str, source: str) -> int:
    """The most roots that Im[(1 + i mu) H] = 0 can have: every coordinate adds four to the degree of a polynomial. Of several
    contacts as many for each pressed set, more of which no system showed."""
    base = base_of(scene, source)
    sets = sum(comb(len(base.contacts), size) for size in range(1, MOST + 1))
    return 4 * sets * (base.rotor.n_coordinates + base.stator.n_coordinates)


def _hash_of(part: Part) -> bytes:
    """Hash of the scene of the only case of a part; empty where it cannot be."""
    (scene,) = scenes_of(part)
    return scene_hash(scene).encode() if isinstance(scene, Scene) else b""


def stored_plan(store: SweepStore) -> Plan:
    """The plan of a store; DataError if this version cannot compute it."""
    plan = store.plan()
    if not set(plan.kinds) <= set(KINDS) or len(set(plan.kinds)) < len(plan.kinds):
        raise DataError(store.folder, f"its plan asks for {one_line(','.join(plan.kinds))[:40]!r}")
    return plan


def held_labels(plan: Plan, store: SweepStore) -> list[Label]:
    """The parts of a plan present in a store, in the order of `labels`; their content is not checked.

    Parts that are not there cost no time, however many they are.
    """
    every, held = labels(plan), []
    for name in store.parts():
        kind, _, number = name.rpartition("-")[0].partition("-")
        label = (kind, int(number) if re.fullmatch(r"[0-9]{6,12}", number) else -1)
        if label in every and name == name_of(part_of(plan, label), label[1]):
            held.append(label)
    return sorted(held, key=lambda label: (plan.kinds.index(label[0]), label[1]))


def refuse_store(store: SweepStore, plan: Plan, resume: bool) -> None:
    """Refuse a folder that a plan cannot be computed into; nothing is made or changed.

    Raises
    ------
    DataError
        There is a store and it is not to be resumed, or none and it is; or other files stand there.
    SceneError, SolverError
        The store is of another scene, or was made by other versions.
    """
    path = store.folder
    if not store.exists:
        if resume:
            raise DataError(path, "holds no sweep to resume")
        refuse_name_of_file(path)
        if not store.holds_nothing:
            raise DataError(path, "cannot be used for a sweep: must be a new or an empty folder")
        return
    if not resume:
        raise DataError(path, "holds a sweep already: --resume (Python: resume=True) continues it or adds to it")
    earlier = stored_plan(store)
    if earlier.versions != plan.versions:
        made = f"{path}: was made with {earlier.versions}; this is {plan.versions}"
        raise SolverError(f"{made}: must be the same, for the same bits (use another folder)")
    keys = plan.cases.keys
    refuse_other_scene(path, _without(earlier.scene, keys), _without(plan.scene, keys, plan.source))


def write_plan(store: SweepStore, plan: Plan, note: Callable[[str], object]) -> None:
    """Write the plan into a store, unless it is that of the store."""
    earlier = stored_plan(store) if store.exists else None
    if earlier is not None and replace(earlier, source=plan.source) == plan:
        return
    if earlier is not None:
        held = f"{len(earlier.cases)} cases of {', '.join(earlier.kinds)}"
        note(f"{store.folder}: holds {held}; parts of the same cases are used again")
    store.write_plan(plan)


class _Content:
    """A scene as `refuse_other_scene` compares it, without the values that are varied."""

    def __init__(self, content: dict[str, Any], source: str) -> None:
        self._content, self.source = content, source

    def to_dict(self) -> dict[str, Any]:
        return self._content


def _without(text: str, keys: Sequence[str], source: str = "<scene>") -> _Content:
    scene = Scene.from_stored(text, source)
    content = scene.tables
    for key in keys:
        for name in at_contacts(scene, key):
            value = value_of(scene, name)
            content[value.table].pop(value.key, None)
    return _Content(content, source)


def missing(plan: Plan, store: SweepStore, note: Callable[[str], object]) -> list[Label]:
    """The parts of a plan that are missing or damaged in a store; damaged ones are reported by `note`."""
    stored = set(store.parts())
    parts = ((label, part_of(plan, label)) for label in labels(plan))
    return [
        label for label, part in parts
        if name_of(part, label[1]) not in stored or not is_whole(store, part, label[1], note)
    ]  # fmt: skip


def is_whole(store: SweepStore, part: Part, i: int, note: Callable[[str], object]) -> bool:
    """Whether a part that is there can be used; else note why it is computed again."""
    try:
        read_rows(store, part, i)
    except DataError as error:
        note(f"{error}; it is computed again")
        return False
    return True
