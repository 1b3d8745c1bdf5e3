"""Pictures of a report along its run as descriptions in the words of plotly; `rsc.show.page.svg` and `plots` draw them too.

Conventions: forward whirl is positive frequency, backward negative; predictions are full where stable, dashed where unstable,
dotted where nothing is claimed.
"""

import numpy as np

from rsc.measure.stretches import at_contacts
from rsc.measure.windows import ROLL
from rsc.show.pictures.lasting import lasting_marks
from rsc.show.pictures.moments import seen_lines
from rsc.show.pictures.stability import parts, stability
from rsc.show.pictures.traces import (
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
from rsc.show.words.units import column, largest_finite, unit_for
from rsc.show.words.wording import frequencies_text, frequency_text

BAND = "#d55e0029"
RANGE_DB = 60.0
MOST_ROWS, MOST_COLUMNS = 400, 720  # cells of the amplitudes in the page
COLOURS = (GREEN, ORANGE, PURPLE)  # of contacts beside the one that a report is at
MOST_STACKED, STACK_HEIGHT = 50, 0.2  # lines of a waterfall, and the highest over the vertical axis
FREQUENCY_TITLE = "whirl frequency in Hz (backward < 0)"
DASHES = {"stable": "solid", "touches a clearance": "dashdot", "unstable": "dash", "not circular: stability not assessed": "dot"}
WIDER = 2.0  # times the reach without them, up to which motions that last widen it
LEAST_PHASE = 10.0  # degrees, half the axis


def campbell(report, along, fall=None):
    """Amplitude over whirl frequency and the course of the run, with the predictions; of the rotor or of another waterfall."""
    reach = _reach(report)
    data = [amplitudes(fall or report.fall, along, reach), *orders(report, along, reach), *_naturals(report, along, reach)]
    data += [
        {**trace, "x": trace["y"], "y": trace["x"]}
        for branch in report.branches
        if np.abs(branch.frequency).min() <= reach
        for trace in _branch(along, branch, branch.frequency, 1.0)
    ]
    rolls = [window.frequency.predicted if window.branch == ROLL else np.nan for window in report.windows]
    if np.isfinite(rolls).any():
        data.append(line(rolls, along.of_windows, "predicted whirl, rolling", ORANGE))
    data += lasting_marks(report, along, reach)
    frequency = {"title": FREQUENCY_TITLE, "range": [-reach, reach]}
    layout = axes(frequency, {"title": along.title, "range": range_of(along)}, 460, across="y")
    return {"data": named_once(data), "layout": layout}


def campbell_of_stator(report, along):
    """`campbell` of the stator's motion; None where it does not move."""
    moves = report.stator_fall is not None and np.any(report.stator_fall.amplitude > 0.0)
    return campbell(report, along, report.stator_fall) if moves else None


def waterfall(report, along):
    """Stacked spectra: each line stands on its place along the run and shows the largest amplitudes of its windows."""
    return cascade(report, along, _reach(report))


def cascade(report, along, reach):
    """`waterfall` up to a frequency in Hz, of whatever has a `fall`."""
    frequency, places, grid = _thinned_grid(report.fall, along, reach, MOST_STACKED)
    low, high = range_of(along)
    largest = largest_finite(grid) or 1.0
    scale = STACK_HEIGHT * (high - low) / largest
    data, around = [], np.concatenate([frequency[:1], frequency, frequency[-1:]])
    for place, amplitude in zip(places[::-1], grid[::-1], strict=True):  # the lower ones stand in front
        heights = place + scale * np.concatenate([[0.0], np.nan_to_num(amplitude), [0.0]])
        data.append(line(around, heights, "", "#222222", width=0.8, fill="toself", fillcolor="#ffffff", showlegend=False))
    factor, unit = unit_for(largest, "m")
    bar = {"mode": "lines+text", "text": ["", f"{factor * largest:.3g} {unit}"], "textposition": "top right", "showlegend": False}
    data.append(line([1.05 * reach] * 2, [low, low + scale * largest], "", "#222222", width=3.0, **bar))
    data += orders(report, along, reach, (-1, 1))
    layout = axes({"title": FREQUENCY_TITLE, "range": [-reach, 1.25 * reach]}, {"title": along.title}, 460)
    layout["yaxis"]["range"] = [low, max(high, float((places + scale * grid.max(axis=1)).max())) + 0.03 * (high - low)]
    return {"data": data, "layout": layout}


def orders(report, along, reach, orders=(-2, -1, 1, 2)):
    """Lines at multiples of the rotor speed, labelled at the far end."""
    speeds, places = report.fall.speed, along.of_windows
    if along.by_speed:
        speeds = places = np.linspace(places.min(), places.max(), 50)
    data = []
    low, high = range_of(along)
    for order in orders:
        line_ = order * speeds
        inside = (np.abs(line_) <= 0.97 * reach) & (places <= high - 0.06 * (high - low))
        if inside.any():
            name = f"{order:+d}X".replace("-", "\N{MINUS SIGN}")
            far = np.flatnonzero(inside)[np.argsort(np.abs(line_[inside]), kind="stable")[-1]]  # of equal ones the last
            text = [name if i == far else "" for i in range(len(line_))]
            more = {"mode": "lines+text", "text": text, "textposition": "top left" if order > 0 else "top right"}
            data.append(line(line_, places, name, GREY, "dash", 0.9, showlegend=False, hoverinfo="name+x+y", **more))
    return data


def _naturals(report, along, reach):
    """Natural frequencies within reach."""
    data = []
    for name, colour in (("coupled", GREEN), ("uncoupled", PURPLE)):
        speed, frequency = report.natural[name]
        for mode in np.asarray(frequency).T:
            if np.abs(mode).min() <= reach:
                y, x = thinned(*along.curve(speed, mode))
                data.append(line(x, y, f"natural frequency, {name}", colour, "dashdot", 1.1, legendgroup=name))
    return data


def _reach(report):
    """Frequency up to which there is something to be seen: the simulated lines, the stable whirls and 1X."""
    lines = [seen_lines(report), report.fall.speed]
    lines += [branch.frequency[branch.stable] for branch in report.branches]
    top = 1.15 * max(largest_finite(np.abs(each)) for each in lines)
    lasting = [1.15 * abs(motion.frequency) for listed in report.motions for motion in listed.motions if motion.bounded]
    top = max([top, *(each for each in lasting if each <= WIDER * top)])  # what is far beyond is marked at the edge
    return min(max(top, 4.0 / report.fall.window), float(np.abs(report.fall.frequency).max()))


def _thinned_grid(fall, along, reach, most_rows):
    """Frequencies (columns,), places along the run (rows,), rising, and amplitudes: of neighbouring cells the largest."""
    inside = np.flatnonzero(np.abs(fall.frequency) <= reach)
    order = np.argsort(along.of_windows, kind="stable")
    grid = fall.amplitude[np.ix_(order, inside)]
    x, y = fall.frequency[inside], along.of_windows[order]
    for axis, most in enumerate((most_rows, MOST_COLUMNS)):
        if grid.shape[axis] > most:
            starts = np.arange(most + 1) * grid.shape[axis] // most
            grid, middle = np.fmax.reduceat(grid, starts[:-1], axis=axis), (starts[1:] + starts[:-1] - 1) // 2
            x, y = (x, y[middle]) if axis == 0 else (x[middle], y)
    return x, y, grid


def amplitudes(fall, along, reach):
    """The amplitudes in dB re the largest as a heat map."""
    x, y, grid = _thinned_grid(fall, along, reach, MOST_ROWS)
    largest = largest_finite(grid) or 1.0
    level = 20.0 * np.log10(np.maximum(np.nan_to_num(grid) / largest, 10.0 ** (-RANGE_DB / 20.0)))
    factor, unit = unit_for(largest, "m")
    rows = np.abs(np.linspace(y[0], y[-1], len(y))[:, None] - y).argmin(axis=1)  # the image on paper has equal rows
    on_paper = np.where(np.isfinite(grid), 1.0 + level / RANGE_DB, np.nan)[rows]
    return {
        "type": "heatmap",
        "x": numbers(x),
        "y": numbers(y),
        "z": packed(np.round(level).astype(np.int8)),
        "levels": on_paper,
        "zmin": -RANGE_DB,
        "zmax": 0.0,
        "name": "",
        "colorbar": {"title": {"text": f"dB re {factor * largest:.3g} {unit}", "side": "right"}, "thickness": 12},
        "hovertemplate": f"%{{x:.2f}} {column('Hz')[1]}, %{{y:.2f}}: %{{z}} dB<extra></extra>",
    }


def _branch(along, branch, values, factor):
    """The line of a branch along the run, which the page can pick out."""
    hover = f"whirl {branch.label}: %{{x:.5g}}, %{{y:.5g}}<extra></extra>"
    traces = stretches_of(branch.speed, factor * np.asarray(values), stability(branch), "predicted whirl", RED, along.curve)
    return [trace | {"meta": branch.label, "hovertemplate": hover} for trace in traces]


def stretches_of(speed, values, stable, name, colour, curve=lambda x, y: (x, y)):
    """Full line where a predicted motion is stable, dashed where it is not, dotted where nothing is claimed (`stable` as from
    `rsc.show.pictures.stability.stability`), without a hole between; curve : to the axes of the picture."""
    traces = []
    for word, shown in parts(stable, np.isfinite(values)).items():
        x, y = curve(speed, np.where(shown, values, np.nan))
        width = 1.8 if word == "stable" else 1.2
        traces.append(line(*thinned(x, y), f"{name}, {word}", colour, DASHES[word], width, legendgroup=word))
    return traces


def amplitude(report, along, others=()):
    """Smallest and largest distance at the contact, gap, predicted whirls, forward rub and the line at the rotor speed."""
    gap = report.contact.gap
    shown = [b for b in report.branches if b.stable.any() or b.label in {window.branch for window in report.windows}]
    known = [gap, largest_finite(report.envelope.maximum)]
    known += [largest_finite(b.amplitude[b.stable]) for b in shown]
    known += [largest_finite(other.envelope.maximum) for other in others]
    factor, unit = unit_for(max(known), "m")
    at = along.of(report.envelope)
    data = [
        line(*thinned(at, factor * report.envelope.maximum), f"{report.word}, largest", BLUE, width=1.4),
        line(*thinned(at, factor * report.envelope.minimum), f"{report.word}, smallest", SKY, width=1.2),
        line(range_of(along), [factor * gap] * 2, "gap", GREY, "dashdot", 1.2),
    ]
    for other in others if along.by_speed else ():
        way = frequencies_text(other.result.scene.drive.speed[0], other.result.scene.drive.speed[-1], "g")
        for values, words in ((other.envelope.maximum, "largest"), (other.envelope.minimum, "smallest")):
            data.append(line(*thinned(other.envelope.speed, factor * values), f"run {way}, {words}", ORANGE, "solid", 1.2))
    for branch in shown:
        data += _envelope(along, branch, factor) + _branch(along, branch, branch.amplitude, factor)
    if np.isfinite(report.rub[1]).any():
        data.append(line(*thinned(*along.curve(report.rub[0], factor * report.rub[1])), "forward rub, closed form", PURPLE))
    rows = [window.synchronous for window in report.windows]
    for name, words, colour, dash in (("simulated", report.word, BLUE, "dot"), ("predicted", "predicted", GREEN, "solid")):
        values = np.array([factor * getattr(row, name) for row in rows])
        data.append(line(*thinned(along.of_windows, values), f"1X {words}", colour, dash, 1.1))
    data += _changes(report, along, 1.1 * factor * max(known))
    y = {"title": f"|r| at {report.lead or 'the contact'} in {unit}", "range": [0.0, 1.2 * factor * max(known)]}
    return {"data": named_once(data), "layout": axes({"title": along.title, "range": range_of(along)}, y, 380, across="x")}


def whirl_line(report, along):
    """The backward line of the windows on a whirl, simulated and predicted, at the body that moves more; None without one."""
    rows = [window.amplitude for window in report.windows]
    sizes = np.array([(row.simulated, row.predicted) if row.branch else (np.nan, np.nan) for row in rows]).T
    if not np.isfinite(sizes).any():
        return None
    factor, unit = unit_for(largest_finite(sizes), "m")
    drawn = zip((report.word, "predicted"), (BLUE, RED), ("solid", "dash"), factor * sizes, strict=True)
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
    data, middle = [], 0.5 * sum(range_of(along))
    for i, change in enumerate(report.transitions if along.by_speed else ()):
        height = top * (1.0 - 0.06 * (i % 4))  # names of neighbours stand below each other
        name = f"{change.before or 'no whirl'} to {change.after or 'no whirl'}"
        for speed, word, dash in ((change.taken_over, report.word, "solid"), (change.predicted_jump, "predicted", "dot")):
            if np.isfinite(speed):
                text = [f"{name}: {frequency_text(speed, '.1f')}" if word == report.word else "", ""]
                label = f"{name}, {word}: {frequency_text(speed, '.1f')}"
                data.append(line([speed] * 2, [height, 0.0], label, GREY, dash, 1.2, text=text, showlegend=word == "predicted"))
                data[-1]["mode"] = "lines+text" if word == report.word else "lines"
                data[-1]["textposition"] = "top left" if speed > middle else "top right"
    return data


def force(report, along):
    """Normal force over the run: mean and largest of every window, and that of the stable whirls; None of a measured run, and of
    one without contact where no whirl is stable."""
    if not _touches(report) and (report.strip is None or not any(branch.stable.any() for branch in report.branches)):
        return None
    strip, factor, picture = _strip(report, along, "normal force, mean of a window", report.strip.normal_force, "N")
    picture["data"][0]["showlegend"] = True
    picture["data"].append(line(*thinned(along.of(strip), factor * strip.peak_force), "largest of a window", SKY, width=1.1))
    _beside(picture, report, along, "force", factor)
    for branch in (branch for branch in report.branches if branch.stable.any()):
        curve = along.curve(branch.speed, np.where(branch.stable, factor * branch.normal_force, np.nan))
        picture["data"].append(line(*thinned(*curve), "predicted whirl, stable", RED, "dash", 1.2, meta=branch.label))
    named_once(picture["data"])
    return picture


def _beside(picture, report, along, quantity, factor):
    """Lines of a quantity at the other ones of several contacts into a picture, all with their names; nothing with one."""
    if not report.lead:
        return
    picture["data"][0] |= {"name": f"{picture['data'][0]['name']}, at {report.lead}", "showlegend": True}
    for i, (name, own) in enumerate((name, own) for name, own in report.contacts.items() if name != report.lead):
        values, colour = factor * getattr(own, quantity), COLOURS[i % len(COLOURS)]
        picture["data"].append(line(*thinned(along.of_windows, values), f"the same at {name}", colour, width=1.2))


def _touches(report):
    """Whether a run has contact, at any of its contacts; not of a measured one, whose probes do not see it."""
    return report.strip is not None and any(own.contact_time.any() for own in at_contacts(report.result))


def power(report, along):
    """Power of friction over the run; None of one without contact."""
    return _strip(report, along, "friction power", report.strip.friction_power, "W")[2] if _touches(report) else None


def share(report, along):
    """Share of the time in contact over the run; None of one without contact."""
    if not _touches(report):
        return None
    picture = _strip(report, along, "time in contact", 100.0 * report.strip.share, "%")[2]
    _beside(picture, report, along, "share", 100.0)
    picture["layout"]["yaxis"]["range"] = [-4.0, 104.0]
    return picture


def slip(report, along):
    """Slip of the surfaces over the run; None without contact or a diameter."""
    values = report.strip.slip_velocity if _touches(report) else None
    return None if values is None else _strip(report, along, "slip velocity (0: rolling)", values, "m/s")[2]


def _strip(report, along, words, values, base):
    """(strip, factor, picture) of one quantity of the contact over the run."""
    factor, unit = (1.0, "%") if base == "%" else unit_for(largest_finite(np.abs(values)), base)
    data = [line(*thinned(along.of(report.strip), factor * values), words, BLUE, showlegend=False)]
    y = {"title": f"{words.partition(',')[0]} in {unit}", "rangemode": "tozero"}
    layout = axes({"title": along.title, "range": range_of(along)}, y, 240, across="x")
    return report.strip, factor, {"data": data, "layout": layout}


def bode_amplitude(report, along):
    """Amplitude of the line at the rotor speed over the run; for a measured run with the predicted ones."""
    factor, unit = unit_for(largest_finite(np.abs(report.order)), "m")
    data = [line(*thinned(along.of_windows, factor * np.abs(report.order)), "1X", BLUE, showlegend=False)]
    if report.stretches is None:
        data[0] = data[0] | {"name": "1X measured", "showlegend": True}
        on_whirl = [window.synchronous.predicted if window.branch else np.nan for window in report.windows]
        data.append(line(*thinned(along.of_windows, factor * np.array(on_whirl)), "predicted on the whirl", RED, "dash", 1.2))
        data.append(line(*thinned(along.of_windows, factor * report.alone), "predicted without contact", GREEN, "dash", 1.2))
        rub = along.curve(report.rub[0], factor * report.rub[1])
        data.append(line(*thinned(*rub), "predicted forward rub", PURPLE, "dash", 1.2))
    y = {"title": f"1X in {unit}", "rangemode": "tozero"}
    return {"data": data, "layout": axes({"title": along.title, "range": range_of(along)}, y, 240, across="x", width=480)}


def bode_phase(report, along):
    """Angle by which the line at the rotor speed lags behind the mark on the shaft."""
    known = np.isfinite(report.order)
    lag = np.full(len(known), np.nan)
    lag[known] = -np.degrees(np.unwrap(np.angle(report.order[known])))
    lag = lag - 360.0 * np.round(np.nanmedian(lag) / 360.0)
    middle, half = 0.5 * (np.nanmax(lag) + np.nanmin(lag)), max(0.55 * float(np.ptp(lag[known])), LEAST_PHASE)
    data = [line(*thinned(along.of_windows, lag), "phase lag", BLUE, showlegend=False)]
    y = {"title": "1X, phase lag in degrees", "range": [float(middle - half), float(middle + half)]}
    return {"data": data, "layout": axes({"title": along.title, "range": range_of(along)}, y, 240, across="x", width=480)}


def polar(report, along):
    """Locus of the line at the rotor speed in the frame of the shaft."""
    factor, unit = unit_for(largest_finite(np.abs(report.order)), "m")
    locus = factor * report.order[np.isfinite(report.order)]
    data = [
        line(locus.real, locus.imag, "1X over the run", BLUE, width=1.2, showlegend=False),
        dots([locus[0].real], [locus[0].imag], "begin of the run", "none", GREY),
    ]
    reach = 1.1 * (largest_finite(np.abs(locus)) or 1.0)
    right, up = ({"title": f"{words}, {unit}", "range": [-reach, reach]} for words in ("to 0 degrees", "to 90 degrees"))
    return {"data": data, "layout": axes(right, up, 340, equal=True, width=360)}


def energy(report, along):
    """Where the energy of the run came from and went to; None of a measured one."""
    if report.result.summary is None:
        return None
    ledger = report.result.ledger
    parts = {
        "unbalance, load": ledger.energy_in,
        **({"turning shaft": ledger.turned_in} if ledger.turned_in else {}),
        **({"following springs": ledger.followed_in} if ledger.followed_in else {}),
        **({"drive": ledger.driven_in} if ledger.driven_in else {}),
        **({"control": ledger.control_in} if ledger.control_in else {}),
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
