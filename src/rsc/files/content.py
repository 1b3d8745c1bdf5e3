"""Opening of files named by users: only regular files, up to a size limit."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

from rsc.errors import DataError, one_line
from rsc.operating_system import Folder, explained, open_to_read


@contextmanager
def opened(path: str | os.PathLike[str], most: int, folder: Folder | None = None) -> Iterator[BinaryIO]:
    """Open a regular file for reading.

    It is checked before it is opened, since opening a device can have effects, and again once open, since the name may have been
    reassigned. A pipe is opened without waiting for a writer, so that no name can make the program hang.

    Parameters
    ----------
    path : str or path
    most : int
        Largest size in bytes.
    folder : Folder, optional
        Folder in which the last component of `path` is opened, without following links.

    Raises
    ------
    DataError
        Not readable, not a regular file, or larger.
    """
    name = path if folder is None else os.path.basename(path)
    try:
        refuse_special(path, os.stat(path) if folder is None else folder.status(os.path.basename(path)))
        file = open(name, "rb", opener=lambda name, _: (folder.open if folder else open_to_read)(name))  # noqa: SIM115 (below)
    except (OSError, ValueError) as error:
        raise DataError(one_line(path), unusable(error)) from None
    with file:
        status = os.fstat(file.fileno())
        refuse_special(path, status)
        if status.st_size > most:
            raise DataError(one_line(path), _too_large(f"{status.st_size / 2**20:.0f} MB", most))
        yield file


def content_of(path: str | os.PathLike[str], most: int, folder: Folder | None = None) -> bytes:
    """All bytes of a regular file; arguments and errors as `opened`.

    No more is read than the cap, also of a file that grows meanwhile or does not tell its size, as those of /proc.
    """
    with opened(path, most, folder) as file:
        parts, read = [], 0
        try:
            while part := file.read(max(os.fstat(file.fileno()).st_size, 4096)):
                parts.append(part)
                read += len(part)
                if read > most:
                    raise DataError(one_line(path), _too_large("more than it tells", most))
        except OSError as error:
            raise DataError(one_line(path), unusable(error)) from None
        return b"".join(parts)


def refuse_special(path: str | os.PathLike[str], status: os.stat_result) -> None:
    """DataError unless the status is that of a regular file."""
    if not stat.S_ISREG(status.st_mode):
        raise DataError(one_line(path), "is a directory" if stat.S_ISDIR(status.st_mode) else "not a regular file")


def unusable(error: OSError | ValueError) -> str:
    """Why a name cannot be used, as text; a ValueError means a name with a null byte."""
    return one_line((isinstance(error, OSError) and explained(error)) or error).lower()


def _too_large(size: str, most: int) -> str:
    return f"the file has {size}; at most {most // 2**20} MB are read"
