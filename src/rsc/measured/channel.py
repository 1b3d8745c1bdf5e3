"""What every format makes of its file: channels, each with its name, its unit, when it was sampled, and its numbers."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from rsc.files.memory import Memory

MOST_COLUMNS = 256


class NoColumns(ValueError):
    """Why a file holds no columns of numbers, in one line."""


@dataclass(frozen=True)
class Channel:
    """One signal of a file, and all that its format says of it.

    Attributes
    ----------
    names : the names by which a table may ask for it, the one in messages first; none where it has only its number in the file
    count : samples; of a text the most that it can have, before it is read
    unit : of a one in its numbers, as the file writes it; "" where it says nothing
    quantity : what it measures, as the file says: "acceleration"; "" where it says nothing
    start : s, when its first sample was taken, counted from one moment for all channels of the file; None where it does not say
    interval : s between samples, None where it does not say
    clock : number in the file, from 0, of the channel that has its times; None without one
    numbers : (n,) as the file has them, scaled as it says; None before they are read
    """

    names: tuple[str, ...]
    count: int
    unit: str = ""
    quantity: str = ""
    start: float | None = None
    interval: float | None = None
    clock: int | None = None
    numbers: NDArray[np.float64] | None = field(default=None, repr=False)


# numbers of the channels that are wanted (from 0), what they may take -> their numbers in that order
Reading: TypeAlias = Callable[[Sequence[int], Memory], list[NDArray[np.float64]]]


@dataclass(frozen=True)
class Recording:
    """A file that was inspected, before its numbers are read.

    Attributes
    ----------
    channels : in the order of the file, by which their numbers from "1" on are counted
    read : takes the numbers of some of them
    told : what the format says of its channels and rsc does not use, in lines
    full_scale : whether a one is the largest number that the format can write, and not a one of a unit
    """

    channels: tuple[Channel, ...]
    read: Reading
    told: tuple[str, ...] = ()
    full_scale: bool = False
