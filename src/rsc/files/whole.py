"""Atomic writing of files, also in folders that others may write: a file name exists only with complete content.

Content is written to a new file with a random name in the same folder, which is renamed once it is on the disk. Links are neither
followed nor replaced. The writer holds a lock on its private file: a file without lock was left by a process that died, and is
removed by the next one.
"""

import contextlib
import os
import re
import secrets
import stat
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import BinaryIO

from rsc.errors import DataError, one_line
from rsc.files.content import unusable
from rsc.operating_system import Folder

_PRIVATE = re.compile(r"\.rsc-[0-9a-f]{16}\.part")
_KINDS = (
    (stat.S_ISDIR, "is a directory"),
    (stat.S_ISLNK, "is a link"),
    (stat.S_ISFIFO, "is a pipe"),
    (stat.S_ISCHR, "is a device"),
    (stat.S_ISBLK, "is a device"),
)


@contextlib.contextmanager
def entered(path: str | os.PathLike[str], make: bool = False) -> Iterator[Folder]:
    """A folder that is no link, open, made when missing if asked for; DataError when it cannot be entered."""
    with contextlib.ExitStack() as left:
        try:
            if make:
                os.makedirs(path, exist_ok=True)
            folder = left.enter_context(contextlib.closing(Folder(path)))
        except (OSError, ValueError) as error:
            raise DataError(one_line(path), f"cannot be used ({_reason(path, error)})") from None
        yield folder


@contextlib.contextmanager
def inside(folder: Folder, name: str, path: Path, make: bool = False) -> Iterator[Folder]:
    """As `entered`, of a folder of this name in an open one; path: for messages."""
    with contextlib.ExitStack() as left:
        try:
            if make:
                with contextlib.suppress(FileExistsError):
                    folder.make(name)
            inner = left.enter_context(contextlib.closing(Folder(name, within=folder)))
        except OSError as error:
            raise DataError(one_line(path), f"cannot be used ({_reason(path, error)})") from None
        yield inner


def _reason(path: str | os.PathLike[str], error: OSError | ValueError) -> str:
    """Why a folder cannot be entered; the system says of a link that it is no directory."""
    linked = not isinstance(error, ValueError) and os.path.islink(path)
    return "it is a link" if linked else unusable(error)


def kind_of(status: os.stat_result) -> str:
    """What a name stands for, in words; "" for a regular file."""
    return "" if stat.S_ISREG(status.st_mode) else next((w for fits, w in _KINDS if fits(status.st_mode)), "is no regular file")


def is_file(folder: Folder, name: str) -> bool:
    """Whether a name in an open folder is that of a regular file; a link to one is none."""
    with contextlib.suppress(OSError, ValueError):
        return stat.S_ISREG(folder.status(name).st_mode)
    return False


def is_private(name: str) -> bool:
    """Whether a file has the name of one that is not yet whole."""
    return bool(_PRIVATE.fullmatch(name))


def refuse_special(folder: Folder, name: str) -> None:
    """OSError for a name in an open folder that is neither new nor that of a regular file."""
    with contextlib.suppress(FileNotFoundError):
        if what := kind_of(folder.status(name)):
            raise OSError(None, f"it {what}, which is not replaced")


def write_whole(folder: Folder, name: str, content: Iterable[bytes | memoryview], synced: bool = True) -> None:
    """Write a file into an open folder; where that fails nothing is left behind.

    synced : bool, wait until it is on the disk

    Raises OSError.
    """
    with staged(folder, name, content, synced) as publish:
        publish()
    if synced:
        folder.sync()


@contextlib.contextmanager
def staged(folder: Folder, name: str, content: Iterable[bytes | memoryview], synced: bool) -> Iterator[Callable[[], None]]:
    """Yield a function that gives a file, which is written already under a private name, its own; without that nothing is left
    behind. Arguments and errors as `write_whole`."""
    refuse_special(folder, name)
    private, file = _private(folder)
    try:
        with file:
            for piece in content:
                file.write(piece)
            file.flush()
            if synced:
                os.fsync(file.fileno())
            yield lambda: folder.publish(file, private, name)
    except BaseException:
        with contextlib.suppress(OSError):
            folder.remove(private)
        raise


def _private(folder: Folder) -> tuple[str, BinaryIO]:
    """A new file of a name that nobody can guess, in work."""
    while True:
        name = f".rsc-{secrets.token_hex(8)}.part"
        if file := folder.begin(name):
            return name, file


def clear_abandoned(folder: Folder) -> None:
    """Remove the private files in an open folder that processes left which died, as far as can be told."""
    for entry in folder.names():
        if is_private(entry) and is_file(folder, entry):
            with contextlib.suppress(OSError):
                folder.remove_abandoned(entry)
