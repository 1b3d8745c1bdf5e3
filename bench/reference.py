"""Independent references, every switch of the contact located: extrapolation in 80-bit numbers (c/reference.c), and DOP853 in
doubles with fixed substeps from one output time to the next.

Nothing is shared with rsc's kernel but the scene's matrices: physical coordinates (in 80 bits divided by the masses, of which the
other programs' matrices are rounded), phase from t by the library's sine and cosine,
another method, another way to end steps on switches (bisection on real steps), no interpolation. Its own error is the
difference between two numbers of substeps.
"""

import ctypes
import hashlib
import math
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
from scipy.integrate._ivp import dop853_coefficients as dop

import c_code
import driven
from naive_kernel import right_hand_side, right_hand_side_1_1, right_hand_side_of
from problems import RATE, displacements

N_STAGES = 12
A = np.ascontiguousarray(dop.A[:N_STAGES, :N_STAGES])
B = np.ascontiguousarray(dop.B)
C = np.ascontiguousarray(dop.C[:N_STAGES])
OPEN, CLOSING, OPENING, CLIPPED = range(4)


def _reference(f):  # noqa: C901 - a family of small functions compiled together with f
    @numba.njit(error_model="numpy")
    def signs(m, y):
        """(delta, delta_dot, force) at a state."""
        n, k = m.stiffness_r.shape[0], m.stiffness_s.shape[0]
        half, r, q = 2 * (n + k), m.i_r, 2 * n + m.i_s
        d_y, d_z = y[r] - y[q], y[n + r] - y[q + k]
        v_y, v_z = y[half + r] - y[half + q], y[half + n + r] - y[half + q + k]
        distance = math.sqrt(d_y * d_y + d_z * d_z)
        delta = m.gap - distance
        delta_dot = -(d_y * v_y + d_z * v_z) / distance if distance > 0.0 else 0.0
        return delta, delta_dot, -m.k_c * delta - m.b_c * delta_dot

    @numba.njit(error_model="numpy")
    def mode_of(m, y):
        delta, delta_dot, force = signs(m, y)
        if delta >= 0.0:
            return OPEN
        if delta_dot <= 0.0:
            return CLOSING
        return OPENING if force >= 0.0 else CLIPPED

    @numba.njit(error_model="numpy")
    def smooth(m, mode, t, y, out):
        """Right-hand side continued analytically beyond the borders of a mode: the kinked one plus the force that it clips."""
        f(m, t, y, out)
        n, k = m.stiffness_r.shape[0], m.stiffness_s.shape[0]
        half, r, q = 2 * (n + k), m.i_r, 2 * n + m.i_s
        delta, delta_dot, _ = signs(m, y)
        kinked = max(0.0, -m.k_c * delta - m.b_c * max(delta_dot, 0.0)) if delta < 0.0 else 0.0
        force = -m.k_c * delta - (m.b_c * delta_dot if mode == OPENING else 0.0)
        force = (force if mode in (CLOSING, OPENING) else 0.0) - kinked
        d_y, d_z = y[r] - y[q], y[n + r] - y[q + k]
        distance = math.sqrt(d_y * d_y + d_z * d_z)
        if force == 0.0 or distance == 0.0:
            return
        f_y = force * (d_y - m.friction * d_z) / distance
        f_z = force * (d_z + m.friction * d_y) / distance
        out[half + r] -= f_y * m.per_mass_r
        out[half + n + r] -= f_z * m.per_mass_r
        out[half + q] += f_y * m.per_mass_s
        out[half + q + k] += f_z * m.per_mass_s

    @numba.njit(error_model="numpy")
    def step(m, mode, t, y, h, k, out):
        for s in range(N_STAGES):
            for i in range(y.shape[0]):
                total = 0.0
                for j in range(s):
                    total += A[s, j] * k[j, i]
                out[i] = y[i] + h * total
            smooth(m, mode, t + C[s] * h, out, k[s])
        for i in range(y.shape[0]):
            total = 0.0
            for j in range(N_STAGES):
                total += B[j] * k[j, i]
            out[i] = y[i] + h * total

    @numba.njit(error_model="numpy")
    def run(m, start, duration, rate, substeps, out):
        """Fill out with the states on the grid; returns the number of switches."""
        y, y_new = start.copy(), start.copy()
        k = np.empty((N_STAGES, start.shape[0]))
        out[0] = y
        mode, switches = mode_of(m, y), 0
        for row in range(1, out.shape[0]):
            for sub in range(substeps):
                t = (row - 1) / rate + sub / (rate * substeps)
                left = 1.0 / (rate * substeps)
                while left > 0.0:
                    step(m, mode, t, y, left, k, y_new)
                    h = left
                    if mode_of(m, y_new) != mode:
                        near, far = 0.0, left
                        # 60 halvings: the switch to the last bit, and the step to its far side
                        for _ in range(60):
                            middle = 0.5 * (near + far)
                            step(m, mode, t, y, middle, k, y_new)
                            if mode_of(m, y_new) != mode:
                                far = middle
                            else:
                                near = middle
                        h = far
                        step(m, mode, t, y, h, k, y_new)
                        mode = mode_of(m, y_new)
                        switches += 1
                    y[:] = y_new
                    t += h
                    left -= h
            out[row] = y
        return switches

    return run


