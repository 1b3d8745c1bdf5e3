"""Pictures of runs and predictions: arrays in, `matplotlib.figure.Figure` out.

Figures are made by the object interface on an Agg canvas, never by pyplot: no display, no global state, safe in
threads. Conventions: forward whirl is positive frequency and the right half, backward whirl the left half; darker is
larger, in dB over 60 dB; predictions are solid where stable, dashed where unstable, dotted where nothing is claimed.
Lengths are drawn in the unit that suits the data. What is drawn is thinned to about one cell per pixel by taking maxima
(or extremes), so that a line or a spike is never lost.
"""

import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from rsc.errors import DataError
from rsc.files.output import PICTURES, put
from rsc.measure.envelopes import Envelope
from rsc.measure.spectra import Peaks, Waterfall
from rsc.show.axes import (
    COUPLING_COLOURS,
    FREQUENCY_LABEL,
    MAX_COLUMNS,
    MAX_STACKED,
    ORDERS,
    PREDICTED,
    ROUND_STEPS,
    RUN_COLOURS,
    STACK_HEIGHT,
    TURN,
    Rows,
    as_text,
    draw_amplitudes,
    draw_branch,
    draw_order,
    draw_transitions,
    finish,
    frequency_range,
    largest_finite,
    new_figure,
    round_down,
    thinned_grid,
    thinned_line,
    unit_for,
)

COMPRESSION = 1  # of a PNG, 1 to 9: a little larger than with more, in half of the time


def plot_campbell(
    fall: Waterfall,
    *,
    title: str,
    natural: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    whirls: Sequence[tuple[ArrayLike, ArrayLike, ArrayLike]] | None = None,
    rolls: ArrayLike | None = None,
    peaks: Sequence[Peaks] | None = None,
    f_range: tuple[float, float] | None = None,
) -> Figure:
    """Amplitude over whirl frequency (x) and rotor speed (y) of a run, with the predictions over it.

    The vertical axis is time where the speed does not run one way only (constant speed, holds, up and down); the
    predictions are then drawn at the speed of each instant.

    Parameters
    ----------
    fall : rsc.measure.spectra.Waterfall
    title : str
    natural : mapping of name to (speed (n,), frequency (n, k)), Hz, or None
        Natural frequencies as signed whirl frequencies, dash-dotted; "coupled" and "uncoupled" have fixed colours.
    whirls : sequence of (speed (n,), frequency (n,), stable (n,)), Hz, or None
        Branches of predicted whirls; stable: true or 1, false or 0, NaN where nothing is claimed (no circle).
    rolls : (n_w,) Hz, or None
        Whirl predicted to roll in each window, NaN where there is none.
    peaks : sequence of rsc.measure.spectra.Peaks, or None
        Measured lines, drawn as small circles.
    f_range : (lowest, highest) Hz, or None: all that lies within 50 dB of the largest amplitude, and +-1X

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    DataError
        If no amplitude in the range is finite and positive.
    """
    figure, axes = new_figure(8.5, 6.5)
    rows = Rows(fall)
    low, high = frequency_range(fall, f_range)
    draw_amplitudes(figure, axes, fall, rows, (low, high))
    axes.axvline(0, color="0.6", linewidth=0.6)
    axes.set(xlim=(low, high), ylim=rows.limits, xlabel=FREQUENCY_LABEL, ylabel=rows.label)
    for order in ORDERS:
        draw_order(axes, rows, order)
    for i_name, (name, (speed, frequency)) in enumerate((natural or {}).items()):
        colour = COUPLING_COLOURS.get(name, RUN_COLOURS[i_name % len(RUN_COLOURS)])
        frequency = np.asarray(frequency, float)
        frequency = frequency if frequency.ndim == 2 else frequency[:, None]
        label: str | None = f"natural frequencies, {name}"
        for column in frequency.T:
            x, y = rows.curve(speed, column)
            axes.plot(x, y, linestyle="-.", color=colour, linewidth=1.0, label=label)
            label = None
    for i_side, side in enumerate(peaks or ()):
        height = side.speed if rows.by_speed else side.time
        height = np.broadcast_to(height[:, None], side.frequency.shape)
        axes.plot(side.frequency.ravel(), height.ravel(), "o", markersize=2.2, color="deepskyblue", markeredgewidth=0,
                  label=None if i_side else "measured lines")
    for speed, frequency, stable in whirls or ():
        x, y = rows.curve(speed, frequency)
        draw_branch(axes, x, y, rows.curve(speed, np.asarray(stable, float))[0], "predicted whirl")
    if rolls is not None and np.isfinite(rolls).any():
        height = fall.speed if rows.by_speed else fall.time
        axes.plot(rolls, height, color="tab:orange", linewidth=1.2, label="predicted whirl, rolling")
    finish(figure, axes, title, pad=20)
    return figure


