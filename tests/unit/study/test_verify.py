"""`rsc verify`: a slice run again has the same bits, and a changed sample is found."""

import h5py
import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.study.verify import verify
from systems import reference_scene


@pytest.fixture
def path(tmp_path):
    scene = reference_scene("bouncing").with_values({"drive.duration": 60.0})
    rsc.simulate(scene, path=tmp_path / "run.h5")
    return tmp_path / "run.h5"


def test_every_block_verifies(path, capsys):
    rows = 0
    index = 0
    while True:
        try:
            found = verify(path, index)
        except rsc.DataError as error:
            assert "blocks with checkpoints" in str(error)
            break
        assert found.same and found.first == rows
        rows, index = found.last, index + 1
    assert rows == len(rsc.load(path).time) and index > 2
    assert main(["verify", str(path)]) == 0
    assert "the same bits" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["rotor", "normal_force", "time"])
def test_a_changed_sample_is_found(path, name, capsys):
    with h5py.File(path, "r+") as file:
        values = file[name]
        values[-5] = np.nextafter(values[-5], 1.0)
    assert verify(path).differing == (name,)
    assert main(["verify", str(path)]) == 3
    assert name in capsys.readouterr().out


def test_a_result_saved_from_memory_has_no_checkpoints(path):
    rsc.load(path).save(path.with_name("saved.h5"))
    with pytest.raises(rsc.DataError, match="holds 0 blocks"):
        verify(path.with_name("saved.h5"))
