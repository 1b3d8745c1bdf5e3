"""Windows, written from its and Python's documentation: never run there, only tested on Linux without what Windows lacks.

Differences to POSIX:

- An open file cannot be renamed, replaced or removed. Files are therefore closed before they get their names; if another program
has
  a file open, the operation is retried for a while, since virus scanners and previews open files briefly, and then reported.
- Locks are mandatory: nobody else can read a locked region. So separate lock files are used, or bytes far beyond the end of a
file.
  There is no way to ask whether a process is alive (`os.kill(pid, 0)` ends it): its lock tells.
- A folder cannot be opened: its entries are those of its path at that moment, and Windows decides when they are on the disk.
- No owner and permissions in the POSIX sense: what is in the user's local data folder belongs to the user by its ACL.
"""

import contextlib
import ctypes
import errno
import msvcrt
import os
import secrets
import signal
import stat
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from rsc.operating_system.shared import UnsafeFolder

assert sys.platform == "win32" or not TYPE_CHECKING

StrPath = str | os.PathLike[str]
CACHES = "LOCALAPPDATA"  # environment variable with the user's local data folder
NEAR_CODE = False  # LLVM's loader of COFF code asks for relative addresses that libraries are beyond, and ends the process
STOPS = (signal.SIGTERM, signal.SIGBREAK)  # signals that ask a process to end (Ctrl-C exists on every system)
SENT_TWICE: tuple[int, ...] = ()  # none of them
LOCKED_BYTE = 2**30  # far beyond the end of a file, where a lock prevents nobody from reading
WAITS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)  # s between attempts at a file that is open elsewhere
ABANDONED = 3600.0  # s since the last write: an unfinished file then counts as abandoned (it is closed briefly before renaming)
LONGEST_PATH = 259  # characters, unless long paths are enabled
IN_USE = "another program has it open, or it may not be written"
_JUNCTION = 0xA0000003  # reparse tag


def open_to_read(path: StrPath) -> int:
    """Open a file for reading and return its descriptor; follows links."""
    return os.open(path, os.O_RDONLY | os.O_BINARY)


def _open(path: Path, flags: int, mode: int) -> int:
    """Open a file that is not a link and return its descriptor."""
    with contextlib.suppress(FileNotFoundError):
        if _is_link(os.lstat(path)):
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    return os.open(path, flags | os.O_BINARY, mode)


def _is_link(status: os.stat_result) -> bool:
    return stat.S_ISLNK(status.st_mode) or getattr(status, "st_reparse_tag", 0) == _JUNCTION


def _patiently(act: Callable[[], object], path: StrPath) -> None:
    """Retry an action for a while that fails as long as another program has the file open; then PermissionError."""
    for wait in (*WAITS, None):
        try:
            act()
            return
        except PermissionError as error:
            if wait is None:
                raise PermissionError(error.errno, IN_USE, os.fspath(path)) from None
            time.sleep(wait)


def lock(handle: int) -> bool | None:
    """Lock an open file exclusively for this process until it is closed: True; False if another process holds the lock, None if
    the file system has no locks."""
    before = os.lseek(handle, 0, os.SEEK_CUR)
    os.lseek(handle, LOCKED_BYTE, os.SEEK_SET)
    try:
        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
    except OSError as error:
        return False if error.errno in (errno.EACCES, errno.EDEADLK) else None
    finally:
        os.lseek(handle, before, os.SEEK_SET)
    return True


def is_own(status: os.stat_result) -> bool:
    """Whether the user owns a file; always True, since its status does not contain the owner."""
    return True


class Folder:
    """A folder; links in it are not followed.

    path : str or path, or the name of a folder inside another one, `within`; linked : bool, whether it may be a link

    All methods raise OSError.
    """

    def __init__(self, path: StrPath, within: "Folder | None" = None, linked: bool = False) -> None:
        self._path: Path = Path(os.path.abspath(path)) if within is None else within._path / path
        status = os.stat(self._path) if linked else os.lstat(self._path)
        if _is_link(status) or not stat.S_ISDIR(status.st_mode):
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(self._path))

    def close(self) -> None:
        """Close the folder."""

    def names(self) -> list[str]:
        """Names of its entries."""
        return os.listdir(self._path)

    def status(self, name: str) -> os.stat_result:
        """Status of an entry; a link is not followed."""
        return os.lstat(self._path / name)

    def make(self, name: str) -> None:
        """Create a folder in it."""
        os.mkdir(self._path / name)

    def open(self, name: str, flags: int = os.O_RDONLY, mode: int = 0o666) -> int:
        """Open a file in it and return its descriptor."""
        return _open(self._path / name, flags, mode)

    def begin(self, name: str) -> BinaryIO | None:
        """Create a file that others see as in use while it is open: they cannot remove it."""
        return open(self.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL), "wb")

    def publish(self, file: BinaryIO, begun: str, name: str) -> None:
        """Close a file from `begin` and give it its final name, replacing an existing file."""
        file.close()
        _patiently(lambda: os.replace(self._path / begun, self._path / name), self._path / name)

    def remove(self, name: str) -> None:
        """Remove a file in it."""
        os.unlink(self._path / name)

    def remove_abandoned(self, name: str) -> None:
        """Remove a file from `begin` unless it may still be in use: OSError if it is open, and a recent one is left alone, since
        it is closed before it gets its name."""
        if time.time() - self.status(name).st_mtime > ABANDONED:
            self.remove(name)

    def sync(self) -> None:
        """Wait until its entries are on the disk; nothing, since Windows has no means for it."""


