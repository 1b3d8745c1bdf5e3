"""Many runs of scenes of the same shape at once, each with the bits it has alone."""

import math
import os
import threading
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor

from rsc.errors import SceneError, SolverError
from rsc.results.budget import refuse_too_many
from rsc.results.trajectory import Trajectory
from rsc.scene.scene import Scene
from rsc.simulation.batch import LANES, Batch, is_small, kind_of
from rsc.simulation.run import Run
from rsc.study.simulate import simulate
from rsc.study.start import run_of, runs_of

LARGEST_PART = 16  # groups of as many scenes as there are lanes that a thread takes at a time, at most


def simulate_many(scenes: Iterable[Scene], *, threads: int | None = None) -> list[Trajectory]:
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

    Returns
    -------
    list of Trajectory
        In the order of the scenes, every one with the bits of `simulate(scene)`, whatever `threads` is; also those
        that did not finish: see their `status`. The arrays of a result may be parts of one piece of memory.

    Raises
    ------
    SceneError
        A scene has another number of coordinates than the first, or starts on a whirl that does not exist.
    SolverError
        No scenes, fewer threads than one, or samples that would not fit into memory.
    """
    scenes = list(scenes)
    _refuse(scenes, threads)
    refuse_too_many(scenes)
    threads = threads or _processors()
    by_parts = _compile(scenes, threads)
    team = _Team(by_parts)
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


def _compile(scenes: list[Scene], threads: int) -> bool:
    """Compile the kernel of the ensemble once, before the threads begin; returns whether it goes by parts."""
    probe = run_of(scenes[0])
    by_parts = len(scenes) >= LANES * threads and is_small(probe)
    if by_parts:
        Batch([probe]).advance(0)
    else:
        probe.compile()
    return by_parts


class _Team:
    """State shared by the threads of an ensemble: whether they take parts, whose turn it is to use Python, whether to stop."""

    def __init__(self, by_parts: bool) -> None:
        self.by_parts, self.turn, self.stop = by_parts, threading.Lock(), threading.Event()

    def run(self, scenes: list[Scene]) -> list[Trajectory]:
        """Trajectories of some scenes, in lanes those that can; fewer once the team is to stop."""
        if not self.by_parts:
            return [simulate(scene) for scene in scenes if not self.stop.is_set()]
        groups: dict[object, list[tuple[int, Run]]] = {}
        results: dict[int, Trajectory] = {}
        with self.turn:  # else all threads would prepare, then all march, then all wait for each other again
            for i, run in enumerate(runs_of(scenes)):
                groups.setdefault(kind_of(run) if is_small(run) else None, []).append((i, run))
        results.update({i: simulate(scenes[i]) for i, _ in groups.pop(None, []) if not self.stop.is_set()})
        for members in groups.values():
            places, runs = zip(*members, strict=True)
            results.update(zip(places, self._together(runs), strict=False))
        return [results[i] for i in sorted(results)]

    def _together(self, runs: Sequence[Run]) -> list[Trajectory]:
        with self.turn:
            batch = Batch(runs)
        while batch.advance():
            if self.stop.is_set():
                return []
        with self.turn:
            return batch.results()


def _refuse(scenes: list[Scene], threads: int | None) -> None:
    """Refuse scenes that form no ensemble, with the reason."""
    if not scenes:
        raise SolverError("an ensemble needs at least one scene, got none")
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise SolverError(f"threads = {threads!r}: must be a whole number from 1")
    shape = _shape(scenes[0])
    for i, scene in enumerate(scenes):
        for part, expected, actual in zip(("rotor", "stator"), shape, _shape(scene), strict=True):
            if actual != expected:
                allowed = f"a {part} of as many as in the first scene of the ensemble ({expected})"
                raise SceneError(scene.source, part, f"scene {i + 1} with {actual} coordinates", allowed)


def _shape(scene: Scene) -> tuple[int, int]:
    return scene.rotor.n_coordinates, scene.stator.n_coordinates


def _processors() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
