"""One run from a scene: the loop over the kernel's chunks, progress, interruption, and how it ended."""

import contextlib
import platform
import signal
import threading
from pathlib import Path

import numba
import numpy as np

from rsc.assemble import assemble
from rsc.errors import DataError
from rsc.kernel import model as kernel
from rsc.kernel.march import march
from rsc.pack import first_step, pack
from rsc.result_file import (
    ResultFile,
    ResultWriter,
    discard_left,
    read_summary,
    refuse_other_scene,
    resumable,
    take_over,
)
from rsc.start import initial_state
from rsc.summary import Ledger, Status, Summary
from rsc.trajectory import MemoryBlocks, Trajectory, load

# steps per call of the kernel: some 10 ms, so that progress shows and Ctrl-C is answered at once
CHUNK_STEPS = 20_000
BUFFER_ROWS = 16_384

_STATUS = {
    kernel.FINISHED: Status.FINISHED,
    kernel.DIVERGED: Status.DIVERGED,
    kernel.STEP_COLLAPSED: Status.STEP_COLLAPSED,
    kernel.NON_FINITE: Status.NON_FINITE,
    kernel.TOO_MANY_STEPS: Status.TOO_MANY_STEPS,
}


def simulate(scene, progress=False, path=None, resume=False):
    """Integrate a scene over its whole speed schedule.

    Parameters
    ----------
    scene : Scene
    progress : bool
        Show simulated time, speed and remaining time on standard error.
    path : str or Path, optional
        Stream the samples to this HDF5 file in bounded memory; otherwise they stay in memory.
    resume : bool
        Continue the run that `path` (or what a kill left of it) holds, bit for bit; a finished run is returned as it is.

    Returns
    -------
    Trajectory
        Also when the run did not finish: see its `status` and `summary.advice`.

    Raises
    ------
    SceneError
        The start asks for a whirl that does not exist, or a run to be resumed has another scene.
    DataError
        The file cannot be written, holds nothing to resume, or is being written by another run.
    """
    system = assemble(scene)
    packed = pack(system, scene.solver, scene.output.rate)
    if path is None:
        sink = MemoryBlocks()
        run = _Run(scene, system, packed, _new_work(packed, initial_state(scene, system)))
        return Trajectory(scene, run.march(sink, progress), sink)
    if resume:
        return _resume(scene, system, packed, path, progress)
    work = _new_work(packed, initial_state(scene, system))
    with ResultWriter(path, scene) as writer:
        writer.finish(_Run(scene, system, packed, work).march(writer, progress))
    return load(path)


def _resume(scene, system, packed, path, progress):
    """Continue the run in `path`, or what a kill left of it, from its last checkpoint."""
    source = resumable(path)
    refuse_other_scene(path, ResultFile(source).scene(), scene)
    if source == Path(path) and read_summary(path).status == Status.FINISHED:
        return load(path)
    old = ResultFile(take_over(path))
    checkpoint = old.checkpoint()
    if checkpoint is None:
        raise DataError(path, "holds no checkpoint to continue from")
    run = _Run(scene, system, packed, _work_of(checkpoint), float(checkpoint["energy_start"][0]))
    with ResultWriter(path, scene) as writer:
        writer.copy(old.path, int(checkpoint["rows"][0]))
        discard_left(path)
        writer.finish(run.march(writer, progress, first=False))
    return load(path)


def _new_work(packed, start):
    x = packed.modal(start.rotor, start.stator)
    v = packed.modal(start.rotor_velocity, start.stator_velocity)
    count = np.zeros(kernel.N_COUNT, dtype=np.int64)
    count[kernel.NORMAL] = -1  # the kernel tells the contact's mode from the state
    real = np.zeros(kernel.N_REAL)
    real[kernel.H] = real[kernel.H_OTHER] = first_step(packed)
    return kernel.Work(x, v, real, count, np.zeros_like(x), np.zeros_like(x))


def _checkpoint(work, energy_start):
    """All that the rest of a run depends on, name -> array; `rows` is the number of samples saved so far."""
    arrays = {name: getattr(work, name).copy() for name in work._fields}
    return arrays | {"rows": work.count[[kernel.SAMPLES]], "energy_start": np.array([energy_start])}


def _work_of(checkpoint):
    return kernel.Work(**{name: np.ascontiguousarray(checkpoint[name]) for name in kernel.Work._fields})


