"""A machine of a scene before reduction: its model, unbalances, loads and observers; read here from a file of `rsc import`."""

from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import Any, NamedTuple

from rsc.errors import DataError, one_line
from rsc.scene.bodies.controls import Control, machine_bearings, placed_states, states_until
from rsc.scene.bodies.off import off_time
from rsc.scene.bodies.reduced import AMOUNT, BEARINGS, MachineRotor, MachineStator
from rsc.scene.keys.keys import RawTable, read_table
from rsc.scene.keys.readers import Number, PairReader, as_list, per_coordinate
from rsc.units import DIMENSIONS


class Machine(NamedTuple):
    """A machine before reduction."""

    model: Any  # rsc.machine.model.model.Model, with its bearings but those that are switched off
    origin: str  # description for users
    key: str  # key of its table, and value, named in errors about the whole machine
    value: Any
    at_nodes: dict[str, Any]  # unbalances, loads and gravity, as arguments of `rsc.machine.model.contact.body_of`
    observers: list[Any]
    switched: tuple[tuple[float, Any], ...] = ()  # (time, the model until then) of bearings that are switched off, by time
    controls: tuple[Control, ...] = ()  # first-order states, magnetic bearings included

    @property
    def earlier(self) -> list[Any]:
        """The models until each time at which bearings that are part of it are switched off."""
        return [model for _, model in self.switched]

    @property
    def stages(self) -> list[tuple[Any, Any]]:
        """(model, its StateMatrices or None) from each time to the next at which bearings are switched off."""
        times = sorted({*(time for time, _ in self.switched), *(one.off for one in self.controls if one.off is not None)})
        acting = [next((model for off, model in self.switched if off >= time), self.model) for time in times]
        pairs = zip((*acting, self.model), (*times, inf), strict=True)
        return [(model, states_until(self.controls, model, time)) for model, time in pairs]


def machine_of_file(table: RawTable, elsewhere: Any, nodes: Sequence[Any]) -> Machine:
    """The machine of a table with a file name; nodes: nodes of clearances, which are observed, too.

    Raises
    ------
    SceneError
        An invalid file, bearing, observer or unbalance.
    """
    from rsc.machine.imports.store import load_model

    rotor = table.name == "rotor"
    values = read_table(MachineRotor if rotor else MachineStator, table, elsewhere)
    if table.folder is None:
        table.refuse("file", values["file"], "no file", "the scene of a result contains the reduced body")
    try:
        model, digest = load_model(table.folder / values["file"])
    except DataError as error:
        table.refuse("file", values["file"], "a file written by `rsc import`", error.problem)
    if values["sha256"] is not None and values["sha256"] != digest:
        table.refuse("file", values["file"], f"the file whose SHA-256 is {values['sha256'][:16]}...", f"it has {digest[:16]}...")
    if model.anisotropic_mass is not None:
        table.refuse("file", values["file"], "a model with isotropic mass")
    switched: tuple[tuple[float, Any], ...] = ()
    controls: tuple[Control, ...] = ()
    if rotor:
        model, switched = _with_bearings(table, model, values["bearings"])
        controls = _controls(table, model, values)
    origin = f"{model.source} ({values['file']}, sha256 {digest[:16]})"
    at_nodes = _at_nodes(table, values) if rotor else {}
    observers = _observers(table, values["observers"], nodes)
    values.refuse_untaken(besides=("contact",))  # contact locations are read with the contacts
    return Machine(model, origin, "file", values["file"], at_nodes, observers, switched, controls)


def _controls(table: RawTable, model: Any, values: Mapping[str, Any]) -> tuple[Control, ...]:
    """The first-order states of a machine, between nodes that it has."""
    from rsc.machine.model.contact import row_at

    def place(table: RawTable, key: str, raw: Any) -> Any:
        try:
            row_at(model, place_of(table, raw, key))
        except (DataError, ValueError, TypeError) as error:
            table.refuse(key, raw, "a place of the model", getattr(error, "problem", ""))
        return raw

    made = placed_states(table, values["states"], place) + machine_bearings(table, values["magnetic_bearings"], place)
    return tuple(made)


def _observers(table: RawTable, raw: object, nodes: Sequence[Any]) -> list[Any]:
    """The observed nodes of a body, followed by those of clearances."""
    observers = as_list(raw)
    if observers is None:
        table.refuse("observers", raw, "a list of nodes")
    for node in nodes:
        if one_line(node) not in map(one_line, observers):
            observers.append(place_of(table, node, "observers"))
    return observers


