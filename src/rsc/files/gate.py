"""The gate: allowed content of HDF5 files, one table per kind of file, checked before anything is read.

A checksum shows that nothing was damaged, not who wrote the file: a forger writes the checksums as well. So a file is accepted
only if it contains exactly what rsc writes: known names, each stored in the file itself and only once, plain numbers and
fixed-length texts, consistent shapes, and no more data than the file has bytes. Links, arrays in other files, virtual arrays and
filters are refused and never followed.

Every function raises ValueError for what it refuses.
"""

import io
import math
import struct
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from rsc.errors import one_line
from rsc.files.memory import Memory

MOST_NAMES = 64  # arrays or attributes in one place; a run writes some twenty
LONGEST_TEXT, LONGEST_SCENE = 4096, 2**26  # bytes, of a text in an array or of a short attribute; of the scene of a sweep
F8, I8, I1, TEXT = "f8", "i8", "i1", "text"
_SIGNATURE, _HEAP, _TEXTS = b"\x89HDF\r\n\x1a\n", b"HEAP\0", b"GCOL\1"
_BLOCK = 2**20  # bytes searched at a time
PACKED_BY = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32}  # as MATLAB does
LZF = h5py.h5z.FILTER_LZF
_DENSEST = 1100  # largest compression ratio: that of zeros is 1032 with deflate, 264 with LZF
_TYPES = {F8: h5py.h5t.IEEE_F64LE, I8: h5py.h5t.STD_I64LE, I1: h5py.h5t.STD_I8LE}


@dataclass(frozen=True)
class Array:
    """One array that a file may contain.

    kinds : str, what its entries may be: one or more of "f8", "i8", "i1" and "text" (of a fixed length)
    shape : tuple, of every axis its length, or a name that axes of the same length share
    chunk : int, rows of a chunk, each of which carries a Fletcher sum; 0: it lies in one piece, without filters
    """

    kinds: str
    shape: tuple[int | str, ...]
    chunk: int = 0


def image(content: bytes) -> h5py.File:
    """Open the HDF5 file in a bytes object for reading."""
    refuse_endless(lambda place, count: content[place : place + count], len(content))
    return h5py.File(io.BytesIO(content), "r")


def refuse_endless(read: Callable[[int, int], bytes], size: int) -> None:
    """ValueError for what HDF5 would search forever, taking memory: a heap of names (the local heap of groups of the oldest kind,
    HDF5 File Format Specification, III.D) whose free list is circular.

    Parameters
    ----------
    read : function, (place, number of bytes) -> the bytes that are there
    size : int, bytes of the file
    """
    start = next((place for place in (0, *(512 << i for i in range(40))) if read(place, 8) == _SIGNATURE), size)
    head, left = read(start, 16), size // 16  # a free block takes at least 16 bytes
    if head and head[9:11] != b"\x08\x08" and head[13:15] != b"\x08\x08":
        raise ValueError("its addresses have not eight bytes")
    for block in range(start, size, _BLOCK):
        part = read(block, _BLOCK + 31)
        place = part.find(_HEAP)
        while 0 <= place <= len(part) - 32:
            length, free, data = struct.unpack_from("<3Q", part, place + 8)
            while free != 1 and free < length and start + data + free <= size - 8:  # otherwise the end, or refused by HDF5 itself
                (free,) = struct.unpack("<Q", read(start + data + free, 8))
                left -= 1
                if left < 0:
                    raise ValueError("a list of free places in it has no end")
            place = part.find(_HEAP, place + 1)
    _refuse_endless_texts(read, size)


