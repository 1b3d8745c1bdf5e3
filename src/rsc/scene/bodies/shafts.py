"""A shaft by its stations, read: what its tables say becomes a `rsc.machine.shaft.parts.Shaft`, and then a machine."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from rsc.errors import DataError, shown
from rsc.machine.model.contact import Unbalance
from rsc.machine.shaft.parts import SAME_PLACE, Disk, Material, Section, Shaft, Support, disk_inertias
from rsc.scene.bodies.bearing_table import read_bearing_table
from rsc.scene.bodies.machine_file import Machine, amount_at, coefficients_of
from rsc.scene.bodies.shaft_keys import MATERIAL, MATERIALS, PLACE, MaterialKeys, ShaftRotor, ShaftStator, UnbalanceKeys
from rsc.scene.keys.keys import Number, RawTable, as_list, per_coordinate, read_table
from rsc.scene.keys.nested import Item, Tables
from rsc.units import QuantityError, eccentricity_of_grade, quantity

SHAFT = "the shaft of"  # begins the origin of a body that was made of one
_FROM = ("left", "right")


class Stations:
    """A table of a shaft as it was read, which gathers the places that other tables name.

    shaft : Shaft
        With these places.
    """

    def __init__(self, table: RawTable, elsewhere: Any) -> None:
        self.table = table
        self.values = read_table(ShaftRotor if table.name == "rotor" else ShaftStator, table, elsewhere)
        values, material = self.values, _material(table, self.values["material"])
        self.shaft = Shaft(
            sections=tuple(_section(own, material) for own in values["sections"]),
            rotating_damping=values.get("shaft_damping") or 0.0,
            rayleigh=_rayleigh(table, values["rayleigh"]),
            shear=values["shear"],
        )
        self._named = {own.values["name"]: (i, own) for i, own in enumerate(values["sections"]) if own.values["name"] is not None}
        self._known: dict[str, float] = {}
        sleeves = tuple(self._sleeve(own, material) for own in values["sleeves"])
        self.shaft = replace(self.shaft, sleeves=sleeves)
        disks = tuple(_disk(own, self._named_place(own), self.shaft, material) for own in values["disks"])
        supports = tuple(_support(own, self._named_place(own)) for own in values["bearings"])
        self.shaft = replace(self.shaft, disks=disks, supports=supports)
        _refuse_overlap(values["disks"], self.shaft)

    def node(self, table: RawTable, key: str, raw: Any) -> str:
        """The name of the node at a place of a table of contacts, loads and so on; from now on it is one."""
        place = self._place(table, key, raw)
        name = raw if isinstance(raw, str) else f"{place:.6g} m"
        self.shaft.places[name] = place
        return name

    def _sleeve(self, own: Item, material: Material) -> tuple[float, Section]:
        """Where it begins, and the sleeve, whose bore is by default the shaft there."""
        place, table = self._place(own.table, "at", own.values["at"]), own.table
        room = self.shaft.length - place
        if own.values["length"] > room * (1.0 + SAME_PLACE):
            table.refuse("length", table.values["length"], f"at most {room:g} m, where the shaft ends")
        if own.values["bore"] is None:
            right = [one for one in self.shaft.placed if one.start <= place * (1.0 + SAME_PLACE)][-1]
            own.values["bore"] = (right.section.diameter_at(place - right.start),) * 2
        return place, _section(own, material)

    def _named_place(self, own: Item) -> float:
        """The place of a disk or bearing, which has its name from now on."""
        place, name = self._place(own.table, "at", own.values["at"]), own.values["name"]
        if name in self._known:
            own.table.refuse("name", name, "a name that no other disk or bearing has")
        if name is not None:
            self._known[name] = place
        return place

    def _place(self, table: RawTable, key: str, raw: Any) -> float:
        """m from the left end."""
        length = self.shaft.length
        if isinstance(raw, Mapping):
            place = self._from_section(table, key, raw)
        elif isinstance(raw, str) and raw in self._known:
            place = self._known[raw]
        else:
            try:
                place = quantity(raw, "length")
            except QuantityError as error:
                known = ", ".join(self._known)
                table.refuse(key, raw, PLACE.wanted, error.hint or (f"names: {known}" if known else ""))
                raise AssertionError from None
        if not -SAME_PLACE * length <= place <= length * (1.0 + SAME_PLACE):
            table.refuse(key, raw, f"on the shaft, 0 to {length:g} m from its left end")
        return min(max(place, 0.0), length)

    def _from_section(self, table: RawTable, key: str, raw: Mapping[str, Any]) -> float:
        ends = [end for end in _FROM if end in raw]
        if len(ends) != 1 or set(raw) != {"section", *ends}:
            table.refuse(key, dict(raw), PLACE.wanted)
        name, (end,) = raw["section"], ends
        if not isinstance(name, str) or name not in self._named:
            table.refuse(f"{key}.section", shown(name), "the name of a section", f"names: {', '.join(self._named)}")
        i, section = self._named[name]
        distance = Number("length", low=0.0, high=section.values["length"]).read(table, f"{key}.{end}", raw[end])
        left, right = self.shaft.ends[i : i + 2]
        return left + distance if end == "left" else right - distance

    def machine(self, top: float, observers: list[Any]) -> Machine:
        """The machine of a shaft for a band up to `top` in Hz, with nodes at all places that were named so far."""
        from rsc.machine.shaft.division import divided

        table, values = self.table, self.values
        observed = [*(self.node(table, f"observers[{i}]", raw) for i, raw in enumerate(_listed(table, values))), *observers]
        at_nodes = self._at_nodes() if table.name == "rotor" else {}
        source = f"{SHAFT} [{table.name}]"
        try:
            made = divided(self.shaft, top, source, values["elements"])
        except DataError as error:
            table.refuse("bearings", [one.place for one in self.shaft.supports], "such that they hold the shaft", error.problem)
        values.refuse_untaken()
        sections = len(self.shaft.sections)
        origin = f"{source} has {sections} sections and {made.words}"
        return Machine(made.model, origin, "sections", f"{sections} tables", at_nodes, list(dict.fromkeys(observed)))

    def _at_nodes(self) -> dict[str, Any]:
        """Unbalances, loads and gravity of a rotor."""
        loads = [(self.node(own.table, "at", own.values["at"]), own.values["force"]) for own in self.values["load"]]
        return {"unbalances": self._unbalances(), "loads": loads, "gravity": self.values["gravity"] or 0.0}

    def _unbalances(self) -> list[Unbalance]:
        """A grade for the whole rotor gives every disk the mass that is nearer to it than to the others."""
        raw, table = self.values["unbalance"], self.table
        if isinstance(raw, str):
            grade = _grade(table, "unbalance", raw)
            if not self.shaft.disks:
                table.refuse("unbalance", raw, "a list of tables {at, amount, angle}", "without disks its planes have no places")
            places = sorted({disk.place for disk in self.shaft.disks})
            shares = zip(places, self.shaft.masses_near(places), strict=True)
            return [Unbalance(self.node(table, "unbalance", place), grade * mass) for place, mass in shares]
        items = Tables(UnbalanceKeys).read(table, "unbalance", raw)
        named = [(self.node(own.table, "at", own.values["at"]), own) for own in items]
        return [Unbalance(name, amount_at(own.table, "amount", own.values["amount"]), own.values["angle"]) for name, own in named]


def _listed(table: RawTable, values: Mapping[str, Any]) -> list[Any]:
    observers = as_list(values["observers"])
    if observers is None:
        table.refuse("observers", values["observers"], "a list of places")
    return observers


def _grade(table: RawTable, key: str, raw: str) -> float:
    """Distance in m of the centre of mass by a balance grade at the largest speed of the drive."""
    grade = eccentricity_of_grade(raw, table.fastest)
    if grade is None:
        table.refuse(key, raw, "a grade such as \"G 6.3\" of a rotor that turns")
        raise AssertionError
    return grade


def _rayleigh(table: RawTable, raw: Any) -> tuple[float, float]:
    if raw is None:
        return 0.0, 0.0
    alpha, beta = per_coordinate(table, "rayleigh", raw, (Number("rate", low=0.0), Number("time", low=0.0)))
    return alpha, beta


def _material(table: RawTable, raw: Any, default: Material | None = None) -> Material:
    """A material by name or by its numbers."""
    if raw is None and default is not None:
        return default
    if isinstance(raw, Mapping):
        values = read_table(MaterialKeys, table.within("material", raw))
        return Material(values["density"], values["youngs_modulus"], values["poisson"])
    if not isinstance(raw, str) or raw not in MATERIALS:
        table.refuse("material", raw, MATERIAL.wanted)
    return MATERIALS[raw]


def _section(own: Item, material: Material) -> Section:
    table, values = own.table, own.values
    for i, (bore, diameter) in enumerate(zip(values["bore"], values["diameter"], strict=True)):
        if not bore < diameter:
            table.refuse("bore", table.values.get("bore", bore), f"less than the diameter at its {_FROM[i]} end, {diameter:g} m")
    material = _material(table, values["material"], material)
    return Section(values["length"], values["diameter"], values["bore"], material, values.get("name") or "")


def _disk(own: Item, place: float, shaft: Shaft, material: Material) -> Disk:
    """A disk with its own inertias, or with those of its shape."""
    table, values = own.table, own.values
    inertias = {key: values[key] for key in ("mass", "polar_inertia", "diametral_inertia")}
    if all(value is None for value in inertias.values()):
        if values["diameter"] is None or values["width"] is None:
            table.refuse("mass", None, "given with polar_inertia and diametral_inertia, or instead of them diameter and width")
        bore = shaft.diameter_at(place) if values["bore"] is None else values["bore"]
        if not bore < values["diameter"]:
            what = "of the shaft there" if values["bore"] is None else "of its bore"
            table.refuse("diameter", table.values["diameter"], f"more than that {what}, {bore:g} m")
        density = _material(table, values["material"], material).density
        inertias = dict(zip(inertias, disk_inertias(values["diameter"], bore, values["width"], density), strict=True))
    else:
        for key in ("bore", "material"):
            if values[key] is not None:
                table.refuse(key, table.values[key], "left out where mass and inertias are given", "it would have no effect")
    missing = [key for key, value in inertias.items() if value is None]
    if missing:
        table.refuse(missing[0], None, "given beside the others of mass, polar_inertia and diametral_inertia")
    if inertias["polar_inertia"] > 2.0 * inertias["diametral_inertia"] * (1.0 + 1e-9):
        wanted = f"at most twice diametral_inertia, {2.0 * inertias['diametral_inertia']:g} kg m^2, as of a thin disk"
        table.refuse("polar_inertia", inertias["polar_inertia"], wanted)
    return Disk(place, **inertias, name=values["name"] or "", diameter=values["diameter"], width=values["width"])


def _refuse_overlap(values: Any, shaft: Shaft) -> None:
    """Two disks of known widths may not share a piece of the shaft."""
    pairs = sorted(zip(shaft.disks, values, strict=True), key=lambda pair: pair[0].place)
    for (left, _), (right, own) in pairwise(pairs):
        least = 0.5 * ((left.width or 0.0) + (right.width or 0.0))
        if right.place - left.place < least * (1.0 - 1e-9):
            wanted = f"at least {least:g} m from the disk at {left.place:g} m: they overlap"
            own.table.refuse("at", own.table.values["at"], wanted)


def _support(own: Item, place: float) -> Support:
    """A bearing with constant coefficients, or with those of its table."""
    table, values = own.table, own.values
    tilting: tuple[float, float, str] = (values["tilt_stiffness"], values["tilt_damping"], values["name"] or "")
    if values["table"] is not None:
        if table.folder is None:
            table.refuse("table", values["table"], "no file", "the scene of a result holds the reduced body")
        try:
            speeds, coefficients = read_bearing_table(table.folder / values["table"])
        except DataError as error:
            table.refuse("table", values["table"], "a CSV file of coefficients over the speed", error.problem)
        return Support(place, speeds, coefficients, *tilting)
    if values["stiffness"] is None:
        table.refuse("stiffness", None, "given, or instead of it table")
    raw = (values[key] or 0.0 for key in ("stiffness", "damping"))
    stiffness, damping = (coefficients_of(table, key, own, key) for key, own in zip(("stiffness", "damping"), raw, strict=True))
    return Support(place, np.zeros(1), np.array([[*stiffness, *damping]]), *tilting)
