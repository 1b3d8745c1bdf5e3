"""Labels of the second engine's motions, out of its own samples alone, by the definitions of docs/users/motions.md.

A label is a set of kinds: where a number stands so close to a limit that the samples cannot tell, those on both sides of it.
"""

import itertools
import math
from typing import NamedTuple

import numpy as np

PERMANENT, ROLLING, ARC, LEAST_TURNS, SENSE_TURNS = 0.99, 0.5, 0.5, 3.0, 2.0
NEAR = 6e-3  # of the surface speed, the difference of two speeds: slip so close to its limit may lie on either side
CENTRE = 1e-3  # of the gap: a deflection from which the sense of its turning tells nothing
BACKWARD = {"backward whirl, sliding", "backward whirl, rolling", "bouncing backward whirl"}
SELF_EXCITED = BACKWARD | {"forward whirl"}
RUNNING_AWAY, NO_CONTACT = "running away", "no contact"


class Signals:
    """What the contact does, from `answers_engine.Samples`: arrays (n,) of d, force, slip and sums of them over time."""

    def __init__(self, run):
        m, turn = run.machine, np.exp(1j * run.drive.angle_at(run.time))
        speed = np.interp(run.time, run.drive.time, run.drive.speed)
        self.time, self.gap, self.diverged, self.rotor, self.stator = run.time, m.gap, run.diverged, run.rotor, run.stator
        self.d = run.rotor - run.stator + m.ring * turn
        rate = run.rotor_rate - run.stator_rate + 1j * speed * m.ring * turn
        distance = np.maximum(abs(self.d), 1e-300)
        along, tangential = (rate * self.d.conj()).real / distance, (rate * self.d.conj()).imag / distance
        self.touch = distance > m.gap
        self.force = np.where(self.touch, np.maximum(m.k * (distance - m.gap) + m.b * np.minimum(along, 0.0), 0.0), 0.0)
        slip = speed * max(m.radius, 0.0) + tangential - run.surface
        sigma = np.clip(slip / m.slip, -1.0, 1.0) if m.radius >= 0.0 else np.ones(len(slip))
        self.friction = m.friction * sigma * self.force
        self.rolls = self.touch & (abs(slip) < m.slip) & (m.radius >= 0.0)
        self.near = self.touch & (abs(abs(slip) - m.slip) < NEAR * abs(speed * m.radius)) & (m.radius >= 0.0)
        self.fed, self.heat = -self.friction * tangential, self.friction * slip  # W
        self.given, self.raced = self.friction * max(m.radius, 0.0) * speed, self.friction * run.surface
        n = len(m.row)  # cross-coupling, or damping that is negative, feeds a whirl as well as friction does
        self.driven = bool(np.any(m.stiffness.imag) or np.any(m.damping.imag))
        self.driven |= bool(n and np.linalg.eigvals(m.damping).real.min() < -1e-9 * abs(m.damping).max())
        self.turn = np.unwrap(np.angle(self.d)) / (2.0 * np.pi)
        self.shaft = run.drive.angle_at(run.time) / (2.0 * np.pi)

    def part(self, begin, end):
        """Slice of the samples between two times, s."""
        first, last = np.searchsorted(self.time, [begin, end])
        return slice(int(first), max(int(last), int(first) + 2))

    def share(self, begin, end):
        """Share of the time in contact."""
        return float(self.touch[self.part(begin, end)].mean())

    def turning(self, begin, end):
        """Mean rate at which d turns, Hz; not a number where the run had ended by then."""
        own = self.part(begin, end)
        if own.start >= len(self.time):
            return math.nan
        return float(np.ptp(self.time[own]) and (self.turn[own][-1] - self.turn[own][0]) / np.ptp(self.time[own]))

    def largest(self, values, begin=0.0, end=np.inf):
        """Largest size of some samples between two times."""
        return float(np.abs(values[self.part(begin, end)]).max(initial=0.0))

    def integral(self, values, begin=0.0, end=np.inf):
        """Integral of some samples from one time to another, by the trapezium rule."""
        own = self.part(begin, end)
        own = slice(max(own.start - 1, 0), own.stop + 1)
        time, values = self.time[own], values[own]
        total = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])
        return float(np.diff(np.interp([begin, end], time, total))[0])

    def mean(self, values, begin=0.0, end=np.inf):
        """Mean of some samples from one time to another."""
        begin, end = max(begin, self.time[0]), min(end, self.time[-1])
        return self.integral(values, begin, end) / (end - begin) if end > begin else 0.0


class Doubt(NamedTuple):
    """How close to a limit a number must be that both sides are allowed."""

    turns: float = 0.15
    share: float = 0.004
    rolling: float = 0.05
    arc: float = 0.03
    least: float = 0.3


