"""Recordings that know their rate: WAV, and of laboratories UFF-58 and TDMS, whose readers are extras."""

import contextlib
import importlib
import io
import logging
import warnings
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rsc.errors import one_line

Recorded: TypeAlias = tuple[dict[str, NDArray[np.float64]], float | None]  # columns by their names, samples a second

MOST_COLUMNS = 256
MAGIC_WAV, MAGIC_TDMS = (b"RIFF", b"RIFX", b"RF64"), b"TDSm"
# pyuff makes an object of every line and of every number
_MOST_BYTES_OF_UFF, _MOST_LINES_OF_UFF = 128 * 2**20, 2_000_000
_MOST_PARTS_OF_TDMS = 200_000  # pieces in which channels are written, each read by itself
_TIME_RESPONSE = 1  # function type of a UFF-58 dataset
_REAL = 2, 4  # its data types that are no complex numbers
_ALIKE = 1e-6  # relative, sample intervals of one rate


class NoColumns(ValueError):
    """Why a file holds no columns of numbers, in one line."""


def wav(content: bytes) -> Recorded:
    """Channels of a WAV file, over its largest number, called by their numbers from "1" on."""
    from scipy.io import wavfile

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", wavfile.WavFileWarning)  # cut off, for example
            rate, data = wavfile.read(io.BytesIO(content))
    except Exception as error:  # it raises nearly anything for a damaged file
        raise NoColumns(f"cannot be read as WAV: {one_line(error)[:100]}") from None
    data = data.reshape(len(data), -1) if data.size else np.empty((0, 0))
    if not rate > 0 or not data.size or data.shape[1] > MOST_COLUMNS:
        raise NoColumns("a WAV file without samples, or with too many channels")
    largest = {"u": 128.0, "i": float(2 ** (8 * data.itemsize - 1)), "f": 1.0}[data.dtype.kind]
    middle = 128.0 if data.dtype.kind == "u" else 0.0
    return {str(i + 1): (data[:, i] - middle) / largest for i in range(data.shape[1])}, float(rate)


def is_uff(content: bytes) -> bool:
    """Whether a file begins as universal files do: with a line of -1 in columns 5 and 6."""
    return content[:200].lstrip(b"\r\n").startswith(b"    -1")


def uff(content: bytes, path: Path) -> Recorded:
    """Time responses of the datasets 58 and 58b of a universal file, in its units, called by their first line of text where these
    differ."""
    pyuff = _reader("pyuff", "UFF-58")
    if len(content) > _MOST_BYTES_OF_UFF or content.count(b"\n") > _MOST_LINES_OF_UFF:
        most = f"{_MOST_BYTES_OF_UFF >> 20} MB or {_MOST_LINES_OF_UFF} lines"
        raise NoColumns(f"a universal file of more than {most}; keep its channels in a .npz file")
    try:
        file = pyuff.UFF(str(path))  # it takes no content, and reads the file again
        places = np.flatnonzero(np.asarray(file.get_set_types()) == 58).tolist()
        datasets = [file.read_sets(place) for place in places[: MOST_COLUMNS + 1]]
    except Exception as error:  # pyuff raises plain exceptions
        raise NoColumns(f"cannot be read as UFF-58: {one_line(error)[:100]}") from None
    responses = [one for one in datasets if one["func_type"] == _TIME_RESPONSE and one["ord_data_type"] in _REAL]
    if not responses or len(datasets) > MOST_COLUMNS:
        raise NoColumns(f"has {len(responses)} time responses (datasets 58 of function type 1); 1 to {MOST_COLUMNS} can be read")
    if any(one["abscissa_spacing"] != 1 for one in responses):
        raise NoColumns("has time responses with uneven times; keep its channels in a .npz file")
    if any(len(one["data"]) < one["num_pts"] for one in responses):
        raise NoColumns("is cut off: a time response has fewer samples than its head says")
    names = [one["id1"].strip() for one in responses]
    columns = [np.asarray(one["data"][: max(one["num_pts"], 0)], dtype=float) for one in responses]
    return _named(names, columns), _rate([one["abscissa_inc"] for one in responses])


