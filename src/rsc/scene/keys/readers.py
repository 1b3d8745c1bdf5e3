"""The kinds of value that a key may have: numbers with units, choices, names, sequences, polar numbers.

A reader makes the value of a key from what the file says, or refuses it.
"""

import numbers
import re
from dataclasses import dataclass, is_dataclass
from typing import Any

import numpy as np

from rsc.errors import nearest
from rsc.scene.keys.keys import RawTable, known_keys
from rsc.units import DIMENSIONS, QuantityError, eccentricity_of_grade, quantity

MAX_COORDINATES = 1000
LONGEST_NAME = 40


@dataclass(frozen=True)
class Number:
    """A finite number, or a text with a unit; `low` and `high` are inclusive bounds, `above` and `below` exclusive ones."""

    dimension: str
    low: float | None = None
    high: float | None = None
    above: float | None = None
    below: float | None = None
    hint: str = ""

    @property
    def wanted(self) -> str:
        """The allowed range in words."""
        unit = DIMENSIONS[self.dimension][0]
        words = [f"{sign} {bound:g}" for sign, bound in self.bounds]
        return "a number" + (f" {' and '.join(words)}" if words else "") + (f" {unit}" if unit != "1" else "")

    @property
    def bounds(self) -> tuple[tuple[str, float], ...]:
        """(sign, bound) pairs of the allowed range."""
        signs = (">", self.above), (">=", self.low), ("<", self.below), ("<=", self.high)
        return tuple((sign, bound) for sign, bound in signs if bound is not None)

    def read(self, table: RawTable, key: str, raw: Any) -> float:
        """The number in SI."""
        try:
            number = quantity(raw, self.dimension)
        except QuantityError as error:
            table.refuse(key, raw, error.wanted, error.hint)
        inside = (
            (self.above is None or number > self.above)
            and (self.low is None or number >= self.low)
            and (self.below is None or number < self.below)
            and (self.high is None or number <= self.high)
        )
        if not inside:
            table.refuse(key, raw, self.wanted, self.hint)
        table.compare_units(key, raw, self.dimension)
        return number


@dataclass(frozen=True)
class Eccentricity(Number):
    """A length, or a balance grade at its speed, by default the largest of the drive (`rsc.units.eccentricity_of_grade`)."""

    @property
    def wanted(self) -> str:
        """The allowed forms in words."""
        return f"{super().wanted}, or for a rotor that turns a balance grade such as \"G 6.3\" or \"G 6.3 at 3000 rpm\""

    def read(self, table: RawTable, key: str, raw: Any) -> float:
        """The length in m."""
        length = eccentricity_of_grade(raw, table.fastest) if isinstance(raw, str) else None
        if length is None and isinstance(raw, str) and raw.strip().startswith("G"):
            table.refuse(key, raw, self.wanted)
        return super().read(table, key, raw if length is None else length)


@dataclass(frozen=True)
class Integer:
    """An integer from `low` to `high`."""

    low: int
    high: int

    @property
    def wanted(self) -> str:
        """The allowed range in words."""
        return f"a whole number from {self.low} to {self.high}"

    def read(self, table: RawTable, key: str, raw: Any) -> int:
        """The number as int."""
        whole = isinstance(raw, numbers.Integral) and not isinstance(raw, bool)
        if not whole and isinstance(raw, float) and raw.is_integer():
            whole = True  # people write large counts as 1e9
        if not whole or not self.low <= raw <= self.high:
            table.refuse(key, raw, self.wanted)
        return int(raw)


@dataclass(frozen=True)
class Flag:
    """true or false."""

    wanted = "true or false"

    def read(self, table: RawTable, key: str, raw: Any) -> bool:
        """The flag as bool."""
        if not isinstance(raw, (bool, np.bool_)):
            table.refuse(key, raw, self.wanted)
        return bool(raw)


@dataclass(frozen=True)
class Choice:
    """One of several names."""

    names: tuple

    @property
    def wanted(self) -> str:
        """The allowed names in words."""
        return "one of " + ", ".join(f"\"{name}\"" for name in self.names)

    def read(self, table: RawTable, key: str, raw: Any) -> str:
        """The name."""
        if not isinstance(raw, str) or raw not in self.names:
            table.refuse(key, raw, self.wanted, nearest(raw, self.names) if isinstance(raw, str) else "")
        return str(raw)


@dataclass(frozen=True)
class Text:
    """A short text."""

    wanted = "a text of 1 to 500 characters"

    def read(self, table: RawTable, key: str, raw: Any) -> str:
        """The text."""
        if not isinstance(raw, str) or not 0 < len(raw) <= 500 or "\0" in raw or not _is_unicode(raw):
            table.refuse(key, raw, self.wanted)
        return str(raw)  # a plain str also for NumPy's string type


def _is_unicode(text: str) -> bool:
    """Whether a text can be encoded in UTF-8, i.e. contains no lone surrogates."""
    return not any("\ud800" <= character <= "\udfff" for character in text)


@dataclass(frozen=True)
class Name:
    """A name that can be part of a dotted key."""

    wanted = f"a name of at most {LONGEST_NAME} letters, digits and _ that starts with a letter"
    pattern = rf"[A-Za-z][A-Za-z0-9_]{{0,{LONGEST_NAME - 1}}}"

    def read(self, table: RawTable, key: str, raw: Any) -> str:
        """The name."""
        if not isinstance(raw, str) or not re.fullmatch(self.pattern, raw):
            table.refuse(key, raw, self.wanted)
        return str(raw)


