"""[report]: how reports, tables and pictures show their numbers."""

from dataclasses import dataclass
from typing import Any

from rsc.scene.keys.keys import declare
from rsc.scene.keys.readers import Choice, plain_section

KEY = "report"
SYSTEMS = ("si", "metric", "us")


@dataclass(frozen=True, kw_only=True)
class Display:
    """[report]: units in which numbers are shown; nothing computed or stored depends on it."""

    units: str = declare(
        Choice(SYSTEMS),
        "si",
        meaning="Units of tables, texts and pictures: `si` (m, N and Hz with prefixes), `metric` (um, mm, N and rpm) or `us` "
        "(mil, in, lbf and rpm); the option `--units` of a command overrides it.",
    )

    def to_dict(self) -> dict[str, Any]:
        """Plain content of the table."""
        content: dict[str, Any] = plain_section(self)
        return content
