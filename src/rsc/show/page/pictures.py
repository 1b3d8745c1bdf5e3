"""Pictures of a report along its run as descriptions for plotly. `rsc.show.page.svg` draws the same ones on paper.

Conventions: forward whirl is positive frequency, backward negative; predictions are full where stable, dashed where unstable,
dotted where nothing is claimed.
"""

import numpy as np

from rsc.measure.words import AMPLITUDE, FREQUENCY, SYNCHRONOUS
from rsc.show.moments import seen_lines
from rsc.show.page.traces import (
    BLUE,
    GREEN,
    GREY,
    MOST_POINTS,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    axes,
    dots,
    line,
    named_once,
    numbers,
    packed,
    range_of,
    thinned,
)
from rsc.show.stability import parts, stability
from rsc.show.units import largest_finite, unit_for

BAND = "rgba(213,94,0,0.16)"
RANGE_DB = 60.0
MOST_ROWS, MOST_COLUMNS = 400, 720  # cells of the amplitudes in the page
DASHES = {"stable": "solid", "unstable": "dash", "no circle: nothing claimed": "dot"}
LEAST_PHASE = 10.0  # degrees, half the axis


def campbell(report, along):
    """Amplitude over whirl frequency and the course of the run, with the predictions."""
    reach = _reach(report)
    data = [_amplitudes(report, along, reach), *_orders(report, along, reach), *_naturals(report, along, reach)]
    data += [
        {**trace, "x": trace["y"], "y": trace["x"]}
        for branch in report.branches
        if np.abs(branch.frequency).min() <= reach
        for trace in _branch(along, branch, branch.frequency, 1.0)
    ]
    rolls = [row.predicted if row.branch == "roll" else np.nan for row in report.rows if row.quantity == FREQUENCY]
    if np.isfinite(rolls).any():
        data.append(line(rolls, along.of_windows, "predicted whirl, rolling", ORANGE))
    frequency = {"title": "whirl frequency in Hz (backward < 0)", "range": [-reach, reach]}
    layout = axes(frequency, {"title": along.title, "range": range_of(along)}, 460, across="y")
    return {"data": named_once(data), "layout": layout}


def _orders(report, along, reach):
    """Lines at multiples of the rotor speed."""
    speeds, places = report.fall.speed, along.of_windows
    if along.by_speed:
        speeds = places = np.array([places.min(), places.max()])
    data = []
    for order in (-2, -1, 1, 2):
        line_ = order * speeds
        if np.abs(line_).min() <= reach:
            name = f"{order:+d}X".replace("-", "\N{MINUS SIGN}")
            data.append(line(line_, places, name, GREY, "dash", 0.9, showlegend=False, hoverinfo="name+x+y"))
    return data


def _naturals(report, along, reach):
    """Natural frequencies within reach."""
    data = []
    for name, colour in (("coupled", GREEN), ("uncoupled", PURPLE)):
        speed, frequency = report.natural[name]
        for column in np.asarray(frequency).T:
            if np.abs(column).min() <= reach:
                y, x = thinned(*along.curve(speed, column))
                data.append(line(x, y, f"natural, {name}", colour, "dashdot", 1.1, legendgroup=name))
    return data


def _reach(report):
    """Frequency up to which there is something to be seen: the simulated lines, the stable whirls and 1X."""
    lines = [seen_lines(report), report.fall.speed]
    lines += [branch.frequency[branch.stable] for branch in report.branches]
    top = 1.15 * max(largest_finite(np.abs(each)) for each in lines)
    return min(max(top, 4.0 / report.fall.window), float(np.abs(report.fall.frequency).max()))


