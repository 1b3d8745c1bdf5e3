"""A run for its end alone: no samples are kept, only the facts of its stretches and the state in which it stands."""

from dataclasses import replace

import numpy as np

from rsc.kernel import model as kernel
from rsc.kernel.facts import BEGIN, END, FINISHED, TIME
from rsc.kernel.march import march
from rsc.simulation import driven, races
from rsc.simulation.pack import pack
from rsc.simulation.run import InitialState, new_work
from rsc.simulation.stretches import facts_of, room_for, running_rows

_ROWS = 4  # of samples that the kernel has room for: the one at time 0, and what a step may add
_NEVER = 1e-12  # Hz, a rate at which no other sample comes


def packed_for_shots(system, solver, stretch):
    """The Packed of a system whose shots have stretches of about so many seconds."""
    packed = pack(system, solver, _NEVER)
    duration = float(packed.model.corner_time[-1])
    return replace(packed, model=packed.model._replace(stretch=duration / max(1, round(duration / stretch))))


class Shot:
    """A run of a packed system from a state.

    Parameters
    ----------
    packed : Packed
        As `packed_for_shots` makes it; its schedule tells how long the run may be.
    start : InitialState
    turns : float
        Of the shaft at the start.
    """

    def __init__(self, packed, start, turns=0.0):
        self._packed, self._work = packed, new_work(packed, start, turns)
        self._out, self._rows = np.zeros((_ROWS, self._work.x.size + 3 * len(packed.model.contacts))), room_for(packed.model)
        self.code = kernel.RUNNING

    def advance(self, attempts):
        """Attempt so many steps; returns whether the run goes on."""
        packed = self._packed
        self.code, _ = march(packed.model, self._work, self._out, self._rows, packed.width, packed.method, attempts)
        return self.code == kernel.RUNNING

    @property
    def diverged(self):
        """Whether it left every bound."""
        return self.code == kernel.DIVERGED

    @property
    def finished(self):
        """Whether it reached its end."""
        return self.code == kernel.FINISHED

    @property
    def stopped(self):
        """Whether its rotor came to rest, of a drive with a torque."""
        return self.code == kernel.STOPPED

    @property
    def time(self):
        """Time at which it stands, s."""
        return float(self._work.real[kernel.T_HI])

    @property
    def speed(self):
        """Rotor speed in Hz at which it stands, of a drive with a torque."""
        return float(driven.speed_of(self._packed.model, self._work.v)) / (2.0 * np.pi)

    @property
    def n_stretches(self):
        """Stretches that have ended."""
        return int(self._work.stretch[FINISHED])

    def facts(self):
        """Facts (n, len(COLUMNS)) of the stretches that have ended, and of the running one of a run that has; of several contacts
        side by side."""
        rows, running = self._rows[:, : self.n_stretches], running_rows(self._packed.model, self._work.stretch)
        if self.code != kernel.RUNNING and running[0, END + TIME] > running[0, BEGIN + TIME]:
            rows = np.concatenate([rows, running[:, None]], axis=1)
        return facts_of(rows)

    @property
    def turns(self):
        """Turns of the shaft at which it stands, modulo one."""
        return float(self._work.real[kernel.PHASE])

    def state(self):
        """The InitialState from which a run would go on, but for the angle of the shaft."""
        (rotor, stator), (rotor_dot, stator_dot) = (self._packed.physical(v[None, :]) for v in (self._work.x, self._work.v))
        own = rotor[0].copy(), rotor_dot[0].copy(), stator[0].copy(), stator_dot[0].copy()
        return InitialState(*own, races.speeds_of(self._packed.model, self._work.v))
