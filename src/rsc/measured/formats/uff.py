"""UFF-58 and 58b: the time responses of a universal file, by pyuff."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.errors import one_line
from rsc.files.memory import Memory
from rsc.measured.channel import MOST_COLUMNS, Channel, NoColumns, Recording
from rsc.measured.formats.library import imported
from rsc.measured.stated import seconds_of

# pyuff makes an object of every line and of every number
_MOST_BYTES, _MOST_LINES = 128 * 2**20, 2_000_000
_TIME_RESPONSE = 1  # function type of a dataset
_REAL = 2, 4  # its data types that are no complex numbers
_EVEN = 1  # its spacing of the abscissa
_QUANTITIES = {8: "displacement", 9: "force", 11: "velocity", 12: "acceleration"}  # of its ordinate
_NO_UNIT = ("", "NONE")


def recognises(head: bytes) -> bool:
    """Whether a file begins as universal files do: with a line of -1 in columns 5 and 6."""
    return head[:200].lstrip(b"\r\n").startswith(b"    -1")


def open_uff(content: bytes, path: Path) -> Recording:
    """Its time responses, named by their first line of text; times of a non-uniform one follow as a channel."""
    pyuff = imported("pyuff", "UFF-58")
    if len(content) > _MOST_BYTES or content.count(b"\n") > _MOST_LINES:
        most = f"{_MOST_BYTES >> 20} MB or {_MOST_LINES} lines"
        raise NoColumns(f"a universal file of more than {most}; keep its channels in a .npz file")
    try:
        file = pyuff.UFF(str(path))  # it takes no content, and reads the file again
        kinds = np.asarray(file.get_set_types())
        places = np.flatnonzero(kinds == 58).tolist()
        heads = [(place, file.read_sets(place, header_only=True)) for place in places[: MOST_COLUMNS + 1]]
    except Exception as error:  # pyuff raises plain exceptions
        raise NoColumns(f"cannot be read as UFF-58: {one_line(error)[:100]}") from None
    responses = [(place, one) for place, one in heads if one["func_type"] == _TIME_RESPONSE and one["ord_data_type"] in _REAL]
    if not responses or len(heads) > MOST_COLUMNS:
        raise NoColumns(f"has {len(responses)} time responses (datasets 58 of function type 1); 1 to {MOST_COLUMNS} can be read")
    channels: list[Channel] = []
    sources: list[tuple[int, str, int]] = []
    for place, one in responses:
        even, count = one["abscissa_spacing"] == _EVEN, max(int(one["num_pts"]), 0)
        channels.append(_channel(one, count, None if even else len(channels) + 1))
        sources.append((place, "data", count))
        if not even:
            channels.append(Channel((), count, unit=_unit(one, "abscissa")))
            sources.append((place, "x", count))

    def read(wanted: Sequence[int], memory: Memory) -> list[NDArray[np.float64]]:
        datasets: dict[int, Any] = {}
        for place in {sources[i][0] for i in wanted}:
            try:
                datasets[place] = file.read_sets(place)
            except Exception as error:
                raise NoColumns(f"cannot be read as UFF-58: {one_line(error)[:100]}") from None
        return [_numbers(datasets[sources[i][0]], *sources[i][1:]) for i in wanted]

    told = ("its dataset 164 states units of its own: not used",) if (kinds == 164).any() else ()
    return Recording(tuple(channels), read, told)


def _channel(one: Any, count: int, clock: int | None) -> Channel:
    name = one["id1"].strip()
    start, interval, second = None, None, seconds_of(_unit(one, "abscissa"))
    if clock is None and second is not None:
        start, interval = second * float(one["abscissa_min"]), second * float(one["abscissa_inc"])
    if interval is not None and not interval > 0.0:
        raise NoColumns(f"states {interval:g} s between the samples of {one_line(name)[:40]}")
    quantity = _QUANTITIES.get(one["ordinate_spec_data_type"], "")
    return Channel((name,) if name else (), count, _unit(one, "ordinate"), quantity, start, interval, clock)


def _unit(one: Any, axis: str) -> str:
    unit = str(one[f"{axis}_axis_units_lab"]).strip()
    return "" if unit.upper() in _NO_UNIT else unit


def _numbers(dataset: Any, part: str, count: int) -> NDArray[np.float64]:
    if len(dataset[part]) < count:
        raise NoColumns("is cut off: a time response has fewer samples than its head says")
    return np.asarray(dataset[part][:count], dtype=float)
