"""Folders whose files may be executed or unpickled: nobody but their owner can have put anything into them."""

import contextlib
import os
import stat
import tempfile
from pathlib import Path

from rsc.errors import RscError

_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
# a folder is opened to be looked at, which needs no right to list it; a link in its place is refused
_LOOK = os.O_DIRECTORY | os.O_NOFOLLOW | getattr(os, "O_PATH", os.O_RDONLY)


class UnsafeFolder(RscError):
    """A folder that cannot be used, or that others may write: which one and why, in one line."""


def own_folder(base: Path, *inside: str) -> Path:
    """A folder below `base` that belongs to the user alone, made where it is missing.

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
        with tempfile.TemporaryFile(dir=path):
            return path
    except OSError as error:
        raise UnsafeFolder(f"{path} cannot be written ({error.strerror})") from None


def _entered(handle, name, path):
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


def _refuse_foreign(handle, path, own):
    """UnsafeFolder where somebody else owns an open folder or may write it; `own`: it must be the user's and is never shared."""
    status = os.fstat(handle)
    if status.st_uid not in ((os.geteuid(),) if own else (0, os.geteuid())):
        raise UnsafeFolder(f"{path} belongs to another user")
    sticky = not own and status.st_mode & stat.S_ISVTX
    if status.st_mode & _OTHERS_WRITE and not sticky:
        raise UnsafeFolder(f"{path} may be written by others (chmod go-w would mend that)")
