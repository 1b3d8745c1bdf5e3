"""Results on axes of matplotlib, for notebooks and scripts: what `plot` of every result calls.

The descriptions are those of the page and of `rsc plot`; only the axes are the caller's.
"""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from rsc.errors import SceneError
from rsc.measure.features import default_window, envelope, revolution_marks, waterfall
from rsc.show.pictures import modes, paths, pictures
from rsc.show.pictures.abscissa import Abscissa
from rsc.show.pictures.album import PICTURES
from rsc.show.pictures.axes import legend_below
from rsc.show.pictures.critical_map import critical_speeds
from rsc.show.pictures.drawing import drawing
from rsc.show.pictures.maps import impacts
from rsc.show.pictures.moments import moments
from rsc.show.pictures.plots import draw
from rsc.show.pictures.shapes import shape
from rsc.show.pictures.traces import BLUE, GREEN, GREY, PURPLE, RED, SKY, axes, dots, in_units, line, thinned
from rsc.show.words.units import largest_finite, unit_for
from rsc.show.words.wording import frequency_text

MOST_LEGEND = 12  # names that a legend inside the axes may have
SEEN = 1e-3  # of the largest amplitude: what lies below does not widen a spectrum
KINDS = ("orbit", "envelope", "spectrum")
SIZE = (7.0, 5.0)  # inches of a figure that is made here


def on_axes(picture: dict[str, Any], ax: Axes | None, style: dict[str, Any]) -> Axes:
    """A description on the caller's axes, or on those of a new figure of pyplot, which a notebook shows; returns the axes."""
    ax = own_axes(ax)
    draw(ax, in_units(picture), style)
    _legend(ax)
    return ax


def own_axes(ax: Axes | None) -> Axes:
    """The axes, or those of a new figure of pyplot."""
    if ax is not None:
        return ax
    from matplotlib import pyplot  # only here: files are drawn without its global state

    return pyplot.subplots(figsize=SIZE, layout="constrained")[1]


def _legend(ax: Axes) -> None:
    handles, names = ax.get_legend_handles_labels()
    unique = dict(zip(names, handles, strict=True))
    if 1 < len(unique) <= MOST_LEGEND:
        ax.legend(list(unique.values()), list(unique), fontsize=8)


def trajectory(result: Any, kind: str, ax: Axes | None, time: float | Sequence[float] | None, style: dict[str, Any]) -> Axes:
    """A run: orbit of an interval, envelope over time, or spectrum of the window at a time."""
    if kind not in KINDS:
        raise SceneError("plot", "kind", kind, f"one of {', '.join(KINDS)}")
    describe = {"orbit": _orbit, "envelope": _envelope, "spectrum": _spectrum}[kind]
    return on_axes(describe(result, time), ax, style)


def _orbit(result: Any, time: float | Sequence[float] | None) -> dict[str, Any]:
    begin, end = _interval(result, time)
    inside = slice(*np.searchsorted(result.time, [begin, end], side="left").tolist())
    rotor, stator, gap = result.contact_rotor()[inside], result.contact_stator()[inside], result.scene.contact.gap
    if not len(rotor):
        raise SceneError("plot", "time", time, f"within 0 to {result.summary.end_time:g} s")
    force = np.reshape(result.normal_force[inside], (len(rotor), -1))[:, 0]
    factor, unit = unit_for(max(largest_finite(np.abs(rotor)), gap), "m")
    marks = revolution_marks(result) - (inside.start or 0)
    marks = marks[(marks >= 0) & (marks < len(rotor))]
    data = paths.traces_of_orbit(factor * rotor, factor * stator, force > 0.0, marks, factor * gap)
    return {"data": data, "layout": axes(f"y in {unit}", f"z in {unit}", 340, equal=True)}


def _interval(result: Any, time: float | Sequence[float] | None) -> tuple[float, float]:
    """Begin and end in s: as given, a window about a time, or the last window."""
    if time is not None and np.ndim(time) == 1:
        begin, end = (float(each) for each in time)  # type: ignore[union-attr]
        return begin, end
    window = min(default_window(result), result.summary.end_time)
    middle = result.summary.end_time - 0.5 * window if time is None else float(time)  # type: ignore[arg-type]
    return middle - 0.5 * window, middle + 0.5 * window


