"""A sweep on the workers of a dask scheduler, one of which is killed."""

import os
import signal
import subprocess
import sys
import threading
import time

import distributed
import pytest

import rsc
from rsc.errors import SolverError
from rsc.study.sweep import plan
from rsc.study.sweep.engines import dask_client
from scenes import LAVAL, changed
from sweep_faults import environment

SCENE = rsc.Scene.from_dict(changed(LAVAL, drive={"duration": 0.2}), "laval.toml")
VARY = {"contact.friction": "0.05:0.3:60", "drive.speed": "30:70:8"}

# of dask's own making: sockets and event loops that a killed worker leaves
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module")
def cluster():
    with distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster:
        yield cluster


def test_a_killed_worker_costs_nothing(cluster, tmp_path):
    expected = rsc.sweep(SCENE, VARY, ("predict", "run"), path=tmp_path / "own", threads=1)
    with dask_client(cluster.scheduler_address) as client:
        victim = next(iter(client.run(os.getpid).values()))
        parts = tmp_path / "dask" / "parts"

        def kill():
            while not parts.exists() or len(list(parts.glob("*.h5"))) < 2:
                time.sleep(0.002)
            os.kill(victim, signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        data = rsc.sweep(SCENE, VARY, ("predict", "run"), path=tmp_path / "dask", executor=client)
        killer.join()
    assert (data.status == "finished").all()
    assert all(data[name].values.tobytes() == expected[name].values.tobytes() for name in expected.variables)
    names = sorted(os.listdir(tmp_path / "own" / "parts"))
    assert names == sorted(os.listdir(parts))
    assert all((parts / name).read_bytes() == (tmp_path / "own" / "parts" / name).read_bytes() for name in names)


def test_workers_with_other_versions_are_refused(cluster, monkeypatch):
    monkeypatch.setattr(plan, "own_versions", lambda: "rsc of tomorrow")
    wanted = "a worker has rsc .*, the sweep rsc of tomorrow"
    with dask_client(cluster.scheduler_address) as client, pytest.raises(SolverError, match=wanted):
        rsc.sweep(SCENE, VARY, executor=client)


def test_a_scheduler_that_dies_leaves_the_rest_to_be_resumed(tmp_path, capfd):
    """Scheduler and worker in processes of their own, as on a cluster; the scheduler is killed when some parts are there."""
    file = tmp_path / "scheduler.json"
    quiet = {"env": environment(), "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    dask, common = [sys.executable, "-m", "distributed.cli.dask_scheduler"], ["--scheduler-file", file, "--no-dashboard"]
    scheduler = subprocess.Popen([*dask, *common, "--port", "0", "--host", "127.0.0.1"], **quiet)
    worker = None
    try:
        while not file.exists():
            assert scheduler.poll() is None
            time.sleep(0.05)
        dask[-1] = "distributed.cli.dask_worker"
        worker = subprocess.Popen([*dask, *common, "--nthreads", "1"], **quiet)
        store = tmp_path / "store"
        killer = threading.Thread(target=_kill_after, args=(scheduler, store / "parts", 2))
        killer.start()
        with dask_client(str(file)) as client:
            data = rsc.sweep(SCENE, VARY, ("predict", "run"), path=store, executor=client)
        killer.join()
    finally:
        for process in filter(None, (scheduler, worker)):
            process.kill()
            process.wait()
    assert (data.status == "missing").any() and "Traceback" not in "".join(capfd.readouterr())
    whole = rsc.sweep(SCENE, VARY, ("predict", "run"), path=store, resume=True, threads=1)
    assert (whole.status == "finished").all()


def _kill_after(process, parts, count):
    while not parts.exists() or len(list(parts.glob("*.h5"))) < count:
        time.sleep(0.002)
    process.kill()
