"""What stands under a name is replaced only if rsc wrote it and nobody changed it, and a file has its name when all of it is
written."""

import os

import pytest

from rsc.errors import DataError
from rsc.files import mark
from rsc.files.output import FOREIGN, OutputFile, folder, put, put_all, target
from rsc.operating_system import Folder

CONTENT = b"\x89PNG\r\n\x1a\n" + b"a picture" + b"\0\0\0\0IEND\xaeB`\x82"


def refusal(path, format=mark.PNG, overwrite=False):
    with pytest.raises(DataError) as caught:
        target(path, format, overwrite)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 700
    return str(caught.value)


def test_what_rsc_wrote_is_replaced_and_an_empty_file(tmp_path):
    (tmp_path / "a.png").write_bytes(b"")
    for content in (CONTENT, CONTENT.replace(b"a picture", b"another")):
        put(tmp_path / "a.png", content, mark.PNG)
        assert (tmp_path / "a.png").read_bytes() == mark.PNG.marked(content) and os.listdir(tmp_path) == ["a.png"]


@pytest.mark.parametrize("change", ["cut", "appended", "one bit", "another mark", "only the mark", "no mark"])
@pytest.mark.parametrize("format", [mark.PNG, mark.TOML, mark.CSV], ids=["PNG", "TOML", "CSV"])
def test_what_was_changed_since_is_left_alone_unless_forced(tmp_path, format, change):
    path = tmp_path / "a"
    put(path, CONTENT, format)
    whole = path.read_bytes()
    start, end = (len(whole), b"") if format is mark.CSV else (whole.index(mark._TOLD.encode()), whole[-format.behind or None :])
    other = mark.PNG.marked(b"x" * 40)[28:-12] if format is mark.PNG else b"# sha256 0"
    mine = {
        "cut": whole[: len(whole) // 3], "appended": whole + b" ", "one bit": whole[:9] + bytes([whole[9] ^ 1]) + whole[10:],
        "another mark": CONTENT[:-12] + other + CONTENT[-12:], "only the mark": whole[start:] or b" ", "no mark": CONTENT + end,
    }[change]  # fmt: skip
    path.write_bytes(mine)
    if format is mark.CSV and change == "no mark":  # as it was written, but its mark is gone
        (tmp_path / ".a.rsc").unlink()
    assert FOREIGN in refusal(path, format) and path.read_bytes() == mine
    with pytest.raises(DataError):
        put(path, CONTENT, format)
    assert path.read_bytes() == mine
    put(path, CONTENT, format, overwrite=True)
    assert path.read_bytes() == whole and target(path, format) == path


def test_a_file_of_one_format_is_not_replaced_by_another(tmp_path):
    put(tmp_path / "a", b"[table]\n", mark.TOML)
    for format in (mark.PNG, mark.HTML, mark.JSON, mark.GIF, mark.CSV, mark.HDF5, mark.ZIP):
        assert FOREIGN in refusal(tmp_path / "a", format)


def test_what_is_no_file_is_left_alone_even_if_forced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    put(tmp_path / "own", CONTENT, mark.PNG)
    (tmp_path / "link").symlink_to(tmp_path / "own")
    (tmp_path / "nowhere").symlink_to(tmp_path / "b")
    (tmp_path / "folder").mkdir()
    for name, reason in {"pipe": "pipe", "link": "link", "nowhere": "link", "folder": "directory"}.items():
        assert reason in refusal(tmp_path / name) and reason in refusal(tmp_path / name, overwrite=True)
    assert "device" in refusal("/dev/null", overwrite=True)
    for name in ("", ".", "/", "a\0b", "x" * 300):
        refusal(name, overwrite=True)
    assert "no such file or directory" in refusal(tmp_path / "missing" / "a.png")


def test_the_mark_beside_a_table_replaces_nothing_of_the_user(tmp_path):
    (tmp_path / ".a.csv.rsc").write_text("my notes")
    assert ".a.csv.rsc: cannot be written" in refusal(tmp_path / "a.csv", mark.CSV)
    with pytest.raises(DataError):
        put(tmp_path / "a.csv", b"x\n1\n", mark.CSV)
    assert sorted(os.listdir(tmp_path)) == [".a.csv.rsc"] and (tmp_path / ".a.csv.rsc").read_text() == "my notes"


def test_several_files_are_written_all_or_none(tmp_path, monkeypatch):
    (tmp_path / "b").write_text("mine")
    outputs = [OutputFile(tmp_path / name, b"new", mark.TOML) for name in "abc"]
    with pytest.raises(DataError, match=r"/b: cannot be written"):
        put_all(outputs)
    assert os.listdir(tmp_path) == ["b"]
    outputs[1] = OutputFile(tmp_path / "d", b"new", mark.TOML)
    begin, begun = Folder.begin, []

    def full_at_the_third(self, name):
        begun.append(name)
        return begin(self, name) if len(begun) < 3 else open("/dev/full", "wb", buffering=0)

    monkeypatch.setattr(Folder, "begin", full_at_the_third)
    with pytest.raises(DataError, match="no space left on device"):
        put_all(outputs)
    assert os.listdir(tmp_path) == ["b"]


def test_a_file_that_cannot_be_written_leaves_nothing_and_the_old_one(tmp_path, monkeypatch):
    put(tmp_path / "a.png", CONTENT, mark.PNG)
    before = (tmp_path / "a.png").read_bytes()

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(DataError, match="no space left on device"):
        put(tmp_path / "a.png", CONTENT + b"new", mark.PNG)
    assert os.listdir(tmp_path) == ["a.png"] and (tmp_path / "a.png").read_bytes() == before


def test_new_files_have_the_rights_that_the_user_gives(tmp_path):
    before = os.umask(0o027)
    try:
        put(tmp_path / "a.png", CONTENT, mark.PNG)
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


@pytest.mark.parametrize("name", ["map.png", "page.HTML", "run.h5"])
def test_no_folder_is_made_with_the_name_of_a_file(name, tmp_path):
    with pytest.raises(DataError, match="must be a folder"):
        folder(tmp_path / name)
    assert not (tmp_path / name).exists()
    (tmp_path / name).mkdir()
    assert folder(tmp_path / name).is_dir()  # the user's
