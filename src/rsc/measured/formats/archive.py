"""NumPy's .npz and .npy: a channel for each array of one axis, and for each column of an array of two."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rsc.files.memory import Memory, TooLarge
from rsc.machine.formats import npz
from rsc.machine.formats.entries import BadMatrix
from rsc.measured.channel import Channel, NoColumns, Recording
from rsc.measured.formats.arrays import ArrayChannel, channels_of, column

MAGIC = npz.MAGIC_ZIP, npz.MAGIC_ARRAY
_ALONE = "array"  # name of the array of a .npy file, for messages; its columns are called by their numbers


def recognises(head: bytes) -> bool:
    """Whether a file begins as these do."""
    return head.startswith(MAGIC)


def open_archive(content: bytes) -> Recording:
    """The channels of an archive."""
    if content.startswith(npz.MAGIC_ARRAY):
        shape = npz.shape_of(content)
        if shape is None or len(shape) != 2:
            raise NoColumns("is a single array without columns of numbers; keep each column by its name in a .npz file")
        places = [ArrayChannel("", shape, i) for i in range(min(shape))]
    else:
        places = [place for name, shape in _shapes(content).items() if shape for place in channels_of(name, shape)]

    def read(wanted: Sequence[int], memory: Memory) -> list[NDArray[np.float64]]:
        names = {places[i].name for i in wanted}
        if content.startswith(npz.MAGIC_ARRAY):
            arrays = {"": npz.array_of(content, memory, _ALONE)}
        else:
            arrays = npz.arrays_of(content, memory, names)
        return [column(arrays[places[i].name], places[i]) for i in wanted]

    return Recording(tuple(Channel(place.names, place.samples) for place in places), read)


def _shapes(content: bytes) -> dict[str, tuple[int, ...] | None]:
    try:
        return npz.shapes_of(content)
    except (BadMatrix, TooLarge):
        raise
    except Exception as error:  # zipfile raises nearly anything for a damaged archive
        raise NoColumns(f"damaged archive: {type(error).__name__}") from None
