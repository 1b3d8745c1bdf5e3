"""What a run is predicted to take against what it takes, and refusals with what would fit."""

import json
import os
import re
import shutil
import subprocess
import sys
import tracemalloc
from pathlib import Path

import pytest

import rsc
from rsc.cli import main
from rsc.results import budget
from rsc.study.run.start import run_of
from scenes import SCENES, changed
from systems import reference_scene
from tiers import nightly

MANY = reference_scene("bouncing").with_values({"drive.duration": 12.0, "output.rate": 1e5})
FILES = {
    "bouncing": reference_scene("bouncing").with_values({"drive.duration": 20.0}),
    "many samples": MANY,
    "few samples": reference_scene("bouncing").with_values({"drive.duration": 100.0, "output.rate": 400.0}),
    "stiff wall": reference_scene("bouncing").with_values({"drive.duration": 4.0, "contact.stiffness": 1e11}),
    "rigid": rsc.Scene.from_dict(changed(SCENES["rigid wall"], drive={"duration": 30.0}, contact={"friction": 0.0})),
    "chains": rsc.Scene.from_dict(changed(SCENES["chains"], drive={"duration": 10.0}, contact={"friction": 0.0})),
}
FILES["velocities"] = FILES["chains"].with_values({"output.velocities": True})


@pytest.mark.parametrize("name", FILES)
def test_size_of_the_file(name, tmp_path):
    scene, run = FILES[name], run_of(FILES[name])
    predicted = budget.file_bytes(scene, run.chunk_time)
    result = rsc.simulate(scene, path=tmp_path / "run.h5")
    assert result.status == "finished"
    assert predicted == pytest.approx((tmp_path / "run.h5").stat().st_size, rel=0.1)


@pytest.mark.parametrize("name", ["chains", "velocities"])
def test_memory_of_a_run_to_a_file(name, tmp_path):
    """In bounded memory: what the blocks of samples take, whatever the length of the run."""
    scene = FILES[name].with_values({"output.rate": 1e5, "drive.duration": 2.0})
    rsc.simulate(scene, path=tmp_path / "run.h5")
    tracemalloc.start()
    rsc.simulate(scene, path=tmp_path / "run.h5")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert budget.memory_bytes(scene, run_of(scene).buffer_bytes) == pytest.approx(peak, rel=0.1)


PEAK = """
import json, sys, tomllib, rsc
from rsc.results import budget
scene = rsc.Scene.from_dict(tomllib.load(open("scene.toml", "rb")))
notes = []
rsc.simulate(scene, path=sys.argv[1] if sys.argv[1:] else None, note=notes.append).rotor
# not getrusage: its peak is inherited from the process that started this one
peak = next(line for line in open("/proc/self/status") if line.startswith("VmHWM:"))
print(json.dumps([notes, 1024 * int(peak.split()[1])]))
"""


@pytest.mark.parametrize(("path", "compiling"), [("run.h5", False), (None, False), nightly("run.h5", True)])
def test_peak_memory_of_the_process(path, compiling, tmp_path):
    """The number a user reads before the start is the one the process has at its end, interpreter and libraries included; also
    where the kernel has to be compiled, which takes more than the run."""
    scene = MANY if path is None else FILES["bouncing"]
    rsc.simulate(FILES["bouncing"])  # the kernel is in its cache
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    command = [sys.executable, "-c", PEAK, *([path] if path else [])]
    cache = {"XDG_CACHE_HOME": str(tmp_path / "cache")} if compiling else {}
    done = subprocess.run(command, cwd=tmp_path, env=os.environ | cache, capture_output=True, text=True, check=True)
    notes, peak = json.loads(done.stdout)
    (note,) = [text for text in notes if "will hold" in text]  # compiling is told as well
    number, unit = re.match(r"this run will hold ([\d.]+) (MB|GB) of memory", note).groups()
    assert float(number) * {"MB": 1e6, "GB": 1e9}[unit] == pytest.approx(peak, rel=0.1)
    assert ("to run.h5" in note) == bool(path)


REPORT = """
import json, sys
from rsc.cli import main
from rsc.operating_system.posix import _proc
main(["check", "scene.toml"])
print(json.dumps(_proc("/proc/self/status", "VmHWM:")[0]))
"""


