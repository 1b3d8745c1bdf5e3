"""Reading the tables of a scene: what is given, what depends on other tables, what does not go together."""

import contextlib
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rsc.errors import SceneError, nearest, one_line, shown
from rsc.scene.bodies import models
from rsc.scene.bodies.body_model import RotorModel
from rsc.scene.bodies.machine_file import Machine, machine_of_file
from rsc.scene.bodies.machines import is_machine, only_or_all, places_of, read_reduction, reduced, with_coordinates
from rsc.scene.bodies.reduced import ReducedRotor, Reduction
from rsc.scene.bodies.shafts import Stations
from rsc.scene.bodies.states import MagneticBearing, States
from rsc.scene.bodies.stations import with_nodes
from rsc.scene.keys.keys import RawTable, known_keys, read_table
from rsc.scene.keys.readers import as_list
from rsc.scene.names import POLAR, polar_readers
from rsc.scene.tables import sections
from rsc.scene.tables.clearances import KEY as CLEARANCE
from rsc.scene.tables.clearances import Clearance, clearance_tables, nodes_of, read_clearances
from rsc.scene.tables.contacts import Contact, contact_tables, read_contacts, touches_itself
from rsc.scene.tables.display import KEY as REPORT
from rsc.scene.tables.display import Display
from rsc.scene.tables.drive import Drive, read_drive
from rsc.scene.tables.limits import KEY as LIMITS
from rsc.scene.tables.limits import Limits, read_limits
from rsc.scene.tables.start import Start, read_start

MAX_TITLE = 1000
TABLES = ("rotor", "stator", "contact", "drive", "start", "solver", "output")
_OPTIONAL = ("start", "solver", "output", "reduction")
SECTIONS: dict[str, type] = {
    "contact": Contact,
    "drive": Drive,
    "start": Start,
    "solver": sections.Solver,
    "output": sections.Output,
    "reduction": Reduction,
    CLEARANCE: Clearance,
    LIMITS: Limits,
    REPORT: Display,
}
INSIDE: dict[str, type] = {"states": States, "magnetic_bearings": MagneticBearing}  # tables inside [rotor] and [stator]


def _key_classes() -> dict[str, tuple[type, ...]]:
    """Table -> the classes that declare its keys."""
    bodies = {"rotor": tuple(models.ROTORS.values()), "stator": tuple(models.STATORS.values())}
    return bodies | {name: (section,) for name, section in SECTIONS.items()}


def all_keys() -> list[str]:
    """All dotted keys that any scene can have, without duplicates."""
    keys = ["title"]
    for table, classes in _key_classes().items():
        keys += [f"{table}.{key}" for item in classes for key in known_keys(item)]
    return list(dict.fromkeys(keys))


def all_names() -> list[str]:
    """All dotted keys, then the names of amounts and angles, without duplicates."""
    names = all_keys()
    for key, section in INSIDE.items():
        numbered = f"{key}[0]" if section is MagneticBearing else key
        names += [f"{body}.{numbered}.{name}" for body in ("rotor", "stator") for name in known_keys(section)]
    for table, classes in _key_classes().items():
        keys = [key for item in classes for key in known_keys(item) if polar_readers(item, key)]
        names += [f"{table}.{key}.{word}" for key in keys for word in POLAR]
    return list(dict.fromkeys(names))


