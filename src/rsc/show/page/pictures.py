"""Pictures of a report as descriptions for plotly: traces and axes. `rsc.show.page.svg` draws the same ones on paper.

Conventions: forward whirl is positive frequency, backward negative; predictions are full where stable and dashed where unstable.
Colours are near those of Okabe and Ito, which colour-blind readers tell apart, and show on a light page as on a dark one.
"""

import base64

import numpy as np

from rsc.measure.words import AMPLITUDE, FREQUENCY, SYNCHRONOUS
from rsc.show.moments import filtered, marks_of, once_per_turn, place_of
from rsc.show.units import largest_finite, unit_for

BLUE, SKY, GREEN, ORANGE, RED, PURPLE, GREY = "#0b7cc4", "#56b4e9", "#009e73", "#d98e04", "#d55e00", "#b9689a", "#8a8a8a"
BAND = "rgba(213,94,0,0.16)"
RANGE_DB = 60.0
# cells of the amplitudes in the page, and points of a line
MOST_ROWS, MOST_COLUMNS, MOST_POINTS = 400, 720, 600
DIGITS = 5
TURN = np.exp(2j * np.pi * np.arange(73) / 72)
FILTERED_COLOURS = {"filtered at 1X": PURPLE, "filtered at the whirl": SKY}
CENTRED = 0.02  # gaps, of a mean position that is no shift
LEAST_PHASE = 10.0  # degrees, half the axis
MOST_TURNS = 120  # windows of which the positions once a turn are drawn


class Course:
    """The axis along the run that all pictures share: rotor speed where it runs one way only, otherwise time."""

    def __init__(self, report):
        speed, time = report.fall.speed, report.fall.time
        steps = np.diff(speed)
        self.by_speed = len(speed) > 1 and bool((steps > 0.0).all() or (steps < 0.0).all())
        self.of_windows = speed if self.by_speed else time
        self._window_speeds, self._time = speed, time
        self.title = "rotor speed in Hz" if self.by_speed else "time in s"

    def of(self, part):
        """Places of something with speed and time."""
        return part.speed if self.by_speed else part.time

    def curve(self, speed, values):
        """x and y of values over the rotor speed; over time NaN where the run is at a speed that they do not reach."""
        speed, values = np.asarray(speed, float), np.asarray(values, float)
        if self.by_speed:
            return speed, values
        order = np.argsort(speed)
        slack = 1e-9 * np.abs(speed).max(initial=0.0)
        inside = (self._window_speeds >= speed.min() - slack) & (self._window_speeds <= speed.max() + slack)
        return self._time, np.where(inside, np.interp(self._window_speeds, speed[order], values[order]), np.nan)


def line(x, y, name, colour, dash="solid", width=1.6, **more):
    """A line; what is not finite breaks it."""
    drawn = {"color": colour, "dash": dash, "width": width}
    return {"type": "scatter", "mode": "lines", "x": numbers(x), "y": numbers(y), "name": name, "line": drawn, **more}


def numbers(values):
    """A list for JSON: five digits, None for what is not finite."""
    return [float(f"{v:.{DIGITS}g}") if np.isfinite(v) else None for v in np.asarray(values, float).tolist()]


