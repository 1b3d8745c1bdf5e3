"""Readers of lists of inline tables, and of a quantity that may differ at the two ends of a section."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from rsc.scene.keys.keys import RawTable, Values, known_keys, read_table
from rsc.scene.keys.readers import MAX_COORDINATES, Number, as_list
from rsc.units import DIMENSIONS

MOST_NAME = 40  # characters of a name in a message


class Item(NamedTuple):
    """One table of a list and the values of its keys."""

    table: RawTable
    values: Values


@dataclass(frozen=True)
class Tables:
    """A list of inline tables, each with the keys that a section class declares."""

    section: type
    least: int = 0

    @property
    def wanted(self) -> str:
        """The allowed form in words."""
        return f"a list of tables {{{', '.join(known_keys(self.section))}}}"

    def read(self, table: RawTable, key: str, raw: object) -> tuple[Item, ...]:
        """All tables with their values from `read_table`."""
        parts = as_list(raw)
        if parts is None or not self.least <= len(parts) <= MAX_COORDINATES:
            table.refuse(key, raw, self.wanted)
        read = []
        for i, values in enumerate(parts):
            if not isinstance(values, Mapping):
                table.refuse(f"{key}[{i}]", values, f"a table {{{', '.join(known_keys(self.section))}}}")
            nested = table.within(f"{key}[{i}]", values, _told(table, key, i, values))
            read.append(Item(nested, read_table(self.section, nested)))
        return tuple(read)


def _told(table: RawTable, key: str, i: int, values: Mapping[str, Any]) -> str:
    """The table number i of a list as people count them: "rotor.disks, disk 2 (impeller)"."""
    name = values.get("name")
    called = f" ({name[:MOST_NAME]})" if isinstance(name, str) and name else ""
    return f"{table.name}.{key}, {key.removesuffix('s').replace('_', ' ')} {i + 1}{called}"


@dataclass(frozen=True)
class Inner:
    """One table inside another, with the keys that a section class declares."""

    section: type

    @property
    def wanted(self) -> str:
        """The allowed form in words."""
        return f"a table {{{', '.join(known_keys(self.section))}}}"

    def read(self, table: RawTable, key: str, raw: object) -> Any:
        """An instance of the section class."""
        if not isinstance(raw, Mapping):
            table.refuse(key, raw, self.wanted)
        return read_table(self.section, table.within(key, raw)).made(self.section)


@dataclass(frozen=True)
class Ends:
    """A number, or two for the left and the right end; read as a pair."""

    item: Number

    @property
    def wanted(self) -> str:
        """The allowed forms in words."""
        return f"{self.item.wanted}, or [left, right] for a cone"

    def read(self, table: RawTable, key: str, raw: object) -> tuple[float, float]:
        """The numbers at the left and right end."""
        parts = as_list(raw)
        if parts is None:
            value = self.item.read(table, key, raw)
            return value, value
        if len(parts) != 2:
            table.refuse(key, raw, f"a number in {DIMENSIONS[self.item.dimension][0]}, or [left, right] for a cone")
        left, right = (self.item.read(table, f"{key}[{i}]", part) for i, part in enumerate(parts))
        return left, right