def _envelope(result: Any, time: float | Sequence[float] | None) -> dict[str, Any]:
    own, gap = envelope(result), result.scene.contact.gap
    picture = _of_envelope(own, gap)
    if time is not None:
        picture["layout"]["xaxis"] = picture["layout"]["xaxis"] | {"range": list(_interval(result, time))}
    return picture


def _thin(x: Any, y: Any, name: str, colour: str, width: float) -> dict[str, Any]:
    x, y = thinned(x, y)
    return line(x, y, name, colour, width=width)


def _of_envelope(own: Any, gap: float | None) -> dict[str, Any]:
    factor, unit = unit_for(max(largest_finite(own.maximum), gap or 0.0), "m")
    data = [
        _thin(own.time, factor * own.maximum, "largest", BLUE, 1.4),
        _thin(own.time, factor * own.minimum, "smallest", SKY, 1.2),
    ]
    if gap is not None:
        data.append(line([own.time[0], own.time[-1]], [factor * gap] * 2, "gap", GREY, "dashdot", 1.2))
    return {"data": data, "layout": axes("time in s", {"title": f"|r| at the contact in {unit}", "rangemode": "tozero"}, 300)}


def envelopes(own: Any, ax: Axes | None, style: dict[str, Any]) -> Axes:
    """An `rsc.measure.envelopes.Envelope` over time."""
    return on_axes(_of_envelope(own, None), ax, style)


def _spectrum(result: Any, time: float | Sequence[float] | None) -> dict[str, Any]:
    fall = waterfall(result)
    middle = np.mean(_interval(result, time))
    i = int(np.abs(fall.time - middle).argmin())
    return spectrum(fall.frequency, fall.amplitude[i], float(fall.speed[i]), reach_of(fall))


def spectrum(frequency: Any, amplitude: Any, speed: float, reach: float) -> dict[str, Any]:
    """A two-sided amplitude spectrum, with the rotor speed in Hz marked: arrays (n,) in Hz and m."""
    factor, unit = unit_for(largest_finite(amplitude), "m")
    inside = np.abs(frequency) <= reach
    data = [_thin(frequency[inside], factor * amplitude[inside], f"at {frequency_text(speed, '.4g')}", BLUE, 1.2)]
    top = factor * largest_finite(amplitude)
    data.append(line([speed, speed], [0.0, top], "+1X", GREY, "dash", 0.9))
    x = {"title": "frequency in Hz (backward < 0)", "range": [-reach, reach]}
    return {"data": data, "layout": axes(x, {"title": f"amplitude in {unit}", "rangemode": "tozero"}, 300)}


def reach_of(fall: Any) -> float:
    """Frequency in Hz up to which a waterfall shows something."""
    largest = largest_finite(fall.amplitude)
    seen = np.abs(fall.frequency[(np.nan_to_num(fall.amplitude) > SEEN * largest).any(axis=0)]).max(initial=0.0)
    return float(min(max(1.15 * seen, 1.15 * np.abs(fall.speed).max(), 4.0 / fall.window), np.abs(fall.frequency).max()))


def spectra(fall: Any, ax: Axes | None, style: dict[str, Any]) -> Axes:
    """A `rsc.measure.spectra.Waterfall` as a Campbell diagram of what was measured or simulated."""
    seen = SimpleNamespace(fall=fall)
    along, reach = Abscissa(seen), reach_of(fall)
    data = [pictures.amplitudes(fall, along, reach), *pictures.orders(seen, along, reach)]
    layout = axes({"title": pictures.FREQUENCY_TITLE, "range": [-reach, reach]}, {"title": along.title}, 460, across="y")
    return on_axes({"data": data, "layout": layout}, ax, style)


def cascade(fall: Any, ax: Axes | None, style: dict[str, Any]) -> Axes:
    """A `rsc.measure.spectra.Waterfall` as stacked spectra."""
    seen = SimpleNamespace(fall=fall)
    return on_axes(pictures.cascade(seen, Abscissa(seen), reach_of(fall)), ax, style)


def whirls(speed: Any, frequency: Any, stable: Any, ax: Axes | None, style: dict[str, Any]) -> Axes:
    """Predicted whirls over the rotor speed: arrays of one shape, Hz, Hz and bool."""
    return on_axes(whirl_picture(speed, frequency, stable), ax, style)


