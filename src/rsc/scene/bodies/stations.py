"""Places along a shaft in other tables: `at` of [contact] and [[clearance]] becomes a node of the shaft."""

from collections.abc import Mapping, Sequence
from typing import Any

from rsc.scene.bodies.shafts import Stations
from rsc.scene.keys.keys import RawTable

KEYS = {"rotor": "at", "stator": "stator_at"}


def with_nodes(tables: Sequence[RawTable], name: str, stations: Stations) -> list[RawTable]:
    """The tables with nodes of the shaft "rotor" or "stator" in the place of places along it.

    A contact has the diameter of the shaft there, or of the disk, unless it names one.

    Raises
    ------
    SceneError
        A place that the shaft does not have.
    """
    key, node = KEYS[name], f"{name}_node"
    made = []
    for table in tables:
        if key in table.values:
            values = {own: value for own, value in table.values.items() if own != key}
            for other in (node, f"{name}_coordinate"):
                if other in values:
                    table.refuse(other, values[other], f"left out when {key} is given", "they exclude each other")
            values[node] = stations.node(table, key, table.values[key])
            if name == "rotor" and table.name.startswith("contact"):
                values.setdefault("diameter", stations.shaft.diameter_at(stations.shaft.places[values[node]]))
            table = RawTable(table.file, table.name, values, table.folder)
        made.append(table)
    return made


def refuse_stations(table: RawTable, values: Mapping[str, Any]) -> None:
    """Refuse a place along a body that is no shaft, in whose place there would be a node by now."""
    for name, key in KEYS.items():
        if values[key] is not None:
            table.refuse(key, table.values[key], "left out", f"the {name} is no \"shaft\": give {name}_coordinate or {name}_node")
