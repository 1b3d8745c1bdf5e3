"""A run in its file: nothing lost, units told, damage refused."""

import h5py
import numpy as np
import pytest

from rsc import DataError, Scene, load, simulate
from rsc.results import structure
from scenes import SCENES, changed


@pytest.fixture(scope="module")
def result():
    return simulate(Scene.from_dict(SCENES["chains"]))


def test_saved_and_loaded_runs_are_the_same(result, tmp_path):
    result.save(tmp_path / "run.h5")
    again = load(tmp_path / "run.h5")
    assert again.summary == result.summary
    assert again.scene == result.scene
    for name in ("time", "speed", "rotor", "stator", "normal_force", "friction_force", "tangential_velocity"):
        assert np.array_equal(getattr(again, name), getattr(result, name)), name
    assert np.array_equal(again.contact_rotor(), result.rotor[:, 1])
    assert np.array_equal(again.contact_stator(), result.stator[:, 1])
    assert not list(tmp_path.glob("*.part"))


def test_the_stored_scene_gives_the_same_bits(result, tmp_path):
    result.save(tmp_path / "run.h5")
    again = simulate(load(tmp_path / "run.h5").scene)
    assert np.array_equal(again.rotor, result.rotor)


def test_file_opens_in_xarray_with_units(result, tmp_path):
    xarray = pytest.importorskip("xarray")
    result.save(tmp_path / "run.h5")
    with xarray.open_dataset(tmp_path / "run.h5", engine="h5netcdf") as data:
        assert data.rotor.dims == ("time", "rotor_coordinate", "axis")
        assert (data.rotor.units, data.speed.units, data.normal_force.units) == ("m", "Hz", "N")
        assert np.array_equal(data.rotor[:, 2, 1], result.rotor[:, 2].imag)
        assert np.array_equal(data.time, result.time)


def test_to_xarray_has_complex_displacements_and_units(result):
    pytest.importorskip("xarray")
    data = result.to_xarray()
    assert np.array_equal(data.rotor.values, result.rotor)
    assert data.rotor.units == "m" and data.time.units == "s"


def test_rigid_stator_has_no_columns(tmp_path):
    rigid = simulate(Scene.from_dict(SCENES["rigid wall"]), path=tmp_path / "run.h5")
    assert rigid.stator.shape == (len(rigid.time), 0)
    assert not rigid.contact_stator().any()


def test_a_file_that_is_kept_open_is_looked_at_once(result, tmp_path, monkeypatch):
    result.save(tmp_path / "run.h5")
    loaded, looks = load(tmp_path / "run.h5"), []
    monkeypatch.setattr(structure, "refuse_other_structure", lambda *_: looks.append(1))
    with loaded.kept_open():
        with loaded.kept_open():
            assert len(loaded.time) == loaded.n_time
        assert np.array_equal(loaded.contact_rotor(), result.contact_rotor()) and len(looks) == 1
    assert loaded.n_time == result.n_time and len(looks) == 2
    with result.kept_open():
        assert result.n_time == loaded.n_time


def test_samples_are_uniform_and_end_with_the_run():
    run = simulate(Scene.from_dict(changed(drive={"speed": [50.0, 60.0], "duration": 0.1003}, output={"rate": 1000.0})))
    assert np.array_equal(run.time, np.arange(101) / 1000.0)
    assert run.speed[0] == 50.0 and run.speed[-1] == pytest.approx(50.0 + 10.0 * 0.1 / 0.1003)


@pytest.mark.parametrize("damage", ["missing", "folder", "empty", "text", "half", "other"])
def test_damaged_files_are_refused_in_one_line(result, tmp_path, damage):
    path = tmp_path / "run.h5"
    result.save(path)
    content = path.read_bytes()
    if damage == "other":
        with h5py.File(path, "w") as file:
            file["x"] = 1.0
    elif damage in ("missing", "folder"):
        path.unlink()
        if damage == "folder":
            path.mkdir()
    else:
        path.write_bytes({"empty": b"", "text": b"not a result", "half": content[: len(content) // 2]}[damage])
    with pytest.raises(DataError) as caught:
        load(path)
    assert "\n" not in str(caught.value) and "run.h5" in str(caught.value)


def test_unwritable_target_is_refused_before_computing(tmp_path, monkeypatch):

    monkeypatch.setattr("rsc.simulation.run.march", None)
    with pytest.raises(DataError, match="cannot be written"):
        simulate(Scene.from_dict(SCENES["bouncing"]), path=tmp_path / "no" / "such" / "folder" / "run.h5")
