"""Parts of the pictures: axes, units, thinning, order lines, branches, legends."""

import math

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import Normal, Stroke, withStroke

from rsc.errors import DataError
from rsc.show.stability import parts
from rsc.show.units import largest_finite, unit_for

DYNAMIC_RANGE_DB = 60.0
DPI = 150
# fewer cells than an axes has pixels at DPI: the renderer would drop parts of narrower ones
MAX_COLUMNS, MAX_ROWS = 800, 500
MAX_POINTS = 4000
MAX_STACKED = 50
STACK_HEIGHT = 0.2  # of the vertical axis, for the largest amplitude
TURN = np.exp(2j * np.pi * np.arange(181) / 180)  # a circle
CHARACTERS = 15.0  # of a legend that fit into an inch

PREDICTED = "tab:red"
COUPLING_COLOURS = {"coupled": "tab:green", "uncoupled": "tab:purple"}
RUN_COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:brown", "tab:cyan", "tab:pink")
HALO = (withStroke(linewidth=2.5, foreground="white"),)
# a light rim that keeps a coloured line readable on a dark picture
BEHIND = (Stroke(linewidth=1.9, foreground="white", alpha=0.6), Normal())
STYLES = {"stable": "-", "unstable": "--", "no circle: nothing claimed": ":"}
ORDERS = (-2, -1, 1, 2)
ROUND_STEPS = (1, 2, 2.5, 5, 10)
FREQUENCY_LABEL = "whirl frequency in Hz   (backward < 0 < forward)"


class Rows:
    """The vertical axis of a waterfall: speed where it runs one way only, otherwise time."""

    def __init__(self, fall):
        steps = np.diff(fall.speed)
        least = 1e-9 * max(largest_finite(np.abs(fall.speed)), 1e-300)
        self.speed_of_rows, self.time = fall.speed, fall.time
        self.by_speed = bool((steps > least).all() or (steps < -least).all())
        values = fall.speed if self.by_speed else fall.time
        self.order = np.argsort(values)
        self.edges = cell_edges(values[self.order])
        self.limits = (self.edges[0], self.edges[-1])
        self.label = "rotor speed in Hz" if self.by_speed else "time in s"

    def curve(self, speed, value):
        """x and y of a curve value(speed) in the picture; NaN at instants whose speed the curve does not reach."""
        speed, value = np.asarray(speed, float), np.asarray(value, float)
        if self.by_speed:
            return value, speed
        if not speed.size:
            return np.full(self.time.size, np.nan), self.time
        order = np.argsort(speed)
        speeds = self.speed_of_rows
        slack = 1e-9 * largest_finite(np.abs(speed))
        inside = (speeds >= speed[order[0]] - slack) & (speeds <= speed[order[-1]] + slack)
        return np.where(inside, np.interp(speeds, speed[order], value[order]), np.nan), self.time


def new_figure(width, height, rows=1):
    figure = Figure(figsize=(width, height), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, 1, sharex=True)
    return figure, axes


def as_text(title):
    """A title of the user in which matplotlib looks for no mathematics."""
    return title.replace("$", r"\$")


def finish(figure, axes, title, pad=8):
    """Title, and a legend below the axes where it can hide nothing."""
    axes.set_title(as_text(title), pad=pad, wrap=True)  # long titles break at the edges of the figure
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        legend_below(figure, handles, labels)


def legend_below(figure, handles, labels):
    """A legend below everything, of as many columns up to three as its longest label leaves room for."""
    room = CHARACTERS * figure.get_figwidth() / (max(map(len, labels)) + 8)
    columns = max(1, min(3, len(labels), int(room)))
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, fontsize=9, frameon=False)


