"""One run from a scene: in memory or to a file, with progress and interruption, from its start or resumed."""

import contextlib
import math
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rsc.arguments import FLAG, FUNCTION, PATH, SCENE, optional, takes
from rsc.compiled.code_cache import keeps_code
from rsc.errors import DataError, SolverError
from rsc.files.output import place
from rsc.kernel.model import SAMPLES, STEPS
from rsc.operating_system import SENT_TWICE, STOPS
from rsc.results.agreement import refuse_other_scene
from rsc.results.budget import foresee, refuse_too_large
from rsc.results.result_file import ResultFile, read_summary
from rsc.results.result_writer import ResultWriter
from rsc.results.structure import refuse_other_file
from rsc.results.summary import Status, Summary
from rsc.results.trajectory import MemoryBlocks, Trajectory, load
from rsc.results.unfinished import discard_left, refuse_unfinished, resumable, take_over
from rsc.scene.scene import Scene
from rsc.scene.tables.sections import RETIRED_METHODS
from rsc.simulation.run import Run, versions
from rsc.study.run.start import run_of

# s, the longest that the kernel takes from its cache; compiling takes longer
LOADED = 3.0
# s of processor time to compile the kernel: for any scene, and more for each coordinate: a rough guide
COMPILED, COMPILED_EACH = 8.0, 1.0
# an error per step above this share of the largest motion leaves small quantities wrong
COARSE = 1e-4
LONG_RUN = 1800.0  # s, from which on it is told how long a run will take
CHANGED = "; then "  # between the versions of the parts of a run


@takes(scene=SCENE, progress=FLAG, path=optional(PATH), resume=FLAG, note=FUNCTION, bitwise=FLAG, overwrite=FLAG)
def simulate(
    scene: Scene,
    progress: bool = False,
    path: str | os.PathLike[str] | None = None,
    resume: bool = False,
    note: Callable[[str], object] = lambda text: None,
    bitwise: bool = True,
    overwrite: bool = False,
) -> Trajectory:
    """Integrate a scene over its whole speed schedule.

    Parameters
    ----------
    scene : Scene
    progress : bool
        Show simulated time, speed and remaining time on standard error.
    path : str or Path, optional
        Stream the samples to this HDF5 file in bounded memory; otherwise they stay in memory.
    resume : bool
        Continue the run that `path` (or a file left there by a kill) holds, bit for bit; a run that ended by itself is returned
        as it is, and one that was killed before its first checkpoint begins anew.
    note : callable
        Called before the run starts with one line on the memory and disk it will take, after its first second with one line if
        it will take more than half an hour, and in the end with one line if the tolerance is coarse beside the motion
        (`tolerance_remark`).
    bitwise : bool
        Refuse to resume with other versions or on another processor than the run began with; False goes on all the same, with
        other bits than an undisturbed run would have, and records it in `summary.versions`.
    overwrite : bool
        Write `path` also in the place of a file that rsc did not write, or that was changed since.

    Returns
    -------
    Trajectory
        Also when the run did not finish: see its `status` and `summary.advice`.

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C; its attribute `result` is the Trajectory until then. SIGTERM and SIGHUP, which end the process, and handlers of
        the caller's own take effect when the run so far is saved. A second signal acts at once.
    Exception
        That `note`, or the caller's standard error, raised; once the run has begun its samples are saved first, and the attribute
        `result` is the Trajectory until then.
    SceneError
        The start asks for a whirl that does not exist, or a run to be resumed has another scene.
    SolverError
        The samples would not fit into memory, or resuming would change bits.
    DataError
        The file cannot be written, is there and was not written by rsc, would not fit on its disk, holds nothing to resume, or is
        being written by another run.

    Examples
    --------
    >>> result = rsc.simulate(rsc.load_scene("laval.toml"))
    >>> print(result.status, result.time[-1])
    finished 30.0
    >>> result.rotor.shape
    (60001, 1)
    """
    if path is None:
        refuse_too_large(scene)
        return _handed_over(*_in_memory(run_of(scene), progress, note), note)
    if resume:
        place(path)  # its reader says more
    else:
        refuse_other_file(path, overwrite)
        if damaged := "" if overwrite else refuse_unfinished(path):
            note(f"{damaged}: what a killed run left there cannot be continued, and this run takes its place")
    run, old = _to_resume(scene, path, bitwise, overwrite, note) if resume else (run_of(scene), None)
    if run is None:
        return load(path)
    sizes = scene, path, run.buffer_bytes, run.chunk_time
    refuse_too_large(*sizes)
    with ResultWriter(path, scene, run.versions, overwrite) as writer:
        _compile(run, note)
        note(foresee(*sizes))
        _say_levitation(scene, note)
        if not writer.locked:
            note(f"{path}: its disk has no locks, so a second run could write it at the same time")
        if old is None:
            discard_left(path)  # of an older run that was never continued: it must not be taken for this one
            # even a run that ends before its first sample has all its arrays and a checkpoint
            writer.append(run.empty_block(), run.checkpoint())
        else:
            writer.copy(old, int(run.work.count[SAMPLES]), run.n_stretches)
            discard_left(path)
        end = _march(run, writer, progress, note)
        writer.finish(end.summary, run.take_stretches(last=True))
    return _handed_over(load(path), end, note)