class _Run:
    """A run in progress."""

    def __init__(self, scene, system, packed, work, energy_start=None):
        self.scene, self.system, self.packed, self.work = scene, system, packed, work
        self.energy_start = _energy(packed, work) if energy_start is None else energy_start

    def march(self, sink, progress, first=True):
        """Call the kernel until the run ends, handing every block of samples to the sink; returns the Summary."""
        width = self.work.x.shape[0] + 3
        wanted = int(self.scene.drive.duration * self.scene.output.rate) + 3
        out = np.zeros((min(BUFFER_ROWS, wanted), width))
        if first:  # even a run that ends before its first sample has all its arrays
            self._hand_over(sink, out[:0], 0)
        with _interrupt_flag() as interrupted, _bar(self.scene, progress) as show:
            while True:
                row = int(self.work.count[kernel.SAMPLES])
                code, filled = march(self.packed.model, self.work, out, self.packed.lanes, CHUNK_STEPS)
                if filled:
                    self._hand_over(sink, out[:filled], row)
                show(self.work.real[kernel.T_HI])
                if code not in (kernel.RUNNING, kernel.BUFFER_FULL):
                    return self._summary(_STATUS[code])
                if interrupted():
                    return self._summary(Status.INTERRUPTED)
                if code == kernel.BUFFER_FULL and not filled:
                    out = np.zeros((2 * out.shape[0], width))

    def _hand_over(self, sink, rows, first):
        sink.append(self._block(rows, first), _checkpoint(self.work, self.energy_start))

    def _block(self, rows, first):
        time = np.arange(first, first + rows.shape[0]) / self.scene.output.rate
        rotor, stator = self.packed.physical(rows[:, :-3])
        return {
            "time": time,
            "speed": np.interp(time, self.scene.drive.time, self.scene.drive.speed),
            "rotor": rotor,
            "stator": stator,
            "normal_force": rows[:, -3].copy(),
            "friction_force": rows[:, -2].copy(),
            "tangential_velocity": rows[:, -1].copy(),
        }

    def _summary(self, status):
        count, real = self.work.count, self.work.real
        ledger = self._ledger()
        return Summary(
            status=status,
            advice=_advice(status, self.system, ledger, real),
            end_time=float(real[kernel.T_HI]),
            steps=int(count[kernel.STEPS]),
            rejected=int(count[kernel.REJECTED]),
            rhs_calls=int(count[kernel.RHS_CALLS]),
            switches=int(count[kernel.SWITCHES]),
            contact_onsets=int(count[kernel.ONSETS]),
            contact_releases=int(count[kernel.RELEASES]),
            contact_time=float(real[kernel.CONTACT_TIME]),
            ledger=ledger,
            versions=f"python {platform.python_version()}, numba {numba.__version__}, numpy {np.__version__}",
        )

    def _ledger(self):
        model, work = self.packed.model, self.work
        n = 2 * self.system.n_rotor
        damped = -model.weight * work.ledger_damping
        energy_in = float((model.weight * work.ledger_input).sum() + work.real[kernel.E_DRIVE])
        friction, contact = float(work.real[kernel.E_FRICTION]), float(work.real[kernel.E_CONTACT])
        change = _energy(self.packed, work) - self.energy_start
        rotor, stator = float(damped[:n].sum()), float(damped[n:].sum())
        residual = energy_in + friction - rotor - stator - contact - change
        return Ledger(energy_in, friction, rotor, stator, contact, change, residual)


def _energy(packed, work):
    """Kinetic and elastic energy of rotor, stator and contact spring, J."""
    m = packed.model
    lateral = 0.5 * float((m.weight * (work.v**2 - m.stiffness * work.x**2)).sum())
    turns = work.real[kernel.PHASE]
    ring = (m.ring_y + 1j * m.ring_z) * np.exp(2j * np.pi * turns)
    penetration = max(abs((m.contact_row * work.x).view(complex).sum() + ring) - m.gap, 0.0)
    return lateral + 0.5 * m.k_c * penetration**2


def _advice(status, system, ledger, real):
    """One sentence on what stopped a run and what to change."""
    time, h = real[kernel.T_HI], real[kernel.H]
    speed = float(system.speed_at(time)) / (2.0 * np.pi)
    where = f"at {time:.6g} s ({speed:.4g} Hz)"
    if status == Status.DIVERGED:
        return f"the motion grew beyond bounds {where}: {_what_fed(system, ledger)}"
    if status == Status.STEP_COLLAPSED:
        return f"the step fell to {h:.3g} s {where}: loosen solver.rtol or look for a stiffness or mass far out of scale"
    if status == Status.NON_FINITE:
        return f"a non-finite acceleration {where}: look for numbers in the scene that overflow"
    if status == Status.TOO_MANY_STEPS:
        return f"solver.max_steps reached {where}: raise it, shorten the run or loosen solver.rtol"
    if status == Status.INTERRUPTED:
        return f"interrupted {where}; the samples until then are kept"
    return ""


def _what_fed(system, ledger):
    if ledger.friction_in < 0.5 * abs(ledger.energy_in):
        return "the imposed forces fed it; look for negative damping or an undamped resonance"
    if system.diameter is None:
        return (
            "contact friction fed it, and the condition 'sliding' (12) is not checked because the one-sided law "
            "(no contact.diameter) slides forward for ever; give contact.diameter, or lower friction"
        )
    return "contact friction fed it while sliding never ended; lower friction or add stator damping"


@contextlib.contextmanager
def _interrupt_flag():
    """Yield a function that tells whether Ctrl-C or SIGTERM came; a second one acts at once."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    caught = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def restore():
        for number, handler in before.items():
            signal.signal(number, handler)

    def handler(number, frame):
        caught.append(number)
        restore()

    for number in before:
        signal.signal(number, handler)
    try:
        yield lambda: bool(caught)
    finally:
        restore()


@contextlib.contextmanager
def _bar(scene, progress):
    """Yield a function that shows the simulated time."""
    if not progress:
        yield lambda time: None
        return
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n:.2f}/{total:.0f} s [{elapsed}<{remaining}{postfix}]"
    with tqdm(total=scene.drive.duration, bar_format=form, mininterval=0.2) as bar:

        def show(time):
            bar.update(time - bar.n)
            bar.set_postfix_str(f"speed {np.interp(time, scene.drive.time, scene.drive.speed):.1f} Hz", refresh=False)

        yield show