def plot_waterfall(fall: Waterfall, *, title: str, f_range: tuple[float, float] | None = None) -> Figure:
    """Stacked spectra: amplitude (linear, scale bar at the right) over whirl frequency, one line per group of windows.

    Each line stands on its rotor speed (on its time where the speed does not run one way only) and shows the largest
    amplitudes of its group of windows; at most 50 lines.

    Parameters
    ----------
    fall : rsc.measure.spectra.Waterfall
    title : str
    f_range : (lowest, highest) Hz, or None: as in `plot_campbell`

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    DataError
        If no amplitude in the range is finite and positive.
    """
    figure, axes = new_figure(8.5, 6.5)
    rows = Rows(fall)
    low, high = frequency_range(fall, f_range)
    edges, columns, grid = thinned_grid(fall, rows, (low, high), (MAX_STACKED, MAX_COLUMNS))
    frequency = 0.5 * (columns[:-1] + columns[1:])
    base = 0.5 * (edges[:-1] + edges[1:])
    span = rows.limits[1] - rows.limits[0]
    largest = np.nanmax(grid)
    scale = STACK_HEIGHT * span / largest
    for i_line in range(base.size):  # from the lowest line up; the lower ones stand in front
        line = base[i_line] + scale * grid[i_line]
        axes.fill_between(frequency, base[i_line], line, facecolor="white", linewidth=0, zorder=10 - i_line / 100)
        axes.plot(frequency, line, color="0.1", linewidth=0.6, zorder=10 - i_line / 100)
    axes.axvline(0, color="0.6", linewidth=0.6, zorder=1)
    top = max(base[i] + scale * largest_finite(grid[i]) for i in range(base.size))
    axes.set(xlim=(low, high), ylim=(rows.limits[0], top + 0.03 * span), xlabel=FREQUENCY_LABEL, ylabel=rows.label)
    # no marks on the vertical axis where there is no speed any more but only the height of the last lines
    marks = MaxNLocator(8, steps=ROUND_STEPS).tick_values(*rows.limits)
    axes.set_yticks([mark for mark in marks if rows.limits[0] <= mark <= rows.limits[1]])
    for order in (-1, 1):
        draw_order(axes, rows, order)
    factor, unit = unit_for(largest, "m")
    bar = round_down(0.6 * largest * factor)
    height = bar / factor * scale
    axes.plot([1.025, 1.025], [rows.limits[0], rows.limits[0] + height], color="black", linewidth=2,
              transform=axes.get_yaxis_transform(), clip_on=False, solid_capstyle="butt")
    axes.text(1.04, rows.limits[0] + height / 2, f"{bar:g} {unit}", rotation=90, va="center", ha="left",
              transform=axes.get_yaxis_transform())
    finish(figure, axes, title)
    return figure


