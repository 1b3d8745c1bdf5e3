"""A result of every format that rsc has written: read, or refused by name. The files were written by the versions of their time.

They are kept compressed in tests/support/old_results; a new format adds one.
"""

import gzip
from pathlib import Path

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.results.result_format import FORMAT
from rsc.results.result_writer import ResultWriter
from rsc.simulation.run import versions
from rsc.study.run.start import run_of
from scenes import SCENES

KEPT = Path(__file__).parents[2] / "support" / "old_results"
NUMBERS = range(1, int(FORMAT.rpartition("-")[2]) + 1)


@pytest.fixture
def path(request, tmp_path):
    name = f"format_{request.param}.h5"
    (tmp_path / name).write_bytes(gzip.decompress((KEPT / f"{name}.gz").read_bytes()))
    return tmp_path / name


def test_there_is_a_file_of_every_format():
    assert sorted(file.name for file in KEPT.iterdir()) == [f"format_{number}.h5.gz" for number in NUMBERS]


@pytest.mark.versions
@pytest.mark.parametrize("path", NUMBERS[:-1], indirect=True)
def test_older_formats_are_refused_by_name(path, tmp_path, capsys):
    for command in (["info"], ["verify"], ["plot", "-o", str(tmp_path / "out")]):
        assert main([*command, str(path)]) == 4
        error = capsys.readouterr().err
        number = int(path.stem.rpartition("_")[2])
        named = f"'rsc-result-{number}'" if number > 3 else "an older one, rsc-result-1 to 3"
        assert f"its format is {named}, this rsc reads '{FORMAT}'" in error and error.count("\n") == 1


@pytest.mark.parametrize("path", NUMBERS[-1:], indirect=True)
def test_the_format_of_today_is_read_from_its_first_version_on(path, capsys):
    result = rsc.load(path)
    assert result.status == "finished" and len(result.time) == 51 and np.ptp(np.abs(result.rotor)) > 0.0
    assert main(["plot", str(path), "-o", str(path.parent / "out")]) == 0
    capsys.readouterr()
    code, error = main(["verify", str(path)]), capsys.readouterr().err
    assert code == 0 or (code == 4 and "different bits in" in error and "this is rsc" in error)


@pytest.mark.parametrize("path", NUMBERS, indirect=True)
def test_an_older_result_is_replaced_only_where_that_is_asked_for(path):
    """Nobody can tell whether a result that this version cannot read was changed since."""
    scene, before = rsc.Scene.from_dict(SCENES["bouncing"]), path.read_bytes()
    if path.stem.rpartition("_")[2] != str(NUMBERS[-1]):
        with pytest.raises(rsc.DataError, match="cannot be written"):
            rsc.simulate(scene, path=path)
        assert path.read_bytes() == before
    rsc.simulate(scene, path=path, overwrite=True)
    assert rsc.load(path).status == "finished"


def test_results_have_a_layout_that_older_readers_know(tmp_path):
    """That of HDF5 1.10, the first in which a file can be read while it is written."""
    run = run_of(rsc.Scene.from_dict(SCENES["bouncing"]))
    with ResultWriter(tmp_path / "run.h5", run.scene, versions()) as writer:
        writer.append(run.empty_block(), run.checkpoint())
        assert writer._file.libver == ("v110", "v110") and writer._file.swmr_mode
