"""A run in progress: blocks of samples from the kernel's chunks, its checkpoint and its summary."""

import platform
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import llvmlite.binding
import numba
import numpy as np

from rsc.compiled.code_cache import fingerprint
from rsc.kernel import model as kernel
from rsc.kernel.facts import BEGIN, END, FINISHED, TIME
from rsc.kernel.march import march
from rsc.results.result_format import OF_CONTACT
from rsc.results.summary import Status, Summary
from rsc.simulation import driven, races
from rsc.simulation.advice import advice_of
from rsc.simulation.checkpoint import work_of
from rsc.simulation.energies import energy, ledger_of, spring_energy
from rsc.simulation.pack import pack_all
from rsc.simulation.sliding import SlidingWatch
from rsc.simulation.stretches import begun, facts_of, room_for, running_rows
from rsc.simulation.tolerances import first_step
from rsc.system.assemble import assemble
from rsc.system.blas import product

# steps times coordinates per call of the kernel: some 10 ms of a small model, so that progress is shown and Ctrl-C is answered at
# once; a block written to the file takes 2 ms
CHUNK_STEPS = 300_000
BUFFER_ROWS = 16_384
# measured: steps in contact are about this many times longer than the cautious first one
STEP_GROWTH = 200.0

STATUS = {
    kernel.FINISHED: Status.FINISHED,
    kernel.DIVERGED: Status.DIVERGED,
    kernel.STEP_COLLAPSED: Status.STEP_COLLAPSED,
    kernel.NON_FINITE: Status.NON_FINITE,
    kernel.TOO_MANY_STEPS: Status.TOO_MANY_STEPS,
    kernel.TOO_STIFF: Status.STIFF,
    kernel.STOPPED: Status.STOPPED,
}

@cache
def versions():
    """One line with everything besides the scene that the bits of a run depend on."""
    kernel_hash, processor = fingerprint(Path(kernel.__file__).parent), llvmlite.binding.get_host_cpu_name()
    try:
        release = version("rotor-stator-contact")
    except PackageNotFoundError:  # run from source
        release = "of unknown version"
    libraries = f"python {platform.python_version()}, numba {numba.__version__}, numpy {np.__version__} with {product()}"
    return f"rsc {release}, {libraries}, kernel {kernel_hash[:12]} on {processor}"


def new_work(packed, start, turns=0.0):
    """The Work of a new run from an InitialState, with the shaft rotated by `turns`."""
    x = packed.modal(start.rotor, start.stator)
    v = packed.modal(start.rotor_velocity, start.stator_velocity)
    if start.states is not None:
        v = packed.with_states(v, start.states)
    driven.begin(packed.model, v)
    if start.races is not None:
        races.begin(packed.model, v, start.races)
    count = np.zeros(kernel.n_count(len(packed.model.contacts)), dtype=np.int64)
    count[kernel.NORMAL] = -1  # the kernel determines the contact states from the motion
    real = np.zeros(kernel.n_real(len(packed.model.contacts)))
    real[kernel.H], real[kernel.PHASE] = first_step(packed), turns
    put_in = np.zeros_like(x)
    work = kernel.Work(x, v, np.zeros_like(x), put_in, real, count, begun(packed.model, x, v, turns))
    put_in[0] = -spring_energy(packed.model, work) / packed.model.weight[0]  # compensates the stored energy in `ledger_of`
    return work


@dataclass(frozen=True)
class InitialState:
    """Complex displacements (m) and velocities (m/s) of rotor (N,) and stator (M,) at t = 0, surface velocities (m/s) of inner
    races at all contacts (n_contacts,), 0 without a race; races = None: at rest; and complex first-order states (p,) of rotor,
    then stator; None: zeros."""

    rotor: np.ndarray
    rotor_velocity: np.ndarray
    stator: np.ndarray
    stator_velocity: np.ndarray
    races: np.ndarray | None = None
    states: np.ndarray | None = None