def _refuse_endless_texts(read: Callable[[int, int], bytes], size: int) -> None:
    """ValueError for a heap of variable-length texts (the global heap, III.E) with an object of size zero, which HDF5 would read
    forever."""
    for block in range(0, size, _BLOCK):
        part = read(block, _BLOCK + len(_TEXTS))
        at = part.find(_TEXTS)
        while 0 <= at < _BLOCK:
            place = block + at
            (length,) = struct.unpack("<Q", read(place + 8, 8).ljust(8, b"\0"))
            end, place = min(place + length, size), place + 16
            while place + 16 <= end:
                index, taken = struct.unpack("<H6xQ", read(place, 16))
                step = 16 + -(-taken // 8) * 8 if index else taken
                if step == 0 or step > end - place:
                    raise ValueError("a heap of texts in it has no end")
                place += step
            at = part.find(_TEXTS, at + 1)


def is_own(group: Any, name: str) -> bool:
    """Whether a name in a group is an object in this file and not a link."""
    return isinstance(group.get(name, getlink=True), h5py.HardLink)


def members(group: Any, known: Collection[str] | None = None, most: int = MOST_NAMES) -> set[str]:
    """Names in a group; ValueError for unknown names (if `known` is given), links, and objects with two names."""
    if not isinstance(group, h5py.Group) or len(group) > most:
        raise ValueError("its groups are not those that rsc writes")
    names = set(group)
    for name in names:
        if known is not None and name not in known:
            raise ValueError(f"{one_line(name)[:40]!r} is nothing that rsc writes")
        if not isinstance(group.get(name, getlink=True), h5py.HardLink) or h5py.h5o.get_info(group.id, name.encode()).rc != 1:
            raise ValueError(f"{one_line(name)[:40]!r} is a link")
    return names


def dataset(group: h5py.Group, name: str) -> h5py.Dataset:
    """An array with rows, whose name is known not to be a link."""
    data = group.get(name)
    if not isinstance(data, h5py.Dataset) or not data.shape:
        raise ValueError(f"{name} is no array that rsc writes")
    return data


def short_attribute(item: Any, name: str) -> Any:
    """Value of an attribute that is a fixed-length text or numbers; None if absent or of another kind."""
    if name not in item.attrs:
        return None
    kind = h5py.check_string_dtype(item.attrs.get_id(name).dtype)
    fixed = kind.length is not None if kind else item.attrs.get_id(name).dtype.kind in "fiu"
    return item.attrs[name] if fixed else None


def text_attribute(item: Any, name: str) -> str:
    """A short text attribute, of fixed or variable length; "" if absent. Only for files whose heaps were checked by
    `refuse_endless`."""
    if name not in item.attrs:
        return ""
    attribute = item.attrs.get_id(name)
    if attribute.get_type().get_class() != h5py.h5t.STRING or attribute.shape not in ((), (1,)):
        return ""
    value = np.ravel(item.attrs[name])[0]
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return one_line(text)[:LONGEST_TEXT]


def numbers(data: Any, name: str, memory: Memory, filters: Collection[int] = frozenset(PACKED_BY)) -> NDArray[Any]:
    """All numbers of an array of foreign origin, after checking its size and that it is stored in this file.

    Parameters
    ----------
    data : h5py.Dataset
    name : str, for messages
    memory : Memory that they count against
    filters : allowed compression filters

    Raises
    ------
    ValueError, TooLarge
    """
    if not isinstance(data, h5py.Dataset) or data.dtype.kind not in "fiu" or data.external or data.is_virtual:
        raise ValueError("an array holds no numbers of its own")
    made = data.id.get_create_plist()
    if not {made.get_filter(i)[0] for i in range(made.get_nfilters())} <= set(filters):
        raise ValueError("an array is packed in a way that is not read")
    if data.nbytes > _DENSEST * data.id.get_storage_size():
        raise ValueError(f"an array is larger than what the file holds of it: {data.size} numbers")
    memory.take(one_line(name)[:40], data.size, data.dtype.itemsize)
    return np.asarray(data[()])


def text_of(item: Any, name: str) -> str | None:
    """A short fixed-length text attribute; None if it is of another kind."""
    if name not in item.attrs:
        return None
    attribute = item.attrs.get_id(name)
    kind = attribute.get_type()
    if kind.get_class() != h5py.h5t.STRING or kind.is_variable_str() or attribute.shape != () or kind.get_size() > LONGEST_TEXT:
        return None
    return bytes(item.attrs[name]).decode("utf-8", "replace")


def attributes(
    item: Any, known: Mapping[str, tuple[int, ...]], most: int, optional: Collection[str] = ()
) -> dict[str, Any]:
    """name -> value of attributes, texts as str: exactly the known ones (optional ones may be absent), with these shapes and at
    most `most` bytes.

    A text of any length is not even looked at, because HDF5 may search a damaged heap for it for ever.
    """
    count = h5py.h5a.get_num_attrs(item.id)
    if count > MOST_NAMES:
        raise ValueError(f"it has {count} attributes")
    for name in item.attrs:
        if name not in known:
            raise ValueError(f"attribute {one_line(name)[:40]!r} is nothing that rsc writes")
        attribute = item.attrs.get_id(name)
        if attribute.shape != known[name]:
            raise ValueError(f"attribute {name} has another shape than rsc writes")
        if attribute.get_type().get_size() > most:
            raise ValueError(f"attribute {name} is too large")
    missing = set(known) - set(optional) - set(item.attrs)
    if missing:
        raise ValueError(f"attribute {min(missing)} is missing")
    return values_of(item)


def values_of(item: Any) -> dict[str, Any]:
    """name -> value of all attributes, texts as str; only for files written by rsc or already checked."""
    values = {}
    for name in item.attrs:
        kind = item.attrs.get_id(name).get_type()
        text = kind.get_class() == h5py.h5t.STRING
        if kind.is_variable_str() if text else kind.get_class() not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT):
            raise ValueError(f"attribute {one_line(name)[:40]!r} is of another kind than rsc writes")
        value = item.attrs[name]
        values[name] = value.decode() if isinstance(value, bytes) else value
    return values


