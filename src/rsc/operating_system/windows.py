"""Windows, as its documentation and Python's describe it: it was never run there, only on Linux without what Windows lacks.

What is different there:

- An open file cannot be renamed, replaced or removed by anybody. So files are closed before they take their names; one that
  another program has open is tried for a while, since virus scanners and previews hold files for moments, and then told.
- Locks are mandatory: what is locked nobody else can read. So locks lie on files of their own, behind all that these hold. There
  is no way to ask whether a process lives (`os.kill(pid, 0)` ends it): its lock tells.
- A folder cannot be opened: its names are those of its path at that moment, and they are on the disk when Windows sees to it.
- No owner and no rights of a file as POSIX knows them: what lies in the folder of the user's own data is the user's by its ACL.
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
CACHES = "LOCALAPPDATA"  # environment variable that names the folder of the user's own data on this machine
STOPS = (signal.SIGTERM, signal.SIGBREAK)  # signals by which others ask a process to end; Ctrl-C is everywhere
SENT_TWICE: tuple[int, ...] = ()  # none of them
LOCKED_BYTE = 2**30  # far behind the end of a file, where a lock keeps nobody from reading
WAITS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)  # s between attempts at a file that is open somewhere
ABANDONED = 3600.0  # s after the last write to a file that was begun; it is closed only for a moment before it takes its name
LONGEST_PATH = 259  # characters, where long paths are not enabled
IN_USE = "another program has it open, or it may not be written"
_JUNCTION = 0xA0000003  # reparse tag


def open_to_read(path: StrPath) -> int:
    """A descriptor of a file to be read, also where a link leads to it."""
    return os.open(path, os.O_RDONLY | os.O_BINARY)


def _open(path: Path, flags: int, mode: int) -> int:
    """A descriptor of a file that is no link."""
    with contextlib.suppress(FileNotFoundError):
        if _is_link(os.lstat(path)):
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    return os.open(path, flags | os.O_BINARY, mode)


def _is_link(status: os.stat_result) -> bool:
    return stat.S_ISLNK(status.st_mode) or getattr(status, "st_reparse_tag", 0) == _JUNCTION


def _patiently(act: Callable[[], object], path: StrPath) -> None:
    """Do what a program that has a file open keeps from being done, again and again for a while; then OSError says so."""
    for wait in (*WAITS, None):
        try:
            act()
            return
        except PermissionError as error:
            if wait is None:
                raise PermissionError(error.errno, IN_USE, os.fspath(path)) from None
            time.sleep(wait)


def lock(handle: int) -> bool | None:
    """Hold an open file for this process alone until it is closed: True; False where another one holds it, None where the disk
    has no locks."""
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
    """Whether a file belongs to the user, as far as its status tells: Windows keeps that elsewhere."""
    return True


class Folder:
    """A folder; no link in it is followed.

    path : str or path, or the name of a folder in another one, `within`; linked : bool, whether it may be reached by a link

    Raises OSError, as does all that is asked of it.
    """

    def __init__(self, path: StrPath, within: "Folder | None" = None, linked: bool = False) -> None:
        self._path: Path = Path(os.path.abspath(path)) if within is None else within._path / path
        status = os.stat(self._path) if linked else os.lstat(self._path)
        if _is_link(status) or not stat.S_ISDIR(status.st_mode):
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(self._path))

    def close(self) -> None:
        """Let go of it."""

    def names(self) -> list[str]:
        """The names in it."""
        return os.listdir(self._path)

    def status(self, name: str) -> os.stat_result:
        """Of what a name stands for, a link itself."""
        return os.lstat(self._path / name)

    def make(self, name: str) -> None:
        """Make a folder in it."""
        os.mkdir(self._path / name)

    def open(self, name: str, flags: int = os.O_RDONLY, mode: int = 0o666) -> int:
        """A descriptor of a file in it."""
        return _open(self._path / name, flags, mode)

    def begin(self, name: str) -> BinaryIO | None:
        """A new file that others see to be in work as long as it is open: they cannot remove it."""
        return open(self.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL), "wb")

    def publish(self, file: BinaryIO, begun: str, name: str) -> None:
        """Give a file that was begun its name, in the place of what has it; the file is closed."""
        file.close()
        _patiently(lambda: os.replace(self._path / begun, self._path / name), self._path / name)

    def remove(self, name: str) -> None:
        """Remove a file in it."""
        os.unlink(self._path / name)

    def remove_abandoned(self, name: str) -> None:
        """Remove a file that was begun, unless it may be in work: OSError where it is open, and a new one is left alone, since it
        is closed before it takes its name."""
        if time.time() - self.status(name).st_mtime > ABANDONED:
            self.remove(name)

    def sync(self) -> None:
        """Wait until its names are on the disk, for which Windows has no way."""


class Claim:
    """A file that this process alone writes until it is published; the claim ends with the process.

    path : Path; status : of the file; held : True, False where another process holds it, None where the disk has no locks

    The lock lies on a file beside it, which is removed with the claim. Raises OSError.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._lock = path, path.with_name(f"{path.name}.lock")
        self._handle = _open(self._lock, os.O_RDWR | os.O_CREAT, 0o644)
        self.status = os.lstat(path) if os.path.lexists(path) else os.fstat(self._handle)
        self.held = lock(self._handle)

    def publish(self, path: Path) -> None:
        """Give the file, which nobody else has open any more, its name, once it is on the disk."""
        handle = _open(self.path, os.O_RDWR, 0o644)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
        _patiently(lambda: os.replace(self.path, path), path)

    def set_aside(self, path: Path) -> None:
        """Give up the claim and the file another name."""
        self.close()
        _patiently(lambda: os.replace(self.path, path), self.path)

    def discard(self) -> None:
        """Remove the file; after a failed write HDF5 keeps it open, and an empty one stays."""
        with contextlib.suppress(PermissionError):
            self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Give up the claim."""
        os.close(self._handle)
        with contextlib.suppress(OSError):  # another process has opened it meanwhile
            os.unlink(self._lock)


def remove(path: Path) -> None:
    """Remove a file if it is there."""
    _patiently(lambda: path.unlink(missing_ok=True), path)


def refuse_in_use(path: Path) -> None:
    """OSError where a file could not be replaced because a program has it open: then it cannot take its own name either."""
    if not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, "it is read-only", str(path))
    _patiently(lambda: os.rename(path, path), path)


def prove_writable(folder: StrPath) -> None:
    """OSError unless a file can be written into a folder; Python's own temporary files would try thousands of names."""
    path = Path(folder) / f".rsc-{secrets.token_hex(8)}.probe"
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_BINARY))
    _patiently(lambda: os.unlink(path), path)


