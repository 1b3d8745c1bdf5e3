"""What a killed run left of its result: whether it can be continued, set aside, replaced."""

import os
from pathlib import Path

from rsc.errors import DataError
from rsc.files.whole import kind_of
from rsc.operating_system import remove
from rsc.results.claims import claimed, left_of, part_of
from rsc.results.result_file import ResultFile
from rsc.results.result_format import Guard
from rsc.results.structure import has_format, reading

BEGINNING = 2**17  # bytes of a file before its first samples, at most


def resumable(path):
    """The file that holds the run to be continued: one left by a kill, or the result itself; None where a kill left only a file
    without a beginning, DataError where there is nothing."""
    path = Path(path)
    left = [file for file in (left_of(path), part_of(path)) if os.path.lexists(file)]
    begun = [file for file in left if not _is_without_beginning(file)]
    if begun or path.exists():
        return (*begun, path)[0]
    if left:
        return None
    raise DataError(path, "does not exist, nor does what a kill would have left of it")


def _is_without_beginning(file):
    """Whether a run was killed before its file was one of HDF5, or before its first checkpoint."""
    status = os.lstat(file)
    if kind_of(status):  # to open a pipe might never end
        return False
    try:
        with reading(file).opened() as opened:
            named = has_format(opened)
    except Exception:  # whatever HDF5 says of it
        return status.st_size <= BEGINNING
    try:
        stored = ResultFile(file)
        return not named or (stored.n_time() == 0 and stored.checkpoint()[0] is None)
    except DataError:
        return False


def refuse_unfinished(path):
    """DataError where another run writes this result, or a killed one left samples of it from which `--resume` goes on.

    Returns the name of what a killed run left that cannot be continued, "" where there is none.
    """
    part, damaged = part_of(path), ""
    if os.path.lexists(part):
        claimed(path, part, False).close()
    for file in (left_of(path), part):
        if not os.path.isfile(file) or _is_without_beginning(file):
            continue
        try:
            checkpoint = ResultFile(file).checkpoint()[0]
        except DataError:
            checkpoint = None
        if checkpoint is None:
            damaged = file.name
        elif rows := int(checkpoint["rows"][0]):
            how = "go on with --resume, or replace them with --force (Python: overwrite=True)"
            raise DataError(path, f"cannot be written ({file.name} holds {rows} samples of a killed run: {how})")
    return damaged


def take_over(path, overwrite=False):
    """Set aside a file left by a kill, so that NAME.part is free for the continued run; returns the file of the samples."""
    source, part, left = resumable(path), part_of(path), left_of(path)
    if source != part:
        return source
    with Guard(path, "cannot be written"):
        claimed(path, part, overwrite).set_aside(left)
    return left


def discard_left(path):
    """Remove the file that `take_over` set aside, once it is copied."""
    with Guard(path, "cannot be written"):
        remove(left_of(path))
