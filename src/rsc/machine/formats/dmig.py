"""Punched DMIG entries of Nastran bulk data: matrices whose rows and columns are grid points and components.

MSC Nastran Quick Reference Guide, DMIG: a header (GJ = 0) with form (1 square, 6 symmetric, of which one half is given) and type
(1 and 2 real), then columns: GJ, CJ and triples G, C, A. Fields have 8 columns, 16 if the entry starts with DMIG*, or are
separated by commas; exponents may lack their letter (1.5-3). Component 0 denotes a scalar point.
"""

import re
from typing import Any

import numpy as np

from rsc.machine.formats.bulk import EXPONENT, cards, integer
from rsc.machine.formats.entries import MOST_COORDINATES, BadMatrix, numbers, sparse, whole

_START = re.compile(rb"^DMIG[ \t*,]", re.MULTILINE | re.IGNORECASE)
_SQUARE, _SYMMETRIC = 1, 6
_REAL = (1, 2)
_MOST_ENTRIES = 3_000_000  # take 1 GB while being read
_TOO_MANY = f"it has more than {_MOST_ENTRIES} entries; write such matrices by OUTPUT4"
_DIRECTIONS = 1024  # larger than any direction number


def recognises(content: bytes) -> bool:
    """Whether a text contains a DMIG entry."""
    return _START.search(content) is not None


def read(content: bytes) -> tuple[dict[str, Any], dict[str, Any]]:
    """(matrices, labels) of the real square matrices: name -> scipy.sparse.csc_array, and name -> (n, 2) int array of grid point
    and component, sorted by both."""
    forms: dict[str, int | None] = {}
    entries: dict[str, list[Any]] = {}
    count = 0
    for _, card in cards(content, (b"DMIG",), 4 * _MOST_ENTRIES, _TOO_MANY):
        name, grid, component, fields = _card(card)
        if name not in forms:
            if grid != 0:
                raise BadMatrix(f"the matrix {name} has a column before its header")
            forms[name], entries[name] = integer(fields[0]), []
            if forms[name] not in (_SQUARE, _SYMMETRIC) or integer(fields[1]) not in _REAL:
                forms[name] = None  # a load, or complex
            continue
        if forms[name] is None:
            continue
        for i in range(0, len(fields) - 2, 4):
            if fields[i] or fields[i + 2]:
                entries[name].append((integer(fields[i]), integer(fields[i + 1]), grid, component, fields[i + 2]))
                count += 1
        if count > _MOST_ENTRIES:
            raise BadMatrix(_TOO_MANY)
    matrices, labels = {}, {}
    for name, form in forms.items():
        if entries[name]:
            matrices[name], labels[name] = _matrix(entries[name], int(form == _SYMMETRIC))
    return matrices, labels


def _matrix(entries: list[Any], mirror: int) -> tuple[Any, Any]:
    *places, words = zip(*entries, strict=True)
    values = numbers(b" ".join(EXPONENT.sub(rb"\1E\2", word) or b"0" for word in words))
    if len(values) != len(entries):
        raise BadMatrix("an entry of a column is not a number")
    rows, columns = (keys_of(places[k], places[k + 1], least=0) for k in (0, 2))
    return labelled(rows, columns, values, mirror)


def keys_of(nodes: Any, directions: Any, least: int = 1) -> Any:
    """One integer per pair of node and direction, which sorts like the pairs: (n,) int64."""
    nodes, directions = np.asarray(nodes), np.asarray(directions)
    return whole(nodes, least, 2**40, "a node") * _DIRECTIONS + whole(directions, least, _DIRECTIONS - 1, "a direction")


def places_of(keys: Any) -> Any:
    """(n, 2) node and direction from keys."""
    return np.column_stack([keys // _DIRECTIONS, keys % _DIRECTIONS])


def labelled(rows: Any, columns: Any, values: Any, mirror: int) -> tuple[Any, Any]:
    """(matrix, labels) from entries whose rows and columns are keys; labels (n, 2) node and direction, sorted by both."""
    keys, place = np.unique(np.concatenate([rows, columns]), return_inverse=True)
    if len(keys) > MOST_COORDINATES:
        raise BadMatrix(f"it has {len(keys)} coordinates; at most {MOST_COORDINATES} are read")
    place = place.reshape(-1)
    return sparse(place[: len(rows)], place[len(rows) :], values, (len(keys),) * 2, mirror), places_of(keys)


def _card(fields: list[bytes]) -> tuple[str, int, int, list[bytes]]:
    """(name, GJ, third field, remaining fields) of an entry; the third field is the form in a header, the component in a
    column."""
    name, grid, third = fields[0].decode("ascii", "replace"), integer(fields[1]), integer(fields[2])
    return name, grid, third, fields[2:] if grid == 0 else fields[4:]
