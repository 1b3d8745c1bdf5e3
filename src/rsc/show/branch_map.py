"""The map of predicted motions over the rotor speed: branches of whirls with their ends and events, forward rubs."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from rsc.analysis.lines.rootlines import RANGE_END
from rsc.errors import one_line
from rsc.show.axes import PREDICTED, RUN_COLOURS, as_text, draw_branch, new_figure
from rsc.show.stability import stability
from rsc.show.units import largest_finite, unit_for

MAPPED = ("frequency", "amplitude")  # of a branch, in the two halves of the map


def branch_map(survey):
    """Frequency and amplitude of a survey's branches over the rotor speed; far-out roots below the gap are left out."""
    gap = survey.scene.contact.gap
    shown = [b for b in survey.branches if b.amplitude.max() > gap]
    branches = [(b.label, b.values, b.frequency, b.amplitude, stability(b)) for b in shown]
    marks = [
        (event.value, event.frequency, float(np.interp(event.value, b.values, b.amplitude)), event.cause)
        for b in shown
        for event in (b.begin, *b.events, b.end)
        if event.cause != RANGE_END
    ]
    rubs = [(rub.speed, rub.amplitude, stability(rub)) for rub in survey.rubs]
    ratios = [_of_ratio(place, {b.label: b for b in shown}) for place in survey.ratios]
    return plot_map(branches, marks, gap=gap, title=one_line(survey.scene.title), rubs=rubs, ratios=ratios)


def _of_ratio(place, by_label):
    """Speed, frequencies, amplitudes and text of a place where two whirls' normal forces pass their limit."""
    pair = [by_label[label] for label in (place.label, place.towards)]
    frequency, amplitude = ([float(np.interp(place.speed, b.values, getattr(b, name))) for b in pair] for name in MAPPED)
    return place.speed, frequency, amplitude, f"F_N of {place.label} is {place.ratio:.3f} F_N of {place.towards}"


def plot_map(
    branches: Sequence[tuple[str, ArrayLike, ArrayLike, ArrayLike, ArrayLike]],
    marks: Sequence[tuple[float, float, float, str]],
    *,
    gap: float,
    title: str,
    rubs: Sequence[tuple[ArrayLike, ArrayLike, ArrayLike]] = (),
    ratios: Sequence[tuple[float, Sequence[float], Sequence[float], str]] = (),
) -> Figure:
    """Frequency (top) and amplitude (bottom) of predicted motions over the rotor speed, ends and events marked with their cause.

    Parameters
    ----------
    branches : sequence of (label, speed (n,), frequency (n,), amplitude (n,), stable (n,)), Hz and m
        stable: true or 1, false or 0, NaN where nothing is claimed (no circle)
    marks : sequence of (speed, frequency, amplitude, cause), Hz and m
    gap : float, m
    title : str
    rubs : sequence of (speed (n,), amplitude (n,), stable (n,)), forward rubs, Hz and m
    ratios : sequence of (speed, frequencies, amplitudes, text), Hz and m
        Places where the normal forces of two whirls pass the limit of the first's stability towards the second (two numbers
        each): a cross on the first, joined to the second.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, (top, bottom) = new_figure(10.0, 8.0, rows=2)
    factor, unit = unit_for(max([gap] + [largest_finite(b[3]) for b in branches]), "m")
    for label, speed, frequency, amplitude, stable in branches:
        x = np.asarray(speed, float)
        for axes, values in ((top, np.asarray(frequency, float)), (bottom, factor * np.asarray(amplitude, float))):
            draw_branch(axes, x, values, stable, "backward whirl")
            axes.annotate(f" {label}", (x[-1], values[-1]), va="center", fontsize=9, color=PREDICTED, annotation_clip=False)
    for speed, amplitude, stable in rubs:
        draw_branch(bottom, np.asarray(speed, float), factor * np.asarray(amplitude), stable, "forward rub", "tab:purple")
    bottom.axhline(factor * gap, color="black", linestyle="-.", linewidth=0.9, label="gap")
    causes = list(dict.fromkeys(mark[3] for mark in marks))
    for i_cause, cause in enumerate(causes):
        places = np.array([mark[:3] for mark in marks if mark[3] == cause], dtype=float)
        shape = "osD^v<>P"[i_cause % 8]
        for axes, values in ((top, places[:, 1]), (bottom, factor * places[:, 2])):
            axes.plot(places[:, 0], values, shape, color="black", markerfacecolor="white", markersize=6, linestyle="none",
                      label=cause if axes is top else None, zorder=5)
    for i_ratio, (speed_of, frequencies, amplitudes, text) in enumerate(ratios):
        colour = RUN_COLOURS[i_ratio % len(RUN_COLOURS)]
        for axes, values in ((top, np.asarray(frequencies)), (bottom, factor * np.asarray(amplitudes))):
            axes.plot([speed_of] * 2, values, linestyle=":", color=colour, linewidth=1.3, marker="x", markersize=8, markevery=[0],
                      label=text if axes is top else None, zorder=6)
    top.set_ylabel("whirl frequency in Hz")
    bottom.set(xlabel="rotor speed in Hz", ylabel=f"amplitude |r| at the contact in {unit}")
    bottom.set_ylim(bottom=0)
    for axes in (top, bottom):
        axes.grid(color="0.92", linewidth=0.6)
        handles = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        axes.legend(handles.values(), handles.keys(), fontsize=8, loc="center left", bbox_to_anchor=(1.04, 0.5))
    top.set_title(as_text(title))
    figure.align_ylabels((top, bottom))
    return figure
