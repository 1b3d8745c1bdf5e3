"""A scene: everything one run needs, validated, with every default written out.

Scenes are created only by `load_scene` and `Scene.from_dict`; every scene that these return can be assembled.
"""

import contextlib
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from html import escape
from pathlib import Path
from typing import Any

from rsc.arguments import NAMED, PATH, TEXT, takes
from rsc.errors import SceneError, nearest, one_line, shown
from rsc.presented import Brief, drawing
from rsc.scene.bodies import models
from rsc.scene.bodies.body_model import BodyModel, RotorModel
from rsc.scene.bodies.machine_file import Machine, machine_of_file
from rsc.scene.bodies.machines import is_machine, only_or_all, places_of, read_reduction, reduced, with_coordinates
from rsc.scene.bodies.reduced import ReducedRotor, Reduction
from rsc.scene.bodies.shafts import Stations
from rsc.scene.bodies.states import MagneticBearing, States
from rsc.scene.bodies.stations import with_nodes
from rsc.scene.files.toml_file import tables_of, text_of
from rsc.scene.files.toml_text import toml_text
from rsc.scene.keys.keys import RawTable, as_list, known_keys, plain_section, read_table
from rsc.scene.keys.mirror import mirrored_table
from rsc.scene.names import EVERY, POLAR, polar_readers, whole_keys
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
from rsc.system.system import only_one

