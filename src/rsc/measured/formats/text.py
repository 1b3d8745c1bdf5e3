"""CSV of every country: lines before its numbers, names, a row of units, decimal commas, comments, UTF-8 and UTF-16."""

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.files.memory import Memory
from rsc.measured.channel import Channel, NoColumns, Recording
from rsc.measured.formats.rows import LONGEST_LINE, MOST_COLUMNS, NUMBER, PARTED, RowForm, columns_of, fields, form_of, numbers_in
from rsc.measured.stated import bare, meaning, parted

_HEAD_LINES = 200  # in which the first line of numbers must stand
_ALIKE = 5  # rows that must be written like the first one
_UNIT_ROWS = 5  # rows next to the numbers of which one may have the units
_UTF8, _UTF16 = b"\xef\xbb\xbf", (b"\xff\xfe", b"\xfe\xff")
_COMMENT = re.compile(r"^\s*(#|%|//|!|\*)+\s*(?=\S)")
_NO_UNIT = re.compile(r"[-–—.\s\[\]()]*|units?:?|einheit(en)?:?", re.IGNORECASE)


class Head(NamedTuple):
    """Where the first row begins in the bytes, how it is written, and the lines before it."""

    begin: int
    form: RowForm
    lines: list[str]


def open_text(content: bytes) -> Recording:
    """Its columns of numbers, called by the line of names over them and counted from "1" on."""
    content = as_ascii(content)
    head = _head(content)
    names, units = _names(head.lines, head.form)
    return recording(content, head.begin, head.form, names, units)


def recording(
    content: bytes,
    begin: int,
    form: RowForm,
    names: Sequence[Sequence[str]],
    units: Sequence[str],
    more: dict[int, dict[str, Any]] | None = None,
) -> Recording:
    """The columns of the rows that begin somewhere in a text, with rows of names, their units and what else is known of some."""
    count = content.count(b"\n", begin) + 1

    def read(wanted: Sequence[int], memory: Memory) -> list[NDArray[np.float64]]:
        columns = sorted(set(wanted))
        numbers = dict(zip(columns, columns_of(content[begin:], form, columns), strict=True))
        return [numbers[i] for i in wanted]

    channels = []
    for i in range(form.width):
        called, unit = _called([row[i] for row in names])
        channels.append(Channel(called, count, units[i] if units and units[i] else unit, **(more or {}).get(i, {})))
    return Recording(tuple(channels), read)


def _called(heads: Sequence[str]) -> tuple[tuple[str, ...], str]:
    """(names of a column, each also without its unit; the unit behind the first of them) from what stands over it.

    A number that stands over the names, of a setting, is no name: it would be taken for the number of a column.
    """
    names = [head for i, head in enumerate(heads) if head and (i == 0 or not NUMBER.fullmatch(head))]
    bare_names = [parted(name)[0] for name in names]
    return tuple(dict.fromkeys([*names, *bare_names])), parted(heads[0])[1] if heads else ""


def as_ascii(content: bytes) -> bytes:
    """A text in an ASCII-compatible encoding with line feeds; NoColumns if it is not text."""
    if is_utf16(content):
        encoding = "utf-16" if content.startswith(_UTF16) else "utf-16-le" if content[1:2] == b"\0" else "utf-16-be"
        content = content.decode(encoding, "replace").encode()
    content = content.removeprefix(_UTF8)
    if b"\0" in content[:LONGEST_LINE]:
        raise NoColumns("is no text")
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return content


def decoded(part: bytes) -> str:
    """A piece of a text, which may be that of an old logger: its micro sign is no UTF-8."""
    try:
        return part.decode()
    except UnicodeDecodeError:
        return part.decode("latin-1")


def is_utf16(content: bytes) -> bool:
    """Whether a text begins with the mark of UTF-16, or has as ASCII in UTF-16 a zero for every second byte."""
    even, odd = content[:200:2], content[1:200:2]
    return content.startswith(_UTF16) or any(
        len(zeros) > 4 and not any(zeros) and "".join(decoded(letters).split()).isprintable()
        for zeros, letters in ((even, odd), (odd, even))
    )


