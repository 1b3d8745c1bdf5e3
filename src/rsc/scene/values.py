"""Single values of a scene by name, such as `rotor.mass` or `start.rotor[0][1]`: readers, units, and changing them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from rsc.errors import SceneError, nearest, one_line, shown
from rsc.scene.files.matrix_files import MatrixReader
from rsc.scene.keys.keys import RawTable
from rsc.scene.keys.readers import Choice, Flag, Integer, Later, Listed, Number, PairReader, PolarReader, Sequence, Text, plain
from rsc.scene.names import POLAR, at_contacts, each_contact, leading, pairs_of, polar_name, polar_readers
from rsc.scene.reading import all_names
from rsc.scene.scene import Scene
from rsc.units import DIMENSIONS

_NAME = re.compile(r"(\w+(?:\.\w+(?:\[\d{1,4}\])?)?)\.(\w+)((?:\[\d{1,4}\])*)", re.ASCII)
_SINGLE = (Number, Integer, Flag, Choice, Text, PolarReader)
_ENTRY = Number("dimensionless")  # entry of a matrix with coordinates of any kind: in SI units
_PHYSICAL = ("rotor", "stator", "contact")
# keys of a reduced body that document the reduction
_BOOKKEEPING = ("tolerance", "error", "band", "speeds", "coefficients_at", "highest_before", "highest_after", "observer_rows",
                "observer_errors", "drawn", "nodes", "node_rows", "parts", "bearing_rows")


@dataclass(frozen=True)
class Value:
    """One value of a scene: a number or a word.

    name : str, dotted key, with indices in brackets for values in lists, or a name of `rsc.scene.names`
    table, key : str, for "contact.*" those of the first contact; places : tuple of int, the indices
    readers : tuple, tried in turn; symmetric : bool, whether it is an entry of a symmetric matrix
    meaning : str, of the key, or of its amount or angle
    polar : str, "amount" or "angle" of all eccentricities of the key, else ""
    """

    name: str
    table: str
    key: str
    places: tuple[int, ...]
    readers: tuple[Any, ...]
    symmetric: bool
    meaning: str
    polar: str = ""

    @property
    def dimension(self) -> str:
        """A key of `rsc.units.DIMENSIONS`; "" for words and counts."""
        return next((reader.dimension for reader in self.readers if isinstance(reader, (Number, PolarReader))), "")

    @property
    def physical(self) -> bool:
        """Whether it describes the machine rather than run, solver, output or the reduction of a body."""
        return self.table.partition(".")[0] in _PHYSICAL and self.key not in _BOOKKEEPING

    @property
    def unit(self) -> str:
        """Unit of a plain number; "SI" if it depends on the coordinate, "" for words."""
        if _ENTRY in self.readers:
            return "SI"
        if self.dimension:
            return DIMENSIONS[self.dimension][0]
        return "1" if any(isinstance(reader, Integer) for reader in self.readers) else ""

    def read(self, raw: object, file: str = "<scene>") -> float | int | str | bool:
        """Validate a raw value: a number in SI (frequencies in Hz), or a word.

        Raises
        ------
        SceneError
            The value is not allowed here.
        """
        table, place = RawTable(file, self.table, {}), f"{self.key}.{self.polar}" if self.polar else self.name.rpartition(".")[2]
        for reader in self.readers[:-1]:
            try:
                return _plain(reader.read(table, place, raw))
            except SceneError:
                continue
        return _plain(self.readers[-1].read(table, place, raw))


def value_of(scene: Scene, name: str) -> Value:
    """Find a value by its name, in scenes of the same kind as this one.

    Raises
    ------
    SceneError
        There is no such value; the message suggests the closest name.
    """
    full = at_contacts(scene, name)[0]
    if (polar := polar_name(scene, full)) is not None:
        return _polar_value(scene, name, *polar)
    match = _NAME.fullmatch(full)
    if match is None:
        hint = "the title is not a value" if name == "title" else nearest(name, all_names())
        raise SceneError(scene.source, one_line(name), None, "a key of a scene", hint)
    table, key, places = scene.table_name(match[1], name), match[2], tuple(int(i) for i in re.findall(r"\d+", match[3]))
    section = scene.section(table)
    declared = {item.name: item.metadata for item in fields(section) if "reader" in item.metadata}
    if key not in declared:
        wanted = f"a key of [{table}]" + (f" with model \"{section.model}\"" if hasattr(section, "model") else "")
        keys = [f"{name.rpartition('.')[0]}.{known}" for known in declared]
        raise SceneError(scene.source, one_line(name), None, wanted, nearest(name, keys))
    reader = declared[key]["reader"]
    readers = _single_readers(reader, places)
    if not readers:
        raise SceneError(scene.source, one_line(name), None, "a single number or word", _hint(reader, table, key, places))
    return Value(name, table, key, places, readers, isinstance(reader, MatrixReader), declared[key]["meaning"])


def _polar_value(scene: Scene, name: str, table: str, key: str, word: str) -> Value:
    """The amount or angle of all eccentricities of a key; SceneError if all are zero."""
    leading(scene, table, key)
    return Value(name, table, key, (), (polar_readers(scene.section(table), key)[word],), False, POLAR[word], word)


def with_entries(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """`scene.with_values` that also accepts entries of lists; in a symmetric matrix the mirrored entry changes, too.

    Raises
    ------
    SceneError
        A value that does not exist, or an invalid scene.
    """
    whole: dict[str, Any] = {}
    for name, number in each_contact(scene, values).items():
        if not name.endswith("]"):
            whole[name] = number
            continue
        value = value_of(scene, name)
        key = f"{value.table}.{value.key}"
        if key not in whole:
            whole[key] = _content(scene, value)
        for places in {value.places, value.places[::-1]} if value.symmetric else {value.places}:
            _put(scene, name, whole[key], places, number)
    return scene.with_values(whole)


def physical_values(scene: Scene) -> dict[str, float]:
    """All nonzero numbers of rotor, stator and contact: name -> value; of symmetric matrices only one half."""
    values = {}
    tables = scene.tables
    for table in [name for name in tables if name.partition(".")[0] in _PHYSICAL]:
        for key, entry in tables[table].items():
            for places, number in _leaves(entry):
                name = f"{table}.{key}" + "".join(f"[{i}]" for i in places)
                if key in _BOOKKEEPING or number == 0.0:
                    continue
                try:
                    value = value_of(scene, name)
                except SceneError:  # angles of [amount, angle], coordinate numbers
                    continue
                if value.dimension and not (value.symmetric and places[0] > places[1]):
                    values[name] = number
    return values


def _plain(value: Any) -> Any:
    """The amount of a Polar; anything else unchanged."""
    return value.amount if hasattr(value, "amount") else value


def _single_readers(reader: Any, places: tuple[int, ...]) -> tuple[Any, ...]:
    """Readers of the value at given indices within what a reader reads; empty if that is a list."""
    if isinstance(reader, Later):
        return tuple(single for form in reader.forms for single in _single_readers(form, places))
    if not places:
        return (reader,) if isinstance(reader, _SINGLE) else ()
    first, inner = places[0], places[1:]
    if isinstance(reader, Sequence):
        return _single_readers(reader.item, inner)
    if isinstance(reader, Listed):
        return _single_readers(reader.items[first], inner) if first < len(reader.items) else ()
    if isinstance(reader, MatrixReader) and len(inner) == 1:
        if reader.entries is None:
            return (_ENTRY,)
        return (reader.entries[first][inner[0]],) if max(places) < len(reader.entries) else ()
    if isinstance(reader, PairReader) and not inner and first < 2:
        return (Number(reader.dimension),)
    if isinstance(reader, PolarReader) and not inner and first < 2:
        return reader.items[first : first + 1]
    return ()


def _hint(reader: Any, table: str, key: str, places: tuple[int, ...]) -> str:
    """How to name one value of a list."""
    for extra in ((0,), (0, 0), (0, 0, 0)):
        if _single_readers(reader, places + extra):
            return f"for example {table}.{key}" + "".join(f"[{i}]" for i in places + extra)
    return "the key is not a list" if places else ""


def _content(scene: Scene, value: Value) -> Any:
    """A copy of the plain content of a value's key, including parts that a scene may omit: angles and a zero state."""
    pairs = pairs_of(scene, value.table, value.key)
    if pairs:
        return pairs
    content = scene.tables[value.table].get(value.key)
    if content is None and value.table == "start":
        content = plain(getattr(scene.start, value.key))
    return _unfolded(content)


def _unfolded(entry: Any) -> Any:
    """A deep copy of nested lists."""
    return [_unfolded(item) for item in entry] if isinstance(entry, list) else entry


def _put(scene: Scene, name: str, content: Any, places: tuple[int, ...], number: Any) -> None:
    """Set an entry of nested lists."""
    for i in places[:-1]:
        content = content[i] if isinstance(content, list) and i < len(content) else None
    if not isinstance(content, list) or places[-1] >= len(content):
        raise SceneError(scene.source, one_line(name), shown(number), "an entry of a list in the scene")
    content[places[-1]] = number


def _leaves(entry: Any, places: tuple[int, ...] = ()) -> list[tuple[tuple[int, ...], float]]:
    """(places, number) of every number within nested lists."""
    if isinstance(entry, list):
        return [leaf for i, item in enumerate(entry) for leaf in _leaves(item, (*places, i))]
    return [(places, float(entry))] if isinstance(entry, (int, float)) and not isinstance(entry, bool) else []
