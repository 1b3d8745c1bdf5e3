"""The engineer's answer to a measured run beside a scene: is it a whirl, is it the model's, what may be concluded of force, what
would have to change. What two probes cannot tell is not told.
"""

import math

import numpy as np

from rsc.measure.kinds import ProbeKind
from rsc.measure.verdict import ALONE, RUB
from rsc.measure.windows import ROLL
from rsc.measure.words import AGREES, DIFFERS, FREQUENCY, TOLERANCES
from rsc.measured.troubles import EXCHANGED
from rsc.show.words.reasons import percent
from rsc.show.words.units import largest_finite
from rsc.show.words.wording import amount, frequency_text, length, rates_text, vibration, where, whirl_name

SILENT = "two probes see neither contact nor force: partial rub, sliding, rolling and bouncing look alike to them"
ENOUGH = 0.5  # of the windows on a whirl that must agree in frequency before a force is told


def compared_answer(report):
    """(topic, text) lines of the Report of a measured run."""
    whirling = np.flatnonzero([report.features.on_whirl(i) for i in range(len(report.features.kind))])
    lines = [("signals", text) for text in report.result.warnings] or [("signals", "nothing wrong is seen in them")]
    lines += [("motion", _motion(report)), ("frequency", _frequency(report, whirling)), ("vibration", _vibration(report))]
    lines += [("1X", _turning_with_the_shaft(report))]
    if len(whirling):
        lines += [("model", _model(report, whirling)), ("would do", _would_do(report)), ("force", _force(report, whirling))]
    lines += [("change", _change(change)) for change in report.transitions]
    lines += [("check", report.agreement), ("not told", SILENT)]
    return [(topic, text) for topic, text in lines if text]


def _motion(report):
    """Every kind of motion that the probes show, with its speeds."""
    told = []
    for kind in (ProbeKind.WHIRL, ProbeKind.FORWARD, ProbeKind.WITH_SHAFT, ProbeKind.NEITHER):
        places = np.flatnonzero(report.features.kind == kind)
        if len(places):
            told.append(f"{kind} at {where(report, places)}")
    if EXCHANGED in report.result.warnings:
        told.insert(0, "which way anything turns is in doubt, by the signals")
    elif not (report.features.kind == ProbeKind.WHIRL).any():
        told.insert(0, "no backward whirl")
    unknown = np.flatnonzero(report.features.kind == ProbeKind.NOT_RESOLVED)
    if len(unknown):
        told.append(f"not resolved at {where(report, unknown)}: {report.features.why[unknown[0]]}")
    return "; ".join(told)


def _frequency(report, whirling):
    """Range of the measured whirl."""
    if not len(whirling):
        return ""
    values = report.features.frequency[whirling]
    low, high = float(values.min()), float(values.max())
    return rates_text(low, high)


def _vibration(report):
    """Vibration, the largest distance from the resting position, and the largest line at the rotor speed."""
    gap, largest = report.contact.gap, largest_finite(report.envelope.maximum)
    once, most = largest_finite(np.abs(report.order)), vibration(largest_finite(report.features.peak_to_peak))
    text = f"up to {most}; up to {length(largest)} ({largest / gap:.2f} gaps of the scene) from its resting position"
    return f"{text}; the line at the rotor speed up to {length(once)}"


def _turning_with_the_shaft(report):
    """Of which predicted motion the line at the rotor speed is where no whirl is."""
    rows, told = [window.synchronous for window in report.windows], []
    for by, words in ((ALONE, "without contact"), (RUB, "of a forward rub")):
        places = np.flatnonzero([row.by == by and row.verdict == AGREES for row in rows])
        told += [f"{words} at {where(report, places)}"] if len(places) else []
    return f"as predicted {' and '.join(told)}" if told else ""


def _model(report, whirling):
    """How the scene's roots stand to the measured whirl."""
    windows = [report.windows[i] for i in whirling]
    agree = sum(window.frequency.verdict == AGREES for window in windows)
    labels = sorted({window.branch for window in windows if window.branch} - {ROLL})
    rolls = any(window.branch == ROLL for window in windows)
    names = [f"whirl {label}" for label in labels] + (["a whirl that rolls"] if rolls else [])
    roots = [root for root in report.nearest if not root.is_that_whirl]
    if agree and not roots:
        return f"its {' and '.join(names)} is the measured one: {agree} of {len(windows)} windows agree in frequency"
    if rolls and agree:
        return f"its {' and '.join(names)} may be the measured one: {agree} of {len(windows)} windows agree in frequency"
    if not roots:
        return "its whirls are near, but not within the tolerance"
    told = next((root for root in roots if root.brings), roots[len(roots) // 2])
    more = f" (so at {len(roots)} of {len(report.nearest)} speeds examined)" if len(report.nearest) > 1 else ""
    return _root(told) + more


def _root(root):
    """What the scene has next to a measured whirl."""
    at = f"at {frequency_text(root.speed)}"
    if math.isnan(root.frequency):
        return f"{at} it has no whirl at all, measured was {frequency_text(root.measured)}"
    state = "stable" if root.stable else f"unstable (grows at {root.growth_rate:.3g} 1/s)"
    off = abs(root.frequency / root.measured - 1.0)
    if off < TOLERANCES[FREQUENCY]:
        return f"{at} it has the measured whirl, {frequency_text(root.frequency)}, but {state}"
    apart = percent(off)
    measured = f"measured was {frequency_text(root.measured)}, {apart} off"
    return f"{at} its nearest root is {frequency_text(root.frequency)}, {state}; {measured}"


def _would_do(report):
    """Which values would make the measured whirl one of the scene's."""
    for root in report.nearest:
        if root.brings:
            parts = [f"{one.name} = {_with_unit(one.needed, one.unit)} (now {one.value:.3g})" for one in root.brings]
            return f"at {frequency_text(root.speed)} the measured whirl would be stable with {', or '.join(parts)}, each alone"
    unlike = [root for root in report.nearest if not root.is_that_whirl]
    return "no single value of the scene, changed by a factor up to 4, gives the measured whirl" if unlike else ""


def _with_unit(value, unit):
    return f"{value:.3g}" + (f" {unit}" if unit != "1" else "")


def _force(report, whirling):
    """The force of the model in windows that agree in frequency, or the reason why it is not given."""
    windows = [report.windows[i] for i in whirling]
    labels = {branch.label: branch for branch in report.branches}
    agreeing = [w for w in windows if w.frequency.verdict == AGREES and w.branch in labels]
    forces = [labels[w.branch].at(w.frequency.speed) for w in agreeing]
    forces = [whirl.normal_force for whirl in forces if whirl is not None and whirl.stable]
    if len(forces) <= ENOUGH * len(windows):
        return "unknown: no stable whirl of the model has the measured frequency"
    span = sorted({amount(force, "N") for force in (min(forces), max(forces))}, key=len)
    apart = [abs(w.amplitude.difference) for w in agreeing if w.amplitude.verdict == DIFFERS]
    but = f"; the amplitude differs by up to {percent(max(apart))}, and so may the force" if apart else ""
    return f"not measured; the model's whirl of this frequency presses with {' to '.join(span)}{but}"


def _change(change):
    """A change of whirl in the measured run."""
    before, after = map(whirl_name, (change.before, change.after))
    predicted = f", predicted at {frequency_text(change.predicted, '.1f')}" if change.predicted == change.predicted else ""
    return f"{before} to {after} at {frequency_text(change.taken_over, '.1f')}{predicted}"
