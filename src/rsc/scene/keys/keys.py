"""Reading one table of a scene against declared keys: each states its kind, unit, range, default and meaning once.

A section of a scene is a frozen dataclass with fields made by `declare(reader, default)`. `read_table` goes
through them; invalid values raise a `SceneError` with file, key, value and range. The scene reference and the JSON Schema of
docs/users are generated from the same declarations (tools/scene_reference.py).
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import field, fields
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

from rsc.errors import MEANT, SceneError, nearest, one_line, shown
from rsc.units.together import has_other_unit

REQUIRED = object()  # default of a required key
OPTIONAL = ()  # default of a group of keys that are all optional


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
        self.place = ""  # the table in words, where its name counts from 0

    def within(self, place: str, values: Mapping[str, Any], told: str = "") -> "RawTable":
        """A table inside this one, at a place such as "disks[0]", whose keys must be used as well; told: that place in words."""
        inner = RawTable(self.file, f"{self.name}.{place}", values, self.folder)
        inner.place = told or (self.place and f"{self.place}, {place}")
        inner.fastest, inner.duration, inner.read = self.fastest, self.duration, self.read
        return inner

    def refuse(self, key: str, value: object, wanted: str, hint: str = "") -> NoReturn:
        """Raise the SceneError for one key of this table."""
        place = one_line(f"{self.place}, {key}") if self.place else ""
        raise SceneError(self.file, one_line(f"{self.name}.{key}"), shown(value), wanted, one_line(hint), place)

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
    renamed, called = (dict(getattr(section, name, ())) for name in ("renamed", "called"))
    if key in renamed:
        return f"since version 0.2.0 it is called {renamed[key]}"
    if key in called:
        return f"it is called {called[key]}"
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
        (name, value); ``renamed`` has pairs (old key, new key), ``called`` (word that
        people try, key).
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
    return (table.place or f"[{table.name}]") + (f" with model \"{model}\"" if model else "")