MAX_TITLE = 1000
HINT = "`rsc new laval` prints one"
MIRRORED = "turns backward: shown in the mirror image, z reversed"
_TABLES = ("rotor", "stator", "contact", "drive", "start", "solver", "output")
_OPTIONAL = ("start", "solver", "output", "reduction")
_SECTIONS: dict[str, type] = {
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
_INSIDE: dict[str, type] = {"states": States, "magnetic_bearings": MagneticBearing}  # tables inside [rotor] and [stator]


@dataclass(frozen=True, kw_only=True, repr=False)
class Scene(Brief):
    """One validated scene, in SI with frequencies and speeds in Hz.

    title : str
    rotor, stator : one of `ROTORS` and one of `STATORS` of `rsc.scene.bodies.models`
    contacts : tuple of rsc.scene.tables.contacts.Contact, at least one
    drive, start, solver, output : see `rsc.scene.tables.sections`
    clearances : tuple of rsc.scene.tables.clearances.Clearance, monitored locations
    limits : None or rsc.scene.tables.limits.Limits, limits for the unbalance response
    report : None or rsc.scene.tables.display.Display, units in which numbers are shown
    source : str, file name and changed values, for messages; ignored in comparisons
    reductions : tuple of rsc.machine.reduction.reduction.Reduced, of bodies read from finite-element models, rotor first; empty
        for a scene from a result or from `to_dict`; ignored in comparisons
    """

    title: str
    rotor: RotorModel
    stator: BodyModel
    contacts: tuple[Contact, ...]
    drive: Drive
    start: Start
    solver: sections.Solver
    output: sections.Output
    clearances: tuple[Clearance, ...] = ()
    limits: Limits | None = None
    report: Display | None = None
    source: str = field(default="<scene>", compare=False)
    reductions: tuple[Any, ...] = field(default=(), compare=False, repr=False)

    @property
    def contact(self) -> Contact:
        """The only contact; SolverError if there are several."""
        only: Contact = only_one(self.contacts)
        return only

    @property
    def tables(self) -> dict[str, dict[str, Any]]:
        """Plain content of every table, by the names used for values: "rotor", "contact" (with several contacts "contact.NAME"),
        and so on."""
        return _all_named(self.to_dict())

    @property
    def table_names(self) -> list[str]:
        """Names of `tables`."""
        contacts = [f"contact.{contact.name}" for contact in self.contacts] if len(self.contacts) > 1 else ["contact"]
        names = [name for key in _TABLES for name in (contacts if key == "contact" else [key])]
        names += [name for body in ("rotor", "stator") for name in _inside(body, getattr(self, body))]
        names += [f"{CLEARANCE}.{clearance.name}" for clearance in self.clearances]
        return names + [key for key in (LIMITS, REPORT) if getattr(self, key) is not None]

    @classmethod
    def from_dict(cls, mapping: Mapping[str, Any], source: str = "<scene>") -> "Scene":
        """Validate a scene given as nested mappings.

        Parameters
        ----------
        mapping : Mapping
            The structure of a scene file. Names of matrix files are relative to the current folder.
        source : str
            Name used in messages.

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            One line with file, key, value, allowed range and a hint.
        """
        return _read_scene(mapping, one_line(source), Path())

    @classmethod
    @takes(text=TEXT)
    def from_toml(cls, text: str, source: str = "<scene>") -> "Scene":
        """Validate a scene given as TOML text; arguments and errors as `from_dict`."""
        return _read_scene(tables_of(text, one_line(source)), one_line(source), Path())

    @classmethod
    def from_stored(cls, text: str, source: str) -> "Scene":
        """The scene of a result: it may name a method of older versions, but no files, since whoever opens a result did not
        choose which files are read. Arguments and errors as `from_toml`."""
        source = one_line(source)
        content = tables_of(text, source)
        solver = content.get("solver", {})
        method = solver.get("method") if isinstance(solver, Mapping) else None
        if not isinstance(method, str) or method not in sections.RETIRED_METHODS:
            return _read_scene(content, source, None)
        readable = {**solver, "method": sections.RETIRED_METHODS[method]}
        scene = _read_scene({**content, "solver": readable}, source, None)
        return replace(scene, solver=replace(scene.solver, method=method))

    def to_dict(self) -> dict[str, Any]:
        """Return the resolved scene as plain numbers, texts and lists (matrices inline).

        `Scene.from_dict(scene.to_dict()) == scene`, bit for bit.
        """
        content: dict[str, Any] = {"title": self.title}
        for name in _TABLES:
            if name == "contact":
                contacts = [contact.to_dict() for contact in self.contacts]
                content[name] = contacts if len(contacts) > 1 else contacts[0]
                continue
            section = getattr(self, name)
            keys = section.to_dict() if hasattr(section, "to_dict") else plain_section(section)
            content[name] = {"model": section.model, **keys} if hasattr(section, "model") else keys
        if self.clearances:
            content[CLEARANCE] = [clearance.to_dict() for clearance in self.clearances]
        content |= {key: getattr(self, key).to_dict() for key in (LIMITS, REPORT) if getattr(self, key) is not None}
        return content

    def plot(self, ax: Any = None, **style: Any) -> Any:
        """Draw the rotor to scale in each direction, with disks, bearings, contacts and clearances.

        ax : matplotlib axes, by default those of a new figure; style : properties of lines of matplotlib. Returns the axes;
        SceneError unless the rotor was given by its stations (model "shaft").
        """
        return drawing().machine(self, ax, style)

    def _repr_html_(self) -> str:
        title = escape(one_line(self.title) or "scene")
        return f"<details><summary>{title}</summary><pre>{escape(self.to_toml())}</pre></details>"

    def to_toml(self) -> str:
        """Return the resolved scene as the text of a scene file; it loads as the same scene, bit for bit."""
        return toml_text(self.to_dict(), listed=(CLEARANCE,))

    @takes(values=NAMED)
    def with_values(self, values: Mapping[str, Any]) -> "Scene":
        """Return a validated scene with some keys changed; messages about it mention the changes.

        Parameters
        ----------
        values : Mapping
            Dotted key to new value, for example ``{"contact.friction": 0.1, "rotor.frequency": "40 Hz"}``. With several contacts
            use a name, ``"contact.seal.friction"``, or all, ``"contact.*.friction"``. ``"rotor.eccentricity.angle"`` and
            ``"rotor.eccentricity.amount"`` rotate and scale all eccentricities of the rotor, see `rsc.scene.names`. A key
            replaces those that it excludes (a new damping_ratio replaces damping).

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            Unknown key or impossible value.
        """
        content = self.to_dict()
        tables = _all_named(content)
        changes = {}
        for dotted, value in whole_keys(self, values).items():
            if dotted == "title":
                content["title"] = value
                continue
            name, _, key = str(dotted).rpartition(".")
            changes[self.table_name(name if key else "", dotted, value), key] = value
        for (name, key), value in changes.items():
            for group, _ in getattr(self.section(name), "one_of", ()):
                for other in [other for other in group if key in group and (name, other) not in changes]:
                    tables[name].pop(other, None)
            tables[name][key] = value
        changed, source = _read_scene(content, self.source, Path()), self.source
        for key, value in values.items():
            source += f"{',' if ' with ' in source else ' with'} {key} = {shown(value)}"
        return replace(changed, source=one_line(source))

    def steady(self, speed: float, duration: float = 1.0) -> "Scene":
        """The scene with a constant prescribed speed in Hz for a duration in s, whatever its drive, and without bearings that are
        switched off during its run.

        Raises
        ------
        SceneError
            An invalid speed.
        """
        drive = self.drive
        without = self if drive.inertia is None else replace(self, drive=Drive.along(drive.time, drive.speed))
        if self.rotor.off_times:
            without = replace(without, rotor=self.rotor.at_end, start=self.start.with_states(self.rotor.state_numbers(math.inf)))
        return without.with_values({"drive.speed": speed, "drive.duration": duration})

    def section(self, table: str) -> type:
        """The class that declares the keys of one of `tables`."""
        outer, _, inner = table.partition(".")
        own = _SECTIONS.get(outer) or _INSIDE.get(inner.partition("[")[0])
        return own or type(getattr(self, table))

    def table_name(self, name: str, dotted: object, value: object = None) -> str:
        """The name of one of `tables`; a single contact may also be referred to by its own name.

        Raises
        ------
        SceneError
            There is no such table; the message is about the key `dotted`.
        """
        known = self.table_names + (["contact." + (self.contacts[0].name or "")] if len(self.contacts) == 1 else [])
        if name in known:
            return "contact" if len(self.contacts) == 1 and name.startswith("contact.") else name
        kind = name.partition(".")[0]
        if kind == "contact" or (kind == CLEARANCE and self.clearances):
            wanted = "a key of " + " or ".join(dict.fromkeys(each.rstrip(".") for each in known if each.startswith(kind)))
            several = kind == "contact" and len(self.contacts) > 1
            hint = f"{EVERY} means every contact" if several else nearest(dotted, all_names())
            raise SceneError(self.source, one_line(dotted), shown(value), wanted, hint)
        raise SceneError(self.source, one_line(dotted), shown(value), "a key of a scene", nearest(dotted, all_names()))

    def mirrored(self) -> "Scene":
        """The same machine in the mirror image z -> -z, with the rotor turning the other way: every number of its runs and
        predictions is conjugated or changes sign."""
        content = self.to_dict()
        for key in _TABLES:
            images = {name: mirrored_table(self.section(name), table) for name, table in _named(key, content[key]).items()}
            content[key] = list(images.values()) if len(images) > 1 else images[key]  # other tables are unchanged
        return replace(_read_scene(content, self.source, Path()), reductions=self.reductions)

    def turning_forward(self) -> "Scene":
        """This scene, or if its rotor turns backward its mirror image, whose title says so: texts assume a rotor that turns
        forward.

        Raises
        ------
        SceneError
            The rotor turns in both directions.
        """
        slowest, fastest = min(self.drive.speed), max(self.drive.speed)
        if slowest >= 0.0:
            return self
        if fastest > 0.0:
            hint = "predictions need one sense of rotation: use one run for each"
            raise SceneError(self.source, "drive.speed", list(self.drive.speed), "of one sign, or 0", hint)
        title = f"{self.title} ({MIRRORED})" if self.title else MIRRORED
        return replace(self.mirrored(), title=title[:MAX_TITLE])


def _named(key: str, content: Any) -> dict[str, dict[str, Any]]:
    """The tables of one top-level key by name, see `Scene.tables`."""
    return {f"{key}.{table['name']}": table for table in content} if isinstance(content, list) else {key: content}


def _all_named(content: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """All tables of a scene's content by name, see `Scene.tables`."""
    named = {name: table for key in content if key != "title" for name, table in _named(key, content[key]).items()}
    for body in ("rotor", "stator"):
        inner = [named[body].get("states"), *(table for _, table in named[body].get("magnetic_bearings", ()))]
        named |= dict(zip(_inside(body, named[body]), filter(None, inner), strict=True))
    return named


def _inside(body: str, own: Any) -> list[str]:
    """Names of the tables inside a body, a model or its plain content: "rotor.states", "rotor.magnetic_bearings[0]"."""
    states, bearings = (
        own.get(key) if isinstance(own, Mapping) else getattr(own, key) for key in ("states", "magnetic_bearings")
    )
    return [f"{body}.states"] * (states is not None) + [f"{body}.magnetic_bearings[{i}]" for i in range(len(bearings or ()))]


def _key_classes() -> dict[str, tuple[type, ...]]:
    """Table -> the classes that declare its keys."""
    bodies = {"rotor": tuple(models.ROTORS.values()), "stator": tuple(models.STATORS.values())}
    return bodies | {name: (section,) for name, section in _SECTIONS.items()}


def all_keys() -> list[str]:
    """All dotted keys that any scene can have, without duplicates."""
    keys = ["title"]
    for table, classes in _key_classes().items():
        keys += [f"{table}.{key}" for item in classes for key in known_keys(item)]
    return list(dict.fromkeys(keys))


def all_names() -> list[str]:
    """All dotted keys, then the names of amounts and angles, without duplicates."""
    names = all_keys()
    for key, section in _INSIDE.items():
        numbered = f"{key}[0]" if section is MagneticBearing else key
        names += [f"{body}.{numbered}.{name}" for body in ("rotor", "stator") for name in known_keys(section)]
    for table, classes in _key_classes().items():
        keys = [key for item in classes for key in known_keys(item) if polar_readers(item, key)]
        names += [f"{table}.{key}.{word}" for key in keys for word in POLAR]
    return list(dict.fromkeys(names))


@takes(path=PATH)
def load_scene(path: str | os.PathLike[str]) -> Scene:
    """Read and validate a scene file.

    Parameters
    ----------
    path : str or os.PathLike
        A TOML file in UTF-8 (a byte order mark and any line ends are accepted) of at most 1 MB.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        Unreadable file, invalid TOML, or an invalid scene; one line.
    """
    path = Path(path)
    return _read_scene(tables_of(text_of(path, "a scene", HINT), one_line(path)), one_line(path), path.parent)


def _read_scene(mapping: Mapping[str, Any], file: str, folder: Path | None) -> Scene:
    """Validate nested mappings; folder: base of relative file names, None if files are not allowed."""
    if not isinstance(mapping, Mapping):
        raise SceneError(file, "scene", shown(mapping), "a mapping with the tables " + ", ".join(_TABLES))
    for key in mapping:
        if key not in (*_TABLES, "title", "reduction", CLEARANCE, LIMITS, REPORT):
            hint = _elsewhere(None, None)(key) or nearest(key, ("title", *_TABLES, CLEARANCE, LIMITS, REPORT))
            raise SceneError(file, one_line(key), shown(mapping[key]), "a table of a scene", hint)
    tables = {name: _table(mapping, name, file, folder) for name in _TABLES if name != "contact"}
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
    return Scene(
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
    if rotor.off_times:
        hint = "give drive.speed or drive.schedule instead of a torque"
        key = "bearings" if isinstance(rotor, ReducedRotor) else "magnetic_bearings"
        table.refuse(key, f"off = {rotor.off_times[0]:g}", "without off where a torque drives the rotor", hint)


def _refuse_coarse_time(table: RawTable, drive: Drive, contact: Contact, rotor: RotorModel) -> None:
    """SceneError if the resolution of time at the end of a very long run is not fine compared with a contact."""
    period = 2.0 * math.pi * math.sqrt(rotor.mass_at(contact.rotor_coordinates[0]) / contact.stiffness)
    tick = math.ulp(drive.duration)
    if tick > 0.01 * period:
        key = "duration" if "duration" in table.values else "schedule"
        wanted = f"shorter: at its end time resolves {tick:.2g} s, the contact period is {period:.2g} s"
        table.refuse(key, drive.duration, wanted)
