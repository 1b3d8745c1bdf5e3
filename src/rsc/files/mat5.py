"""Reader of real dense and sparse matrices, and structs of them, from possibly damaged MAT-files of level 5 (-v6, -v7).

scipy.io.loadmat crashed the process on damaged files, so the few parts needed here are read with every length checked before it
is used. Format: MathWorks, "MAT-File Format", level 5.
"""

import struct
import zlib

import numpy as np
import scipy.sparse

_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_MATRIX, _COMPRESSED = 14, 15
_STRUCT, _SPARSE, _DENSE = 2, 5, range(6, 16)  # array classes
_COMPLEX, _LOGICAL = 0x08, 0x02  # flags
_HEAD = 1024  # bytes of a variable that hold its flags, shape and name
_MOST = 32 * 2**20  # bytes of one variable, unless the caller takes more
_MOST_FIELDS, _DEEPEST = 1000, 8  # variables of a file or fields of a struct; nesting depth of structs


class MatError(ValueError):
    """Not a MAT-file of level 5, or damaged."""


class _Elements:
    """Iterates over the data elements of a buffer."""

    def __init__(self, content, order, padded=True):
        self.content, self._order, self._padded, self.place = content, order, padded, 0

    def __bool__(self):
        return self.place < len(self.content)

    def next(self):
        """(type, content) of the next element; MatError if its length does not fit."""
        if self.place + 8 > len(self.content):
            raise MatError("an element is cut off")
        kind, length = struct.unpack_from(self._order + "II", self.content, self.place)
        start = self.place + 8
        if kind >> 16:  # the short form: type, length and at most four bytes in eight
            kind, length, start = kind & 0xFFFF, kind >> 16, self.place + 4
            if length > 4:
                raise MatError("a short element is too long")
            self.place += 8
        else:
            self.place = start + (-(-length // 8) * 8 if self._padded else length)
        if start + length > len(self.content):
            raise MatError("an element is cut off")
        return kind, self.content[start : start + length]

    def numbers(self, kinds=_TYPES):
        """The next element as an array of numbers."""
        kind, content = self.next()
        if kind not in _TYPES or kind not in kinds:
            raise MatError(f"an element of type {kind} is no array of numbers")
        dtype = np.dtype(self._order + _TYPES[kind])
        if len(content) % dtype.itemsize:
            raise MatError("an element holds a part of a number")
        return np.frombuffer(content, dtype)


def read_mat5(content, most=_MOST):
    """Variables of a MAT-file of level 5.

    Parameters
    ----------
    content : bytes
    most : int
        Most bytes of all variables that are read, unpacked: the parts of structs are kept as long as their functions.

    Returns
    -------
    dict
        Name -> (shape, function). Of a real matrix the function returns the (rows, columns) array, a scipy.sparse.csc_array where
        the file has a sparse one. The shape is None for what is no real matrix: there the function returns the fields of a struct
        as such a dict. Nothing large is taken before a function is called.

    Raises
    ------
    MatError
        Also raised by the functions.
    """
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if order is None or struct.unpack_from(order + "H", content, 124)[0] != 0x0100:
        raise MatError("not a MAT-file of level 5 (save with -v7)")
    elements, variables, left = _Elements(content[128:], order, padded=False), {}, most
    while elements:
        kind, packed = elements.next()
        head = _unpacked(packed, _HEAD, _HEAD) if kind == _COMPRESSED else packed[:_HEAD]
        outer = struct.unpack_from(order + "II", head) if kind == _COMPRESSED and len(head) >= 8 else (kind, len(packed))
        if outer[0] != _MATRIX:
            continue
        parts = _Elements(head[8:] if kind == _COMPRESSED else head, order)
        shape, name, _ = _header(parts)

        def read(kind=kind, packed=packed, outer=outer):
            nonlocal left
            if kind != _COMPRESSED:
                return _value(packed, order)
            body = _unpacked(packed, outer[1] + 8, left, complete=True)[8:]
            left -= len(body)
            return _value(body, order)

        variables[name] = shape, read
        if len(variables) > _MOST_FIELDS:
            raise MatError(f"it has more than {_MOST_FIELDS} variables")
    return variables


def _unpacked(packed, length, most, complete=False):
    """The first `length` bytes of a compressed element, or (complete) all of it, with a check of length and checksum."""
    if length > most:
        raise MatError(f"a variable is larger than {most // 2**20} MB, what is left for all that are read")
    unpacker = zlib.decompressobj()
    try:
        content = unpacker.decompress(packed, length + complete)  # one more, for the checksum is read behind the last byte
    except zlib.error:
        raise MatError("a compressed variable is damaged") from None
    if complete and not (unpacker.eof and len(content) == length):
        raise MatError("a compressed variable is damaged")
    return content


def _header(parts, named=True):
    """(shape or None, name, class) from the start of a variable; fields of structs are unnamed."""
    flags = parts.numbers((6,))
    shape = tuple(int(n) for n in parts.numbers((5,)))
    name = bytes(parts.numbers((1, 2))).decode("ascii", "replace")
    if len(flags) != 2 or (named and not name):
        raise MatError("a variable has no flags or no name")
    kind, bits = int(flags[0]) & 0xFF, int(flags[0]) >> 8
    matrix = (kind == _SPARSE or kind in _DENSE) and not bits & (_COMPLEX | _LOGICAL) and len(shape) == 2 and min(shape) >= 0
    return (shape if matrix else None), name, kind


def _value(body, order, depth=0):
    """The matrix of a variable, or the fields of a struct."""
    parts = _Elements(body, order)
    shape, _, kind = _header(parts, named=depth == 0)
    if kind == _STRUCT and depth < _DEEPEST:
        return _fields(parts, order, depth + 1)
    if shape is None:
        raise MatError("a variable is no real matrix")
    return _sparse(parts, *shape) if kind == _SPARSE else _dense(parts, *shape)


def _fields(parts, order, depth):
    """The fields of a single struct; an array of structs repeats their names and is refused."""
    width = parts.numbers((5,))
    text = bytes(parts.numbers((1, 2)))
    if len(width) != 1 or width[0] < 1 or len(text) % width[0] or len(text) > _MOST_FIELDS * width[0]:
        raise MatError("a struct has no names of fields")
    width = int(width[0])
    names = [text[i : i + width].split(b"\0")[0].decode("ascii", "replace") for i in range(0, len(text), width)]
    fields = {}
    for name in names:
        kind, body = parts.next()
        if kind != _MATRIX:
            raise MatError("a field of a struct is no variable")
        if not body:  # how an empty field may be written
            continue
        shape = _header(_Elements(body[:_HEAD], order), named=False)[0]
        fields[name] = shape, lambda body=body: _value(body, order, depth)
    if parts:
        raise MatError("an array of structs, not a single one")
    return fields


def _sparse(parts, rows, columns):
    i, starts, values = parts.numbers((5, 6)), parts.numbers((5, 6)).astype(int), parts.numbers()
    counts = np.diff(starts)
    used = int(starts[-1]) if len(starts) else 0
    fits = len(starts) == columns + 1 and starts[0] == 0 and np.all(counts >= 0) and used <= min(len(i), len(values))
    if not fits or np.any((i[:used] < 0) | (i[:used] >= rows)):
        raise MatError("a sparse matrix contradicts itself")
    matrix = scipy.sparse.csc_array((values[:used].astype(float), i[:used].astype(int), starts), shape=(rows, columns))
    matrix.sum_duplicates()
    return matrix


def _dense(parts, rows, columns):
    values = parts.numbers()
    if len(values) != rows * columns:
        raise MatError("a matrix has another number of entries than its shape says")
    return values.reshape((rows, columns), order="F")
