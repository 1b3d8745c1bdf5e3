"""Small files that unpack to far more than they are: read or refused within four times the memory that is told."""

import subprocess
import sys
from pathlib import Path

import pytest

import bomb_files
import rsc
from rsc.errors import DataError
from rsc.files import memory

ROOT = Path(__file__).parents[3]


@pytest.mark.posix
def test_a_sample_of_bombs_stays_within_four_times_the_cap():
    """`python tools/bombs.py` runs a thousand; here two of each format."""
    command = [sys.executable, str(ROOT / "tools/bombs.py"), "--count", "12"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "12 files, 0 failures" in done.stdout


@pytest.mark.parametrize("number", range(6), ids=bomb_files.FORMATS)
def test_what_does_not_fit_is_refused_before_it_is_read(number, tmp_path, monkeypatch):
    """With next to no memory every format is refused for it, or for what is wrong with it, in one line."""
    path, _ = bomb_files.write(number, tmp_path)
    monkeypatch.setattr(memory, "MOST", 1000)
    with pytest.raises(DataError) as error:
        rsc.read_measured(path)
    assert "\n" not in str(error.value)
