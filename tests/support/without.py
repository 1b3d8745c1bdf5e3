"""Programs that run on this machine as on Windows, as far as tests/support/without_posix takes away what Windows lacks."""

import os
import subprocess
import sys
from pathlib import Path

SHIM = Path(__file__).parent / "without_posix"
COMMAND = (sys.executable, "-m", "rsc")


def environment(**changes):
    """Compiled code is where a program on POSIX keeps it, so that nothing is compiled anew."""
    from rsc.operating_system import user_caches

    paths = os.pathsep.join([str(SHIM), *filter(None, sys.path)])
    return {name: text for name, text in os.environ.items() if name != "XDG_CACHE_HOME"} | {
        "PYTHONPATH": paths, "LOCALAPPDATA": str(user_caches()), **changes
    }  # fmt: skip


def started(command, folder, **changes):
    """A process, its output in pipes."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([*map(str, command)], cwd=folder, env=environment(**changes), **pipes)


def ended(command, folder, **changes):
    """(exit code, standard output, standard error) of a process."""
    process = started(command, folder, **changes)
    out, told = process.communicate(timeout=300)
    return process.returncode, out, told
