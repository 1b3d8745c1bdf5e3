"""A sweep that is killed, interrupted or without disk: what was computed stays, and resuming ends with the same bits."""

import random
import resource
import signal
import subprocess

import pytest

import sweep_faults as faults
from rsc.study.sweep.dataset import load_dataset
from run_faults import shim


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """(scene file, seconds of the sweep, content of its store)."""
    folder = tmp_path_factory.mktemp("whole")
    scene = faults.scene_file(folder)
    faults.whole(scene, folder / "compiled")
    seconds = faults.whole(scene, folder / "store")
    return scene, seconds, faults.content(folder / "store")


@pytest.mark.nightly
def test_kills_at_random_moments_cost_nothing(undisturbed, tmp_path):
    scene, seconds, expected = undisturbed
    dice, killed, latest = random.Random(1), 0, 0.5 * seconds
    for _ in range(12):
        if faults.disturbed(scene, tmp_path / "store", dice.uniform(0.0, latest))[0] == -signal.SIGKILL:
            killed += 1
        else:
            latest *= 0.5  # what is left to do gets less, and the machine may have become idle
        if killed == 4:
            break
    faults.whole(scene, tmp_path / "store")
    assert killed >= 2
    assert faults.content(tmp_path / "store") == expected


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_sweep_says_so_in_one_line_and_goes_on(stop, undisturbed, tmp_path):
    scene, _, expected = undisturbed
    code, told = faults.disturbed(scene, tmp_path / "store", 0.0, stop, parts=2)
    assert code == 130
    last = told.strip().splitlines()[-1]
    assert last.startswith("error: interrupted") and "--resume continues it" in last and "Traceback" not in told
    faults.whole(scene, tmp_path / "store")
    assert faults.content(tmp_path / "store") == expected


def test_a_full_disk_is_told_in_one_line_and_costs_nothing(undisturbed, tmp_path):
    scene, _, expected = undisturbed
    sizes = sorted({len(content) for content in expected.values()})
    for most in (100, sizes[0] + 1, sizes[len(sizes) // 2], sizes[-1] - 1):  # no plan; no part; some parts; all but the dataset
        process = faults.started(scene, tmp_path / "store")
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (most, most))
        code, told = faults.ended(process)
        assert code == 4 and told.strip().splitlines()[-1].startswith("error: ") and "Traceback" not in told
        assert "file too large" in told.lower()
        assert all(expected[name] == content for name, content in faults.content(tmp_path / "store").items())
    faults.whole(scene, tmp_path / "store")
    assert faults.content(tmp_path / "store") == expected


def test_a_batch_of_processes_computes_one_store_at_a_time_and_a_killed_one_is_repeated(undisturbed, tmp_path):
    scene, _, expected = undisturbed
    store = tmp_path / "store"
    run = [*faults.COMMAND, "sweep"]
    quiet = {"env": faults.environment(), "capture_output": True, "text": True}
    assert subprocess.run([*run, "plan", scene, *faults.GRID, "-o", store], **quiet, check=False).returncode == 0
    halves = [subprocess.Popen([*run, "run", store, "--part", part], env=quiet["env"]) for part in ("0-9", "5-15")]
    while not faults.n_parts(store):
        assert halves[0].poll() is None
    halves[0].send_signal(signal.SIGKILL)
    assert [half.wait() for half in halves][1] == 0
    assert subprocess.run([*run, "run", store, "--part", "0-15"], **quiet, check=False).returncode == 0
    assert subprocess.run([*run, "collect", store], **quiet, check=False).returncode == 0
    held = {name: content for name, content in faults.content(store).items() if ".rsc-" not in name}
    assert held == expected
    assert (load_dataset(store / "sweep.nc")["status"] == "finished").all()


def test_a_kill_a_full_disk_or_an_error_at_a_call_that_changes_a_file_costs_nothing(tmp_path):
    """At a fifth of the calls; at all of them: tools/faults.py."""
    library = shim(tmp_path)
    if library is None:
        pytest.skip("needs Linux and a C compiler")
    rows = faults.driven(library, tmp_path, 0.2)
    assert len(rows) > 20 and {row[0] for row in rows} == set(faults.MODES)
    assert [row for row in rows if row[-1] != "same"] == []
