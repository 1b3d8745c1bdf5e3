"""Positions along a shaft in other tables: `at` of [contact] and [[clearance]] is replaced by a node of the shaft."""

from collections.abc import Mapping, Sequence
from typing import Any

from rsc.machine.shaft.parts import SAME_PLACE
from rsc.scene.bodies.shaft_keys import METRES
from rsc.scene.bodies.shafts import Stations
from rsc.scene.keys.keys import RawTable
from rsc.units import QuantityError, quantity

KEYS = {"rotor": "at", "stator": "stator_at"}


def with_nodes(tables: Sequence[RawTable], name: str, stations: Stations) -> list[RawTable]:
    """The tables with positions along the shaft "rotor" or "stator" replaced by nodes.

    The diameter of a contact defaults to that of the shaft or disk there.

    Raises
    ------
    SceneError
        A position that is not on the shaft.
    """
    key, node = KEYS[name], f"{name}_node"
    made = []
    for table in tables:
        if key in table.values:
            values = {kept: value for kept, value in table.values.items() if kept != key}
            for other in (node, f"{name}_coordinate"):
                if other in values:
                    table.refuse(other, values[other], f"left out when {key} is given", "they exclude each other")
            values[node] = stations.node(table, key, table.values[key])
            if name == "rotor" and table.name.startswith("contact"):
                _refuse_inside(table, stations, stations.shaft.places[values[node]])
                values.setdefault("diameter", stations.shaft.diameter_at(stations.shaft.places[values[node]]))
            table = RawTable(table.file, table.name, values, table.folder)
        made.append(table)
    return made


def _refuse_inside(table: RawTable, stations: Stations, place: float) -> None:
    """SceneError for a contact whose diameter is smaller than that of the shaft there, or whose gap exceeds its radius."""
    raw, least = table.values.get("diameter"), stations.shaft.least_diameter_at(place)
    diameter, gap = (_read(table.values.get(key)) for key in ("diameter", "gap"))
    diameter = stations.shaft.diameter_at(place) if diameter is None else diameter
    if diameter < least * (1.0 - SAME_PLACE):
        wanted = f"at least that of the shaft at {1e3 * place:.6g} mm, {1e3 * least:.6g} mm"
        table.refuse("diameter", raw, wanted, "it is the diameter of the surface of the rotor that touches")
    if gap is not None and gap > 0.5 * diameter:
        table.refuse("gap", table.values["gap"], f"less than the radius of the rotor there, {500.0 * diameter:.6g} mm", METRES)


def _read(raw: Any) -> float | None:
    """A length in m; None where there is none, or none that can be read, which is refused with the other keys of its table."""
    try:
        return None if raw is None else quantity(raw, "length")
    except QuantityError:
        return None


def refuse_stations(table: RawTable, values: Mapping[str, Any]) -> None:
    """SceneError for a position along a body that is not a shaft (for shafts it has been replaced by a node)."""
    for name, key in KEYS.items():
        if values[key] is not None:
            hint = f"the {name} does not have model \"shaft\": give {name}_coordinate or {name}_node"
            table.refuse(key, table.values[key], "left out", hint)
