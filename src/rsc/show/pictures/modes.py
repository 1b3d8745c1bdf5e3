"""Modes of a machine as tables and as a Campbell diagram."""

import math

import numpy as np

from rsc.errors import one_line
from rsc.show.pictures.traces import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, axes, dots, in_units, line, named_once
from rsc.show.words.table import exact, table
from rsc.show.words.units import column
from rsc.show.words.wording import frequency_text

SHOWN = 8  # modes of each part in a table and a picture: the slowest
LEAST, REACH = 4, 4.0  # lines of a Campbell diagram that are always drawn, and others: below so many times the highest speed
HEAVY = 3.0  # logarithmic decrement up to which it is drawn
COLOURS = {"forward": BLUE, "backward": RED, "straight": GREEN, "mixed": PURPLE, "-": ORANGE}
INK = "#222222"


def modes_text(modes, title, most=SHOWN, machine=()):
    """Tables of the slowest modes at one rotor speed; machine: lines (topic, text) on the rotor, told first."""
    lines = [one_line(title)] if title else []
    lines += [f"{topic}: {text}" for topic, text in machine]
    lines.append(f"modes at {_speed(modes.speed)}")
    names = {"rotor": "the rotor, free", "stator": "the stator", "coupled": "both, joined at the contact"}
    for part, own in modes.parts.items():
        lines += ["", f"{names[part]}: {_told(own, most)}"]
        if own:
            header = ("frequency Hz", "rpm", "undamped Hz", "decrement", "growth 1/s", "participation", "sense", "remark")
            lines.append(table(header, [_row(mode) for mode in own[:most]]))
    return "\n".join(lines)


def model_text(modes, model, speed):
    """Table of the slowest modes of a `rsc.machine.model.model.FiniteElementModel`, as it was read."""
    told = f"the slowest {len(modes)} modes at {_speed(speed)}"
    lines = [f"{one_line(model.source)}, as it was read", told]
    rows = [
        (
            exact(f"{mode.frequency:.5g}", mode.frequency), f"{60.0 * mode.frequency:.5g}", _number(mode.decrement, "+.4g"),
            f"{mode.growth_rate:+.4g}", "",
        )
        for mode in modes
    ]
    return "\n".join([*lines, table(("frequency Hz", "rpm", "decrement", "growth 1/s", ""), rows)])


def campbell_text(modes, title, most=SHOWN):
    """A table of the rotor's slowest modes over the rotor speed, frequency and decrement, and the critical speeds."""
    shown = _slowest(modes)[:most]
    header = ("speed Hz", *(f"mode {i + 1}" for i in range(len(shown))), "")
    rows = [
        (exact(f"{each.speed:.4g}", each.speed), *("-" if own[i] is None else _cell(each.rotor[own[i]]) for own in shown), "")
        for i, each in enumerate(modes)
    ]
    lines = [one_line(title)] if title else []
    about = f"the rotor, free: damped frequency in {column('Hz')[1]} (logarithmic decrement); negative: backward"
    lines += [about + ("; -: does not oscillate" if any(None in own for own in shown) else ""), table(header, rows)]
    return "\n".join([*lines, criticals_text(modes.criticals)])


def _slowest(modes):
    """The lines of a `rsc.Campbell` by their lowest frequency."""
    return sorted(modes.lines, key=lambda own: min(abs(mode.frequency) for mode in _along(modes, own) if mode))


def _along(modes, own):
    """The modes of one line, None where it has none."""
    return [None if i is None else each.rotor[i] for each, i in zip(modes, own, strict=True)]


def criticals_text(criticals):
    """The critical speeds in words."""
    if not criticals:
        return "critical speeds: none between these speeds"
    return "critical speeds: " + ", ".join(map(_speed, criticals))


def _speed(speed):
    """A rotor speed, and as rpm."""
    return frequency_text(speed, ".2f") + (f" ({60.0 * speed:.0f} rpm)" if column("Hz")[1] == "Hz" else "")


def campbell(modes):
    """Descriptions of both pictures of a `rsc.analysis.alone.modes.Campbell`: the lines that come below four times the highest
    speed, at least four of them, by the size of their frequency and in the colour of their sense."""
    speeds = np.array([each.speed for each in modes])
    fastest = np.abs(speeds).max(initial=0.0)
    lines = [_along(modes, own) for own in _slowest(modes)[:SHOWN]]
    lines = [own for i, own in enumerate(lines) if i < LEAST or _frequencies(own).min() <= REACH * fastest]
    frequency = [trace for own in lines for trace in _by_sense(speeds, own, _frequencies(own, np.nan))]
    decrements = [[mode.decrement if mode else np.nan for mode in own] for own in lines]
    decrement = [trace for own, values in zip(lines, decrements, strict=True) for trace in _by_sense(speeds, own, values)]
    top = 1.06 * max([fastest, *(_frequencies(own, 0.0).max() for own in lines)])
    frequency.append(line(speeds, np.abs(speeds), "1X", GREY, "dash", 1.2))
    if modes.criticals:
        frequency.append(dots(modes.criticals, np.abs(modes.criticals), "critical speed", "#ffffff", INK, 7))
    decrement.append(line([speeds.min(), speeds.max()], [0.0, 0.0], "limit of stability", GREY, "dashdot", 1.2))
    known = [value for own in decrements for value in own if math.isfinite(value)]
    low, high = min([*known, 0.0]), min(max([*known, 0.1]), HEAVY)
    room = 0.06 * (high - low)
    x = {"title": "rotor speed in Hz"}
    sizes = {"title": "damped frequency in Hz", "range": [0.0, top]}
    limits = {"title": "logarithmic decrement", "range": [low - room, high + room]}
    parts = (frequency, sizes, 380), (decrement, limits, 220)
    return [in_units({"data": named_once(data), "layout": axes(x, y, height)}) for data, y, height in parts]


def _frequencies(own, absent=math.inf):
    """Sizes of the frequencies of a line in Hz."""
    return np.array([abs(mode.frequency) if mode else absent for mode in own])


def _by_sense(speeds, own, values):
    """A line in pieces, each in the colour of the sense that its mode has at the piece's end."""
    senses = [mode.sense if mode else None for mode in own]
    traces = []
    for sense in dict.fromkeys(filter(None, senses[1:] or senses)):
        kept = [at == sense or following == sense for at, following in zip(senses, [*senses[1:], None], strict=True)]
        traces.append(line(speeds, np.where(kept, values, np.nan), f"{sense} mode", COLOURS[sense]))
    return traces


def _told(modes, most):
    if not modes:
        return "it has no coordinates"
    return f"{len(modes)} modes" if len(modes) <= most else f"the slowest {most} of {len(modes)} modes"


def _row(mode):
    frequency, undamped = exact(f"{mode.frequency:.5g}", mode.frequency), exact(_number(mode.undamped), mode.undamped)
    numbers = (frequency, f"{60.0 * mode.frequency:.5g}", undamped, _number(mode.decrement, "+.4g"))
    return (*numbers, f"{mode.growth_rate:+.4g}", f"{mode.share:.3f}", mode.sense, mode.remark or "-")


def _cell(mode):
    return f"{column('Hz')[0] * mode.frequency:.5g} ({_number(mode.decrement, '.3g')})"


def _number(value, form=".5g"):
    return "-" if math.isnan(value) else f"{value:{form}}"
