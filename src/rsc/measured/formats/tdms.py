"""TDMS of LabVIEW and its kin: channels of numbers, scaled as the file says, by npTDMS."""

import contextlib
import io
import logging
import math
from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.errors import one_line
from rsc.files.memory import Memory
from rsc.measured.channel import MOST_COLUMNS, Channel, NoColumns, Recording
from rsc.measured.formats.library import imported
from rsc.measured.stated import seconds_of

MAGIC = b"TDSm"
_MOST_PARTS = 200_000  # pieces in which channels are written, each read by itself
_NOT_SET = np.datetime64("1904-01-02")  # a time of LabVIEW before it was never set: they count from 1904 on
_UNITS = ("unit_string", "NI_UnitDescription")


def recognises(head: bytes) -> bool:
    """Whether a file begins as TDMS files do."""
    return head.startswith(MAGIC)


def open_tdms(content: bytes) -> Recording:
    """Its channels, each called by its name and by that of its group, "group/channel"; when they began by their waveforms."""
    if content.count(MAGIC) > _MOST_PARTS or content.count(b"/'") > 2 * _MOST_PARTS:
        raise NoColumns(f"a TDMS file of more than {_MOST_PARTS} segments or names; keep its channels in a .npz file")
    with _opened(content) as file:
        if file.file_status.channel_statuses is not None:  # told of files only whose last piece is not whole
            raise NoColumns("is cut off: its last segment has fewer samples than its head says")
        signals = [one for group in file.groups() for one in group.channels() if len(one) and one.dtype.kind in "iuf"]
        if not 0 < len(signals) <= MOST_COLUMNS:
            raise NoColumns(f"has {len(signals)} channels of numbers; 1 to {MOST_COLUMNS} can be read")
        if sum(map(len, signals)) > len(content):
            raise NoColumns("damaged TDMS file: it says to have more samples than bytes")
        told: list[str] = []
        places = [(one.group_name, one.name) for one in signals]
        begins = [_begin(one, told) for one in signals]
        first = min((begin for begin, _ in begins if begin is not None), default=None)
        channels = tuple(_channel(one, *begin, first) for one, begin in zip(signals, begins, strict=True))

    def read(wanted: Sequence[int], memory: Memory) -> list[NDArray[np.float64]]:
        with _opened(content) as file:
            return [_samples(file[places[i][0]][places[i][1]]) for i in wanted]

    return Recording(channels, read, tuple(dict.fromkeys(told)))


def _begin(channel: Any, told: list[str]) -> tuple[Any, float | None]:
    """(when a channel was started, None where it does not say; seconds from there to its first sample)."""
    begin, offset = channel.properties.get("wf_start_time"), _number(channel, "wf_start_offset")
    if begin is not None:
        try:
            begin = np.datetime64(begin, "ns")
        except (TypeError, ValueError):
            told.append(f"its wf_start_time of {one_line(channel.name)[:40]} is no time: not used")
            begin = None
    second = seconds_of(str(channel.properties.get("wf_xunit_string", ""))[:40]) or 1.0
    return (None if begin is None or np.isnat(begin) or begin < _NOT_SET else begin), offset and second * offset


def _channel(channel: Any, begin: Any, offset: float | None, first: Any) -> Channel:
    start = offset if first is None else None  # beside channels that say when they began, an offset alone says nothing
    if begin is not None:
        start = (offset or 0.0) + float((begin - first) / np.timedelta64(1, "ns")) * 1e-9
    unit = next((str(channel.properties[key]) for key in _UNITS if channel.properties.get(key)), "")
    interval, second = _number(channel, "wf_increment"), seconds_of(str(channel.properties.get("wf_xunit_string", ""))[:40])
    if second is None or (interval is not None and not interval > 0.0):
        start = interval = None  # a spectrum; LabVIEW writes 0 where it was never set
    elif interval is not None:
        interval *= second
    return Channel((channel.name, f"{channel.group_name}/{channel.name}"), len(channel), unit[:40], "", start, interval)


def _number(channel: Any, key: str) -> float | None:
    """A property that must be a finite number; None without it."""
    value = channel.properties.get(key)
    if value is None:
        return None
    real = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not real or not math.isfinite(value):
        raise NoColumns(f"its {key} of {one_line(channel.name)[:40]} is no number: {one_line(repr(value))[:40]}")
    return float(value)


def _samples(channel: Any) -> NDArray[np.float64]:
    """The samples of a channel, read piece by piece, so that a file of tiny ones ends."""
    samples, place = np.empty(len(channel)), 0
    for number, chunk in enumerate(channel.data_chunks()):
        if number > _MOST_PARTS:
            raise NoColumns(f"a TDMS file of more than {_MOST_PARTS} pieces; keep its channels in a .npz file")
        part = np.asarray(chunk[:], dtype=float)
        samples[place : place + len(part)] = part
        place += len(part)
    if place != len(samples):
        raise NoColumns("is cut off: a channel has fewer samples than its head says")
    return samples


@contextlib.contextmanager
def _opened(content: bytes) -> Iterator[Any]:
    """The open file; any exception of npTDMS for a damaged one becomes one line."""
    nptdms = imported("nptdms", "TDMS")
    try:
        with _silent(nptdms), nptdms.TdmsFile.open(io.BytesIO(content)) as file:
            yield file
    except NoColumns:
        raise
    except Exception as error:
        raise NoColumns(f"cannot be read as TDMS: {one_line(error)[:100] or type(error).__name__}") from None


@contextlib.contextmanager
def _silent(nptdms: ModuleType) -> Iterator[None]:
    """Suppresses messages that npTDMS prints for damaged files."""
    before = nptdms.log.log_manager.log_level
    nptdms.log.log_manager.set_level(logging.CRITICAL + 1)
    try:
        yield
    finally:
        nptdms.log.log_manager.set_level(before)
