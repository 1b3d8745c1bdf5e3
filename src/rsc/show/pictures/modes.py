"""Modes of a machine as tables and as a Campbell diagram."""

import math

import numpy as np

from rsc.errors import one_line
from rsc.show.pictures.traces import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, axes, dots, in_units, line, named_once
from rsc.show.words.table import table
from rsc.show.words.units import column
from rsc.show.words.wording import frequency_text

SHOWN = 8  # modes of each part in a table and a picture: the slowest
COLOURS = {"forward": BLUE, "backward": RED, "straight": GREEN, "mixed": PURPLE, "-": ORANGE}
INK = "#222222"


def modes_text(modes, title, most=SHOWN):
    """Tables of the slowest modes at one rotor speed."""
    lines = [one_line(title)] if title else []
    lines.append(f"modes at {_speed(modes.speed)}")
    names = {"rotor": "the rotor, free", "stator": "the stator", "coupled": "both, joined at the contact"}
    for part, own in modes.parts.items():
        lines += ["", f"{names[part]}: {_told(own, most)}"]
        if own:
            header = ("frequency Hz", "rpm", "undamped Hz", "decrement", "growth 1/s", "share", "sense", "remark")
            lines.append(table(header, [_row(mode) for mode in own[:most]]))
    return "\n".join(lines)


def model_text(modes, model, speed):
    """Table of the slowest modes of a `rsc.machine.model.model.FiniteElementModel`, as it was read."""
    told = f"the slowest {len(modes)} modes at {_speed(speed)}"
    lines = [f"{one_line(model.source)}, as it was read", told]
    rows = [
        (f"{mode.frequency:.5g}", f"{60.0 * mode.frequency:.5g}", _number(mode.decrement, "+.4g"), f"{mode.growth_rate:+.4g}", "")
        for mode in modes
    ]
    return "\n".join([*lines, table(("frequency Hz", "rpm", "decrement", "growth 1/s", ""), rows)])


def campbell_text(modes, title, most=SHOWN):
    """A table of the rotor's slowest modes over the rotor speed, frequency and decrement, and the critical speeds."""
    number = min(most, max(len(each.rotor) for each in modes))
    header = ("speed Hz", *(f"mode {i + 1}" for i in range(number)), "")
    rows = []
    for each in modes:
        cells = [_cell(mode) for mode in each.rotor[:number]]
        rows.append((f"{each.speed:.4g}", *cells, *[""] * (number - len(cells)), ""))
    lines = [one_line(title)] if title else []
    about = f"the rotor, free: damped frequency in {column('Hz')[1]} (logarithmic decrement); negative: backward"
    lines += [about, table(header, rows)]
    return "\n".join([*lines, criticals_text(modes.criticals)])


def criticals_text(criticals):
    """The critical speeds in words."""
    if not criticals:
        return "critical speeds: none between these speeds"
    return "critical speeds: " + ", ".join(map(_speed, criticals))


def _speed(speed):
    """A rotor speed, and as rpm."""
    return frequency_text(speed, ".2f") + (f" ({60.0 * speed:.0f} rpm)" if column("Hz")[1] == "Hz" else "")


def campbell(modes):
    """Descriptions of both pictures of a `rsc.analysis.alone.modes.Campbell`."""
    speeds = np.array([each.speed for each in modes])
    # by signed frequency, so that a mode keeps its place while none crosses
    ranked = [sorted(each.rotor, key=lambda mode: mode.frequency) for each in modes]
    number = min(map(len, ranked))
    slowest = sorted(range(number), key=lambda i: min(abs(own[i].frequency) for own in ranked))[:SHOWN]
    frequency, decrement = [], []
    for i in sorted(slowest):
        own = [each[i] for each in ranked]
        sense = own[len(own) // 2].sense
        frequency.append(line(speeds, [mode.frequency for mode in own], f"{sense} mode", COLOURS[sense]))
        decrement.append(line(speeds, [mode.decrement for mode in own], f"{sense} mode", COLOURS[sense]))
    low, high = (extreme(extreme(trace["y"]) for trace in frequency) for extreme in (min, max))
    room = 0.06 * (high - low)
    frequency.append(line(speeds, speeds, "1X", GREY, "dash", 1.2))
    frequency.append(line(speeds, -speeds, "1X", GREY, "dash", 1.2))
    if modes.criticals:
        frequency.append(dots(modes.criticals, modes.criticals, "critical speed", "#ffffff", INK, 7))
    decrement.append(line([speeds.min(), speeds.max()], [0.0, 0.0], "limit of stability", GREY, "dashdot", 1.2))
    x, limits = {"title": "rotor speed in Hz"}, [low - room, high + room]
    sizes = {"title": "damped frequency in Hz (backward < 0)", "range": limits}
    parts = (frequency, sizes, 380), (decrement, {"title": "logarithmic decrement"}, 220)
    return [in_units({"data": named_once(data), "layout": axes(x, y, height)}) for data, y, height in parts]


def _told(modes, most):
    if not modes:
        return "it has no coordinates"
    return f"{len(modes)} modes" if len(modes) <= most else f"the slowest {most} of {len(modes)} modes"


def _row(mode):
    numbers = (f"{mode.frequency:.5g}", f"{60.0 * mode.frequency:.5g}", _number(mode.undamped), _number(mode.decrement, "+.4g"))
    return (*numbers, f"{mode.growth_rate:+.4g}", f"{mode.share:.3f}", mode.sense, mode.remark or "-")


def _cell(mode):
    return f"{column('Hz')[0] * mode.frequency:.5g} ({_number(mode.decrement, '.3g')})"


def _number(value, form=".5g"):
    return "-" if math.isnan(value) else f"{value:{form}}"
