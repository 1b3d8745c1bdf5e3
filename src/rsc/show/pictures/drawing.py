"""The drawing of a shaft by its stations, and the shapes of its modes with the sense of whirl at every node."""

import math
from typing import Any

import numpy as np

from rsc.show.pictures.traces import BLUE, GREEN, GREY, ORANGE, RED, axes, dots, line, named_once

INK, MM = "#222222", 1e3
SHAPES = 4  # modes whose shapes are shown
_OVER = 1.35  # of the largest radius: the limits of the drawing
_SHARE = 1e-3  # of the largest deflection: smaller ones have no sense


def drawing(scene: Any) -> dict[str, Any] | None:
    """Description of the drawing of a rotor; None where it was not given by its stations, or its scene comes from a result.

    Sections with their bores, sleeves, disks, bearings below the axis, contacts and clearances at the surface, true to scale
    along the axis and across it, each of its own.
    """
    shaft = shaft_of(scene)
    if shaft is None:
        return None
    data = []
    for i, one in enumerate(shaft.placed):
        sleeve = i >= len(shaft.sections)
        ends = [one.start, one.end]
        data += _mirrored(*_box(ends, one.section.outer), "sleeve" if sleeve else "shaft", GREY if sleeve else INK)
        if any(one.section.inner) and not sleeve:
            data += _mirrored(ends, [0.5 * d for d in one.section.inner], "bore", INK, "dot")
    widest = max(0.5 * d for one in shaft.placed for d in one.section.outer)
    for disk in shaft.disks:
        radius, half = _size(disk, widest)
        widest = max(widest, radius)
        known = disk.diameter is not None
        name, dash = ("disk", "solid") if known else ("disk, shape unknown", "dash")
        data += _mirrored(*_box([disk.place - half, disk.place + half], (2.0 * radius, 2.0 * radius)), name, BLUE, dash)
    held = [(one.place, -0.5 * shaft.diameter_at(one.place), one.name) for one in shaft.supports]
    data += _marks(held, "bearing", GREEN, "triangle-up")
    touched = [(contact.name or "contact", place) for contact, place in zip(scene.contacts, _touching(scene), strict=False)]
    watched = [(one.name, shaft.places[one.rotor_node]) for one in scene.clearances if one.rotor_node in shaft.places]
    for named, name, colour, symbol in ((touched, "contact", RED, "triangle-down"), (watched, "clearance", ORANGE, "diamond")):
        data += _marks([(place, 0.5 * shaft.diameter_at(place), label) for label, place in named], name, colour, symbol)
    x = {"title": "from the left end in mm", "range": [-0.05 * shaft.length * MM, 1.2 * shaft.length * MM]}  # room for names
    y = {"title": "radius in mm", "range": [-_OVER * widest * MM, _OVER * widest * MM]}
    return {"data": named_once(data), "layout": axes(x, y, 320)}


def shaft_of(scene: Any) -> Any:
    """The shaft that a scene's rotor was made of; None of any other."""
    models = [reduced.model for reduced in scene.reductions[:1]] if scene.rotor.model == "reduced" else []
    return getattr(models[0], "shaft", None) if models else None


def shapes(model: Any, modes: Any) -> list[dict[str, Any]]:
    """Descriptions of modes with their vectors (`rsc.machine.model.modes.slowest_shapes`): the deflection along the
    axis when it is largest, blue where a node whirls forward and red where it whirls backward."""
    kept = np.flatnonzero(model.kind == "displacement")
    order = kept[np.argsort([model.position[node] for node in model.node[kept]])]
    places = MM * np.array([model.position[node] for node in model.node[order]])
    made = []
    for mode, vector in modes:
        own = vector[order]
        other = vector[model.n + order] if len(vector) > model.n else 0.0 * own
        size = np.abs(own) + np.abs(other)
        lead = int(np.argmax(size))
        reference = own[lead] if abs(own[lead]) >= abs(other[lead]) else other[lead]
        sign = np.sign(((own + other) * np.conj(reference)).real)
        bent = sign * size / size.max()
        data = [line(places, bent, "deflection", GREY), line(places[[0, -1]], [0.0, 0.0], "axis", GREY, "dashdot", 1.0)]
        forward, seen = np.abs(own) >= np.abs(other), size > _SHARE * size.max()
        forward = forward if mode.frequency >= 0.0 or len(vector) > model.n else ~forward
        for which, name, colour in ((forward, "forward", BLUE), (~forward, "backward", RED)):
            if (which & seen).any():
                data.append(dots(places[which & seen], bent[which & seen], name, colour, size=4))
        y = {"title": f"{mode.frequency:.4g} Hz", "range": [-1.15, 1.15]}
        made.append({"data": data, "layout": axes("from the left end in mm", y, 170)})
    return made


def _box(ends: list[float], diameters: tuple[float, float]) -> tuple[list[float], list[float]]:
    """The upper outline of a piece, from the axis and back to it."""
    return [ends[0], ends[0], ends[1], ends[1]], [0.0, 0.5 * diameters[0], 0.5 * diameters[1], 0.0]


def _mirrored(x: list[float], y: list[float], name: str, colour: str, dash: str = "solid") -> list[dict[str, Any]]:
    """A line above the axis and its mirror image."""
    x, y = [MM * value for value in x], [MM * value for value in y]
    return [line(x, y, name, colour, dash), line(x, [-value for value in y], name, colour, dash)]


def _marks(stations: list[tuple[float, float, str]], name: str, colour: str, symbol: str) -> list[dict[str, Any]]:
    """Symbols at (place, radius, label)."""
    if not stations:
        return []
    places, radii, labels = zip(*stations, strict=True)
    marks = dots([MM * x for x in places], [MM * r for r in radii], name, colour, size=11, symbol=symbol)
    return [marks | {"mode": "markers+text", "text": list(labels), "textposition": "top right"}]


def _size(disk: Any, widest: float) -> tuple[float, float]:
    """Radius and half width of a disk, as they are known or guessed."""
    gyration = math.sqrt(2.0 * disk.polar_inertia / disk.mass)  # radius of a solid cylinder of that inertia
    radius = max(1.2 * widest, gyration) if disk.diameter is None else 0.5 * disk.diameter
    return radius, 0.5 * (disk.width if disk.width is not None else 0.1 * radius)


def _touching(scene: Any) -> list[float]:
    """Places of the contacts in m, in their order."""
    shaft, reduced = shaft_of(scene), scene.reductions[0]
    rows = np.atleast_2d(reduced.full.contact)
    nodes = [int(reduced.model.node[int(np.abs(row).argmax())]) for row in rows]
    return [reduced.model.position[nodes[contact.rotor_coordinates[0]]] for contact in scene.contacts if shaft is not None]
