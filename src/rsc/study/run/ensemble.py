"""Many runs of scenes of the same shape at once, each with the bits it has alone."""

import math
import threading
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal, overload

from rsc.arguments import TEXT, WHOLE, optional, scenes_in, takes
from rsc.errors import SceneError, SolverError
from rsc.operating_system import processors
from rsc.results.budget import refuse_too_many
from rsc.results.trajectory import MemoryBlocks, Trajectory
from rsc.scene.scene import Scene
from rsc.simulation.run import Run
from rsc.study.run.start import run_of, runs_or_errors

LARGEST_PART = 32  # scenes that a thread takes at a time, at most: what comes before their steps is done for all at once


@dataclass(frozen=True)
class NoRun:
    """The place of an impossible scene among the results of many: scene, and the reason, one line as in its SceneError."""

    scene: Scene
    reason: str
    status: str = "impossible"


@overload
def simulate_many(
    scenes: Iterable[Scene], *, threads: int | None = None, on_error: Literal["raise"] = "raise"
) -> list[Trajectory]: ...


@overload
def simulate_many(
    scenes: Iterable[Scene], *, threads: int | None = None, on_error: Literal["keep"]
) -> list[Trajectory | NoRun]: ...


@takes(threads=optional(WHOLE), on_error=TEXT)
def simulate_many(
    scenes: Iterable[Scene], *, threads: int | None = None, on_error: str = "raise"
) -> list[Trajectory] | list[Trajectory | NoRun]:
    """Integrate many scenes of the same shape, on several processors.

    Parameters
    ----------
    scenes : sequence of Scene
        All with the same numbers of rotor and stator coordinates; everything else may differ.
    threads : int, optional
        Threads that run at a time; by default the processors this process may use.
    on_error : "raise" or "keep"
        What becomes of a scene that asks to start on a whirl that does not exist, or has another number of coordinates than the
        first: it is raised, or keeps its place in the results as a NoRun with the reason.

    Returns
    -------
    list of Trajectory (with on_error="keep" also of NoRun: `scene`, `status` "impossible", `reason`)
        In the order of the scenes, every one with the bits of `simulate(scene)`, whatever `threads` is; also those
        that did not finish: see their `status`. The arrays of a result may be parts of one piece of memory.

    Raises
    ------
    SceneError
        A scene has another number of coordinates than the first, or starts on a whirl that does not exist (on_error="raise").
    SolverError
        No scenes, fewer threads than one, another word for on_error, or samples that would not fit into memory.

    Examples
    --------
    >>> scene = rsc.load_scene("laval.toml")
    >>> results = rsc.simulate_many([scene, scene.with_values({"contact.gap": "1.2 mm"})])
    >>> print(*(result.status for result in results))
    finished finished
    """
    scenes = scenes_in("simulate_many", scenes)
    _refuse(scenes, threads, on_error)
    misfits = {i: error for i, scene in enumerate(scenes) if (error := _misfit(scene, i, scenes[0])) is not None}
    if misfits and on_error == "raise":
        raise next(iter(misfits.values()))
    fitting = [scene for i, scene in enumerate(scenes) if i not in misfits]
    refuse_too_many(fitting)
    results = iter(_on_threads(fitting, threads or processors(), on_error == "keep"))
    return [NoRun(scene, str(misfits[i])) if i in misfits else next(results) for i, scene in enumerate(scenes)]


def _on_threads(scenes: list[Scene], threads: int, keep: bool) -> list[Trajectory | NoRun]:
    """Results of scenes of one shape; an impossible one is kept as NoRun or raises."""
    _compile(scenes, keep)
    team = _Team(keep)
    with ThreadPoolExecutor(threads) as pool:
        try:
            parts = pool.map(team.run, parts_of(scenes, threads))
            return [result for part in parts for result in part]
        except BaseException:
            team.stop.set()
            pool.shutdown(cancel_futures=True)
            raise


def parts_of(scenes: list[Scene], threads: int) -> list[list[Scene]]:
    """The scenes in order, in parts that one thread takes at a time. For several threads they become smaller towards the end, so
    that none waits long for another's."""
    parts, left = [], scenes
    while left:
        size = min(LARGEST_PART, len(left) if threads == 1 else math.ceil(len(left) / (2 * threads)))
        parts.append(left[:size])
        left = left[size:]
    return parts


def _compile(scenes: list[Scene], keep: bool) -> None:
    """Compile the kernel of the first scene that can run once, before the threads begin."""
    for scene in scenes:
        try:
            run_of(scene).compile()
        except SceneError:
            if not keep:
                raise
        else:
            return


class _Team:
    """State shared by the threads of an ensemble: whether an impossible scene is kept, whose turn it is to prepare runs, whether
    to stop."""

    def __init__(self, keep: bool) -> None:
        self.keep, self.turn, self.stop = keep, threading.Lock(), threading.Event()

    def run(self, scenes: list[Scene]) -> list[Trajectory | NoRun]:
        """Results of some scenes, prepared in one stack; fewer once the team is to stop."""
        with self.turn:  # else all threads would prepare, then all march, then all wait for each other again
            runs = runs_or_errors(scenes)
        results = (self._result(*pair) for pair in zip(scenes, runs, strict=True))
        return [result for result in results if result is not None]

    def _result(self, scene: Scene, run: Run | SceneError) -> Trajectory | NoRun | None:
        """The run marched to its end; None once the team is to stop."""
        if isinstance(run, SceneError):
            if not self.keep:
                raise run
            return NoRun(scene, str(run))
        sink = MemoryBlocks()
        for block, status in run.chunks():
            sink.append(block)
            if status is not None:
                sink.finish(run.take_stretches(last=True))
                return Trajectory(scene, run.summary(status), sink)
            if self.stop.is_set():
                break
        return None


def _refuse(scenes: list[Scene], threads: int | None, on_error: str) -> None:
    """Refuse arguments that cannot be meant, with the reason."""
    if not scenes:
        raise SolverError("an ensemble needs at least one scene, got none")
    if threads is not None and threads < 1:
        raise SolverError(f"threads = {threads!r}: must be a whole number from 1")
    if on_error not in ("raise", "keep"):
        raise SolverError(f"on_error = {on_error!r}: must be \"raise\" or \"keep\"")


def _misfit(scene: Scene, i: int, first: Scene) -> SceneError | None:
    """The error of scene number i if it has other numbers of coordinates than the first."""
    for part, expected, actual in zip(("rotor", "stator"), _shape(first), _shape(scene), strict=True):
        if actual != expected:
            allowed = f"a {part} of as many as in the first scene of the ensemble ({expected})"
            return SceneError(scene.source, part, f"scene {i + 1} with {actual} coordinates", allowed)
    return None


def _shape(scene: Scene) -> tuple[int, int]:
    return scene.rotor.n_coordinates, scene.stator.n_coordinates
