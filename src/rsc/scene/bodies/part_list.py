"""What a reduced rotor keeps of its shaft as numbers: mass and place of every part, and the coefficients of its bearings."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from rsc.errors import one_line
from rsc.scene.bodies.drawn import DISK, MOST_NAME, SECTION, SLEEVE
from rsc.scene.keys.keys import RawTable
from rsc.scene.keys.readers import Choice, Number, as_list

_COEFFICIENTS = 8


class ShaftPart(NamedTuple):
    """A section, sleeve or disk: place of its centre of mass in m from the left end, mass in kg, moments of inertia in kg m^2
    about the axis and about a diameter through that centre."""

    kind: str
    name: str
    place: float
    mass: float
    polar_inertia: float
    diametral_inertia: float


class BearingRow(NamedTuple):
    """Coefficients of a bearing, its place in m from the left end: k_yy, k_yz, k_zy, k_zz in N/m, then damping in N s/m, at a
    rotor speed in Hz, 0 where they are constant."""

    name: str
    place: float
    speed: float
    coefficients: tuple[float, ...]


@dataclass(frozen=True)
class ShaftPartReader:
    """A `ShaftPart` as a list of its fields."""

    wanted = "[kind, name, place in m, mass in kg, polar and diametral moment of inertia in kg m^2]"

    def read(self, table: RawTable, key: str, raw: Any) -> ShaftPart:
        """The part."""
        fields = _listed(table, key, raw, len(ShaftPart._fields), self.wanted)
        kind = Choice((SECTION, SLEEVE, DISK)).read(table, f"{key}[0]", fields[0])
        numbers = _numbers(table, key, 2, fields[2:], ("length", "mass", "inertia", "inertia"), low=0.0)
        return ShaftPart(kind, _name(table, f"{key}[1]", fields[1]), *numbers)


@dataclass(frozen=True)
class BearingRowReader:
    """A `BearingRow` as [name, place, speed, eight coefficients]."""

    wanted = "[name, place in m, speed in Hz, [k_yy, k_yz, k_zy, k_zz, c_yy, c_yz, c_zy, c_zz]]"

    def read(self, table: RawTable, key: str, raw: Any) -> BearingRow:
        """The row."""
        name, place, speed, eight = _listed(table, key, raw, len(BearingRow._fields), self.wanted)
        eight = _listed(table, f"{key}[3]", eight, _COEFFICIENTS, self.wanted)
        (at,) = _numbers(table, key, 1, [place], ("length",), low=0.0)
        (turning,) = _numbers(table, key, 2, [speed], ("frequency",))
        numbers = _numbers(table, f"{key}[3]", 0, eight, ("stiffness",) * 4 + ("damping",) * 4)
        return BearingRow(_name(table, f"{key}[0]", name), at, turning, tuple(numbers))


def _listed(table: RawTable, key: str, raw: Any, count: int, wanted: str) -> list[Any]:
    parts = as_list(raw)
    if parts is None or len(parts) != count:
        table.refuse(key, raw, wanted)
    return list(parts)


def _name(table: RawTable, key: str, raw: Any) -> str:
    if not isinstance(raw, str) or len(raw) > MOST_NAME or raw != one_line(raw):
        table.refuse(key, raw, f"a text of at most {MOST_NAME} characters")
    return str(raw)


def _numbers(table: RawTable, key: str, first: int, raw: list[Any], dimensions: tuple[str, ...], **limits: Any) -> list[float]:
    pairs = enumerate(zip(dimensions, raw, strict=True), first)
    return [Number(dimension, **limits).read(table, f"{key}[{i}]", value) for i, (dimension, value) in pairs]


def mirrored_rows(rows: list[Any]) -> list[Any]:
    """The rows of bearings of the mirror image, in which the rotor turns the other way."""
    signs = (1.0, -1.0, -1.0, 1.0) * 2
    return [
        [name, place, 0.0 - speed, [number if sign > 0.0 else 0.0 - number for sign, number in zip(signs, eight, strict=True)]]
        for name, place, speed, eight in rows
    ]


def part_list(shaft: Any) -> dict[str, Any]:
    """Keys of the reduced rotor of a `rsc.machine.shaft.parts.Shaft`: `parts` and `bearing_rows`."""
    n_sections = len(shaft.sections)
    pieces = [
        ShaftPart(SECTION if i < n_sections else SLEEVE, one_line(one.section.name), one.start + one.section.centre,
                  one.section.mass, *one.section.inertias)
        for i, one in enumerate(shaft.placed)
    ]  # fmt: skip
    disks = [ShaftPart(DISK, one_line(d.name), d.place, d.mass, d.polar_inertia, d.diametral_inertia) for d in shaft.disks]
    rows = [
        [one_line(one.name), one.place, float(speed), [float(value) for value in eight]]
        for one in shaft.supports
        for speed, eight in zip(one.speeds, one.coefficients, strict=True)
    ]
    return {"parts": [list(part) for part in pieces + disks], "bearing_rows": rows}