def plot_amplitude(
    runs: Sequence[tuple[str, Envelope]],
    *,
    gap: float,
    title: str,
    predicted: Sequence[tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike | None, ArrayLike | None]] | None = None,
    synchronous: tuple[ArrayLike, ArrayLike] | None = None,
    transition: Mapping[str, float] | None = None,
    unbalance_line: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
) -> Figure:
    """Amplitude of the contact coordinate against rotor speed: measured envelopes beside the predicted ones.

    Parameters
    ----------
    runs : sequence of (label, envelope)
        Envelopes with speed (n,) Hz, minimum and maximum (n,) m (`rsc.measure.envelopes.Envelope`); a run-up and a run-down
        in one picture show the hysteresis.
    gap : float, m
    title : str
    predicted : sequence of (speed (n,), amplitude (n,), stable (n,), minimum, maximum), or None
        Branches of predicted whirls, Hz and m; stable as in `plot_campbell`; minimum and maximum, (n,) each or None, are the
        envelope that the unbalance makes of the circle, drawn as a light band where the branch is stable.
    synchronous : (speed (n,), amplitude (n,)), or None
        Closed form of the synchronous forward motion, NaN where it does not exist.
    transition : mapping of label to speed in Hz, or None
        Places to be marked.
    unbalance_line : (speed (n,), simulated (n,), predicted (n,)), or None
        Line at the rotor speed on the whirls of a run, Hz and m, NaN elsewhere.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = new_figure(8.0, 5.5)
    known = [gap] + [largest_finite(run.maximum) for _, run in runs]
    known += [largest_finite(np.where(np.equal(stable, 1), size, np.nan)) for _, size, stable, *_ in predicted or ()]
    factor, unit = unit_for(max(known), "m")
    for i_run, (label, run) in enumerate(runs):
        colour = RUN_COLOURS[i_run % len(RUN_COLOURS)]
        axes.fill_between(run.speed, factor * run.minimum, factor * run.maximum, color=colour, alpha=0.18, linewidth=0)
        axes.plot(run.speed, factor * run.maximum, color=colour, linewidth=1.2, label=f"{label}: min and max of |r|")
        axes.plot(run.speed, factor * run.minimum, color=colour, linewidth=0.8)
    axes.axhline(factor * gap, color="black", linestyle="-.", linewidth=0.9, label="gap")
    band_name: str | None = "predicted envelope, first order"
    for speed, size, stable, minimum, maximum in predicted or ():
        draw_branch(axes, np.asarray(speed, float), factor * np.asarray(size, float), stable, "predicted whirl")
        if minimum is not None and maximum is not None:
            axes.fill_between(speed, factor * np.asarray(minimum), factor * np.asarray(maximum), where=np.equal(stable, 1),
                              color=PREDICTED, alpha=0.13, linewidth=0, label=band_name)
            band_name = None
    if synchronous is not None:
        axes.plot(synchronous[0], factor * np.asarray(synchronous[1]), color="tab:purple", linewidth=1.2,
                  label="forward rub, closed form")
    if unbalance_line is not None and np.isfinite(unbalance_line[1]).any():
        speed, simulated, expected = (np.asarray(values, float) for values in unbalance_line)
        axes.plot(speed, factor * simulated, color=RUN_COLOURS[0], linewidth=1.2, linestyle=":",
                  label="unbalance line on the whirl")
        axes.plot(speed, factor * expected, color=PREDICTED, linewidth=0.7, linestyle="-",
                  label="predicted unbalance line")
    axes.set(xlabel="rotor speed in Hz", ylabel=f"amplitude |r| at the contact in {unit}")
    axes.set_ylim(0, 1.12 * factor * max(known))
    speeds = [run.speed for _, run in runs] or [np.asarray(branch[0], float) for branch in predicted or ()]
    if speeds:
        x = np.concatenate(speeds)
        margin = 0.02 * (np.ptp(x) or 1.0)
        axes.set_xlim(x.min() - margin, x.max() + margin)
    draw_transitions(axes, transition or {})
    finish(figure, axes, title)
    return figure


def plot_contact(
    abscissa: ArrayLike,
    share: ArrayLike,
    normal_force: ArrayLike,
    slip_velocity: ArrayLike | None,
    friction_power: ArrayLike,
    *,
    title: str,
    x_label: str = "rotor speed in Hz",
) -> Figure:
    """Rub strip: contact share, normal force, slip velocity and friction power in panels over one abscissa.

    Parameters
    ----------
    abscissa : (n,) rotor speed in Hz, or time in s with a matching `x_label`
    share : (n,) share of the time in contact, 0 to 1
    normal_force : (n,) N
    slip_velocity : (n,) m/s, or None where the scene has no contact diameter: the panel is left out
    friction_power : (n,) W
    title : str
    x_label : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    panels = [("contact share\nin %", "%", 100 * np.asarray(share, float)), ("normal force\nin {}", "N", normal_force)]
    if slip_velocity is not None:
        panels.append(("slip velocity\nin {}", "m/s", slip_velocity))
    panels.append(("friction power\nin {}", "W", friction_power))
    figure, all_axes = new_figure(8.0, 0.9 + 1.45 * len(panels), rows=len(panels))
    for axes, (label, base, values) in zip(all_axes, panels, strict=True):
        values = np.asarray(values, float)
        factor, unit = (1.0, "%") if base == "%" else unit_for(largest_finite(np.abs(values)), base)
        axes.plot(*thinned_line(np.asarray(abscissa, float), factor * values), color="tab:blue", linewidth=0.9)
        axes.set_ylabel(label.format(unit))
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=ROUND_STEPS))
        axes.grid(color="0.9", linewidth=0.6)
        if base == "%":
            axes.set_ylim(-4, 104)
        elif base == "m/s":
            axes.axhline(0, color=PREDICTED, linewidth=1.0, linestyle="--", label="rolling limit")
            axes.legend(loc="best", fontsize=8, framealpha=0.8)
        else:
            axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    all_axes[-1].set_xlabel(x_label)
    all_axes[0].set_title(as_text(title))
    figure.align_ylabels(all_axes)
    return figure


