"""Pictures by matplotlib: figures of the descriptions that `pictures` and `paths` beside it make, as the page has them.

Figures are made by the object interface on an Agg canvas, never by pyplot: no display, no global state, safe in threads.
"""

import io
import os
import textwrap
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rsc.show.pictures.settings import default_settings

import numpy as np
from matplotlib import colormaps
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cbook import normalize_kwargs
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from PIL import Image

from rsc.errors import DataError
from rsc.files.mark import PICTURES
from rsc.files.output import OutputFile, put_all, target
from rsc.show.pictures.axes import HALO, ROUND_STEPS, as_text, legend_below, new_figure

MORE: dict[str, dict[str, Any]] = {
    ".png": {"pil_kwargs": {"compress_level": 1}},  # of 1 to 9: a little larger than with more, in half of the time
    ".pdf": {"metadata": {"CreationDate": None}},  # else no two files are the same
    ".svg": {"metadata": {"Date": None}},
}
PIXELS = 85.0  # of a description in an inch of a figure
POINTS = 0.75  # of a line in a pixel of its description
COLUMNS = 3  # of paths side by side
CHARACTERS = 9.0  # of the name of an axis that fit into an inch
FRAME_MS = 60
STYLES = {"solid": "-", "dash": "--", "dot": ":", "dashdot": "-."}
SYMBOLS = {
    "circle": "o", "square": "s", "diamond": "D", "triangle-up": "^", "triangle-down": "v", "triangle-left": "<",
    "triangle-right": ">", "cross": "P", "x": "x",
}  # fmt: skip
SIDES: dict[str, dict[str, Any]] = {  # of a text from its point
    "top left": {"xytext": (-4, 3), "ha": "right"},
    "top right": {"xytext": (4, 3), "ha": "left"},
    "bottom left": {"xytext": (-4, -3), "ha": "right", "va": "top"},
    "bottom right": {"xytext": (4, -3), "ha": "left", "va": "top"},
    "middle center": {"xytext": (0, 0), "ha": "center", "va": "center"},
}
NO_DATA = "#fff3b0"
DRAWN = ("scatter", "heatmap", "bar")

Picture = dict[str, Any]  # "data": traces, "layout": axes; `rsc.show.pictures.traces`


@default_settings()
def stacked(pictures: Sequence[Picture], title: str, share: float = 1.0) -> Figure:
    """Pictures above each other over one abscissa, each of its height times `share`."""
    heights = [share * picture["layout"]["height"] / PIXELS for picture in pictures]
    figure, axes = new_figure(8.5, sum(heights) + 1.1, rows=len(pictures))
    every = np.atleast_1d(axes)
    for own, picture, height in zip(every, pictures, heights, strict=True):
        draw(own, picture)
        own.set_ylabel(_broken(own.get_ylabel(), int(CHARACTERS * height)))
        if own is not every[-1]:
            own.set_xlabel("")
    every[0].set_title(as_text(title), wrap=True)  # long titles break at the edges of the figure
    figure.align_ylabels(every)
    _legend(figure)
    return figure