def whirl_picture(speed: Any, frequency: Any, stable: Any) -> dict[str, Any]:
    """The description of predicted whirls as dots: filled where stable, open where not."""
    speed, frequency, stable = (np.ravel(each) for each in np.broadcast_arrays(speed, frequency, stable))
    exists = np.isfinite(frequency)
    data = []
    for name, chosen, colour in (("stable", exists & stable, RED), ("unstable", exists & ~stable, "#ffffff")):
        if chosen.any():
            data.append(dots(speed[chosen], frequency[chosen], f"predicted whirl, {name}", colour, RED, 4))
    ends = np.array([speed.min(), speed.max()]) if len(speed) else np.zeros(2)
    if ends[1] > ends[0]:
        data += [line(ends, sign * ends, "1X", GREY, "dash", 0.9, showlegend=sign < 0) for sign in (-1.0, 1.0)]
    return {"data": data, "layout": axes("rotor speed in Hz", "whirl frequency in Hz (backward < 0)", 380)}


def campbell(diagram: Any, ax: Axes | None, style: dict[str, Any]) -> Axes:
    """An `rsc.Campbell`: damped natural frequencies over the rotor speed."""
    return on_axes(modes.campbell(diagram)[0], ax, style)


def machine(scene: Any, ax: Axes | None, style: dict[str, Any]) -> Axes:
    """The rotor of a scene by its stations."""
    picture = drawing(scene)
    if picture is None:
        raise SceneError("plot", "rotor", scene.rotor.model, "given by its stations, model \"shaft\", for a drawing")
    return on_axes(picture, ax, style)


def mode_shape(modes: Any, mode: int, ax: Axes | None, style: dict[str, Any]) -> Axes:
    """The shape of a mode of the rotor of `rsc.Modes`."""
    if not modes.shapes:
        raise SceneError("plot", "mode", mode, "a mode of a rotor that was given by its stations, model \"shaft\"")
    if not 0 <= mode < len(modes.shapes):
        raise SceneError("plot", "mode", mode, f"a whole number from 0 to {len(modes.shapes) - 1}")
    picture = shape(modes, mode)
    ax = on_axes(picture, ax, style)
    ax.set_title(picture["caption"], fontsize=9, wrap=True)
    return ax


def critical_map(made: Any, ax: Axes | None, style: dict[str, Any]) -> Axes:
    """An `rsc.CriticalMap`: critical speeds over the stiffness of the bearings."""
    return on_axes(critical_speeds(made), ax, style)


def motions(listed: Any, ax: Axes | None) -> Axes:
    """The random impacts of a `rsc.measure.catalogue.Motions`, of several contacts at the first, by the motion each ends in."""
    ax, n_places = own_axes(ax), max(1, len(listed.largest_at))
    impacts(ax, listed, slice(0, None, n_places), next(iter(listed.largest_at.values()), listed.largest))
    legend_below(ax, *ax.get_legend_handles_labels())  # impacts lie everywhere
    return ax


def report(made: Any, name: str, ax: Axes | None, others: Sequence[Any], style: dict[str, Any]) -> Axes:
    """A picture of a report by its name, with the reports of other runs where it compares them."""
    along = Abscissa(made)
    if name == "orbit":
        return on_axes(paths.orbit(made, moments(made)[-1].window), ax, style)
    if name not in PICTURES:
        raise SceneError("plot", "picture", name, f"one of orbit, {', '.join(PICTURES)}")
    entry = PICTURES[name]
    picture = entry.describe(made, along, others) if entry.compares else entry.describe(made, along)
    if picture is None:
        raise SceneError("plot", "picture", name, "one that this run has something to show in")
    return on_axes(picture, ax, style)


def benchmark(made: Any, ax: Axes | None, style: dict[str, Any]) -> Axes:
    """Processor time over error of a `rsc.study.equations.benchmark.Benchmark`, both logarithmic."""
    ax = own_axes(ax)
    for i, method in enumerate(dict.fromkeys(point.method for point in made.points)):
        known = sorted((p.error, p.seconds) for p in made.points if p.method == method and p.error > 0.0)
        colour = (BLUE, RED, GREEN, PURPLE)[i % 4]
        ax.loglog(*np.array(known).reshape(-1, 2).T, **{"color": colour, "marker": "osD^"[i % 4], "label": method, **style})
    ax.axvline(max(made.reference_error, 1e-300), color=GREY, linestyle=":", label="error of the reference")
    ax.set(xlabel="largest error of a displacement in gaps", ylabel="processor time in s")
    ax.grid(color="0.92", linewidth=0.6)
    _legend(ax)
    return ax
