"""A sweep that is disturbed (killed, interrupted, out of disk) and continued until it is whole, and one that is not.

For test_sweep_faults and bench/sweep.py: `rsc sweep` in a process of its own, compared file by file.
"""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from scenes import LAVAL, changed

GRID = ("--vary", "contact.friction=0.05:0.3:24", "--vary", "drive.speed=30:70:16", "--compute", "predict,run")
COMMAND = (sys.executable, "-m", "rsc")
LONGEST = 120.0  # s that a sweep may take before something hangs


def scene_file(folder):
    """A small scene in a folder."""
    import rsc

    path = Path(folder, "laval.toml")
    path.write_text(rsc.Scene.from_dict(changed(LAVAL, drive={"duration": 0.2})).to_toml())
    return path


def environment():
    """Of processes with the rsc that this process has."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}


def started(scene, store):
    """The process of a sweep into a store, continued where there is one; it leads a group of its own."""
    resume = ["--resume"] if Path(store, "plan.h5").exists() else []
    command = [*COMMAND, "sweep", str(scene), *GRID, "-o", str(store), *resume]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, env=environment(), text=True, start_new_session=True, **pipes)


def whole(scene, store):
    """Seconds from the start to the end of an undisturbed sweep, or of what was left of one."""
    process = started(scene, store)
    begun = _first_news(process, store)
    _, problem = process.communicate(timeout=LONGEST)
    if process.returncode:
        raise RuntimeError(problem)
    return time.monotonic() - begun


def _first_news(process, store):
    """Wait until the process has opened the store; returns the time."""
    lock, before = Path(store, "lock"), time.time()
    while process.poll() is None and not (lock.exists() and lock.stat().st_mtime >= before):
        time.sleep(0.001)
    return time.monotonic()


def disturbed(scene, store, pause, with_signal=signal.SIGKILL, parts=0):
    """Send a signal a pause after a sweep opened its store, and once this has some parts; returns as `ended`."""
    process = started(scene, store)
    _first_news(process, store)
    while n_parts(store) < parts and process.poll() is None:
        time.sleep(0.001)
    time.sleep(pause)
    process.send_signal(with_signal)
    return ended(process)


def ended(process):
    """(exit code or minus the signal, standard error) of a process."""
    _, problem = process.communicate(timeout=LONGEST)
    return process.returncode, problem


def content(store):
    """name -> bytes of all that a store holds, but its lock."""
    root = Path(store)
    return {str(path.relative_to(root)): path.read_bytes() for path in root.rglob("*") if path.is_file() and path.name != "lock"}


def n_parts(store):
    """Number of whole parts of a store."""
    return len(list(Path(store, "parts").glob("*.h5")))


# What follows: a kill, or a disk that is full from then on, at every operation on a file of the store. As a program it prints one
# line of JSON for each: [mode, number of the operation, exit code or minus the signal, "same" or what is wrong].

SMALL = {"contact.friction": [0.1, 0.2, 0.3], "drive.speed": [40.0, 50.0, 60.0]}
CHANGES = {"open", "os.rename", "os.mkdir", "os.remove"}
KILLED, FULL = "killed before the operation", "no space from the operation on"


class Fault:
    """An audit hook, which Python tells of an operation on a file before it is done: counts those that change the store, and at
    one of them kills the process, or from then on lets none have space."""

    def __init__(self, store):
        self.store, self.mode, self.at, self.count = str(store), None, -1, 0
        sys.addaudithook(self)

    def __call__(self, event, arguments):
        if event not in CHANGES or not str(arguments[0]).startswith(self.store):
            return
        if event == "open" and not arguments[2] & (os.O_WRONLY | os.O_RDWR):
            return
        self.count += 1
        if self.mode == KILLED and self.count > self.at:
            os.kill(os.getpid(), signal.SIGKILL)
        if self.mode == FULL and self.count > self.at and event != "os.remove":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def faulty(fault, store, mode, at):
    """Exit code, or minus the signal, of `rsc sweep`'s computation into a store in a copy of this process."""
    import rsc

    child = os.fork()
    if not child:
        code = 1
        try:
            fault.mode, fault.at, fault.count = mode, at, 0
            _sweep(store)
            code = 0
        except rsc.DataError:
            code = 4
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _sweep(store):
    import rsc

    scene = rsc.Scene.from_dict(changed(LAVAL, drive={"duration": 0.05}))
    return rsc.sweep(scene, SMALL, ("predict", "run"), path=store, resume=Path(store, "plan.h5").exists(), threads=1)


def _main(folder):
    store = Path(folder, "store")
    _sweep(Path(folder, "whole"))
    expected, fault = content(Path(folder, "whole")), Fault(store)
    _sweep(store)
    operations = fault.count
    for mode in (KILLED, FULL):
        for at in range(operations):
            shutil.rmtree(store)
            code = faulty(fault, store, mode, at)
            held = content(store) if store.exists() else {}
            wrong = [name for name, data in held.items() if not name.endswith(".tmp") and data != expected[name]]
            _sweep(store)
            verdict = f"half a file: {wrong}" if wrong else "same" if content(store) == expected else "other files"
            print(json.dumps([mode, at, code, verdict]), flush=True)


if __name__ == "__main__":
    _main(sys.argv[1])