def _sides(value, limit, doubt):
    """Possible answers to value >= limit."""
    return {True, False} if abs(value - limit) <= doubt else {bool(value >= limit)}


def kinds(signals, begin, end, edges=None, doubt=None):
    """The kinds that a motion from one time to another may be called; edges (k,) s: of the parts that it is looked at in."""
    doubt = doubt or Doubt()
    own = signals.part(begin, end)
    if len(signals.time) < 3 or own.start >= len(signals.time):
        return {RUNNING_AWAY} if signals.diverged else {"not resolved"}
    touch, slack = signals.touch[own], signals.largest(signals.d, begin, end) / signals.gap - 1.0
    none = {True, False} if abs(slack) < 1e-3 or 0 < touch.sum() < 3 else {not touch.any()}
    edges = np.linspace(begin, end, 9) if edges is None else edges
    turn = np.interp(edges, signals.time, signals.turn)
    parts = np.diff(turn)
    shaft = abs(float(np.diff(np.interp([begin, end], signals.time, signals.shaft))[0]))
    turned, share = abs(float(turn[-1] - turn[0])), touch.mean()
    rolling, near = (values[own][touch].mean() if touch.any() else 0.0 for values in (signals.rolls, signals.near))
    arc = abs(signals.d[own][touch].mean()) / signals.gap if touch.any() else 0.0
    work, scale = signals.fed[own].sum(), np.abs(signals.fed[own]).sum()
    beside_shaft = abs(turned - shaft) - max(0.75, 0.01 * shaft)
    # where d begins at nothing it turns in loops that samples may miss
    loops = 1.0 if np.abs(signals.d[own]).min() < CENTRE * signals.gap else 0.0
    allowed = set()
    for answers in itertools.product(
        none,
        _sides(parts.min(), 0.0, doubt.turns) if parts.max() > 0.0 else {False},
        _sides(-parts.max(), 0.0, doubt.turns) if parts.min() < 0.0 else {False},
        _sides(turned, LEAST_TURNS, doubt.least),
        _sides(turned, SENSE_TURNS, doubt.turns),
        _sides(shaft, LEAST_TURNS, doubt.least),
        _sides(share, PERMANENT, min(doubt.share, max(3.0 / max(len(touch), 1), doubt.share))) if share < 1.0 else {True},
        _sides(rolling, ROLLING, doubt.rolling + near),
        _sides(share, 0.5, 2.0 * doubt.share),
        {True, False} if abs(work) <= 2e-3 * scale else {bool(work > 0.0)},
        _sides(-beside_shaft, 0.0, 0.1 + 0.002 * shaft + loops),
        _sides(arc, ARC, doubt.arc),
        _repeats(signals, own, edges, max(turned, shaft)),
    ):
        allowed.add(_kind(answers, signals.driven))
    return allowed


def _repeats(signals, own, edges, turned):
    """Possible answers to whether a contact that comes and goes repeats itself; turned: turns of d or the shaft, the larger."""
    touch = signals.touch[own]
    parts = [signals.touch[signals.part(*edge)].any() for edge in itertools.pairwise(edges)]
    lengths = [sum(np.diff(edges)[list(at)]) for pressed, at in _runs(parts) if not pressed]
    free = max(lengths, default=0.0) / (edges[-1] - edges[0])
    onsets = int((np.diff(touch.astype(int)) > 0).sum()) + 0.5 * bool(touch[0])  # which may have begun before
    many, half = _sides(onsets, min(3.0, turned), 0.6), _sides(touch.mean(), 0.5, 0.02)
    long = _sides(free, 0.5, 0.5 / len(parts))
    return {(a or b) and not c for a in many for b in half for c in long}


def _runs(values):
    """(value, places) of consecutive equal ones."""
    for value, group in itertools.groupby(range(len(values)), key=lambda i: bool(values[i])):
        yield value, list(group)


def _kind(answers, driven):
    """The table of docs/users/motions.md, row by row."""
    none, forward, backward, whole, turned, shaft, permanent, rolls, often, fed, with_shaft, in_arc, repeats = answers
    if none:
        return NO_CONTACT
    if not (whole or shaft):
        return "not resolved"
    if not permanent and not repeats:
        return "transient contact"
    if permanent and forward and turned and with_shaft:
        return "forward rub"
    if forward and turned and (permanent or (often and driven)) and not with_shaft:
        return "forward whirl"
    if permanent and backward and turned:
        return "backward whirl, rolling" if rolls else "backward whirl, sliding"
    if not permanent and backward and turned and fed:
        return "bouncing backward whirl"
    if permanent and in_arc and not (turned and (forward or backward)):
        return "resting on the stator"
    return "partial rub"