def _amplitudes(report, along, reach):
    """The amplitudes in dB re the largest as a heat map, thinned to the largest of neighbouring cells."""
    fall = report.fall
    inside = np.flatnonzero(np.abs(fall.frequency) <= reach)
    order = np.argsort(along.of_windows, kind="stable")
    grid = fall.amplitude[np.ix_(order, inside)]
    x, y = fall.frequency[inside], along.of_windows[order]
    for axis, most in enumerate((MOST_ROWS, MOST_COLUMNS)):
        if grid.shape[axis] > most:
            starts = np.arange(most) * grid.shape[axis] // most
            grid = np.fmax.reduceat(grid, starts, axis=axis)
            x, y = (x, y[starts]) if axis == 0 else (x[starts], y)
    largest = largest_finite(grid) or 1.0
    level = 20.0 * np.log10(np.maximum(np.nan_to_num(grid) / largest, 10.0 ** (-RANGE_DB / 20.0)))
    factor, unit = unit_for(largest, "m")
    rows = np.abs(np.linspace(y[0], y[-1], len(y))[:, None] - y).argmin(axis=1)  # the image on paper has equal rows
    return {
        "type": "heatmap",
        "x": numbers(x),
        "y": numbers(y),
        "z": packed(np.round(level).astype(np.int8)),
        "levels": (1.0 + level / RANGE_DB)[rows],
        "zmin": -RANGE_DB,
        "zmax": 0.0,
        "name": "",
        "colorbar": {"title": {"text": f"dB re {factor * largest:.3g} {unit}", "side": "right"}, "thickness": 12},
        "hovertemplate": "%{x:.2f} Hz, %{y:.2f}: %{z} dB<extra></extra>",
    }


def _branch(along, branch, values, factor):
    """Full line where a branch is stable, dashed where it is not, dotted where nothing is claimed, without a hole between."""
    traces = []
    for word, shown in parts(stability(branch), np.isfinite(values)).items():
        x, y = along.curve(branch.speed, np.where(shown, factor * np.asarray(values), np.nan))
        hover = f"whirl {branch.label}: %{{x:.5g}}, %{{y:.5g}}<extra></extra>"
        more = {"meta": branch.label, "legendgroup": word, "hovertemplate": hover}
        width = 1.8 if word == "stable" else 1.2
        traces.append(line(*thinned(x, y), f"predicted whirl, {word}", RED, DASHES[word], width, **more))
    return traces


def amplitude(report, along, others=()):
    """Smallest and largest distance at the contact, gap, predicted whirls, forward rub and the line at the rotor speed."""
    gap = report.result.scene.contact.gap
    shown = [b for b in report.branches if b.stable.any() or b.label in {row.branch for row in report.rows}]
    known = [gap, largest_finite(report.envelope.maximum)]
    known += [largest_finite(b.amplitude[b.stable]) for b in shown]
    known += [largest_finite(other.envelope.maximum) for other in others]
    factor, unit = unit_for(max(known), "m")
    at = along.of(report.envelope)
    data = [
        line(*thinned(at, factor * report.envelope.maximum), "simulated, largest", BLUE, width=1.4),
        line(*thinned(at, factor * report.envelope.minimum), "simulated, smallest", SKY, width=1.2),
        line(range_of(along), [factor * gap] * 2, "gap", GREY, "dashdot", 1.2),
    ]
    for other in others if along.by_speed else ():
        way = f"{other.result.scene.drive.speed[0]:g} to {other.result.scene.drive.speed[-1]:g} Hz"
        for values, words in ((other.envelope.maximum, "largest"), (other.envelope.minimum, "smallest")):
            data.append(line(*thinned(other.envelope.speed, factor * values), f"run {way}, {words}", ORANGE, "solid", 1.2))
    for branch in shown:
        data += _envelope(along, branch, factor) + _branch(along, branch, branch.amplitude, factor)
    if np.isfinite(report.rub[1]).any():
        data.append(line(*thinned(*along.curve(report.rub[0], factor * report.rub[1])), "forward rub, closed form", PURPLE))
    rows = [row for row in report.rows if row.quantity == SYNCHRONOUS]
    for name, words, colour, dash in (("simulated", "simulated", BLUE, "dot"), ("predicted", "predicted", GREEN, "solid")):
        values = np.array([factor * getattr(row, name) for row in rows])
        data.append(line(*thinned(along.of_windows, values), f"1X {words}", colour, dash, 1.1))
    data += _changes(report, along, 1.1 * factor * max(known))
    y = {"title": f"|r| at the contact in {unit}", "range": [0.0, 1.2 * factor * max(known)]}
    return {"data": named_once(data), "layout": axes({"title": along.title, "range": range_of(along)}, y, 380, across="x")}