def _head(content: bytes) -> Head:
    """The first line of numbers is one that the next lines are written like; else the first that is all numbers."""
    begin, lines, begins = 0, [], []
    for _ in range(_HEAD_LINES + _ALIKE):
        end = content.find(b"\n", begin, begin + LONGEST_LINE)
        lines.append(decoded(content[begin : end if end >= 0 else begin + LONGEST_LINE]))
        begins.append(begin)
        if end < 0:
            break
        begin = end + 1
    first = None
    for i, line in enumerate(lines[:_HEAD_LINES]):
        for how in sorted(PARTED, key=lambda how: not _all_numbers(line, how)):
            kinds = numbers_in(line, how)
            if sum(kinds) < 2:
                continue
            following = [one for one in lines[i + 1 :] if one.strip()][:_ALIKE]
            alike = all(numbers_in(one, how) == kinds for one in following)
            if all(kinds) and first is None:
                first = i, how
            if alike and (following or all(kinds)) and not _counts(line, following, how):
                return Head(begins[i], form_of([line, *following], how), lines[:i])
    if first is None:
        long = any(len(line) >= LONGEST_LINE or max(map(line.count, PARTED)) >= MOST_COLUMNS for line in lines)
        problem = f"its first {_HEAD_LINES} lines have no line of two or more numbers"
        if long:
            problem += f" with at most {MOST_COLUMNS} fields and {LONGEST_LINE} characters: leave out columns that are not needed"
        raise NoColumns(problem)
    return Head(begins[first[0]], form_of([lines[first[0]]], first[1]), lines[: first[0]])


def _all_numbers(line: str, how: str) -> bool:
    kinds = numbers_in(line, how)
    return bool(kinds) and all(kinds)


def _counts(line: str, following: list[str], how: str) -> bool:
    """Whether a line counts the columns below it, "0,1,2,3", and is a line of names."""
    cells = fields(line, how)
    if not following or cells not in ([str(i) for i in range(len(cells))], [str(i + 1) for i in range(len(cells))]):
        return False
    return not all(field.isdigit() for one in following for field in fields(one, how))


def _names(lines: list[str], form: RowForm) -> tuple[list[list[str]], list[str]]:
    """Rows of names, that next to the numbers first, and the units of the columns, from the lines before the numbers."""
    rows = [row for row in (_row(line, form) for line in lines) if row][::-1]
    units = next((row for row in rows[:_UNIT_ROWS] if _are_units(row)), None) if len(rows) > 1 else None
    names = [row for row in rows if row is not units]
    return names, [bare(unit) if not _NO_UNIT.fullmatch(unit) else "" for unit in units or []]


def _row(line: str, form: RowForm) -> list[str]:
    """The fields of a line of names, as many as a row has; empty where it is none."""
    for text in dict.fromkeys((_COMMENT.sub("", line, count=1), line)):
        row = fields(text, form.parted)
        if form.parted == " " and len(row) != form.width:
            row = [field.strip() for field in re.split(r"\s{2,}|\t", text.strip())]
        row += [""] * (form.width - len(row) if form.width - len(row) == 1 else 0)  # the last name may be missing, as its unit
        if len(row) == form.width and sum(bool(field) for field in row) >= max(1, form.width - 1):
            return row
    return []


def _are_units(row: list[str]) -> bool:
    """Whether a line under the names has units, each with or without brackets, or nothing; behind one of time also others."""
    kinds = [meaning(field) for field in row]
    nothing = [bool(_NO_UNIT.fullmatch(field)) or field[:1] in "([" for field in row]
    known = [kind is not None or empty for kind, empty in zip(kinds, nothing, strict=True)]
    return (all(known) and any(kinds)) or (kinds[0] is not None and kinds[0][0] == "time")