def read_at(handle: int, place: int, count: int) -> bytes:
    """So many bytes of an open file from a place on, which moves there."""
    os.lseek(handle, place, os.SEEK_SET)
    return os.read(handle, count)


def explained(error: OSError) -> str | None:
    """What the system says of an error, or what is meant where it tells less."""
    name = error.filename
    if isinstance(error, FileNotFoundError) and isinstance(name, (str, os.PathLike)):
        length = len(os.path.abspath(name))
        if length > LONGEST_PATH:
            return f"the path has {length} characters, more than the {LONGEST_PATH} of Windows where long paths are not enabled"
    return error.strerror


def user_caches() -> Path:
    """Folder of the user's own data on this machine; UnsafeFolder without one."""
    stated = os.environ.get(CACHES, "")
    if not os.path.isabs(stated):
        raise UnsafeFolder(f"{CACHES} names no folder")
    return Path(stated)


def own_folder(base: Path, *inside: str) -> Path:
    """A folder below `base` into which nobody but the user can have put anything, made where it is missing.

    base : Path, absolute, the user's alone by its ACL, which folders below it inherit; inside : str, no links

    Raises UnsafeFolder with the folder that stands against it.
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
    """Processors that this process may use."""
    return os.cpu_count() or 1


def address_space() -> int | None:
    """Bytes of address space that this process may take, or None without a limit."""
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
    """Bytes of memory that this process may still take, or None where the system does not tell."""
    status = _MemoryStatus(length=ctypes.sizeof(_MemoryStatus))
    told = ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status))
    return min(int(status.available), int(status.available_virtual)) if told else None


def process_memory() -> tuple[int | None, int | None]:
    """Bytes of memory that this process holds, and the most that it has held: not asked for."""
    return None, None


def hdf5_library(extension: str) -> Any:
    """The HDF5 library that h5py has loaded, which goes by its name."""
    return ctypes.CDLL("hdf5.dll")
