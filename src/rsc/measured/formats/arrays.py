"""Arrays of one and two axes as channels: the long axis is time, and each column of the short one a channel."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.measured.channel import MOST_COLUMNS

LEAST = 2  # numbers, below which an array is a single value


class ArrayChannel(NamedTuple):
    """A channel in an array: its name, its shape, and which of its columns it is, None where it has only one."""

    name: str
    shape: tuple[int, ...]
    column: int | None = None
    join: str = "."

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the channel: "data.2" is the second column of the array data; none where the array has no name."""
        if self.column is None:
            return (self.name,)
        return (f"{self.name}{self.join}{self.column + 1}",) if self.name else ()

    @property
    def samples(self) -> int:
        """Its samples."""
        return max(self.shape)


def channels_of(name: str, shape: tuple[int, ...], join: str = ".") -> list[ArrayChannel]:
    """The channels of an array; none of a single value, of more than two axes, or of two that are both long."""
    long = [length for length in shape if length != 1]
    if len(shape) > 2 or not long or max(long) < LEAST:
        return []
    if len(long) == 1:
        return [ArrayChannel(name, shape, join=join)]
    return [ArrayChannel(name, shape, i, join) for i in range(min(long))] if min(long) <= MOST_COLUMNS else []


def column(array: Any, place: ArrayChannel) -> NDArray[np.float64]:
    """The numbers of a channel from its array."""
    if place.column is None:
        return np.asarray(array, dtype=float).reshape(-1)
    along = array[:, place.column] if array.shape[0] >= array.shape[1] else array[place.column]
    return np.asarray(along, dtype=float)
