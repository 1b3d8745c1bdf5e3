"""Linux and macOS: folders by file descriptors, advisory locks, owners and permissions, resource limits."""

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
CACHES = "XDG_CACHE_HOME"  # environment variable with an alternative cache folder
# signals that ask a process to end, from a scheduler or a closed terminal (Ctrl-C exists on every system)
NEAR_CODE = True  # compiled code may be laid out so that all it calls is within reach of a relative address
STOPS = (signal.SIGTERM, signal.SIGHUP)
SENT_TWICE = (signal.SIGHUP,)  # sent by both terminal and shell: a second one means nothing new
# neither wait for the other end of a pipe nor make a terminal the controlling one
_NO_WAIT = os.O_NONBLOCK | os.O_NOCTTY
_NO_LINK = os.O_NOFOLLOW | _NO_WAIT
_FOLDER = os.O_RDONLY | os.O_DIRECTORY
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
# open a folder for inspection only, which needs no permission to list it; links are refused
_LOOK = os.O_DIRECTORY | os.O_NOFOLLOW | getattr(os, "O_PATH", os.O_RDONLY)


def open_to_read(path: StrPath) -> int:
    """Open a file for reading and return its descriptor; follows links, does not wait for the writer of a pipe."""
    return os.open(path, os.O_RDONLY | _NO_WAIT)


def lock(handle: int) -> bool | None:
    """Lock an open file exclusively for this process until it is closed: True; False if another process holds the lock, None if
    the file system has no locks."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


def is_own(status: os.stat_result) -> bool:
    """Whether the user owns a file."""
    return status.st_uid == os.geteuid()


class Folder:
    """An open folder: names in it refer to the same folder whatever happens to its path, and links in it are not followed.

    path : str or path, or the name of a folder inside another one, `within`; linked : bool, whether it may be a link

    All methods raise OSError.
    """

    def __init__(self, path: StrPath, within: "Folder | None" = None, linked: bool = False) -> None:
        flags = _FOLDER if linked else _FOLDER | os.O_NOFOLLOW
        self._handle: int = os.open(path, flags, dir_fd=None if within is None else within._handle)

    def close(self) -> None:
        """Close the folder."""
        os.close(self._handle)

    def names(self) -> list[str]:
        """Names of its entries."""
        return os.listdir(self._handle)

    def status(self, name: str) -> os.stat_result:
        """Status of an entry; a link is not followed."""
        return os.stat(name, dir_fd=self._handle, follow_symlinks=False)

    def make(self, name: str) -> None:
        """Create a folder in it."""
        os.mkdir(name, dir_fd=self._handle)

    def open(self, name: str, flags: int = os.O_RDONLY, mode: int = 0o666) -> int:
        """Open a file in it and return its descriptor."""
        return os.open(name, flags | _NO_LINK, mode, dir_fd=self._handle)

    def begin(self, name: str) -> BinaryIO | None:
        """Create a file that others see as in use while it is open; None if another process has already begun to remove it."""
        handle = self.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL)
        if lock(handle) is not False and os.fstat(handle).st_nlink:
            return open(handle, "wb")
        os.close(handle)
        return None

    def publish(self, file: BinaryIO, begun: str, name: str) -> None:
        """Close a file from `begin` and give it its final name, replacing an existing file."""
        with file:
            os.replace(begun, name, src_dir_fd=self._handle, dst_dir_fd=self._handle)

    def remove(self, name: str) -> None:
        """Remove a file in it."""
        os.unlink(name, dir_fd=self._handle)

    def remove_abandoned(self, name: str) -> None:
        """Remove a file from `begin` unless it may still be in use."""
        handle = self.open(name, os.O_RDWR)
        try:
            if lock(handle):
                self.remove(name)
        finally:
            os.close(handle)

    def sync(self) -> None:
        """Wait until its entries are on the disk."""
        os.fsync(self._handle)


class Claim:
    """A file that only this process writes until it is published; the claim ends with the process.

    path : Path; status : of the file; held : True, False if another process holds it, None if the file system has no locks

    Raises OSError.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT | _NO_LINK, 0o644)
        self.status = os.fstat(self._handle)
        self.held = lock(self._handle)

    def publish(self, path: Path) -> None:
        """Flush the file, which nobody else has open, to the disk and give it its final name."""
        os.fsync(self._handle)
        os.replace(self.path, path)
        folder = os.open(path.resolve().parent, os.O_RDONLY)
        os.fsync(folder)
        os.close(folder)

    def set_aside(self, path: Path) -> None:
        """Give up the claim and rename the file."""
        self.close()
        os.replace(self.path, path)

    def discard(self) -> None:
        """Remove the file."""
        self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Give up the claim."""
        os.close(self._handle)


def remove(path: Path) -> None:
    """Remove a file if it exists."""
    path.unlink(missing_ok=True)


def refuse_in_use(path: Path) -> None:
    """OSError if a file cannot be replaced because a program has it open; on POSIX never."""


def prove_writable(folder: StrPath) -> None:
    """OSError unless a file can be created in a folder."""
    with tempfile.TemporaryFile(dir=folder):
        pass


def read_at(handle: int, place: int, count: int) -> bytes:
    """`count` bytes of an open file from offset `place`."""
    return os.pread(handle, count, place)


def explained(error: OSError) -> str | None:
    """The system's message for an error."""
    return error.strerror