def tdms(content: bytes) -> Recorded:
    """Channels of numbers of a TDMS file, scaled as it says, called by their names, where these repeat with that of their group.

    The rate is that of their waveforms, None where they are none.
    """
    nptdms = _reader("nptdms", "TDMS")
    if content.count(MAGIC_TDMS) > _MOST_PARTS_OF_TDMS or content.count(b"/'") > 2 * _MOST_PARTS_OF_TDMS:
        raise NoColumns(f"a TDMS file of more than {_MOST_PARTS_OF_TDMS} segments or names; keep its channels in a .npz file")
    try:
        with _silent(nptdms), nptdms.TdmsFile.open(io.BytesIO(content)) as file:
            if file.file_status.channel_statuses is not None:  # told of files only whose last piece is not whole
                raise NoColumns("is cut off: its last segment has fewer samples than its head says")
            channels = [one for group in file.groups() for one in group.channels() if len(one) and one.dtype.kind in "iuf"]
            if not 0 < len(channels) <= MOST_COLUMNS:
                raise NoColumns(f"has {len(channels)} channels of numbers; 1 to {MOST_COLUMNS} can be read")
            columns = _chunks(file, channels, len(content))
            increments = [one.properties.get("wf_increment") for one in channels]
            names = [one.name for one in channels]
            if len(set(names)) < len(names):
                names = [f"{one.group_name}/{one.name}" for one in channels]
    except NoColumns:
        raise
    except Exception as error:  # it raises nearly anything for a damaged file
        raise NoColumns(f"cannot be read as TDMS: {one_line(error)[:100] or type(error).__name__}") from None
    return _named(names, columns), None if None in increments else _rate([float(one) for one in increments])


def _chunks(file: Any, channels: list[Any], size: int) -> list[NDArray[np.float64]]:
    """The samples of channels of a TDMS file, read piece by piece, so that a file of tiny ones ends."""
    pieces: list[list[Any]] = [[] for _ in channels]
    if sum(map(len, channels)) > size:
        raise NoColumns("damaged TDMS file: it says to have more samples than bytes")
    for number, chunk in enumerate(file.data_chunks()):
        if number * len(channels) > _MOST_PARTS_OF_TDMS:
            raise NoColumns(f"a TDMS file of more than {_MOST_PARTS_OF_TDMS} pieces; keep its channels in a .npz file")
        for own, channel in zip(pieces, channels, strict=True):
            own.append(np.asarray(chunk[channel.group_name][channel.name][:], dtype=float))
    return [np.concatenate(own) for own in pieces]


@contextlib.contextmanager
def _silent(nptdms: ModuleType) -> Iterator[None]:
    """It prints what it meets in a damaged file, which may be anything."""
    before = nptdms.log.log_manager.log_level
    nptdms.log.log_manager.set_level(logging.CRITICAL + 1)
    try:
        yield
    finally:
        nptdms.log.log_manager.set_level(before)


def _reader(module: str, kind: str) -> ModuleType:
    try:
        return importlib.import_module(module)
    except ImportError:
        raise NoColumns(f'is {kind}, whose reader is an extra: pip install "rotor-stator-contact[measured]"') from None


def _named(names: list[str], columns: list[NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
    """Columns of one length by their names; by their numbers from "1" on where names repeat."""
    if len({len(column) for column in columns}) != 1:
        lengths = ", ".join(f"{one_line(name)[:40]} {len(column)}" for name, column in zip(names[:5], columns, strict=False))
        raise NoColumns(f"its channels have not one length ({lengths})")
    if len(set(names)) < len(names) or not all(names):
        names = [str(i + 1) for i in range(len(columns))]
    return dict(zip(names, columns, strict=True))


def _rate(increments: list[float]) -> float:
    first = increments[0]
    if not first > 0.0 or any(not abs(one - first) <= _ALIKE * first for one in increments):
        raise NoColumns("its channels have not one rate")
    return 1.0 / first