class Claim:
    """A file that only this process writes until it is published; the claim ends with the process.

    path : Path; status : of the file; held : True, False if another process holds it, None if the file system has no locks

    The lock is on a separate file next to it, which is removed with the claim. Raises OSError.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._lock = path, path.with_name(f"{path.name}.lock")
        self._handle = _open(self._lock, os.O_RDWR | os.O_CREAT, 0o644)
        self.status = os.lstat(path) if os.path.lexists(path) else os.fstat(self._handle)
        self.held = lock(self._handle)

    def publish(self, path: Path) -> None:
        """Flush the file, which nobody else has open, to the disk and give it its final name."""
        handle = _open(self.path, os.O_RDWR, 0o644)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
        _patiently(lambda: os.replace(self.path, path), path)

    def set_aside(self, path: Path) -> None:
        """Give up the claim and rename the file."""
        self.close()
        _patiently(lambda: os.replace(self.path, path), self.path)

    def discard(self) -> None:
        """Remove the file, unless HDF5 still has it open after a failed write."""
        with contextlib.suppress(PermissionError):
            self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Give up the claim."""
        os.close(self._handle)
        with contextlib.suppress(OSError):  # another process has opened it in the meantime
            os.unlink(self._lock)


def remove(path: Path) -> None:
    """Remove a file if it exists."""
    _patiently(lambda: path.unlink(missing_ok=True), path)


def refuse_in_use(path: Path) -> None:
    """OSError if a file cannot be replaced because a program has it open: then renaming it to its own name fails, too."""
    if not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, "it is read-only", str(path))
    _patiently(lambda: os.rename(path, path), path)


def prove_writable(folder: StrPath) -> None:
    """OSError unless a file can be created in a folder; Python's temporary files would try thousands of names."""
    path = Path(folder) / f".rsc-{secrets.token_hex(8)}.probe"
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_BINARY))
    _patiently(lambda: os.unlink(path), path)


def read_at(handle: int, place: int, count: int) -> bytes:
    """`count` bytes of an open file from offset `place`; moves the file position."""
    os.lseek(handle, place, os.SEEK_SET)
    return os.read(handle, count)


def explained(error: OSError) -> str | None:
    """The system's message for an error, or a more specific one for too long paths."""
    name = error.filename
    if isinstance(error, FileNotFoundError) and isinstance(name, (str, os.PathLike)):
        length = len(os.path.abspath(name))
        if length > LONGEST_PATH:
            return f"the path has {length} characters, more than the {LONGEST_PATH} of Windows where long paths are not enabled"
    return error.strerror


def user_caches() -> Path:
    """Local data folder of the user; UnsafeFolder without one."""
    stated = os.environ.get(CACHES, "")
    if not os.path.isabs(stated):
        raise UnsafeFolder(f"{CACHES} does not name an absolute folder")
    return Path(stated)


def own_folder(base: Path, *inside: str) -> Path:
    """A folder below `base` into which nobody but the user can have put anything, created if missing.

    base : Path, absolute, accessible to the user alone by an ACL that its folders inherit; inside : str, nested folders, no links

    Raises UnsafeFolder, which names the folder that fails the check.
    """
    path = Path(os.path.realpath(base))
    try:
        path.mkdir(parents=True, exist_ok=True)
        for name in inside:
            path /= name
            path.mkdir(exist_ok=True)
            if _is_link(os.lstat(path)):
                raise UnsafeFolder(f"{path} is a link")
        prove_writable(path)
    except OSError as error:
        raise UnsafeFolder(f"{path} cannot be used ({error.strerror})") from None
    return path


def processors() -> int:
    """Number of processors that this process may use."""
    return os.cpu_count() or 1


def address_space() -> int | None:
    """Limit of the address space of this process in bytes; None, since Windows has no such limit."""
    return None


class _MemoryStatus(ctypes.Structure):
    """MEMORYSTATUSEX."""

    _fields_ = (
        ("length", ctypes.c_uint32),
        ("load", ctypes.c_uint32),
        *((name, ctypes.c_ulonglong) for name in (
            "total", "available", "total_page_file", "available_page_file", "total_virtual", "available_virtual",
            "available_extended",
        )),
    )  # fmt: skip


def free_memory() -> int | None:
    """Bytes of memory that this process may still allocate; None if the system does not report it."""
    status = _MemoryStatus(length=ctypes.sizeof(_MemoryStatus))
    reported = ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status))
    return min(int(status.available), int(status.available_virtual)) if reported else None


def process_memory() -> tuple[int | None, int | None]:
    """Resident memory of this process in bytes, now and at its peak; not determined on Windows."""
    return None, None


def hdf5_library(extension: str) -> Any:
    """The HDF5 library that h5py has loaded, found by its name."""
    return ctypes.CDLL("hdf5.dll")
