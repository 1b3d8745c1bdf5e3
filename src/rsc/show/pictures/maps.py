"""Pictures of sweeps: classes and values over two varied keys, curves over one; arrays in, `matplotlib.figure.Figure` out.

Classes are told apart by lightness as well as by hue, so that neither a colour-blind eye nor a grey printer loses them; cells
without a value are hatched.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rsc.show.pictures.settings import default_settings

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import ArrayLike, NDArray

from rsc.measure.catalogue import Motions
from rsc.measure.kinds import Kind
from rsc.show.pictures.axes import (
    BEHIND,
    HALO,
    PREDICTED,
    RUN_COLOURS,
    TURN,
    as_text,
    cell_edges,
    finish,
    legend_below,
    new_figure,
)
from rsc.show.words.units import column, largest_finite, unit_for
from rsc.show.words.wording import frequency_text, motion_name

# from light, nothing, to dark, worst
DANGER_COLOURS = ("#eeeeee", "#f7d666", "#e8743b", "#6a1b4d")
SEVERITY_COLOURS = ("#eeeeee", "#b9c7d6", "#f7d666", "#e8a13b", "#cf4a2a", "#3d0c33")
# Okabe and Ito's colours, which every kind of colour vision tells apart
CLASS_COLOURS = (
    "#eeeeee", "#56b4e9", "#009e73", "#d55e00", "#cc79a7", "#e69f00", "#f0e442", "#a6a6a6", "#000000", "#ffffff",
    "#bfd98a", "#0072b2", "#7a3b00",
)  # fmt: skip
ABSENT = "no value"
VALUES = matplotlib.colormaps["cividis_r"]
EVEN = 1e-3  # of a ratio: values whose ratios differ by less stand on a logarithmic axis
WIDE = 30.0  # largest over smallest value from which colours are logarithmic
PREFIXED = ("m", "N", "N s", "m/s", "W", "kg")


@dataclass(frozen=True)
class Side:
    """One side of a map: values (n,), rising numbers or words, and its label with the unit."""

    values: NDArray[Any]
    label: str

    @property
    def in_words(self) -> bool:
        """Whether the values are words."""
        return self.values.dtype.kind not in "fiu"

    @property
    def logarithmic(self) -> bool:
        """Whether the numbers rise by equal ratios."""
        if self.in_words or len(self.values) < 3 or not (self.values > 0.0).all():
            return False
        return bool(np.ptp(np.diff(np.log(self.values))) < EVEN)

    @property
    def places(self) -> NDArray[np.float64]:
        """Where the values stand on the axis."""
        return np.arange(len(self.values), dtype=float) if self.in_words else self.values.astype(float)

    def edges(self) -> NDArray[np.float64]:
        """Edges of the cells around the values."""
        return np.exp(cell_edges(np.log(self.places))) if self.logarithmic else cell_edges(self.places)


@default_settings()
def plot_classes(
    x: Side, y: Side, classes: ArrayLike, legend: Sequence[tuple[str, str]], *, title: str,
    lines: Sequence[tuple[str, ArrayLike, ArrayLike]] = (), marked: tuple[str, ArrayLike] | None = None, axes: Axes | None = None,
) -> Figure:  # fmt: skip
    """A map of classes.

    Parameters
    ----------
    x, y : Side
    classes : (n_y, n_x) int, places in `legend`; negative where there is none
    legend : sequence of (word, colour), of every class
    title : str
    lines : sequence of (name, x (n,), y (n,)), drawn over the map
    marked : (name, (n_y, n_x) bool), cells that have a cross over their class
    axes : of another figure, by default those of a new one

    Returns
    -------
    matplotlib.figure.Figure
        Its legend tells the share of the cells of every class that occurs, and of the marked ones.
    """
    owner, axes = _ground(axes, 7.5, 6.0)
    cells = np.ma.masked_less(np.asarray(classes), 0)
    norm = BoundaryNorm(np.arange(len(legend) + 1) - 0.5, len(legend))
    _cells(axes, x, y, cells, cmap=ListedColormap([colour for _, colour in legend]), norm=norm)
    for i, (word, colour) in enumerate(legend):
        share = float(np.mean(np.asarray(classes) == i))
        if share:
            axes.fill_between([], [], [], facecolor=colour, edgecolor="0.5", linewidth=0.5, label=f"{word} ({_percent(share)})")
    _tell_absent(axes, cells)
    if marked is not None:
        _cross(axes, x, y, *marked)
    for i, (name, line_x, line_y) in enumerate(lines):
        axes.plot(line_x, line_y, color="black", linestyle=("--", ":", "-.")[i % 3], linewidth=1.6, path_effects=HALO, label=name)
    finish(owner, axes, title)
    return owner.figure


@default_settings()
def plot_values(
    x: Side, y: Side, values: ArrayLike, *, quantity: str, unit: str, title: str, axes: Axes | None = None
) -> Figure:
    """A map of one quantity, darker where larger, with contour lines on round values; where it differs by decades, which it does
    in jumps, the colours are logarithmic and there are no lines.

    Parameters
    ----------
    x, y : Side
    values : (n_y, n_x) float in SI, NaN where there is none
    quantity, unit : str, for the colour bar
    title : str
    axes : of another figure, by default those of a new one

    Returns
    -------
    matplotlib.figure.Figure
    """
    owner, axes = _ground(axes, 8.0, 6.0)
    factor, name = scaled(values, unit)
    cells = np.ma.masked_invalid(factor * np.asarray(values, float))
    jumps = cells.count() > 0 and cells.min() > 0.0 and cells.max() > WIDE * cells.min()
    image = _cells(axes, x, y, cells, cmap=VALUES, norm=LogNorm() if jumps else None)
    bar = axes.figure.colorbar(image, ax=axes, pad=0.02, format=lambda value, place: f"{value:g}")
    bar.set_label(f"{quantity} in {name}" if name else quantity)
    smooth = not jumps and cells.count() > 3 and min(cells.shape) > 2 and np.ptp(cells.compressed()) > 0.0
    if smooth and not (x.in_words or y.in_words):
        lines = axes.contour(x.places, y.places, cells, levels=6, colors="black", linewidths=0.8)
        lines.set(path_effects=BEHIND)
        bar.add_lines(lines)
        for text in axes.clabel(lines, fontsize=8, fmt="%g"):
            text.set(path_effects=HALO)
    _tell_absent(axes, cells)
    finish(owner, axes, title)
    return owner.figure


@default_settings()
def plot_starts(listed: Motions, *, title: str) -> Figure:
    """Random impacts on a running rotor, coloured by the motion in which each ends.

    Parameters
    ----------
    listed : rsc.measure.catalogue.Motions
    title : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    places = listed.largest_at or {"": listed.largest}
    figure, axes = new_figure(max(6.4, 4.6 * len(places)), 6.6 if len(places) == 1 else 5.8, columns=len(places))
    for i, (name, largest) in enumerate(places.items()):
        own = np.ravel(axes)[i]
        impacts(own, listed, slice(i, None, len(places)), largest)
        if name:
            own.set_title(f"at {as_text(name)}")
    title = f"{title}\nimpacts at {frequency_text(listed.speed, '.4g')} and the motions they start".strip()
    if listed.largest_at:
        figure.suptitle(as_text(title), wrap=True)
        labels = {label: handle for own in axes for handle, label in zip(*own.get_legend_handles_labels(), strict=True)}
        legend_below(figure, list(labels.values()), list(labels))
    else:
        finish(figure, axes, title)
    return figure