def _compile(run: Run, note: Callable[[str], object]) -> None:
    """Compile or load the kernel; a compilation is reported while it runs and afterwards."""

    def tell() -> None:
        with contextlib.suppress(Exception):  # in a thread of its own nobody would catch it
            how_often = "once on this machine" if keeps_code() else "as every start does"
            seconds = 5 * round((COMPILED + COMPILED_EACH * run.packed.model.stiffness.size / 2) / 5)
            note(f"compiling the kernel for a scene of this kind, {how_often}: some {seconds} s of processor time")

    begun, timer = time.monotonic(), threading.Timer(LOADED, tell)
    timer.daemon = True
    timer.start()
    try:
        run.compile()
    finally:
        timer.cancel()
    took = time.monotonic() - begun
    if took > LOADED:
        note(f"compiled in {took:.0f} s" + ("; later runs of this kind start at once" if keeps_code() else ""))


def _say_levitation(scene: Scene, note: Callable[[str], object]) -> None:
    """Note whether a controlled rotor is not held; a rotor without states need not wait for the analysis to be loaded."""
    if scene.rotor.states or scene.rotor.magnetic_bearings:
        from rsc.study.run.levitation import levitation_remarks

        for remark in levitation_remarks(scene):
            note(remark)


def _in_memory(run: Run, progress: bool, note: Callable[[str], object]) -> "tuple[Trajectory, _RunEnd]":
    """(Trajectory, how it ended) of a Run that keeps its samples in memory."""
    _compile(run, note)
    note(foresee(run.scene))
    _say_levitation(run.scene, note)
    sink = MemoryBlocks()
    sink.append(run.empty_block())
    end = _march(run, sink, progress, note)
    sink.finish(run.take_stretches(last=True))
    return Trajectory(run.scene, end.summary, sink), end


def _to_resume(
    scene: Scene, path: str | os.PathLike[str], bitwise: bool, overwrite: bool, note: Callable[[str], object]
) -> tuple[Run | None, Path | None]:
    """(Run that continues from the last checkpoint in `path` or in a file left by a kill, file with the samples before it).

    (None, None) where the run ended by itself: to continue it would be to end it again. (Run, None) where a kill left nothing.
    """
    source = resumable(path)
    if source is None:
        note(f"{path}: the run was killed before its first checkpoint, and starts again")
        return run_of(scene), None
    stored = ResultFile(source).scene()
    if stored.solver.method in RETIRED_METHODS:
        raise DataError(path, f"was made by {stored.solver.method}, a method that is gone: it can be read but not continued")
    refuse_other_scene(path, stored, scene)
    if source == Path(path) and read_summary(path).status != Status.INTERRUPTED:
        return None, None
    made_with = ResultFile(source).versions()
    same = made_with.split(CHANGED)[-1] == versions()
    if bitwise and not same:
        advice = "resume it there, or give --not-bitwise (Python: bitwise=False) for other bits from here on"
        raise SolverError(f"{path}: was made with {made_with}; this is {versions()}: {advice}")
    old = ResultFile(take_over(path, overwrite))
    checkpoint, earlier = old.checkpoint()
    if checkpoint is None:
        raise DataError(path, "holds no checkpoint to continue from")
    run = Run.resumed(scene, checkpoint, made_with)
    if source != Path(path) and not old.has_stretches(run.n_stretches):
        note(f"{path}: what the killed run left is damaged, and the run starts again")
        return run_of(scene), None
    if bitwise and made_with == versions():
        _refuse_other_state(path, scene, checkpoint, earlier)
    if not same:
        run.versions = f"{made_with} until {run.time:.6g} s{CHANGED}{versions()}"
    return run, old.path


def _refuse_other_state(
    path: str | os.PathLike[str], scene: Scene, checkpoint: Mapping[str, np.ndarray], earlier: Mapping[str, np.ndarray] | None
) -> None:
    """DataError unless the earlier checkpoint, or the start of the scene where there is none, leads to a checkpoint bit for bit.

    It costs one chunk of steps; a state that was damaged, or forged, is not continued.
    """
    run = run_of(scene) if earlier is None else Run.resumed(scene, earlier)
    if earlier is not None:
        next(block for block, status in run.chunks() if len(block["time"]) or status or _is_behind(run, checkpoint))
    again = run.checkpoint()
    if any(values.tobytes() != again[name].tobytes() for name, values in checkpoint.items()):
        problem = "its last checkpoint does not follow from the one before it or from the scene"
        raise DataError(path, f"{problem}: start again, or give --not-bitwise (Python: bitwise=False) to accept it")


def _is_behind(run: Run, checkpoint: Mapping[str, np.ndarray]) -> bool:
    """Whether a run has made all the steps that led to a checkpoint."""
    return bool(run.work.count[STEPS] >= checkpoint["count"][STEPS])


