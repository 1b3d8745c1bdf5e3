"""Entries of Nastran bulk data: their fields, in small (8 columns), wide (NAME*, 16 columns) and free form (commas)."""

import re

from rsc.machine.formats.entries import BadMatrix, TextLines

EXPONENT = re.compile(rb"([\d.])([+-]\d)")  # one without its letter: 1.5-3
_CONTINUES = (b"+", b"*", b" ", b",")


def cards(content, names, most, too_many):
    """(name, fields) of every entry with one of some names (bytes, capital), those of its continuation lines joined.

    Raises
    ------
    BadMatrix
        An entry has more than `most` fields; `too_many` says so.
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


def fields_of(line):
    """The eight (or, wide, four) fields of a line behind its first one."""
    if b"," in line:
        fields = [field.strip() for field in line.split(b",", 9)[1:9]]
        return fields + [b""] * (8 - len(fields))
    width, count = (16, 4) if b"*" in line[:8] else (8, 8)
    return [line[8 + width * i : 8 + width * (i + 1)].strip() for i in range(count)]


def integer(field):
    """The whole number of a field; 0 of an empty one."""
    try:
        if len(field) <= 16:  # as wide as a field can be; with commas it could be of any length
            return int(field or b"0")
    except ValueError:
        pass
    raise BadMatrix(f"'{field[:20].decode('ascii', 'replace')}' stands where a whole number belongs")


def real(field):
    """The number of a field; 0 of an empty one."""
    try:
        if len(field) <= 24:
            return float(EXPONENT.sub(rb"\1E\2", field.upper().replace(b"D", b"E")) or b"0")
    except ValueError:
        pass
    raise BadMatrix(f"'{field[:20].decode('ascii', 'replace')}' stands where a number belongs")
