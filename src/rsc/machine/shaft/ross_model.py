"""Reader of shafts from ROSS model files, written by `rotor.save` (versions 2.0 to 3): elements, not matrices.

The file has a table for each element, whose name starts with its class: ShaftElement (length, inner and outer diameters at both
ends, material), DiskElement, and bearings or seals with coefficients, over the rotor speed in rad/s if there are several. Of
several shaft elements at one position the first is the section and the others are sleeves on it.
"""

from collections.abc import Mapping
from itertools import accumulate
from typing import Any

import numpy as np

from rsc.errors import DataError, one_line
from rsc.machine.shaft.parts import Disk, Material, Section, Shaft, Support

_BEARINGS = ("BearingElement", "SealElement", "BallBearingElement", "RollerBearingElement", "BearingFluidFlow", "PlainJournal")
_COEFFICIENTS = [f"{letter}{pair}" for letter in "kc" for pair in ("xx", "xy", "yx", "yy")]
_MASSES = ("mxx", "mxy", "myx", "myy")
_LEFT_OUT = {"axial_force": "axial forces", "torque": "torques"}
# effects that elements may switch off in ROSS, but not in rsc
_TAKEN = {"rotary_inertia": "rotary inertia", "gyroscopic": "gyroscopics"}


def shaft_of(tables: Mapping[str, Any], source: str) -> tuple[Shaft, list[str]]:
    """(shaft of a model file with one section per element, notes in whole sentences on omissions).

    Raises
    ------
    DataError
        Not such a file, or unsupported elements: gears, couplings, point masses, magnetic bearings.
    """
    kinds = _elements(tables, source)
    elements = sorted(kinds["ShaftElement"], key=lambda element: _number(element, "n", source))
    below = [element for i, element in enumerate(elements) if i == 0 or element["n"] != elements[i - 1]["n"]]
    if [element["n"] for element in below] != list(range(len(below))):
        raise DataError(source, "its shaft elements are not contiguous from node 0 on")
    nodes = list(accumulate((_number(element, "L", source) for element in below), initial=0.0))
    sleeves = [element for element in elements if not any(element is one for one in below)]
    shear = {bool(element.get("shear_effects", True)) for element in elements}
    damping = {(float(element.get("alpha", 0.0)), float(element.get("beta", 0.0))) for element in elements}
    if len(shear) > 1 or len(damping) > 1:
        raise DataError(source, "shear or damping of its shaft elements differ: rsc has a single setting for the whole shaft")
    shaft = Shaft(
        sections=tuple(_section(element, source) for element in below),
        sleeves=tuple((nodes[int(element["n"])], _section(element, source)) for element in sleeves),
        disks=tuple(_disk(element, nodes, source) for element in kinds["DiskElement"]),
        supports=tuple(_support(element, nodes, source) for element in kinds["BearingElement"]),
        rayleigh=damping.pop(),
        shear=shear.pop(),
    )
    return shaft, _notes(elements, kinds["BearingElement"])


def _elements(tables: Mapping[str, Any], source: str) -> dict[str, list[Mapping[str, Any]]]:
    """Elements by class; all bearings and seals under BearingElement."""
    kinds: dict[str, list[Mapping[str, Any]]] = {"ShaftElement": [], "DiskElement": [], "BearingElement": []}
    for name, element in tables.items():
        kind = name.partition("_")[0]
        kind = "BearingElement" if kind in _BEARINGS else kind
        if not isinstance(element, Mapping) or name == "parameters":
            continue
        if kind not in kinds:
            raise DataError(source, f"{one_line(name)[:60]}: only shaft elements, disks, bearings and seals are supported")
        kinds[kind].append(element)
    if not kinds["ShaftElement"] or not kinds["BearingElement"]:
        raise DataError(source, "not a model file of ROSS's rotor.save: it needs shaft elements and bearings")
    return kinds


def _number(element: Mapping[str, Any], key: str, source: str) -> float:
    value = element.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
        raise DataError(source, f"{_tag(element)}: its {key} must be a number")
    return float(value)


def _tag(element: Mapping[str, Any]) -> str:
    return one_line(element.get("tag", "an element"))[:40]


def _section(element: Mapping[str, Any], source: str) -> Section:
    """The Section of a shaft element; Poisson's ratio follows from both moduli."""
    table = element.get("material")
    if not isinstance(table, Mapping):
        raise DataError(source, f"{_tag(element)}: it has no material")
    young, slide = _number(table, "E", source), _number(table, "G_s", source)
    (left, right), (bore_left, bore_right) = ([_number(element, f"{kind}{end}", source) for end in "lr"] for kind in ("od", "id"))
    length = _number(element, "L", source)
    if not (length > 0.0 and 0.0 <= bore_left < left and 0.0 <= bore_right < right and young > 0.0 and slide > 0.0):
        raise DataError(source, f"{_tag(element)}: its length, diameters or moduli are impossible")
    material = Material(_number(table, "rho", source), young, young / slide / 2.0 - 1.0)
    return Section(length, (left, right), (bore_left, bore_right), material)


def _place(element: Mapping[str, Any], nodes: list[float], source: str) -> float:
    node = int(_number(element, "n", source))
    if element.get("n_link") is not None or not 0 <= node < len(nodes):
        raise DataError(source, f"{_tag(element)}: it must be between a node of the shaft and ground")
    return nodes[node]


def _disk(element: Mapping[str, Any], nodes: list[float], source: str) -> Disk:
    mass, polar, diametral = (_number(element, key, source) for key in ("m", "Ip", "Id"))
    return Disk(_place(element, nodes, source), mass, polar, diametral, name=_tag(element))


def _support(element: Mapping[str, Any], nodes: list[float], source: str) -> Support:
    """A bearing or seal with constant or speed-dependent coefficients; missing ones default as in ROSS."""
    alike = {"kyy": "kxx", "cyy": "cxx"}
    columns = [np.ravel(element.get(name, element.get(alike.get(name, ""), 0.0))) for name in _COEFFICIENTS]
    speeds = np.ravel(element.get("frequency") or [0.0]) / (2.0 * np.pi)
    count = len(speeds)
    try:
        table = np.array([np.broadcast_to(np.array(column, float), count) for column in columns]).T
    except ValueError:
        raise DataError(source, f"{_tag(element)}: its coefficients do not match its {count} frequencies") from None
    if not (np.isfinite(table).all() and (np.diff(speeds) > 0.0).all()):
        raise DataError(source, f"{_tag(element)}: its coefficients must be finite and its frequencies increasing")
    if (table == table[0]).all():
        speeds, table = np.zeros(1), table[:1]
    return Support(_place(element, nodes, source), speeds, table, name=_tag(element))


def _notes(elements: list[Mapping[str, Any]], bearings: list[Mapping[str, Any]]) -> list[str]:
    """Notes on what rsc models differently."""
    loaded = [word for key, word in _LEFT_OUT.items() if any(one.get(key) for one in elements)]
    without = [word for key, word in _TAKEN.items() if not all(one.get(key, True) for one in elements)]
    notes = [f"{word} of shaft elements are left out." for word in loaded]
    notes += [f"{word} is included for all elements." for word in without]
    if any(one.get("shear_method_calc", "cowper") != "cowper" for one in elements):
        notes.append("the shear factor is Cowper's for all elements.")
    if any(np.any(one.get(name, 0.0)) for one in bearings for name in _MASSES):
        notes.append("added masses of bearings and seals are left out.")
    return notes
