"""The files of a sweep: whole or not there, damage noticed, readable as netCDF."""

import os
import socket
import subprocess

import numpy as np
import pytest
import xarray

import rsc
from rsc.results.labelled import Labelled, is_labelled, load_labelled
from rsc.results.sweep_store import Axis, Cases, Plan, SweepStore

AXES = (
    Axis("contact.friction", "contact.friction", (0.1, 0.2), "1", "Coefficient of friction."),
    Axis("solver.method", "case", ("rk45", "taylor8", "rk45"), "", "How."),
    Axis("contact.gap", "case", (1e-3, 2e-3, 3e-3), "m", "Gap."),
)
PLAN = Plan("title = \"ä\"\n", "laval.toml", ("predict", "run"), (2, 1), Cases(AXES), "rsc 1")
ROWS = {
    "status": np.array([b"finished", b"lost"]),
    "force": np.array([1.0, np.nan]),
    "stable": np.array([[0, 1], [1, 0]], dtype="i1"),
}


@pytest.fixture
def store(tmp_path):
    store = SweepStore(tmp_path / "store")
    store.write_plan(PLAN)
    store.write("predict-0", ROWS)
    return store


def test_what_is_written_is_read(store):
    assert store.plan() == PLAN and store.parts() == ["predict-0"] and store.has("predict-0") and not store.has("predict-1")
    read = store.read("predict-0")
    assert {name: values.tobytes() for name, values in read.items()} == {name: values.tobytes() for name, values in ROWS.items()}


def test_the_same_rows_make_the_same_file(store):
    store.write("predict-1", ROWS)
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
        assert store.read("predict-0")
        return
    with pytest.raises(rsc.DataError, match=r"is damaged|no file of a sweep"):
        store.read("predict-0")


@pytest.mark.parametrize("size", [0, 1, 511, 600])
def test_a_shortened_file_is_noticed(store, size):
    path = store.folder / "parts" / "predict-0.h5"
    path.write_bytes(path.read_bytes()[:size])
    with pytest.raises(rsc.DataError, match=r"is damaged|no file of a sweep"):
        store.read("predict-0")


def test_what_is_no_store_is_refused(tmp_path):
    with pytest.raises(rsc.DataError, match="is no store of a sweep"):
        SweepStore(tmp_path).plan()
    with pytest.raises(rsc.DataError, match="no such file"):
        SweepStore(tmp_path).read("predict-0")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")
def test_a_full_disk_is_told_and_leaves_nothing(store, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(rsc.DataError, match=r"cannot be written .*No space left"):
        store.write("predict-1", ROWS)
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
    return Labelled({"contact.friction": 2, "case": 3, "whirl": 4}, coordinates, variables, {"title": "A title"})


def test_a_dataset_survives_its_file_and_is_one_for_xarray(tmp_path):
    data, path = labelled(), tmp_path / "sweep.nc"
    data.save(path)
    assert is_labelled(path) and not list(tmp_path.glob("*.tmp"))
    read = load_labelled(path)
    assert read.dims == data.dims and read.attributes["title"] == "A title" and set(read.variables) == set(data.variables)
    assert read.to_xarray().identical(data.to_xarray())
    with xarray.open_dataset(path, engine="h5netcdf") as seen:
        assert seen.sizes == data.dims and seen.force.attrs["units"] == "N"
        assert seen.stable.dtype == bool and np.array_equal(seen.stable, data["stable"])
        assert seen.status.values.tolist() == data["status"].tolist()
        assert "contact.gap" in seen.coords and seen["contact.gap"].dims == ("case",)


def test_what_is_no_dataset_is_told(tmp_path):
    (tmp_path / "x.nc").write_bytes(b"nothing")
    assert not is_labelled(tmp_path / "x.nc") and not is_labelled(tmp_path / "none.nc") and not is_labelled(tmp_path)
    with pytest.raises(rsc.DataError, match="cannot be read"):
        load_labelled(tmp_path / "x.nc")


def test_what_a_dead_process_left_half_written_is_removed_and_nothing_else(tmp_path):
    (tmp_path / "parts").mkdir()
    with subprocess.Popen(["true"]) as process:
        pass
    host = socket.gethostname()
    kept = [f"b.h5.{host}-{os.getpid()}.tmp", f"c.h5.another-{process.pid}.tmp", "d.h5", "notes.tmp"]
    for name in [f"a.h5.{host}-{process.pid}.tmp", *kept]:
        (tmp_path / "parts" / name).touch()
    SweepStore(tmp_path).clear()
    assert sorted(os.listdir(tmp_path / "parts")) == kept