def impacts(axes: Axes, listed: Motions, part: slice, largest: float) -> None:
    """The random impacts at one contact, every so manieth of all, into axes."""
    factor, unit = unit_for(largest, "N s")
    impact, ended = factor * listed.impulse[part], listed.ended[part]
    for i, motion in enumerate(listed.motions):
        own = ended == i
        rate = "" if np.isnan(motion.frequency) else f", {frequency_text(motion.frequency, '.4g')}"
        if own.any():
            colour = CLASS_COLOURS[list(Kind).index(Kind(motion.motion))]
            label = f"{motion_name(motion)}{rate} ({100.0 * motion.share:.0f} %)"
            axes.plot(*impact[own].T, "osD^vP*"[i % 7], color=colour, markeredgecolor="black", markeredgewidth=0.5, label=label)
    if (ended < 0).any():
        axes.plot(*impact[ended < 0].T, "x", color="0.4", label="had not settled")
    circle = factor * largest * TURN
    axes.plot(circle.real, circle.imag, color="0.6", linewidth=0.8, linestyle="--", label="largest impulse")
    axes.set(aspect="equal", xlabel=f"impact in y in {unit}", ylabel=f"impact in z in {unit}")
    axes.grid(color="0.92", linewidth=0.6)


@dataclass(frozen=True)
class Curve:
    """Values over the abscissa: (n,), or (n, k) of k at every place; NaN where there is none.

    style : "line", "stable", "unstable" (predictions: filled and open circles), "dots" (simulated) or "bars" (values (n, 3):
        from, middle, to); name : str, for the legend
    """

    name: str
    values: ArrayLike
    style: str = "line"


@dataclass(frozen=True)
class Panel:
    """One quantity over the abscissa, from 0 to 1 if it is a share."""

    quantity: str
    unit: str
    curves: Sequence[Curve]
    share: bool = False

    @property
    def name(self) -> str:
        """The quantity as the name of a picture."""
        return self.quantity.replace(" ", "_")


