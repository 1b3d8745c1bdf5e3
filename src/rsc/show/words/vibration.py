"""Vibration, static sag and closest approach of a run at a contact, in words."""

import math

import numpy as np

from rsc.measure.kinds import BACKWARD
from rsc.show.words.reasons import percent
from rsc.show.words.units import largest_finite
from rsc.show.words.wording import interval, length, moment, vibration

OFFSET = 0.05  # of the gap: a mean position further from where the rotor rests is an offset


def vibration_text(report, line=math.nan):
    """Largest peak-to-peak vibration of a window, static sag, mean offset, orbit and stator amplitude.

    Parameters
    ----------
    report : Report
    line : float, m, the largest line of a backward whirl; NaN where it is not known
    """
    features, whole, gap = report.features, report.stretches.whole(), report.contact.gap
    i = int(np.argmax(np.nan_to_num(features.peak_to_peak)))
    told = [f"up to {vibration(features.peak_to_peak[i])} {_window(report, i)}"]
    if 0.0 < report.sag < math.inf:
        told.append(f"static sag {length(report.sag)}")
    told += [text for text in (_offset(report),) if text]
    if np.isin(features.kind, [str(kind) for kind in BACKWARD]).any() and math.isfinite(whole.rotor_max):
        orbit = f"orbit up to {whole.rotor_max / gap:.2f} gaps ({length(whole.rotor_max)}) from the bearing centre"
        told.append(orbit + ("" if math.isnan(line) else f", the whirl's line up to {line / gap:.2f} gaps"))
    if whole.stator_max > whole.rotor_max:
        told.append(f"the stator up to {length(whole.stator_max)} from its resting position")
    return "; ".join(told)


def _offset(report):
    """The mean position of a window that is furthest from where the rotor rests, where that is far."""
    if report.result.status == "diverged":
        return ""  # the mean of a motion that grows a thousandfold within a window is no position
    sag = report.sag if math.isfinite(report.sag) else 0.0
    away = np.abs(np.abs(report.centre) - sag)
    if largest_finite(away) < OFFSET * report.contact.gap:
        return ""
    i = int(np.nanargmax(away))
    return f"mean position up to {length(abs(report.centre[i]))} from the bearing centre, {_window(report, i)}"


def _window(report, i):
    """A window of a report in words."""
    middle, half = report.features.time[i], 0.5 * report.features.window
    return interval(report, max(middle - half, 0.0), middle + half)


def approach_text(report):
    """How much of the clearance is left at least, or the largest penetration; with the moment."""
    whole, gap = report.stretches.whole(), report.contact.gap
    at = moment(report, whole.deflection_max_at)
    if whole.contact_time == 0.0:
        return f"{left_text(whole.deflection_max, gap)} left, at {at}"
    depth = max(whole.deflection_max - gap, 0.0)
    return f"touches; penetration up to {length(depth)}, {percent(depth / gap)} of the clearance, at {at}"


def left_text(deflection, gap):
    """What is left of a clearance in m at a deflection."""
    return f"{length(max(gap - deflection, 0.0))} ({percent(1.0 - deflection / gap)}) of the clearance of {length(gap)}"