@pytest.mark.parametrize("duration", [1.0, 300.0])
def test_memory_of_a_report_is_no_more_than_was_told(duration, tmp_path):
    scene = rsc.Scene.from_dict(changed(SCENES["whirl, unbalance, run-up"], drive={"duration": duration}))
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    done = subprocess.run([sys.executable, "-c", REPORT], cwd=tmp_path, capture_output=True, text=True, check=True)
    peak, told = json.loads(done.stdout.splitlines()[-1]), done.stderr.splitlines()[0]
    most = 1e6 * float(re.fullmatch(r"rsc: run and report will hold at most ([\d.]+) MB of memory", told)[1])
    assert peak < most < 2.0 * peak


DENSE = """
import json, sys, rsc
from rsc.operating_system.posix import _proc
foreseen = []
rsc.simulate(rsc.load_scene("dense.toml"), path="run.h5", note=foreseen.append)
text = next(text for text in foreseen if "will hold" in text)
print(json.dumps([text, _proc("/proc/self/status", "VmHWM:")[0]]))
"""


def test_memory_where_a_step_holds_more_samples_than_the_buffer(tmp_path):
    tables = {"rotor": {"frequency": 1.0, "eccentricity": 1e-12}, "start": {"rest": True}, "output": {"rate": 1e7}}
    scene = changed(drive={"speed": 0.1, "duration": 0.3}, solver={"rtol": 1e-3}, **tables)
    (tmp_path / "dense.toml").write_text(rsc.Scene.from_dict(scene).to_toml())
    done = subprocess.run([sys.executable, "-c", DENSE], cwd=tmp_path, capture_output=True, text=True, check=True)
    text, peak = json.loads(done.stdout)
    number, unit = re.search(r"hold ([\d.]+) (MB|GB) of memory", text).groups()
    assert peak < float(number) * {"MB": 1e6, "GB": 1e9}[unit] < 3.0 * peak


@pytest.mark.parametrize("velocities", [False, True])
def test_bytes_of_the_samples(velocities):
    scene = MANY.with_values({"output.velocities": velocities})
    held = sum(values.nbytes for values in rsc.simulate(scene).source.block().values())
    assert budget.sample_bytes(scene) == pytest.approx(held, rel=1e-5)


def test_more_than_the_memory_is_refused_with_what_would_fit(monkeypatch):
    held = budget.sample_bytes(MANY)
    monkeypatch.setattr(budget, "free_memory", lambda: 2 * held)
    with pytest.raises(rsc.SolverError, match=r"lower output.rate to [\d.e+]+$") as caught:
        rsc.simulate(MANY)
    rate = float(str(caught.value).rsplit(" ", 1)[1])
    rsc.simulate(MANY.with_values({"output.rate": rate}))
    with pytest.raises(rsc.SolverError):
        rsc.simulate(MANY.with_values({"output.rate": 1.01 * rate}))


def test_more_than_the_disk_is_refused_and_nothing_is_written(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(FILES["bouncing"].to_toml())
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: usage._replace(free=3_000_000))
    assert main(["run", "scene.toml", "-o", "run.h5"]) == 4
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "MB of disk and 3.0 MB are free: lower output.rate to" in error
    assert [item.name for item in tmp_path.iterdir()] == ["scene.toml"]
    rate = float(error.split()[-1])
    (tmp_path / "scene.toml").write_text(FILES["bouncing"].with_values({"output.rate": rate}).to_toml())
    assert main(["run", "scene.toml", "-o", "run.h5"]) == 0
    assert "of disk" not in capsys.readouterr().err and (tmp_path / "run.h5").stat().st_size < 0.8 * 3_000_000


def test_a_sampling_rate_that_may_not_fall_further_is_not_proposed(monkeypatch):
    monkeypatch.setattr(budget, "free_memory", lambda: 100_000_000)
    with pytest.raises(rsc.SolverError, match=r"shorten drive.duration to [\d.]+ s"):
        rsc.simulate(MANY.with_values({"output.rate": 400.0, "drive.duration": 1e4}))


def test_many_small_runs_leave_nothing_behind():
    """F16: neither memory nor open files grow with the number of runs."""
    scene = rsc.Scene.from_dict(changed(SCENES["bouncing"], drive={"duration": 0.02}))

    def used():
        kilobytes = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmRSS:"))
        return int(kilobytes.split()[1]), len(os.listdir("/proc/self/fd"))

    for _ in range(100):
        rsc.simulate(scene)
    memory, files = used()
    for _ in range(1000):
        rsc.simulate(scene)
    assert used()[0] < 1.01 * memory and used()[1] == files
