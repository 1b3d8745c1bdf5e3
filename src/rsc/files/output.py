"""Output files: all are checked before anything is computed, and no file of the user is replaced.

A name may be new, or that of an empty file, or of a file that rsc wrote in the same format and nobody has changed since
(`rsc.files.mark`). Links, folders, pipes and devices are refused even with overwrite: for an administrator, renaming would
replace a system device by a result.
"""

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO, NamedTuple

from rsc.errors import DataError, one_line
from rsc.files.content import unusable
from rsc.files.mark import Format, digest_beside, is_of, name_beside, text_beside
from rsc.files.whole import clear_abandoned, kind_of, staged
from rsc.operating_system import Folder, prove_writable, refuse_in_use

FOREIGN = "this rsc did not write that file, or it was changed since"
FORCED = "choose another name, or replace it with --force (Python: overwrite=True)"
LONGEST_BESIDE = 512  # bytes
OF_FILES = (".png", ".gif", ".pdf", ".svg", ".html", ".h5", ".nc", ".json", ".toml", ".csv")  # what no new folder is called


class OutputFile(NamedTuple):
    """A file to be written."""

    path: Path
    content: bytes
    format: Format


def place(path: str | os.PathLike[str]) -> Path:
    """The path, if it can be that of a file: a new one, or one that is there.

    Raises
    ------
    DataError
        Not a file name, or the name of something that is not a regular file.
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
    with _failing(path):
        refuse_in_use(path)
    return path


def refuse_foreign(path: Path) -> None:
    """DataError for a file that rsc did not write or that was changed since."""
    raise DataError(one_line(path), f"cannot be written ({FOREIGN}; {FORCED})")


def target(path: str | os.PathLike[str], format: Format, overwrite: bool = False) -> Path:
    """The path, if a file of this format may be written there.

    overwrite : bool, allow replacing a file that rsc did not write

    Raises
    ------
    DataError
        As `place`, or a file is there that rsc did not write in this format, or that was changed since.
    """
    path = place(path)
    with _failing(path):
        prove_writable(path.parent)
    if format.piece is None:
        beside = place(path.with_name(name_beside(path.name)))
        if not overwrite and _content(beside) not in (None, b"") and _digest(beside) is None:
            refuse_foreign(beside)
    if not overwrite and not _is_own(path, format):
        refuse_foreign(path)
    return path


def _is_own(path: Path, format: Format) -> bool:
    """Whether a file is absent, empty, or unchanged since rsc wrote it."""
    with _opened(path) as file:
        size = os.fstat(file.fileno()).st_size if file else 0
        if not file or not size:
            return True
        if format.piece is not None:
            return format.is_marked(file, size)
        digest = _digest(path.with_name(name_beside(path.name)))
        return digest is not None and is_of(digest, file, size)


def _digest(beside: Path) -> str | None:
    """The digest in a separate mark file."""
    return digest_beside(_content(beside) or b"")


def _content(path: Path) -> bytes | None:
    """The first bytes of a file, None without one."""
    with _opened(path) as file:
        return file.read(LONGEST_BESIDE) if file else None


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[BinaryIO | None]:
    """Open a file for reading, None if absent; links are not followed."""
    try:
        with contextlib.ExitStack() as stack:
            file = None
            with contextlib.suppress(FileNotFoundError):
                folder = stack.enter_context(contextlib.closing(Folder(path.parent, linked=True)))
                file = stack.enter_context(open(path.name, "rb", opener=lambda name, _: folder.open(name)))
            yield file
    except OSError as error:
        raise DataError(one_line(path), f"cannot be written ({unusable(error)})") from None


def put(path: str | os.PathLike[str], content: bytes | memoryview, format: Format, overwrite: bool = False) -> None:
    """Write a small file with its mark atomically; arguments and errors as for `target` and `put_all`."""
    put_all([OutputFile(Path(path), bytes(content), format)], overwrite)


def put_all(outputs: Sequence[OutputFile], overwrite: bool = False) -> None:
    """Write small files with their marks, all or none.

    Files have private names in the same folder until all are written, and then get their final names; remains of killed processes
    are removed.

    Raises
    ------
    DataError
        As `target`, or one cannot be written; then nothing is left behind.
    """
    for output in outputs:
        target(output.path, output.format, overwrite)
    with contextlib.ExitStack() as stack:
        publishes = []
        for output in outputs:
            with _failing(output.path):
                folder = stack.enter_context(contextlib.closing(Folder(output.path.parent, linked=True)))
                clear_abandoned(folder)
                for name, content in _files(output):
                    publishes.append((output.path, stack.enter_context(staged(folder, name, [content], synced=False))))
        for path, publish in publishes:
            with _failing(path):
                publish()


def _files(output: OutputFile) -> Iterator[tuple[str, bytes]]:
    """Names and contents of the files of an output."""
    if output.format.piece is None:
        yield name_beside(output.path.name), text_beside(output.path.name, output.content)
    yield output.path.name, output.format.marked(output.content)


@contextlib.contextmanager
def _failing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise DataError(one_line(path), f"cannot be written ({unusable(error)})") from None


def refuse_name_of_file(path: Path) -> None:
    """DataError for a new folder with the name of a file, such as map.png: several files are written into it."""
    if path.suffix.lower() in OF_FILES and not os.path.lexists(path):
        raise DataError(one_line(path), f"must be a folder, into which files are written: leave {path.suffix} out")


def folder(path: str | os.PathLike[str]) -> Path:
    """The folder, created if missing and tested to be writable before anything is computed; DataError otherwise."""
    if not os.fspath(path):
        raise DataError("''", "cannot be written (it is not the name of a folder)")
    path = Path(path)
    try:
        refuse_name_of_file(path)
        path.mkdir(parents=True, exist_ok=True)
        prove_writable(path)
        return path
    except (OSError, ValueError) as error:
        raise DataError(one_line(path), f"cannot be written ({unusable(error)})") from None
