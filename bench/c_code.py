"""The C programs of bench/c, compiled when first used and kept by the content of source and flags and the features of the
processor."""

import atexit
import ctypes
import functools
import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import llvmlite.binding

from rsc.operating_system import UnsafeFolder, own_folder, user_caches

FOLDER = Path(__file__).parent / "c"
FLAGS = ("-O3", "-march=native", "-std=gnu11", "-fno-math-errno", "-fno-trapping-math", "-shared", "-fPIC")


class NoCompiler(Exception):
    """There is no C compiler, or it refused the source."""


def compiler():
    """Name of the compiler, or None."""
    return os.environ.get("CC") or shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")


def version():
    """First line of what the compiler says of itself, or why there is none."""
    if compiler() is None:
        return "no C compiler"
    return subprocess.run([compiler(), "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]


@functools.cache
def cache_folder():
    """Folder of what need not be made twice; nobody else may write it, because its libraries are loaded.

    Where the user has none, one that lasts as long as this process.
    """
    try:
        return own_folder(user_caches(), "rsc-bench")
    except UnsafeFolder:
        place = tempfile.mkdtemp()
        atexit.register(shutil.rmtree, place, ignore_errors=True)
        return Path(place)


@functools.cache
def library(name, *flags):
    """The shared library of c/NAME.c built with additional flags.

    Raises
    ------
    NoCompiler
        With the compiler's message.
    """
    if compiler() is None:
        raise NoCompiler("no C compiler on the path")
    source = FOLDER / f"{name}.c"
    processor = llvmlite.binding.get_host_cpu_name(), llvmlite.binding.get_host_cpu_features().flatten()
    parts = (source.read_text(), *FLAGS, *flags, version(), *processor)
    digest = hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]
    folder = cache_folder()
    file = folder / f"{name}_{digest}.so"
    if not file.exists():
        with tempfile.TemporaryDirectory(dir=folder) as place:
            made = Path(place) / file.name
            command = [compiler(), *FLAGS, *flags, str(source), "-o", str(made), "-lm"]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode:
                raise NoCompiler(done.stderr.strip() or "the C compiler failed")
            made.replace(file)
    return ctypes.CDLL(str(file))


def pointer(array):
    """Address of a contiguous array as a C argument."""
    assert array.flags.c_contiguous
    return array.ctypes.data_as(ctypes.c_void_p)