@default_settings()
def side_by_side(panels: Sequence[tuple[str, Picture]], title: str) -> Figure:
    """(caption, picture) of paths in rows of three."""
    columns = min(len(panels), COLUMNS)
    rows = -(-len(panels) // columns)
    figure, grid = new_figure(3.2 * columns, 3.3 * rows + 1.2, rows=rows, columns=columns)
    for i, axes in enumerate(np.ravel(grid)):
        axes.set_visible(i < len(panels))
        if i < len(panels):
            draw(axes, panels[i][1])
            axes.set_title("\n".join(textwrap.wrap(as_text(panels[i][0]), 34)), fontsize=9)
            axes.tick_params(labelsize=8)
            if i + columns < len(panels):
                axes.set_xlabel("")
            if i % columns:
                axes.set_ylabel("")
    figure.suptitle(as_text(title), fontsize=11, wrap=True)
    _legend(figure)
    return figure


@default_settings()
def film(pictures: Iterable[Picture], title: str, reach: float) -> bytes:
    """The bytes of a GIF that shows paths one after the other on axes that reach from -reach to reach."""
    figure, axes = _screen(title)
    canvas = FigureCanvasAgg(figure)
    images = []
    for picture in pictures:
        _frame(axes, picture, reach)
        canvas.draw()
        pixels = np.asarray(canvas.buffer_rgba())[..., :3].copy()
        images.append(Image.fromarray(pixels).quantize(64, dither=Image.Dither.NONE))
    content = io.BytesIO()
    images[0].save(content, "GIF", save_all=True, append_images=images[1:], duration=FRAME_MS, loop=0)
    return content.getvalue()


class Film(FuncAnimation):
    """Paths one after the other on axes that reach from -reach to reach; plays in a notebook."""

    @default_settings()
    def __init__(self, pictures: Sequence[Picture], title: str, reach: float) -> None:
        figure, axes = _screen(title)
        shown = partial(_frame, axes, reach=reach)
        super().__init__(figure, shown, frames=pictures, interval=FRAME_MS, cache_frame_data=False)

    @default_settings()
    def _repr_html_(self) -> str:
        return self.to_jshtml()


def _screen(title: str) -> tuple[Figure, Axes]:
    """Figure and axes of a film."""
    figure, axes = new_figure(4.8, 5.1)
    figure.set_dpi(100)
    figure.suptitle(as_text(title), fontsize=9, wrap=True)
    return figure, axes


def _frame(axes: Axes, picture: Picture, reach: float) -> None:
    """One picture of a film."""
    axes.clear()
    draw(axes, picture)
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach))


