"""Command lines that cannot be right: exit code 2 (4 for a file), nothing written."""

import os

import pytest

from rsc.cli import main
from rsc.scene.templates import template

COMMANDS = {
    "C48 unknown option": (["run", "scene.toml", "--worker", "2"], 2, "--worker"),
    "C48 unknown command": (["runn", "scene.toml"], 2, "runn"),
    "C48 no number": (["predict", "scene.toml", "--speed", "fast"], 2, "fast"),
    "C48 no scene": (["run"], 2, "SCENE"),
    "C50 output is the input": (["run", "scene.toml", "-o", "scene.toml"], 2, "another file than the scene"),
    "C50 the same by another name": (["run", "scene.toml", "-o", "./x/../scene.toml"], 2, "another file than the scene"),
    "C57 nothing to resume": (["run", "scene.toml", "-o", "run.h5", "--resume"], 4, "does not exist"),
    "F8 folder that is not there": (["run", "scene.toml", "-o", "missing/run.h5"], 4, "cannot be written"),
    "F8 file is a folder": (["run", "scene.toml", "-o", "x"], 4, "is a directory"),
    "F8 folder is a file": (["check", "scene.toml", "-o", "scene.toml"], 4, "cannot be written"),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_bad_command_is_refused_and_nothing_written(name, tmp_path, monkeypatch, capsys):
    arguments, code, part = COMMANDS[name]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x").mkdir()
    (tmp_path / "scene.toml").write_text(template("laval"))
    try:
        assert main(arguments) == code
    except SystemExit as error:  # argparse
        assert error.code == code
    message = capsys.readouterr().err
    assert part in message and "Traceback" not in message
    assert sorted(os.listdir(tmp_path)) == ["scene.toml", "x"] and (tmp_path / "scene.toml").read_text() == template("laval")
