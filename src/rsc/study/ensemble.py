"""Many runs of scenes of the same shape at once, each with the bits it has alone."""

import math
import os
import threading
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal, overload

from rsc.arguments import TEXT, WHOLE, optional, scenes_in, takes
from rsc.errors import SceneError, SolverError
from rsc.results.budget import refuse_too_many
from rsc.results.trajectory import Trajectory
from rsc.scene.scene import Scene
from rsc.simulation.batch import LANES, Batch, is_small, kind_of
from rsc.simulation.run import Run
from rsc.study.simulate import simulate
from rsc.study.start import run_of, runs_or_errors

LARGEST_PART = 16  # groups of as many scenes as there are lanes that a thread takes at a time, at most


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
        Threads that run at a time; by default the processors this process may use. Up to four coordinates, and with
        eight scenes a thread or more, each thread takes eight at a time in SIMD lanes (four for eight without AVX-512;
        compiled when first used, up to 30 s for a method and for every combination of contact diameter, eccentric ring and
        full matrices among the scenes).
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
    by_parts = _compile(scenes, threads, keep)
    team = _Team(by_parts, keep)
    with ThreadPoolExecutor(threads) as pool:
        try:
            parts = pool.map(team.run, parts_of(scenes, threads, by_parts))
            return [result for part in parts for result in part]
        except BaseException:
            team.stop.set()
            pool.shutdown(cancel_futures=True)
            raise


def parts_of(scenes: list[Scene], threads: int, by_parts: bool = True) -> list[list[Scene]]:
    """The scenes in order, each for one thread at a time, or in parts of a multiple of the lanes, so that none of them runs dry.
    For several threads the first parts are small, as one thread at a time prepares, and so are the last, so that none waits long
    for another's."""
    if not by_parts:
        return [[scene] for scene in scenes]
    parts, begin, groups = [], 0, math.ceil(len(scenes) / LANES)
    while groups > 0:
        share = groups if threads == 1 else min(begin // LANES + 1, max(1, groups // (2 * threads)))
        n_groups = min(share, LARGEST_PART)
        parts.append(scenes[begin : begin + n_groups * LANES])
        begin, groups = begin + n_groups * LANES, groups - n_groups
    return parts


def _compile(scenes: list[Scene], threads: int, keep: bool) -> bool:
    """Compile the kernel of the ensemble once, before the threads begin; returns whether it goes by parts."""
    for scene in scenes:
        try:
            probe = run_of(scene)
        except SceneError:
            if not keep:
                raise
            continue
        by_parts = len(scenes) >= LANES * threads and is_small(probe)
        if by_parts:
            Batch([probe]).advance(0)
        else:
            probe.compile()
        return by_parts
    return False


class _Team:
    """State shared by the threads of an ensemble: whether they take parts, whether an impossible scene is kept, whose turn it is
    to use Python, whether to stop."""

    def __init__(self, by_parts: bool, keep: bool) -> None:
        self.by_parts, self.keep, self.turn, self.stop = by_parts, keep, threading.Lock(), threading.Event()

    def run(self, scenes: list[Scene]) -> list[Trajectory | NoRun]:
        """Results of some scenes, in lanes those that can; fewer once the team is to stop."""
        if not self.by_parts:
            return [self._alone(scene) for scene in scenes if not self.stop.is_set()]
        groups: dict[object, list[tuple[int, Run]]] = {}
        results: dict[int, Trajectory | NoRun] = {}
        with self.turn:  # else all threads would prepare, then all march, then all wait for each other again
            for i, run in enumerate(runs_or_errors(scenes)):
                if isinstance(run, SceneError):
                    results[i] = self._impossible(scenes[i], run)
                else:
                    groups.setdefault(kind_of(run) if is_small(run) else None, []).append((i, run))
        results.update({i: self._alone(scenes[i]) for i, _ in groups.pop(None, []) if not self.stop.is_set()})
        for members in groups.values():
            places, runs = zip(*members, strict=True)
            results.update(zip(places, self._together(runs), strict=False))
        return [results[i] for i in sorted(results)]

    def _alone(self, scene: Scene) -> Trajectory | NoRun:
        try:
            return simulate(scene)
        except SceneError as error:
            return self._impossible(scene, error)

    def _impossible(self, scene: Scene, error: SceneError) -> NoRun:
        if not self.keep:
            raise error
        return NoRun(scene, str(error))

    def _together(self, runs: Sequence[Run]) -> list[Trajectory]:
        with self.turn:
            batch = Batch(runs)
        while batch.advance():
            if self.stop.is_set():
                return []
        with self.turn:
            return batch.results()


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


def processors() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