def scene_fields(mapping: Mapping[str, Any], file: str, folder: Path | None) -> dict[str, Any]:
    """The validated fields of a Scene from nested mappings; folder: base of relative file names, None if no files are allowed."""
    if not isinstance(mapping, Mapping):
        raise SceneError(file, "scene", shown(mapping), "a mapping with the tables " + ", ".join(TABLES))
    for key in mapping:
        if key not in (*TABLES, "title", "reduction", CLEARANCE, LIMITS, REPORT):
            hint = _elsewhere(None, None)(key) or nearest(key, ("title", *TABLES, CLEARANCE, LIMITS, REPORT))
            raise SceneError(file, one_line(key), shown(mapping[key]), "a table of a scene", hint)
    tables = {name: _table(mapping, name, file, folder) for name in TABLES if name != "contact"}
    drive = read_drive(tables["drive"], _elsewhere("drive"))
    tables["rotor"].fastest, tables["rotor"].duration = drive.fastest, drive.duration
    clearances = clearance_tables(mapping, file, folder)
    several = as_list(mapping.get("contact"))
    touching = [_table(mapping, "contact", file, folder)] if several is None else contact_tables(several, file, folder)
    tables, touching, clearances, reductions = _reduced_tables(mapping, tables, touching, drive, clearances)
    rotor = models.read_body(models.ROTORS, tables["rotor"], _elsewhere("rotor", models.ROTORS))
    stator = models.read_body(models.STATORS, tables["stator"], _elsewhere("stator", models.STATORS))
    contacts = read_contacts(touching, _elsewhere("contact"), rotor, stator, drive)
    watched = read_clearances(clearances, _elsewhere(CLEARANCE), rotor, stator)
    for contact in contacts:
        _refuse_coarse_time(tables["drive"], drive, contact, rotor)
    if drive.inertia is not None:
        _refuse_free_slip(tables["drive"], contacts)
        _refuse_off(tables["rotor"], rotor)
    _refuse_other_speeds(tables["drive"], drive, rotor)
    return dict(
        title=_read_title(mapping.get("title", ""), file),
        rotor=rotor,
        stator=stator,
        contacts=contacts,
        drive=drive,
        start=read_start(tables["start"], _elsewhere("start"), rotor, stator, contacts),
        solver=sections.read_solver(tables["solver"], _elsewhere("solver")),
        output=sections.read_output(tables["output"], _elsewhere("output"), drive),
        clearances=watched,
        limits=read_limits(_table(mapping, LIMITS, file, folder), _elsewhere(LIMITS), watched) if LIMITS in mapping else None,
        report=_read_display(mapping, file, folder),
        source=file,
        reductions=reductions,
    )


def _read_display(mapping: Mapping[str, Any], file: str, folder: Path | None) -> Display | None:
    """[report], if it is given."""
    if REPORT not in mapping:
        return None
    return Display(**read_table(Display, _table(mapping, REPORT, file, folder), _elsewhere(REPORT)))


def _reduced_tables(
    mapping: Mapping[str, Any],
    tables: dict[str, RawTable],
    touching: list[RawTable],
    drive: Drive,
    clearances: list[RawTable],
) -> tuple[dict[str, RawTable], list[RawTable], list[RawTable], tuple[Any, ...]]:
    """Replace machines by reduced bodies, nodes of contacts by coordinates, and positions of clearances by nodes; returns tables,
    contacts, clearances and reductions."""
    rotor, reductions = tables["rotor"], []
    table = _table(mapping, "reduction", rotor.file, rotor.folder)
    machines = [name for name in ("rotor", "stator") if is_machine(tables[name])]
    if not machines:
        if table.values:
            table.refuse("tolerance", table.values.get("tolerance"), "left out", "no body has model \"machine\" or \"shaft\"")
        return tables, touching, clearances, ()
    reduction = (*read_reduction(table, _elsewhere("reduction"), drive.fastest), drive.covered)
    for name in machines:
        touching, clearances, machine = _machine_of(tables[name], touching, clearances, max(map(abs, reduction[1])))
        places = places_of(tables[name], touching)
        if any(isinstance(place, Mapping) for place in places) and tables["stator"].values.get("model") != "rigid":
            rotor.refuse("contact", only_or_all(places), "a node", "for contact between two nodes leave [stator] out")
        made, result = reduced(tables[name], machine, reduction, places)
        tables, touching = {**tables, name: made}, with_coordinates(touching, name, places)
        reductions.append(result)
    return tables, touching, clearances, tuple(reductions)


