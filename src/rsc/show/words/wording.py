"""Quantities, speeds and places along a run in words."""

import math
import re

import numpy as np

from rsc.measure.several import name_of
from rsc.show.words.units import SI, VIBRATION, column, system, unit_for

MOST_STRETCHES = 3
# a number, or two, with a unit of `sentence_in_units`, and no other behind it
_NUMBER = r"([+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?)"
_QUANTITY = re.compile(rf"(?<![\w.]){_NUMBER}(?: to {_NUMBER})? (Hz|m/s|mm|N)(?![\w/]| [ms]\b)")
# of predictions that have no letter
NAMES = {"": "no whirl", "roll": "rolling", "forward rub": "forward rub", "no contact": "no contact"}


# side condition (`rsc.analysis.paper.whirls.side_conditions`) -> what is wrong with a whirl for which it does not hold
NOT_VALID = {
    "psi_real": "at its fold",
    "normal_force_positive": "contact in tension",
    "asynchronous_force_dominates": "force below 3 times that of the unbalance",
    "rotor_amplitude_exceeds_gap": "orbit smaller than clearance",
    "sliding": "does not slide forward",
    "contact_stiff_enough": "contact too soft",
    "nearly_circular": "orbit not circular",
    "within_clearances": "touches a clearance",
}
# cause of an event (`rsc.analysis.follow.events`) -> its name, as of a mark in a picture
CAUSES = {
    "fold of two roots": "fold (limit point)",
    "fold of two forward rubs": "fold (limit point)",
    "end of the range": "end of range",
    "normal force positive": "contact pressed",
    "|r_R| above the gap": "orbit larger than clearance",
    "stable (creeping)": "loss of stability (real eigenvalue)",
    "stable (oscillatory)": "flutter (Hopf)",
}
LOSSES = {"stable (creeping)": "real eigenvalue", "stable (oscillatory)": "flutter, Hopf"}


def not_valid(whirl):
    """Why the solution for a whirl is not valid, in words; "-" where every side condition holds."""
    return ", ".join(NOT_VALID[name] for name in whirl.violated) or "-"


def cause_text(cause):
    """The cause of an event of a branch in words."""
    return CAUSES.get(cause, cause)


def event_text(event):
    """An event of a branch in words, with its speed: on which side of it the condition holds."""
    at = f"{event.holds} {frequency_text(event.value, '.6g')}"
    return f"stable {at} ({LOSSES[event.cause]})" if event.cause in LOSSES else f"{cause_text(event.cause)} {at}"


def whirl_name(label):
    """A predicted motion by its label, in words."""
    return NAMES.get(label, f"whirl {label}")


def motion_name(motion):
    """The kind of a `rsc.measure.final.FinalMotion`; of several contacts each kind that it is somewhere, and where."""
    return name_of({name: own.motion for name, own in motion.contacts.items()}) if motion.contacts else motion.motion


def length(metres):
    """A length in its unit."""
    return amount(metres, "m")


def amount(value, base):
    """A value in SI in the unit in which it reads well."""
    factor, unit = unit_for(abs(value), base)
    shown = factor * value
    text = f"{shown:.0f}" if 1e3 <= abs(shown) < 1e6 else f"{shown:.3g}"  # of units that have no prefix
    return f"{text} {unit.replace('µ', 'u')}"


def frequency_text(value, form=""):
    """A frequency or rotor speed in Hz in its unit; form: of a number in Hz, by default with the digits its size asks for."""
    unit = column("Hz")[1]
    if unit != "Hz":
        return f"{rpm(value)} {unit}"
    return f"{format(value, form) if form else hertz(value)} {unit}"


def frequency_number(value):
    """The same without its unit, for a table."""
    return hertz(value) if column("Hz")[1] == "Hz" else rpm(value)


def sentence_in_units(text):
    """A sentence of the analysis, which tells numbers in SI and Hz, with its frequencies, speeds, forces and lengths in the units
    that are shown."""
    return text if system() == SI else _QUANTITY.sub(_converted, text)