RUNS = {f: _reference(f) for f in (right_hand_side_1_1, right_hand_side)}


def reference_run(problem, rate, substeps):
    """(states on the output grid, switches); problems without gyroscopics only."""
    rows = round(problem.duration * rate) + 1
    out = np.zeros((rows, problem.start.size))
    run = RUNS[right_hand_side_of(problem.matrices)]
    return out, run(problem.matrices, problem.start, problem.duration, rate, substeps, out)


def gbs_run(problem, rate, substeps, columns):
    """(states on the output grid, switches) by c/reference.c: extrapolation in 80-bit numbers, switches located on real steps.

    Raises
    ------
    c_code.NoCompiler
        There is no C compiler here.
    """
    m, s = problem.matrices, problem.system
    run = c_code.library("reference").reference
    run.restype = ctypes.c_long
    out = np.zeros((round(problem.duration * rate) + 1, problem.start.size))
    numbers = np.array([s.contact.gap, s.law.friction, s.law.stiffness, s.law.damping, *s.schedule_speed, s.schedule_time[1]])
    index = np.array([m.i_r, m.i_s], dtype=np.intc)
    masses = [np.diag(s.rotor.mass).copy(), np.diag(s.stator.mass).copy()]
    rotor = (masses[0], s.rotor.stiffness, s.rotor.damping, s.rotor.gyroscopic)
    stator = (masses[1], s.stator.stiffness, s.stator.damping)
    imposed = (s.rotor.unbalance.real.copy(), s.rotor.unbalance_euler.real.copy())
    switches = run(
        m.stiffness_r.shape[0],
        m.stiffness_s.shape[0],
        *(c_code.pointer(part) for part in (*rotor, *stator, *imposed, index, numbers, problem.start)),
        ctypes.c_double(rate),
        substeps,
        columns,
        ctypes.c_long(out.shape[0]),
        c_code.pointer(out),
    )
    assert switches >= 0, "the problem is too large for c/reference.c"
    return out, switches


# problem: (columns, steps between two output times of the reference, and of the coarser run that its error is told from); the
# steps are short enough that no switch hides between two looks at the contact
RESOLUTION = {"P1": (8, 6, 4), "P1c": (8, 8, 6), "P2": (8, 6, 4), "P3": (6, 6, 4), "gyro": (8, 8, 6), "ROSS": (6, 6, 4)}
GBS = c_code.FOLDER / "reference.c"
DRIVEN = 12, 8  # steps between two output times of the pump's


class Solution(NamedTuple):
    """A reference and how good it is."""

    motion: np.ndarray  # (samples, N + M) complex, m
    error: float  # gaps
    switches: int
    how: str


def solution(problem):
    """The reference of a problem; without a C compiler the double-precision one, whose own error then limits what can be drawn.

    Its error: the largest difference to a run with longer steps, divided by (ratio of the steps)^(half the order), of DOP853 in
    `driven` by (ratio)^8. Kept on disk by the content of the problem and of the source that made it, as the compiled code is.
    """
    gap = problem.matrices.gap
    if isinstance(problem, driven.Driven):
        many, fewer = DRIVEN
        (fine, switches), (coarse, _) = (_kept(problem, driven.__file__, driven.reference_run, n) for n in DRIVEN)
        gain, how = (many / fewer) ** 8, "DOP853 in doubles, switches and corners of both tables located"
    else:
        columns, many, fewer = RESOLUTION[problem.name]
        gain = (many / fewer) ** columns
        how = f"extrapolation (GBS) of order {2 * columns} in 80-bit numbers, switches located"
        try:
            (fine, switches), (coarse, _) = (_kept(problem, GBS, gbs_run, RATE, n, columns) for n in (many, fewer))
        except c_code.NoCompiler:
            (coarse, _), (fine, switches) = (reference_run(problem, RATE, n) for n in (12, 16))
            gain, how = 1.0, "DOP853 in doubles, switches located (no C compiler here)"
    motion = displacements(fine, problem)
    error = abs(motion - displacements(coarse, problem)).max() / (gap * gain)
    return Solution(motion, float(error), switches, how)


def _kept(problem, source, run, *settings):
    """(states on the output grid, switches) that `run` of a source makes of a problem, computed once."""
    content = hashlib.sha256(Path(source).read_bytes())
    for part in (*problem.matrices, problem.start, problem.duration, *settings):
        content.update(np.asarray(part, dtype=float).tobytes())
    file = c_code.cache_folder() / f"reference_{content.hexdigest()[:20]}.npz"
    if file.exists():
        with np.load(file, allow_pickle=False) as kept:
            return kept["rows"], int(kept["switches"])
    rows, switches = run(problem, *settings)
    np.savez(file, rows=rows, switches=switches)
    return rows, switches
