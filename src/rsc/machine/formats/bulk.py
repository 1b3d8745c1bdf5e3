"""Entries of Nastran bulk data in small (8 columns), large (NAME*, 16 columns) and free (comma-separated) field format."""

import re
from collections.abc import Iterator, Sequence

from rsc.machine.formats.entries import BadMatrix, TextLines

EXPONENT = re.compile(rb"([\d.])([+-]\d)")  # an exponent without its letter: 1.5-3
_CONTINUES = (b"+", b"*", b" ", b",")


def cards(content: bytes, names: Sequence[bytes], most: int, too_many: str) -> Iterator[tuple[bytes, list[bytes]]]:
    """(name, fields) of every entry with one of the names (upper case bytes), including its continuation lines.

    Raises
    ------
    BadMatrix
        An entry has more than `most` fields; the message is `too_many`.
    """
    name, card = None, []
    for line in TextLines(content):
        line = line.split(b"$", 1)[0].rstrip()
        if not line.strip():
            continue
        if line[:1] not in _CONTINUES:
            if name:
                yield name, card
            head = re.split(rb"[,\t *]", line[:8], maxsplit=1)[0].upper()
            name, card = (head, fields_of(line)) if head in names else (None, [])
        elif name:
            card += fields_of(line)
            if len(card) > most:
                raise BadMatrix(too_many)
    if name:
        yield name, card


def fields_of(line: bytes) -> list[bytes]:
    """The eight (in large format four) fields of a line after the first one."""
    if b"," in line:
        fields = [field.strip() for field in line.split(b",", 9)[1:9]]
        return fields + [b""] * (8 - len(fields))
    width, count = (16, 4) if b"*" in line[:8] else (8, 8)
    return [line[8 + width * i : 8 + width * (i + 1)].strip() for i in range(count)]


def integer(field: bytes) -> int:
    """The integer in a field; 0 if it is empty."""
    try:
        if len(field) <= 16:  # the widest field; comma-separated ones could have any length
            return int(field or b"0")
    except ValueError:
        pass
    raise BadMatrix(f"'{field[:20].decode('ascii', 'replace')}' found where an integer is expected")


def real(field: bytes) -> float:
    """The number in a field; 0 if it is empty."""
    try:
        if len(field) <= 24:
            return float(EXPONENT.sub(rb"\1E\2", field.upper().replace(b"D", b"E")) or b"0")
    except ValueError:
        pass
    raise BadMatrix(f"'{field[:20].decode('ascii', 'replace')}' found where a number is expected")
