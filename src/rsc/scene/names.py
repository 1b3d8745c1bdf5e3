"""Names of values in addition to keys: `contact.*.friction` is the friction of every contact; `rotor.eccentricity.angle` and
`rotor.eccentricity.amount` rotate and scale all eccentricities of the rotor together, in a reduced machine
`rotor.unbalance.angle` and `rotor.unbalance.amount` its unbalance.

Amount and angle refer to the *leading* eccentricity, the first nonzero one of a displacement. The others keep their ratio to it
and their relative angle, so that the unbalance distribution is rotated and scaled as a whole.
"""

import cmath
import math
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, Protocol

from rsc.errors import SceneError, one_line, shown
from rsc.scene.keys.keys import RawTable
from rsc.scene.keys.readers import Later, Number, PairReader, Polar, PolarReader, Sequence, plain

EVERY = "contact.*"
# parts of an eccentricity with separate names, in the order of `PolarReader.items`, and their meaning
POLAR = {
    "amount": "Amount of the leading one; all eccentricities or unbalances of the key are scaled in proportion.",
    "angle": "Angle of the leading one ahead of the rotor's y axis; all eccentricities or unbalances of the key rotate with it.",
}


class SceneTables(Protocol):
    """The parts of a `rsc.scene.scene.Scene` used here."""

    @property
    def source(self) -> str: ...
    @property
    def rotor(self) -> Any: ...
    @property
    def contacts(self) -> tuple[Any, ...]: ...
    def section(self, table: str) -> Any: ...
    def table_name(self, name: str, dotted: object, value: object = None) -> str: ...


def at_contacts(scene: SceneTables, name: str) -> list[str]:
    """The names of a value at every contact if it starts with `contact.*`; else the name itself."""
    if not name.startswith(f"{EVERY}."):
        return [name]
    tables = [f"contact.{contact.name}" for contact in scene.contacts] if len(scene.contacts) > 1 else ["contact"]
    return [table + name.removeprefix(EVERY) for table in tables]


def each_contact(scene: SceneTables, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values with `contact.*` expanded to every contact; SceneError if a value is given twice."""
    each: dict[str, Any] = {}
    for name, value in values.items():
        for full in at_contacts(scene, name):
            if full in each:
                raise SceneError(scene.source, one_line(full), shown(value), "given once", f"{EVERY} means every contact")
            each[full] = value
    return each


def whole_keys(scene: SceneTables, values: Mapping[str, Any]) -> dict[str, Any]:
    """The same values with amounts and angles replaced by whole keys.

    Raises
    ------
    SceneError
        An amount or angle together with its whole key, or of eccentricities that are all zero; a value given twice.
    """
    whole = each_contact(scene, values)
    polar: dict[tuple[str, str, str], dict[str, Any]] = {}
    for name in list(whole):
        if (polar_parts := polar_name(scene, name)) is not None:
            table, key, word = polar_parts
            polar.setdefault((name.removesuffix(f".{word}"), table, key), {})[word] = whole.pop(name)
    for (dotted, table, key), wanted in polar.items():
        if dotted in whole:
            hint = f"{dotted}.amount keeps the angle"
            raise SceneError(scene.source, dotted, shown(whole[dotted]), f"left out beside its {' and '.join(wanted)}", hint)
        whole[dotted] = _changed(scene, table, key, wanted)
    return whole


def polar_name(scene: SceneTables, name: str) -> tuple[str, str, str] | None:
    """(table, key, "amount" or "angle") of the name of an amount or angle; None for any other name."""
    dotted, _, word = name.rpartition(".")
    table, _, key = dotted.rpartition(".")
    if word not in POLAR or not table:
        return None
    table = scene.table_name(table, name)
    return (table, key, word) if polar_readers(scene.section(table), key) else None


def polar_readers(section: type, key: str) -> dict[str, Number]:
    """The readers of "amount" and "angle" of a key that holds one eccentricity, or an eccentricity or unbalance per coordinate;
    empty for other keys."""
    for reader in [item.metadata.get("reader") for item in fields(section) if item.name == key]:
        for form in reader.forms if isinstance(reader, Later) else (reader,):
            item = form.item if isinstance(form, Sequence) else form
            if isinstance(item, PairReader) and item.dimension == "unbalance":
                item = PolarReader(item.dimension)
            if isinstance(item, PolarReader):
                return dict(zip(POLAR, item.items, strict=True))
    return {}


def leading(scene: SceneTables, table: str, key: str) -> Polar:
    """The leading eccentricity of a key (a single one even if zero); SceneError if there is none."""
    polars = polars_of(scene, table, key)
    if isinstance(polars, Polar):
        return polars
    for i, polar in enumerate(map(_polar, polars)):
        if polar.amount and i not in scene.rotor.tilts:
            return polar
    hint = "its amount and angle are those of the first nonzero one"
    raise SceneError(scene.source, f"{table}.{key}", plain(polars), "other than zero at some displacement", hint)


def polars_of(scene: SceneTables, table: str, key: str) -> Polar | tuple[Polar | complex, ...]:
    """Value of a key of amounts and angles: one Polar, or one per coordinate; unbalances are complex numbers."""
    kind, _, name = table.partition(".")
    section = next(item for item in scene.contacts if name in ("", item.name)) if kind == "contact" else getattr(scene, kind)
    polars: Polar | tuple[Polar | complex, ...] = getattr(section, key)
    return polars


def pairs_of(scene: SceneTables, table: str, key: str) -> list[Any]:
    """[amount, angle] of a key of amounts and angles, or a list of them per coordinate; empty for any other key."""
    if not polar_readers(scene.section(table), key):
        return []
    polars = polars_of(scene, table, key)
    if isinstance(polars, Polar):
        return [polars.amount, polars.angle]
    return [[polar.amount, polar.angle] for polar in polars if isinstance(polar, Polar)]


def _polar(value: Polar | complex) -> Polar:
    """A complex number as a Polar."""
    return value if isinstance(value, Polar) else Polar(abs(value), math.degrees(cmath.phase(value)))


def _changed(scene: SceneTables, table: str, key: str, wanted: Mapping[str, Any]) -> Any:
    """Plain content of a key of amounts and angles with a new leading amount, angle or both."""
    readers, section = polar_readers(scene.section(table), key), RawTable(scene.source, table, {})
    lead, polars = leading(scene, table, key), polars_of(scene, table, key)
    numbers = {word: readers[word].read(section, f"{key}.{word}", raw) for word, raw in wanted.items()}
    if isinstance(polars, Polar):
        return plain(replace(polars, **numbers))
    each = [(value, _beside(_polar(value), lead, **numbers)) for value in polars]
    return plain(tuple(polar if isinstance(value, Polar) else complex(polar) for value, polar in each))


def _beside(polar: Polar, lead: Polar, amount: float | None = None, angle: float | None = None) -> Polar:
    """An eccentricity scaled and rotated along with a leading one, which gets exactly the new amount and angle."""
    if amount is not None:
        polar = replace(polar, amount=amount * (polar.amount / lead.amount))
    return polar if angle is None else replace(polar, angle=angle + (polar.angle - lead.angle))