def whirl_line(report, along):
    """The backward line of the windows on a whirl, simulated and predicted, at the body that moves more; None without one."""
    rows = [row for row in report.rows if row.quantity == AMPLITUDE]
    sizes = np.array([(row.simulated, row.predicted) if row.branch else (np.nan, np.nan) for row in rows]).T
    if not np.isfinite(sizes).any():
        return None
    factor, unit = unit_for(largest_finite(sizes), "m")
    drawn = zip(("simulated", "predicted"), (BLUE, RED), ("solid", "dash"), factor * sizes, strict=True)
    data = [line(*thinned(along.of_windows, size), f"whirl line, {name}", colour, dash) for name, colour, dash, size in drawn]
    y = {"title": f"whirl line in {unit}", "rangemode": "tozero"}
    return {"data": data, "layout": axes({"title": along.title, "range": range_of(along)}, y, 240, across="x")}


def _envelope(along, branch, factor):
    """What the unbalance makes of a stable whirl, as a band."""
    stable = np.asarray(branch.stable, bool)
    if not stable.any():
        return []
    low, high = (along.curve(branch.speed, np.where(stable, factor * branch.envelope(i), np.nan)) for i in (0, 1))
    known = np.isfinite(low[1])
    x, band = low[0][known], np.array([low[1][known], high[1][known]])
    places = np.unique(np.linspace(0, len(x) - 1, min(len(x), MOST_POINTS // 2)).astype(int))
    x, band = x[places], band[:, places]
    around = np.concatenate([x, x[::-1]]), np.concatenate([band[0], band[1][::-1]])
    more = {"fill": "toself", "fillcolor": BAND, "hoverinfo": "skip", "showlegend": False, "meta": branch.label}
    return [line(*around, "with the unbalance", BAND, width=0, **more)]


def _changes(report, along, top):
    """Vertical lines where the run changes its whirl, simulated and predicted."""
    data = []
    for i, change in enumerate(report.transitions if along.by_speed else ()):
        height = top * (1.0 - 0.06 * (i % 4))  # names of neighbours stand below each other
        name = f"{change.before or 'no whirl'} to {change.after or 'no whirl'}"
        for speed, word, dash in ((change.taken_over, "simulated", "solid"), (change.predicted_jump, "predicted", "dot")):
            if np.isfinite(speed):
                text = [f"{name}: {speed:.1f} Hz" if word == "simulated" else "", ""]
                label = f"{name}, {word}: {speed:.1f} Hz"
                data.append(line([speed] * 2, [height, 0.0], label, GREY, dash, 1.2, text=text, showlegend=word == "predicted"))
                data[-1]["mode"] = "lines+text" if word == "simulated" else "lines"
                data[-1]["textposition"] = "top right"
    return data


def strips(report, along):
    """name -> picture of normal force, friction power, contact share and, with a diameter, slip over the run."""
    strip = report.strip
    wanted = {
        "force": ("normal force, mean of a window", strip.normal_force, "N"),
        "power": ("friction power", strip.friction_power, "W"),
        "share": ("time in contact", 100.0 * strip.share, "%"),
    }
    if strip.slip_velocity is not None:
        wanted["slip"] = ("slip velocity (0: rolling)", strip.slip_velocity, "m/s")
    pictures = {}
    for key, (words, values, base) in wanted.items():
        factor, unit = (1.0, "%") if base == "%" else unit_for(largest_finite(np.abs(values)), base)
        x, y = thinned(along.of(strip), factor * values)
        data = [line(x, y, words, BLUE, showlegend=key == "force")]
        if key == "force":
            data.append(line(*thinned(along.of(strip), factor * strip.peak_force), "largest of a window", SKY, width=1.1))
            for b in (b for b in report.branches if b.stable.any()):
                curve = along.curve(b.speed, np.where(b.stable, factor * b.normal_force, np.nan))
                data.append(line(*thinned(*curve), "predicted whirl, stable", RED, "dash", 1.2, meta=b.label))
        y_axis = {"title": f"{words.partition(',')[0]} in {unit}", "rangemode": "tozero"}
        if base == "%":
            y_axis["range"] = [-4.0, 104.0]
        layout = axes({"title": along.title, "range": range_of(along)}, y_axis, 240, across="x")
        pictures[key] = {"data": named_once(data), "layout": layout}
    return pictures


def bode(report, along):
    """name -> picture of amplitude, phase and locus of the line at the rotor speed, in the frame of the shaft."""
    line_ = report.order
    factor, unit = unit_for(largest_finite(np.abs(line_)), "m")
    lag = -np.degrees(np.unwrap(np.angle(np.where(np.isfinite(line_), line_, 1.0))))
    lag = lag - 360.0 * np.round(np.median(lag) / 360.0)
    x = {"title": along.title, "range": range_of(along)}
    of = along.of_windows
    size = {"data": [line(*thinned(of, factor * np.abs(line_)), "1X", BLUE, showlegend=False)]}
    size["layout"] = axes(x, {"title": f"1X in {unit}", "rangemode": "tozero"}, 240, across="x", width=480)
    phase = {"data": [line(*thinned(of, lag), "phase lag", BLUE, showlegend=False)]}
    middle, half = 0.5 * (lag.max() + lag.min()), max(0.55 * float(np.ptp(lag)), LEAST_PHASE)
    degrees = {"title": "1X, phase lag in degrees", "range": [float(middle - half), float(middle + half)]}
    phase["layout"] = axes(x, degrees, 240, across="x", width=480)
    locus = factor * line_
    polar = {"data": [line(locus.real, locus.imag, "1X over the run", BLUE, width=1.2, showlegend=False)]}
    polar["data"].append(dots([locus[0].real], [locus[0].imag], "begin of the run", "none", GREY))
    reach = 1.1 * (largest_finite(np.abs(locus)) or 1.0)
    right, up = ({"title": f"{words}, {unit}", "range": [-reach, reach]} for words in ("to 0 degrees", "to 90 degrees"))
    polar["layout"] = axes(right, up, 340, equal=True, width=360)
    return {"bode_amplitude": size, "bode_phase": phase, "polar": polar}


def energy(report):
    """Where the energy of the run came from and went to."""
    ledger = report.result.ledger
    parts = {
        "unbalance, load": ledger.energy_in,
        "friction": ledger.friction_in,
        "in rotor": -ledger.rotor_damping,
        "in stator": -ledger.stator_damping,
        "in contact": -ledger.contact_damping,
        "stored": -ledger.change,
    }
    values = np.array(list(parts.values()))
    factor, unit = unit_for(largest_finite(np.abs(values)), "J")
    places = np.arange(len(parts))
    bars = {"type": "bar", "x": numbers(places), "y": numbers(factor * values), "name": "", "showlegend": False}
    bars["marker"] = {"color": [BLUE if value >= 0.0 else ORANGE for value in values]}
    top = 1.1 * max(factor * np.abs(values).max(initial=0.0), 1e-12)
    x = {"title": "put in (up) and taken out (down)", "range": [-0.6, len(parts) - 0.4]}
    x |= {"tickvals": places.tolist(), "ticktext": list(parts)}
    return {"data": [bars], "layout": axes(x, {"title": f"energy in {unit}", "range": [-top, top]}, 260)}
