"""Progress: one line that is written over on a terminal, nothing on a pipe, and nothing at all with --quiet."""

import os
import re
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

import rsc
from rsc.cli import progress
from rsc.cli.streams import Plain
from scenes import SCENES, changed


class Terminal:
    """A stream that looks like a terminal and keeps what is written."""

    encoding = "utf-8"

    def __init__(self):
        self.text = ""

    def isatty(self):
        return True

    def write(self, text):
        self.text += text
        return len(text)

    def flush(self):
        pass


@pytest.fixture
def terminal(monkeypatch):
    shown = Terminal()
    monkeypatch.setattr(progress, "sys", SimpleNamespace(stderr=Plain(shown, "\n\t\r")))
    monkeypatch.setenv("COLUMNS", "60")
    return shown


def test_the_line_has_stage_share_and_estimate_and_is_gone_in_the_end(terminal, monkeypatch):
    moments = iter([100.0, 103.0, 104.0])
    monkeypatch.setattr(progress, "EVERY", 100.0)
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(moments))
    with progress.shown_runs() as note:
        note(1, 4)
        note(2, 4)
    states = terminal.text.split("\r")
    assert states[1].strip() == "rsc: simulation 25 % (3 s, 9 s left): 1 of 4 runs"
    assert states[2].strip() == "rsc: simulation 50 % (4 s, 4 s left): 2 of 4 runs"
    assert "\n" not in terminal.text and states[-2].isspace() and not states[-1]
    assert max(map(len, states)) < 60


def test_the_line_lives_while_nothing_is_told(terminal, monkeypatch):
    monkeypatch.setattr(progress, "EVERY", 0.02)
    with progress.signs_of_life("analysis"):
        time.sleep(0.2)
    assert terminal.text.count("rsc: analysis (0 s)") >= 3 and "x1b" not in terminal.text


def test_a_note_stays(terminal):
    with progress.signs_of_life() as told:
        told("roots")
        progress.note("the disk has no locks")
    assert re.search(r"\r {59}\rrsc: the disk has no locks\n", terminal.text)


def test_on_a_pipe_there_are_notes_and_no_progress(capsys, monkeypatch):
    monkeypatch.setattr(progress, "EVERY", 0.01)
    with progress.shown_runs() as count, progress.signs_of_life() as told:
        count(1, 2)
        told("half")
        progress.note("a note")
        time.sleep(0.05)
    assert capsys.readouterr().err == "rsc: a note\n"


@pytest.mark.posix
@pytest.mark.parametrize("quiet", [[], ["--quiet"]])
def test_a_command_on_a_terminal(quiet, tmp_path):
    scene = changed(SCENES["rigid wall"], drive={"duration": 0.01})
    (tmp_path / "scene.toml").write_text(rsc.Scene.from_dict(scene).to_toml())
    import termios  # not on Windows

    ours, theirs = os.openpty()
    termios.tcsetwinsize(theirs, (24, 100))
    command = [sys.executable, "-m", "rsc", "run", "scene.toml", *quiet]
    done = subprocess.run(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=theirs, check=True)
    os.write(theirs, b"end")
    told = os.read(ours, 100_000).decode().removesuffix("end")
    os.close(theirs)
    os.close(ours)
    assert b"written: scene.h5" in done.stdout
    assert (told == "") if quiet else re.search(r"\rrsc: simulation \d+ % \(", told)
