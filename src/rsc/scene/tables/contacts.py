"""[contact], or several [[contact]]: where rotor and stator may touch; reading, and checks against the bodies."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rsc.errors import SceneError, shown
from rsc.scene.bodies.body_model import RATIO
from rsc.scene.bodies.reduced import PLACE
from rsc.scene.bodies.reduced import ROTOR_PLACE as ROTOR_NODE
from rsc.scene.bodies.shaft_keys import PLACE as STATION
from rsc.scene.bodies.stations import refuse_stations
from rsc.scene.keys.keys import RawTable, declare, read_table
from rsc.scene.keys.readers import (
    MAX_COORDINATES,
    NO_ECCENTRICITY,
    Integer,
    Later,
    Listed,
    Name,
    Number,
    PairReader,
    Polar,
    PolarReader,
    as_list,
    plain,
    plain_section,
)
from rsc.units import SMALLEST

MAX_CONTACTS = 8
MIN_CONTACT_PERIOD = 1e-12  # s
_COORDINATE = Integer(0, MAX_COORDINATES)
ROTOR_PLACE = Later("a whole number, or two for contact with each other", (Listed((_COORDINATE, _COORDINATE)), _COORDINATE))


@dataclass(frozen=True, kw_only=True)
class Contact:
    """[contact], or one of several [[contact]]: contact of a rotor and a stator coordinate (physics.md (6)-(11))."""

    name: str | None = declare(Name(), None, meaning="Name of the contact; required and unique with several contacts.")
    rotor_coordinate: int | tuple[int, int] = declare(
        ROTOR_PLACE,
        0,
        meaning="Number of the rotor coordinate in contact, counted from 0; two for contact within the rotor, without stator.",
    )
    stator_coordinate: int = declare(
        Integer(0, MAX_COORDINATES), 0, meaning="Number of the stator coordinate in contact, counted from 0."
    )
    rotor_node: object = declare(
        ROTOR_NODE, None, meaning="For a rotor with model \"machine\" and several contacts: the node in contact."
    )
    stator_node: object = declare(PLACE, None, meaning="For a stator with model \"machine\": the node in contact.")
    at: object = declare(STATION, None, meaning="For a rotor with model \"shaft\": position of the contact; sets `diameter`.")
    stator_at: object = declare(STATION, None, meaning="For a stator with model \"shaft\": position of the contact.")
    gap: float = declare(
        Number("length", above=0.0, hint="the contact direction is undefined at zero gap"),
        None,
        meaning="Radial gap of the centred rotor.",
    )
    stator_diameter: float | None = declare(
        Number("length", above=0.0), None, meaning="Inner diameter of the stator; with `diameter` it determines the gap."
    )
    friction: float = declare(Number("dimensionless", low=0.0, high=5.0), meaning="Coefficient of friction.")
    stiffness: float = declare(Number("stiffness", above=0.0), meaning="Stiffness of the contact.")
    damping_ratio: float | None = declare(
        RATIO, None, meaning="Damping ratio of the contact, relative to critical damping of the reduced mass."
    )
    damping: float = declare(  # computed if a ratio is given
        Number("damping", low=0.0), None, meaning="Damping of the contact, which acts only while the surfaces separate."
    )
    diameter: float | None = declare(
        Number("length", above=0.0),
        None,
        meaning="Diameter of the rotor at the contact, for Coulomb friction by slip (without it: forward sliding only).",
    )
    ring_eccentricity: Polar = declare(  # noqa: RUF009 (it is a field)
        PolarReader("length"), NO_ECCENTRICITY, meaning="Eccentricity of the contact ring from the shaft axis, and its angle."
    )
    offset: complex = declare(
        PairReader("length"), 0j, meaning="Offset of the stator's centre at rest from the bearing centre; less than the gap."
    )
    slip_velocity: float | None = declare(
        Number("velocity", above=0.0),
        None,
        meaning="Slip velocity of full friction, needs diameter; default: 1/1000 of the highest surface velocity.",
    )

    race_inertia: float | None = declare(
        Number("inertia", above=0.0), None, meaning="Polar inertia of an inner race that rotates in the stator, needs diameter."
    )
    race_drag: float | None = declare(
        Number("tilt damping", low=0.0), None, meaning="Drag torque of the race per angular velocity; default: none."
    )
    yield_force: float | None = declare(
        Number("force", above=0.0),
        None,
        meaning="Normal force at which the contact deforms permanently; a motion with more is reported as beyond the model.",
    )

    one_of = (
        (("damping_ratio", "damping"), ("damping", 0.0)),
        (("gap", "stator_diameter"), None),
        (("rotor_coordinate", "rotor_node", "at"), ("rotor_coordinate", 0)),
        (("stator_coordinate", "stator_node", "stator_at"), ("stator_coordinate", 0)),
    )

    @property
    def rotor_coordinates(self) -> tuple[int, ...]:
        """The rotor coordinate in contact, or the two in contact with each other."""
        return self.rotor_coordinate if isinstance(self.rotor_coordinate, tuple) else (self.rotor_coordinate,)

    @property
    def in_rotor(self) -> bool:
        """Whether the contact is between two locations of the rotor."""
        return isinstance(self.rotor_coordinate, tuple)

    def of_rotor(self, moved: Any) -> Any:
        """Contact displacement of the rotor from its coordinates (..., n): one of them, or the first minus the second."""
        first, *against = self.rotor_coordinates
        return moved[..., first] - moved[..., against[0]] if against else moved[..., first]

    def to_dict(self) -> dict[str, Any]:
        """Plain content of the table."""
        content = plain_section(self)
        if self.stator_diameter is not None:
            del content["gap"]  # it follows from the diameters
        if self.damping_ratio is not None:
            del content["damping"]  # it follows from the ratio
        if not self.offset:
            del content["offset"]  # so that versions without this key read such scenes
        return content


def read_contacts(tables: Sequence[RawTable], elsewhere: Any, rotor: Any, stator: Any, drive: Any) -> tuple[Contact, ...]:
    """Read all [[contact]] tables; several must have unique names."""
    contacts = tuple(_read_contact(table, elsewhere, rotor, stator, drive) for table in tables)
    seen: dict[str | None, RawTable] = {}
    for table, contact in zip(tables, contacts, strict=True):
        if contact.name is None and len(contacts) > 1:
            table.refuse("name", None, "given: with several contacts each needs a name")
        if seen.setdefault(contact.name, table) is not table:
            table.refuse("name", contact.name, "different from that of " + seen[contact.name].name)
    if stator.n_coordinates and all(contact.in_rotor for contact in contacts):
        places = list(contacts[0].rotor_coordinates)
        tables[0].refuse("rotor_coordinate", places, "one coordinate", "the stator is not involved: leave [stator] out")
    return contacts


def _read_contact(table: RawTable, elsewhere: Any, rotor: Any, stator: Any, drive: Any) -> Contact:
    """Read one contact: computes damping from a ratio and checks coordinates and time scale against the bodies."""
    values = read_table(Contact, table, elsewhere)
    for name in ("rotor", "stator"):  # in a machine nodes have been replaced by coordinates
        if values[f"{name}_node"] is not None:
            hint = f"the {name} is not a finite-element model: give {name}_coordinate"
            table.refuse(f"{name}_node", values[f"{name}_node"], "left out", hint)
    refuse_stations(table, values)
    if values["stator_diameter"] is not None:
        values["gap"] = _gap_of_diameters(table, values)
    mass = _contact_mass(values, table, rotor, stator)
    stiffness = values["stiffness"]
    period = 2.0 * math.pi * math.sqrt(mass / stiffness)
    if period < MIN_CONTACT_PERIOD:
        wanted = f"such that the contact period exceeds {MIN_CONTACT_PERIOD:g} s"
        table.refuse("stiffness", stiffness, wanted, f"the reduced mass is {mass:.3g} kg")
    ratio = values["damping_ratio"]
    if ratio is not None:
        if ratio < 0.0:
            table.refuse("damping_ratio", ratio, ">= 0")
        values["damping"] = 2.0 * ratio * math.sqrt(stiffness * mass)
    if values["diameter"] is None:
        if values["slip_velocity"] is not None:
            table.refuse("slip_velocity", values["slip_velocity"], "left out", "it needs contact.diameter")
    elif values["slip_velocity"] is None:
        fastest = 2.0 * math.pi * drive.fastest
        slip = 1e-3 * fastest * values["diameter"] / 2.0
        values["slip_velocity"] = slip
        if slip < SMALLEST:
            table.refuse("slip_velocity", None, "given when the rotor stands still", "a velocity > 0 m/s")
    _read_race(table, values)
    if abs(values["offset"]) >= values["gap"]:
        wanted = f"shorter than the gap, {values['gap']:g} m"
        table.refuse("offset", plain(values["offset"]), wanted, "the centred rotor would be inside the wall")
    return values.made(Contact)


def _read_race(table: RawTable, values: Any) -> None:
    """Check that a race has a diameter, and race drag a race."""
    if values["race_inertia"] is not None:
        if values["diameter"] is None:
            table.refuse("race_inertia", values["race_inertia"], "left out", "friction drives it only with contact.diameter")
        values["race_drag"] = values["race_drag"] or 0.0
    elif values["race_drag"] is not None:
        table.refuse("race_drag", values["race_drag"], "left out", "it needs contact.race_inertia")


def _gap_of_diameters(table: RawTable, values: Any) -> float:
    """Radial gap from two diameters; that of the stator must be larger by at least a millionth."""
    inner, outer = values["diameter"], values["stator_diameter"]
    if inner is None:
        table.refuse("stator_diameter", outer, "left out", "without diameter it does not determine the gap")
    gap = 0.5 * (outer - inner)
    if not gap > 5e-7 * outer:
        table.refuse("stator_diameter", outer, f"larger than diameter = {inner:g} m")
    return gap


def _contact_mass(values: Any, table: RawTable, rotor: Any, stator: Any) -> float:
    """Reduced mass in kg of the two contacting coordinates (from diagonal entries)."""
    masses, read = [], []
    places: Any = as_list(values["rotor_coordinate"])
    several = places is not None
    if several and len(places) != 2:
        table.refuse("rotor_coordinate", values["rotor_coordinate"], ROTOR_PLACE.wanted)
    touching = [("rotor_coordinate", i, rotor) for i in (places if several else [values["rotor_coordinate"]])]
    touched = [] if several else [("stator_coordinate", values["stator_coordinate"], stator)]
    for key, i, body in (*touching, *touched):
        i = _COORDINATE.read(table, key, i)
        read.append(i)
        most = max(body.n_coordinates, 1) if body.model != "reduced" else body.n_touching
        if i >= most:
            table.refuse(key, i, f"a whole number from 0 to {most - 1}")
        if i in body.tilts:
            table.refuse(key, i, "a displacement", f"coordinate {i} is a tilt")
        if body.n_coordinates:
            masses.append(body.mass_at(i))
    if several:
        if rotor.model == "reduced":
            wanted = "left out"
            table.refuse("rotor_coordinate", places, wanted, "for a machine give rotor.contact = {node = ..., against = ...}")
        if places[0] == places[1]:
            table.refuse("rotor_coordinate", places, "two coordinates")
        values["rotor_coordinate"] = tuple(read)
    else:
        values["rotor_coordinate"], values["stator_coordinate"] = read
    return 1.0 / sum(1.0 / mass for mass in masses)


def touches_itself(mapping: Mapping[str, Any]) -> bool:
    """Whether all contacts are within the rotor, so that there is no stator."""
    rotor, contact = mapping.get("rotor"), as_list(mapping.get("contact")) or [mapping.get("contact")]
    if isinstance(rotor, Mapping) and isinstance(rotor.get("contact"), Mapping):
        return True
    return all(
        isinstance(table, Mapping)
        and (as_list(table.get("rotor_coordinate")) is not None or isinstance(table.get("rotor_node"), Mapping))
        for table in contact
    )


def contact_tables(content: list[Any], file: str, folder: Path | None) -> list[RawTable]:
    """The [[contact]] tables, named for messages."""
    if not 0 < len(content) <= MAX_CONTACTS:
        raise SceneError(file, "contact", f"{len(content)} tables", f"one to {MAX_CONTACTS} tables [[contact]]")
    for i, values in enumerate(content):
        if not isinstance(values, Mapping):
            raise SceneError(file, f"contact[{i}]", shown(values), "a table [[contact]]")
    if len(content) == 1:
        return [RawTable(file, "contact", content[0], folder)]
    names = [values.get("name") for values in content]
    unique = [isinstance(name, str) and bool(re.fullmatch(Name.pattern, name)) and names.count(name) == 1 for name in names]
    heads = [f"contact.{name}" if good else f"contact[{i}]" for i, (name, good) in enumerate(zip(names, unique, strict=True))]
    return [RawTable(file, *parts, folder) for parts in zip(heads, content, strict=True)]
