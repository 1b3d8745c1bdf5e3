"""Whirl branches: the roots of neighbouring rotor speeds joined to lines, and where a line loses its stability."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq, linear_sum_assignment

from rsc.predict import predict_system

# two roots are the same whirl when the frequency moves by less than this share from speed to speed
SAME = 0.03


@dataclass(frozen=True)
class Branch:
    """One whirl over rotor speed.

    label : str, "A", "B", ... by rising |frequency| where the branch begins
    whirls : tuple of Whirl, at consecutive speeds of the grid
    lost : tuple of float, Hz, speeds where the growth rate crosses zero upwards, located
    """

    label: str
    whirls: tuple
    lost: tuple

    speed = property(lambda self: np.array([w.speed for w in self.whirls]), doc="(n,) Hz")
    frequency = property(lambda self: np.array([w.frequency for w in self.whirls]), doc="(n,) Hz")
    stable = property(lambda self: np.array([w.stable for w in self.whirls]), doc="(n,) bool")
    amplitude = property(lambda self: np.array([w.rotor_amplitude for w in self.whirls]), doc="(n,) m, at the contact")
    growth_rate = property(lambda self: np.array([w.growth_rate for w in self.whirls]), doc="(n,) 1/s")

    def envelope(self, i):
        """(n,) m: smallest (i = 0) or largest (i = 1) |r| with the unbalance, consistent first order."""
        return np.array([w.synchronous.consistent.envelope[i] for w in self.whirls])

    def at(self, speed):
        """The branch's whirl at the grid speed next to `speed`, or None outside the branch."""
        own = self.speed
        step = np.ptp(own) / max(len(own) - 1, 1)
        if not own.min() - step <= speed <= own.max() + step:
            return None
        return self.whirls[int(np.argmin(np.abs(own - speed)))]


def branches(system, speeds):
    """Predict the backward whirls over rotor speeds and join them to branches.

    Parameters
    ----------
    system : System
    speeds : (n,) Hz, monotonic

    Returns
    -------
    list of Branch, by label
    """
    order = np.argsort(np.abs([speeds[0], speeds[-1]]))[0]
    grid = np.asarray(speeds, dtype=float)[:: -1 if order else 1]
    lists = [[w for w in predict_system(system, speed) if w.frequency < 0.0] for speed in grid]
    lines = _joined(lists)
    found = [Branch("", tuple(line), _losses(system, line)) for line in lines]
    found.sort(key=lambda b: (abs(b.whirls[0].speed - grid[0]) > 1e-9 * abs(grid).max(), abs(b.whirls[0].frequency)))
    return [replace(branch, label=_name(i)) for i, branch in enumerate(found)]


def _name(i):
    return chr(ord("A") + i) if i < 26 else f"Z{i - 25}"


def _joined(lists):
    """Lists of Whirl per speed -> lists of Whirl per branch, by the smallest total jump from the extrapolated frequency."""
    done, open_lines = [], []
    for whirls in lists:
        taken = set()
        kept = []
        if open_lines and whirls:
            jump = np.array([[abs(w.frequency - _expected(line)) for w in whirls] for line in open_lines])
            for i, j in zip(*linear_sum_assignment(jump), strict=True):
                if jump[i, j] <= SAME * abs(whirls[j].frequency):
                    open_lines[i].append(whirls[j])
                    kept.append(i)
                    taken.add(j)
        done += [line for i, line in enumerate(open_lines) if i not in kept]
        open_lines = [open_lines[i] for i in sorted(kept)] + [[w] for j, w in enumerate(whirls) if j not in taken]
    return done + open_lines


def _expected(line):
    return line[-1].frequency if len(line) < 2 else 2.0 * line[-1].frequency - line[-2].frequency


def _losses(system, line):
    """Speeds at which the growth rate of a branch crosses zero towards instability."""
    found = []
    for a, b in zip(line, line[1:], strict=False):
        if a.stable == b.stable:
            continue

        def growth(speed, a=a, b=b):
            share = (speed - a.speed) / (b.speed - a.speed)
            frequency = a.frequency + share * (b.frequency - a.frequency)
            return min(predict_system(system, speed), key=lambda w: abs(w.frequency - frequency)).growth_rate

        found.append(float(brentq(growth, a.speed, b.speed, rtol=1e-9)))
    return tuple(found)
