"""The axis along the run that the pictures of a report share."""

import numpy as np


class Abscissa:
    """The axis along a run: rotor speed where it runs one way only, otherwise time.

    of_windows : (n_w,) places of the windows of a Report; title : str; by_speed : bool
    """

    def __init__(self, report):
        speed, time = report.fall.speed, report.fall.time
        steps = np.diff(speed)
        self.by_speed = len(speed) > 1 and bool((steps > 0.0).all() or (steps < 0.0).all())
        self.of_windows = speed if self.by_speed else time
        self._window_speeds, self._time = speed, time
        self.title = "rotor speed in Hz" if self.by_speed else "time in s"

    def of(self, part):
        """Places of something with speed and time."""
        return part.speed if self.by_speed else part.time

    def curve(self, speed, values):
        """x and y of values over the rotor speed; over time NaN where the run is at a speed that they do not reach."""
        speed, values = np.asarray(speed, float), np.asarray(values, float)
        if self.by_speed:
            return speed, values
        order = np.argsort(speed)
        slack = 1e-9 * np.abs(speed).max(initial=0.0)
        inside = (self._window_speeds >= speed.min() - slack) & (self._window_speeds <= speed.max() + slack)
        return self._time, np.where(inside, np.interp(self._window_speeds, speed[order], values[order]), np.nan)