def _machine_of(
    body: RawTable, touching: list[RawTable], clearances: list[RawTable], top: float
) -> tuple[list[RawTable], list[RawTable], Machine]:
    """(contacts, clearances, machine) with positions along a shaft replaced by nodes; top: highest frequency, Hz."""
    if body.values["model"] == "machine":
        return touching, clearances, machine_of_file(body, _elsewhere(body.name), nodes_of(clearances, body.name))
    stations = Stations(body, _elsewhere(body.name))
    touching, clearances = (with_nodes(listed, body.name, stations) for listed in (touching, clearances))
    return touching, clearances, stations.machine(top, nodes_of(clearances, body.name))


def _refuse_other_speeds(table: RawTable, drive: Drive, rotor: RotorModel) -> None:
    """SceneError for speeds outside the range for which the rotor was reduced."""
    if isinstance(rotor, ReducedRotor):
        low, high = rotor.speeds
        top = max(drive.speed) if drive.inertia is None else drive.fastest
        if min(drive.speed) < low or top > high:
            key = "speed" if "speed" in table.values else "schedule"
            hint = "read the scene file with these speeds, so that it is reduced for them"
            table.refuse(key, list(drive.speed), f"within {low:g} to {high:g} Hz, for which the rotor was reduced", hint)


def _table(mapping: Mapping[str, Any], name: str, file: str, folder: Path | None) -> RawTable:
    if name not in mapping:
        if name == "stator" and touches_itself(mapping):
            return RawTable(file, name, {"model": "rigid"}, folder)
        if name not in _OPTIONAL:
            hint = "model = \"rigid\" for a rigid wall" if name == "stator" else ""
            raise SceneError(file, name, None, f"given as a table [{name}]", hint)
        return RawTable(file, name, {}, folder)
    values = mapping[name]
    if not isinstance(values, Mapping):
        raise SceneError(file, name, shown(values), f"a table [{name}]")
    return RawTable(file, name, values, folder)


def _read_title(raw: object, file: str) -> str:
    if isinstance(raw, str) and len(raw) <= MAX_TITLE:
        with contextlib.suppress(UnicodeEncodeError):  # half of a surrogate pair
            return raw.encode("utf-8").decode("utf-8")
    raise SceneError(file, "title", shown(raw), f"a text of at most {MAX_TITLE} characters")


def _elsewhere(section: str | None, models: Mapping[str, type] | None = None) -> Callable[[str], str]:
    """A function that names the other table or model in which an unknown key would be valid."""

    def where(key: str) -> str:
        tables = [
            name
            for name, classes in _key_classes().items()
            if name != section and any(key in known_keys(item) for item in classes)
        ]
        matching_models = [name for name, item in (models or {}).items() if key in known_keys(item)]
        if matching_models:
            return f"a key of model {' and '.join(matching_models)}"
        return "it belongs to " + " or ".join(f"[{name}]" for name in tables) if tables else ""

    return where


def _refuse_free_slip(table: RawTable, contacts: tuple[Contact, ...]) -> None:
    """SceneError for a torque-limited drive with one-sided friction, which has no contact diameter."""
    if any(contact.diameter is None for contact in contacts):
        table.refuse("torque", None, "left out without contact.diameter", "friction brakes the drive at this diameter")


def _refuse_off(table: RawTable, rotor: RotorModel) -> None:
    """SceneError for bearings that are switched off while a torque drives the rotor."""
    if rotor.switched_at:
        hint = "give drive.speed or drive.schedule instead of a torque"
        key = "bearings" if rotor.off_times else "magnetic_bearings"
        table.refuse(key, f"off = {rotor.switched_at[0]:g}", "without off where a torque drives the rotor", hint)


def _refuse_coarse_time(table: RawTable, drive: Drive, contact: Contact, rotor: RotorModel) -> None:
    """SceneError if the resolution of time at the end of a very long run is not fine compared with a contact."""
    period = 2.0 * math.pi * math.sqrt(rotor.mass_at(contact.rotor_coordinates[0]) / contact.stiffness)
    tick = math.ulp(drive.duration)
    if tick > 0.01 * period:
        key = "duration" if "duration" in table.values else "schedule"
        wanted = f"shorter: at its end time resolves {tick:.2g} s, the contact period is {period:.2g} s"
        table.refuse(key, drive.duration, wanted)
