"""Writes the table of formats in docs/users/measured.md from the readers of rsc.measured.formats.

    python tools/measured_formats.py
"""

import re
import sys
from pathlib import Path

from rsc.measured import formats

PAGE = Path(__file__).resolve().parent.parent / "docs/users/measured.md"
_TABLE = re.compile(r"(<!-- python tools/measured_formats.py [^\n]*-->\n).*?(<!-- end of the table -->)", re.DOTALL)


def page_text() -> str:
    """The page with the table of the readers."""
    return _TABLE.sub(lambda match: match[1] + formats.table() + match[2], PAGE.read_text(encoding="utf-8"))


def main() -> int:
    """Write the page."""
    PAGE.write_text(page_text(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
