"""Signals, other versions, disks without locks, caches that are damaged: what a run and its caller are told."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.results.result_writer import ResultWriter
from rsc.simulation.run import versions
from scenes import SCENES, changed

SHORT = rsc.Scene.from_dict(SCENES["bouncing"])
LONG = rsc.Scene.from_dict(changed(SCENES["bouncing"], drive={"duration": 1000.0}, contact={"friction": 0.0}))
LOOP = """
import rsc
scene = rsc.load_scene("long.toml")
for i in range(3):
    rsc.simulate(scene, path=f"{i}.h5")
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def signals(monkeypatch):
    """Sends this process a signal when its next run has handed over so many blocks, and puts the handlers back in the end."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    append, pending = ResultWriter.append, []

    def sending(writer, *parts):
        append(writer, *parts)
        if pending and (number := pending.pop()):
            signal.raise_signal(number)

    monkeypatch.setattr(ResultWriter, "append", sending)

    def send(number, blocks=3):
        pending[:] = [number, *[None] * (blocks - 1)]

    yield send
    for number, handler in before.items():
        signal.signal(number, handler)


def same(a, b):
    return np.array_equal(a.rotor, b.rotor) and np.array_equal(a.normal_force, b.normal_force)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_script_that_loops_over_runs_ends_with_the_signal(folder, number):
    """F4 and F5: the run at work is saved, the next ones do not begin, and who sent the signal sees it obeyed."""
    (folder / "long.toml").write_text(LONG.to_toml())
    process = subprocess.Popen([sys.executable, "-c", LOOP], stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60.0
    part = folder / "0.h5.part"
    while process.poll() is None and not (part.exists() and part.stat().st_size > 100_000):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    process.send_signal(number)
    _, errors = process.communicate(timeout=20.0)
    assert process.returncode == -number and ("KeyboardInterrupt: interrupted at" in errors) == (number == signal.SIGINT)
    assert sorted(os.listdir(folder)) == ["0.h5", "long.toml"]
    left = rsc.load("0.h5")
    assert left.status == "interrupted" and len(left.time) > 1000


def test_a_handler_of_the_caller_is_called_once_the_run_is_saved(folder, signals):
    seen = []
    signal.signal(signal.SIGTERM, lambda number, frame: seen.append((number, sorted(os.listdir(folder)))))
    signals(signal.SIGTERM)
    assert rsc.simulate(LONG, path="run.h5").status == "interrupted"
    assert seen == [(signal.SIGTERM, ["run.h5"])]


def test_what_the_caller_ignores_is_ignored(signals):
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signals(signal.SIGINT)
    assert rsc.simulate(LONG.with_values({"drive.duration": 60.0}), path="run.h5").status == "finished"


def test_a_second_ctrl_c_acts_at_once_and_what_was_written_goes_on(signals, monkeypatch):
    """F4: it falls where the first one is being answered, before the result has its name."""
    finish = ResultWriter.finish

    def late(writer, *parts):
        signal.raise_signal(signal.SIGINT)
        finish(writer, *parts)

    scene = LONG.with_values({"drive.duration": 100.0})
    whole = rsc.simulate(scene)
    monkeypatch.setattr(ResultWriter, "finish", late)
    signals(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt) as caught:
        rsc.simulate(scene, path="run.h5")
    assert not hasattr(caught.value, "result") and os.listdir() == ["run.h5.part"]
    monkeypatch.setattr(ResultWriter, "finish", finish)
    assert same(rsc.simulate(scene, path="run.h5", resume=True), whole)


def test_a_run_killed_before_it_has_its_name_is_not_run_again(folder, monkeypatch):
    """Found by random kills: its last checkpoint is its end, and one more step was counted."""
    whole = rsc.simulate(SHORT)
    finish = ResultWriter.finish
    monkeypatch.setattr(ResultWriter, "finish", lambda writer, *parts: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        rsc.simulate(SHORT, path="run.h5")
    monkeypatch.setattr(ResultWriter, "finish", finish)
    again = rsc.simulate(SHORT, path="run.h5", resume=True)
    assert same(again, whole) and again.summary == whole.summary


def test_a_run_that_stopped_by_itself_is_not_resumed():
    scene = SHORT.with_values({"solver.max_steps": 300})
    stopped = rsc.simulate(scene, path="run.h5")
    before = Path("run.h5").read_bytes()
    assert rsc.simulate(scene, path="run.h5", resume=True).summary == stopped.summary
    assert stopped.status == "too many steps" and Path("run.h5").read_bytes() == before


def interrupted(scene, signals):
    signals(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt) as caught:
        rsc.simulate(scene, path="run.h5")
    return caught.value.result


def test_other_versions_are_not_resumed_unless_asked_and_then_recorded(signals, monkeypatch, capsys):
    """F15: on another processor or with another kernel the bits may differ."""
    scene = LONG.with_values({"drive.duration": 60.0})
    Path("long.toml").write_text(scene.to_toml())
    before, half = versions(), interrupted(scene, signals)
    assert half.summary.versions == before and rsc.load("run.h5").summary == half.summary
    content = Path("run.h5").read_bytes()
    for module in ("rsc.simulation.run", "rsc.study.run.simulate"):
        monkeypatch.setattr(f"{module}.versions", lambda: "rsc 99 on a toaster")
    command = ["run", "long.toml", "-o", "run.h5", "--resume"]
    assert main(command) == 2
    error = capsys.readouterr().err
    assert "--not-bitwise" in error and before in error and "toaster" in error and error.count("\n") == 1
    assert Path("run.h5").read_bytes() == content and sorted(os.listdir()) == ["long.toml", "run.h5"]
    assert main([*command, "--not-bitwise"]) == 0
    found = rsc.load("run.h5")
    assert found.summary.versions == f"{before} until {half.summary.end_time:.6g} s; then rsc 99 on a toaster"
    assert found.status == "finished" and same(found, rsc.simulate(scene))
    capsys.readouterr()
    assert main(["verify", "run.h5"]) == 0 and "energies as well; this is rsc 99 on a toaster" in capsys.readouterr().out


def test_a_run_of_several_versions_is_resumed_by_the_last_of_them(signals, monkeypatch):
    scene = LONG.with_values({"drive.duration": 200.0})
    for name in ("one", "two", "two"):
        for module in ("rsc.simulation.run", "rsc.study.run.simulate"):
            monkeypatch.setattr(f"{module}.versions", lambda name=name: name)
        signals(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            rsc.simulate(scene, path="run.h5", resume=Path("run.h5").exists(), bitwise=name == "one")
    made_with = rsc.load("run.h5").summary.versions
    assert made_with.startswith("one until ") and made_with.endswith("; then two") and made_with.count("two") == 1


def test_a_disk_without_locks_is_told_and_the_run_goes_on(signals, monkeypatch):
    """F10: as network disks answer."""

    def no_locks(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", no_locks)
    scene, notes = LONG.with_values({"drive.duration": 60.0}), []
    signals(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        rsc.simulate(scene, path="run.h5", note=notes.append)
    assert any("no locks" in note for note in notes)
    os.replace("run.h5", "run.h5.part")  # as a kill would have left it
    assert same(rsc.simulate(scene, path="run.h5", resume=True), rsc.simulate(scene))