def round_down(value):
    """Largest of 1, 2, 5 times a power of ten not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)) * power


def cell_edges(centres):
    """Cell edges half-way between ascending centres."""
    if centres.size == 1:
        return centres[0] + np.array([-0.5, 0.5])
    middle = 0.5 * (centres[:-1] + centres[1:])
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])


def frequency_range(fall, f_range):
    """Limits of the horizontal axis: those given, or all within 50 dB of the largest amplitude and +-1X."""
    if f_range is not None:
        return min(f_range), max(f_range)
    columns = np.fmax.reduce(fall.amplitude, axis=0)
    strong = fall.frequency[columns > 10 ** (-50 / 20) * largest_finite(columns)]
    reach = 1.15 * largest_finite(np.abs(fall.speed))
    low, high = min([-reach, *1.04 * strong[:1]]), max([reach, *1.04 * strong[-1:]])
    return max(low, fall.frequency[0]), min(high, fall.frequency[-1])


def thinned_grid(fall, rows, f_range, cells):
    """Row edges, column edges and amplitudes of the part in range, thinned to at most `cells` by taking maxima."""
    step = fall.frequency[1] - fall.frequency[0]
    inside = np.flatnonzero((fall.frequency > f_range[0] - step) & (fall.frequency < f_range[1] + step))
    if not inside.size or not largest_finite(fall.amplitude[:, inside]) > 0:
        raise DataError("<waterfall>", f"nothing to draw between {f_range[0]:.6g} and {f_range[1]:.6g} Hz")
    grid = fall.amplitude[np.ix_(rows.order, inside)]
    edges = [rows.edges, cell_edges(fall.frequency[inside])]
    for axis, limit in enumerate(cells):
        count = grid.shape[axis]
        if count > limit:
            starts = np.arange(limit) * count // limit
            grid = np.fmax.reduceat(grid, starts, axis=axis)
            edges[axis] = edges[axis][np.append(starts, count)]
    return edges[0], edges[1], grid


def draw_amplitudes(figure, axes, fall, rows, f_range):
    """Amplitudes in dB as a grey picture with its colour bar; windows without finite data in yellow."""
    edges, columns, grid = thinned_grid(fall, rows, f_range, (MAX_ROWS, MAX_COLUMNS))
    largest = np.nanmax(grid)
    level = 20 * np.log10(np.maximum(grid / largest, 1e-10))
    colours = matplotlib.colormaps["Greys"].with_extremes(bad="#fff3b0")
    image = axes.pcolormesh(columns, edges, np.ma.masked_invalid(level), cmap=colours, vmin=-DYNAMIC_RANGE_DB,
                            vmax=0, rasterized=True)
    factor, unit = unit_for(largest, "m")
    bar = figure.colorbar(image, ax=axes, extend="min", pad=0.02)
    bar.set_label(f"amplitude in dB re {factor * largest:.3g} {unit} (largest shown)")
    if not np.isfinite(level).all():
        axes.fill_between([], [], [], facecolor="#fff3b0", label="no finite data")


def draw_order(axes, rows, order):
    """Order line: thin, dashed, with its name where it leaves the axes or, over time, where the speed is highest."""
    low, high = axes.get_xlim()
    y = np.array(rows.limits) if rows.by_speed else np.concatenate([rows.limits[:1], rows.time, rows.limits[1:]])
    x = order * (y if rows.by_speed else np.interp(y, rows.time, rows.speed_of_rows))
    axes.plot(x, y, color="0.35", linestyle=(0, (5, 4)), linewidth=0.8, zorder=11)
    name = dict(text=f"{order:+d}X".replace("-", "\N{MINUS SIGN}"), textcoords="offset points", fontsize=9,
                color="0.25", path_effects=HALO, zorder=12)
    inside = (x >= low) & (x <= high)
    if inside[-1] and rows.by_speed:
        axes.annotate(xy=(x[-1], y[-1]), xytext=(0, 3), ha="center", va="bottom", **name)
    elif inside.any():
        i_far = np.argmax(np.where(inside, np.abs(x), -1))
        far = (x[i_far], y[i_far])
        if rows.by_speed:
            edge = low if order < 0 else high
            far = (edge, edge / order)
        # away from the middle where a run up and down leaves space there, else towards it
        outward = not rows.by_speed and low + 0.08 * (high - low) < far[0] < high - 0.08 * (high - low)
        to_the_right = (order > 0) == outward
        side = dict(xytext=(4, 5), ha="left") if to_the_right else dict(xytext=(-4, 5), ha="right")
        axes.annotate(xy=far, va="bottom", **side, **name)


def draw_branch(axes, x, y, stable, label, colour=PREDICTED):
    """A predicted branch: solid where stable, dashed where unstable, dotted where nothing is claimed (`stable` as from
    `rsc.show.stability.stability`), without a hole where that changes."""
    used = set(axes.get_legend_handles_labels()[1])
    for word, shown in parts(stable, np.isfinite(x) & np.isfinite(y)).items():
        name = f"{label}, {word}"
        axes.plot(np.where(shown, x, np.nan), np.where(shown, y, np.nan), color=colour, linestyle=STYLES[word],
                  linewidth=1.1, path_effects=BEHIND, label=None if name in used else name)


def draw_transitions(axes, transition):
    """Vertical lines with their names and speeds; a name close to the one before goes to the other side of its line."""
    low, high = axes.get_xlim()
    last, right = -math.inf, False
    for name, speed in sorted(transition.items(), key=lambda item: item[1]):
        right = (speed - last < 0.06 * (high - low) and not right) or speed - low < 0.06 * (high - low)
        last = speed
        axes.axvline(speed, color="0.2", linestyle=":", linewidth=1.2)
        axes.annotate(f"{name}: {speed:.4g} Hz", (speed, 0.98), xycoords=axes.get_xaxis_transform(), rotation=90,
                      xytext=(3 if right else -3, 0), textcoords="offset points", ha="left" if right else "right",
                      va="top", fontsize=9, path_effects=HALO)


def thinned_line(x, y):
    """A line with at most MAX_POINTS points that keeps the smallest and largest value of each group."""
    if x.size <= MAX_POINTS:
        return x, y
    indices = []
    for group in np.array_split(np.arange(x.size), MAX_POINTS // 2):
        values = y[group]
        if np.isfinite(values).any():
            indices += sorted({group[np.nanargmin(values)], group[np.nanargmax(values)]})
        else:
            indices.append(group[0])
    return x[indices], y[indices]