def place_of(table: RawTable, raw: object, key: str = "contact") -> Any:
    """Read a node, a place between two nodes, or for the contact of a rotor two nodes that may touch (`Against`)."""
    if isinstance(raw, Mapping) and key == "contact" and table.name == "rotor":
        if set(raw) != {"node", "against"}:
            table.refuse(key, dict(raw), "{node = ..., against = ...}, two nodes in contact with each other")
        from rsc.machine.model.contact import Against

        return Against(*(place_of(table, raw[end], f"contact.{end}") for end in ("node", "against")))
    if isinstance(raw, (int, str)) and not isinstance(raw, bool):
        return raw
    parts = as_list(raw)
    if parts is None or len(parts) != 3:
        table.refuse(key, raw, "a node (number or name), or [node, node, fraction of the distance]")
    return parts


def _with_bearings(table: RawTable, model: Any, raw: object) -> tuple[Any, tuple[tuple[float, Any], ...]]:
    """The model with the bearings of the scene that stay, and `Machine.switched`."""
    from rsc.machine.imports.bearings import Bearing, with_bearings

    bearings, items = [], as_list(raw)
    if items is None:
        table.refuse("bearings", raw, BEARINGS.wanted)
    for i, item in enumerate(items):
        key, off = f"bearings[{i}]", None
        if isinstance(item, Mapping):
            item, off = _switched_off(table, key, item)
        parts = as_list(item)
        if parts is None or len(parts) not in (2, 3):
            table.refuse(key, item, BEARINGS.wanted)
        units = zip(("stiffness", "damping"), parts[1:], strict=False)
        coefficients = [coefficients_of(table, f"{key}[{k}]", part, unit) for k, (unit, part) in enumerate(units, 1)]
        bearings.append((off, Bearing(_node(table, f"{key}[0]", parts[0]), *coefficients)))

    def at(time: float | None) -> Any:
        """The model with those that are there until a time, or that stay."""
        holding = [one for off, one in bearings if off is None or (time is not None and off >= time)]
        return with_bearings(model, holding, required=False)

    try:
        return at(None), switched_models(at, [off for off, _ in bearings])
    except DataError as error:
        table.refuse("bearings", raw, "bearings at nodes of the model", error.problem)


def switched_models(at: Callable[[float], Any], offs: Sequence[float | None]) -> tuple[tuple[float, Any], ...]:
    """(time, model until then) for each time at which bearings are switched off, given the function that makes the model."""
    return tuple((off, at(off)) for off in sorted({off for off in offs if off is not None}))


def _switched_off(table: RawTable, key: str, item: Mapping[str, Any]) -> tuple[list[Any], float | None]:
    """([node, stiffness, damping], off) of a bearing given as a table."""
    if not {"node", "stiffness"} <= set(item) <= {"node", "stiffness", "damping", "off"}:
        table.refuse(key, dict(item), "{node = ..., stiffness = ..., damping = ..., off = ...}")
    parts = [item[name] for name in ("node", "stiffness", "damping") if name in item]
    return parts, off_time(table, f"{key}.off", item.get("off"))


def coefficients_of(table: RawTable, key: str, raw: Any, unit: str) -> Any:
    """[yy, yz, zy, zz] from a single number (isotropic) or from four."""
    if as_list(raw) is None:
        value = Number(unit).read(table, key, raw)
        return value, 0.0, 0.0, value
    if len(raw) != 4:
        table.refuse(key, raw, f"a number in {DIMENSIONS[unit][0]}, or [yy, yz, zy, zz]")
    return per_coordinate(table, key, raw, [Number(unit)] * 4)


def _node(table: RawTable, key: str, raw: Any) -> Any:
    if isinstance(raw, bool) or not isinstance(raw, (int, str)):
        table.refuse(key, raw, "a node, number or name")
    return raw


def _at_nodes(table: RawTable, values: Mapping[str, Any]) -> dict[str, Any]:
    """Unbalances, loads and gravity of a rotor."""
    from rsc.machine.model.contact import Unbalance

    unbalances, loads = [], []
    for i, raw in enumerate(as_list(values["unbalance"]) or []):
        parts, key = as_list(raw), f"unbalance[{i}]"
        if parts is None or len(parts) not in (2, 3):
            table.refuse(key, raw, "[node, amount] or [node, amount, angle in degrees]")
        angle = Number("angle in degrees").read(table, f"{key}[2]", parts[2]) if len(parts) == 3 else 0.0
        unbalances.append(Unbalance(parts[0], amount_at(table, f"{key}[1]", parts[1]), angle))
    for i, raw in enumerate(as_list(values["load"]) or []):
        parts = as_list(raw)
        if parts is None or len(parts) != 2:
            table.refuse(f"load[{i}]", raw, "[node, [f_y, f_z] in N]")
        loads.append((parts[0], PairReader("force").read(table, f"load[{i}][1]", parts[1])))
    return {"unbalances": unbalances, "loads": loads, "gravity": values["gravity"] or 0.0}


def amount_at(table: RawTable, key: str, raw: object) -> float | str:
    """Amount in kg m, or the text of a balance grade."""
    if isinstance(raw, str) and raw.strip().startswith("G"):
        return raw
    return AMOUNT.read(table, key, raw)
