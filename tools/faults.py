"""Faults to survive: kills at random moments of a long run, and a kill or a full disk at every write of a short one.

    python tools/faults.py --kills 50 --share 1 --write

After each fault what is left must be a part of the undisturbed run, and the resumed run must end with its bits: every array, the
counters, the energies. Exit code 1 when one does not.
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
    from rsc.results.result_file import part_of

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
    import faults
    import rsc
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
            outcome = faults.after(scene, path, whole)
            found[("killed, resumed, killed again" if again else "killed", *outcome)] += 1 + again
            print(done, outcome, file=sys.stderr, flush=True)
    return found


def writes(share):
    """Outcome -> times of a kill or a full disk at a share of the writes of a short run."""
    import faults

    with tempfile.TemporaryDirectory() as folder:
        library = faults.shim(folder)
        if library is None:
            raise SystemExit("needs Linux and a C compiler")
        calls, rows = faults.driven(library, share)
    return calls, collections.Counter((mode, left, verdict) for mode, _, left, verdict in rows)


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--share", type=float, default=1.0, help="share of the writes of the short run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
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


if __name__ == "__main__":
    sys.exit(main())
