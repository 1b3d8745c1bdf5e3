"""Runs of the second engine from the start of a run of rsc, asked what is right, and findings."""

import math
from typing import NamedTuple

import numpy as np

from answers_engine import Drive, State, integrate, machine_of
from answers_labels import RUNNING_AWAY, Signals, kinds
from answers_motions import AtSpeed
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble

PARTED = 0.1  # gaps
FINER = 4.0  # samples and tolerance of the run that a number is compared with before it is called false
AWAY = 1e3  # gaps, of rotor or stator: rsc looks at all coordinates, of which others may be larger
# DISTURBED: share of the velocities, and of the gap, by which the second engine's other runs begin elsewhere;
# RUNS: how many runs there are; CHAOTIC: how many of a motion of which no two stay together, so that chance decides how it ends
DISTURBED, RUNS, CHAOTIC = 1e-4, 3, 24
# as texts of an answer have them
NUM = r"(-?\d+(?:\.\d+)?(?:e[+-]?\d+)?)"
SAID = rf"{NUM} (?:([pnumkMGT]?)(N m|[mNWJ]))"
PREFIX = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}
KINDS = (
    "no contact", "forward rub", "forward whirl", "backward whirl, sliding", "backward whirl, rolling", "bouncing backward whirl",
    "partial rub", "resting on the stator", "running away", "not resolved", "transient contact",
)  # fmt: skip


class Finding(NamedTuple):
    """A line that is false, or that could not be judged: topic, what is wrong and what is right, whether it is only skipped."""

    topic: str
    detail: str
    skipped: bool = False


class Witness:
    """Runs of the second engine from the start of a report's run, the first from it, the others, made when needed, beside it."""

    def __init__(self, report):
        scene = report.result.scene
        self.report, self.scene, self.system = report, scene, assemble(scene)
        self.machine, self.end = machine_of(self.system), float(report.result.time[-1])
        self.drive = Drive.of(self.system.schedule_time, self.system.schedule_speed)
        self._start, self._dice = State.of(initial_state(scene, self.system)), np.random.default_rng(1)
        self.signals = [self._run(self._start)]
        self._at = {}
        self.edges = np.append(report.stretches.begin, report.stretches.end[-1:])

    def _run(self, state, finer=1.0):
        return Signals(integrate(self.machine, self.drive, state, max(self.end, float(self.report.stretches.end[-1])), finer))

    def every(self):
        """All runs; more of them where the first few do not stay together."""
        while len(self.signals) < RUNS or (len(self.signals) < CHAOTIC and self._apart(self.end)):
            self.signals.append(self._one_more())
        return self.signals

    def _one_more(self):
        """One more run, from beside the start."""
        beside = self._start.beside(self._dice, DISTURBED)
        away = DISTURBED * self.machine.gap * self._dice.normal(size=2) @ [1.0, 1j]
        return self._run(beside._replace(x=beside.x + away * abs(self.machine.push) / abs(self.machine.push).max()))

    def largest_mean(self, values, signals):
        """The largest mean of some samples over a stretch, with its sign."""
        means = [signals.mean(values, *pair) for pair in zip(self.edges[:-1], self.edges[1:], strict=True)]
        return max(means, key=abs)

    def number(self, said, value, relative, absolute=0.0):
        """ "" if a number is right, "skipped" if the second engine's own runs do not agree on it (one that ended too early has
        none), else what is right."""

        def near(low, high):
            return low - absolute - relative / (1.0 + relative) * abs(low) <= said <= high + absolute + relative * abs(high)

        first = value(self.signals[0])
        if near(first, first):
            return ""
        values = np.array([value(signals) for signals in self.every()])
        spread = np.ptp(values)
        if not spread <= absolute + relative * abs(values).max():
            return "skipped"
        finest = value(self._run(self._start, FINER))  # whose sums over short contacts are those of its samples
        right = near(values.min() - spread, values.max() + spread) or near(finest - spread, finest + spread)
        return "" if right else f"second engine: {finest:.5g}"

    def places(self, i):
        """Numbers of the first and last (exclusive) stretch that the kind of window i is taken from."""
        fall = self.report.fall
        begin, end = self.span(i)
        middles = 0.5 * (self.edges[1:] + self.edges[:-1])
        first, last = np.searchsorted(middles, [begin, end]).tolist()
        if i == len(fall.time) - 1:
            last = len(middles)
        if last <= first:
            first = min(int(np.searchsorted(self.edges[1:], 0.5 * (begin + end))), len(middles) - 1)
            last = first + 1
        return first, last

    def window_kinds(self, i, signals):
        """Kinds that window i of the report may be called."""
        first, last = self.places(i)
        places = np.linspace(first, last, min(8, last - first) + 1).round().astype(int)
        allowed = kinds(signals, self.edges[first], self.edges[last], self.edges[places])
        largest = max(signals.largest(signals.rotor), signals.largest(signals.stator))
        away = signals.diverged or largest > AWAY * self.machine.gap
        if away and self.edges[last] >= signals.time[-1] - 2.0 * self.report.fall.window:
            allowed = allowed | {RUNNING_AWAY}
        return allowed

    def parted(self, i):
        """Whether the second engine's runs are no longer together at the begin of window i; a change may then come a little
        sooner or later, and the kinds of the windows beside it count as well."""
        self.every()
        return self._apart(self.edges[self.places(i)[0]])

    def _apart(self, time):
        """Whether the runs that there are lie apart at a time, or some of them have ended by then."""
        where = np.array([np.interp(time, signals.time, signals.d) for signals in self.signals])
        return bool(np.ptp(where.real) + np.ptp(where.imag) > PARTED * self.machine.gap)

    def rate(self, i, signals):
        """Rate at which d turns in the stretches of window i, Hz."""
        return signals.turning(*self.edges[list(self.places(i))])

    def span(self, i):
        """(begin, end) of window i, s."""
        fall = self.report.fall
        return fall.time[i] - 0.5 * fall.window, fall.time[i] + 0.5 * fall.window

    def speed(self, time):
        """Rotor speed in Hz."""
        return float(np.interp(time, self.drive.time, self.drive.speed)) / (2.0 * math.pi)

    def at(self, speed):
        """AtSpeed of a speed in Hz, kept."""
        if speed not in self._at:
            self._at[speed] = AtSpeed(self.system, speed)
        return self._at[speed]