@dataclass(frozen=True)
class Sequence:
    """A list of one kind of value."""

    item: Any

    @property
    def wanted(self) -> str:
        """The allowed list in words."""
        return f"a list, each item {self.item.wanted}"

    def read(self, table: RawTable, key: str, raw: Any) -> tuple[Any, ...]:
        """A tuple of the items."""
        parts = as_list(raw)
        if parts is None:
            table.refuse(key, raw, self.wanted)
        if len(parts) > MAX_COORDINATES + 1:
            table.refuse(key, raw, f"a list of at most {MAX_COORDINATES + 1} items")
        return tuple(self.item.read(table, f"{key}[{i}]", part) for i, part in enumerate(parts))


@dataclass(frozen=True)
class Later:
    """A key that can be validated only when the rest of its table is known: its description, and readers of its possible
    forms."""

    wanted: str
    forms: tuple

    def read(self, table: RawTable, key: str, raw: Any) -> Any:
        """The raw value, unchecked."""
        return raw


@dataclass(frozen=True)
class Listed:
    """A list with a separate reader for each position."""

    items: tuple


@dataclass(frozen=True)
class Keyed:
    """An inline table with a separate reader for each key."""

    items: dict


@dataclass(frozen=True)
class Polar:
    """A complex amount fixed to the rotor: `amount` at `angle` degrees ahead of the rotor's y axis.

    Kept as entered, so that a scene is stored and read back without rounding; `complex(polar)` is the value.
    """

    amount: float
    angle: float = 0.0

    def __complex__(self) -> complex:
        # quarter turns are exact: cos(90 deg) must not leave 6e-17 in a coordinate meant to be zero
        quarter, remainder = divmod(self.angle, 90.0)
        if remainder == 0.0:
            return self.amount * (1 + 0j, 1j, -1 + 0j, -1j)[int(quarter) % 4]
        return self.amount * complex(np.exp(1j * np.deg2rad(self.angle)))


@dataclass(frozen=True)
class PolarReader:
    """A number, or [amount, angle in degrees]."""

    dimension: str

    @property
    def wanted(self) -> str:
        """The allowed forms in words."""
        return f"a number in {DIMENSIONS[self.dimension][0]}, or [amount, angle in degrees]"

    @property
    def items(self) -> tuple[Number, Number]:
        """The readers of amount and angle."""
        return Number(self.dimension), Number("angle in degrees", low=-1e6, high=1e6)

    def read(self, table: RawTable, key: str, raw: Any) -> Polar:
        """A Polar."""
        parts = as_list(raw)
        if parts is None:
            return Polar(self.items[0].read(table, key, raw))
        if len(parts) != 2:
            table.refuse(key, raw, self.wanted)
        amount, angle = (item.read(table, f"{key}[{i}]", parts[i]) for i, item in enumerate(self.items))
        return Polar(amount, angle or 0.0)  # -0.0 would be lost, since `plain` omits it


@dataclass(frozen=True)
class EccentricityReader(PolarReader):
    """An `Eccentricity`, or [eccentricity, angle in degrees]."""

    dimension: str = "length"

    @property
    def wanted(self) -> str:
        """The allowed forms in words."""
        return f"{self.items[0].wanted}, or [amount, angle in degrees]"

    @property
    def items(self) -> tuple[Number, Number]:
        """The readers of amount and angle."""
        return Eccentricity(self.dimension), super().items[1]


NO_ECCENTRICITY = Polar(0.0)


@dataclass(frozen=True)
class PairReader:
    """A complex number as [y, z]."""

    dimension: str

    @property
    def wanted(self) -> str:
        """The allowed form in words."""
        return f"a pair [y, z] in {DIMENSIONS[self.dimension][0]}"

    def read(self, table: RawTable, key: str, raw: Any) -> complex:
        """The complex number y + i z."""
        parts = as_list(raw)
        if parts is None or len(parts) != 2:
            table.refuse(key, raw, self.wanted)
        number = Number(self.dimension)
        return complex(number.read(table, f"{key}[0]", parts[0]), number.read(table, f"{key}[1]", parts[1]))


def per_coordinate(table: RawTable, key: str, raw: Any, readers: Any) -> tuple[Any, ...]:
    """Read a list with one entry per coordinate, each with its own reader (a tilt is an angle)."""
    parts = as_list(raw)
    if parts is None or len(parts) != len(readers):
        count = f"a list of {len(readers)}, one entry per coordinate"
        table.refuse(key, raw, f"{count}, each {readers[0].wanted}")
    pairs = zip(readers, parts, strict=True)
    return tuple(reader.read(table, f"{key}[{i}]", part) for i, (reader, part) in enumerate(pairs))


def as_list(raw: Any) -> list[Any] | None:
    """A list, tuple or array as a list; None for anything else."""
    if isinstance(raw, np.ndarray) and raw.ndim > 0:
        return raw.tolist()
    return list(raw) if isinstance(raw, (list, tuple)) else None


def plain(value: Any) -> Any:
    """A value as plain numbers, texts and lists for TOML and JSON; reading it again gives the same value."""
    if isinstance(value, Polar):
        return value.amount if value.angle == 0.0 else [value.amount, value.angle]
    if isinstance(value, complex):
        return [value.real, value.imag]
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    return plain_section(value) if is_dataclass(value) else value


def plain_section(section: Any) -> dict[str, Any]:
    """The declared keys of a section as a plain dict, without absent ones."""
    kind: type = type(section)
    pairs = ((name, getattr(section, name)) for name in known_keys(kind))
    return {name: plain(value) for name, value in pairs if value is not None}
