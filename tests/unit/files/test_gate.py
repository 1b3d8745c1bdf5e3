"""What HDF5 itself would not survive is refused before it is asked: lists of free places that lead back to themselves."""

import io
import struct

import h5py
import numpy as np
import pytest

from rsc.errors import DataError
from rsc.files import gate
from rsc.results.structure import reading


def old_groups(userblock=0):
    """A file whose groups are of the oldest kind, each with a heap of names."""
    stream = io.BytesIO()
    with h5py.File(stream, "w", userblock_size=userblock) as file:
        for name in ("a", "b/c", "b/d"):
            file.create_dataset(name, data=np.eye(2))
    return stream.getvalue()


def endless(content, heap, start=0):
    """The content with the first free place of one of its heaps as its own successor."""
    place = -1
    for _ in range(heap + 1):
        place = content.index(b"HEAP", place + 1)
    _, free, data = struct.unpack_from("<3Q", content, place + 8)
    changed = bytearray(content)
    changed[start + data + free : start + data + free + 8] = struct.pack("<Q", free)
    return bytes(changed)


@pytest.mark.parametrize("heap", [0, 1])
@pytest.mark.parametrize("userblock", [0, 512])
def test_an_endless_list_of_free_places_is_refused(heap, userblock, tmp_path):
    content = old_groups(userblock)
    with gate.image(content) as file:
        assert sorted(file["b"]) == ["c", "d"]
    bad = endless(content, heap, userblock)
    with pytest.raises(ValueError, match="has no end"):
        gate.image(bad)
    (tmp_path / "run.h5").write_bytes(bad)
    with pytest.raises(DataError, match="has no end"), reading(tmp_path / "run.h5"):
        pass
    far = bytes(4 * gate._BLOCK) + bad[userblock:]  # there HDF5 looks for a file as well
    with pytest.raises(ValueError, match="has no end"):
        gate.image(far)


def test_addresses_of_another_length_are_refused():
    content = bytearray(old_groups())
    assert content[13:15] == b"\x08\x08"
    content[14] = 4
    with pytest.raises(ValueError, match="eight bytes"):
        gate.image(bytes(content))


def test_a_text_of_any_length_is_no_attribute():
    """It lies in a heap without a checksum, which HDF5 may search for ever."""
    with h5py.File(io.BytesIO(), "w") as file:
        file.attrs.create("title", "long", shape=(), dtype=h5py.string_dtype())
        assert gate.text_of(file, "title") is None
        with pytest.raises(ValueError, match="of another kind than rsc writes"):
            gate.attributes(file, {"title": ()}, most=1000)
