"""Linux and macOS: folders by descriptors, locks that only those see who ask, owners and their rights, limits of a process."""

import contextlib
import ctypes
import fcntl
import os
import resource
import signal
import stat
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from rsc.operating_system.shared import UnsafeFolder

assert sys.platform != "win32" or not TYPE_CHECKING

StrPath = str | os.PathLike[str]
CACHES = "XDG_CACHE_HOME"  # environment variable that names another folder for caches
# signals by which others ask a process to end: a scheduler, a terminal that is closed; Ctrl-C is everywhere
STOPS = (signal.SIGTERM, signal.SIGHUP)
SENT_TWICE = (signal.SIGHUP,)  # of these: by the terminal and by its shell, so that a second one asks for nothing more
# without waiting for the other end of a pipe, and without becoming the process that a terminal sends its signals to
_NO_WAIT = os.O_NONBLOCK | os.O_NOCTTY
_NO_LINK = os.O_NOFOLLOW | _NO_WAIT
_FOLDER = os.O_RDONLY | os.O_DIRECTORY
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
# a folder is opened to be looked at, which needs no right to list it; a link in its place is refused
_LOOK = os.O_DIRECTORY | os.O_NOFOLLOW | getattr(os, "O_PATH", os.O_RDONLY)


def open_to_read(path: StrPath) -> int:
    """A descriptor of a file to be read, also where a link leads to it; a pipe is opened without waiting for its writer."""
    return os.open(path, os.O_RDONLY | _NO_WAIT)


def lock(handle: int) -> bool | None:
    """Hold an open file for this process alone until it is closed: True; False where another one holds it, None where the disk
    has no locks."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


def is_own(status: os.stat_result) -> bool:
    """Whether a file belongs to the user."""
    return status.st_uid == os.geteuid()


class Folder:
    """A folder that is open: names in it stay its own, whatever happens to its path, and no link in it is followed.

    path : str or path, or the name of a folder in another one, `within`; linked : bool, whether it may be reached by a link

    Raises OSError, as does all that is asked of it.
    """

    def __init__(self, path: StrPath, within: "Folder | None" = None, linked: bool = False) -> None:
        flags = _FOLDER if linked else _FOLDER | os.O_NOFOLLOW
        self._handle: int = os.open(path, flags, dir_fd=None if within is None else within._handle)

    def close(self) -> None:
        """Let go of it."""
        os.close(self._handle)

    def names(self) -> list[str]:
        """The names in it."""
        return os.listdir(self._handle)

    def status(self, name: str) -> os.stat_result:
        """Of what a name stands for, a link itself."""
        return os.stat(name, dir_fd=self._handle, follow_symlinks=False)

    def make(self, name: str) -> None:
        """Make a folder in it."""
        os.mkdir(name, dir_fd=self._handle)

    def open(self, name: str, flags: int = os.O_RDONLY, mode: int = 0o666) -> int:
        """A descriptor of a file in it."""
        return os.open(name, flags | _NO_LINK, mode, dir_fd=self._handle)

    def begin(self, name: str) -> BinaryIO | None:
        """A new file that others see to be in work as long as it is open; None where one was quicker, and removes it."""
        handle = self.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL)
        if lock(handle) is not False and os.fstat(handle).st_nlink:
            return open(handle, "wb")
        os.close(handle)
        return None

    def publish(self, file: BinaryIO, begun: str, name: str) -> None:
        """Give a file that was begun its name, in the place of what has it; the file is closed."""
        with file:
            os.replace(begun, name, src_dir_fd=self._handle, dst_dir_fd=self._handle)

    def remove(self, name: str) -> None:
        """Remove a file in it."""
        os.unlink(name, dir_fd=self._handle)

    def remove_abandoned(self, name: str) -> None:
        """Remove a file that was begun, unless it may be in work."""
        handle = self.open(name, os.O_RDWR)
        try:
            if lock(handle):
                self.remove(name)
        finally:
            os.close(handle)

    def sync(self) -> None:
        """Wait until its names are on the disk."""
        os.fsync(self._handle)


class Claim:
    """A file that this process alone writes until it is published; the claim ends with the process.

    path : Path; status : of the file; held : True, False where another process holds it, None where the disk has no locks

    Raises OSError.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT | _NO_LINK, 0o644)
        self.status = os.fstat(self._handle)
        self.held = lock(self._handle)

    def publish(self, path: Path) -> None:
        """Give the file, which nobody else has open any more, its name, once it is on the disk."""
        os.fsync(self._handle)
        os.replace(self.path, path)
        folder = os.open(path.resolve().parent, os.O_RDONLY)
        os.fsync(folder)
        os.close(folder)

    def set_aside(self, path: Path) -> None:
        """Give up the claim and the file another name."""
        self.close()
        os.replace(self.path, path)

    def discard(self) -> None:
        """Remove the file."""
        self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Give up the claim."""
        os.close(self._handle)


def remove(path: Path) -> None:
    """Remove a file if it is there."""
    path.unlink(missing_ok=True)


def refuse_in_use(path: Path) -> None:
    """OSError where a file could not be replaced because a program has it open: never."""


def prove_writable(folder: StrPath) -> None:
    """OSError unless a file can be written into a folder."""
    with tempfile.TemporaryFile(dir=folder):
        pass


def read_at(handle: int, place: int, count: int) -> bytes:
    """So many bytes of an open file from a place on."""
    return os.pread(handle, count, place)


def explained(error: OSError) -> str | None:
    """What the system says of an error."""
    return error.strerror


def user_caches() -> Path:
    """Folder of the user's caches; UnsafeFolder without a home."""
    stated = os.environ.get(CACHES, "")
    if os.path.isabs(stated):  # another one is to be ignored
        return Path(stated)
    try:
        home = Path.home()
    except RuntimeError:  # a user without a name
        home = Path()
    if not home.is_absolute():
        raise UnsafeFolder("there is no home folder")
    return home / ".cache"