def draw(axes: Axes, picture: Picture, style: dict[str, Any] | None = None) -> None:
    """The traces of a description on axes, in their order, and its names and limits.

    style : properties of lines of matplotlib that all lines and dots get in the place of their own; of a heat map those of images
    """
    style = normalize_kwargs(style or {}, Line2D)
    layout, heated = picture["layout"], any(trace["type"] == "heatmap" for trace in picture["data"])
    if not heated:
        axes.grid(color="0.92", linewidth=0.6)
    axes.set_axisbelow(True)
    for i, trace in enumerate(picture["data"]):
        if trace["type"] not in DRAWN:
            raise ValueError(f"a PNG shows traces of type {', '.join(DRAWN)}, not {trace['type']!r}")
        if trace["type"] == "heatmap":
            _levels(axes, trace, style)
        elif trace["type"] == "bar":
            axes.bar(trace["x"], trace["y"], color=trace["marker"]["color"], zorder=2.0)
        else:
            _curve(axes, trace, 2.0 + 0.01 * i, {} if heated else style)
    equal, many = layout.get("equal"), max(4, layout["height"] // 50)
    for name, axis, most in (("x", axes.xaxis, 8), ("y", axes.yaxis, many)):
        own = layout[f"{name}axis"]
        axis.set_label_text(as_text(own["title"]))
        if own.get("type") == "log":
            axes.set(**{f"{name}scale": "log"})
        else:
            axis.set_major_locator(MaxNLocator(5 if equal else most, steps=ROUND_STEPS))
        if "tickvals" in own:
            axis.set_ticks(own["tickvals"], own["ticktext"], fontsize=8)
        low, high = axis.get_view_interval()
        if "range" in own:
            axes.set(**{f"{name}lim": own["range"]})
        elif own.get("rangemode") == "tozero":
            axes.set(**{f"{name}lim": (min(low, 0.0), max(high, 0.0))})
    if equal:
        axes.set_aspect("equal", adjustable="datalim")


def _broken(name: str, most: int) -> str:
    """The name of an axis, wrapped, with its unit on a separate line."""
    if len(name) <= most:
        return name
    quantity, _, unit = name.rpartition(" in ")
    return "\n".join([*textwrap.wrap(quantity, most), f"in {unit}"])


def _curve(axes: Axes, trace: dict[str, Any], zorder: float, style: dict[str, Any]) -> None:
    """A line, an area, dots and texts, whatever of them a trace has."""
    x, y = (np.array(trace[name], float) for name in "xy")
    label = None if trace.get("showlegend") is False else as_text(trace["name"])
    if trace.get("fill"):
        axes.fill(x, y, facecolor=trace["fillcolor"], linewidth=0.0, zorder=zorder)
    if "lines" in trace["mode"] and trace["line"]["width"]:
        line = trace["line"]
        own = {"color": line["color"], "linestyle": STYLES[line["dash"]], "linewidth": POINTS * line["width"], "label": label}
        axes.plot(x, y, **{**own, "zorder": zorder, **style})
    if "markers" in trace["mode"]:
        marker = trace["marker"]
        ring, shape = marker.get("line", {}).get("color", "none"), SYMBOLS[marker["symbol"]]
        size, colours = POINTS * marker["size"], {"markerfacecolor": marker["color"], "markeredgecolor": ring}
        own = {"marker": shape, "markersize": size, "label": label, "zorder": zorder} | colours
        axes.plot(x, y, **{**own, **style, "linestyle": "none"})
    side: dict[str, Any] = {"textcoords": "offset points", **SIDES[trace.get("textposition", "top right")]}
    for i, text in enumerate(trace.get("text", ())):
        if text:
            axes.annotate(as_text(text), (x[i], y[i]), fontsize=9, path_effects=HALO, zorder=zorder + 5.0, **side)


def _levels(axes: Axes, trace: dict[str, Any], style: dict[str, Any]) -> None:
    """Amplitudes in dB as a grey picture with its colour bar; windows without finite data in yellow."""
    x, y, levels = trace["x"], trace["y"], trace["levels"]
    room = [0.5 * (ends[-1] - ends[0]) / max(count - 1, 1) for ends, count in zip((x, y), levels.shape[::-1], strict=True)]
    extent = (x[0] - room[0], x[-1] + room[0], y[0] - (room[1] or 0.5), y[-1] + (room[1] or 0.5))
    decibels = np.ma.masked_invalid(trace["zmin"] * (1.0 - levels))
    grey = colormaps["Greys"].with_extremes(bad=NO_DATA)
    limits = {"vmin": trace["zmin"], "vmax": trace["zmax"]}
    own = {"aspect": "auto", "origin": "lower", "cmap": grey, "interpolation": "none"}
    image = axes.imshow(decibels, extent=extent, **{**own, **limits, **style})
    figure = axes.get_figure()
    assert figure is not None
    bar = figure.colorbar(image, ax=axes, extend="min", pad=0.02)
    bar.set_label(f"amplitude in {trace['colorbar']['title']['text']} (largest shown)")
    if decibels.mask.any():
        axes.fill_between([], [], [], facecolor=NO_DATA, label="no finite data")


def _legend(figure: Figure) -> None:
    """A legend of all axes below them, each name once."""
    named = {text: handle for axes in figure.axes for handle, text in zip(*axes.get_legend_handles_labels(), strict=True)}
    if named:
        legend_below(figure, list(named.values()), list(named))


def save(figure: Figure, path: str | os.PathLike[str], overwrite: bool = False) -> None:
    """Write a figure; the ending of `path` (png, pdf, svg) chooses the format.

    overwrite : bool, also in the place of a file that rsc did not write, or that was changed since

    Raises
    ------
    DataError
        If the ending is unknown or the file cannot be written, for example because such a file has this name.
    """
    put_all([picture_file(figure, path)], overwrite)


def picture_target(path: str | os.PathLike[str], overwrite: bool = False) -> Path:
    """The path, if a picture may be written there; errors as `save`."""
    return target(path, PICTURES[_ending(path)], overwrite)


@default_settings()
def picture_file(figure: Figure, path: str | os.PathLike[str]) -> OutputFile:
    """The file of a figure, to be written by `rsc.files.output.put_all`; DataError for an unknown ending."""
    ending = _ending(path)
    if (engine := figure.get_layout_engine()) is not None:  # laid out once: savefig would do it twice, and draw for that
        engine.execute(figure)
        figure.set_layout_engine(None)
    content = io.BytesIO()
    figure.savefig(content, format=ending[1:], **MORE.get(ending, {}))
    return OutputFile(Path(path), content.getvalue(), PICTURES[ending])


def _ending(path: str | os.PathLike[str]) -> str:
    ending = Path(path).suffix.lower()
    if ending not in PICTURES:
        raise DataError(path, f"picture not written: its name must end with {', '.join(PICTURES)}")
    return ending