STYLES: dict[str, dict[str, Any]] = {
    "line": {"linestyle": "-", "linewidth": 1.3},
    "stable": {"linestyle": "none", "marker": "o", "markersize": 4, "color": PREDICTED, "markeredgewidth": 0.8},
    "unstable": {"linestyle": "none", "marker": "o", "markersize": 4, "color": PREDICTED, "markerfacecolor": "white",
                 "markeredgewidth": 0.8},
    "dots": {"linestyle": "none", "marker": "x", "markersize": 5, "color": "black"},
    "bars": {"linestyle": "none", "marker": "o", "markersize": 3, "color": PREDICTED, "capsize": 2},
}  # fmt: skip


@default_settings()
def plot_panels(x: Side, panels: Sequence[Panel], *, title: str, axes: Axes | None = None) -> Figure:
    """Quantities over one varied key, one panel above the other.

    Parameters
    ----------
    x : Side
    panels : sequence of Panel
    title : str
    axes : of another figure, for a single panel, by default those of a new one

    Returns
    -------
    matplotlib.figure.Figure
    """
    owner, every = _ground(axes, 7.5, 1.2 + 2.0 * len(panels), len(panels))
    every = np.atleast_1d(every)
    for axes, panel in zip(every, panels, strict=True):
        factor, name = scaled(np.concatenate([np.ravel(curve.values) for curve in panel.curves]), panel.unit)
        for i, curve in enumerate(panel.curves):
            style = {"color": RUN_COLOURS[i % len(RUN_COLOURS)]} | STYLES[curve.style]
            values = factor * np.asarray(curve.values, float)
            if curve.style == "bars":
                low, middle, high = values.T
                axes.errorbar(x.places, middle, yerr=[middle - low, high - middle], label=curve.name, **style)
                continue
            drawn = axes.plot(x.places, values, **style)
            drawn[0].set_label(curve.name)
        axes.set_ylabel(f"{panel.quantity}\nin {name}" if name else panel.quantity)
        axes.grid(color="0.92", linewidth=0.6)
        if panel.share:
            axes.set_ylim(-0.05, 1.05)
        _side(axes, x, None)
    every[-1].set_xlabel(as_text(x.label))
    handles = {label: handle for own in every for handle, label in zip(*own.get_legend_handles_labels(), strict=True)}
    legend_below(owner, [*handles.values()], [*handles])
    every[0].set_title(as_text(title), wrap=True)
    owner.figure.align_ylabels(every)
    return owner.figure


def _ground(axes: Axes | None, width: float, height: float, rows: int = 1) -> tuple[Any, Any]:
    """What gets the legend, and the axes: those that are given, or a new figure and its own."""
    return (axes, axes) if axes is not None else new_figure(width, height, rows=rows)


def scaled(values: ArrayLike, unit: str) -> tuple[float, str]:
    """Factor and unit in which values read well; "" for numbers without unit."""
    if unit == "Hz":
        return column(unit)
    if unit in PREFIXED:
        return unit_for(largest_finite(np.abs(np.asarray(values, float))), unit)
    return 1.0, "" if unit == "1" else unit


def _cells(axes: Axes, x: Side, y: Side, cells: Any, **how: Any) -> Any:
    """The cells of a map on a hatched ground."""
    axes.set_facecolor("white")
    axes.patch.set(hatch="////", edgecolor="0.75")
    image = axes.pcolormesh(x.edges(), y.edges(), cells, rasterized=True, **how)
    _side(axes, x, y)
    axes.set(xlabel=as_text(x.label), ylabel=as_text(y.label))
    return image


def _side(axes: Axes, x: Side, y: Side | None) -> None:
    """Scales and ticks of the axes."""
    for side, axis in ((x, axes.xaxis), (y, axes.yaxis)):
        if side is None:
            continue
        if side.logarithmic:
            (axes.set_xscale if axis is axes.xaxis else axes.set_yscale)("log")
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(lambda value, place: f"{value:g}")
            axis.set_minor_formatter(NullFormatter())
        elif side.in_words:
            axis.set_ticks(side.places, [as_text(str(word)) for word in side.values])


def _tell_absent(axes: Axes, cells: Any) -> None:
    if np.ma.getmaskarray(cells).any():
        share = float(np.ma.getmaskarray(cells).mean())
        axes.fill_between([], [], [], facecolor="white", edgecolor="0.75", hatch="////", label=f"{ABSENT} ({_percent(share)})")


def _cross(axes: Axes, x: Side, y: Side, name: str, marked: ArrayLike) -> None:
    """Crosses over the cells of a map that are marked, and their share in its legend."""
    rows, columns = np.nonzero(np.asarray(marked))
    if len(rows):
        label = as_text(f"{name} ({_percent(len(rows) / np.size(marked))})")
        size = float(np.clip(200.0 / max(np.shape(marked)), 1.0, 5.0))  # points: about half a cell
        axes.plot(x.places[columns], y.places[rows], "x", color="black", markersize=size, markeredgewidth=0.2 * size, label=label)


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %" if share >= 0.01 else "less than 1 %"
