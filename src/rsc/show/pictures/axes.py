"""Parts of the figures: canvas, titles, legends."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import Normal, Stroke, withStroke

DPI = 150
TURN = np.exp(2j * np.pi * np.arange(181) / 180)  # a circle
CHARACTERS = 15.0  # of a legend that fit into an inch

PREDICTED = "tab:red"
RUN_COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:brown", "tab:cyan", "tab:pink")
HALO = (withStroke(linewidth=2.5, foreground="white"),)
# a light rim that keeps a coloured line readable on a dark picture
BEHIND = (Stroke(linewidth=1.9, foreground="white", alpha=0.6), Normal())
ROUND_STEPS = (1, 2, 2.5, 5, 10)


def new_figure(width, height, rows=1, columns=1):
    figure = Figure(figsize=(width, height), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, columns, sharex=columns == 1)
    return figure, axes


def as_text(title):
    """A title of the user in which matplotlib looks for no mathematics."""
    return title.replace("$", r"\$")


def finish(owner, axes, title):
    """Title, and a legend below the figure or the axes, where it can hide nothing."""
    axes.set_title(as_text(title), pad=8, wrap=True)  # long titles break at the edges of the figure
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        legend_below(owner, handles, labels)


def legend_below(owner, handles, labels):
    """A legend below a figure or below axes, of as many columns up to three as its longest label leaves room for."""
    room = CHARACTERS * owner.figure.get_figwidth() / (max(map(len, labels)) + 8)
    columns = max(1, min(3, len(labels), int(room)))
    place = {"loc": "outside lower center"} if owner is owner.figure else {"loc": "upper center", "bbox_to_anchor": (0.5, -0.13)}
    owner.legend(handles, labels, ncols=columns, fontsize=9, frameon=False, **place)


def cell_edges(centres):
    """Cell edges half-way between ascending centres."""
    if centres.size == 1:
        return centres[0] + np.array([-0.5, 0.5])
    middle = 0.5 * (centres[:-1] + centres[1:])
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])
