"""Runs of one shape in the lanes of the registers: their data into records, through the kernel, and back."""

import numpy as np

from rsc.kernel import model as kernel
from rsc.kernel.lanes import layout as rows
from rsc.kernel.lanes.march import march_cases
from rsc.kernel.simd.registers import LARGEST
from rsc.results.trajectory import MemoryBlocks, Trajectory
from rsc.simulation.lines import on_lines
from rsc.simulation.run import STATUS

LANES = LARGEST  # cases in a register
# numbers 2n of coordinates up to which lanes pay: a single run of more fills the registers by itself
WIDEST = 8
# attempts of all lanes per call of the kernel, 0.1 to 0.5 s, which an interruption may take: a thread that comes back may wait
# 5 ms for the interpreter's lock
CHUNK_STEPS = 300_000
_REALS, _COUNTS = slice(rows.REAL, rows.COUNT), slice(rows.COUNT, rows.MOTION)


def is_small(run):
    """Whether a run takes so little time that what is made for it is better made for many at once, in lanes, which have no skew
    and anisotropic springs."""
    return run.work.x.size <= WIDEST and not len(run.packed.model.stiffness_columns)


def kind_of(run):
    """What all runs in lanes must share: flags as the kernel tells them of a single run, and the method."""
    m = run.packed.model
    has_euler = bool((m.euler[::2] ** 2 + m.euler[1::2] ** 2).max() != 0.0)
    matrices = len(m.damping_columns) > 0, len(m.gyroscopic_columns) > 0
    return len(m.ring) > 0, has_euler, matrices if any(matrices) else (), run.packed.method


class Batch:
    """Runs of one kind that have not begun, in lanes.

    Parameters
    ----------
    runs : list of Run
        All of the same number of coordinates and the same `kind_of`, every one `is_small`.
    """

    def __init__(self, runs):
        models = [run.packed.model for run in runs]
        self.runs, width = runs, runs[0].work.x.size
        self.records = np.array([_record(run) for run in runs])
        samples = np.array([int(run.scene.drive.duration * run.scene.output.rate) + 3 for run in runs])
        corners = np.array([m.corner_time.size for m in models])
        in_row = np.array([run.row_size for run in runs])
        self.out = [np.empty(count * (size + 3)) for count, size in zip(samples, in_row, strict=True)]
        self.numbers = self.records[:, rows.N_VECTORS * width : rows.record_length(width)]
        self.numbers[:, rows.MOTION] = [out.ctypes.data for out in self.out]
        self.numbers[:, rows.FORCES] = self.numbers[:, rows.MOTION] + rows.BYTES * in_row * samples
        self.numbers[:, rows.ROWS], self.numbers[:, rows.IN_ROW] = samples, in_row
        self.numbers[:, rows.N_CORNERS], self.numbers[:, rows.FIRST_CORNER] = corners, np.cumsum(corners) - corners
        self.schedule = tuple(np.concatenate([getattr(m, name) for m in models]) for name in ("corner_time", "corner_speed"))
        self.codes = np.zeros(len(runs), dtype=np.int64)
        has_ring, has_euler, matrices, method = kind_of(runs[0])
        layouts = _layout(rows.layout_rows(width)), _layout(rows.attempt_rows(width, len(method)))
        self.state = (*layouts, np.zeros(LANES + 1, dtype=np.int64), self.codes)
        parts = has_ring, has_euler, any(m.radius > 0.0 for m in models)
        self.flags = *[(0.0,) * part for part in parts], matrices
        self.sizes = (0.0,) * width, (0.0,) * (2 * runs[0].system.n_rotor), (0.0,) * LANES, method

    def advance(self, attempts=CHUNK_STEPS):
        """Attempt some steps in all lanes; returns how many runs have not ended."""
        return march_cases(self.records, self.schedule, self.state, self.flags, self.sizes, attempts)

    def results(self):
        """Trajectories of the runs, which have all ended."""
        return [self._trajectory(i) for i in range(len(self.runs))]

    def _trajectory(self, i):
        run, record, numbers = self.runs[i], self.records[i], self.numbers[i]
        work = run.work
        width = work.x.size
        for k, name in enumerate(kernel.WORK_VECTORS, start=rows.X):
            getattr(work, name)[:] = record[k * width : (k + 1) * width]
        work.real[:], work.count[:] = numbers[_REALS], numbers[_COUNTS]
        work.count[kernel.RHS_CALLS] += work.count[kernel.SWITCHES]  # as tally.store_tally counts them
        made, n_rows, in_row = work.count[kernel.SAMPLES], int(numbers[rows.ROWS]), run.row_size
        motion, forces = self.out[i][: made * in_row].reshape(made, in_row), self.out[i][n_rows * in_row :].reshape(3, n_rows)
        sink = MemoryBlocks()
        sink.append(run.seen_block(motion, forces[:, :made], 0))
        return Trajectory(run.scene, run.summary(STATUS[self.codes[i]]), sink)


def _record(run):
    """The numbers of a run that has not begun, in the rows of kernel/lanes/layout.py."""
    m, work = run.packed.model, run.work
    width = work.x.size
    record = np.zeros(rows.record_length(width) + rows.matrix_rows(width))
    vectors, tail = record[: rows.N_VECTORS * width].reshape(-1, width), record[rows.N_VECTORS * width :]
    numbers, matrices = tail[: rows.RECORD_NUMBERS], tail[rows.RECORD_NUMBERS :].reshape(2, -1, width)
    vectors[: rows.X] = [getattr(m, name) for name in kernel.MODEL_VECTORS]
    vectors[rows.X : rows.A] = [getattr(work, name) for name in kernel.WORK_VECTORS]
    numbers[: rows.REAL] = kernel.scalars_of(m, m.ring or (0.0, 0.0))
    numbers[_REALS], numbers[_COUNTS] = work.real, work.count
    for place, columns in zip(matrices, (m.damping_columns, m.gyroscopic_columns), strict=True):
        if len(columns):
            place[...] = columns
    return record


def _layout(n_rows):
    """Layout of the lanes, every row a cache line."""
    return on_lines(np.zeros((n_rows, LANES)))
