"""Traces and axes of a picture as plotly takes them: lines, dots, numbers.

Colours are near those of Okabe and Ito, which colour-blind readers tell apart, and show on a light page as on a dark one.
"""

import base64
import itertools

import numpy as np

from rsc.show.words.units import column

BLUE, SKY, GREEN, ORANGE, RED, PURPLE, GREY = "#0b7cc4", "#56b4e9", "#009e73", "#d98e04", "#d55e00", "#b9689a", "#8a8a8a"
MOST_POINTS = 600  # of a line
DIGITS = 5


def line(x, y, name, colour, dash="solid", width=1.6, **more):
    """A line, broken at non-finite values."""
    drawn = {"color": colour, "dash": dash, "width": width}
    return {"type": "scatter", "mode": "lines", "x": numbers(x), "y": numbers(y), "name": name, "line": drawn, **more}


def numbers(values):
    """A list for JSON: five digits, None for non-finite values."""
    return [float(f"{v:.{DIGITS}g}") if np.isfinite(v) else None for v in np.asarray(values, float).tolist()]


def thinned(x, y, most=MOST_POINTS):
    """A line thinned to a maximum number of points; keeps the smallest and largest value of every group."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    if len(x) <= most:
        return x, y
    places = []
    for group in np.array_split(np.arange(len(x)), most // 2):
        known = group[np.isfinite(y[group])]
        places += sorted({int(known[np.argmin(y[known])]), int(known[np.argmax(y[known])])}) if len(known) else [int(group[0])]
    return x[places], y[places]


def axes(x, y, height, **more):
    """A layout: titles, or dicts of an axis, and the height in pixels."""
    x, y = ({"title": axis} if isinstance(axis, str) else axis for axis in (x, y))
    return {"xaxis": x, "yaxis": y, "height": height, **more}


def in_units(picture):
    """A description whose axes of Hz or N/m, and the traces along them, are in the units that are chosen for these."""
    data, layout = [dict(trace) for trace in picture["data"]], dict(picture["layout"])
    for letter, base in itertools.product("xy", ("Hz", "N/m")):
        axis, (factor, unit) = dict(layout[f"{letter}axis"]), column(base)
        title, in_base, sign = axis["title"].partition(f" in {base}")
        if not in_base or unit == base:
            continue
        layout[f"{letter}axis"] = axis | {"title": f"{title} in {unit}{sign}"}
        if "range" in axis:
            layout[f"{letter}axis"]["range"] = [factor * value for value in axis["range"]]
        for trace in data:
            trace[letter] = [None if value is None else float(f"{factor * value:.{DIGITS + 1}g}") for value in trace[letter]]
    return picture | {"data": data, "layout": layout}


def dots(x, y, name, colour, ring=None, size=6, symbol="circle"):
    """Filled circles or other symbols, with a rim of the colour `ring`."""
    marker = {"color": colour, "size": size, "symbol": symbol} | ({"line": {"color": ring, "width": 1.2}} if ring else {})
    return {"type": "scatter", "mode": "markers", "x": numbers(x), "y": numbers(y), "name": name, "marker": marker}


def named_once(data):
    """Traces in which each name appears once in the legend."""
    names = set()
    for trace in data:
        if trace.get("showlegend") is not False and trace["name"] in names:
            trace["showlegend"] = False
        names.add(trace["name"])
    return data


def range_of(along):
    """Limits of an axis along the run (`rsc.show.pictures.abscissa.Abscissa`): half a window more on both sides."""
    low, high = float(along.of_windows.min()), float(along.of_windows.max())
    room = 0.5 * (high - low) / max(len(along.of_windows) - 1, 1) or 0.5
    return [low - room, high + room]


def packed(array):
    """An array of int8 as plotly reads it: base64 with type and shape."""
    text = base64.b64encode(np.ascontiguousarray(array)).decode()
    return {"dtype": "i1", "bdata": text, "shape": ", ".join(map(str, array.shape))}
