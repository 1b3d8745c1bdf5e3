"""Whatever a name stands for, it is opened as a regular file below the cap or refused at once."""

import os

import pytest

from rsc.errors import DataError
from rsc.files.content import content_of, opened


def refusal(path, most=100):
    with pytest.raises(DataError) as caught, opened(path, most):
        pass
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_reads_a_file_at_the_cap_and_refuses_a_larger_one(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"x" * 100)
    with opened(path, 100) as file:
        assert file.read() == b"x" * 100
    assert "at most 0 MB" in refusal(path, 99)


def test_refuses_what_is_no_regular_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert "not a regular file" in refusal(tmp_path / "pipe")
    assert "not a regular file" in refusal("/dev/zero")
    assert "is a directory" in refusal(tmp_path)
    assert "no such file" in refusal(tmp_path / "nothing")
    assert "null" in refusal("a\0b")
    assert "no such file" in refusal("")


def test_no_more_is_read_than_the_cap_of_a_file_that_does_not_tell_its_size():
    assert os.path.getsize("/proc/self/smaps") == 0
    with pytest.raises(DataError, match="more than it tells"):
        content_of("/proc/self/smaps", 1000)