def plot_centre_line(centre: ArrayLike, *, gap: float, title: str) -> Figure:
    """Shaft centre line: mean positions of the rotor over a run, within the circle of the gap.

    Parameters
    ----------
    centre : (n,) complex m, in the order of the run
    gap : float, m
    title : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = new_figure(5.6, 5.8)
    centre = np.asarray(centre)
    factor, unit = unit_for(max(largest_finite(np.abs(centre)), gap), "m")
    circle, path = factor * gap * TURN, factor * centre
    axes.plot(circle.real, circle.imag, color="black", linestyle="-.", linewidth=0.9, label="gap")
    axes.plot(path.real, path.imag, color=RUN_COLOURS[0], linewidth=1.2, label="mean position of a window")
    for i, shape, words in ((0, "o", "begin of the run"), (-1, "s", "end of the run")):
        axes.plot(path[i].real, path[i].imag, shape, color="black", markerfacecolor="white", markersize=6, linestyle="none",
                  label=words, zorder=5)
    axes.set(aspect="equal", xlabel=f"y in {unit}", ylabel=f"z in {unit}")
    axes.grid(color="0.92", linewidth=0.6)
    finish(figure, axes, title)
    return figure


def plot_once_a_turn(
    abscissa: ArrayLike, distance: ArrayLike, *, gap: float, title: str, x_label: str = "rotor speed in Hz"
) -> Figure:
    """Distance of the rotor at each revolution of its shaft: one line of dots is a motion that the rotation repeats, a band or
    several lines one that it does not.

    Parameters
    ----------
    abscissa : (n,) rotor speed in Hz, or time in s with a matching `x_label`
    distance : (n,) m, |r| at the contact
    gap : float, m
    title : str
    x_label : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = new_figure(8.0, 4.2)
    distance = np.asarray(distance, float)
    factor, unit = unit_for(max(largest_finite(distance), gap), "m")
    axes.plot(np.asarray(abscissa, float), factor * distance, "o", color=RUN_COLOURS[0], markersize=1.8, markeredgewidth=0,
              linestyle="none", label="once a revolution")
    axes.axhline(factor * gap, color="black", linestyle="-.", linewidth=0.9, label="gap")
    axes.set(xlabel=x_label, ylabel=f"|r| at the contact in {unit}")
    axes.set_ylim(bottom=0)
    finish(figure, axes, title)
    return figure


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure; the ending of `path` (png, pdf, svg) chooses the format.

    Raises
    ------
    DataError
        If the ending is unknown or the file cannot be written, for example because something else has this name.
    """
    ending = Path(path).suffix.lower()
    if ending not in PICTURES:
        raise DataError(path, f"picture not written: its name must end with {', '.join(PICTURES)}")
    if (engine := figure.get_layout_engine()) is not None:  # laid out once: savefig would do it twice, and draw for that
        engine.execute(figure)
        figure.set_layout_engine(None)
    content = io.BytesIO()
    more: dict[str, Any] = {"pil_kwargs": {"compress_level": COMPRESSION}} if ending == ".png" else {}
    figure.savefig(content, format=ending[1:], **more)
    put(path, content.getvalue(), PICTURES[ending])
