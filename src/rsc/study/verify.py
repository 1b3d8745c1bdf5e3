"""Check of a result against its scene: a stated slice is run again from its checkpoint and compared bit for bit."""

import hashlib
import os
from dataclasses import dataclass

import numpy as np

from rsc.arguments import PATH, WHOLE, takes
from rsc.errors import DataError
from rsc.results.result_file import ResultFile, read_summary
from rsc.simulation.run import Run


@dataclass(frozen=True)
class Verification:
    """A slice of a result that was run again, and whether it has the same bits.

    first, last : rows of the slice; same : every array equal in every bit; differing : names of arrays that are not
    scene_hash : SHA-256 of the resolved scene; versions : of the result
    """

    first: int
    last: int
    same: bool
    differing: tuple[str, ...]
    scene_hash: str
    versions: str


@takes(path=PATH, index=WHOLE)
def verify(path: str | os.PathLike[str], index: int = -1) -> Verification:
    """Run one block of a result again from the checkpoint before it and compare.

    Parameters
    ----------
    path : str or Path
    index : int
        Which block, counted from the start, or from the end when negative.

    Raises
    ------
    DataError
        The file is damaged or holds no such block (a result saved from memory has no checkpoints).
    """
    file = ResultFile(path)
    summary, scene = read_summary(path), file.scene()
    marks = file.checkpoint_rows()
    blocks = len(marks) - 1
    if not -blocks <= index < blocks:
        raise DataError(path, f"holds {max(blocks, 0)} blocks with checkpoints, none of index {index}")
    number = index % blocks
    first, last = int(marks[number]), int(marks[number + 1])
    run = Run.resumed(scene, file.checkpoint_at(number))
    rerun = next(block for block, _ in run.chunks() if len(block["time"]))
    stored = file.rows(first, last)
    differing = tuple(name for name, values in stored.items() if not np.array_equal(values, rerun[name][: last - first]))
    text = scene.to_toml().encode()
    return Verification(first, last, not differing, differing, hashlib.sha256(text).hexdigest(), summary.versions)
