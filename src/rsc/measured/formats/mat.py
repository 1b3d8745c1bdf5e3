"""MAT-files of level 5 by rsc.files.mat5, of level 7.3, which are HDF5 files, as such: variables and fields of structs.

A vector is a channel, and so is each column of a matrix. Structs of Simcenter Testlab (x_values with start_value and increment,
y_values with values) say when their samples were taken.
"""

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from rsc.files import memory as cap
from rsc.files.mat5 import MatError, read_mat5
from rsc.files.memory import Memory
from rsc.measured.channel import Channel, NoColumns, Recording
from rsc.measured.formats.arrays import LEAST, ArrayChannel, channels_of, column

Arrays: TypeAlias = dict[str, tuple[tuple[int, ...], Callable[[], Any]]]  # name -> shape, what reads it

RATES = ("fs", "sr", "rate", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency")
STEPS = ("dt", "ts", "deltat", "interval", "sampleinterval", "samplingperiod")
_AXIS, _VALUES = "x_values.", "y_values."
_DEEPEST = 6


def recognises(head: bytes) -> bool:
    """Whether a file's first 128 bytes are those of a MAT-file of level 5."""
    return head[126:128] in (b"IM", b"MI") and head[124:126] in (b"\0\1", b"\1\0")


def open_mat(content: bytes) -> Recording:
    """Its vectors and matrices as channels."""
    try:
        arrays: Arrays = {}
        _collect(read_mat5(content, cap.MOST), arrays)
    except MatError as error:
        raise NoColumns(f"cannot be read as a MAT-file: {error}") from None
    places = [place for name, (shape, _) in arrays.items() for place in channels_of(name, shape)]

    def read(wanted: Sequence[int], memory: Memory) -> list[NDArray[np.float64]]:
        matrices: dict[str, Any] = {}
        for i in wanted:
            name, shape = places[i].name, places[i].shape
            if name not in matrices:
                if places[i].column is not None:
                    memory.take(name[:40], int(np.prod(shape)))
                matrices[name] = _dense(arrays[name][1], name)
        return [column(matrices[places[i].name], places[i]) for i in wanted]

    return Recording(tuple(_channel(place, arrays) for place in places), read, told_of(_scalars(arrays)))


def _collect(variables: dict[str, Any], arrays: Arrays, prefix: str = "", depth: int = 0) -> None:
    for name, (shape, read) in variables.items():
        if shape is not None:
            arrays[prefix + name] = shape, read
        elif depth < _DEEPEST:
            try:
                fields = read()
            except MatError:  # text, cells, complex numbers
                continue
            if isinstance(fields, dict):
                _collect(fields, arrays, f"{prefix}{name}.", depth + 1)


def _dense(read: Callable[[], Any], name: str) -> Any:
    try:
        array = read()
    except MatError as error:
        raise NoColumns(f"cannot be read as a MAT-file: {error}") from None
    if scipy.sparse.issparse(array):
        raise NoColumns(f"its variable {name[:40]} is a sparse matrix, not a signal")
    return array


def _channel(place: ArrayChannel, arrays: Arrays) -> Channel:
    """A channel with the start and the interval that its struct says."""
    before, values, _ = place.name.rpartition(_VALUES)
    start = _scalar(arrays, f"{before}{_AXIS}start_value") if values else None
    interval = _scalar(arrays, f"{before}{_AXIS}increment") if values else None
    if interval is not None and not interval > 0.0:
        raise NoColumns(f"states {interval:g} s between the samples of {place.name[:40]}")
    return Channel(place.names, place.samples, start=start, interval=interval)


def _scalar(arrays: Arrays, name: str) -> float | None:
    if name not in arrays or max(arrays[name][0], default=0) >= LEAST or 0 in arrays[name][0]:
        return None
    return float(np.asarray(_dense(arrays[name][1], name)).reshape(-1)[0])


def _scalars(arrays: Arrays) -> dict[str, float]:
    """Single numbers named like a sampling rate or interval."""
    named = [name for name in arrays if plain(name) in RATES + STEPS]
    return {name: value for name in named if (value := _scalar(arrays, name)) is not None}


def plain(name: str) -> str:
    """The last part of a name in small letters alone: "Data.Sample_Rate" is samplerate."""
    last = name.replace("/", ".").rpartition(".")[2]
    return "".join(letter for letter in last.lower() if letter.isalpha())


def told_of(scalars: dict[str, float]) -> tuple[str, ...]:
    """Remarks on numbers that may be the sampling rate; they are reported and not used."""
    words = "may be the samples a second, or the interval: not used"
    return tuple(f"its {name[:40]} = {value:g} {words}" for name, value in scalars.items())
