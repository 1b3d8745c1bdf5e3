"""Aligned text of tables."""


def table(header, rows):
    """Aligned text of a table; rows hold strings, the last column is read from the left."""
    widths = [max(len(cell) for cell in column) for column in zip(header, *rows, strict=True)]
    lines = []
    for row in (header, *rows):
        numbers = [cell.rjust(w) for cell, w in zip(row[:-1], widths, strict=False)]
        lines.append("  ".join([*numbers, row[-1]]).rstrip())
    return "\n".join([lines[0], "-" * (sum(widths[:-1]) + 2 * len(widths) + 12), *lines[1:]])
