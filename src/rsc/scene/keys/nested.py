"""Readers of inline tables in a list, and of a quantity that may differ at both ends."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from rsc.scene.keys.keys import MAX_COORDINATES, Number, RawTable, Values, as_list, known_keys, read_table
from rsc.units import DIMENSIONS


class Item(NamedTuple):
    """One table of a list, and the values of its keys."""

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
        """Every table with its values, as `read_table` gives them."""
        parts = as_list(raw)
        if parts is None or not self.least <= len(parts) <= MAX_COORDINATES:
            table.refuse(key, raw, self.wanted)
        read = []
        for i, values in enumerate(parts):
            if not isinstance(values, Mapping):
                table.refuse(f"{key}[{i}]", values, f"a table {{{', '.join(known_keys(self.section))}}}")
            own = table.within(f"{key}[{i}]", values)
            read.append(Item(own, read_table(self.section, own)))
        return tuple(read)


@dataclass(frozen=True)
class Ends:
    """A number, or two, at the left and at the right end; both as a pair."""

    item: Number

    @property
    def wanted(self) -> str:
        """The allowed forms in words."""
        return f"{self.item.wanted}, or two of a cone, [left, right]"

    def read(self, table: RawTable, key: str, raw: object) -> tuple[float, float]:
        """The numbers at the left and at the right end."""
        parts = as_list(raw)
        if parts is None:
            value = self.item.read(table, key, raw)
            return value, value
        if len(parts) != 2:
            table.refuse(key, raw, f"a number in {DIMENSIONS[self.item.dimension][0]}, or two of a cone, [left, right]")
        left, right = (self.item.read(table, f"{key}[{i}]", part) for i, part in enumerate(parts))
        return left, right
