"""The files of a sweep: whole or not there, damage noticed, readable as netCDF."""

import fcntl
import hashlib
import os
from dataclasses import replace

import numpy as np
import pytest
import xarray

import rsc
from rsc.files.gate import F8, I1, I8, TEXT, Array
from rsc.results.labelled import Labelled, as_str, is_labelled, load_labelled
from rsc.results.sweep_store import Axis, Cases, Plan, SweepStore
from scenes import LAVAL

AXES = (
    Axis("contact.friction", "contact.friction", (0.1, 0.2), "1", "Coefficient of friction."),
    Axis("solver.method", "case", ("rk45", "taylor8", "rk45"), "", "How."),
    Axis("output.velocities", "case", (True, False, True), "", "What."),
    Axis("contact.gap", "case", (1e-3, 2e-3, 3e-3), "m", "Gap."),
)
SCENE = rsc.Scene.from_dict(LAVAL | {"title": "ä"})
PLAN = Plan(SCENE.to_toml(), "laval.toml", ("predict", "run"), (2, 1), Cases(AXES), "rsc 1")
ROWS = {
    "status": np.array([b"finished", b"lost"]),
    "force": np.array([1.0, np.nan]),
    "stable": np.array([[0, 1], [1, 0]], dtype="i1"),
}
TABLE = {"status": Array(TEXT, (2,)), "force": Array(F8, ("case",)), "stable": Array(I1, ("case", "whirl"))}
ORIGIN = {"kind": "predict", "versions": "rsc 1", "cases": "0" * 64}


def read(store, name):
    return store.read(name, TABLE, ORIGIN)


@pytest.fixture
def store(tmp_path):
    store = SweepStore(tmp_path / "store")
    store.write_plan(PLAN)
    store.write("predict-0", ROWS, ORIGIN)
    return store


def test_what_is_written_is_read(store):
    found = store.plan()
    assert replace(found, cases=PLAN.cases) == PLAN
    assert store.parts() == ["predict-0"] and store.has("predict-0") and not store.has("predict-1")
    told = [(axis.key, axis.dim, axis.values) for axis in found.cases.axes]
    assert told == [(axis.key, axis.dim, axis.values) for axis in AXES]
    assert found.cases.axes[3].unit == "m" and found.cases.axes[3].meaning  # as the scene knows them
    rows = read(store, "predict-0")
    assert {name: values.tobytes() for name, values in rows.items()} == {name: values.tobytes() for name, values in ROWS.items()}


def test_the_same_rows_make_the_same_file(store):
    store.write("predict-1", ROWS, ORIGIN)
    contents = {path.read_bytes() for path in (store.folder / "parts").iterdir()}
    assert len(contents) == 1


def test_another_plan_leaves_the_earlier_one_beside_it(store):
    store.write_plan(Plan(PLAN.scene, PLAN.source, ("run",), (4,), Cases(AXES[:1]), PLAN.versions))
    assert store.plan().kinds == ("run",) and len(list(store.folder.glob("plan-*.h5"))) == 1


@pytest.mark.parametrize("place", [0, 3, 20, 60, 511, 512, 700, -1])
def test_any_flipped_bit_is_noticed(store, place):
    path = store.folder / "parts" / "predict-0.h5"
    content = bytearray(path.read_bytes())
    content[place] ^= 4
    path.write_bytes(content)
    if place == 511:  # nothing stands there
        assert read(store, "predict-0")
        return
    with pytest.raises(rsc.DataError, match=r"is damaged|no file of a sweep"):
        read(store, "predict-0")


@pytest.mark.parametrize("size", [0, 1, 511, 600])
def test_a_shortened_file_is_noticed(store, size):
    path = store.folder / "parts" / "predict-0.h5"
    path.write_bytes(path.read_bytes()[:size])
    with pytest.raises(rsc.DataError, match=r"is damaged|no file of a sweep"):
        read(store, "predict-0")