def look_at(file: h5py.File, table: Mapping[str, Array], size: int, unwritten: int = 0, most: int = MOST_NAMES) -> dict[str, int]:
    """ValueError for an open file that does not contain exactly the arrays of a table.

    Parameters
    ----------
    file : h5py.File
    table : name -> Array; a group stands in the names, as in "checkpoint/x"
    size : int, bytes of the file
    unwritten : int, bytes of an array that may be declared but not yet written, in a file still being written
    most : int, names in one place

    Returns
    -------
    dict
        Name of an axis -> its length.
    """
    for group in sorted({name.rpartition("/")[0] for name in table} | {""}):
        inner = {name.removeprefix(f"{group}/").partition("/")[0] for name in table if not group or name.startswith(f"{group}/")}
        missing = inner - members(file[group] if group else file, inner, most)
        if missing:
            raise ValueError(f"{min(missing)} is missing")
    lengths: dict[str, int] = {}
    left = size + unwritten * len(table)
    for name, array in table.items():
        data = dataset(file, name)
        _refuse_other_shape(name, data.shape, array.shape, lengths)
        _refuse_other_kind(name, data, array)
        wanted = math.prod(data.shape) * data.id.get_type().get_size()
        left -= wanted
        if wanted > min(data.id.get_storage_size(), size) + unwritten or left < 0:
            raise ValueError(f"{name} is larger than the file")
    return lengths


def _refuse_other_shape(name: str, shape: tuple[int, ...], wanted: tuple[int | str, ...], lengths: dict[str, int]) -> None:
    if len(shape) != len(wanted):
        raise ValueError(f"{name} has another shape than rsc writes")
    for length, axis in zip(shape, wanted, strict=True):
        expected = lengths.setdefault(axis, length) if isinstance(axis, str) else axis
        if length != expected:
            raise ValueError(f"{name} has another shape than rsc writes")


def _refuse_other_kind(name: str, data: h5py.Dataset, array: Array) -> None:
    kind, made = data.id.get_type(), data.id.get_create_plist()
    text = kind.get_class() == h5py.h5t.STRING and not kind.is_variable_str() and kind.get_size() <= LONGEST_TEXT
    if not any(text if word == TEXT else kind.equal(_TYPES[word]) for word in array.kinds.split()):
        raise ValueError(f"{name} is no array that rsc writes")
    filters = [made.get_filter(i)[0] for i in range(made.get_nfilters())]
    if array.chunk:
        fits = made.get_layout() == h5py.h5d.CHUNKED and made.get_chunk() == (array.chunk, *data.shape[1:])
        fits = fits and filters == [h5py.h5z.FILTER_FLETCHER32]
    else:
        fits = made.get_layout() == h5py.h5d.CONTIGUOUS and not filters
    if not fits or made.get_external_count():
        raise ValueError(f"{name} was not written by rsc")


def read(file: h5py.File, name: str) -> NDArray[Any]:
    """The values of a checked array; texts (bytes in UTF-8) must be printable, since they will be displayed."""
    values = file[name][()]
    if values.dtype.kind == "S" and not _plain(values):
        for text in set(values.ravel().tolist()):
            refuse_unprintable(name, text.decode())  # a UnicodeDecodeError is a ValueError
    return values


def _plain(values: NDArray[Any]) -> bool:
    """Whether texts contain only printable ASCII characters."""
    letters = np.ascontiguousarray(values).reshape(-1).view(np.uint8)
    return not np.any((letters > 126) | ((letters < 32) & (letters != 0)))


def refuse_unprintable(name: str, *texts: str) -> None:
    """ValueError for texts that would break the line of a message or that a terminal would interpret."""
    if not all(text.isprintable() for text in texts):
        raise ValueError(f"{name} is no line of text")
