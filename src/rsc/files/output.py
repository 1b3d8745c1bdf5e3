"""Files that rsc writes: looked at before anything is computed, and never put in the place of what is something else.

A name may be new, or that of a regular file of the same kind, told by its first bytes. Links, folders, pipes and devices are
refused: as the administrator a rename would replace a device of the system by a result.
"""

import contextlib
import os
from pathlib import Path

from rsc.errors import DataError, one_line
from rsc.files.content import unusable
from rsc.files.whole import clear_abandoned, kind_of, write_whole
from rsc.operating_system import Folder, prove_writable, refuse_in_use

HDF5 = b"\x89HDF\r\n\x1a\n"
ZIP = b"PK\x03\x04"
PICTURES = {".png": b"\x89PNG\r\n\x1a\n", ".pdf": b"%PDF", ".svg": b"<?xml"}


def target(path: str | os.PathLike[str], begins: bytes) -> Path:
    """The path, if a file that begins so may be written there.

    Raises
    ------
    DataError
        No name for a file, or the name of something else that is there.
    """
    path, name = Path(path), one_line(path)
    if not path.name:
        raise DataError(name, "cannot be written (it is not the name of a file)")
    try:
        status = os.lstat(path)
    except FileNotFoundError:
        return path
    except (OSError, ValueError) as error:
        raise DataError(name, f"cannot be written ({unusable(error)})") from None
    if what := kind_of(status):
        raise DataError(name, f"cannot be written (it {what}, which is not replaced)")
    if status.st_size and _head(path, len(begins)) != begins:
        raise DataError(name, "cannot be written (a file of another kind has this name; remove it, or choose another name)")
    try:
        refuse_in_use(path)
    except OSError as error:
        raise DataError(name, f"cannot be written ({unusable(error)})") from None
    return path


def _head(path, length):
    try:
        folder = Folder(path.parent, linked=True)
        with contextlib.closing(folder), open(path.name, "rb", opener=lambda name, _: folder.open(name)) as file:
            return file.read(length)
    except OSError as error:
        raise DataError(one_line(path), f"cannot be written ({unusable(error)})") from None


def put(path: str | os.PathLike[str], content: bytes | memoryview, begins: bytes) -> None:
    """Write a small file as a whole: it has its name when all of it is written, and until then a private one beside it; such
    ones that a kill left there before are removed.

    Raises
    ------
    DataError
        As `target`, or it cannot be written; then nothing is left behind.
    """
    path = target(path, begins)
    try:
        with contextlib.closing(Folder(path.parent, linked=True)) as folder:
            clear_abandoned(folder)
            write_whole(folder, path.name, [content], synced=False)
    except OSError as error:
        raise DataError(one_line(path), f"cannot be written ({unusable(error)})") from None


def folder(path: str | os.PathLike[str]) -> Path:
    """The folder, made when missing and proved writable before anything is computed; DataError when that is impossible."""
    if not os.fspath(path):
        raise DataError("''", "cannot be written (it is not the name of a folder)")
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
        prove_writable(path)
        return path
    except (OSError, ValueError) as error:
        raise DataError(one_line(path), f"cannot be written ({unusable(error)})") from None
