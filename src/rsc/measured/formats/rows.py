"""Rows of numbers in a text: how their fields are parted, and the numbers of some of their columns."""

import csv
import io
import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.errors import one_line
from rsc.measured.channel import MOST_COLUMNS, NoColumns

NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?|[+-]?(nan|inf(inity)?)", re.IGNORECASE)
PARTED = (";", "\t", ",", " ")  # what may part fields, in the order in which it is tried; " ": blanks
LONGEST_LINE = 20_000
_BAD = re.compile(r"could not convert string (?P<text>.*) to float64 at row (?P<row>\d+), column (?P<column>\d+)", re.DOTALL)


class RowForm(NamedTuple):
    """How rows are written: what parts their fields, how many these are, whether decimals stand behind a comma, whether fields
    may stand in quotation marks, and whether a row may have more fields (a comment)."""

    parted: str
    width: int
    comma: bool = False
    quoted: bool = False
    longer: bool = False


def fields(line: str, parted: str) -> list[str]:
    """The fields of a line, without blanks and quotation marks; no empty ones at its end."""
    if parted == " ":
        return [field.strip('"') for field in line.split()]
    line = line.rstrip("\r\n").rstrip(parted + " ")
    if '"' in line:
        try:
            return [field.strip() for field in next(csv.reader([line], delimiter=parted, skipinitialspace=True), [])]
        except csv.Error:
            pass
    return [field.strip().strip('"').strip() for field in line.split(parted)]


def numbers_in(line: str, parted: str) -> tuple[bool, ...]:
    """Which fields of a line are numbers; none of one with a single field, too many, or commas both in and between numbers."""
    cells = fields(line, parted)
    if not 2 <= len(cells) <= MOST_COLUMNS or (parted == "," and '"' not in line and any("," in field for field in cells)):
        return ()
    return tuple(NUMBER.fullmatch(field) is not None for field in cells)


def form_of(lines: list[str], parted: str) -> RowForm:
    """The layout of rows, from the first ones."""
    cells = [fields(line, parted) for line in lines]
    comma = any("," in cell for row in cells for cell in row if NUMBER.fullmatch(cell))
    return RowForm(parted, len(cells[0]), comma, '"' in lines[0])


def columns_of(body: bytes, form: RowForm, columns: list[int]) -> list[NDArray[np.float64]]:
    """The numbers of some columns of rows.

    Parameters
    ----------
    body : bytes, lines of rows alone, in an encoding in which ASCII is ASCII
    form : RowForm
    columns : their numbers from 0, in rising order, each once
    """
    if form.quoted and b'"' in body:
        body = _unquoted(body, form)
        form = form._replace(parted=";", comma=False)
    elif form.comma:
        if b"." in body and b"." not in body.partition(b"\n")[0]:
            raise NoColumns("has points as well as decimal commas in its numbers; write thousands without a point")
        body = body.replace(b",", b".")
    _refuse_other_widths(body, form)
    lines = io.TextIOWrapper(io.BytesIO(body), encoding="latin-1", newline=None)
    try:
        delimiter = None if form.parted == " " else form.parted
        data = np.loadtxt(lines, delimiter=delimiter, usecols=columns, ndmin=2, comments=None)
    except (ValueError, OverflowError) as error:
        match = _BAD.search(str(error))
        where = f": row {int(match['row']) + 1} has {one_line(match['text'])[:60]}" if match else ""
        hint = "; give measured.rate instead of times of day" if match and ":" in match["text"] else ""
        raise NoColumns(f"a line after its header is not {form.width} numbers{where}{hint}") from None
    return [data[:, i] for i in range(len(columns))]


def _refuse_other_widths(body: bytes, form: RowForm) -> None:
    """Refuse rows with more or fewer fields than the first: a decimal comma would shift the following columns."""
    if form.parted == " " or form.longer:
        return
    parted = form.parted.encode()
    first = body.partition(b"\n")[0].count(parted)
    rows = body.count(b"\n") + (not body.endswith(b"\n"))
    if body.count(parted) == first * rows:
        return
    for number, line in enumerate(io.BytesIO(body), 1):  # blank lines are rows to nobody
        if line.strip() and line.count(parted) != first:
            raise NoColumns(
                f"a line after its header is not {form.width} numbers: line {number} from its first numbers on has "
                f"{line.count(parted) + 1} fields, the first {first + 1}"
            )


def _unquoted(body: bytes, form: RowForm) -> bytes:
    """The rows with their fields parted by semicolons, out of their quotation marks and with decimal points."""

    def lines() -> Iterator[str]:
        text = io.TextIOWrapper(io.BytesIO(body), encoding="latin-1", newline="")
        for row in csv.reader(text, delimiter=form.parted, skipinitialspace=True):
            yield ";".join(field.strip().replace(",", ".") if form.comma else field.strip() for field in row)

    try:
        return "\n".join(lines()).encode("latin-1")
    except csv.Error as error:
        raise NoColumns(f"a line after its header cannot be split: {one_line(error)[:60]}") from None
