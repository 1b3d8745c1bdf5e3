"""The undamped critical speed map as a table and as a picture."""

from typing import Any

import numpy as np

from rsc.analysis.alone.critical_map import CriticalMap, MappedBearing
from rsc.errors import one_line
from rsc.show.pictures.traces import BLUE, GREEN, ORANGE, PURPLE, RED, SKY, axes, dots, in_units, line
from rsc.show.words.table import table
from rsc.show.words.units import column
from rsc.show.words.wording import amount

COLOURS = (RED, GREEN, PURPLE, ORANGE, SKY)
ROOM = 1.15  # factor between the extreme speeds and the frame


def map_text(made: CriticalMap, title: str) -> str:
    """A table of the critical speeds, and the stiffnesses of the machine."""
    shown = np.isfinite(made.speed).any(axis=0)
    factor, unit = column("Hz")
    header = ("stiffness N/m", *(f"critical {i + 1}" for i in np.flatnonzero(shown)), "")
    rows = [
        (f"{k:.4g}", *(f"{factor * speed:.5g}" if np.isfinite(speed) else "-" for speed in speeds), "")
        for k, speeds in zip(made.stiffness, made.speed[:, shown], strict=True)
    ]
    lines = [one_line(title)] if title else []
    lines += [f"undamped critical speeds in {unit} over the stiffness of the bearings; forward, without cross-coupling"]
    return "\n".join([*lines, table(header, rows), *(f"stiffness of {one.name}: {_told(one)}" for one in made.bearings)])


def _told(bearing: MappedBearing) -> str:
    ends = [amount(value, "N/m") for value in dict.fromkeys([bearing.stiffness.min(), bearing.stiffness.max()])]
    return " to ".join(ends) + (", over the rotor speed" if len(ends) > 1 else "") + ("" if bearing.varied else ", not varied")


def critical_speeds(made: CriticalMap) -> dict[str, Any]:
    """Description of the map: both axes logarithmic, a line for every critical speed, and the stiffness that each varied bearing
    has, over the rotor speed where it depends on it."""
    known = made.speed[np.isfinite(made.speed)]
    low, high = (known.min() / ROOM, known.max() * ROOM) if known.size else (1.0, 10.0)
    data = []
    for i, speeds in enumerate(made.speed.T):
        if np.isfinite(speeds).any():
            data.append(line(made.stiffness, speeds, "undamped critical speed", BLUE, showlegend=not i))
    for i, bearing in enumerate(one for one in made.bearings if one.varied):
        colour, name = COLOURS[i % len(COLOURS)], f"{bearing.name}, as it is"
        # constant below and above its table
        speed = np.concatenate([[low], np.clip(bearing.speed, low, high), [high]])
        stiffness = np.concatenate([bearing.stiffness[:1], bearing.stiffness, bearing.stiffness[-1:]])
        if (stiffness > 0.0).all():
            data.append(line(stiffness, speed, name, colour, "dash" if i % 2 else "solid", 1.3))
            if len(bearing.speed) > 1:
                inside = (bearing.speed >= low) & (bearing.speed <= high)
                data.append(dots(bearing.stiffness[inside], bearing.speed[inside], name, colour, size=4) | {"showlegend": False})
    x = {"title": "stiffness of the bearings in N/m", "type": "log", "range": [made.stiffness.min(), made.stiffness.max()]}
    return in_units({"data": data, "layout": axes(x, {"title": "rotor speed in Hz", "type": "log", "range": [low, high]}, 460)})
