"""`rsc verify` makes a run again, whole or a block of it: the same bits, or what differs is named and the file refused."""

import re

import h5py
import numpy as np
import pytest

import forge
import rsc
from rsc.cli import main
from rsc.results.result_format import put
from rsc.study.run.verify import verify
from scenes import SCENES
from systems import reference_scene


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("verify") / "run.h5"
    rsc.simulate(reference_scene("bouncing").with_values({"drive.duration": 60.0}), path=path)
    return path


@pytest.fixture
def path(result, tmp_path):
    (tmp_path / "run.h5").write_bytes(result.read_bytes())
    return tmp_path / "run.h5"


@pytest.fixture
def forged(path):
    """A function that changes the file with another one and writes every checksum anew."""

    def change(what):
        with h5py.File(path, "r+") as file:
            what(file)
            forge.sum_up(file)
        return path

    return change


def refused(path, capsys, *options):
    """What `rsc verify` says of a file that is not what its scene gives; its exit code is that of a bad file."""
    assert main(["verify", str(path), *options]) == 4
    error = capsys.readouterr().err
    assert error.startswith(f"error: {path}: ") and error.count("\n") == 1
    return error


def test_every_block_verifies(path, capsys):
    rows = index = 0
    while True:
        try:
            found = verify(path, index)
        except rsc.DataError as error:
            assert "blocks with checkpoints" in str(error)
            break
        assert found.same and found.first == rows and not found.whole
        rows, index = found.last, index + 1
    assert rows == len(rsc.load(path).time) and index > 2
    assert main(["verify", str(path), "--block", "-1"]) == 0
    assert "identical bits; the rest of the result was not checked" in capsys.readouterr().out


def test_the_whole_run_is_made_again_by_default(path, capsys):
    found, rows = verify(path), len(rsc.load(path).time)
    assert found.same and found.whole and (found.first, found.last) == (0, rows)
    assert main(["verify", str(path)]) == 0
    assert f"rows 0 to {rows - 1} repeated: identical bits; checkpoints, counters and energies" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["rotor", "normal_force", "time"])
@pytest.mark.parametrize("row", [5, -5])
def test_a_changed_sample_is_found(path, name, row, capsys):
    with h5py.File(path, "r+") as file:
        values = file[name]
        values[row] = np.nextafter(values[row], 1.0)
    assert verify(path).differing == (name,)
    assert verify(path, 0 if row > 0 else -1).differing == (name,)
    assert f"different bits in {name}" in refused(path, capsys)


@pytest.mark.parametrize("name", ["steps", "switches", "contact_time", "ledger", "advice", "rtol"])
def test_a_changed_summary_is_found(forged, name, capsys):
    def change(file):
        value = file.attrs[name]
        if name == "ledger":
            value[3] *= 1.0 + 1e-12
        put(file.attrs, {name: value if name == "ledger" else "all is well" if name == "advice" else value + value // 50})

    if name in ("contact_time", "rtol"):
        forged(lambda file: file.attrs.modify(name, np.nextafter(file.attrs[name], 0.0)))
    else:
        forged(change)
    assert f"different bits in {name}" in refused(forged(lambda file: None), capsys)


def test_a_changed_checkpoint_is_found(forged, capsys):
    def change(file):
        file["checkpoint/v"][1] *= 1.0 + 1e-12

    assert "different bits in checkpoints" in refused(forged(change), capsys)


def test_a_start_of_its_own_is_found(forged, capsys):
    """A first checkpoint that does not stand at the scene's start would pass for the first block that is run from it."""

    def change(file):
        file["checkpoint/x"][0] = 1e-9

    assert "no row repeated: different bits in checkpoints" in refused(forged(change), capsys)


def test_no_more_is_run_than_up_to_the_first_difference(path):
    with h5py.File(path, "r+") as file:
        file["rotor"][5] = 0.0
    assert verify(path).last < len(rsc.load(path.with_name("run.h5")).time) / 2


def test_a_result_saved_from_memory_has_no_blocks_and_is_run_again_as_a_whole(path):
    rsc.load(path).save(path.with_name("saved.h5"))
    with pytest.raises(rsc.DataError, match="holds 0 blocks"):
        verify(path.with_name("saved.h5"), 0)
    assert verify(path.with_name("saved.h5")).same


@pytest.mark.parametrize("values", [{"solver.max_steps": 300}, {"drive.duration": 1e-9}])
def test_runs_that_stop_early_verify(tmp_path, values):
    rsc.simulate(rsc.Scene.from_dict(SCENES["bouncing"]).with_values(values), path=tmp_path / "run.h5")
    assert verify(tmp_path / "run.h5").same


def test_ensembles_verify(tmp_path):
    scene = rsc.Scene.from_dict(SCENES["bouncing"])
    for i, run in enumerate(rsc.simulate_many([scene, scene.with_values({"contact.friction": 0.25})])):
        run.save(tmp_path / f"{i}.h5")
        assert verify(tmp_path / f"{i}.h5").same


def test_a_method_that_is_gone_cannot_be_run_again(forged):
    def change(file):
        text, changed = re.subn('method = ".*"', 'method = "verner76"', file.attrs["scene"].decode())
        assert changed == 1
        put(file.attrs, {"scene": text})

    with pytest.raises(rsc.DataError, match="verner76, a method that is gone"):
        verify(forged(change))
