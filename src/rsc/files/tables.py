"""Tables of results for notebooks and other programs: HTML, pandas and CSV."""

import csv
import io
import os
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

from rsc.files.mark import CSV
from rsc.files.output import put

if TYPE_CHECKING:
    import pandas

SHOWN = 20  # rows in a notebook


@dataclass(frozen=True)
class Table:
    """A table with named columns; a column name ends with its unit.

    columns : tuple of str
    rows : sequence of sequences, one value per column
    """

    columns: tuple[str, ...]
    rows: Sequence[Sequence[Any]]

    def to_dataframe(self) -> "pandas.DataFrame":
        """The table as a pandas.DataFrame (needs pandas)."""
        import pandas

        return pandas.DataFrame.from_records(list(map(tuple, self.rows)), columns=list(self.columns))

    def to_csv(self, path: str | os.PathLike[str], overwrite: bool = False) -> None:
        """Write the table as CSV with all digits, and `.NAME.rsc`, by which rsc later recognises the file as its own.

        overwrite : bool, allow replacing a file that rsc did not write or that was changed since

        Raises
        ------
        DataError
            The file cannot be written, or such a file exists and overwrite is false.
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(self.rows)
        put(path, text.getvalue().encode(), CSV, overwrite)

    def _repr_html_(self) -> str:
        return html(self.columns, [[_short(value) for value in row] for row in self.rows[:SHOWN]], len(self.rows))


def html(columns: Sequence[str], rows: Sequence[Sequence[str]], number: int | None = None) -> str:
    """A small HTML table of escaped texts; number: total number of rows, stated if larger."""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in columns)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    more = f"<p>{len(rows)} of {number} rows</p>" if number is not None and number > len(rows) else ""
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.5g}"
    return str(value)
