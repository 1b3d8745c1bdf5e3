"""A run ended at a chosen write to its file, by a kill or a full disk, or at a chosen allocation of memory, and continued.

For test_faults and tools/faults.py. Started with LD_PRELOAD=fault_shim.so (`driven`); as a program it prints one line
of JSON per fault: [mode, call, what was left, "same" or what differs].
"""

import ctypes
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
MODES = {"killed before the call": 1, "killed in the middle of the call": 2, "no space from the call on": 3}
MEMORY = {"no memory for one allocation": 0, "no memory from an allocation on": 1}
ARRAYS = ("time", "speed", "rotor", "stator", "normal_force", "friction_force", "tangential_velocity")


def shim(folder):
    """The compiled shim, or None where there is no C compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if not (compiler and sys.platform == "linux"):
        return None
    target = Path(folder, "fault_shim.so")
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", "-o", target, HERE / "fault_shim.c", "-ldl"], check=True)
    return target


def driven(library, share, faults="writes"):
    """(calls of a whole run, [[mode, call, left, verdict]]) of a share of all its calls, in every mode; faults: of writes, or of
    allocations of memory; or kills at so many of the last writes ("end")."""
    paths = os.pathsep.join(filter(None, sys.path))  # the rsc that this process has
    environment = os.environ | {"LD_PRELOAD": str(library), "FAULT_SHIM": str(library), "PYTHONPATH": paths}
    command = [sys.executable, str(Path(__file__).resolve()), str(share), faults]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr)
    calls, *rows = (json.loads(line) for line in done.stdout.splitlines())
    return calls, rows


def _same(result, whole):
    import numpy as np

    differing = [name for name in ARRAYS if not np.array_equal(getattr(result, name), getattr(whole, name))]
    return "same" if not differing and result.summary == whole.summary else f"differs: {differing or 'summary'}"


def _child(action):
    """Exit code, or minus the signal, of an action in a copy of this process."""
    child = os.fork()
    if not child:
        code = 1
        try:
            action()
            code = 0
        except BaseException as error:
            code = {"WriteError": 4, "DataError": 4, "MemoryError": 2}.get(type(error).__name__, 1)
            if code == 1:
                sys.excepthook(*sys.exc_info())
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def after(scene, path, whole):
    """(what was left, verdict) after a fault: what can be read is a part of the whole, and the run goes on to the same bits."""
    import rsc
    from rsc.results.result_file import ResultFile
    from rsc.results.unfinished import resumable

    try:
        left = resumable(path)
    except rsc.DataError:
        return "nothing", _same(rsc.simulate(scene, path=path), whole)
    if left is None:  # the fault came before the first checkpoint: said so, and the run begins anew
        told = []
        verdict = _same(rsc.simulate(scene, path=path, resume=True, note=told.append), whole)
        return "nothing whole", verdict if any("starts again" in line for line in told) else "begun anew without a word"
    try:
        checkpoint = ResultFile(left).checkpoint()[0]
    except rsc.DataError:
        checkpoint = None
    if checkpoint is None:  # torn, so that nothing of it can be read: said so, and a new run takes its place
        try:
            rsc.simulate(scene, path=path, resume=True)
            return "a torn part", "a run was resumed from nothing"
        except rsc.DataError:
            return "a torn part", _same(rsc.simulate(scene, path=path), whole)
    rows = int(checkpoint["rows"][0])
    block = ResultFile(left).rows(0, rows)
    if any((values != getattr(whole, name)[:rows]).any() for name, values in block.items()):
        return f"{rows} samples", "a wrong sample is read"
    what, told = "result" if left == path else "a part", []
    try:
        verdict = _same(rsc.simulate(scene, path=path, resume=True, note=told.append), whole)
        return "a part, begun anew" if any("starts again" in line for line in told) else what, verdict
    except rsc.DataError as error:
        return what, f"cannot be resumed: {error}"


def _main(share, faults):
    import rsc
    from rsc.simulation import run
    from systems import reference_scene

    scene = reference_scene("bouncing").with_values({"drive.duration": 20.0 if faults == "end" else 5.0})
    run.BUFFER_ROWS = 2300  # some blocks, of which one crosses a chunk's border
    whole = rsc.simulate(scene)
    library = ctypes.CDLL(os.environ["FAULT_SHIM"])
    tried = {"writes": _of_writes, "end": _of_writes, "memory": _of_memory}[faults](library)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.h5")
        calls = tried.count(lambda: rsc.simulate(scene, path=path))
        print(json.dumps(calls))
        chosen = sorted({round(i / max(share * calls - 1, 1) * (calls - 1)) for i in range(max(int(share * calls), 2))})
        modes = list(tried.modes.items())
        if faults == "end":
            chosen, modes = range(calls - int(share), calls), modes[:1]
        for name, mode in modes:
            for call in chosen:
                for item in Path(folder).iterdir():
                    item.unlink()

                def action(mode=mode, call=call):
                    tried.arm(mode, call)
                    rsc.simulate(scene, path=path)

                code = _child(action)
                tried.disarm()
                left, verdict = after(scene, path, whole)
                verdict = verdict if code in tried.codes[mode] else f"exit {code}, {verdict}"
                print(json.dumps([name, call, left, verdict]), flush=True)


class _Tried(NamedTuple):
    """Faults: modes, the exit codes that each may end with, functions that arm one or none, one that counts the calls of an
    action."""

    modes: dict[str, int]
    codes: dict[int, tuple[int, ...]]
    arm: Callable[[int, int], None]
    disarm: Callable[[], None]
    count: Callable[[Callable[[], object]], int]


def _of_writes(library):
    library.fault_count.restype = ctypes.c_long

    def count(action):
        library.fault_set(0, ctypes.c_long(-1))
        action()
        return library.fault_count()

    codes = {1: (-9,), 2: (-9,), 3: (4,)}
    return _Tried(MODES, codes, lambda m, n: library.fault_set(m, ctypes.c_long(n)), lambda: library.fault_set(0, -1), count)


def _of_memory(library):
    """A run that finds no memory goes on to its end where it can do without."""
    library.memory_count.restype = ctypes.c_long

    def count(action):
        library.memory_set(ctypes.c_long(2**62), 0)
        action()
        calls = library.memory_count()
        library.memory_set(ctypes.c_long(-1), 0)
        return calls

    def arm(mode, call):
        library.memory_set(ctypes.c_long(call), mode)

    return _Tried(MEMORY, dict.fromkeys(MEMORY.values(), (0, 2, 4)), arm, lambda: arm(0, -1), count)


if __name__ == "__main__":
    _main(float(sys.argv[1]), sys.argv[2])
