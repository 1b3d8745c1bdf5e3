"""A scene: everything one run needs, validated, with every default written out.

Scenes are created only by `load_scene` and `Scene.from_dict`; every scene that these return can be assembled.
"""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from html import escape
from pathlib import Path
from typing import Any

from rsc.arguments import NAMED, PATH, TEXT, takes
from rsc.errors import SceneError, nearest, one_line, shown
from rsc.presented import Brief, drawing
from rsc.scene.bodies.body_model import BodyModel, RotorModel
from rsc.scene.files.toml_file import tables_of, text_of
from rsc.scene.files.toml_text import toml_text
from rsc.scene.keys.mirror import mirrored_table
from rsc.scene.keys.readers import plain_section
from rsc.scene.names import EVERY, whole_keys
from rsc.scene.reading import INSIDE, MAX_TITLE, SECTIONS, TABLES, all_names, scene_fields
from rsc.scene.tables import sections
from rsc.scene.tables.clearances import KEY as CLEARANCE
from rsc.scene.tables.clearances import Clearance
from rsc.scene.tables.contacts import Contact
from rsc.scene.tables.display import KEY as REPORT
from rsc.scene.tables.display import Display
from rsc.scene.tables.drive import Drive
from rsc.scene.tables.limits import KEY as LIMITS
from rsc.scene.tables.limits import Limits
from rsc.scene.tables.start import Start
from rsc.system.system import only_one

HINT = "`rsc new laval` prints one"
MIRRORED = "turns backward: shown in the mirror image, y reversed"


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
        names = [name for key in TABLES for name in (contacts if key == "contact" else [key])]
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
        for name in TABLES:
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
            if name in (LIMITS, REPORT):  # a scene need not have them
                tables[name] = content.setdefault(name, {})
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
        if self.rotor.switched_at:
            without = replace(without, rotor=self.rotor.at_end, start=self.start.with_states(self.rotor.state_numbers(math.inf)))
        return without.with_values({"drive.speed": speed, "drive.duration": duration})

    def section(self, table: str) -> type:
        """The class that declares the keys of one of `tables`."""
        outer, _, inner = table.partition(".")
        own = SECTIONS.get(outer) or INSIDE.get(inner.partition("[")[0])
        return own or type(getattr(self, table))

    def table_name(self, name: str, dotted: object, value: object = None) -> str:
        """The name of one of `tables`; a single contact may also be referred to by its own name.

        Raises
        ------
        SceneError
            There is no such table; the message is about the key `dotted`.
        """
        known = [*self.table_names, LIMITS, REPORT, *(f"contact.{contact.name or ''}" for contact in self.contacts[:1])]
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
        """The same machine in the mirror image y -> -y: seen from the other end of its shaft, the rotor turning the other way.

        In its runs and predictions every y, speed and frequency changes its sign; gravity still acts along -z.
        """
        content = self.to_dict()
        for key in TABLES:
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
        inner = [named[body].get("states"), *(item[-1] for item in named[body].get("magnetic_bearings", ()))]
        named |= dict(zip(_inside(body, named[body]), filter(None, inner), strict=True))
    return named


def _inside(body: str, own: Any) -> list[str]:
    """Names of the tables inside a body, a model or its plain content: "rotor.states", "rotor.magnetic_bearings[0]"."""
    states, bearings = (
        own.get(key) if isinstance(own, Mapping) else getattr(own, key) for key in ("states", "magnetic_bearings")
    )
    return [f"{body}.states"] * (states is not None) + [f"{body}.magnetic_bearings[{i}]" for i in range(len(bearings or ()))]


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

    Examples
    --------
    >>> scene = rsc.load_scene("laval.toml")
    >>> scene.contacts[0].gap
    0.001
    """
    path = Path(path)
    return _read_scene(tables_of(text_of(path, "a scene", HINT), one_line(path)), one_line(path), path.parent)


def _read_scene(mapping: Mapping[str, Any], file: str, folder: Path | None) -> Scene:
    """The Scene of nested mappings, see `scene_fields`."""
    return Scene(**scene_fields(mapping, file, folder))