def own_folder(base: Path, *inside: str) -> Path:
    """A folder below `base` into which nobody but the user can have put anything, made where it is missing.

    Every folder on the way from the root is opened without following a link and looked at as it was opened. Those down to `base`
    must belong to the user or to root, and others may not write them, but for those with a sticky bit (/tmp), where nobody
    renames what belongs to the user. What is checked so stays what it is: only its owner can put another in its place.

    Parameters
    ----------
    base : Path
        Absolute; links on the way to it are followed before the check.
    inside : str
        Folders in one another below it: the user's, not to be written by others; no links.

    Raises
    ------
    UnsafeFolder
        With the folder that stands against it.
    """
    above = Path(os.path.realpath(base)).parts
    path, handle = Path(above[0]), None
    with contextlib.ExitStack() as opened:
        for i, name in enumerate((*above, *inside)):
            path /= name
            handle = _entered(handle, name, path)
            opened.callback(os.close, handle)
            _refuse_foreign(handle, path, own=i >= len(above))
    try:
        prove_writable(path)
    except OSError as error:
        raise UnsafeFolder(f"{path} cannot be written ({error.strerror})") from None
    return path


def _entered(handle: int | None, name: str, path: Path) -> int:
    """A descriptor of a folder inside an open one (None: of the root), made when it is missing."""
    try:
        with contextlib.suppress(FileNotFoundError):
            return os.open(name, _LOOK, dir_fd=handle)
        with contextlib.suppress(FileExistsError):  # another process was quicker
            os.mkdir(name, 0o700, dir_fd=handle)
        return os.open(name, _LOOK, dir_fd=handle)
    except OSError as error:
        problem = "is a link" if os.path.islink(path) else f"cannot be used ({error.strerror})"
        raise UnsafeFolder(f"{path} {problem}") from None


def _refuse_foreign(handle: int, path: Path, own: bool) -> None:
    """UnsafeFolder where somebody else owns an open folder or may write it; `own`: it must be the user's and is never shared."""
    status = os.fstat(handle)
    if status.st_uid not in ((os.geteuid(),) if own else (0, os.geteuid())):
        raise UnsafeFolder(f"{path} belongs to another user")
    sticky = not own and status.st_mode & stat.S_ISVTX
    if status.st_mode & _OTHERS_WRITE and not sticky:
        raise UnsafeFolder(f"{path} may be written by others (chmod go-w would mend that)")


def processors() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def address_space() -> int | None:
    """Bytes of address space that this process may take (ulimit -v), or None without a limit."""
    allowed = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if allowed == resource.RLIM_INFINITY else allowed


def free_memory() -> int | None:
    """Bytes of memory that this process may still take, or None where the system does not tell: what is free, or what its limit
    of address space leaves where that is less."""
    free, allowed = _proc("/proc/meminfo", "MemAvailable:")[0], address_space()
    if allowed is None:
        return free
    left = max(allowed - (_proc("/proc/self/status", "VmSize:")[0] or 0), 0)
    return left if free is None else min(free, left)


def process_memory() -> tuple[int | None, int | None]:
    """Bytes of memory that this process holds, and the most that it has held; None where the system does not tell."""
    held, peak = _proc("/proc/self/status", "VmRSS:", "VmHWM:")
    return held, peak


def _proc(file: str, *keys: str) -> list[int | None]:
    """Bytes that the lines of the given keys state in a file of the operating system; None for a key that is missing."""
    try:
        lines = Path(file).read_text().splitlines()
    except OSError:
        return [None] * len(keys)
    return [next((int(line.split()[1]) * 1024 for line in lines if line.startswith(key)), None) for key in keys]


def hdf5_library(extension: str) -> ctypes.CDLL:
    """The HDF5 library that a module of h5py is linked to, by the file of the module."""
    return ctypes.CDLL(extension)
