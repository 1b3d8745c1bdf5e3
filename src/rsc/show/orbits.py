"""Orbits side by side, and an orbit that moves."""

import io

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image

from rsc.show.axes import DPI, ROUND_STEPS, TURN, as_text
from rsc.show.units import largest_finite, unit_for

COLUMNS = 3
FRAMES, FRAME_MS = 60, 60
FILTERED_COLOURS = {"filtered at 1X": "tab:purple", "filtered at the whirl": "black"}


def plot_orbits(panels, *, gap, title):
    """Paths of several moments of a run, each with the stator, the gap around its middle, the contact, a mark a revolution and
    its paths filtered at 1X and at the whirl frequency.

    Parameters
    ----------
    panels : sequence of (caption, rotor (n,) complex m, stator (n,) complex m, marks (k,) int, normal force (n,) N, filtered)
        with `filtered` as from `rsc.show.moments.filtered`
    gap : float, m
    title : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    rows, columns = -(-len(panels) // COLUMNS), min(len(panels), COLUMNS)
    figure = Figure(figsize=(3.2 * columns, 3.3 * rows + 1.2), dpi=DPI)
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, columns, squeeze=False)
    factor, unit = unit_for(max([gap, *(largest_finite(np.abs(panel[1])) for panel in panels)]), "m")
    top = max(largest_finite(panel[4]) for panel in panels) or 1.0
    for axes, panel in zip(grid.flat, panels, strict=False):
        _draw(axes, panel, factor, gap, top)
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    for axes in grid[:, 0]:
        axes.set_ylabel(f"z in {unit}")
    for axes in grid[-1]:
        axes.set_xlabel(f"y in {unit}")
    height = figure.get_figheight()
    figure.suptitle(as_text(title), fontsize=11, wrap=True)
    named = {label: handle for axes in grid.flat for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    force, force_unit = unit_for(top, "N")
    labels = [f"in contact, darker: up to {force * top:.3g} {force_unit}" if label == "in contact" else label for label in named]
    in_a_line = columns + 1
    bottom = (0.6 + 0.19 * -(-len(labels) // in_a_line)) / height
    figure.subplots_adjust(left=0.08, right=0.98, bottom=bottom, top=1.0 - 0.75 / height, hspace=0.28)
    figure.legend(list(named.values()), labels, loc="lower center", ncols=in_a_line, fontsize=8, frameon=False)
    return figure


def _draw(axes, panel, factor, gap, top, adjustable="datalim"):
    """One path into its axes; the contact is coloured by the force over the largest of all panels."""
    caption, rotor, stator, marks, force, filtered = panel
    rotor, stator = factor * np.asarray(rotor), factor * np.asarray(stator)
    circle = stator.mean() + factor * gap * TURN
    axes.plot(circle.real, circle.imag, color="0.4", linestyle="--", linewidth=0.9, label="gap around the stator")
    if np.ptp(stator.real) + np.ptp(stator.imag) > 0.0:
        axes.plot(stator.real, stator.imag, color="tab:green", linewidth=0.7, label="stator")
    axes.plot(rotor.real, rotor.imag, color="tab:blue", linewidth=0.7, label="rotor")
    for name, (centre, forward, backward) in filtered.items():
        path = factor * (centre + forward * TURN + backward * TURN.conj())
        axes.plot(path.real, path.imag, color=FILTERED_COLOURS[name], linewidth=0.9, label=name, zorder=4.5)
    touching = np.asarray(force) > 0.0
    shade = colormaps["YlOrRd"](0.35 + 0.6 * np.asarray(force)[touching] / top)
    axes.scatter(rotor[touching].real, rotor[touching].imag, c=shade, s=5, linewidths=0, zorder=4, label="in contact")
    axes.plot(rotor[marks].real, rotor[marks].imag, "o", markersize=4.5, markerfacecolor="white", markeredgecolor="black",
              linestyle="none", label="once a revolution", zorder=5)  # fmt: skip
    axes.set_title(caption, fontsize=9)
    axes.set_aspect("equal", adjustable=adjustable)
    axes.tick_params(labelsize=8)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=ROUND_STEPS))


def animate_orbit(panels, *, gap, title):
    """The bytes of a GIF that shows the paths of consecutive moments one after the other.

    Parameters
    ----------
    panels : as in `plot_orbits`
    gap : float, m
    title : str
    """
    factor, unit = unit_for(max([gap, *(largest_finite(np.abs(panel[1])) for panel in panels)]), "m")
    reach = 1.05 * factor * max([gap, *(largest_finite(np.abs(panel[1])) for panel in panels)])
    top = max(largest_finite(panel[4]) for panel in panels) or 1.0
    figure = Figure(figsize=(4.8, 5.1), dpi=100)
    canvas, axes = FigureCanvasAgg(figure), figure.add_axes((0.13, 0.1, 0.84, 0.78))
    figure.suptitle(as_text(title), fontsize=9, wrap=True)
    images = []
    for panel in panels:
        axes.clear()
        _draw(axes, panel, factor, gap, top, adjustable="box")
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel=f"y in {unit}", ylabel=f"z in {unit}")
        canvas.draw()
        images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy()).quantize(64, dither=Image.Dither.NONE))
    content = io.BytesIO()
    images[0].save(content, "GIF", save_all=True, append_images=images[1:], duration=FRAME_MS, loop=0)
    return content.getvalue()
