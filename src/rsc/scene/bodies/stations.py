"""Positions along a shaft in other tables: `at` of [contact] and [[clearance]] is replaced by a node of the shaft."""

from collections.abc import Mapping, Sequence
from typing import Any

from rsc.scene.bodies.shafts import Stations
from rsc.scene.keys.keys import RawTable

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
                values.setdefault("diameter", stations.shaft.diameter_at(stations.shaft.places[values[node]]))
            table = RawTable(table.file, table.name, values, table.folder)
        made.append(table)
    return made


def refuse_stations(table: RawTable, values: Mapping[str, Any]) -> None:
    """SceneError for a position along a body that is not a shaft (for shafts it has been replaced by a node)."""
    for name, key in KEYS.items():
        if values[key] is not None:
            hint = f"the {name} does not have model \"shaft\": give {name}_coordinate or {name}_node"
            table.refuse(key, table.values[key], "left out", hint)