def thinned(x, y, most=MOST_POINTS):
    """A line with at most so many points that keeps the smallest and the largest value of every group."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    if len(x) <= most:
        return x, y
    places = []
    for group in np.array_split(np.arange(len(x)), most // 2):
        known = group[np.isfinite(y[group])]
        places += sorted({int(known[np.argmin(y[known])]), int(known[np.argmax(y[known])])}) if len(known) else [int(group[0])]
    return x[places], y[places]


def axes(x, y, height, **more):
    """A layout: titles, or dicts of an axis, and the height in pixels."""
    x, y = ({"title": axis} if isinstance(axis, str) else axis for axis in (x, y))
    return {"xaxis": x, "yaxis": y, "height": height, **more}


def campbell(report, course):
    """Amplitude over whirl frequency and the course of the run, with the predictions."""
    reach = _reach(report)
    data = [_amplitudes(report, course, reach), *_orders(report, course, reach), *_naturals(report, course, reach)]
    data += [
        {**trace, "x": trace["y"], "y": trace["x"]}
        for branch in report.branches
        if np.abs(branch.frequency).min() <= reach
        for trace in _branch(course, branch, branch.frequency, 1.0)
    ]
    rolls = [row.predicted if row.branch == "roll" else np.nan for row in report.rows if row.quantity == FREQUENCY]
    if np.isfinite(rolls).any():
        data.append(line(rolls, course.of_windows, "predicted whirl, rolling", ORANGE))
    frequency = {"title": "whirl frequency in Hz (backward < 0)", "range": [-reach, reach]}
    layout = axes(frequency, {"title": course.title, "range": _range(course)}, 460, across="y")
    return {"data": _named_once(data), "layout": layout}


def _orders(report, course, reach):
    """Lines at multiples of the rotor speed."""
    speeds, places = report.fall.speed, course.of_windows
    if course.by_speed:
        speeds = places = np.array([places.min(), places.max()])
    data = []
    for order in (-2, -1, 1, 2):
        line_ = order * speeds
        if np.abs(line_).min() <= reach:
            name = f"{order:+d}X".replace("-", "\N{MINUS SIGN}")
            data.append(line(line_, places, name, GREY, "dash", 0.9, showlegend=False, hoverinfo="name+x+y"))
    return data


def _naturals(report, course, reach):
    """Natural frequencies within reach."""
    data = []
    for name, colour in (("coupled", GREEN), ("uncoupled", PURPLE)):
        speed, frequency = report.natural[name]
        for column in np.asarray(frequency).T:
            if np.abs(column).min() <= reach:
                y, x = thinned(*course.curve(speed, column))
                data.append(line(x, y, f"natural, {name}", colour, "dashdot", 1.1, legendgroup=name))
    return data


def _named_once(data):
    """Traces of which only the first of a name stands in the legend."""
    names = set()
    for trace in data:
        if trace.get("showlegend") is not False and trace["name"] in names:
            trace["showlegend"] = False
        names.add(trace["name"])
    return data


def _range(course):
    low, high = float(course.of_windows.min()), float(course.of_windows.max())
    room = 0.5 * (high - low) / max(len(course.of_windows) - 1, 1) or 0.5
    return [low - room, high + room]


def _reach(report):
    """Frequency up to which there is something to be seen: the simulated lines, the stable whirls and 1X."""
    lines = [report.features.frequency, report.fall.speed]
    lines += [branch.frequency[branch.stable] for branch in report.branches]
    top = 1.15 * max(largest_finite(np.abs(each)) for each in lines)
    return min(max(top, 4.0 / report.fall.window), float(np.abs(report.fall.frequency).max()))


def _amplitudes(report, course, reach):
    """The amplitudes in dB re the largest as a heat map, thinned to the largest of neighbouring cells."""
    fall = report.fall
    inside = np.flatnonzero(np.abs(fall.frequency) <= reach)
    order = np.argsort(course.of_windows, kind="stable")
    grid = fall.amplitude[np.ix_(order, inside)]
    x, y = fall.frequency[inside], course.of_windows[order]
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


def packed(array):
    """An array as plotly reads it: base64 with type and shape."""
    kinds = {"int8": "i1", "int16": "i2", "float32": "f4"}
    text = base64.b64encode(np.ascontiguousarray(array)).decode()
    return {"dtype": kinds[array.dtype.name], "bdata": text, "shape": ", ".join(map(str, array.shape))}


def _branch(course, branch, values, factor):
    """Full line where a branch is stable, dashed where it is not, without a hole between."""
    stable = np.asarray(branch.stable, bool)
    unstable = ~stable
    dashed = unstable.copy()
    dashed[:-1] |= unstable[1:]
    dashed[1:] |= unstable[:-1]
    traces = []
    for shown, dash, word in ((stable, "solid", "stable"), (dashed, "dash", "unstable")):
        if shown.any():
            x, y = course.curve(branch.speed, np.where(shown, factor * np.asarray(values), np.nan))
            hover = f"whirl {branch.label}: %{{x:.5g}}, %{{y:.5g}}<extra></extra>"
            more = {"meta": branch.label, "legendgroup": word, "hovertemplate": hover}
            width = 1.8 if dash == "solid" else 1.2
            traces.append(line(*thinned(x, y), f"predicted whirl, {word}", RED, dash, width, **more))
    return traces


def amplitude(report, course, others=()):
    """Smallest and largest distance at the contact, gap, predicted whirls, forward rub and the line at the rotor speed."""
    gap = report.result.scene.contact.gap
    shown = [b for b in report.branches if b.stable.any() or b.label in {row.branch for row in report.rows}]
    known = [gap, largest_finite(report.envelope.maximum)]
    known += [largest_finite(b.amplitude[b.stable]) for b in shown]
    known += [largest_finite(other.envelope.maximum) for other in others]
    factor, unit = unit_for(max(known), "m")
    at = course.of(report.envelope)
    data = [
        line(*thinned(at, factor * report.envelope.maximum), "simulated, largest", BLUE, width=1.4),
        line(*thinned(at, factor * report.envelope.minimum), "simulated, smallest", SKY, width=1.2),
        line(_range(course), [factor * gap] * 2, "gap", GREY, "dashdot", 1.2),
    ]
    for other in others if course.by_speed else ():
        way = f"{other.result.scene.drive.speed[0]:g} to {other.result.scene.drive.speed[-1]:g} Hz"
        for values, words in ((other.envelope.maximum, "largest"), (other.envelope.minimum, "smallest")):
            data.append(line(*thinned(other.envelope.speed, factor * values), f"run {way}, {words}", ORANGE, "solid", 1.2))
    for branch in shown:
        data += _envelope(course, branch, factor) + _branch(course, branch, branch.amplitude, factor)
    if np.isfinite(report.rub[1]).any():
        data.append(line(*thinned(*course.curve(report.rub[0], factor * report.rub[1])), "forward rub, closed form", PURPLE))
    rows = [row for row in report.rows if row.quantity == SYNCHRONOUS]
    for name, words, colour, dash in (("simulated", "simulated", BLUE, "dot"), ("predicted", "predicted", GREEN, "solid")):
        values = np.array([factor * getattr(row, name) for row in rows])
        data.append(line(*thinned(course.of_windows, values), f"1X {words}", colour, dash, 1.1))
    data += _changes(report, course, 1.1 * factor * max(known))
    y = {"title": f"|r| at the contact in {unit}", "range": [0.0, 1.2 * factor * max(known)]}
    return {"data": _named_once(data), "layout": axes({"title": course.title, "range": _range(course)}, y, 380, across="x")}


def whirl_line(report, course):
    """The backward line of the windows on a whirl, simulated and predicted, at the body that moves more; None without one."""
    rows = [row for row in report.rows if row.quantity == AMPLITUDE]
    sizes = np.array([(row.simulated, row.predicted) if row.branch else (np.nan, np.nan) for row in rows]).T
    if not np.isfinite(sizes).any():
        return None
    factor, unit = unit_for(largest_finite(sizes), "m")
    drawn = zip(("simulated", "predicted"), (BLUE, RED), ("solid", "dash"), factor * sizes, strict=True)
    data = [line(*thinned(course.of_windows, size), f"whirl line, {name}", colour, dash) for name, colour, dash, size in drawn]
    y = {"title": f"whirl line in {unit}", "rangemode": "tozero"}
    return {"data": data, "layout": axes({"title": course.title, "range": _range(course)}, y, 240, across="x")}


def _envelope(course, branch, factor):
    """What the unbalance makes of a stable whirl, as a band."""
    stable = np.asarray(branch.stable, bool)
    if not stable.any():
        return []
    low, high = (course.curve(branch.speed, np.where(stable, factor * branch.envelope(i), np.nan)) for i in (0, 1))
    known = np.isfinite(low[1])
    x, band = low[0][known], np.array([low[1][known], high[1][known]])
    places = np.unique(np.linspace(0, len(x) - 1, min(len(x), MOST_POINTS // 2)).astype(int))
    x, band = x[places], band[:, places]
    around = np.concatenate([x, x[::-1]]), np.concatenate([band[0], band[1][::-1]])
    more = {"fill": "toself", "fillcolor": BAND, "hoverinfo": "skip", "showlegend": False, "meta": branch.label}
    return [line(*around, "with the unbalance", BAND, width=0, **more)]


def _changes(report, course, top):
    """Vertical lines where the run changes its whirl, simulated and predicted."""
    data = []
    for change in report.transitions if course.by_speed else ():
        name = f"{change.before or 'no whirl'} to {change.after or 'no whirl'}"
        for speed, word, dash in ((change.taken_over, "simulated", "solid"), (change.predicted_jump, "predicted", "dot")):
            if np.isfinite(speed):
                text = [f"{name}: {speed:.1f} Hz" if word == "simulated" else "", ""]
                label = f"{name}, {word}: {speed:.1f} Hz"
                data.append(line([speed] * 2, [top, 0.0], label, GREY, dash, 1.2, text=text, showlegend=word == "predicted"))
                data[-1]["mode"] = "lines+text" if word == "simulated" else "lines"
                data[-1]["textposition"] = "top right"
    return data


def strips(report, course):
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
        x, y = thinned(course.of(strip), factor * values)
        data = [line(x, y, words, BLUE, showlegend=key == "force")]
        if key == "force":
            data.append(line(*thinned(course.of(strip), factor * strip.peak_force), "largest of a window", SKY, width=1.1))
            for b in (b for b in report.branches if b.stable.any()):
                curve = course.curve(b.speed, np.where(b.stable, factor * b.normal_force, np.nan))
                data.append(line(*thinned(*curve), "predicted whirl, stable", RED, "dash", 1.2, meta=b.label))
        y_axis = {"title": f"{words.partition(',')[0]} in {unit}", "rangemode": "tozero"}
        if base == "%":
            y_axis["range"] = [-4.0, 104.0]
        layout = axes({"title": course.title, "range": _range(course)}, y_axis, 240, across="x")
        pictures[key] = {"data": _named_once(data), "layout": layout}
    return pictures


def bode(report, course):
    """name -> picture of amplitude, phase and locus of the line at the rotor speed, in the frame of the shaft."""
    line_ = report.order
    factor, unit = unit_for(largest_finite(np.abs(line_)), "m")
    lag = -np.degrees(np.unwrap(np.angle(np.where(np.isfinite(line_), line_, 1.0))))
    lag = lag - 360.0 * np.round(np.median(lag) / 360.0)
    x = {"title": course.title, "range": _range(course)}
    of = course.of_windows
    size = {"data": [line(*thinned(of, factor * np.abs(line_)), "1X", BLUE, showlegend=False)]}
    size["layout"] = axes(x, {"title": f"1X in {unit}", "rangemode": "tozero"}, 240, across="x", width=480)
    phase = {"data": [line(*thinned(of, lag), "phase lag", BLUE, showlegend=False)]}
    middle, half = 0.5 * (lag.max() + lag.min()), max(0.55 * float(np.ptp(lag)), LEAST_PHASE)
    degrees = {"title": "1X, phase lag in degrees", "range": [float(middle - half), float(middle + half)]}
    phase["layout"] = axes(x, degrees, 240, across="x", width=480)
    locus = factor * line_
    polar = {"data": [line(locus.real, locus.imag, "1X over the run", BLUE, width=1.2, showlegend=False)]}
    polar["data"].append(_dots([locus[0].real], [locus[0].imag], "begin of the run", "none", GREY))
    reach = 1.1 * (largest_finite(np.abs(locus)) or 1.0)
    right, up = ({"title": f"{words}, {unit}", "range": [-reach, reach]} for words in ("to 0 degrees", "to 90 degrees"))
    polar["layout"] = axes(right, up, 340, equal=True, width=360)
    return {"bode_amplitude": size, "bode_phase": phase, "polar": polar}


def centre_line(report):
    """Mean positions of the rotor over the run within the gap, None where it stays in the middle."""
    gap = report.result.scene.contact.gap
    if largest_finite(np.abs(report.centre)) < CENTRED * gap:
        return None
    factor, unit = unit_for(gap, "m")
    circle, centre = factor * gap * TURN, factor * report.centre
    data = [line(circle.real, circle.imag, "gap", GREY, "dash", 1.1), line(centre.real, centre.imag, "centre", BLUE, width=1.4)]
    data.append(_dots([centre[0].real], [centre[0].imag], "begin of the run", "none", GREY))
    return {"data": data, "layout": axes(f"y in {unit}", f"z in {unit}", 340, equal=True, width=360)}


def once_a_turn(report, course):
    """Distance of the rotor at every revolution of the shaft that the kept paths hold, over the run."""
    factor, unit = unit_for(max(largest_finite(np.abs(report.orbits.rotor)), report.result.scene.contact.gap), "m")
    windows = np.unique(np.linspace(0, len(report.fall.speed) - 1, MOST_TURNS).round().astype(int))
    sizes = [factor * np.abs(once_per_turn(report, int(window))) for window in windows]
    places = np.repeat(course.of_windows[windows], [len(size) for size in sizes])
    dots = _dots(places, np.concatenate(sizes), "once a revolution", BLUE, size=3) | {"showlegend": False}
    y = {"title": f"|r| once a revolution in {unit}", "rangemode": "tozero"}
    return {"data": [dots], "layout": axes({"title": course.title, "range": _range(course)}, y, 260, across="x")}


def _dots(x, y, name, colour, ring=None, size=6):
    marker = {"color": colour, "size": size} | ({"line": {"color": ring, "width": 1.2}} if ring else {})
    return {"type": "scatter", "mode": "markers", "x": numbers(x), "y": numbers(y), "name": name, "marker": marker}


def orbit(report, window):
    """The path in the middle of a window: rotor, contact, stator, gap and one mark a revolution."""
    orbits, gap = report.orbits, report.result.scene.contact.gap
    factor, unit = unit_for(max(largest_finite(np.abs(orbits.rotor)), gap), "m")
    rotor, stator = factor * orbits.rotor[window], factor * orbits.stator[window]
    data = traces_of_orbit(rotor, stator, orbits.normal_force[window] > 0.0, marks_of(report, window), factor * gap)
    for name, (centre, radius) in filtered(report, window).items():
        path = factor * (centre + radius * TURN)
        data.append(line(path.real, path.imag, name, FILTERED_COLOURS[name], "dot", 1.4))
    return {"data": data, "layout": axes(f"y in {unit}", f"z in {unit}", 340, equal=True, width=360)}


def traces_of_orbit(rotor, stator, touching, marks, gap):
    """Traces of a path; all in one unit."""
    middle = stator.mean()
    circle = middle + gap * TURN
    held = np.where(touching, rotor, np.nan + 1j * np.nan)
    data = [
        line(circle.real, circle.imag, "gap", GREY, "dash", 1.1),
        line(rotor.real, rotor.imag, "rotor", BLUE, width=1.2),
        line(held.real, held.imag, "in contact", RED, width=2.2),
    ]
    if np.abs(stator - middle).max() > 0.0:
        data.append(line(stator.real, stator.imag, "stator", GREEN, width=1.1))
    data.append(_dots(rotor[marks].real, rotor[marks].imag, "once a revolution", "#ffffff", "#444444", 7))
    return data


def moments(report, chosen):
    """(caption, picture) of every moment."""
    return [(f"{moment.text}, {place_of(report, moment.window)}", orbit(report, moment.window)) for moment in chosen]


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


def at_cursor(report, course, most=120):
    """Values and paths of at most so many windows, which the page shows where its cursor stands."""
    n_windows = len(report.fall.speed)
    chosen = np.unique(np.linspace(0, n_windows - 1, min(n_windows, most)).round().astype(int))
    orbits, gap = report.orbits, report.result.scene.contact.gap
    factor, unit = unit_for(max(largest_finite(np.abs(orbits.rotor)), gap), "m")
    motions = np.array([orbits.rotor[chosen], orbits.stator[chosen]])
    scale = max(largest_finite(np.abs(motions)), gap) / 32000.0
    by = {q: [row for row in report.rows if row.quantity == q] for q in (FREQUENCY, AMPLITUDE, SYNCHRONOUS)}
    values = [[factor * getattr(by[q][i], name) if q != FREQUENCY else getattr(by[q][i], name) for i in chosen]
              for q in by for name in ("simulated", "predicted")]  # fmt: skip
    coordinates = np.stack([motions.real, motions.imag], axis=-1) / scale
    return {
        "place": numbers(course.of_windows[chosen]),
        "speed": numbers(report.fall.speed[chosen]),
        "time": numbers(report.fall.time[chosen]),
        "values": [numbers(column) for column in values],
        "verdict": [by[FREQUENCY][i].verdict for i in chosen],
        "branch": [by[FREQUENCY][i].branch for i in chosen],
        "force": numbers(report.strip.normal_force[chosen]),
        "share": numbers(report.strip.share[chosen]),
        "paths": packed(np.round(np.nan_to_num(coordinates)).astype(np.int16)),
        "touching": packed((orbits.normal_force[chosen] > 0.0).astype(np.int8)),
        "marks": [marks_of(report, int(i)).tolist() for i in chosen],
        "scale": scale * factor,
        "gap": gap * factor,
        "reach": factor * max(largest_finite(np.abs(orbits.rotor)), gap),
        "unit": unit,
    }
