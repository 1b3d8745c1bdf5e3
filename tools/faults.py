"""Faults to survive: kills at random moments of a long run, and a kill or a full disk at every write of a short one; of sweeps
kills of the client and of workers, and a kill, a full disk or an I/O error at every call that changes a file.

    python tools/faults.py --kills 50 --share 1 --write
    python tools/faults.py --sweeps --kills 40 --share 1 --write
    python tools/faults.py --memory --share 0.01 --write

--memory: a run whose allocations fail in HDF5 or NumPy, one or all from then on. After each fault what is left must be a
part of the undisturbed run, and the resumed run must end with its bits: every array, the counters, the energies. A sweep that
goes on must end with the same files and no other. Exit code 1 when one does not.
"""

import argparse
import collections
import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

from pages import TABLES, write_page

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests" / "support")]


def _killed(scene, path, pause, resume):
    """Start the run in a copy of this process (its kernel is compiled), and kill it a pause after it began to write.

    Returns whether it was still running.
    """
    import rsc
    from rsc.results.claims import part_of

    part, since = part_of(path), time.time()
    child = os.fork()
    if not child:
        code = 1
        try:
            rsc.simulate(scene, path=path, resume=resume)
            code = 0
        finally:
            os._exit(code)
    while not _ended(child) and not (part.exists() and part.stat().st_mtime >= since):
        time.sleep(0.001)
    time.sleep(pause)
    os.kill(child, signal.SIGKILL)  # a child that has ended by itself is still there to be waited for
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


def _ended(child):
    """Whether a child has ended; it is not waited for."""
    return os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


def kills(count, seed):
    """(outcome, times) of `count` kills -9 at random moments, every second time the resumed run is killed as well."""
    import rsc
    import run_faults
    from systems import reference_scene

    scene = reference_scene("bouncing").with_values({"drive.duration": 400.0})
    whole, dice, found, done = rsc.simulate(scene), random.Random(seed), collections.Counter(), 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.h5")
        started = time.time()
        rsc.simulate(scene, path=path)
        length = time.time() - started
        while done < count:
            for item in Path(folder).glob("run.h5*"):
                item.unlink()
            if not _killed(scene, path, dice.uniform(0.0, length), False):
                continue
            again = done % 2 and _killed(scene, path, dice.uniform(0.0, length), True)
            done += 1 + again
            outcome = run_faults.after(scene, path, whole)
            found[("killed, resumed, killed again" if again else "killed", *outcome)] += 1 + again
            print(done, outcome, file=sys.stderr, flush=True)
    return found


def writes(share):
    """Outcome -> times of a kill or a full disk at a share of the writes of a short run."""
    import run_faults

    with tempfile.TemporaryDirectory() as folder:
        calls, rows = run_faults.driven(faults_shim(folder), share)
    return calls, collections.Counter((mode, left, verdict) for mode, _, left, verdict in rows)


def memory(share):
    """(allocations of a short run, outcome -> times of a share of them that failed)."""
    import run_faults

    with tempfile.TemporaryDirectory() as folder:
        calls, rows = run_faults.driven(faults_shim(folder), share, "memory")
    return calls, collections.Counter((mode, left, verdict) for mode, _, left, verdict in rows)


def of_sweeps(kills, share, seed):
    """Outcome -> times of kills of the client and of a worker at random moments, and of faults at a share of all calls."""
    import sweep_faults

    with tempfile.TemporaryDirectory() as name:
        folder, dice, found = Path(name).resolve(), random.Random(seed), collections.Counter()
        library, scene, calls = faults_shim(folder), sweep_faults.scene_file(folder), folder / "calls"
        calls.mkdir()
        sweep_faults.whole(scene, folder / "compiled")
        length = sweep_faults.whole(scene, folder / "whole")
        expected = sweep_faults.content(folder / "whole")
        for i in range(kills):
            left = sweep_faults.disturbed(scene, folder / str(i), dice.uniform(0.0, 1.2 * length))[0]
            sweep_faults.whole(scene, folder / str(i))
            same = "same" if sweep_faults.content(folder / str(i)) == expected else "other"
            found["client killed -9 at a random moment" if left else "client done before it was killed", "", same] += 1
        for i in range(kills // 2):
            same = "same" if sweep_faults.with_a_worker_killed(scene, folder / f"w{i}", dice.uniform(0.0, length)) else "other"
            found["worker killed -9 at a random moment", "", same] += 1
        for mode, _, code, _, verdict in sweep_faults.driven(library, calls, share):
            found[f"{mode} that changes a file", f"exit code {code}" if code >= 0 else "killed", verdict] += 1
    return found


def faults_shim(folder):
    """The shim of tests/support/run_faults.py, compiled into a folder."""
    import run_faults

    library = run_faults.shim(folder)
    if library is None:
        raise SystemExit("needs Linux and a C compiler")
    return library


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sweeps", action="store_true", help="faults of sweeps instead of runs")
    parser.add_argument("--memory", action="store_true", help="allocations of memory that fail instead of kills and full disks")
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--share", type=float, default=1.0, help="share of the writes of the short run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
    if options.sweeps:
        return _told_of_sweeps(options)
    if options.memory:
        return _told_of_memory(options)
    random_kills = kills(options.kills, options.seed)
    calls, at_writes = writes(options.share)
    lines = ["| fault | what was left | resumed run | times |", "|---|---|---|---|"]
    for (fault, left, verdict), times in sorted(random_kills.items()):
        lines.append(f"| {fault} -9 at a random moment of a long run | {left} | {verdict} bits | {times} |")
    for (fault, left, verdict), times in sorted(at_writes.items()):
        lines.append(f"| {fault}, at one of the {calls} writes of a short run | {left} | {verdict} bits | {times} |")
    text = "\n".join(lines)
    print(text)
    if options.write:
        write_page(TABLES / "faults.md", "Kills and full disks", "python tools/faults.py --write", text)
    return 0 if all(verdict == "same" for _, _, verdict in (*random_kills, *at_writes)) else 1


def _told_of_memory(options):
    calls, found = memory(options.share)
    lines = [f"Of the {calls} allocations of a short run by HDF5 and NumPy:", ""]
    lines += ["| fault | what was left | resumed run | times |", "|---|---|---|---|"]
    lines += [f"| {fault} | {left} | {verdict} bits | {times} |" for (fault, left, verdict), times in sorted(found.items())]
    print("\n".join(lines))
    if options.write:
        command = f"python tools/faults.py --memory --share {options.share:g} --write"
        write_page(TABLES / "memory_faults.md", "Allocations of memory that fail", command, "\n".join(lines))
    return 0 if all(verdict == "same" for *_, verdict in found) else 1


def _told_of_sweeps(options):
    swept = of_sweeps(options.kills, options.share, options.seed)
    lines = ["| fault | end of the sweep | continued | times |", "|---|---|---|---|"]
    lines += [f"| {fault} | {end} | {verdict} files | {times} |" for (fault, end, verdict), times in sorted(swept.items())]
    print("\n".join(lines))
    if options.write:
        command = f"python tools/faults.py --sweeps --kills {options.kills} --share {options.share:g} --write"
        write_page(TABLES / "sweep_faults.md", "Kills, full and failing disks of sweeps", command, "\n".join(lines))
    return 0 if all(verdict == "same" for *_, verdict in swept) else 1


if __name__ == "__main__":
    sys.exit(main())
