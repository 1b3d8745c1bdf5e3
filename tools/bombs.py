"""Small files that unpack to far more than they are, over six formats: memory and time of reading each.

    python tools/bombs.py --count 1000 --write     keeps the table in docs/maintainers/tables
    python tools/bombs.py --count 1 --first 4711   one case again

Every case is read in a child process; what it takes beyond what was loaded before must stay within four times the cap. Exit code
1 where one does not, or where anything but a refusal in one line comes of it.
"""

import argparse
import collections
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pages import TABLES, write_page

ROOT = Path(__file__).resolve().parent.parent
SUPPORT = ROOT / "tests" / "support"
BATCH = 50
READ = """
import json, os, sys, time
sys.path.insert(0, sys.argv[1])
import bomb_files, h5py, nptdms, pyuff, scipy.io.wavfile, scipy.signal.windows, rsc.measured.measured  # once for all cases

def peak():
    line = next(line for line in open("/proc/self/status") if line.startswith("VmHWM:"))
    return int(line.split()[1]) * 1024

for path in sys.argv[2:]:
    child = os.fork()  # each case has a peak of its own, above that of the process that has loaded everything
    if child == 0:
        open("/proc/self/clear_refs", "w").write("5")
        before, began = peak(), time.process_time()
        outcome = bomb_files.explode(path)
        print(json.dumps([path, outcome, peak() - before, time.process_time() - began]), flush=True)
        os._exit(0)
    os.waitpid(child, 0)
"""


def outcomes(numbers, folder):
    """[kind, bytes of the file, outcome, bytes it took, s] of each bomb."""
    sys.path.insert(0, str(SUPPORT))
    import bomb_files

    paths = {}
    for number in numbers:
        place = Path(folder, str(number))
        place.mkdir()
        path, size = bomb_files.write(number, place)
        paths[str(path)] = bomb_files.FORMATS[number % len(bomb_files.FORMATS)], size
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    command = [sys.executable, "-c", READ, str(SUPPORT), *paths]
    told = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    lines = [json.loads(line) for line in told.stdout.splitlines()]
    if len(lines) != len(paths):
        raise SystemExit(f"{len(paths) - len(lines)} of {len(paths)} cases ended their process:\n{told.stderr[-2000:]}")
    for path, outcome, taken, seconds in lines:
        yield *paths[path], outcome, taken, seconds


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
    sys.path.insert(0, str(SUPPORT))
    import bomb_files

    rows = collections.defaultdict(list)
    began, failed = time.perf_counter(), 0
    for first in range(options.first, options.first + options.count, BATCH):
        with tempfile.TemporaryDirectory() as folder:
            numbers = range(first, min(first + BATCH, options.first + options.count))
            for number, (kind, size, outcome, taken, seconds) in zip(numbers, outcomes(numbers, folder), strict=True):
                rows[kind].append((outcome == "read", size, taken, seconds))
                if taken > bomb_files.TIMES * bomb_files.CAP or "\n" in outcome:
                    failed += 1
                    print(f"case {number}, {kind}: {taken / 2**20:.0f} MB, {outcome[:200]}", file=sys.stderr, flush=True)
        print(f"{first + len(numbers)} done, {time.perf_counter() - began:.0f} s", file=sys.stderr, flush=True)
    allowed = f"the cap is {bomb_files.CAP >> 20} MB, of which {bomb_files.TIMES} times are allowed"
    text = [f"{options.count} files, {failed} failures; {allowed}.", ""]
    text += ["| format | files | largest, kB | read | refused | most memory, MB | longest, s |", "|---|---|---|---|---|---|---|"]
    for kind, cases in rows.items():
        read, sizes, taken, seconds = zip(*cases, strict=True)
        most = f"{max(taken) / 2**20:.0f} | {max(seconds):.1f}"
        text.append(f"| {kind} | {len(cases)} | {max(sizes) / 1e3:.0f} | {sum(read)} | {len(cases) - sum(read)} | {most} |")
    print("\n".join(text))
    if options.write and not failed:
        write_page(TABLES / "bombs.md", "Bombs", f"python tools/bombs.py --count {options.count} --write", "\n".join(text))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
