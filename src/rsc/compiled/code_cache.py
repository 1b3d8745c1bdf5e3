"""Folder of compiled code on disk, named by what the code is made of.

Numba's own disk cache looks only at the file of the cached function, so an edited helper in another file would leave old code
running silently. The folder is therefore named by a hash of every source in it, of this wing, the versions and the processor.
"""

import hashlib
import os
import sys
import tempfile
import threading
from pathlib import Path

import llvmlite
import llvmlite.binding
import numba

OWN_SOURCES = Path(__file__).parent  # how code is compiled decides what it is, as its own source does
_SETTING = threading.Lock()  # Numba's cache folder is one for all threads


def fingerprint(place):
    """Name for compiled code: a hash of its source or sources below its folder, those of this wing, versions and processor."""
    digest = hashlib.sha256()
    for folder in (Path(place), OWN_SOURCES):
        for source in sorted(folder.rglob("*.py")) if folder.is_dir() else [folder]:
            digest.update(str(source.relative_to(folder.parent)).encode())
            digest.update(source.read_bytes())
    parts = (sys.version, numba.__version__, llvmlite.__version__, llvmlite.binding.get_host_cpu_name())
    digest.update(repr(parts).encode())
    return digest.hexdigest()[:20]


def _writable(folder):
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def cache_folder(place):
    """Folder of what is compiled from exactly this source (or folder of sources), versions and processor (made when missing)."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    name = fingerprint(place)
    for folder in (base / "rsc" / name, Path(tempfile.gettempdir()) / f"rsc-{os.getuid()}" / name):
        if _writable(folder):
            return folder
    return Path(tempfile.mkdtemp(prefix="rsc-"))


def in_folder(function, folder, options):
    """numba.njit with these options, what it compiles kept in a folder."""
    with _SETTING:
        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(folder)
        try:
            return numba.njit(nogil=True, error_model="numpy", cache=True, **options)(function)
        finally:
            numba.config.CACHE_DIR = before
