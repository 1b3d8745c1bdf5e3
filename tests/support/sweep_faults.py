"""A sweep that is disturbed (killed, interrupted, out of disk) and continued until it is whole, and one that is not.

For test_sweep_faults, tools/faults.py and bench/sweep.py: `rsc sweep` in a process of its own, compared file by file.
"""

import ctypes
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from scenes import LAVAL, changed

GRID = ("--vary", "contact.friction=0.05:0.3:24", "--vary", "drive.speed=30:70:16", "--compute", "predict,run")
VARIED = {"contact.friction": "0.05:0.3:24", "drive.speed": "30:70:16"}
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


def with_a_worker_killed(scene, store, pause):
    """Whether a sweep on two processes, one of which is killed a pause after its start, and continued has the files of one on
    threads."""
    import rsc

    def swept(path, **how):
        return rsc.sweep(rsc.load_scene(scene), VARIED, ("predict", "run"), path=path, **how)

    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as executor:
        list(executor.map(abs, range(8)))  # both are there
        victim = next(iter(executor._processes))
        timer = threading.Timer(pause, os.kill, (victim, signal.SIGKILL))
        timer.start()
        swept(store, executor=executor)
        timer.cancel()
    swept(store, resume=True, threads=1)
    undisturbed = store.with_name("threads")
    if not undisturbed.exists():
        swept(undisturbed, threads=1)
    return content(store) == content(undisturbed)


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


# What follows: a kill, a full disk or an I/O error at every call that changes a file of the store. As a program, started with
# LD_PRELOAD=fault_shim.so (`driven`), it prints one line of JSON for each: [mode, call, exit code or minus the signal, what was
# left before the sweep went on, "same" or what is wrong].

SMALL = ("--vary", "contact.friction=0.1,0.2,0.3", "--vary", "drive.speed=40,50,60", "--compute", "predict,run")
MODES = {"killed before the call": 1, "killed behind the call": 2, "no space from the call on": 3, "I/O error of the call": 4}


def driven(library, folder, share=1.0):
    """[[mode, call, code, left, verdict]] of a share of all calls, in every mode."""
    preloaded = environment() | {"LD_PRELOAD": str(library), "FAULT_SHIM": str(library)}
    command = [sys.executable, str(Path(__file__).resolve()), str(folder), str(share)]
    done = subprocess.run(command, env=preloaded, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return [json.loads(line) for line in done.stdout.splitlines()]


def _swept(scene, store):
    """(exit code or minus the signal, standard error) of a sweep in a copy of this process; continued where there is a plan."""
    from rsc.cli import main

    resume = ["--resume"] if Path(store, "plan.h5").exists() else []
    with tempfile.TemporaryFile("w+") as told:
        child = os.fork()
        if not child:
            code = 1
            try:
                os.dup2(told.fileno(), 2)
                os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
                code = main(["sweep", str(scene), *SMALL, "--threads", "1", "-o", str(store), *resume])
            finally:
                sys.stderr.flush()
                os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        told.seek(0)
        return code, told.read()


def _verdict(mode, code, told, held, expected):
    """What is wrong after a fault, "" if nothing."""
    torn = [name for name, data in held.items() if ".rsc-" not in name and data != expected[name]]
    if torn:
        return f"half a file: {torn}"
    if code not in ((-signal.SIGKILL,) if mode < 3 else (4,) if mode == 3 else (0, 4)):
        return f"exit code {code}: {told[-300:]}"
    errors = [line for line in told.splitlines() if not line.startswith("rsc: ")]
    return f"it says {told!r}" if code == 4 and (len(errors) != 1 or not errors[0].startswith("error: ")) else ""


def _main(folder, share):
    import rsc

    folder = Path(folder).resolve()
    library, store, scene = ctypes.CDLL(os.environ["FAULT_SHIM"]), folder / "store", folder / "small.toml"
    library.fault_count.restype = ctypes.c_long
    scene.write_text(rsc.Scene.from_dict(changed(LAVAL, drive={"duration": 0.05})).to_toml())
    compiled = rsc.sweep(rsc.load_scene(scene), {"contact.friction": [0.1, 0.2]}, ("predict", "run"), threads=1)
    assert compiled.sizes["contact.friction"] == 2
    code, told = _swept(scene, folder / "whole")
    assert code == 0, told
    expected = content(folder / "whole")
    library.fault_under(str(store).encode())
    calls = _calls(library, scene, store)
    for name, mode in MODES.items():
        for call in sorted({round(i * (calls - 1) / max(share * calls - 1, 1)) for i in range(max(int(share * calls), 2))}):
            shutil.rmtree(store, ignore_errors=True)
            library.fault_set(mode, ctypes.c_long(call))
            code, told = _swept(scene, store)
            library.fault_set(0, ctypes.c_long(-1))
            held = content(store) if store.exists() else {}
            wrong = _verdict(mode, code, told, held, expected)
            again, told = _swept(scene, store) if code else (0, "")
            verdict = wrong or (f"going on: exit code {again}: {told[-300:]}" if again else "")
            verdict = verdict or ("same" if content(store) == expected else f"other files: {sorted(content(store))}")
            print(json.dumps([name, call, code, len(held), verdict]), flush=True)


def _calls(library, scene, store):
    """Number of calls of a whole sweep, counted in a copy of this process: it is the first one without a fault."""
    low, high = 0, 1
    while _ends_at(library, scene, store, high):
        high *= 2
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if _ends_at(library, scene, store, middle) else (low, middle)
    return high


def _ends_at(library, scene, store, call):
    shutil.rmtree(store, ignore_errors=True)
    library.fault_set(1, ctypes.c_long(call))
    return _swept(scene, store)[0] != 0


if __name__ == "__main__":
    _main(sys.argv[1], float(sys.argv[2]))
