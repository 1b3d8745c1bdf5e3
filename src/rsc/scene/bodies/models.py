"""All models of [rotor] and [stator] by name, and reading of their tables."""

from collections.abc import Mapping
from typing import Any

from rsc.scene.bodies.body_model import SUPPORTS
from rsc.scene.bodies.by_speed import read_by_speed, read_place
from rsc.scene.bodies.reduced import MachineRotor, MachineStator, ReducedRotor, ReducedStator
from rsc.scene.bodies.rotors import ChainRotor, DiskRotor, LavalRotor, MatricesRotor
from rsc.scene.bodies.shaft_keys import ShaftRotor, ShaftStator
from rsc.scene.bodies.states import read_states
from rsc.scene.bodies.stators import ChainStator, LavalStator, MatricesStator, RigidStator
from rsc.scene.files.matrix_files import is_definite
from rsc.scene.keys.keys import RawTable, nearest, read_table
from rsc.scene.keys.readers import Number, PairReader, as_list, per_coordinate
from rsc.system.assemble import elastic_stiffness

DAMPING_KEYS = ("damping_ratio", "damping", "dampings", "rayleigh")
ROTORS = {item.model: item for item in (LavalRotor, DiskRotor, ChainRotor, MatricesRotor, ShaftRotor, MachineRotor, ReducedRotor)}
_STATORS = (RigidStator, LavalStator, ChainStator, MatricesStator, ShaftStator, MachineStator, ReducedStator)
STATORS = {item.model: item for item in _STATORS}


def read_body(models: Mapping[str, Any], table: RawTable, elsewhere: Any) -> Any:
    """Read [rotor] or [stator] according to its `model`.

    Parameters
    ----------
    models : dict
        `ROTORS` or `STATORS`.
    table : rsc.scene.keys.keys.Table
        The raw table.
    elsewhere : callable
        Hint for keys that belong to another table or model.

    Returns
    -------
    instance of a class of `models`

    Raises
    ------
    SceneError
        For any invalid input.
    """
    name = table.values.get("model")
    if not isinstance(name, str) or name not in models:
        hint = nearest(name, list(models)) if isinstance(name, str) else ""
        table.refuse("model", name, "one of " + ", ".join(f"\"{model}\"" for model in models), hint)
    section = models[name]
    values = read_table(section, table, elsewhere)
    if "rayleigh" in values and values["rayleigh"] is not None:
        readers: Any = (Number("rate"), Number("time"))
        values["rayleigh"] = per_coordinate(table, "rayleigh", values["rayleigh"], readers)
    section.resolve(values, table)
    _refuse_negative_damping(values, table)
    later = {"supports": (), "supports_by_speed": (), "magnetic_bearings": None}
    unsupported = {**values, **{key: none for key, none in later.items() if key in values}}
    if "supports" in values:
        values["supports"] = _read_supports(table, values["supports"], section(**unsupported))
    if values.get("supports_by_speed") is not None:
        values["supports_by_speed"] = read_by_speed(table, values["supports_by_speed"], section(**unsupported))
    if "states" in values:
        read_states(table, values, section(**unsupported))
    body = section(**values)
    if values.get("supports"):
        _refuse_pushing_supports(table, body)
    if values.get("load") is not None:
        readers = [PairReader("torque" if i in body.tilts else "force") for i in range(body.n_coordinates)]
        values["load"] = per_coordinate(table, "load", values["load"], readers)
        body = section(**values)
    return body


def _read_supports(table: RawTable, raw: Any, body: Any) -> tuple[Any, ...]:
    """Read supports as ((coordinate, four stiffnesses, four dampings), ...)."""
    supports = []
    items = as_list(raw)
    if items is None:
        table.refuse("supports", raw, SUPPORTS.wanted)
    for i, item in enumerate(items):
        parts, key = as_list(item), f"supports[{i}]"
        if parts is None or len(parts) not in (2, 3):
            table.refuse(key, item, SUPPORTS.wanted)
        place = read_place(table, f"{key}[0]", parts[0], body)
        readers = [Number("stiffness")] * 4, [Number("damping")] * 4
        coefficients = [per_coordinate(table, f"{key}[{k}]", part, readers[k - 1]) for k, part in enumerate(parts) if k]
        supports.append((place, *coefficients, *(((0.0,) * 4,) if len(parts) == 2 else ())))
    return tuple(supports)


def _refuse_pushing_supports(table: RawTable, body: Any) -> None:
    """SceneError for supports with negative stiffness that make the body statically unstable."""
    is_held = table.name == "stator"
    if not is_definite(elastic_stiffness(body), strictly=is_held):
        wanted = f"such that the stiffness of the {table.name} stays " + ("positive" if is_held else "positive or zero")
        table.refuse("supports", body.supports, f"{wanted} in every direction")


def _refuse_negative_damping(values: Any, table: RawTable) -> None:
    """SceneError for negative damping without allow_negative_damping."""
    if values.get("allow_negative_damping"):
        return
    hint = "set allow_negative_damping = true in [rotor] if intended" if table.name == "rotor" else ""
    for key in DAMPING_KEYS:
        value = values.get(key)
        if value is None:
            continue
        if isinstance(value, float):
            negative = value < 0.0
        elif value and isinstance(value[0], tuple):
            negative = not is_definite(value, strictly=False)
        else:
            negative = any(item < 0.0 for item in value)
        if negative:
            is_matrix = isinstance(value, tuple) and isinstance(value[0], tuple)
            table.refuse(key, value, "positive semidefinite" if is_matrix else ">= 0", hint)