def user_caches() -> Path:
    """Cache folder of the user; UnsafeFolder without a home folder."""
    stated = os.environ.get(CACHES, "")
    if os.path.isabs(stated):  # the XDG specification says to ignore relative paths
        return Path(stated)
    try:
        home = Path.home()
    except RuntimeError:  # a user without an account name
        home = Path()
    if not home.is_absolute():
        raise UnsafeFolder("there is no home folder")
    return home / ".cache"


def own_folder(base: Path, *inside: str) -> Path:
    """A folder below `base` into which nobody but the user can have put anything, created if missing.

    Every folder on the path from the root is opened without following links and checked while open. Folders down to `base` must
    belong to the user or root and must not be writable by others, except with the sticky bit (/tmp), where nobody can rename the
    user's files. A checked folder cannot be swapped afterwards: only its owner can replace it.
    Parameters
    ----------
    base : Path
        Absolute; links in it are resolved before the check.
    inside : str
        Nested folders below it, which must belong to the user, not be writable by others and not be links.

    Raises
    ------
    UnsafeFolder
        Names the folder that fails the check.
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
    """Open a folder inside an open one (None: the root), creating it if missing, and return its descriptor."""
    try:
        with contextlib.suppress(FileNotFoundError):
            return os.open(name, _LOOK, dir_fd=handle)
        with contextlib.suppress(FileExistsError):  # another process has just created it
            os.mkdir(name, 0o700, dir_fd=handle)
        return os.open(name, _LOOK, dir_fd=handle)
    except OSError as error:
        problem = "is a link" if os.path.islink(path) else f"cannot be used ({error.strerror})"
        raise UnsafeFolder(f"{path} {problem}") from None


def _refuse_foreign(handle: int, path: Path, own: bool) -> None:
    """UnsafeFolder if others own or may write an open folder; own: it must belong to the user, and no sticky bit excuses it."""
    status = os.fstat(handle)
    if status.st_uid not in ((os.geteuid(),) if own else (0, os.geteuid())):
        raise UnsafeFolder(f"{path} belongs to another user")
    sticky = not own and status.st_mode & stat.S_ISVTX
    if status.st_mode & _OTHERS_WRITE and not sticky:
        raise UnsafeFolder(f"{path} may be written by others (chmod go-w would fix that)")


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def address_space() -> int | None:
    """Limit of the address space of this process in bytes (ulimit -v), None without a limit."""
    allowed = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if allowed == resource.RLIM_INFINITY else allowed


def free_memory() -> int | None:
    """Bytes of memory that this process may still allocate: free memory, or less if the limit of the address space leaves less;
    None if the system does not report it."""
    free, allowed = _proc("/proc/meminfo", "MemAvailable:")[0], address_space()
    if allowed is None:
        return free
    left = max(allowed - (_proc("/proc/self/status", "VmSize:")[0] or 0), 0)
    return left if free is None else min(free, left)


def process_memory() -> tuple[int | None, int | None]:
    """Resident memory of this process in bytes, now and at its peak; None where the system does not report it."""
    held, peak = _proc("/proc/self/status", "VmRSS:", "VmHWM:")
    return held, peak


def _proc(file: str, *keys: str) -> list[int | None]:
    """Values in bytes of the given keys in a /proc file; None for a missing key."""
    try:
        lines = Path(file).read_text().splitlines()
    except OSError:
        return [None] * len(keys)
    return [next((int(line.split()[1]) * 1024 for line in lines if line.startswith(key)), None) for key in keys]


def hdf5_library(extension: str) -> ctypes.CDLL:
    """The HDF5 library that an extension module of h5py is linked to, loaded via that module's file."""
    return ctypes.CDLL(extension)
