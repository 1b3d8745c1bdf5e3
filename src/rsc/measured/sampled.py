"""Sampling times of the channels of a file: from a time column, the format, or the rate in the table."""

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, one_line
from rsc.measured.channel import Channel
from rsc.measured.clock import Signal
from rsc.measured.keys import Channels
from rsc.measured.reading import Selection
from rsc.measured.scales import rate_of, seconds
from rsc.measured.times import Even, even_times, evenly

_LATEST = 1e12  # s


def signals_of(
    table: Channels, selection: Selection, values: dict[str, NDArray[np.float64]], source: str
) -> tuple[dict[str, Signal], list[str]]:
    """The signals of a file at even times each, NaN where one has no sample, and what to tell.

    Parameters
    ----------
    table : Channels
    selection : Selection
    values : the numbers of the channels by the names that the table has for them
    source : name of the file
    """
    evens: dict[int, Even] = {}
    signals, told = {}, []
    for name, numbers in values.items():
        channel = selection.channels[name]
        clock = _times_of(table, selection, channel)
        if clock is None:
            even = _by_rate(table, channel, source)
        else:
            if clock.count != channel.count:
                listed = f"{one_line(name)[:40]} {channel.count}, its times {clock.count}"
                raise DataError(source, f"its columns have not one length ({listed})")
            if id(clock) not in evens:
                size, lines = seconds(table, clock, source)
                evens[id(clock)] = even_times(np.asarray(clock.numbers), size, source)
                told += [*lines, *evens[id(clock)].told]
            even = evens[id(clock)]
        signals[name] = Signal(one_line(name)[:40], even.start, even.step, _placed(numbers, even))
    silent = [name for name in values if selection.channels[name].start is None]
    spoken = [name for name in values if selection.channels[name].start]
    if silent and spoken and table.time is None:
        told.append(f"the file does not say when {one_line(silent[0])[:40]} began: taken to begin with the first channel")
    if table.rate is not None and any(selection.channels[name].clock is not None for name in values):
        told.append("the times in the file are not used: measured.rate is given")
    return signals, told


def _times_of(table: Channels, selection: Selection, channel: Channel) -> Channel | None:
    """The channel that has the times of another one; None where a rate has them."""
    if table.time is not None:
        return selection.channels[table.time]
    if channel.clock is None or table.rate is not None:
        return None
    return selection.clocks[channel.clock]


def _by_rate(table: Channels, channel: Channel, source: str) -> Even:
    rate = rate_of(table, channel, source)
    if channel.start is not None and not abs(channel.start) <= _LATEST:
        raise DataError(source, f"says that a channel begins at {channel.start:g} s: no time of a measurement")
    if rate is None:
        raise DataError(source, "has no times: measured.time or measured.rate must be given")
    return evenly(channel.start or 0.0, 1.0 / rate if rate > 0.0 else np.inf, channel.count, source)


def _placed(values: NDArray[np.float64], even: Even) -> NDArray[np.float64]:
    """The values at even times, NaN where the file has no sample."""
    placed = np.full(even.samples, np.nan)
    placed[even.place[even.place >= 0]] = values[even.place >= 0]
    return placed
