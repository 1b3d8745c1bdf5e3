"""A picture that the package does not have, added as CONTRIBUTING.md says and by nothing else: the rotor speed over the run."""

import numpy as np

from rsc.show.pictures.album import PICTURES, Entry
from rsc.show.pictures.traces import BLUE, axes, line, range_of


def rotor_speed(report, along):
    """The rotor speed of every window; None where it is constant, and there is nothing to show."""
    speed = report.fall.speed
    if np.ptp(speed) == 0.0:
        return None
    data = [line(along.of_windows, speed, "rotor speed", BLUE)]
    return {"data": data, "layout": axes({"title": along.title, "range": range_of(along)}, "rotor speed in Hz", 240, across="x")}


PICTURES["rotor_speed"] = Entry(rotor_speed, "Rotor speed over the run.", section="Frequencies", file="rotor_speed")
