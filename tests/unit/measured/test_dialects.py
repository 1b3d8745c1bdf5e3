"""One run as many programs write it: read rightly, or refused in one line; never misread in silence."""

import re
from pathlib import Path

import numpy as np
import pytest

import dialect_files
import dialect_texts
import rsc
from dialects import DIALECTS, problem_of, written
from rsc.errors import RscError
from rsc.measured import formats

ROOT = Path(__file__).parents[3]

assert dialect_files and dialect_texts  # they register their dialects
READ = [name for name, one in DIALECTS.items() if not one.refused]


@pytest.mark.parametrize("name", DIALECTS)
def test_a_dialect_is_read_rightly_or_refused_for_what_is_wrong(name, tmp_path):
    path, wanted = written(tmp_path, name), DIALECTS[name]
    if wanted.refused:
        with pytest.raises(RscError) as error:
            rsc.read_measured(path)
        assert wanted.refused in str(error.value) and "\n" not in str(error.value) and len(str(error.value)) < 600
        return
    run = rsc.read_measured(path)
    assert problem_of(run) == ""
    assert wanted.told in " | ".join(run.warnings) if wanted.told else not run.warnings


def test_most_dialects_are_read_and_every_format_has_some():
    assert len(READ) >= 55
    known = {reader.name for reader in (formats.TEXT, *formats.READERS)}
    files = {ending: one.name for one in formats.READERS for ending in re.findall(r"\.([a-z]\w+)", one.endings)}
    seen = {files.get(DIALECTS[name].file.rpartition(".")[2], "text") for name in READ}
    assert seen == known


def test_a_run_that_is_misread_is_noticed(tmp_path):
    """The check of these tests: it tells channels that were exchanged, late, or in another unit."""
    path = written(tmp_path, "NumPy, vectors")
    good, text = (tmp_path / "run.npz").read_bytes(), path.read_text()
    assert problem_of(rsc.read_measured(path)) == ""
    path.write_text(text.replace('"1 um"', '"1.1 um"'))
    assert "whirl" in problem_of(rsc.read_measured(path))
    path.write_text(text.replace('"X"', '"?"').replace('"Y"', '"X"').replace('"?"', '"Y"'))
    assert "whirl" in problem_of(rsc.read_measured(path))
    path.write_text(text)
    arrays = dict(np.load(tmp_path / "run.npz"))
    np.savez(tmp_path / "run.npz", **(arrays | {"KPH": np.roll(arrays["KPH"], 20)}))
    assert "phase" in problem_of(rsc.read_measured(path))
    (tmp_path / "run.npz").write_bytes(good)


def test_the_documents_have_the_table_of_the_readers():
    """`python tools/measured_formats.py` writes it."""
    assert formats.table() in (ROOT / "docs/users/measured.md").read_text(encoding="utf-8")
