"""Velocities in a result: the same in memory, in a file, resumed and verified; a file has them if and only if its scene asks."""

import itertools

import h5py
import numpy as np
import pytest

import forge
import rsc
from rsc.cli import main
from rsc.results.claims import part_of
from rsc.results.result_format import FORMAT
from rsc.results.result_writer import ResultWriter
from rsc.simulation.run import versions
from rsc.study.run.start import run_of
from rsc.study.run.verify import verify
from scenes import SCENES, changed

ASKING = changed(SCENES["chains"], output={"velocities": True})
ARRAYS = ("time", "rotor", "stator", "normal_force", "rotor_velocity", "stator_velocity")


def same(one, other):
    return all(getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in ARRAYS) and one.summary == other.summary


@pytest.fixture(scope="module")
def result():
    return rsc.simulate(rsc.Scene.from_dict(ASKING))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("velocities") / "run.h5"
    rsc.simulate(rsc.Scene.from_dict(ASKING), path=path)
    return path


@pytest.fixture
def path(written, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.h5").write_bytes(written.read_bytes())
    return tmp_path / "run.h5"


def test_a_file_has_the_velocities_of_the_run(result, path, tmp_path):
    assert result.rotor_velocity.shape == result.rotor.shape and result.stator_velocity.shape == result.stator.shape
    result.save(tmp_path / "saved.h5")
    for stored in (rsc.load(path), rsc.load(tmp_path / "saved.h5")):
        assert same(stored, result) and stored.scene.output.velocities
        with pytest.raises(ValueError, match="read-only"):
            stored.rotor_velocity[0] = 0.0
    assert verify(path).same and verify(path, 0).same and verify(tmp_path / "saved.h5").same


def test_other_programs_find_velocities_with_units(result, path):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        assert data.stator_velocity.dims == ("time", "stator_coordinate", "axis") and data.stator_velocity.units == "m s-1"
        assert np.array_equal(data.rotor_velocity[:, 2, 1], result.rotor_velocity[:, 2].imag)
    data = result.to_xarray()
    assert np.array_equal(data.rotor_velocity.values, result.rotor_velocity) and data.rotor_velocity.units == "m s-1"
    frame = result.table().to_dataframe()
    assert np.array_equal(frame["stator velocity 1 y in m s-1"], result.stator_velocity[:, 1].real)
    assert frame.shape[1] == 5 + 4 * (result.rotor.shape[1] + result.stator.shape[1])


def test_a_rigid_stator_has_no_velocities_to_store(tmp_path):
    scene = rsc.Scene.from_dict(changed(SCENES["rigid wall"], output={"velocities": True}))
    memory, stored = rsc.simulate(scene), rsc.simulate(scene, path=tmp_path / "run.h5")
    assert memory.stator_velocity.shape == stored.stator_velocity.shape == (memory.n_time, 0)
    assert np.array_equal(memory.rotor_velocity, stored.rotor_velocity) and verify(tmp_path / "run.h5").same


def test_a_killed_run_goes_on_with_its_velocities(result, tmp_path, monkeypatch):
    monkeypatch.setattr("rsc.simulation.run.CHUNK_STEPS", 400)
    scene, path = result.scene, tmp_path / "run.h5"
    run = run_of(scene)
    with ResultWriter(path, scene, versions()) as writer:
        writer.append(run.empty_block(), run.checkpoint())
        for block, _ in itertools.islice(run.chunks(), 3):
            writer.append(block, run.checkpoint())
        left = part_of(path).read_bytes()
    part_of(path).write_bytes(left)
    with pytest.raises(rsc.SceneError, match=r"output\.velocities = .*: must be True, as in the run to be resumed"):
        rsc.simulate(scene.with_values({"output.velocities": False}), path=path, resume=True)
    again = rsc.simulate(scene, path=path, resume=True)
    assert same(again, result) and verify(path).same


def without(*names):
    def change(file):
        kept = [name for name in ("time", "speed", "normal_force", "friction_force", "tangential_velocity", "rotor", "stator",
                                  "rotor_velocity", "stator_velocity") if name not in names]  # fmt: skip
        for name in names:
            del file[name]
        marks = file["blocks/checksums"][...]
        forge.as_written(file, "blocks/checksums", marks[:, : 1 + len(kept)])

    return change


def replaced(name, values):
    return lambda file: forge.as_written(file, name, values(file[name][...]))


def a_number(file):
    del file["checkpoint/x"]
    file["checkpoint/x"] = 1.0


def not_finite(file):
    file["stator_velocity"][3, 0, 1] = np.inf


def not_asked_for(file):
    text = file.attrs["scene"].decode()
    assert "velocities = true\n" in text
    forge.put(file.attrs, {"scene": text.replace("velocities = true\n", "")})


FORGED = {
    "one body's are missing": (without("stator_velocity"), "stator_velocity has 0 coordinates, in runs of the stored scene 2"),
    "all are missing": (without("rotor_velocity", "stator_velocity"), "has 0 coordinates, in runs of the stored scene"),
    "nobody asked for them": (not_asked_for, "rotor_velocity has 3 coordinates, in runs of the stored scene 0"),
    "of fewer coordinates": (replaced("rotor_velocity", lambda v: v[:, :2]), "rotor_velocity has another shape"),
    "without components": (replaced("rotor_velocity", lambda v: v[..., 0]), "rotor_velocity has another shape"),
    "a series for the displacements": (replaced("rotor", lambda v: v[:, 0, 0]), "rotor has another shape"),
    "a number for a state": (a_number, "x is no array that rsc writes"),
    "single precision": (replaced("stator_velocity", lambda v: v.astype("f4")), "stator_velocity is no array that rsc writes"),
    "fewer samples": (replaced("rotor_velocity", lambda v: v[:-5]), "rotor_velocity has another shape"),
    "not finite": (not_finite, "stator_velocity has a sample that is not finite"),
}


@pytest.mark.parametrize(("change", "problem"), [pytest.param(*row, id=name) for name, row in FORGED.items()])
def test_forged_velocities_are_refused(path, capsys, change, problem):
    with h5py.File(path, "r+", libver="latest") as file:
        change(file)
        forge.sum_up(file)
    with pytest.raises(rsc.DataError, match=problem) as caught:
        _ = rsc.load(path).rotor_velocity, rsc.load(path).stator_velocity
    assert "\n" not in str(caught.value)
    assert main(["verify", "run.h5"]) == 4
    error = capsys.readouterr().err
    assert error.startswith("error: ") and error.count("\n") == 1


@pytest.mark.parametrize("name", ["rotor_velocity", "stator_velocity"])
def test_other_velocities_than_the_run_gives_do_not_verify(path, name):
    with h5py.File(path, "r+", libver="latest") as file:
        file[name][100, 0, 0] *= 1.0 + 1e-15
        forge.sum_up(file)
    assert rsc.load(path).n_time and verify(path).differing == (name,)


def test_a_result_without_velocities_is_as_it_was_before_there_were_any(tmp_path):
    """Its scene has no key and its file no array that older versions would refuse."""
    scene = rsc.Scene.from_dict(changed(ASKING, output={"velocities": False}))
    rsc.simulate(scene, path=tmp_path / "run.h5")
    assert "velocities" not in scene.to_toml() and scene.to_dict()["output"] == {"rate": 2000.0}
    with h5py.File(tmp_path / "run.h5") as file:
        assert not any("velocit" in name for name in set(file) - {"tangential_velocity"})
        assert file["blocks/checksums"].shape[1] == 8 and file.attrs["format"] == FORMAT.encode()
