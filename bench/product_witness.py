"""Runs of the third engine from the start of a run of rsc, at every contact what `Witness` is at one."""

from functools import cached_property

import numpy as np

from answers_engine import Drive, Samples, State, machine_of
from answers_labels import Signals
from answers_motions import AtSpeed
from answers_witness import Witness
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from third_engine import GAP, RADIUS, beside, prescribed, run, state_of, torque_of
from third_engine import machine_of as whole_machine_of

LOST = 1e5  # gaps, of a run that has diverged


def shaft_of(scene, system):
    """What turns the shaft of a scene."""
    drive = scene.drive
    if drive.inertia is None:
        return prescribed(np.column_stack([system.schedule_time, system.schedule_speed]))
    return torque_of(system.drive.inertia, drive.torque, drive.coast, np.inf if drive.trip is None else drive.trip)


class Runs:
    """Runs of the third engine from beside a start, made when asked for.

    scene, system; state: of `third_engine.march`; shaft; end s
    """

    def __init__(self, scene, system, state, shaft, end):
        self.scene, self.system, self.state, self.shaft, self.end = scene, system, state, shaft, end
        self.machine, self._known = whole_machine_of(system), {}
        speed = abs(float(state[1]))
        self.contacts = [machine_of(system.at_contact(contact.name).at_speed(speed)) for contact in system.contacts]

    def of(self, number, finer=1.0):
        """[Signals] at every contact of a run; 0: from the start itself, others from perturbed starts."""
        if (number, finer) not in self._known:
            self._known[number, finer] = self.signals(self.path(number, finer))
        return self._known[number, finer]

    def path(self, number, finer=1.0):
        """The Path of a run."""
        return run(self.machine, self.shaft, beside(self.state, self.machine, number), self.end, finer)

    def signals(self, path):
        """[Signals] of a Path at every contact."""
        n, m = self.system.n_rotor, path.machine
        drive = Drive(path.time, 2.0 * np.pi * path.speed, 2.0 * np.pi * path.turns)
        told = []
        for j, machine in enumerate(self.contacts):
            parts = []
            for values in (path.q, path.v):
                for own in (slice(0, n), slice(n, None)):
                    row = np.zeros_like(m.rows[j])
                    row[own] = m.rows[j][own]
                    parts.append((1.0 if own.start == 0 else -1.0) * path.along(values, row[None])[:, 0])
            rotor, stator, rotor_rate, stator_rate = parts
            surface = path.races[:, j] * (m.surfaces[j, RADIUS] + m.surfaces[j, GAP])
            lost = bool(np.abs(rotor - stator).max() > LOST * machine.gap)
            told.append(Signals(Samples(machine, drive, path.time, rotor, stator, rotor_rate, stator_rate, None, lost, surface)))
        return told


class ContactWitness(Witness):
    """A Witness at contact number j of a report, of runs that all contacts share."""

    def __init__(self, report, runs, j):
        self.report, self.scene, self.system, self.runs, self.j = report, runs.scene, runs.system, runs, j
        self.machine, self.end = runs.contacts[j], runs.end
        self._start, self._dice, self._at = State(np.zeros(1), np.zeros(1)), np.random.default_rng(1), {}
        path = runs.path(0)
        self.drive = Drive(path.time, 2.0 * np.pi * path.speed, 2.0 * np.pi * path.turns)
        self.signals = [runs.of(0)[j]]
        self.edges = np.append(report.stretches.begin, report.stretches.end[-1:])

    def _run(self, state, finer=1.0):
        return self.runs.of(0, finer)[self.j]

    def _one_more(self):
        return self.runs.of(len(self.signals))[self.j]

    def at(self, speed):
        """AtSpeed of a speed in Hz, kept; by the second engine, which knows one contact without a race."""
        if speed not in self._at:
            self._at[speed] = AtSpeed(self.system.at_speed(2.0 * np.pi * speed), speed)
        return self._at[speed]


class ProductWitness:
    """The ContactWitness of every contact of a report; scene: what was run, with its torque."""

    def __init__(self, report, scene):
        self.report, self.scene, self.system = report, scene, assemble(scene)
        state = state_of(initial_state(scene, self.system), 0.0, scene.drive.speed[0], len(scene.contacts))
        end = max(float(report.result.time[-1]), float(report.stretches.end[-1]))
        self.runs = Runs(scene, self.system, state, shaft_of(scene, self.system), end)
        self.contacts = [ContactWitness(report, self.runs, j) for j in range(len(scene.contacts))]

    @cached_property
    def every(self):
        """[[Signals]] at every contact of all runs that are needed to see whether they agree."""
        count = max(len(contact.every()) for contact in self.contacts)
        return [self.runs.of(number) for number in range(count)]
