"""Names of values beside those of keys: `contact.*.friction` is the friction of every contact; `rotor.eccentricity.angle` and
`rotor.eccentricity.amount` turn and scale all eccentricities of the rotor together, of a reduced machine `rotor.unbalance.angle`
and `rotor.unbalance.amount` its unbalance.

Amount and angle are those of the *leading* eccentricity, the first displacement's that is not zero. The others keep their ratio
to it and their angle from it: an unbalance turns and grows as a whole, whatever its distribution.
"""

import cmath
import math
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, Protocol

from rsc.errors import SceneError, one_line, shown
from rsc.scene.keys.keys import Later, Number, PairReader, Polar, PolarReader, RawTable, Sequence, plain

EVERY = "contact.*"
# what is told of an eccentricity by a name of its own, in the order of `PolarReader.items`, and what it means
POLAR = {
    "amount": "Amount: all eccentricities or unbalances of the key are scaled with it.",
    "angle": "Angle ahead of the rotor's y axis: all eccentricities or unbalances of the key turn with it.",
}


class SceneTables(Protocol):
    """What names need of a `rsc.scene.scene.Scene`."""

    @property
    def source(self) -> str: ...
    @property
    def rotor(self) -> Any: ...
    @property
    def contacts(self) -> tuple[Any, ...]: ...
    def section(self, table: str) -> Any: ...
    def table_name(self, name: str, dotted: object, value: object = None) -> str: ...


def at_contacts(scene: SceneTables, name: str) -> list[str]:
    """The names of a value at every contact, where it is one of `contact.*`; else the name itself."""
    if not name.startswith(f"{EVERY}."):
        return [name]
    tables = [f"contact.{contact.name}" for contact in scene.contacts] if len(scene.contacts) > 1 else ["contact"]
    return [table + name.removeprefix(EVERY) for table in tables]


def each_contact(scene: SceneTables, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values with those of `contact.*` under the names of every contact; SceneError where one is given twice."""
    each: dict[str, Any] = {}
    for name, value in values.items():
        for own in at_contacts(scene, name):
            if own in each:
                raise SceneError(scene.source, one_line(own), shown(value), "given once", f"{EVERY} is every contact")
            each[own] = value
    return each


def whole_keys(scene: SceneTables, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values by the names of keys alone, with the same meaning.

    Raises
    ------
    SceneError
        An amount or angle beside its whole key or of eccentricities that are all zero, or a value given twice.
    """
    whole = each_contact(scene, values)
    polar: dict[tuple[str, str, str], dict[str, Any]] = {}
    for name in list(whole):
        if (own := polar_name(scene, name)) is not None:
            table, key, word = own
            polar.setdefault((name.removesuffix(f".{word}"), table, key), {})[word] = whole.pop(name)
    for (dotted, table, key), wanted in polar.items():
        if dotted in whole:
            hint = f"{dotted}.amount leaves the angle as it is"
            raise SceneError(scene.source, dotted, shown(whole[dotted]), f"left out beside its {' and '.join(wanted)}", hint)
        whole[dotted] = _changed(scene, table, key, wanted)
    return whole


def polar_name(scene: SceneTables, name: str) -> tuple[str, str, str] | None:
    """(table, key, "amount" or "angle") of the name of such a value; None of any other name."""
    dotted, _, word = name.rpartition(".")
    table, _, key = dotted.rpartition(".")
    if word not in POLAR or not table:
        return None
    table = scene.table_name(table, name)
    return (table, key, word) if polar_readers(scene.section(table), key) else None


def polar_readers(section: type, key: str) -> dict[str, Number]:
    """The readers of "amount" and "angle" of a key, whether it is one eccentricity, or one or an unbalance for every coordinate;
    else none."""
    for reader in [item.metadata.get("reader") for item in fields(section) if item.name == key]:
        for form in reader.forms if isinstance(reader, Later) else (reader,):
            item = form.item if isinstance(form, Sequence) else form
            if isinstance(item, PairReader) and item.dimension == "unbalance":
                item = PolarReader(item.dimension)
            if isinstance(item, PolarReader):
                return dict(zip(POLAR, item.items, strict=True))
    return {}


def leading(scene: SceneTables, table: str, key: str) -> Polar:
    """The leading eccentricity of a key, that of a single one whatever it is; SceneError where it has none."""
    polars = polars_of(scene, table, key)
    if isinstance(polars, Polar):
        return polars
    for i, polar in enumerate(map(_polar, polars)):
        if polar.amount and i not in scene.rotor.tilts:
            return polar
    hint = "its amount and angle are those of the first such"
    raise SceneError(scene.source, f"{table}.{key}", plain(polars), "other than zero at some displacement", hint)


def polars_of(scene: SceneTables, table: str, key: str) -> Polar | tuple[Polar | complex, ...]:
    """What a scene has under a key of amounts and angles: one, or one for every coordinate, of unbalances complex numbers."""
    kind, _, name = table.partition(".")
    section = next(own for own in scene.contacts if name in ("", own.name)) if kind == "contact" else getattr(scene, kind)
    polars: Polar | tuple[Polar | complex, ...] = getattr(section, key)
    return polars


def pairs_of(scene: SceneTables, table: str, key: str) -> list[Any]:
    """[amount, angle] of a key that is read so, or a list of such for every coordinate; none of any other key."""
    if not polar_readers(scene.section(table), key):
        return []
    polars = polars_of(scene, table, key)
    if isinstance(polars, Polar):
        return [polars.amount, polars.angle]
    return [[polar.amount, polar.angle] for polar in polars if isinstance(polar, Polar)]


def _polar(value: Polar | complex) -> Polar:
    """A complex number as amount and angle."""
    return value if isinstance(value, Polar) else Polar(abs(value), math.degrees(cmath.phase(value)))


def _changed(scene: SceneTables, table: str, key: str, wanted: Mapping[str, Any]) -> Any:
    """Plain content of a key of amounts and angles with another leading amount, angle or both."""
    readers, own = polar_readers(scene.section(table), key), RawTable(scene.source, table, {})
    lead, polars = leading(scene, table, key), polars_of(scene, table, key)
    numbers = {word: readers[word].read(own, f"{key}.{word}", raw) for word, raw in wanted.items()}
    if isinstance(polars, Polar):
        return plain(replace(polars, **numbers))
    each = [(value, _beside(_polar(value), lead, **numbers)) for value in polars]
    return plain(tuple(polar if isinstance(value, Polar) else complex(polar) for value, polar in each))


def _beside(polar: Polar, lead: Polar, amount: float | None = None, angle: float | None = None) -> Polar:
    """An eccentricity beside a leading one of another amount and angle; the leading one has exactly these."""
    if amount is not None:
        polar = replace(polar, amount=amount * (polar.amount / lead.amount))
    return polar if angle is None else replace(polar, angle=angle + (polar.angle - lead.angle))
