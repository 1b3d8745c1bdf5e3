"""Names of a result's file while its run goes on, which one process alone may write."""

from pathlib import Path

from rsc.errors import DataError
from rsc.files.content import refuse_special
from rsc.operating_system import Claim, explained
from rsc.results.structure import refuse_other_file, refuse_other_part


def part_of(path):
    """Name of the file while its run goes on."""
    path = Path(path)
    return path.parent / f"{path.name}.part"


def left_of(path):
    """Name of the file left by a killed run, while the run that continues it copies it."""
    path = Path(path)
    return path.parent / f"{path.name}.left"


def claimed(path, part, overwrite):
    """The part file, claimed for this process alone."""
    refuse_other_file(path, overwrite)
    for file in () if overwrite else (part, left_of(path)):
        refuse_other_part(file)
    try:
        claim = Claim(part)
    except OSError as error:
        raise DataError(path, f"cannot be written ({explained(error)})") from None
    try:
        refuse_special(part, claim.status)
        if claim.held is False:
            raise DataError(path, f"is being written by another run (lock on {part.name})")
    except DataError:
        claim.close()
        raise
    return claim
