"""The motions that last, from the lists of a report, as marks in the pictures over the rotor speed."""

import numpy as np

from rsc.show.pictures.traces import ORANGE, dots, line
from rsc.show.words.wording import frequency_text, motion_name

EDGE = 0.97  # of the reach of a picture, where a motion beyond it is marked


def lasting_marks(report, along, reach):
    """Marks of every bounded motion that turns and lasts, at its frequency and at the speed or time of its list; one beyond the
    reach of the picture at its edge, with its frequency."""
    motions = [
        (motion.frequency, _place(report, along, listed.speed), motion_name(motion))
        for listed in report.motions
        for motion in listed.motions
        if motion.bounded and np.isfinite(motion.frequency)
    ]
    if not motions:
        return []
    frequency, places = (np.array(column) for column in list(zip(*motions, strict=True))[:2])
    beyond = np.abs(frequency) > reach
    x = np.where(beyond, np.sign(frequency) * EDGE * reach, frequency)
    names = [f"{name}, {frequency_text(rate)}" if far else "" for (rate, _, name), far in zip(motions, beyond, strict=True)]
    marks = dots(x, places, "lasts, from a list of motions", "#ffffff", ORANGE, 9)
    data = [marks | {"hovertext": [f"{name}, {frequency_text(rate)}" for rate, _, name in motions]}]
    for own, position in ((beyond & (x < 0.0), "bottom right"), (beyond & (x >= 0.0), "bottom left")):
        if own.any():
            told = [text if mine else "" for text, mine in zip(names, own, strict=True)]
            more = {"mode": "lines+text", "text": told, "textposition": position, "showlegend": False}
            data.append(line(x, places, "", ORANGE, width=0, **more))
    return data


def _place(report, along, speed):
    """Where a list's speed is on the axis along the run: where it is over time the last window at that speed."""
    if along.by_speed:
        return speed
    return float(along.of_windows[int(np.argmin(np.abs(report.fall.speed[::-1] - speed)) * -1 - 1)])
