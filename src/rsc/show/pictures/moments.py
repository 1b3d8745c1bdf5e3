"""The moments of a run that its pictures show: where the motion is largest, before and after each change, each kind of motion."""

from dataclasses import dataclass

import numpy as np

from rsc.measure.features import ellipse, turned
from rsc.show.words.units import largest_finite
from rsc.show.words.wording import frequency_text, whirl_name

MOST = 6
LEAST = 0.01  # of the gap, filtered paths that are drawn
RESOLVED = 2.0  # turns in a window: half the main lobe of its spectrum, in which two lines are one
SEEN = 0.02  # of the largest line, a backward one that sets the scale of pictures
CENTRED = 0.02  # of the gap, a mean position that is no shift


@dataclass(frozen=True)
class Moment:
    """A window of a run worth a picture.

    window : int, its number; text : str, why
    """

    window: int
    text: str


def moments(report):
    """At most six Moments of a Report, in the order of the run."""
    labels = _labels(report)
    chosen = {int(np.argmax(np.nan_to_num(np.abs(report.orbits.rotor)).max(axis=1))): "largest amplitude"}
    for change in report.transitions:
        at = int(np.argmin(np.abs(report.fall.speed - change.taken_over)))
        for window, text in ((at - 2, f"before {whirl_name(change.after)}"), (at + 3, f"after {whirl_name(change.before)}")):
            if 0 <= window < len(labels):
                chosen.setdefault(window, text)
    for label in dict.fromkeys(labels):  # the middle window of each kind of motion
        own = [i for i, other in enumerate(labels) if other == label]
        chosen.setdefault(own[len(own) // 2], label)
    chosen.setdefault(len(labels) - 1, "end of the run")
    first = list(chosen.items())[:MOST]
    return [Moment(window, text) for window, text in sorted(first)]


def _labels(report):
    """(n_w,) kind of motion of every window, in words."""
    return [_kind(report, i) for i in range(len(report.windows))]


def _kind(report, i):
    row = report.windows[i].frequency
    if row.branch:
        return whirl_name(row.branch)
    return str(report.features.kind[i])


def seen_lines(report):
    """(n_w,) Hz, the strongest backward line of every window; NaN where it is too small to set the scale of a picture."""
    features, largest = report.features, np.fmax.reduce(report.fall.amplitude, axis=None)  # without a copy of a long run's
    return np.where(features.size >= SEEN * largest, features.frequency, np.nan)


def marks_of(report, window):
    """Places in the path of a window where a revolution of the shaft is completed."""
    turns = np.floor(turned(report.result, report.orbits.time[window]) + 1e-9)
    return np.flatnonzero(np.diff(turns) != 0.0) + 1


def filtered(report, window):
    """The motion of a window filtered at 1X and at the frequency of its strongest backward line: ellipses around its mean.

    Returns
    -------
    dict of name to (centre, forward, backward), complex m
        The path is centre + forward e^(i phi) + backward e^(-i phi). Left out are paths within 1 % of the gap, frequencies of
        which the window holds fewer than two turns, and a backward line that it cannot tell from 1X.
    """
    result, fall, centre = report.result, report.fall, complex(report.centre[window])
    first = round(float(fall.time[window]) * result.scene.output.rate - 0.5 * fall.n_samples)
    part = report.at_contact.samples(first, first + fall.n_samples)
    once, line = abs(float(fall.speed[window])), abs(float(report.features.frequency[window]))
    angles = {}
    if once * fall.window >= RESOLVED:
        angles["filtered at 1X"] = turned(result, part.time)
    if min(line, abs(line - once)) * fall.window >= RESOLVED:
        angles["filtered at the whirl"] = line * part.time
    motion, least = part.contact_rotor() - centre, LEAST * report.contact.gap
    lines = {name: ellipse(motion, angle) for name, angle in angles.items()}
    return {name: (centre, *pair) for name, pair in lines.items() if sum(map(abs, pair)) > least}


def once_per_turn(report, window):
    """(k,) complex m: positions of the rotor in the path of a window where a revolution of the shaft is completed, by cubics."""
    orbits, step = report.orbits, np.arange(-2, 2)
    turns = turned(report.result, orbits.time[window])
    marks = marks_of(report, window)
    marks = marks[(marks >= 2) & (marks < len(turns) - 1)]
    before, after = turns[marks - 1], turns[marks]
    x = (np.maximum(np.floor(before + 1e-9), np.floor(after + 1e-9)) - before) / (after - before) - 1.0
    others = [np.delete(step, i) for i in range(len(step))]
    weights = np.array([np.prod((x[:, None] - other) / (own - other), axis=1) for own, other in zip(step, others, strict=True)])
    return (weights.T * orbits.rotor[window][marks[:, None] + step]).sum(axis=1)


def distances_once_a_turn(report, most):
    """Distances of the rotor at the contact in the positions of `once_per_turn`, of at most so many windows all along a run.

    Returns
    -------
    windows : (k,) int, number of the window of each
    distances : (k,) m
    """
    windows = np.unique(np.linspace(0, len(report.fall.speed) - 1, most).round().astype(int))
    positions = [once_per_turn(report, window) for window in windows.tolist()]
    return np.repeat(windows, [len(each) for each in positions]), np.abs(np.concatenate(positions))


def is_deflected(report):
    """Whether the mean position of the rotor leaves the middle, as under a load."""
    return largest_finite(np.abs(report.centre)) >= CENTRED * report.contact.gap


def place_of(report, window):
    """Text of rotor speed, or of time where the speed does not change."""
    speeds = report.fall.speed
    if np.ptp(speeds) > 0.0:
        return frequency_text(speeds[window], ".1f")
    return f"{report.fall.time[window]:.3g} s"
