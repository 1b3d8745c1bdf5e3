"""HDF5, and MAT-files of level 7.3: a channel for each array of one axis, and for each column of an array of two.

What its attributes say is used: units, the interval and start of waveforms (as npTDMS exports them), scale_factor, add_offset and
_FillValue (CF conventions, of netCDF files).
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.errors import one_line
from rsc.files import gate
from rsc.files.memory import Memory, TooLarge
from rsc.measured.channel import Channel, NoColumns, Recording
from rsc.measured.formats.arrays import ArrayChannel, channels_of, column
from rsc.measured.formats.mat import RATES, STEPS, plain, told_of

MAGIC = b"\x89HDF\r\n\x1a\n"
_USER_BLOCK = 512  # before which MATLAB writes a header of its own
_DEEPEST, _MOST_NAMES = 6, 1000
_UNITS = ("units", "unit", "Unit", "Units", "unit_string", "NI_UnitDescription")
_INTERVALS, _STARTS = ("wf_increment", "dt", "increment", "interval"), ("wf_start_offset", "t0", "x0", "start")
_FACTOR, _OFFSET, _MISSING = "scale_factor", "add_offset", ("_FillValue", "missing_value")


def recognises(head: bytes) -> bool:
    """Whether a file's first bytes are those of an HDF5 file, with MATLAB's header or without."""
    return head.startswith(MAGIC) or head[_USER_BLOCK:].startswith(MAGIC)


def open_hdf5(content: bytes) -> Recording:
    """Its arrays as channels, called "group/array", those of a MAT-file "struct.field"."""
    join = "/" if content.startswith(MAGIC) else "."
    channels: list[Channel] = []
    places: list[ArrayChannel] = []
    paths: list[str] = []
    scalars: dict[str, float] = {}
    with _opened(content) as file:
        for path, data in _arrays(file, "", 0, iter(range(_MOST_NAMES))):
            name = path.replace("/", join)
            if plain(name) in RATES + STEPS and data.size == 1 and data.dtype.kind in "fiu":
                scalars[name] = float(gate.numbers(data, name, Memory()).reshape(-1)[0])
            for place in channels_of(name, data.shape if join == "/" else data.shape[::-1], join):
                places.append(place)
                paths.append(path)
                channels.append(_channel(place, data))

    def read(wanted: Sequence[int], memory: Memory) -> list[NDArray[np.float64]]:
        values: dict[str, Any] = {}
        with _opened(content) as file:
            for i in wanted:
                if paths[i] not in values:
                    values[paths[i]] = _values(file[paths[i]], places[i].name, memory)
        return [column(values[paths[i]] if join == "/" else values[paths[i]].T, places[i]) for i in wanted]

    return Recording(tuple(channels), read, told_of(scalars))


def _arrays(group: Any, prefix: str, depth: int, visits: Iterator[int]) -> Iterator[tuple[str, Any]]:
    """(path, array of numbers) of a group; `visits` has an item for each name that is looked at: groups may hold themselves."""
    for name in group:
        if next(visits, None) is None or depth > _DEEPEST:
            raise NoColumns("it holds too many arrays")
        if name.startswith("#") or not gate.is_own(group, name):
            continue  # what cells of MATLAB point to; files elsewhere
        member = group[name]
        if hasattr(member, "keys"):
            if gate.short_attribute(member, "MATLAB_sparse") is None:
                yield from _arrays(member, f"{prefix}{name}/", depth + 1, visits)
        elif _holds_numbers(member):
            yield prefix + name, member


def _holds_numbers(member: Any) -> bool:
    numbers = bool(getattr(member, "shape", ())) and member.dtype.kind in "fiu"
    return numbers and gate.short_attribute(member, "MATLAB_class") not in (b"char", b"logical", b"cell")


def _channel(place: ArrayChannel, data: Any) -> Channel:
    unit = next((text for key in _UNITS if (text := gate.text_attribute(data, key))), "")
    interval = next((value for key in _INTERVALS if (value := _number(data, key)) is not None), None)
    start = next((value for key in _STARTS if (value := _number(data, key)) is not None), None)
    if interval is not None and not interval > 0.0:
        raise NoColumns(f"states {interval:g} s between the samples of {one_line(place.name)[:40]}")
    return Channel(place.names, place.samples, unit[:40], "", start if interval is not None else None, interval)


def _number(data: Any, key: str, finite: bool = True) -> float | None:
    """An attribute that must be a number; None without it."""
    if key not in data.attrs:
        return None
    value = gate.short_attribute(data, key)
    number = math.nan if value is None or isinstance(value, bytes | str) or np.size(value) != 1 else float(np.ravel(value)[0])
    if finite and not math.isfinite(number):
        raise NoColumns(f"its attribute {key} of {one_line(data.name)[:40]} is no number")
    return number


def _values(data: Any, name: str, memory: Memory) -> NDArray[Any]:
    """The numbers of an array, scaled as it says."""
    values = gate.numbers(data, name, memory, gate.PACKED_BY | {gate.LZF})
    factor, offset = _number(data, _FACTOR), _number(data, _OFFSET)
    missing = [value for key in _MISSING if (value := _number(data, key, finite=False)) is not None]
    if factor is None and offset is None and not missing:
        return values
    known = np.where(np.isin(values, missing), np.nan, values) if missing else np.asarray(values, dtype=float)
    return known * (1.0 if factor is None else factor) + (0.0 if offset is None else offset)


class _opened:
    """The open file; any exception of h5py for a damaged one becomes one line."""

    def __init__(self, content: bytes) -> None:
        self._content = content

    def __enter__(self) -> Any:
        try:
            self._file = gate.image(self._content)
        except Exception as error:
            raise NoColumns(f"damaged HDF5 file: {type(error).__name__}") from None
        return self._file

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        self._file.close()
        if isinstance(error, Exception) and not isinstance(error, NoColumns | TooLarge):
            problem = one_line(error)[:100] if type(error) is ValueError else type(error).__name__
            raise NoColumns(f"damaged HDF5 file: {problem}") from None