def test_what_is_no_store_is_refused(tmp_path):
    with pytest.raises(rsc.DataError, match="is no store of a sweep"):
        SweepStore(tmp_path).plan()
    with pytest.raises(rsc.DataError, match="no such file"):
        read(SweepStore(tmp_path), "predict-0")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")
def test_a_full_disk_is_told_and_leaves_nothing(store, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(rsc.DataError, match=r"cannot be written .*No space left"):
        store.write("predict-1", ROWS, ORIGIN)
    assert os.listdir(store.folder / "parts") == ["predict-0.h5"]


def labelled():
    coordinates = {
        "contact.friction": (("contact.friction",), np.array([0.1, 0.2]), {"units": "1", "long_name": "friction"}),
        "contact.gap": (("case",), np.array([1e-3, 2e-3, 3e-3]), {"units": "m", "long_name": "gap"}),
    }
    dims = ("contact.friction", "case")
    variables = {
        "status": (dims, np.array([["finished", "lost", "ä"]] * 2), {"long_name": "status"}),
        "force": (dims, np.arange(6.0).reshape(2, 3), {"units": "N", "long_name": "force"}),
        "stable": ((*dims, "whirl"), np.eye(6, dtype=bool)[:, :4].reshape(2, 3, 4), {"long_name": "stable"}),
    }
    head = dict.fromkeys(("computed", "source", "scene", "versions", "axes"), "x")
    return Labelled({"contact.friction": 2, "case": 3, "whirl": 4}, coordinates, variables, {"title": "A title", **head})


DIMS = ("contact.friction", "case")
DATASET = {
    "contact.friction": Array(F8, DIMS[:1]), "contact.gap": Array(F8, DIMS[1:]), "case": Array(I8, DIMS[1:]),
    "whirl": Array(I8, ("whirl",)), "status": Array(TEXT, DIMS), "force": Array(F8, DIMS), "stable": Array(I1, (*DIMS, "whirl")),
}  # fmt: skip


def test_a_dataset_survives_its_file_and_is_one_for_xarray(tmp_path):
    data, path = labelled(), tmp_path / "sweep.nc"
    data.save(path)
    assert is_labelled(path) and os.listdir(tmp_path) == ["sweep.nc"]
    head, lengths, arrays = load_labelled(path, lambda head: DATASET)
    assert lengths == data.dims and head["title"] == "A title" and set(arrays) == set(DATASET)
    for name, (_, values, _) in {**data.coordinates, **data.variables}.items():
        assert as_str(arrays[name]).astype(values.dtype).tolist() == values.tolist()
    with xarray.open_dataset(path, engine="h5netcdf") as seen:
        assert seen.sizes == data.dims and seen.force.attrs["units"] == "N"
        assert seen.stable.dtype == bool and np.array_equal(seen.stable, data["stable"])
        assert seen.status.values.tolist() == data["status"].tolist()
        assert "contact.gap" in seen.coords and seen["contact.gap"].dims == ("case",)


def test_what_is_no_dataset_is_told(tmp_path):
    (tmp_path / "x.nc").write_bytes(b"nothing")
    assert not is_labelled(tmp_path / "x.nc") and not is_labelled(tmp_path / "none.nc") and not is_labelled(tmp_path)
    with pytest.raises(rsc.DataError, match="cannot be read"):
        load_labelled(tmp_path / "x.nc", lambda head: {})


def test_what_a_dead_process_left_half_written_is_removed_and_nothing_else(store):
    """A file that somebody still writes is held by his lock."""
    parts, names = store.folder / "parts", [f".rsc-{i:016x}.part" for i in range(5)]
    kept = [names[3], names[4], "notes.tmp", "predict-0.h5"]
    for folder in (store.folder, parts):
        for name in (*names[:3], "notes.tmp"):
            (folder / name).touch()
    (parts / names[3]).symlink_to(store.folder / "plan.h5")
    with open(parts / names[4], "w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        with store.locked():
            pass
        assert sorted(os.listdir(parts)) == kept
    assert sorted(os.listdir(store.folder)) == ["lock", "notes.tmp", "parts", "plan.h5"]


def linked(path, kind, precious):
    """In the place of a file something through which another would be changed, or that answers to nobody."""
    path.unlink(missing_ok=True)
    {
        "symbolic": lambda: path.symlink_to(precious), "hard": lambda: os.link(precious, path),
        "dangling": lambda: path.symlink_to("nowhere"), "pipe": lambda: os.mkfifo(path), "folder": path.mkdir,
        "device": lambda: path.symlink_to("/dev/zero"),
    }[kind]()  # fmt: skip


def test_a_lock_whose_owner_was_killed_while_it_wrote_is_taken(store):
    line = b"process 4711 on engine"
    for n in range(len(line) + 1):
        (store.folder / "lock").write_bytes(line[:n])
        with store.locked():
            pass
    (store.folder / "lock").write_bytes(b"process of welding")
    with pytest.raises(rsc.DataError, match="of another kind has this name"), store.locked():
        pass
    assert (store.folder / "lock").read_bytes() == b"process of welding"


@pytest.mark.parametrize("kind", ["symbolic", "hard", "dangling", "pipe", "folder", "device"])
@pytest.mark.parametrize("name", ["lock", "plan.h5", "plan-{0}.h5", "parts/predict-1.h5", "sweep.nc"])
def test_nothing_is_written_through_what_is_no_file_of_its_own(store, tmp_path, name, kind):
    """A name gets a new file, and keeps what it had, or everything is refused; what a link leads to is never changed."""
    digest = hashlib.sha256((store.folder / "plan.h5").read_bytes()).hexdigest()[:12]
    precious, path = tmp_path / "precious", store.folder / name.format(digest)
    precious.write_text("kept")
    linked(path, kind, precious)
    before = os.lstat(path)
    other = Plan(PLAN.scene, PLAN.source, ("run",), (4,), Cases(AXES[:1]), PLAN.versions)
    refusals = 0
    for action in (
        lambda: store.locked().__enter__(), lambda: store.write_plan(other), lambda: store.write("predict-1", ROWS, ORIGIN),
        lambda: labelled().save(store.folder / "sweep.nc"), store.plan, lambda: read(store, "predict-1"),
    ):  # fmt: skip
        try:
            action()
        except rsc.DataError as error:
            refusals += 1
            assert "\n" not in str(error)
    assert precious.read_text() == "kept" and not (tmp_path / "nowhere").exists() and not (store.folder / "nowhere").exists()
    assert refusals >= (kind != "hard" or name in ("lock", "sweep.nc"))
    if kind != "hard":
        assert os.lstat(path)[:3] == before[:3]  # it is still there
    assert not [entry for entry in os.listdir(store.folder) if entry.startswith(".rsc-")]


@pytest.mark.parametrize("name", ["", "parts"])
def test_a_folder_that_is_a_link_is_not_entered(tmp_path, name):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    store = SweepStore(tmp_path / "store")
    if name:
        store.write_plan(PLAN)
    (store.folder / name).symlink_to(elsewhere) if name else store.folder.symlink_to(elsewhere)
    with pytest.raises(rsc.DataError, match="it is a link"):
        store.write("predict-0", ROWS, ORIGIN) if name else store.write_plan(PLAN)
    assert os.listdir(elsewhere) == []


def test_private_names_cannot_be_guessed(store, monkeypatch):
    names, replaced = set(), os.replace

    def seen(source, *arguments, **options):
        names.add(source)
        replaced(source, *arguments, **options)

    monkeypatch.setattr(os, "replace", seen)
    for _ in range(20):
        store.write("predict-1", ROWS, ORIGIN)
    assert len(names) == 20 and all(len(name) > 20 for name in names)


@pytest.mark.parametrize("word", ["kind", "versions", "cases"])
def test_a_part_of_another_origin_is_not_used(store, word):
    with pytest.raises(rsc.DataError, match="than its name says"):
        store.read("predict-0", TABLE, ORIGIN | {word: "another"})
