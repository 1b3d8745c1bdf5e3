"""What a reduced rotor keeps of its shaft for pictures: the parts of its drawing, and the displacements of its nodes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from rsc.errors import one_line
from rsc.scene.bodies.states import MagneticBearing
from rsc.scene.keys.keys import RawTable
from rsc.scene.keys.readers import Choice, Number, as_list

SECTION, SLEEVE, DISK, CYLINDER, BEARING, CONTACT, PLACE = (
    "section", "sleeve", "disk", "cylinder", "bearing", "contact", "place",
)  # fmt: skip
KINDS = (SECTION, SLEEVE, DISK, CYLINDER, BEARING, CONTACT, PLACE)
MOST_NAME = 500  # characters
_DIGITS = 6  # of the displacements of nodes


class Drawn(NamedTuple):
    """A part of the drawing, between two positions in m from the left end, with its diameters in m at both.

    kind : "section", "sleeve", "disk", "cylinder" (a disk of unknown diameter, as wide as a solid cylinder of its mass and polar
        moment of inertia), "bearing", "contact" (in the order of the coordinates) or "place" (observed, such as that of a
        clearance); a disk of unknown width ends where it starts
    """

    kind: str
    name: str
    start: float
    end: float
    left: float
    right: float
    left_bore: float = 0.0
    right_bore: float = 0.0


@dataclass(frozen=True)
class DrawnReader:
    """A `Drawn` as [kind, name, start, end, left, right, left bore, right bore]."""

    wanted = "[kind, name, start, end, left and right diameter, left and right bore] in m"

    def read(self, table: RawTable, key: str, raw: Any) -> Drawn:
        """The part."""
        parts = as_list(raw)
        if parts is None or len(parts) != len(Drawn._fields):
            table.refuse(key, raw, self.wanted)
        kind = Choice(KINDS).read(table, f"{key}[0]", parts[0])
        if not isinstance(parts[1], str) or len(parts[1]) > MOST_NAME or parts[1] != one_line(parts[1]):
            table.refuse(f"{key}[1]", parts[1], f"a text of at most {MOST_NAME} characters")
        place, diameter = Number("length"), Number("length", low=0.0)
        readers = [place, place, *[diameter] * (len(parts) - 4)]  # a wide disk on the end of a shaft begins before it
        numbered = enumerate(zip(readers, parts[2:], strict=True), 2)
        numbers = [reader.read(table, f"{key}[{i}]", part) for i, (reader, part) in numbered]
        if numbers[1] < numbers[0]:
            table.refuse(key, raw, "a part that ends where it starts, or to the right of that")
        return Drawn(kind, parts[1], *numbers)


def drawn_content(model: Any, basis: Any, touching: Sequence[Any], controls: Sequence[Any]) -> dict[str, Any]:
    """Keys of the reduced body of a model that was made from a shaft: `drawn`, `nodes` and `node_rows`; none of another.

    basis : (n, r), displacements = basis @ reduced ones; touching : names of the contact positions;
    controls : `rsc.scene.bodies.controls.Control`; its magnetic bearings are drawn
    """
    if model.shaft is None:
        return {}
    rows = np.flatnonzero(model.kind == "displacement")
    places = np.array([model.position[node] for node in model.node[rows]])
    order = np.argsort(places)
    seen = np.asarray(basis)[rows[order]]
    return {
        "drawn": [list(part) for part in _parts(model.shaft, touching, _magnets(controls))],
        "nodes": places[order].tolist(),
        "node_rows": [[float(f"{value:.{_DIGITS}g}") for value in row] for row in seen.tolist()],
    }


def _magnets(controls: Sequence[Any]) -> list[tuple[str, str]]:
    """(place, name) of the magnetic bearings among the controls of a shaft."""
    return [(one.actuators[0], one.name) for one in controls if isinstance(one.own, MagneticBearing)]


def _parts(shaft: Any, touching: Sequence[Any], magnets: list[tuple[str, str]]) -> list[Drawn]:
    sections = len(shaft.sections)
    made = [
        Drawn(SECTION if i < sections else SLEEVE, one.section.name, one.start, one.end, *one.section.outer, *one.section.inner)
        for i, one in enumerate(shaft.placed)
    ]
    made += [_disk(disk, shaft) for disk in shaft.disks]
    at = [(BEARING, one.name, one.place) for one in shaft.supports]
    at += [(BEARING, name, shaft.places[place]) for place, name in magnets]
    drawn = [*touching, *(place for place, _ in magnets)]
    at += [(CONTACT, str(name), shaft.places[name]) for name in touching]
    at += [(PLACE, name, place) for name, place in shaft.places.items() if name not in drawn]
    return made + [Drawn(kind, one_line(name), place, place, *(shaft.diameter_at(place),) * 2) for kind, name, place in at]


def _disk(disk: Any, shaft: Any) -> Drawn:
    """A disk at its place, with its diameter and width where they are known: else with the diameter of the solid cylinder that
    has its mass and polar moment of inertia, and without width."""
    outer = float(np.sqrt(8.0 * disk.polar_inertia / disk.mass)) if disk.diameter is None else disk.diameter
    bore, half = min(replace(shaft, disks=()).diameter_at(disk.place), outer), 0.5 * (disk.width or 0.0)
    kind = CYLINDER if disk.diameter is None else DISK
    return Drawn(kind, disk.name, disk.place - half, disk.place + half, outer, outer, bore, bore)
