"""Quantities, speeds and places along a run in words."""

import math

import numpy as np

from rsc.measure.several import name_of
from rsc.show.words.units import unit_for

MOST_STRETCHES = 3
# of predictions that have no letter
NAMES = {"": "no whirl", "roll": "rolling", "forward rub": "forward rub", "no contact": "no contact"}


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
    return f"{factor * value:.3g} {unit.replace('µ', 'u')}"


def hertz(value):
    """A frequency in Hz with the digits that its size asks for, without unit."""
    decimals = 3 - math.floor(math.log10(abs(value))) if value else 1
    return f"{value:.{min(max(decimals, 1), 12)}f}" if abs(value) < 1e5 else f"{value:.6g}"


def rpm(value):
    """A speed or frequency in Hz as rpm, without unit."""
    value *= 60.0
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.4g}"


def speed_range(speeds):
    """Text of rotor speeds in Hz and rpm."""
    low, high = float(np.min(speeds)), float(np.max(speeds))
    if f"{low:.4g}" == f"{high:.4g}":
        return f"{hertz(low)} Hz ({rpm(low)} rpm)"
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
        text = f"{hertz(fall.speed[0])} Hz ({rpm(fall.speed[0])} rpm)" + ("" if whole else f", {' and '.join(spans)}")
    else:
        text = " and ".join(speed_range(fall.speed[p]) for p in shown)
    return text + (" and between" if len(pieces) > MOST_STRETCHES else "")
