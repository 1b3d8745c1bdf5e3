"""bench/import_remarks.py: a few of its imports, and a remark that is wrong is found."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "bench"))

import import_remarks
from rsc.cli import main
from rsc.study import import_model


@pytest.mark.parametrize("number", range(4))
def test_no_remark_contradicts_the_modes(number, tmp_path, capsys):
    arguments, _ = import_remarks.drawn(number, tmp_path)
    assert main(["import", "fe", *arguments, "-o", str(tmp_path / "m.toml")]) == 0
    assert import_remarks.contradictions(capsys.readouterr().out, tmp_path) == []


def test_wrong_remarks_are_found(tmp_path, capsys, monkeypatch):
    """The slowest modes left out, another frequency, no effect of the speed where there is one, nothing damped."""
    monkeypatch.setattr(import_model, "_slowest_of", lambda model, whole=import_model._slowest_of: whole(model)[2:])
    arguments, _ = import_remarks.drawn(0, tmp_path)
    assert main(["import", "fe", *arguments, "-o", str(tmp_path / "m.toml")]) == 0
    told = capsys.readouterr().out
    assert any("is left out" in one for one in import_remarks.contradictions(told, tmp_path))
    wrong = told.replace("full model: ", "full model: 3.123 Hz (undamped), ") + "nothing depends on the rotor speed."
    found = " ".join(import_remarks.contradictions(wrong, tmp_path))
    assert "no mode is at 3.123 Hz" in found and "the rotor speed has an effect" in found
