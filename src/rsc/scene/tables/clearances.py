"""[[clearance]]: locations with a gap but no contact in the model, monitored by runs and predictions without any force."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rsc.errors import SceneError, one_line, shown
from rsc.scene.bodies.reduced import PLACE
from rsc.scene.bodies.shaft_keys import PLACE as STATION
from rsc.scene.bodies.stations import refuse_stations
from rsc.scene.keys.keys import OPTIONAL, RawTable, declare, read_table
from rsc.scene.keys.readers import MAX_COORDINATES, Integer, Name, Number, as_list, plain_section

KEY = "clearance"
MAX_CLEARANCES = 16


@dataclass(frozen=True, kw_only=True)
class Clearance:
    """[[clearance]]: a location of the rotor, relative to ground or to a location of the stator."""

    name: str = declare(Name(), meaning="Its name, in reports and as `clearance.NAME.gap`.")
    gap: float = declare(
        Number("length", above=0.0), meaning="Radial gap of the centred rotor, half the diametral clearance."
    )
    rotor_coordinate: int | None = declare(
        Integer(0, MAX_COORDINATES), None, meaning="Number of the rotor coordinate, counted from 0."
    )
    rotor_node: str | None = declare(
        PLACE, None, meaning="Node of the rotor in a finite-element model; it becomes an observer."
    )
    stator_coordinate: int | None = declare(
        Integer(0, MAX_COORDINATES), None, meaning="Number of the stator coordinate; by default the ground."
    )
    stator_node: str | None = declare(PLACE, None, meaning="Node of the stator in a finite-element model.")

    at: object = declare(STATION, None, meaning="Position along a rotor with model \"shaft\".")
    stator_at: object = declare(STATION, None, meaning="Position along a stator with model \"shaft\".")

    one_of = ((("rotor_coordinate", "rotor_node", "at"), None), (("stator_coordinate", "stator_node", "stator_at"), OPTIONAL))

    def to_dict(self) -> dict[str, Any]:
        """Plain content of the table."""
        content: dict[str, Any] = plain_section(self)
        return content


def clearance_tables(mapping: Mapping[str, Any], file: str, folder: Path | None) -> list[RawTable]:
    """The tables [[clearance]] of a scene."""
    content = as_list(mapping.get(KEY, []))
    if content is None or len(content) > MAX_CLEARANCES:
        raise SceneError(file, KEY, shown(mapping[KEY]), f"at most {MAX_CLEARANCES} tables [[{KEY}]]")
    tables = []
    for i, values in enumerate(content):
        if not isinstance(values, Mapping):
            raise SceneError(file, f"{KEY}[{i}]", shown(values), f"a table [[{KEY}]]")
        name = values.get("name")
        known = isinstance(name, str) and re.fullmatch(Name.pattern, name)
        tables.append(RawTable(file, f"{KEY}.{name}" if known else f"{KEY}[{i}]", values, folder))
    return tables


def nodes_of(tables: Sequence[RawTable], body: str) -> list[Any]:
    """The nodes of "rotor" or "stator" in clearances, as written in the file."""
    return [table.values[f"{body}_node"] for table in tables if f"{body}_node" in table.values]


def read_clearances(tables: Sequence[RawTable], elsewhere: Any, rotor: Any, stator: Any) -> tuple[Clearance, ...]:
    """Read all [[clearance]] tables and check the locations against the bodies."""
    clearances: list[Clearance] = []
    for table in tables:
        values = read_table(Clearance, table, elsewhere)
        if values["name"] in [other.name for other in clearances]:
            table.refuse("name", values["name"], "a unique name", "another clearance has it")
        refuse_stations(table, values)
        for name, body in (("rotor", rotor), ("stator", stator)):
            _refuse_place(table, values, name, body)
        clearances.append(values.made(Clearance))
    return tuple(clearances)


def _refuse_place(table: RawTable, values: dict[str, Any], name: str, body: Any) -> None:
    """SceneError for a location that the body does not have; replaces a node by the name of its observer."""
    i, node = values[f"{name}_coordinate"], values[f"{name}_node"]
    if i is not None:
        if i >= body.n_coordinates:
            wanted = f"a whole number from 0 to {body.n_coordinates - 1}" if body.n_coordinates else "left out"
            table.refuse(f"{name}_coordinate", i, wanted, "" if body.n_coordinates else f"the {name} has no coordinates")
        if i in body.tilts:
            table.refuse(f"{name}_coordinate", i, "a displacement", f"coordinate {i} is a tilt")
    if node is not None:
        values[f"{name}_node"] = one_line(node)
        known = getattr(body, "observers", ())
        if one_line(node) not in known:
            wanted = "one of " + ", ".join(known) if known else "left out"
            hint = "" if known else f"the {name} is not a finite-element model: give {name}_coordinate"
            table.refuse(f"{name}_node", node, wanted, hint)
