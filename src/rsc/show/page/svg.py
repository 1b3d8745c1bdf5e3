"""A picture of the page on paper and without script: the same description that plotly draws, as an SVG."""

import base64
import struct
import zlib
from html import escape

import numpy as np

WIDTH = 720
LEFT, RIGHT, TOP, BOTTOM = 62, 12, 14, 44
DASHES = {"dash": "60 40", "dot": "20 30", "dashdot": "70 30 20 30"}  # tenths of a pixel
LEGEND_ROW, LETTER = 17, 6.3
# of a text from its point, in pixels
SIDES = {
    "top left": (-4, -4, ' text-anchor="end"'), "top right": (4, -4, ""), "bottom left": (-4, 12, ' text-anchor="end"'),
    "bottom right": (4, 12, ""), "middle center": (0, 4, ' text-anchor="middle"'),
}  # fmt: skip


def svg(picture, label):
    """The SVG of a picture.

    Parameters
    ----------
    picture : dict
        "data": traces, "layout": axes, "height", as `rsc.show.pictures.pictures` makes them.
    label : str
        What a screen reader says.
    """
    data, layout = picture["data"], picture["layout"]
    width = layout.get("width", WIDTH)
    legend, rows = _legend(data, layout["height"], width) if not layout.get("equal") else ("", 0)
    box = LEFT, TOP, width - LEFT - RIGHT, layout["height"] - TOP - BOTTOM
    x, y = (_limits(data, layout[f"{name}axis"], name) for name in "xy")
    if layout.get("equal"):
        x, y, box = _equal(x, y, box)
    scale = _Scale(x, y, box)
    size = layout["height"] + LEGEND_ROW * rows
    parts = [f'<svg class="static" viewBox="0 0 {width} {size}" role="img" aria-label="{escape(label, quote=True)}">']
    parts.append(_frame(scale, layout))
    inner = "".join(_trace(trace, scale) for trace in data)
    clip = f"clip-{zlib.crc32(inner.encode()):08x}"
    parts.append(f'<clipPath id="{clip}"><rect x="{box[0]}" y="{box[1]}" width="{box[2]:.1f}" height="{box[3]:.1f}"/></clipPath>')
    parts.append(f'<g clip-path="url(#{clip})">{inner}</g>{legend}</svg>')
    return "".join(parts)


class _Scale:
    """Pixels of values in a box (left, top, width, height)."""

    def __init__(self, x, y, box):
        self.x_limits, self.y_limits, self.box = x, y, box

    def x(self, values):
        low, high = self.x_limits
        return self.box[0] + (np.asarray(values, float) - low) / (high - low) * self.box[2]

    def y(self, values):
        low, high = self.y_limits
        return self.box[1] + self.box[3] - (np.asarray(values, float) - low) / (high - low) * self.box[3]


def _limits(data, axis, name):
    """(low, high) of an axis: its range, or that of all values."""
    if "range" in axis:
        return axis["range"]
    values = [np.array(trace[name], float) for trace in data if len(trace[name])]
    values = np.concatenate(values) if values else np.array([0.0])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
    low = min(low, 0.0) if axis.get("rangemode") == "tozero" else low
    room = 0.04 * ((high - low) or abs(high) or 1.0)
    return low - room if low or axis.get("rangemode") != "tozero" else low, high + room


def _equal(x, y, box):
    """Limits and box in which a unit is as long on both axes."""
    half = 0.5 * max(x[1] - x[0], y[1] - y[0])
    x, y = ((0.5 * (low + high) - half, 0.5 * (low + high) + half) for low, high in (x, y))
    side = min(box[2:])
    return x, y, (*box[:2], side, side)


def ticks(low, high, most=7):
    """Round values between two limits, about `most` of them."""
    step = (high - low) / most
    power = 10.0 ** np.floor(np.log10(step))
    step = power * next(round_ for round_ in (1, 2, 2.5, 5, 10) if round_ * power >= step * (1 - 1e-9))
    return step * np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1)


