"""The map of predicted motions over the rotor speed: branches of whirls with their ends and events, forward rubs."""

from math import tau as TWO_PI

import numpy as np

from rsc.analysis.follow.lines import RANGE_END
from rsc.errors import one_line
from rsc.show.pictures import plots
from rsc.show.pictures.pictures import stretches_of
from rsc.show.pictures.stability import stability
from rsc.show.pictures.traces import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, axes, dots, in_units, line, named_once
from rsc.show.words.units import largest_finite, unit_for
from rsc.show.words.wording import cause_text

COLOURS = (BLUE, GREEN, ORANGE, SKY)  # of pairs of whirls
SHAPES = ("circle", "square", "diamond", "triangle-up", "triangle-down", "triangle-left", "triangle-right", "cross")
INK = "#222222"


def branch_map(survey):
    """The map of a `rsc.analysis.survey.Survey` as a Figure."""
    return plots.stacked(map_of(survey), one_line(survey.scene.title))


def map_of(survey):
    """Frequency and amplitude of a survey's branches over the rotor speed, a picture each: ends and events by their cause, and a
    cross where the normal force of a whirl passes the limit of its stability towards another, joined to that one. Roots whose
    amplitude stays below the gap are left out. With several contacts the amplitude is the largest deflection over the gap."""
    several = len(survey.scene.contacts) > 1
    gap = 1.0 if several else survey.scene.contact.gap
    shown = [b for b in survey.branches if _size(b).max() > gap]
    rolling = [roll.rotor_amplitude for rolls in survey.rolls.values() for roll in rolls if roll.Psi < 0.0]
    factor, unit = (1.0, "") if several else unit_for(max([gap, *rolling, *(largest_finite(b.amplitude) for b in shown)]), "m")
    frequency, amplitude = [], []
    for b in shown:
        for data, values in ((frequency, b.frequency), (amplitude, factor * _size(b))):
            data += stretches_of(b.values, values, stability(b), "backward whirl", RED)
            own = np.flatnonzero(b.stable) if b.stable.any() else np.arange(len(values))
            middle, name = own[[len(own) // 2]], {"text": [_label(b)], "textposition": "top right", "showlegend": False}
            data.append(line(b.values[middle], values[middle], "", RED, mode="lines+text", **name))
    for data, row in ((frequency, 1), (amplitude, 2)):
        data += _rolls(survey, factor, row)
    for rub in survey.rubs:
        amplitude += stretches_of(rub.speed, factor * rub.amplitude, stability(rub), "forward rub", PURPLE)
    speeds = np.concatenate([np.ravel(each) for each in [*(b.values for b in shown), *(r.speed for r in survey.rubs)]] or [[0.0]])
    amplitude.append(line([speeds.min(), speeds.max()], [factor * gap] * 2, "gap", GREY, "dashdot", 1.2))
    for i, (cause, places) in enumerate(_marks(shown, factor).items()):
        for data, row in ((frequency, 1), (amplitude, 2)):
            data.append(dots(places[:, 0], places[:, row], cause_text(cause), "#ffffff", INK, 7, symbol=SHAPES[i % len(SHAPES)]))
    for i, place in enumerate(survey.ratios):
        pair = [next(b for b in shown if b.label == label) for label in (place.label, place.towards)]
        text = f"F_N of {place.label} is {place.ratio:.3f} F_N of {place.towards}"
        for data, name, scale in ((frequency, "frequency", 1.0), (amplitude, "amplitude", factor)):
            ends = [scale * float(np.interp(place.speed, b.values, getattr(b, name))) for b in pair]
            colour = COLOURS[i % len(COLOURS)]
            data.append(line([place.speed] * 2, ends, text, colour, "dot", 1.8))
            data.append(dots([place.speed], ends[:1], "", "none", colour, 10, symbol="x") | {"showlegend": False})
    x = {"title": "rotor speed in Hz"}
    top = max([gap, *rolling, *(largest_finite(_size(each)) for each in [*shown, *survey.rubs])])
    quantity = "largest deflection over gap" if several else f"amplitude |r| at the contact in {unit}"
    sizes = {"title": quantity, "range": [0.0, 1.12 * factor * top]}
    parts = (frequency, {"title": "whirl frequency in Hz"}), (amplitude, sizes)
    return [in_units({"data": named_once(data), "layout": axes(x, y, 300)}) for data, y in parts]


def _size(branch):
    """(n,) amplitude in m of a branch or forward rub; of a whirl at several contacts the largest deflection over the gap."""
    at = getattr(branch, "at_contacts", {})
    return np.max([one["over_gap"] for one in at.values()], axis=0) if at else branch.amplitude


def _label(branch):
    return f"{branch.label} ({', '.join(branch.pressed)})" if branch.pressed else branch.label


def _rolls(survey, factor, row):
    """Dots of the whirls that roll, filled where stable: their frequency (row 1) or amplitude (row 2)."""
    places = [
        (speed, roll.Psi / TWO_PI, factor * roll.rotor_amplitude, roll.stable)
        for speed, rolls in survey.rolls.items()
        for roll in rolls
        if roll.Psi < 0.0
    ]
    data = []
    for stable, colour in ((True, ORANGE), (False, "#ffffff")):
        own = np.array([place for place in places if place[3] == stable])
        if len(own):
            data.append(dots(own[:, 0], own[:, row], f"rolling, {'stable' if stable else 'unstable'}", colour, ORANGE, 5))
    return data


def _marks(branches, factor):
    """Cause -> (n, 3) speeds, frequencies and amplitudes of the ends and events of branches."""
    marks = {}
    for b in branches:
        for event in (b.begin, *b.events, b.end):
            if event.cause != RANGE_END:
                size = factor * float(np.interp(event.value, b.values, _size(b)))
                marks.setdefault(event.cause, []).append((event.value, event.frequency, size))
    return {cause: np.array(places) for cause, places in marks.items()}
