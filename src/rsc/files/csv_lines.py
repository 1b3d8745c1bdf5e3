"""Reading of lines of comma-separated values."""

import csv
import io
import os
from collections.abc import Iterator

from rsc.errors import DataError, one_line


def csv_lines(path: str | os.PathLike[str], text: str, delimiter: str = ",") -> Iterator[tuple[int, list[str]]]:
    """Yield (line number in the file, cells) for every row of a text.

    path : str or path, for messages

    Raises
    ------
    DataError
        Not such a text: an unterminated quote, or a cell that is too long.
    """
    lines = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    first = 1
    try:
        for cells in lines:
            yield first, cells
            first = lines.line_num + 1
    except csv.Error as error:
        raise DataError(one_line(path), f"no text of comma separated values (line {first}: {error})") from None
