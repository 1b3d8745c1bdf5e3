"""Reading of a shaft described by stations: its tables become a `rsc.machine.shaft.parts.Shaft`, then a machine."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from rsc.errors import DataError, SceneError, shown
from rsc.machine.model.contact import Unbalance
from rsc.machine.shaft.parts import SAME_PLACE, Disk, Material, Section, Shaft, Support, disk_inertias
from rsc.scene.bodies.bearing_table import read_bearing_table
from rsc.scene.bodies.controls import Control, bearing_of, placed_states
from rsc.scene.bodies.machine_file import Machine, amount_at, coefficients_of, switched_models
from rsc.scene.bodies.off import off_time
from rsc.scene.bodies.shaft_keys import MATERIAL, MATERIALS, METRES, PLACE, MaterialKeys, ShaftRotor, ShaftStator, UnbalanceKeys
from rsc.scene.bodies.states import MagneticBearing, refuse_many
from rsc.scene.keys.keys import RawTable, read_table
from rsc.scene.keys.nested import Item, Tables
from rsc.scene.keys.readers import Number, as_list, per_coordinate
from rsc.units import QuantityError, eccentricity_of_grade, quantity

SHAFT = "the shaft of"  # start of the `origin` of a body made from a shaft
_FROM = ("left", "right")
FASTEST = 500.0  # m/s: no shaft is so fast at its surface
LIGHTEST, HEAVIEST = 10.0, 30000.0  # kg/m^3, from foam to more than the heaviest metals
METAL, SOFT = 2000.0, 1e9  # kg/m^3 and Pa: no solid so dense is softer


class Stations:
    """The table of a shaft, which also collects positions from other tables.

    shaft : Shaft, including these positions
    """

    def __init__(self, table: RawTable, elsewhere: Any) -> None:
        self.table = table
        self.values = read_table(ShaftRotor if table.name == "rotor" else ShaftStator, table, elsewhere)
        values, material = self.values, _material(table, self.values["material"])
        self.shaft = Shaft(
            sections=tuple(_section(item, material) for item in values["sections"]),
            rotating_damping=values.get("shaft_damping") or 0.0,
            rayleigh=_rayleigh(table, values["rayleigh"]),
            shear=values["shear"],
        )
        _refuse_fast(table, max(max(section.outer) for section in self.shaft.sections))
        numbered = list(enumerate(values["sections"]))
        self._named = {item.values["name"]: (i, item) for i, item in numbered if item.values["name"] is not None}
        self._known: dict[str, float] = {}
        sleeves = tuple(self._sleeve(item, material) for item in values["sleeves"])
        self.shaft = replace(self.shaft, sleeves=sleeves)
        disks = tuple(_disk(item, self._named_place(item), self.shaft, material) for item in values["disks"])
        self._supports = tuple(_support(item, self._named_place(item)) for item in values["bearings"])
        self._off = [_off(item) for item in values["bearings"]]
        pairs = list(zip(self._supports, self._off, strict=True))
        places = {one.name or f"{one.place:.6g} m": one.place for one, off in pairs if off is not None}
        staying = tuple(one for one, off in pairs if off is None)
        self.shaft = replace(self.shaft, disks=disks, supports=staying, places=places)
        _refuse_overlap(values["disks"], self.shaft)
        self._magnets = [(item, self._named_place(item)) for item in values.get("magnetic_bearings", ())]

    def node(self, table: RawTable, key: str, raw: Any) -> str:
        """The name of the node at a position in a table of contacts, loads etc.; adds it to the positions of the shaft."""
        place = self._place(table, key, raw)
        name = raw if isinstance(raw, str) else f"{place:.6g} m"
        self.shaft.places[name] = place
        return name

    def _sleeve(self, item: Item, material: Material) -> tuple[float, Section]:
        """(start in m, sleeve); its bore defaults to the shaft diameter there."""
        place, table = self._place(item.table, "at", item.values["at"]), item.table
        room = self.shaft.length - place
        if item.values["length"] > room * (1.0 + SAME_PLACE):
            table.refuse("length", table.values["length"], f"at most {_mm(room)}, where the shaft ends")
        if item.values["bore"] is None:
            right = [one for one in self.shaft.placed if one.start <= place * (1.0 + SAME_PLACE)][-1]
            item.values["bore"] = (right.section.diameter_at(place - right.start),) * 2
        return place, _section(item, material)

    def _named_place(self, item: Item) -> float:
        """Position of a disk or bearing, and registration of its name."""
        place, name = self._place(item.table, "at", item.values["at"]), item.values["name"]
        if name in self._known:
            item.table.refuse("name", name, "a name that no other disk or bearing has")
        if name is not None:
            self._known[name] = place
        return place

    def _place(self, table: RawTable, key: str, raw: Any) -> float:
        """Position in m from the left end."""
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
            table.refuse(key, raw, f"on the shaft, 0 to {_mm(length)} from its left end", METRES if _is_number(raw) else "")
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
        """The machine of the shaft for a band up to `top` in Hz, with nodes at all positions named so far."""
        from rsc.machine.shaft.assembly import model_of
        from rsc.machine.shaft.division import TooManyNodes, divided

        table, values = self.table, self.values
        observed = [*(self.node(table, f"observers[{i}]", raw) for i, raw in enumerate(_listed(table, values))), *observers]
        at_nodes = self._at_nodes() if table.name == "rotor" else {}
        controls, source = self._controls(), f"{SHAFT} [{table.name}]"
        try:
            made = divided(self.shaft, top, source, values["elements"])
            switched = switched_models(lambda time: model_of(self._until(time), made.nodes, source), list(self._off))
        except TooManyNodes as error:
            told = f"{len(self.shaft.sections)} sections, {_mm(self.shaft.length)}"
            wanted = f"a shaft that bends in the band, up to {top:g} Hz, in fewer elements"
            table.refuse("sections", told, wanted, f"it {error.problem}: check lengths, diameters, Young's modulus and density")
        except DataError as error:
            at = [float(f"{one.place:.6g}") for one in self.shaft.supports]
            table.refuse("bearings", at, "bearings that support the shaft", error.problem)
        values.refuse_untaken()
        sections = len(self.shaft.sections)
        origin = f"{source} has {sections} sections and {made.words}"
        observed = list(dict.fromkeys(observed))
        return Machine(made.model, origin, "sections", f"{sections} tables", at_nodes, observed, switched, controls)

    def _controls(self) -> tuple[Control, ...]:
        """The first-order states of a rotor, with nodes at their sensors and actuators."""
        made = placed_states(self.table, self.values.get("states"), self.node)
        for item, place in self._magnets:
            own, name = item.values, item.values["name"]
            actuator = self.node(item.table, "at", name or place)
            sensor = actuator if own["sensor_at"] is None else self.node(item.table, "sensor_at", own["sensor_at"])
            bearing = bearing_of(item.table, own)
            made.append(Control([actuator], [sensor], bearing, name or actuator))
        refuse_many(self.table, [one.own for one in made if isinstance(one.own, MagneticBearing)])
        return tuple(made)

    def _until(self, time: float) -> Shaft:
        """The shaft with the bearings that are there until a time in s."""
        holding = tuple(one for one, off in zip(self._supports, self._off, strict=True) if off is None or off >= time)
        return replace(self.shaft, supports=holding)

    def _at_nodes(self) -> dict[str, Any]:
        """Unbalances, loads and gravity of a rotor."""
        loads = [(self.node(item.table, "at", item.values["at"]), item.values["force"]) for item in self.values["load"]]
        return {"unbalances": self._unbalances(), "loads": loads, "gravity": self.values["gravity"] or 0.0}

    def _unbalances(self) -> list[Unbalance]:
        """The unbalances; a grade for the whole rotor is divided by the mass nearest to each disk."""
        raw, table = self.values["unbalance"], self.table
        if isinstance(raw, str):
            grade = _grade(table, "unbalance", raw)
            if not self.shaft.disks:
                table.refuse("unbalance", raw, "a list of tables {at, amount, angle}", "without disks the planes are unknown")
            places = sorted({disk.place for disk in self.shaft.disks})
            shares = zip(places, self.shaft.masses_near(places), strict=True)
            return [Unbalance(self.node(table, "unbalance", place), grade * mass) for place, mass in shares]
        items = Tables(UnbalanceKeys).read(table, "unbalance", raw)
        named = [(self.node(item.table, "at", item.values["at"]), item) for item in items]
        amounts = [amount_at(item.table, "amount", item.values["amount"]) for item in items]
        return [Unbalance(name, amount, item.values["angle"]) for (name, item), amount in zip(named, amounts, strict=True)]


def _mm(metres: float) -> str:
    """A length in m as drawings have it."""
    return f"{1e3 * metres:.6g} mm"


def _is_number(raw: Any) -> bool:
    return isinstance(raw, (int, float))


def _listed(table: RawTable, values: Mapping[str, Any]) -> list[Any]:
    observers = as_list(values["observers"])
    if observers is None:
        table.refuse("observers", values["observers"], "a list of places")
    return observers


def _grade(table: RawTable, key: str, raw: str) -> float:
    """Eccentricity in m permitted by a balance grade at the speed it names, else at the largest of the drive."""
    grade = eccentricity_of_grade(raw, table.fastest)
    if grade is None:
        table.refuse(key, raw, "a grade such as \"G 6.3\" or \"G 6.3 at 3000 rpm\", for a rotor that turns")
        raise AssertionError
    return grade


def _rayleigh(table: RawTable, raw: Any) -> tuple[float, float]:
    if raw is None:
        return 0.0, 0.0
    alpha, beta = per_coordinate(table, "rayleigh", raw, (Number("rate", low=0.0), Number("time", low=0.0)))
    return alpha, beta


def _material(table: RawTable, raw: Any, default: Material | None = None) -> Material:
    """A material by name or by its properties."""
    if raw is None and default is not None:
        return default
    if isinstance(raw, Mapping):
        inner = table.within("material", raw)
        values = read_table(MaterialKeys, inner)
        density, young = values["density"], values["youngs_modulus"]
        if density and not LIGHTEST <= density <= HEAVIEST:
            wanted = f"0 for a massless piece, or {LIGHTEST:g} to {HEAVIEST:g} kg/m^3"
            inner.refuse("density", raw["density"], wanted, "steel has 7850 kg/m^3 = 7.85 g/cm^3")
        if density > METAL and young < SOFT:
            wanted = f"at least {1e-9 * SOFT:g} GPa for a material of {density:g} kg/m^3"
            inner.refuse("youngs_modulus", raw["youngs_modulus"], wanted, "steel has 210 GPa = 210000 MPa")
        return Material(density, young, values["poisson"])
    if not isinstance(raw, str) or raw not in MATERIALS:
        table.refuse("material", raw, MATERIAL.wanted)
    return MATERIALS[raw]


def _section(item: Item, material: Material) -> Section:
    table, values = item.table, item.values
    for i, (bore, diameter) in enumerate(zip(values["bore"], values["diameter"], strict=True)):
        if not bore < diameter:
            table.refuse("bore", table.values.get("bore", bore), f"less than the diameter at its {_FROM[i]} end, {_mm(diameter)}")
    material = _material(table, values["material"], material)
    return Section(values["length"], values["diameter"], values["bore"], material, values.get("name") or "")


def _disk(item: Item, place: float, shaft: Shaft, material: Material) -> Disk:
    """A disk with given inertias, or with those that follow from its shape."""
    table, values = item.table, item.values
    inertias = {key: values[key] for key in ("mass", "polar_inertia", "diametral_inertia")}
    if all(value is None for value in inertias.values()):
        if values["diameter"] is None or values["width"] is None:
            table.refuse("mass", None, "given with polar_inertia and diametral_inertia, or diameter and width instead")
        bore = shaft.diameter_at(place) if values["bore"] is None else values["bore"]
        if not bore < values["diameter"]:
            what = "of the shaft there" if values["bore"] is None else "of its bore"
            table.refuse("diameter", table.values["diameter"], f"more than that {what}, {_mm(bore)}")
        density = _material(table, values["material"], material).density
        inertias = dict(zip(inertias, disk_inertias(values["diameter"], bore, values["width"], density), strict=True))
    else:
        for key in ("bore", "material"):
            if values[key] is not None:
                table.refuse(key, table.values[key], "left out where mass and inertias are given", "it would have no effect")
    missing = [key for key, value in inertias.items() if value is None]
    if missing:
        table.refuse(missing[0], None, "given: mass, polar_inertia and diametral_inertia go together")
    if inertias["polar_inertia"] > 2.0 * inertias["diametral_inertia"] * (1.0 + 1e-9):
        wanted = f"at most twice diametral_inertia, {2.0 * inertias['diametral_inertia']:g} kg m^2, the value for a thin disk"
        table.refuse("polar_inertia", inertias["polar_inertia"], wanted)
    _refuse_wide(table, inertias, shaft.length)
    return Disk(place, **inertias, name=values["name"] or "", diameter=values["diameter"], width=values["width"])


def _refuse_fast(table: RawTable, diameter: float) -> None:
    """SceneError for a rotor whose shaft would burst at the largest speed of the drive."""
    surface = np.pi * diameter * abs(table.fastest)
    if surface > FASTEST:
        wanted = f"so slow that the surface of the shaft, {_mm(diameter)} in diameter, moves at {FASTEST:g} m/s at most"
        hint = f"at {table.fastest:g} Hz it has {surface:.4g} m/s: a number without a unit is in Hz, write \"9000 rpm\""
        raise SceneError(table.file, "drive.speed", float(table.fastest), wanted, hint)


def _refuse_wide(table: RawTable, inertias: Mapping[str, Any], length: float) -> None:
    """SceneError for a disk whose mass is so small, or whose inertia so large, that it would be wider than the shaft is long."""
    radius = np.sqrt(inertias["polar_inertia"] / inertias["mass"])
    if radius > length:
        told = f"{_mm(radius)} of {inertias['polar_inertia']:g} kg m^2: is a unit wrong?"
        wanted = f"a mass whose radius of gyration is not larger than the length of the shaft, {_mm(length)}"
        table.refuse("mass", table.values.get("mass"), wanted, told)


def _refuse_overlap(values: Any, shaft: Shaft) -> None:
    """SceneError for overlapping disks of known widths."""
    pairs = sorted(zip(shaft.disks, values, strict=True), key=lambda pair: pair[0].place)
    for (left, _), (right, item) in pairwise(pairs):
        least = 0.5 * ((left.width or 0.0) + (right.width or 0.0))
        if right.place - left.place < least * (1.0 - 1e-9):
            wanted = f"at least {_mm(least)} from the disk at {_mm(left.place)}: they overlap"
            item.table.refuse("at", item.table.values["at"], wanted)


def _off(item: Item) -> float | None:
    """The time in s at which a bearing is switched off; None for one that stays."""
    off = off_time(item.table, "off", item.values["off"])
    if off is not None and item.values["table"] is not None:
        item.table.refuse("off", item.values["off"], "left out with table: coefficients that follow the speed stay")
    return off


def _support(item: Item, place: float) -> Support:
    """A bearing with constant coefficients, or with those of its table."""
    table, values = item.table, item.values
    tilting: tuple[float, float, str] = (values["tilt_stiffness"], values["tilt_damping"], values["name"] or "")
    if values["table"] is not None:
        if table.folder is None:
            table.refuse("table", values["table"], "no file", "the scene of a result contains the reduced body")
        try:
            speeds, coefficients = read_bearing_table(table.folder / values["table"])
        except DataError as error:
            table.refuse("table", values["table"], "a CSV file of coefficients over the speed", error.problem)
        return Support(place, speeds, coefficients, *tilting)
    if values["stiffness"] is None:
        table.refuse("stiffness", None, "given, or table instead")
    raw = (values[key] or 0.0 for key in ("stiffness", "damping"))
    stiffness, damping = (coefficients_of(table, key, part, key) for key, part in zip(("stiffness", "damping"), raw, strict=True))
    return Support(place, np.zeros(1), np.array([[*stiffness, *damping]]), *tilting)
