"""Tests of compiled code with every index of an array checked (NUMBA_BOUNDSCHECK), on Numba's public interface alone.

    python tools/bounds.py
    python tools/bounds.py tests/unit/kernel

By default the short suite, the tests marked `versions`. Code is compiled anew into a cache of its own, some minutes. What reads
and writes memory by its address (rsc.kernel.simd.vec) is not checked. Exit code 1 where an index is out of its range, or where a
test fails.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from versions import MARKED

ROOT = Path(__file__).resolve().parent.parent
# an index that is out of range, in code compiled with the options of rsc's helpers
TRIED = """
import numba, numpy
from rsc.compiled.paths import helper_options
beyond = numba.njit(**helper_options())(lambda values, place: values[place])
try:
    beyond(numpy.zeros(3), 5)
except IndexError:
    print("checked")
"""


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tests", nargs="*", help="files or folders of tests (default: the short suite)")
    options = parser.parse_args()
    chosen = options.tests or ["-m", "versions", *MARKED]
    with tempfile.TemporaryDirectory() as caches:
        own = {"NUMBA_BOUNDSCHECK": "1", "RSC_PLAIN": "1", "XDG_CACHE_HOME": caches}
        environment = os.environ | own
        tried = subprocess.run([sys.executable, "-c", TRIED], env=environment, capture_output=True, text=True, check=False)
        if tried.stdout.strip() != "checked":
            print(f"indices are not checked: {tried.stderr}", file=sys.stderr)
            return 1
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *chosen]
        return min(subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode, 1)


if __name__ == "__main__":
    sys.exit(main())
