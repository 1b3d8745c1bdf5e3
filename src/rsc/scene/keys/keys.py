"""Reading one table of a scene against declared keys: each states its kind, unit, range, default and meaning once.

A section of a scene is a frozen dataclass with fields made by `declare(reader, default)`. `read_table` goes
through them; invalid values raise a `SceneError` with file, key, value and range. The scene reference and the JSON Schema of
docs/users are generated from the same declarations (tools/scene_reference.py).
"""

import numbers
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from rsc.errors import MEANT, SceneError, nearest, one_line, shown
from rsc.units import DIMENSIONS, QuantityError, eccentricity_of_grade, quantity
from rsc.units.together import has_other_unit

REQUIRED = object()  # default of a required key
OPTIONAL = ()  # default of a group of keys that are all optional
MAX_COORDINATES = 1000
LONGEST_NAME = 40


class RawTable:
    """One table of a scene being read; its errors name file and key.

    Parameters
    ----------
    file : str
        Name for messages.
    name : str
        Name of the table, for example ``"contact"``.
    values : Mapping
        Its raw content.
    folder : pathlib.Path or None
        Base of relative file names; None if files are not allowed.

    Attributes
    ----------
    fastest : float, Hz
        Largest speed of the drive, used for balance grades of the rotor.
    """

    def __init__(self, file: str, name: str, values: Mapping[str, Any], folder: Path | None = None) -> None:
        self.file, self.name, self.values, self.folder, self.fastest, self.duration = file, name, values, folder, 0.0, 0.0
        # (key, dimension) -> first number without a unit and first text with another unit, each with its position
        self._met: dict[tuple[str, str], dict[type, tuple[str, object]]] = {}
        self.read: list[Values] = []  # values read from this table and from those inside it

    def within(self, place: str, values: Mapping[str, Any]) -> "RawTable":
        """A table inside this one, at a place such as "disks[0]", whose keys must be used as well."""
        inner = RawTable(self.file, f"{self.name}.{place}", values, self.folder)
        inner.fastest, inner.duration, inner.read = self.fastest, self.duration, self.read
        return inner

    def refuse(self, key: str, value: object, wanted: str, hint: str = "") -> NoReturn:
        """Raise the SceneError for one key of this table."""
        raise SceneError(self.file, one_line(f"{self.name}.{key}"), shown(value), wanted, one_line(hint))

    def compare_units(self, place: str, raw: Any, dimension: str) -> None:
        """Refuse a plain number in a list, at a place such as "speed[0]", together with a text in another unit."""
        key, listed, _ = place.partition("[")
        if not listed or not (raw if not isinstance(raw, str) else has_other_unit(raw, dimension)):
            return
        met = self._met.setdefault((key, dimension), {})
        met.setdefault(str if isinstance(raw, str) else float, (place, raw))
        if len(met) > 1:
            self.refuse(*met[float], "a text with a unit", f"like {met[str][1]!r} in the same list")


def declare(reader: Any, default: Any = REQUIRED, *, meaning: str, mirror: Callable[[Any], Any] | None = None) -> Any:
    """Declare a key of a section: its reader, default (None: may be absent) and meaning, in one sentence.

    mirror : plain value -> value in the mirrored scene, by default derived from `reader` (`rsc.scene.keys.mirror`)
    """
    return field(metadata={"reader": reader, "default": default, "meaning": meaning, "mirror": mirror})


class Values(dict):
    """The values of the declared keys of one table, each of which must be used: by its name, or by the class made from all of
    them. A key that is accepted but never used would silently have no effect, which is a bug of rsc."""

    def __init__(self, table: RawTable, values: dict[str, Any]) -> None:
        super().__init__(values)
        self._table, self._untaken = table, {key for key in values if key in table.values}

    def __getitem__(self, key: str) -> Any:
        self._untaken.discard(key)
        return super().__getitem__(key)

    def get(self, key: str, default: Any = None) -> Any:
        """The value of a key that not every class of tables declares."""
        self._untaken.discard(key)
        return super().get(key, default)

    def made(self, section: type) -> Any:
        """An instance of the class that declares the keys."""
        return section(**self)

    def refuse_untaken(self, besides: Iterable[str] = ()) -> None:
        """AssertionError for a key of this table, or of a table inside it, that was given but never used; besides: keys that
        were used before."""
        for values in self._table.read:
            if untaken := values._untaken.difference(besides if values is self else ()):
                raise AssertionError(f"[{values._table.name}] {min(untaken)} is declared, but nothing uses it")


@cache  # called for every key of every case of a sweep
def known_keys(section: type) -> tuple[str, ...]:
    """Names of the keys that a section class declares."""
    return tuple(item.name for item in fields(section) if "reader" in item.metadata)


def _hint(section: type, key: str, names: tuple[str, ...], elsewhere: Callable[[str], str] | None) -> str:
    """Hint for an unknown key: its new name, the closest name, or where it belongs."""
    renamed = dict(getattr(section, "renamed", ()))
    if key in renamed:
        return f"since version 0.2.0 it is called {renamed[key]}"
    hint, place = nearest(key, names), elsewhere(key) if elsewhere else ""
    if place:
        return f"{hint} As it is, {place}" if hint.startswith(MEANT) else place
    return hint


def read_table(section: type, table: RawTable, elsewhere: Callable[[str], str] | None = None) -> Values:
    """Read the declared keys of a section class from a table.

    Parameters
    ----------
    section : type
        Dataclass with fields made by `declare`; an optional attribute ``one_of`` lists groups
        ``(names, default)`` of keys that exclude each other; default is None (one must be given), OPTIONAL or
        (name, value); ``renamed`` has pairs (old key, new key).
    table : RawTable
        The raw table.
    elsewhere : callable, optional
        ``elsewhere(key) -> str`` says where an unknown key would be valid ("" if nowhere).

    Returns
    -------
    Values
        Field name to value.

    Raises
    ------
    SceneError
        For an unknown, missing, contradictory or impossible key.
    """
    names = known_keys(section)
    for key in table.values:
        if key not in names and not (key == "model" and hasattr(section, "model")):
            table.refuse(key, table.values[key], f"a key of {_title(section, table)}", _hint(section, key, names, elsewhere))
    groups = getattr(section, "one_of", ())
    for group, _ in groups:
        present = [name for name in group if name in table.values]
        if len(present) > 1:
            wanted = f"left out when {present[0]} is given"
            table.refuse(present[1], table.values[present[1]], wanted, "they exclude each other")
    values = {}
    for item in fields(section):
        reader, default = item.metadata["reader"], item.metadata["default"]
        if item.name in table.values:
            values[item.name] = reader.read(table, item.name, table.values[item.name])
        elif default is REQUIRED:
            table.refuse(item.name, None, f"given: {reader.wanted}")
        else:
            values[item.name] = default
    for group, default in groups:
        if default != OPTIONAL and all(values[name] is None for name in group):
            if default is None:
                table.refuse(group[0], None, "given, or instead of it " + " or ".join(group[1:]))
            values[default[0]] = default[1]
    table.read.append(Values(table, values))
    return table.read[-1]


def _title(section: type, table: RawTable) -> str:
    model = getattr(section, "model", None)
    return f"[{table.name}]" + (f" with model \"{model}\"" if model else "")


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
    """A length, or a balance grade, taken at the largest speed of the drive (`rsc.units.eccentricity_of_grade`)."""

    @property
    def wanted(self) -> str:
        """The allowed forms in words."""
        return f"{super().wanted}, or for a rotor that turns a balance grade such as \"G 6.3\""

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
