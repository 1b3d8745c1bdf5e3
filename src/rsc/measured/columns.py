"""Columns of numbers in the files of data loggers: CSV of every country, .npz and recordings; at most `MOST_BYTES` are read."""

import io
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError, one_line
from rsc.files.content import content_of
from rsc.machine.formats import npz
from rsc.machine.formats.entries import BadMatrix
from rsc.measured import recorded
from rsc.measured.recorded import MOST_COLUMNS, NoColumns

MOST_BYTES = 512 * 2**20
_HEAD_LINES = 200  # in which the first line of numbers must stand
_LONGEST_LINE = 20_000
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?|[+-]?(nan|inf(inity)?)", re.IGNORECASE)


def columns_of(path: Path) -> tuple[dict[str, NDArray[np.float64]], float | None]:
    """The columns of a file.

    Returns
    -------
    dict, float or None
        Name -> (n,) numbers, as the file has them, a WAV file's over its largest number; samples per second where the file
        tells them. A column without a name is called by its number, from "1" on.

    Raises
    ------
    DataError
        For a file that cannot be read, is too large, or holds no columns of numbers.
    """
    content = content_of(path, MOST_BYTES)
    try:
        if content.startswith((npz.MAGIC_ZIP, npz.MAGIC_ARRAY)):
            return _archived(content), None
        if content.startswith(recorded.MAGIC_WAV):
            return recorded.wav(content)
        if content.startswith(recorded.MAGIC_TDMS):
            return recorded.tdms(content)
        if recorded.is_uff(content):
            return recorded.uff(content, path)
        return _csv(content), None
    except (BadMatrix, NoColumns) as error:
        raise DataError(one_line(path), str(error)) from None


def _archived(content):
    if content.startswith(npz.MAGIC_ARRAY):
        raise NoColumns("is a single array; keep each column by its name in a .npz file")
    try:
        arrays = npz.arrays_of(content, MOST_BYTES)
    except BadMatrix:
        raise
    except Exception as error:  # zipfile raises nearly anything for a damaged archive
        raise NoColumns(f"damaged archive: {type(error).__name__}") from None
    columns = {name: array.astype(float) for name, array in arrays.items() if array is not None and array.ndim == 1}
    if len({len(column) for column in columns.values()}) != 1:
        lengths = ", ".join(f"{one_line(name)[:40]} {len(column)}" for name, column in list(columns.items())[:5])
        raise NoColumns(f"its columns have not one length ({lengths})" if columns else "it has no columns of numbers")
    return columns


def _csv(content):
    """Columns of a text: the first line of numbers says how they are parted, the first line before with as many fields their
    names, so that a line of units between them is passed over.
    """
    text = _decoded(content)
    begin, head = _numbers_begin(text)
    first = text[begin : begin + _LONGEST_LINE].partition("\n")[0]
    parted = _parted(first)
    if parted is None:
        raise NoColumns("its first line of numbers cannot be parted into columns")
    comma = parted != "," and "," in first
    count = len(_fields(first, parted))
    body = text[begin:].replace(",", ".") if comma else text[begin:]
    try:
        data = np.loadtxt(io.StringIO(body), delimiter=None if parted == " " else parted, ndmin=2, comments=None)
    except (ValueError, OverflowError) as error:
        raise NoColumns(f"a line behind its head is not {count} numbers: {one_line(error)[:120]}") from None
    rows = [_fields(line, parted) for line in head]
    names = next((row for row in rows if len(row) == count and len(set(row)) == count and all(row)), None)
    return {name: data[:, i] for i, name in enumerate(names or map(str, range(1, count + 1)))}


def _decoded(content):
    encoding = "utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError:
        text = content.decode("latin-1")  # a micro sign of an old logger
    if "\0" in text[:_LONGEST_LINE]:
        raise NoColumns("is no text, .npz, WAV, UFF-58 or TDMS file")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _numbers_begin(text):
    """Where the first line of numbers begins, and the lines before it."""
    begin, head = 0, []
    for _ in range(_HEAD_LINES):
        end = text.find("\n", begin, begin + _LONGEST_LINE)
        line = text[begin : end if end >= 0 else begin + _LONGEST_LINE]
        if _parted(line) is not None:
            return begin, head
        head.append(line)
        if end < 0:
            break
        begin = end + 1
    raise NoColumns(f"its first {_HEAD_LINES} lines have no line of two or more numbers")


def _parted(line):
    """What parts a line of two numbers or more: ";", a tab, a comma or blanks; None where it is no such line."""
    for parted in (";", "\t", ",", " "):
        fields = _fields(line, parted)
        if 2 <= len(fields) <= MOST_COLUMNS and all(_NUMBER.fullmatch(field) for field in fields):
            if parted == "," and any("," in field for field in fields):
                continue
            return parted
    return None


def _fields(line, parted):
    fields = line.split() if parted == " " else line.rstrip(parted + "\n").split(parted)
    return [field.strip().strip('"').strip() for field in fields]
