"""The channels of a measured file that a table names, whatever its format; no others are read."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rsc.errors import DataError, nearest, one_line
from rsc.files import memory
from rsc.files.content import content_of
from rsc.files.memory import Memory, TooLarge
from rsc.machine.formats.entries import BadMatrix
from rsc.measured.channel import Channel, NoColumns, Recording
from rsc.measured.formats import recording_of

_SHOWN = 12  # names of channels in a message
_RUN = 8  # numbers of every sample beside those of the channels, while a run is made of them


class Selection(NamedTuple):
    """What a table asked for: a channel for each name, with its numbers; the channels with the times of others, by their number
    in the file; what the format says and is not used; whether numbers are parts of the largest that the format can write."""

    channels: dict[str, Channel]
    clocks: dict[int, Channel]
    told: tuple[str, ...]
    full_scale: bool


def channels_of(path: Path, names: Sequence[str]) -> Selection:
    """The channels of a file by the names that a table has for them.

    Raises
    ------
    DataError
        For a file that cannot be read, is too large, holds no columns of numbers, or none of a name: in one line.
    """
    source = one_line(path)
    content = content_of(path, memory.MOST_FILE)
    try:
        recording = recording_of(content, path)
        places = {name: _place(recording, name) for name in names}
        clocks = {clock for place in places.values() if (clock := recording.channels[place].clock) is not None}
        wanted = sorted({*places.values(), *clocks})
        budget = Memory(memory.MOST)
        budget.take("the run", _RUN * max(recording.channels[place].count for place in wanted))
        for place in wanted:
            budget.take(_name(recording, place)[:40], recording.channels[place].count)
        numbers = dict(zip(wanted, recording.read(wanted, budget), strict=True))
    except (BadMatrix, NoColumns, TooLarge) as error:
        raise DataError(source, one_line(error)) from None
    except (MemoryError, RecursionError):
        raise DataError(source, "its channels do not fit into memory") from None
    except DataError:
        raise
    except Exception as error:  # libraries raise nearly anything for a damaged file
        raise DataError(source, f"is damaged: {type(error).__name__}: {one_line(error)[:80]}") from None

    def filled(place: int) -> Channel:
        values = np.asarray(numbers[place], dtype=float)
        return replace(recording.channels[place], numbers=values, count=len(values))

    channels = {name: filled(place) for name, place in places.items()}
    return Selection(channels, {place: filled(place) for place in clocks}, recording.told, recording.full_scale)


def _place(recording: Recording, name: str) -> int:
    """The number, from 0, of the channel that a table calls by a name or by its number from "1" on."""
    channels = recording.channels
    called = [i for i, channel in enumerate(channels) if name in channel.names]
    if len(called) == 1:
        return called[0]
    if called:
        numbers = ", ".join(f'"{i + 1}"' for i in called[:4])
        raise NoColumns(f"has {len(called)} columns {one_line(name)[:60]!r}: ask for one by its number, {numbers}")
    if name.isdecimal() and 0 < int(name[:6]) <= len(channels) and len(name) <= 6:
        return int(name) - 1
    known = [_name(recording, i) for i in range(len(channels))]
    hint = nearest(name, known) or f"it has {', '.join(known[:_SHOWN])} and {len(known) - _SHOWN} more"
    raise NoColumns(f"has no column {one_line(name)[:60]!r} ({one_line(hint)})")


def _name(recording: Recording, place: int) -> str:
    names = recording.channels[place].names
    return names[0] if names else str(place + 1)
