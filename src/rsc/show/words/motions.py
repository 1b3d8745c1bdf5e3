"""The list of motions that last at a speed, as text."""

import math
import textwrap

from rsc.errors import one_line
from rsc.measure.several import together
from rsc.measure.severity import coverage_of, verdict_of
from rsc.show.words.answer import COLUMNS, least_friction
from rsc.show.words.clearances import touching
from rsc.show.words.held import held_text
from rsc.show.words.table import exact, table
from rsc.show.words.units import VIBRATION, column
from rsc.show.words.verdict import beyond_text, coverage_text, verdict_text
from rsc.show.words.wording import amount, frequency_text, hertz, motion_name, speed_text, whirl_name


def motions_text(listed, title=""):
    """A `rsc.measure.catalogue.Motions` as text: motions that last, predicted ones not reached, and coverage."""
    verdict = textwrap.wrap(f"verdict: {verdict_text(verdict_of(None, None, (), [listed]))}", COLUMNS, break_long_words=False)
    head = [*verdict, "", *([one_line(title), ""] if title else [])]
    lines = [*head, f"motions that last at {speed_text(listed.speed)}, {listed.runs} runs"]
    lines.append(table(*motions_cells(listed)) if listed.motions else "none: no start settled in a motion that lasts")
    return "\n".join([*lines, *only_predicted(listed), claim(listed), least_friction(listed)])


def claim(listed):
    """What the random impacts of a list claim."""
    at = " and ".join(f"at {name} up to {size:.3g} N s" for name, size in listed.largest_at.items())
    return f"coverage: {coverage_text([coverage_of(listed)])} (random impacts {at or f'up to {listed.largest:.3g} N s'})"


def only_predicted(listed):
    """Lines on the predictions of a list that are no motion that lasts."""
    lines = [f"predicted, not reached: {predicted_text(one, listed.gap)}" for one in listed.not_reached]
    return lines + [f"does not last, but is left slowly: {predicted_text(one, listed.gap)}" for one in listed.leaving]


def rolling_lines(lists):
    """A line on each motion of some lists that rolls or is predicted to: branches over the speed are of whirls that slide."""
    lines = []
    for listed in lists:
        at = f"Rolling at a rotor speed of {frequency_text(listed.speed)}"
        known = [motion for motion in listed.motions if motion.predicted is not None and motion.predicted.label == "roll"]
        for motion in known:
            size = beyond_text(motion.border) or amount(motion.force_max, "N")
            large = f"|r| {motion.amplitude_max / listed.gap:.2f} gaps"
            lines.append(f"{at}: {frequency_text(motion.frequency)}, {large}, {size}; it lasts.")
        others = [one for one in listed.not_reached if one.label == "roll"]
        lines += [f"{at}: {predicted_text(one, listed.gap)}; no run ended there." for one in others]
    return lines


def motions_cells(listed):
    """Header and rows of texts of the motions of a list."""
    per_metre, um = column(VIBRATION)
    if listed.largest_at:
        places = [f"{name}: |d|/gap, N, % in contact" for name in listed.largest_at]
    else:
        places = ["|r|/gap", f"{um} p-p", "penetration/gap", "force N"]
    header = ("frequency Hz", *places, "torque N m", "power W", "starts %", "impact N s", "motion")
    rows = []
    for motion in listed.motions:
        endless = not motion.bounded
        beyond = endless or bool(motion.border.passed)  # whose forces are those of a model that does not hold
        if listed.largest_at:
            cells = ["-" if endless else _at(motion.contacts[name]) for name in listed.largest_at]
        else:
            sizes = motion.amplitude_max / listed.gap, per_metre * motion.peak_to_peak, motion.border.penetration
            cells = [*(_known(size, endless) for size in sizes), _known(motion.force_max, beyond)]
        cells += [_known(motion.torque, beyond), _known(motion.power, beyond)]
        impact = "-" if math.isnan(motion.smallest_impulse) else f"{motion.smallest_impulse:.3g}"
        share = "-" if math.isnan(motion.share) else f"{100.0 * motion.share:.0f}"
        rate = "-" if endless or math.isnan(motion.frequency) else exact(hertz(motion.frequency), motion.frequency)
        words = motion_name(motion) + (", modulated" if motion.modulated else "")
        words += f", {touching(motion.touches)}" if motion.touches else ""
        if motion.predicted is not None:
            words += f"; predicted: {predicted_text(motion.predicted, listed.gap)}{_off(motion)}"
        words += f"; {beyond_text(motion.border)}" if beyond and not endless else ""
        words += f"; {held_text(motion.held)}" if motion.held else ""
        rows.append((rate, *cells, share, impact, words))
    return header, rows


def _known(value, endless):
    return "-" if endless or math.isnan(value) else _number(value)


def _at(contact):
    """What a motion is at one of several contacts, in numbers."""
    return f"{contact.over_gap:.4g}, {_number(contact.force_max)}, {100.0 * contact.share:.0f}"


def _off(motion):
    """How far a motion at several contacts is from its prediction."""
    if not motion.contacts:
        return ""
    frequency, force = motion.off
    return f" (off by {100.0 * frequency:.2g} % in frequency, {100.0 * force:.2g} % in mean force)"


def _number(value):
    """A number of four digits, or of all before the point."""
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e9 else f"{value:.4g}"


def predicted_text(one, gap):
    """A predicted motion in words."""
    rate = "" if math.isnan(one.frequency) else f" {frequency_text(one.frequency)}"
    with_unbalance = "" if math.isnan(one.with_unbalance) else " with its unbalance"
    name = whirl_name(one.label)
    slides = "" if one.possible else ", which cannot slide so fast"
    slides += f", {touching(one.touches)}" if one.touches else ""
    if one.forces:
        name += f" at {together(one.pressed)}"
        size = " and ".join(amount(one.forces[pressed], "N") for pressed in one.pressed)
    else:
        size = f"{one.amplitude / gap:.2f} gaps, {amount(one.normal_force, 'N')}"
    return f"{name}{rate}, {size}, growth {one.rate:+.3g} 1/s{with_unbalance}{slides}"
