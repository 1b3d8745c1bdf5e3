"""What stands under a name is replaced only if it is of the same kind, and a file has its name when all of it is written."""

import os

import pytest

from rsc.errors import DataError
from rsc.files.output import PICTURES, folder, put, target

PNG = PICTURES[".png"]


def refusal(path, begins=PNG):
    with pytest.raises(DataError) as caught:
        target(path, begins)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_file_of_the_same_kind_is_replaced_and_an_empty_one(tmp_path):
    for before in (None, b"", PNG + b"old"):
        if before is not None:
            (tmp_path / "a.png").write_bytes(before)
        put(tmp_path / "a.png", PNG + b"new", PNG)
        assert (tmp_path / "a.png").read_bytes() == PNG + b"new" and os.listdir(tmp_path) == ["a.png"]


def test_what_is_something_else_is_left_alone(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(tmp_path / "a")
    (tmp_path / "text").write_text("a letter")
    (tmp_path / "folder").mkdir()
    for name, reason in {"pipe": "pipe", "link": "link", "text": "another kind", "folder": "directory"}.items():
        assert reason in refusal(tmp_path / name)
    assert "device" in refusal("/dev/null")
    for name in ("", ".", "/", "a\0b", "x" * 300):
        refusal(name)
    assert (tmp_path / "text").read_text() == "a letter" and sorted(os.listdir(tmp_path)) == ["folder", "link", "pipe", "text"]


def test_a_file_that_cannot_be_written_leaves_nothing_and_the_old_one(tmp_path, monkeypatch):
    (tmp_path / "a.png").write_bytes(PNG)

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(DataError, match="no space left on device"):
        put(tmp_path / "a.png", PNG + b"new", PNG)
    assert os.listdir(tmp_path) == ["a.png"] and (tmp_path / "a.png").read_bytes() == PNG


def test_new_files_have_the_rights_that_the_user_gives(tmp_path):
    before = os.umask(0o027)
    try:
        put(tmp_path / "a.png", PNG, PNG)
    finally:
        os.umask(before)
    assert os.stat(tmp_path / "a.png").st_mode & 0o777 == 0o640


def test_a_folder_is_proved_writable_without_touching_what_is_in_it(tmp_path):
    (tmp_path / ".rsc-probe").write_text("mine")
    assert folder(tmp_path / "a" / "b").is_dir() and folder(tmp_path) == tmp_path
    assert sorted(os.listdir(tmp_path)) == [".rsc-probe", "a"]
    for name in ("", "a\0b", "/dev/null", tmp_path / ".rsc-probe"):
        with pytest.raises(DataError):
            folder(name)