class Run:
    """A run of a scene from an initial state.

    Parameters
    ----------
    scene : Scene
    system : System
    packed : Packed
        Made from this system and scene.
    start : InitialState
    """

    def __init__(self, scene, system, packed, start):
        work = new_work(packed, start)
        self._begin(scene, system, packed, work, energy(packed, work))
        self.sliding, self._code, self.versions = SlidingWatch(system.sense), kernel.RUNNING, versions()

    @classmethod
    def resumed(cls, scene, checkpoint, made_with=None):
        """A run from a checkpoint, which continues bit for bit.

        Parameters
        ----------
        scene : Scene
        checkpoint : dict
            name -> array as returned by `checkpoint()`; SolverError if it is not a possible state of a run of this scene.
        made_with : str, optional
            `versions` of the earlier part of the run, if known.
        """
        run, system = cls.__new__(cls), assemble(scene)
        (packed,) = pack_all([system], [scene])
        work = work_of(checkpoint, scene, packed)
        run._begin(scene, system, packed, work, float(checkpoint["energy_start"][0]))
        run.sliding, run._code = SlidingWatch(system.sense, checkpoint["sliding"]), int(checkpoint["code"][0])
        run.versions = made_with or versions()
        return run

    def _begin(self, scene, system, packed, work, energy_start):
        self.scene, self.system, self.packed, self.work, self.energy_start = scene, system, packed, work, energy_start
        self._rows, self._taken = room_for(packed.model), self.n_stretches

    @property
    def time(self):
        """Simulated time reached, s."""
        return float(self.work.real[kernel.T_HI])

    @property
    def buffer_bytes(self):
        """Largest size of the sample buffer in bytes: it grows until it holds the samples of the longest step."""
        rows, most = self._buffer_rows(), self.packed.longest_step * self.scene.output.rate + 2.0
        while rows < min(most, self._most_rows()):
            rows = self._grown(rows)
        return 8 * rows * (self.row_size + self._forces)

    @property
    def row_size(self):
        """Numbers of the motion in a sample as written by the kernel: x, followed by v if the scene asks for velocities."""
        return self.work.x.size * (2 if self.scene.output.velocities else 1)

    @property
    def _forces(self):
        """Trailing columns of a sample: normal force, friction force and tangential velocity of each contact."""
        return 3 * len(self.packed.model.contacts)

    @property
    def least_steps(self):
        """Lower bound for the number of steps: none is longer than a quarter turn or a quarter of the rotor's natural period,
        except blocks of exact flight."""
        return self.scene.drive.duration / self.packed.longest_step

    @property
    def chunk_time(self):
        """Simulated time in s of a short chunk: entirely in contact, or one that fills the buffer."""
        return min(self._chunk_steps() * STEP_GROWTH * first_step(self.packed), BUFFER_ROWS / self.scene.output.rate)

    def _chunk_steps(self):
        return max(1, 2 * CHUNK_STEPS // self.work.x.size)

    def _buffer_rows(self):
        return min(BUFFER_ROWS, self._most_rows())

    def _most_rows(self):
        return int(self.scene.drive.duration * self.scene.output.rate) + 3

    def _grown(self, rows):
        return min(2 * rows, self._most_rows())

    def checkpoint(self):
        """Everything that the rest of the run depends on, name -> array; `rows` is the number of samples saved so far."""
        arrays = {name: getattr(self.work, name).copy() for name in self.work._fields}
        arrays |= {name: self.packed.kept(arrays[name]) for name in kernel.WORK_VECTORS}  # without padding
        numbers = {"energy_start": self.energy_start, "code": self._code, "rows": self.work.count[kernel.SAMPLES]}
        return arrays | {"sliding": self.sliding.state.copy()} | {name: np.array([n]) for name, n in numbers.items()}

    @property
    def n_stretches(self):
        """Number of finished stretches."""
        return int(self.work.stretch[FINISHED])

    def take_stretches(self, last=False):
        """Facts (k, len(COLUMNS)) of the stretches finished since the last call; with `last` also of the running one, in which
        the run ended."""
        rows, self._taken = self._rows[:, self._taken : self.n_stretches], self.n_stretches
        running = running_rows(self.packed.model, self.work.stretch)
        if last and running[0, END + TIME] > running[0, BEGIN + TIME]:
            rows = np.concatenate([rows, running[:, None]], axis=1)
        return facts_of(rows)

    def compile(self):
        """Compile the kernel for this number of coordinates, or load it from the cache, without taking a step."""
        out = np.zeros((0, self.row_size + self._forces))
        work = kernel.Work(*(values.copy() for values in self.work))
        march(self.packed.model, work, out, self._rows, self.packed.width, self.packed.method, 0)

    def chunks(self):
        """Advance chunk by chunk; yields (block of samples, Status, None while the run continues)."""
        forces = self._forces
        width = self.row_size + forces
        out = np.zeros((self._buffer_rows(), width))
        if self._code in STATUS:  # killed between the last block and renaming the file: another step would be too many
            yield self.empty_block(), STATUS[self._code]
            return
        while True:
            row = int(self.work.count[kernel.SAMPLES])
            where = out, self._rows
            code, filled = march(self.packed.model, self.work, *where, self.packed.width, self.packed.method, self._chunk_steps())
            self._code = code
            yield _owned(self.seen_block(out[:filled, :-forces], out[:filled, -forces:].T, row)), STATUS.get(code)
            if code in STATUS:
                return
            if code == kernel.BUFFER_FULL and not filled:  # one step holds more samples than the buffer
                out = np.zeros((self._grown(len(out)), width))

    def empty_block(self):
        """A block without samples, which shows names and shapes of all arrays."""
        return self._block(np.zeros((0, self.row_size)), np.zeros((self._forces, 0)), 0)

    def seen_block(self, motion, forces, first):
        """Samples from number `first` on, name -> array, from the kernel's motion (k, row_size) and contact columns (3 contacts,
        k), some of them as views; sliding is monitored."""
        block = self._block(motion, forces, first)
        for i, contact in enumerate(self.system.contacts):
            if contact.law.diameter is None and contact.law.friction > 0.0:
                self.sliding.see(block if len(self.system.contacts) == 1 else of_contact(block, i))
        return block

    def _block(self, motion, forces, first):
        time = np.arange(first, first + len(motion)) / self.scene.output.rate
        width = self.work.x.size
        rotor, stator = self.packed.physical(motion[:, :width])
        turned = self._turned(time, motion)
        block = {
            "time": time,
            **turned,
            "rotor": rotor,
            "stator": stator,
            **{name: forces[i] if len(forces) == 3 else forces[i::3].T for i, name in enumerate(OF_CONTACT[:3])},
            **self._races(motion),
        }
        if self.packed.state_size.size:
            states, p = self.packed.states(motion[:, :width]), self.system.at_start.rotor.n_states
            block["rotor_states"], block["stator_states"] = states[:, :p], states[:, p:]
        if self.scene.output.velocities:
            block["rotor_velocity"], block["stator_velocity"] = self.packed.physical(motion[:, width:])
        return block

    def _turned(self, time, motion):
        """Speed of the samples, and their angle if the speed is integrated."""
        if self.packed.model.drive:
            place = self.work.x.size - 2
            return {"speed": motion[:, place + 1].copy(), "angle": motion[:, place].copy()}
        return {"speed": np.interp(time, self.scene.drive.time, self.scene.drive.speed)}

    def _races(self, motion):
        """Speed of the races in the samples, with several contacts one column each."""
        places = [contact.race.place if contact.race else None for contact in self.packed.model.contacts]
        if not any(places):
            return {}
        none = np.zeros(len(motion))
        columns = [none if place is None else motion[:, place] for place in places]
        return {"race_speed": np.column_stack(columns) if len(columns) > 1 else columns[0].copy()}

    def summary(self, status):
        """The Summary of the run so far."""
        count, real = self.work.count, self.work.real
        ledger = ledger_of(self.packed, self.work, self.system.n_rotor, self.energy_start)
        if status == Status.FINISHED and self.sliding.lost_at < np.inf:
            status = Status.OUT_OF_ASSUMPTIONS
        return Summary(
            status=status,
            advice=advice_of(self, status, ledger),
            end_time=float(real[kernel.T_HI]),
            rtol=self.packed.model.rtol,
            steps=int(count[kernel.STEPS]),
            rejected=int(count[kernel.REJECTED]),
            rhs_calls=int(count[kernel.RHS_CALLS]),
            switches=int(count[kernel.SWITCHES]),
            contact_onsets=int(sum(kernel.of_contacts(count, kernel.ONSETS))),
            contact_releases=int(sum(kernel.of_contacts(count, kernel.RELEASES))),
            contact_time=float(max(kernel.of_contacts(real, kernel.CONTACT_TIME))),
            least_diameter=self.sliding.least_diameter,
            sliding_lost=self.sliding.lost_at,
            ledger=ledger,
            versions=self.versions,
        )


def of_contact(block, i):
    """A block of samples with the forces of only one of several contacts."""
    return block | {name: block[name][:, i] for name in OF_CONTACT if name in block}


def _owned(block):
    """A block with copies instead of views, since the kernel reuses its rows."""
    return {name: values if values.base is None else values.copy() for name, values in block.items()}
