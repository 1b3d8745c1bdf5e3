"""Files written as a whole, into folders that others may write too: a name stands for all of a file or does not exist.

Content goes into a new file of a random name in the same folder, which takes its name once all of it is on the disk. Links are
neither followed nor replaced. Whoever writes holds a lock on his private file: what nobody holds was left by a process that died,
and the next one removes it.
"""

import contextlib
import fcntl
import os
import re
import secrets
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import BinaryIO

from rsc.errors import DataError, one_line
from rsc.files.content import unusable

_FOLDER = os.O_RDONLY | os.O_DIRECTORY
# of a file in such a folder: no link, no waiting for the other end of a pipe, no terminal that sends its signals
NO_LINK = os.O_NOFOLLOW | os.O_NONBLOCK | os.O_NOCTTY
_PRIVATE = re.compile(r"\.rsc-[0-9a-f]{16}\.part")
_KINDS = (
    (stat.S_ISDIR, "is a directory"),
    (stat.S_ISLNK, "is a link"),
    (stat.S_ISFIFO, "is a pipe"),
    (stat.S_ISCHR, "is a device"),
    (stat.S_ISBLK, "is a device"),
)


@contextlib.contextmanager
def entered(path: str | os.PathLike[str], make: bool = False) -> Iterator[int]:
    """A descriptor of a folder that is no link, made when missing if asked for; DataError when it cannot be entered."""
    with contextlib.ExitStack() as left:
        try:
            if make:
                os.makedirs(path, exist_ok=True)
            folder = os.open(path, _FOLDER | os.O_NOFOLLOW)
            left.callback(os.close, folder)
        except (OSError, ValueError) as error:
            raise DataError(one_line(path), f"cannot be used ({_reason(path, error)})") from None
        yield folder


@contextlib.contextmanager
def inside(folder: int, name: str, path: Path, make: bool = False) -> Iterator[int]:
    """As `entered`, of a folder of this name in an open one; path: for messages."""
    with contextlib.ExitStack() as left:
        try:
            if make:
                with contextlib.suppress(FileExistsError):
                    os.mkdir(name, dir_fd=folder)
            handle = os.open(name, _FOLDER | os.O_NOFOLLOW, dir_fd=folder)
            left.callback(os.close, handle)
        except OSError as error:
            raise DataError(one_line(path), f"cannot be used ({_reason(path, error)})") from None
        yield handle


def _reason(path: str | os.PathLike[str], error: OSError | ValueError) -> str:
    """Why a folder cannot be entered; the system says of a link that it is no directory."""
    linked = not isinstance(error, ValueError) and os.path.islink(path)
    return "it is a link" if linked else unusable(error)


def kind_of(status: os.stat_result) -> str:
    """What a name stands for, in words; "" for a regular file."""
    return "" if stat.S_ISREG(status.st_mode) else next((w for fits, w in _KINDS if fits(status.st_mode)), "is no regular file")


def is_file(folder: int, name: str) -> bool:
    """Whether a name in an open folder is that of a regular file; a link to one is none."""
    with contextlib.suppress(OSError, ValueError):
        return stat.S_ISREG(os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode)
    return False


def is_private(name: str) -> bool:
    """Whether a file has the name of one that is not yet whole."""
    return bool(_PRIVATE.fullmatch(name))


def refuse_special(folder: int, name: str) -> None:
    """OSError for a name in an open folder that is neither new nor that of a regular file."""
    with contextlib.suppress(FileNotFoundError):
        if what := kind_of(os.stat(name, dir_fd=folder, follow_symlinks=False)):
            raise OSError(None, f"it {what}, which is not replaced")


def write_whole(folder: int, name: str, content: Iterable[bytes | memoryview], synced: bool = True) -> None:
    """Write a file into an open folder; where that fails nothing is left behind.

    synced : bool, wait until it is on the disk

    Raises OSError.
    """
    refuse_special(folder, name)
    private, file = _private(folder)
    try:
        with file:
            for piece in content:
                file.write(piece)
            file.flush()
            if synced:
                os.fsync(file.fileno())
            os.replace(private, name, src_dir_fd=folder, dst_dir_fd=folder)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(private, dir_fd=folder)
        raise
    if synced:
        os.fsync(folder)


def _private(folder: int) -> tuple[str, BinaryIO]:
    """A new file of a name that nobody can guess, locked."""
    while True:
        name = f".rsc-{secrets.token_hex(8)}.part"
        handle = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL | NO_LINK, 0o666, dir_fd=folder)
        if _hold(handle) and os.fstat(handle).st_nlink:
            return name, open(handle, "wb")
        os.close(handle)  # another process saw it before it was locked, and removes it


def _hold(handle: int) -> bool:
    """Lock an open file; False where another process holds it. On a disk without locks nobody does, and nothing is removed."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True


def clear_abandoned(folder: int) -> None:
    """Remove the private files in an open folder that processes left which died, as far as their lock tells."""
    for entry in os.listdir(folder):
        if not is_private(entry) or not is_file(folder, entry):
            continue
        with contextlib.suppress(OSError):
            handle = os.open(entry, os.O_RDWR | NO_LINK, dir_fd=folder)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                os.unlink(entry, dir_fd=folder)
            finally:
                os.close(handle)