class _RunEnd(NamedTuple):
    """The end of a run: its Summary, interruptions (signal numbers, errors of the progress bar), and a remark or ""."""

    summary: Summary
    stops: list[int | Exception]
    remark: str


def _handed_over(result: Trajectory, end: _RunEnd, note: Callable[[str], object]) -> Trajectory:
    """The result, unless what interrupted the run ends more than it: a signal is passed on to whom it was meant for, an error to
    the caller whose function raised it. Whatever is raised carries the result."""
    try:
        if end.remark:
            note(end.remark)
        for stop in end.stops:
            if isinstance(stop, Exception):
                raise stop
            if signal.getsignal(stop) is signal.default_int_handler:
                raise KeyboardInterrupt(result.summary.advice)  # no class of its own: only so the shell sees the signal as well
            signal.raise_signal(stop)
    except BaseException as error:
        error.result = result  # type: ignore[attr-defined]
        raise
    return result


def tolerance_remark(largest: float, gap: float, rtol: float) -> str:
    """One line if the tolerance (rtol times the gap) is coarse compared with the largest displacement in m; else ""."""
    if largest == 0.0 or rtol * gap <= COARSE * largest:
        return ""
    return (
        f"the rotor moves by no more than {largest / gap:.2g} gaps, and every step may err by rtol = {rtol:.1g} of the gap, "
        f"{100.0 * rtol * gap / largest:.2g} % of that: lower solver.rtol, or contact.gap if it is larger than it should be"
    )


def _march(run: Run, sink: MemoryBlocks | ResultWriter, progress: bool, note: Callable[[str], object]) -> _RunEnd:
    """Hand every block and its checkpoint to the sink until the run ends or is interrupted."""
    largest, contacts, pace = 0.0, run.scene.contacts, _Pace(run)
    gap = min(contact.gap for contact in contacts)
    with _caught_signals() as stops, shown_progress(run.scene, progress) as show:
        for block, status in run.chunks():
            if len(block["time"]):
                sink.append(block, run.checkpoint(), run.take_stretches())
                most = max(float(np.abs(contact.of_rotor(block["rotor"])).max()) for contact in contacts)
                largest = max(largest, most)
            try:
                show(run.time)
                if text := pace.remark():
                    note(text)
            except Exception as error:  # of the caller: the samples so far are kept all the same
                stops.append(error)
            if status is None and stops:
                status = Status.INTERRUPTED
            if status is not None:
                summary = run.summary(status)
                remark = tolerance_remark(largest, gap, summary.rtol)
                return _RunEnd(summary, stops, remark if status == Status.FINISHED else "")
    raise AssertionError("a run ends with a status")


class _Pace:
    """Estimates the duration of a run after its first second and reports it once if it is long."""

    def __init__(self, run: Run) -> None:
        self._run, self._first, self._began, self._told = run, run.time, time.monotonic(), False

    def remark(self) -> str:
        """One line, or ""."""
        elapsed, advanced = time.monotonic() - self._began, self._run.time - self._first
        if self._told or elapsed < 1.0:
            return ""
        self._told = True
        left = elapsed * (self._run.scene.drive.duration - self._run.time) / advanced if advanced > 0.0 else math.inf
        if left < LONG_RUN:
            return ""
        hours = f"another {left / 3600.0:.2g} h" if left < 3e7 else "more than a year"
        return f"{advanced:.3g} s of the run took {elapsed:.1f} s: it will take {hours}; Ctrl-C keeps the results so far"


@contextlib.contextmanager
def _caught_signals() -> Iterator[list[int | Exception]]:
    """Yield a list to which a Ctrl-C, SIGTERM or SIGHUP is added; a second one acts at once, except SIGHUP of a closed terminal,
    which comes twice. What the caller ignores stays ignored."""
    caught: list[int | Exception] = []
    if threading.current_thread() is not threading.main_thread():
        yield caught
        return
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, *STOPS)}
    before = {number: handler for number, handler in before.items() if handler not in (signal.SIG_IGN, None)}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def handler(number: int, frame: object) -> None:
        caught.append(number)
        restore()
        if number in SENT_TWICE:
            signal.signal(number, signal.SIG_IGN)

    for number in before:
        signal.signal(number, handler)
    try:
        yield caught
    finally:
        restore()


@contextlib.contextmanager
def shown_progress(scene: Scene, progress: bool) -> Iterator[Callable[[float], None]]:
    """Yield a function that shows the simulated time."""
    if not progress:
        yield lambda time: None
        return
    from tqdm import tqdm

    form = "rsc: simulation {percentage:.0f} % ({elapsed}, {remaining} left): {n:.2f} of {total:.4g} s{postfix}"
    bar = tqdm(total=scene.drive.duration, bar_format=form, mininterval=0.2, leave=False)

    def show(time: float) -> None:
        bar.update(time - bar.n)
        bar.set_postfix_str(f"speed {np.interp(time, scene.drive.time, scene.drive.speed):.1f} Hz", refresh=False)

    try:
        yield show
    finally:
        with contextlib.suppress(Exception):  # as in `_march`: it is not worth a run
            bar.close()
