"""The drawing of a rotor by its stations: sections, disks, bearings, contacts and clearances, with their names."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from rsc.scene.bodies.drawn import BEARING, CONTACT, CYLINDER, DISK, PLACE, SLEEVE, Drawn
from rsc.show.pictures.traces import BLUE, GREEN, GREY, ORANGE, RED, axes, line, named_once
from rsc.show.words.wording import length

MM = 1e3
BODY, EDGE, ROW = 200, 14, 16  # pixels: height of the rotor, room above and below it, height of a row of names
NARROW, LETTER = 270.0, 7.0  # pixels: width of a narrow picture, for which names are set in rows, and of a letter
MARGIN = 0.06  # of the length, on both sides
HALF = 0.012  # of the length: half of a bearing or of a piece of the stator
HATCHES = 4
PALE = "29"  # opacity of an area, as the last two digits of its colour
STYLES = {SLEEVE: ("sleeve", GREY, "dash"), DISK: ("disk", BLUE, "solid"),
          CYLINDER: ("disk, diameter of its polar inertia", BLUE, "dash")}  # fmt: skip
THIN = 0.004  # of the length: half of a disk whose width is not known


def drawing(scene: Any) -> dict[str, Any] | None:
    """Description of the drawing of a rotor; None of one that was not given by its stations.

    True to scale along the axis and across it, each with a scale of its own. Bearings stand on the ground below the shaft. Disks
    of unknown width are thin. Pieces of the stator at contacts and clearances are not to scale; their gaps stand beside them.
    """
    parts: Sequence[Drawn] = getattr(scene.rotor, "drawn", None) or ()
    if not parts:
        return None
    span = min(part.start for part in parts), max(part.end for part in parts)
    reach = span[1] - span[0]
    solid = [_seen(part, THIN * reach) for part in parts if part.kind not in (BEARING, CONTACT, PLACE)]
    widest = 0.5 * max(max(part.left, part.right) for part in solid)
    bearings = [part for part in parts if part.kind == BEARING]
    gaps = _gaps(scene, parts)
    above = [(part.name, 0.5 * (part.start + part.end), 0.5 * part.left) for part in solid if part.kind in (DISK, CYLINDER)]
    above += [(f"{name} {length(gap)}", place, radius) for name, place, radius, gap, _ in gaps]
    below = [(part.name or BEARING, part.start, 0.5 * part.left) for part in bearings]
    upper, lower = (_rows([one for one in named if one[0]], span) for named in (above, below))
    pixel = 2.0 * widest / BODY  # in m
    data = [trace for part in solid for trace in _solid(part)]
    data += [trace for part in bearings for trace in _bearing(part, HALF * reach, pixel)]
    for gap in gaps:
        data += _stator(gap, HALF * reach, pixel)
    rows = [1 + max((row for *_, row in named), default=-1) for named in (upper, lower)]
    data += _names(upper, widest + EDGE * pixel, ROW * pixel) + _names(lower, -widest - EDGE * pixel, -ROW * pixel)
    ends = [-widest - (1.5 * EDGE + ROW * rows[1]) * pixel, widest + (1.5 * EDGE + ROW * rows[0]) * pixel]
    x = {"title": "from the left end in mm", "range": [MM * (span[0] - MARGIN * reach), MM * (span[1] + MARGIN * reach)]}
    y = {"title": "radius in mm", "range": [MM * end for end in ends]}
    return {"data": named_once(data), "layout": axes(x, y, BODY + 3 * EDGE + ROW * sum(rows) + 58)}


def _seen(part: Drawn, half: float) -> Drawn:
    """A part as it is drawn: a disk of unknown width is twice `half` wide."""
    return part if part.end > part.start else part._replace(start=part.start - half, end=part.end + half)


def _gaps(scene: Any, parts: Sequence[Drawn]) -> list[tuple[str, float, float, float, str]]:
    """(name, place, radius of the rotor, gap, kind), in m, of every contact and clearance along the shaft."""
    touching = [part for part in parts if part.kind == CONTACT]
    at = {part.name: part for part in parts if part.kind in (PLACE, CONTACT)}
    gaps = []
    for contact in scene.contacts:
        part = touching[contact.rotor_coordinates[0]] if contact.rotor_coordinates[0] < len(touching) else None
        if part is not None:
            diameter = contact.diameter or part.left
            gaps.append((contact.name or CONTACT, part.start, 0.5 * diameter, contact.gap, CONTACT))
    watched = [one for one in scene.clearances if one.rotor_node in at]
    named = [(one.name, at[one.rotor_node], one.gap) for one in watched]
    return gaps + [(name, part.start, 0.5 * part.left, gap, "clearance") for name, part, gap in named]


def _solid(part: Drawn) -> list[dict[str, Any]]:
    """A section, sleeve or disk, cut along its axis."""
    name, colour, dash = STYLES.get(part.kind, ("shaft", GREY, "solid"))
    outer, inner = (part.left, part.right), (part.left_bore, part.right_bore)
    if part.kind in STYLES or any(inner):
        halves = [_closed(part, outer, inner, sign) for sign in (1.0, -1.0)]
    else:
        halves = [_closed(part, outer, (-outer[0], -outer[1]), 1.0)]
    return [_area(x, y, name, colour, dash) for x, y in halves]


def _closed(part: Drawn, outer: Sequence[float], inner: Sequence[float], sign: float) -> tuple[list[float], list[float]]:
    """The outline between two pairs of diameters."""
    x = [part.start, part.end, part.end, part.start, part.start]
    return x, [0.5 * sign * value for value in (outer[0], outer[1], inner[1], inner[0], outer[0])]


def _area(x: Any, y: Any, name: str, colour: str, dash: str = "solid") -> dict[str, Any]:
    more = {"fill": "toself", "fillcolor": colour + PALE, "hoverinfo": "skip"}
    return line(MM * np.array(x), MM * np.array(y), name, colour, dash, 1.3, **more)


def _bearing(part: Drawn, half: float, pixel: float) -> list[dict[str, Any]]:
    """A triangle below the shaft that stands on the hatched ground."""
    top, foot = -0.5 * part.left, -0.5 * part.left - EDGE * pixel
    data = [_area([part.start, part.start + half, part.start - half, part.start], [top, foot, foot, top], BEARING, GREEN)]
    x, y = [part.start - 1.4 * half, part.start + 1.4 * half], [foot, foot]
    for i in range(HATCHES):
        right = part.start + half * (2.8 * (i + 1) / HATCHES - 1.4)
        x, y = [*x, np.nan, right, right - 0.5 * half], [*y, np.nan, foot, foot - 0.35 * EDGE * pixel]
    return [*data, line(MM * np.array(x), MM * np.array(y), BEARING, GREEN, width=1.3, hoverinfo="skip")]


def _stator(gap: tuple[str, float, float, float, str], half: float, pixel: float) -> list[dict[str, Any]]:
    """Pieces of the stator above and below the shaft, at a distance that can be seen."""
    _, place, radius, _, kind = gap
    near, far = radius + 0.3 * EDGE * pixel, radius + 0.9 * EDGE * pixel
    x = [place - half, place + half, place + half, place - half, place - half]
    y, colour = np.array([near, near, far, far, near]), RED if kind == CONTACT else ORANGE
    return [_area(x, sign * y, kind, colour) for sign in (1.0, -1.0)]


Row = tuple[str, float, float, float, int]  # name, its middle, place and radius of what it names, number of its row


def _rows(named: Sequence[tuple[str, float, float]], span: tuple[float, float]) -> list[Row]:
    """Names in as few rows as let none of them overlap in a narrow picture; span: first and last position of the rotor."""
    reach, ends = span[1] - span[0], list[float]()
    letter, low, high = (1.0 + 2.0 * MARGIN) * reach * LETTER / NARROW, span[0] - MARGIN * reach, span[1] + MARGIN * reach
    placed = []
    for name, place, radius in sorted(named, key=lambda one: one[1]):
        half = 0.5 * letter * (len(name) + 1)
        middle = min(max(place, low + half), max(high - half, 0.5 * (low + high)))
        row = next((i for i, end in enumerate(ends) if end <= middle - half), len(ends))
        ends[row : row + 1] = [middle + half]
        placed.append((name, middle, place, radius, row))
    return placed


def _names(placed: Sequence[Row], base: float, step: float) -> list[dict[str, Any]]:
    """Names with thin lines to what they name, in rows from `base` outwards."""
    if not placed:
        return []
    heights = [base + (row + 0.5) * step for *_, row in placed]
    x, y = list[float](), list[float]()
    for (_, middle, place, radius, _), height in zip(placed, heights, strict=True):
        foot = height - 0.45 * step
        x, y = [*x, place, place, middle, np.nan], [*y, np.copysign(radius, step), base, foot, np.nan]
    quiet: dict[str, Any] = {"showlegend": False, "hoverinfo": "skip"}
    lines = line(MM * np.array(x), MM * np.array(y), "names", GREY, "dot", 0.8, **quiet)
    texts = line([MM * one[1] for one in placed], [MM * height for height in heights], "names", GREY, **quiet)
    return [lines, texts | {"mode": "text", "text": [one[0] for one in placed], "textposition": "middle center"}]
