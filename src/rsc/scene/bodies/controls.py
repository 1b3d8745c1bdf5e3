"""Magnetic bearings and other first-order states of machines and shafts, given by the places of their sensors and actuators.

The reduction of the machine turns the places into rows of its reduced coordinates; what acts between them stays as it is.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from rsc.scene.bodies.states import (
    ENTRIES,
    NUMBERS,
    MagneticBearing,
    StateMatrices,
    checked,
    of_bearing,
    refuse_many,
    refuse_shapes,
    squared,
    together,
)
from rsc.scene.keys.keys import RawTable, declare, known_keys, read_table
from rsc.scene.keys.nested import Inner
from rsc.scene.keys.readers import Integer, Later, Listed, Text, as_list, plain_section
from rsc.scene.keys.readers import Sequence as Items

_NODE = Integer(-(10**9), 10**9)
PLACES = Later("a list of places, as `observers`", (Items(_NODE), Items(Text())))
Place = Callable[[RawTable, str, Any], Any]  # reads a place of the body


@dataclass(frozen=True, kw_only=True)
class PlacedStates:
    """First-order states z of a machine, alike in both directions: z' = Az z + Bz s + Bv s' from the displacements s at sensors,
    with the forces Lz z at actuators."""

    matrix: tuple = declare(ENTRIES, meaning="Az, p x p for p states.")
    sensors: object = declare(PLACES, meaning="Places of the sensors.")
    displacement: tuple | None = declare(ENTRIES, None, meaning="Bz, p x sensors: what displacements do to the states.")
    velocity: tuple | None = declare(ENTRIES, None, meaning="Bv, p x sensors: what velocities do to the states.")
    actuators: object = declare(PLACES, meaning="Places of the actuators.")
    force: tuple = declare(ENTRIES, meaning="Lz, actuators x p: forces of the states, N.")


@dataclass(frozen=True, kw_only=True)
class MachineBearing(MagneticBearing):
    """A magnetic bearing at a node, with its sensor there or at another node."""

    sensor: object = declare(Later("a node, or a place between two", (_NODE, Text())), None, meaning="Its sensor, if elsewhere.")


STATES = Later(Inner(PlacedStates).wanted, (Inner(PlacedStates),))
STATES_MEANING = "First-order states between sensors and actuators: controllers, lags, viscoelastic supports."
MACHINE_BEARINGS = Later(
    f"a list of [node, {{{NUMBERS}, sensor}}]", (Items(Listed((_NODE, Inner(MachineBearing)))),)
)
BEARINGS_MEANING = "Magnetic bearings with their controllers"


class Control(NamedTuple):
    """First-order states between places of a machine.

    actuators, sensors : places as `rsc.machine.model.contact.row_at` takes them
    own : MagneticBearing, with one of each, or PlacedStates
    name : of a magnetic bearing of a shaft
    """

    actuators: list[Any]
    sensors: list[Any]
    own: Any
    name: str = ""

    @property
    def off(self) -> float | None:
        """Time in s at which it is switched off; None if it stays."""
        return getattr(self.own, "off", None)

    def rows(self, model: Any) -> tuple[Any, Any]:
        """Rows of the displacements at actuators and sensors in the coordinates of a model. DataError for an unknown place."""
        from rsc.machine.model.contact import row_at

        actuators, sensors = (np.array([row_at(model, place) for place in places]) for places in (self.actuators, self.sensors))
        return actuators, sensors

    def states(self, actuators: Any, sensors: Any) -> StateMatrices:
        """Its StateMatrices in coordinates with these rows (k, n)."""
        if isinstance(self.own, MagneticBearing):
            return of_bearing(self.own, actuators[0], sensors[0])
        matrix, none = np.array(self.own.matrix), np.zeros((len(self.own.matrix), len(sensors)))
        parts = (none if part is None else np.array(part) for part in (self.own.displacement, self.own.velocity))
        sensed, moved = (part @ sensors for part in parts)
        return StateMatrices(matrix, sensed, moved, actuators.T @ np.array(self.own.force), squared(0.0 * actuators[0]))


def bearing_of(table: RawTable, values: Mapping[str, Any]) -> MagneticBearing:
    """The magnetic bearing alone, from its own table with places; SceneError for one that cannot be built."""
    return checked(table, MagneticBearing(**{name: values[name] for name in known_keys(MagneticBearing)}))


def machine_bearings(table: RawTable, raw: Any, place: Place) -> list[Control]:
    """The magnetic bearings of a machine, [[node, {...}], ...]."""
    items, made = [] if raw is None else as_list(raw), []
    if items is None:
        table.refuse("magnetic_bearings", raw, MACHINE_BEARINGS.wanted)
    for i, item in enumerate(items):
        parts, key = as_list(item), f"magnetic_bearings[{i}]"
        if parts is None or len(parts) != 2:
            table.refuse(key, item, f"[node, {{{NUMBERS}, sensor}}]")
        if not isinstance(parts[1], Mapping):
            table.refuse(f"{key}[1]", parts[1], Inner(MachineBearing).wanted)
        inner = table.within(key, parts[1])
        own, actuator = read_table(MachineBearing, inner), place(table, f"{key}[0]", parts[0])
        sensor = actuator if own["sensor"] is None else place(inner, "sensor", own["sensor"])
        made.append(Control([actuator], [sensor], bearing_of(inner, own)))
    refuse_many(table, [control.own for control in made])
    return made


def placed_states(table: RawTable, raw: Any, place: Place) -> list[Control]:
    """The first-order states of a machine, none or one Control."""
    if raw is None:
        return []
    if not isinstance(raw, Mapping):
        table.refuse("states", raw, STATES.wanted)
    values = read_table(PlacedStates, table.within("states", raw))
    states = PlacedStates(**{name: values[name] for name in known_keys(PlacedStates)})
    listed = {name: as_list(getattr(states, name)) for name in ("actuators", "sensors")}
    for name, items in listed.items():
        if not items:
            table.refuse(f"states.{name}", getattr(states, name), "a list of one or more places")
    refuse_shapes(table, states, {name: len(items or ()) for name, items in listed.items()})
    both = [[place(table, f"states.{name}[{i}]", item) for i, item in enumerate(items or ())] for name, items in listed.items()]
    return [Control(both[0], both[1], states)]


def states_until(controls: Sequence[Control], model: Any, until: float = np.inf) -> StateMatrices | None:
    """The states of a model but for those of bearings that are switched off before a time in s; None without any."""
    acting = [control for control in controls if control.off is None or control.off >= until]
    return together([control.states(*control.rows(model)) for control in acting])


def control_content(controls: Sequence[Control], model: Any, basis: Any) -> dict[str, Any]:
    """Keys `states` and `magnetic_bearings` of a reduced body, displacements = basis @ reduced ones."""
    content: dict[str, Any] = {}
    bearings = []
    for control in controls:
        rows = [part @ basis for part in control.rows(model)]
        if isinstance(control.own, MagneticBearing):
            bearings.append([rows[0][0].tolist(), rows[1][0].tolist(), plain_section(control.own)])
            continue
        own = control.states(*rows)
        matrices = {name: getattr(own, name) for name in ("matrix", "displacement", "velocity", "force")}
        content["states"] = {name: matrix.tolist() for name, matrix in matrices.items()}
    return content | ({"magnetic_bearings": bearings} if bearings else {})
