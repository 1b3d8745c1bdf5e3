"""Files that others name: only regular ones are opened, and none larger than a cap."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from rsc.errors import DataError, one_line


@contextmanager
def opened(path: str | os.PathLike[str], most: int) -> Iterator[BinaryIO]:
    """A regular file, open for reading.

    A pipe is opened without waiting for a writer and then refused, so that no name can make the program hang.

    Parameters
    ----------
    path : str or path
    most : int
        Largest size in bytes.

    Raises
    ------
    DataError
        Not readable, not a regular file, or larger.
    """
    name = one_line(path)
    try:
        handle = os.open(Path(path), os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except (OSError, ValueError) as error:  # ValueError: a name with a zero byte
        raise DataError(name, one_line(getattr(error, "strerror", None) or "not readable").lower()) from None
    with _regular(handle, name) as file:
        size = os.fstat(file.fileno()).st_size
        if size > most:
            raise DataError(name, f"the file has {size / 2**20:.0f} MB; at most {most // 2**20} MB are read")
        yield file


def _regular(handle, name):
    try:
        if stat.S_ISREG(os.fstat(handle).st_mode):
            return os.fdopen(handle, "rb")
    except OSError:  # a folder
        pass
    os.close(handle)
    raise DataError(name, "not a regular file")
