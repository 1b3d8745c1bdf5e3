"""LabVIEW measurement files (.lvm): two heads of keys, a line of names, rows.

National Instruments, "Specification for the LabVIEW Measurement File": X_Columns says whether the rows have one column of times,
one for each channel, or none, where X0 and Delta_X tell them.
"""

import re
from typing import Any

from rsc.measured.channel import NoColumns, Recording
from rsc.measured.formats.rows import NUMBER, RowForm
from rsc.measured.formats.text import as_ascii, decoded, recording
from rsc.measured.stated import seconds_of

MAGIC = b"LabVIEW Measurement"
_END = "***End_of_Header***"
_LONGEST_HEAD = 200_000  # bytes
_SEPARATORS = {"Tab": "\t", "Comma": ","}
_NEVER = {"", "Comment"}


def recognises(head: bytes) -> bool:
    """Whether a text begins as these files do."""
    return head.removeprefix(b"\xef\xbb\xbf").startswith(MAGIC)


def open_lvm(content: bytes) -> Recording:
    """The columns without comments, with their units and, without a time column, their rate."""
    content = as_ascii(content)
    ends = [match.start() for match in re.finditer(re.escape(_END.encode()), content[:_LONGEST_HEAD])]
    if not ends or content.count(_END.encode()) > 2:
        raise NoColumns("a LabVIEW measurement file of several segments, or without the end of its head; save one segment")
    begin = content.find(b"\n", ends[-1]) + 1
    head = decoded(content[:begin])
    separator = _SEPARATORS.get(_keys(head.splitlines(), None).get("Separator", ["Tab"])[0].strip(), "\t")
    outer = _keys(head[: ends[0]].splitlines(), separator)
    own = _keys(head[ends[0] :].splitlines(), separator)
    names, begin = _names(content, begin, separator)
    columns = _value(outer, "X_Columns", "One")
    comma = _value(outer, "Decimal_Separator", ".") == ","
    form = RowForm(separator, len(names), comma, longer=True)
    whole = recording(content, begin, form, [names], _units(own, names, columns), _clock(own, names, columns))
    return Recording(whole.channels, whole.read, _told(own, columns))


def _keys(lines: list[str], separator: str | None) -> dict[str, list[str]]:
    """Key -> its fields, one per channel."""
    parts = (re.split(r"[\t,]", line) if separator is None else line.split(separator) for line in lines)
    return {part[0].strip(): part[1:] for part in parts if part and part[0].strip()}


def _value(keys: dict[str, list[str]], key: str, default: str) -> str:
    return keys[key][0].strip() if keys.get(key) else default


def _names(content: bytes, begin: int, separator: str) -> tuple[list[str], int]:
    """The names over the rows, without that of the comment, and where the rows begin."""
    end = content.find(b"\n", begin)
    if end < 0:
        raise NoColumns("ends after its header")
    names = [name.strip() for name in decoded(content[begin:end]).split(separator)]
    first = decoded(content[end + 1 : end + 20_001]).partition("\n")[0].split(separator)
    count = len(first) if len(names) > len(first) else len(names)
    while count and (names[count - 1] in _NEVER or (count <= len(first) and not NUMBER.fullmatch(first[count - 1].strip()))):
        count -= 1
    if count < 2:
        raise NoColumns("has no line of two or more numbers after its header")
    return names[:count], end + 1


def _channels(names: list[str], columns: str) -> list[int]:
    """The columns of the channels, without those of times."""
    return list(range(1, len(names), 2)) if columns == "Multi" else list(range(1, len(names)))


def _units(own: dict[str, list[str]], names: list[str], columns: str) -> list[str]:
    units = [""] * len(names)
    axes = range(0, len(names), 2 if columns == "Multi" else len(names))
    for column, unit in zip(axes, own.get("X_Unit_Label", []), strict=False):
        units[column] = unit.strip()
    for column, unit in zip(_channels(names, columns), own.get("Y_Unit_Label", []), strict=False):
        units[column] = unit.strip()
    return units


def _clock(own: dict[str, list[str]], names: list[str], columns: str) -> dict[int, dict[str, Any]]:
    """What is known of the times of each column."""
    places = _channels(names, columns)
    if columns == "Multi":
        return {place: {"clock": place - 1} for place in places}
    if columns != "No":
        return {place: {"clock": 0} for place in places}
    known: dict[int, dict[str, Any]] = {}
    labels = own.get("X_Unit_Label", []) + [""] * len(names)
    for place, start, step, unit in zip(places, own.get("X0", []), own.get("Delta_X", []), labels, strict=False):
        second, interval = seconds_of(unit), _number("Delta_X", step)
        if second is not None and interval > 0.0:
            known[place] = {"start": second * _number("X0", start), "interval": second * interval}
    return known


def _number(key: str, text: str) -> float:
    text = text.strip().replace(",", ".")
    if not NUMBER.fullmatch(text):
        raise NoColumns(f"its {key} is no number: {text[:40]!r}")
    return float(text)


def _told(own: dict[str, list[str]], columns: str) -> tuple[str, ...]:
    """A line where the times of day of the channels differ, since another clock stands in the file."""
    days = [day.strip() for day in own.get("Time", []) if day.strip()]
    if len(set(days)) < 2:
        return ()
    clock = "X0 and Delta_X are" if columns == "No" else "its columns of X values are"
    return (f"its channels have different times of day (Time, {days[0][:20]} to {days[-1][:20]}): not used, {clock} the clock",)
