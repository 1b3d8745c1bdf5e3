"""Command lines that cannot be right: exit code 2 (4 for a file), nothing written."""

import os

import h5py
import pytest

from rsc.cli import main
from rsc.scene.files.templates import template

COMMANDS = {
    "C48 unknown option": (["run", "scene.toml", "--worker", "2"], 2, "--worker"),
    "C48 unknown command": (["runn", "scene.toml"], 2, "runn"),
    "C48 no number": (["predict", "scene.toml", "--speed", "fast"], 2, "fast"),
    "C48 another unit for an impulse": (["impact", "scene.toml", "--largest", "3 mm"], 2, "N s"),
    "C48 another unit for random impulses": (["motions", "scene.toml", "--largest", "3 Ns/m"], 2, "N s"),
    "C48 no scene": (["run"], 2, "SCENE"),
    "C50 output is the input": (["run", "scene.toml", "-o", "scene.toml"], 2, "another file than"),
    "C50 the same by another name": (["run", "scene.toml", "-o", "./x/../scene.toml"], 2, "another file than"),
    "C57 nothing to resume": (["run", "scene.toml", "-o", "run.h5", "--resume"], 4, "does not exist"),
    "F8 folder that is not there": (["run", "scene.toml", "-o", "missing/run.h5"], 4, "cannot be written"),
    "F8 file is a folder": (["run", "scene.toml", "-o", "x"], 4, "is a directory"),
    "F8 folder is a file": (["check", "scene.toml", "-o", "scene.toml"], 4, "cannot be written"),
    "F8 folder without a name": (["check", "scene.toml", "-o", ""], 4, "not the name of a folder"),
    "F8 this folder": (["run", "scene.toml", "-o", "."], 4, "not the name of a file"),
    "F8 the root folder": (["run", "scene.toml", "-o", "/"], 4, "not the name of a file"),
    "F8 no name": (["run", "scene.toml", "-o", ""], 4, "not the name of a file"),
    "F8 a name too long": (["run", "scene.toml", "-o", "x" * 300], 4, "name too long"),
    "F8 a name too long while it is written": (["run", "scene.toml", "-o", "x" * 254], 4, "name too long"),
    "F8 zero byte in a name": (["run", "scene.toml", "-o", "a\0b"], 4, "null"),
    "F8 zero byte in a folder": (["check", "scene.toml", "-o", "a\0b"], 4, "null"),
    "F8 device": (["run", "scene.toml", "-o", "/dev/null"], 4, "is a device"),
    "F8 picture on a device": (["predict", "scene.toml", "-o", "/dev/null"], 4, "must end with"),
    "E70 link to a result that is not there": (["run", "scene.toml", "-o", "link.h5"], 4, "is a link"),
    "E70 link to a device as a picture": (["predict", "scene.toml", "-o", "link.png"], 4, "is a link"),
    "C48 picture of a table": (["predict", "scene.toml", "--speed", "50", "-o", "map.png"], 2, "cannot be combined with --speed"),
    "F8 pipe": (["run", "scene.toml", "-o", "pipe"], 4, "is a pipe"),
    "F8 file of another kind": (["run", "scene.toml", "-o", "notes"], 4, "did not write"),
    "F8 HDF5 file of another program": (["run", "scene.toml", "-o", "model.mat"], 4, "did not write"),
    "B34 scene is a pipe": (["run", "pipe"], 2, "not a regular file"),
    "B34 scene is an endless device": (["run", "/dev/zero"], 2, "not a regular file"),
    "B34 scene is standard input": (["run", "-"], 2, "no such file"),
    "B34 result is a pipe": (["info", "pipe"], 4, "not a regular file"),
    "B33 scene without a name": (["predict", ""], 2, "is a directory"),
}


def contents(folder):
    return {path.name: path.read_bytes() if path.is_file() else os.lstat(path).st_ino for path in folder.iterdir()}


@pytest.mark.posix
@pytest.mark.parametrize("name", COMMANDS)
def test_a_bad_command_is_refused_and_nothing_written(name, tmp_path, monkeypatch, capsys):
    arguments, code, part = COMMANDS[name]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x").mkdir()
    (tmp_path / "scene.toml").write_text(template("laval"))
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "notes").write_text("my notes")
    (tmp_path / "link.h5").symlink_to("/dev/null")
    (tmp_path / "link.png").symlink_to("/dev/null")
    with h5py.File(tmp_path / "model.mat", "w") as file:
        file["K"] = [[1.0]]
    before = contents(tmp_path)
    try:
        assert main(arguments) == code
    except SystemExit as error:  # argparse
        assert error.code == code
    message = capsys.readouterr().err
    assert part in message and "Traceback" not in message
    assert contents(tmp_path) == before
    assert os.stat("/dev/null").st_rdev == os.makedev(1, 3)
