"""A run without samples: only the facts of its stretches and its current state are kept."""

from dataclasses import replace

import numpy as np

from rsc.kernel import model as kernel
from rsc.kernel.facts import BEGIN, END, FINISHED, TIME
from rsc.kernel.march import march
from rsc.simulation import driven, races
from rsc.simulation.pack import in_classes, pack
from rsc.simulation.run import InitialState, new_work
from rsc.simulation.stretches import facts_of, room_for, running_rows

_ROWS = 4  # sample rows of the kernel's buffer: one for time 0, and what a step may add
_NEVER = 1e-12  # Hz, a rate so low that no further sample occurs


def packed_for_shots(system, scene, stretch):
    """The Packed of a scene's system for shots with stretches of some `stretch` seconds, in the compiled kernel of its runs."""
    packed = pack(system, scene.solver, _NEVER, in_classes(scene))
    duration = float(packed.model.corner_time[-1])
    return replace(packed, model=packed.model._replace(stretch=duration / max(1, round(duration / stretch))))


class Shot:
    """A run of a packed system from a state.

    Parameters
    ----------
    packed : Packed
        From `packed_for_shots`; its schedule limits the length of the run.
    start : InitialState
    turns : float
        Rotation of the shaft at the start.
    """

    def __init__(self, packed, start, turns=0.0):
        self._packed, self._work = packed, new_work(packed, start, turns)
        self._out, self._rows = np.zeros((_ROWS, self._work.x.size + 3 * len(packed.model.contacts))), room_for(packed.model)
        self.code = kernel.RUNNING

    def advance(self, attempts):
        """Attempt this many steps; returns whether the run can continue."""
        packed = self._packed
        self.code, _ = march(packed.model, self._work, self._out, self._rows, packed.width, packed.method, attempts)
        return self.code == kernel.RUNNING

    @property
    def diverged(self):
        """Whether it diverged."""
        return self.code == kernel.DIVERGED

    @property
    def finished(self):
        """Whether it reached its end time."""
        return self.code == kernel.FINISHED

    @property
    def stopped(self):
        """Whether the rotor stopped turning, with a torque-limited drive."""
        return self.code == kernel.STOPPED

    @property
    def time(self):
        """Current time, s."""
        return float(self._work.real[kernel.T_HI])

    @property
    def speed(self):
        """Current rotor speed in Hz, with a torque-limited drive."""
        return float(driven.speed_of(self._packed.model, self._work.v)) / (2.0 * np.pi)

    @property
    def n_stretches(self):
        """Number of finished stretches."""
        return int(self._work.stretch[FINISHED])

    def facts(self):
        """Facts (n, len(COLUMNS)) of the finished stretches, and of the running one if the run has ended; with several contacts
        side by side."""
        rows, running = self._rows[:, : self.n_stretches], running_rows(self._packed.model, self._work.stretch)
        if self.code != kernel.RUNNING and running[0, END + TIME] > running[0, BEGIN + TIME]:
            rows = np.concatenate([rows, running[:, None]], axis=1)
        return facts_of(rows)

    @property
    def turns(self):
        """Current rotation of the shaft in turns, modulo one."""
        return float(self._work.real[kernel.PHASE])

    def state(self):
        """The InitialState from which a run would continue; the shaft angle is `turns`."""
        (rotor, stator), (rotor_dot, stator_dot) = (self._packed.physical(v[None, :]) for v in (self._work.x, self._work.v))
        motion = rotor[0].copy(), rotor_dot[0].copy(), stator[0].copy(), stator_dot[0].copy()
        states = self._packed.states(self._work.v[None, :])[0] if self._packed.state_size.size else None
        return InitialState(*motion, races.speeds_of(self._packed.model, self._work.v), states)
