"""One run from a scene: in memory or to a file, with progress and interruption, from its start or resumed."""

import contextlib
import signal
import threading
from pathlib import Path

import numpy as np

from rsc.budget import foresee
from rsc.errors import DataError
from rsc.result_file import (
    ResultFile,
    ResultWriter,
    discard_left,
    read_summary,
    refuse_other_scene,
    resumable,
    take_over,
)
from rsc.run import Run
from rsc.summary import Status
from rsc.trajectory import MemoryBlocks, Trajectory, load


def simulate(scene, progress=False, path=None, resume=False, note=lambda text: None):
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
    note : callable
        Called before the run starts with one line on the memory and disk it will take.

    Returns
    -------
    Trajectory
        Also when the run did not finish: see its `status` and `summary.advice`.

    Raises
    ------
    SceneError
        The start asks for a whirl that does not exist, or a run to be resumed has another scene.
    SolverError
        The samples would not fit into memory.
    DataError
        The file cannot be written, would not fit on its disk, holds nothing to resume, or is being written by another run.
    """
    if path is None:
        note(foresee(scene))
        sink, run = MemoryBlocks(), Run(scene)
        sink.append(run.empty_block())
        return Trajectory(scene, _march(run, sink, progress), sink)
    if resume:
        return _resume(scene, path, progress, note)
    run = Run(scene)
    needs = foresee(scene, path, run.buffer_bytes, run.chunk_time)
    with ResultWriter(path, scene) as writer:
        note(needs)
        discard_left(path)  # of an older run that was never continued: it must not be taken for this one
        # even a run that ends before its first sample has all its arrays and a checkpoint
        writer.append(run.empty_block(), run.checkpoint())
        writer.finish(_march(run, writer, progress))
    return load(path)


def _resume(scene, path, progress, note):
    """Continue the run in `path`, or what a kill left of it, from its last checkpoint."""
    source = resumable(path)
    refuse_other_scene(path, ResultFile(source).scene(), scene)
    if source == Path(path) and read_summary(path).status in (Status.FINISHED, Status.OUT_OF_ASSUMPTIONS):
        return load(path)
    old = ResultFile(take_over(path))
    checkpoint = old.checkpoint()
    if checkpoint is None:
        raise DataError(path, "holds no checkpoint to continue from")
    run = Run(scene, checkpoint)
    needs = foresee(scene, path, run.buffer_bytes, run.chunk_time)
    with ResultWriter(path, scene) as writer:
        note(needs)
        writer.copy(old.path, int(checkpoint["rows"][0]))
        discard_left(path)
        writer.finish(_march(run, writer, progress))
    return load(path)


def _march(run, sink, progress):
    """Hand every block and its checkpoint to the sink until the run ends or is interrupted; returns the Summary."""
    with _interrupt_flag() as interrupted, _bar(run.scene, progress) as show:
        for block, status in run.chunks():
            if len(block["time"]):
                sink.append(block, run.checkpoint())
            show(run.time)
            if status is None and interrupted():
                status = Status.INTERRUPTED
            if status is not None:
                return run.summary(status)
    raise AssertionError("a run ends with a status")


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
