"""Check of a result against its scene: the run is made again, whole or a block of it, and compared bit for bit."""

import hashlib
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields

import numpy as np

from rsc.arguments import FLAG, PATH, WHOLE, optional, takes
from rsc.errors import DataError
from rsc.kernel.model import STEPS
from rsc.results.result_file import ResultFile
from rsc.results.summary import Status, Summary
from rsc.scene.scene import Scene
from rsc.scene.tables.sections import RETIRED_METHODS
from rsc.simulation.run import Run, versions
from rsc.study.run.simulate import shown_progress
from rsc.study.run.start import run_of


@dataclass(frozen=True)
class Verification:
    """What of a result was made again, and whether it has the same bits.

    first, last : rows that were run again, from first to last (exclusive); no more than up to the first difference
    whole : from the start of the scene to the end, with checkpoints, counters and energies; else one block from its checkpoint
    differing : names of the arrays, of "checkpoints" and of parts of the summary that are not the same in every bit
    scene_hash : SHA-256 of the resolved scene; versions : of the result
    """

    first: int
    last: int
    whole: bool
    differing: tuple[str, ...]
    scene_hash: str
    versions: str

    @property
    def same(self) -> bool:
        """Whether all that was made again is the same in every bit."""
        return not self.differing


@takes(path=PATH, index=optional(WHOLE), progress=FLAG)
def verify(path: str | os.PathLike[str], index: int | None = None, progress: bool = False) -> Verification:
    """Make the run of a result again and compare; this takes as long as the run did, and stops at the first difference.

    Parameters
    ----------
    path : str or Path
    index : int, optional
        Only this block of samples, from the checkpoint before it, which is taken as it is: counted from the start, or from the
        end when negative.
    progress : bool
        Show simulated time, speed and remaining time on standard error.

    Raises
    ------
    DataError
        The file is damaged, was made by a method that is gone, or holds no such block (a result saved from memory has none).
    SolverError
        A checkpoint is no state of a run of the scene.
    """
    file = ResultFile(path)
    with file.kept_open():
        scene, summary = file.scene(), file.summary()
    if scene.solver.method in RETIRED_METHODS:
        raise DataError(path, f"was made by {scene.solver.method}, a method that is gone: it can be read but not run again")
    if index is None:
        with file.kept_open():
            last, differing = _whole(file, scene, summary, progress)
        first = 0
    else:
        first, last, differing = _block(file, scene, index)
    text = scene.to_toml().encode()
    return Verification(first, last, index is None, differing, hashlib.sha256(text).hexdigest(), summary.versions)


def _block(file: ResultFile, scene: Scene, index: int) -> tuple[int, int, tuple[str, ...]]:
    """(first row, end, names that differ) of one block, run again from the checkpoint before it."""
    marks = file.checkpoint_rows()
    blocks = len(marks) - 1
    if not -blocks <= index < blocks:
        raise DataError(file.path, f"holds {max(blocks, 0)} blocks with checkpoints, none of index {index}")
    number = index % blocks
    first, last = int(marks[number]), int(marks[number + 1])
    run = Run.resumed(scene, file.checkpoint_at(number))
    again = next((block for block, _ in run.chunks() if len(block["time"])), run.empty_block())
    return first, last, _differing(file.rows(first, last), {name: values[: last - first] for name, values in again.items()})


def _whole(file: ResultFile, scene: Scene, summary: Summary, progress: bool) -> tuple[int, tuple[str, ...]]:
    """(end of the repeated rows, names that differ); makes at most as many steps as the summary states."""
    run, row, ended = run_of(scene), 0, Status.INTERRUPTED
    numbers = {int(rows): i for i, rows in enumerate(file.checkpoint_rows())}
    if numbers and _differing(file.checkpoint_at(numbers.pop(0)), run.checkpoint()):
        return 0, ("checkpoints",)
    with shown_progress(scene, progress) as show:
        for block, status in run.chunks():
            first, row, ended = row, row + len(block["time"]), status or ended
            differing = _differing(file.rows(first, row), block)
            if not differing and row in numbers:
                differing = ("checkpoints",) if _differing(file.checkpoint_at(numbers.pop(row)), run.checkpoint()) else ()
            if differing:
                return row, differing
            show(run.time)
            if run.time >= summary.end_time or summary.steps <= run.work.count[STEPS]:
                break
    if row != file.n_time():
        return row, ("time",)
    if numbers and summary.versions == versions():  # another version may have them at other rows
        return row, ("checkpoints",)
    return row, tuple(_differing_summary(summary, run.summary(ended)))


def _differing(stored: Mapping[str, np.ndarray], again: Mapping[str, np.ndarray]) -> tuple[str, ...]:
    """Names of the arrays that are not bit-identical."""
    return tuple(name for name, values in stored.items() if name not in again or not _same(values, again[name]))


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two arrays have the same shape and the same bits, those of numbers that are not finite as well."""
    return np.shape(one) == np.shape(other) and np.asarray(one).tobytes() == np.asarray(other).tobytes()


def _differing_summary(stored: Summary, again: Summary) -> Iterator[str]:
    """Names of the fields that differ in two summaries; texts are compared only for equal versions."""
    for field in fields(Summary):
        one, other = getattr(stored, field.name), getattr(again, field.name)
        if field.name == "ledger":
            same = _same(*(np.array([getattr(ledger, part.name) for part in fields(ledger)]) for ledger in (one, other)))
        elif isinstance(one, float):
            same = _same(np.array(one), np.array(other))
        else:
            same = one == other or field.name == "versions" or (field.name == "advice" and stored.versions != versions())
        if not same:
            yield field.name