def _frame(scale, layout):
    left, top, width, height = scale.box
    parts = []
    named = layout["xaxis"].get("tickvals")  # places with names have no lines
    values = ticks(*scale.x_limits, most=8) if named is None else named
    names = layout["xaxis"].get("ticktext") or [_number(value) for value in values]
    for value, name in zip(values, names, strict=True):
        x = float(scale.x(value))
        parts.append(f'<path class="grid" d="M{x:.1f} {top}v{height:.1f}"/>' if named is None else "")
        parts.append(f'<text x="{x:.1f}" y="{top + height + 15:.1f}" text-anchor="middle">{escape(name)}</text>')
    for value in ticks(*scale.y_limits, most=max(3, int(height / 45))):
        y = float(scale.y(value))
        parts.append(f'<path class="grid" d="M{left} {y:.1f}h{width:.1f}"/>')
        parts.append(f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">{_number(value)}</text>')
    parts.append(f'<rect class="frame" x="{left}" y="{top}" width="{width:.1f}" height="{height:.1f}"/>')
    x_title, y_title = (escape(layout[f"{name}axis"]["title"]) for name in "xy")
    parts.append(f'<text x="{left + width / 2:.0f}" y="{top + height + 33:.0f}" text-anchor="middle">{x_title}</text>')
    middle = top + height / 2
    parts.append(f'<text transform="translate(14 {middle:.0f}) rotate(-90)" text-anchor="middle">{y_title}</text>')
    return "".join(parts)


def _number(value):
    return f"{value + 0.0:.6g}".replace("-", "\N{MINUS SIGN}")


def _trace(trace, scale):
    if trace["type"] == "heatmap":
        return _image(trace, scale)
    if trace["type"] == "bar":
        return _bars(trace, scale)
    if trace["type"] != "scatter":
        raise ValueError(f"the page shows traces of type scatter, heatmap and bar, not {trace['type']!r}")
    x, y = scale.x(trace["x"]), scale.y(trace["y"])
    parts = []
    if "lines" in trace["mode"] or trace.get("fill"):
        parts.append(_line(trace, x, y))
    if "markers" in trace["mode"]:
        parts.append(_dots(trace["marker"], x, y))
    if "text" in trace["mode"]:
        right, down, anchor = SIDES[trace["textposition"]]
        for px, py, text in zip(x, y, trace["text"], strict=True):
            place = f'x="{px + right:.1f}" y="{py + down:.1f}"{anchor}'
            parts.append(f"<text {place}>{escape(text)}</text>" if text else "")
    return "".join(parts)


def _tenths(x, y):
    """Points in tenths of a pixel, as complex whole numbers."""
    return np.round(10.0 * np.asarray(x)) + 1j * np.round(10.0 * np.asarray(y))


def _corners(points):
    """Points of a line without those that the line through the others meets within half a tenth of a pixel."""
    keep, spans = {0, len(points) - 1}, [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        away, along = points[first + 1 : last] - points[first], points[last] - points[first]
        if len(away):
            share = np.clip((away * along.conjugate()).real / abs(along) ** 2, 0.0, 1.0) if along else 0.0
            distance = np.abs(away - share * along)
            farthest = int(distance.argmax())
            if distance[farthest] > 0.5:
                middle = first + 1 + farthest
                keep.add(middle)
                spans += [(first, middle), (middle, last)]
    return points[sorted(keep)]


def _steps(points, end=""):
    """The coordinates of a path: first point, then relative steps, each followed by `end`."""
    words = [f"{int(step.real)} {int(step.imag)}{end}" for step in np.diff(points, prepend=0.0).tolist()]
    letter = "m" if end else "l"
    return ("M" + words[0] + (letter + (letter if end else " ").join(words[1:]) if words[1:] else "")).replace(" -", "-")


def _path(words, fill, colour="", width=0.0, more=""):
    """A path in tenths of a pixel."""
    stroke = f' stroke="{colour}" stroke-width="{10 * width:g}"' if colour else ""
    return f'<path d="{words}" fill="{fill}"{stroke}{more} transform="scale(.1)"/>'


def _dots(marker, x, y):
    """Circles with a rim; without one all dots as one path, of lines without length and with round ends, which is shorter."""
    known = np.isfinite(x) & np.isfinite(y)
    size, colour = marker["size"], marker["color"]
    if "line" in marker:
        ring = f'r="{0.5 * size}" fill="{colour}" stroke="{marker["line"]["color"]}"'
        return "".join(f'<circle cx="{px:.1f}" cy="{py:.1f}" {ring}/>' for px, py in zip(x[known], y[known], strict=True))
    if not known.any():
        return ""
    return _path(_steps(_tenths(x[known], y[known]), end="h0"), "none", colour, size, ' stroke-linecap="round"')


def _line(trace, x, y):
    """The path of a line, broken where it has no value; or the area that it encloses."""
    known = np.isfinite(x) & np.isfinite(y)
    edges = np.flatnonzero(np.diff(known.astype(int))) + 1
    pieces = [part for part in np.split(np.arange(len(x)), edges) if len(part) and known[part[0]]]
    words = "".join(_steps(_corners(_tenths(x[piece], y[piece]))) for piece in pieces)
    line, area = trace["line"], trace["fillcolor"] if trace.get("fill") else "none"
    if not line.get("width", 1.5):
        return _path(words, area)
    dash = f' stroke-dasharray="{DASHES[line["dash"]]}"' if line.get("dash", "solid") != "solid" else ""
    return _path(words, area, line["color"], line.get("width", 1.5), dash)


def _bars(trace, scale):
    zero, parts = float(scale.y(0.0)), []
    for x, y, colour in zip(scale.x(trace["x"]), scale.y(trace["y"]), trace["marker"]["color"], strict=True):
        parts.append(f'<rect x="{x - 18:.1f}" y="{min(y, zero):.1f}" width="36" height="{abs(y - zero):.1f}" fill="{colour}"/>')
    return "".join(parts)


def _image(trace, scale):
    """The amplitudes as an image in shades of the colour of the text."""
    level = np.nan_to_num(trace["levels"])
    x0, x1 = scale.x([trace["x"][0], trace["x"][-1]])
    y0, y1 = scale.y([trace["y"][0], trace["y"][-1]])
    data = base64.b64encode(_png(level[::-1] if y1 < y0 else level)).decode()
    place = f'x="{min(x0, x1):.1f}" y="{min(y0, y1):.1f}" width="{abs(x1 - x0):.1f}" height="{abs(y1 - y0):.1f}"'
    return f'<image class="levels" {place} preserveAspectRatio="none" href="data:image/png;base64,{data}"/>'


def _png(level):
    """A PNG of levels 0 to 1 (rows, columns): black with that opacity."""
    rows, columns = level.shape
    pixels = np.zeros((rows, columns, 2), dtype=np.uint8)
    pixels[..., 1] = np.round(15 * level) * 17
    lines = np.zeros((rows, 1 + 2 * columns), dtype=np.uint8)
    lines[:, 1:] = pixels.reshape(rows, -1)
    head = struct.pack(">IIBBBBB", columns, rows, 8, 4, 0, 0, 0)
    parts = (b"IHDR", head), (b"IDAT", zlib.compress(lines.tobytes(), 6)), (b"IEND", b"")
    chunks = (struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body)) for name, body in parts)
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def _legend(data, top, right):
    """Text of the legend below the picture, and its number of rows."""
    entries, x, row = [], LEFT, 0
    for trace in data:
        if not trace.get("name") or trace.get("showlegend") is False:
            continue
        width = 34 + LETTER * len(trace["name"])
        if x + width > right and x > LEFT:
            x, row = LEFT, row + 1
        y = top + 8 + LEGEND_ROW * row
        entries.append(f'{_sample(trace, x, y)}<text x="{x + 27}" y="{y + 4}">{escape(trace["name"])}</text>')
        x += width
    return "".join(entries), row + 1 if entries else 0


def _sample(trace, x, y):
    if trace.get("fill"):
        return f'<rect x="{x}" y="{y - 5}" width="22" height="10" fill="{trace["fillcolor"]}"/>'
    if trace["mode"] == "markers":
        colour = trace["marker"]["color"]
        ring = f' stroke="{trace["marker"]["line"]["color"]}"' if "line" in trace["marker"] else ""
        return f'<circle cx="{x + 11}" cy="{y}" r="4" fill="{colour}"{ring}/>'
    return _line({**trace, "fill": None}, np.array([x, x + 22.0]), np.array([y, float(y)]))