def _converted(match):
    """A number, or two from one to the other, with its unit."""
    low, high, unit = match.groups()
    base, factor = {"mm": ("m", 1e-3)}.get(unit, (unit, 1.0))
    values = [factor * float(number) for number in (low, high) if number]
    if base == "Hz":
        return frequency_text(*values) if len(values) == 1 else frequencies_text(*values)
    return " to ".join(amount(value, base) for value in values)


def speed_text(value):
    """A rotor speed in Hz in its unit, and as rpm."""
    return frequency_text(value) + (f" ({rpm(value)} rpm)" if column("Hz")[1] == "Hz" else "")


def hertz(value):
    """A frequency in Hz with the digits that its size asks for, without unit."""
    decimals = 3 - math.floor(math.log10(abs(value))) if value else 1
    return f"{value:.{min(max(decimals, 1), 12)}f}" if abs(value) < 1e5 else f"{value:.6g}"


def vibration(metres):
    """A vibration peak to peak, in um as long as it is that of a machine."""
    factor, unit = column(VIBRATION)
    if not 1e-7 <= metres < 0.1:
        return f"{length(metres)} pk-pk"
    size = factor * metres
    return (f"{size:.3g}" if size < 999.5 else f"{size:.0f}") + f" {unit} pk-pk"


def moment(report, time):
    """A time of a run, and the rotor speed there where it changes."""
    drive = report.result.scene.drive
    rotor_speed = float(np.interp(time, drive.time, drive.speed))
    return f"{time:.4g} s" if len(set(drive.speed)) == 1 else f"{frequency_text(rotor_speed)} ({time:.4g} s)"


def interval(report, begin, end):
    """A stretch of time of a run, and the rotor speed in its middle where it changes."""
    drive = report.result.scene.drive
    text = f"from {begin:.4g} to {end:.4g} s"
    rotor_speed = float(np.interp(0.5 * (begin + end), drive.time, drive.speed))
    return text if len(set(drive.speed)) == 1 else f"at {frequency_text(rotor_speed)} ({text})"


def rpm(value):
    """A speed or frequency in Hz as rpm, without unit."""
    value *= 60.0
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.4g}"


def frequencies_text(low, high, form=""):
    """A range of frequencies or rotor speeds in Hz in their unit."""
    if column("Hz")[1] != "Hz":
        return f"{frequency_number(low)} to {frequency_text(high)}"
    return f"{format(low, form) if form else hertz(low)} to {frequency_text(high, form)}"


def rates_text(low, high, explained=True):
    """A range of whirl rates in Hz; `explained` adds the meaning of the sign."""
    same, sign = f"{low:.4g}" == f"{high:.4g}", "negative: against the rotation" if explained else ""
    if column("Hz")[1] != "Hz":
        text = frequency_text(low) if same else frequencies_text(low, high)
        return text + (f" ({sign})" if sign else "")
    hz, turns = (text(low) if same else f"{text(low)} to {text(high)}" for text in (hertz, rpm))
    return f"{hz} Hz ({turns} rpm{'; ' if sign else ''}{sign})"


def speed_range(speeds):
    """Text of rotor speeds in Hz and rpm."""
    low, high = float(np.min(speeds)), float(np.max(speeds))
    if f"{low:.4g}" == f"{high:.4g}":
        return speed_text(low)
    if column("Hz")[1] != "Hz":
        return f"{frequency_number(low)} to {frequency_text(high)}"
    return f"{hertz(low)} to {hertz(high)} Hz ({rpm(low)} to {rpm(high)} rpm)"


def where(report, places):
    """Text of the rotor speeds, or at constant speed of the times, of some windows, which may be several stretches of them."""
    pieces = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)
    pieces.sort(key=len, reverse=True)
    shown = sorted(pieces[:MOST_STRETCHES], key=lambda piece: piece[0])
    fall, half = report.fall, 0.5 * report.fall.window
    if np.ptp(fall.speed) == 0.0:
        whole = len(places) == len(fall.time)
        spans = [f"{max(fall.time[p[0]] - half, 0.0):.3g} to {fall.time[p[-1]] + half:.3g} s" for p in shown]
        text = speed_text(fall.speed[0]) + ("" if whole else f", {' and '.join(spans)}")
    else:
        text = " and ".join(speed_range(report.speeds[p]) for p in shown)
    return text + (" and between" if len(pieces) > MOST_STRETCHES else "")
