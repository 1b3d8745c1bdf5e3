"""The three problems every measurement uses, as plain matrices in physical coordinates (../docs/kernel.md, "Yardstick")."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from rsc import load_scene
from rsc.assemble import assemble
from rsc.start import initial_state

DATA = Path(__file__).parents[1] / "data" / "reference"
# Laval rotor in backward whirl, 8,300 damper switches in 30 s; the same bouncing, 306 onsets in 10 s; ten disks and three masses
FILES = {"P1": "laval.toml", "P1c": "bouncing.toml", "P2": "chain_10.toml"}
RATE = 2000.0  # output grid, 1/s


class Matrices(NamedTuple):
    """Equations of motion divided by the (diagonal) masses; state of the yardstick: y, z of rotor, y, z of stator, then rates."""

    stiffness_r: np.ndarray  # (N, N) M^-1 K
    damping_r: np.ndarray
    stiffness_s: np.ndarray  # (M, M)
    damping_s: np.ndarray
    unbalance: np.ndarray  # (N,) eccentricity, m, real
    i_r: int  # contacting coordinates
    i_s: int
    per_mass_r: float  # 1/kg at the contacting coordinate
    per_mass_s: float
    gap: float
    friction: float
    k_c: float
    b_c: float
    omega: float  # rad/s at t = 0
    omega_dot: float  # rad/s^2


class Problem(NamedTuple):
    """A scene with its matrices, initial state (8 numbers per 1+1 coordinates) and duration."""

    name: str
    scene: object
    matrices: Matrices
    start: np.ndarray
    duration: float


def problem(name):
    """One of FILES, as `Problem`."""
    scene = load_scene(DATA / FILES[name])
    system = assemble(scene)
    start = initial_state(scene, system)
    m_r, m_s = np.diag(system.mass_r), np.diag(system.mass_s)
    i_r, i_s = int(np.argmax(system.contact_r)), int(np.argmax(system.contact_s))
    speed, time = system.schedule_speed, system.schedule_time
    matrices = Matrices(
        np.ascontiguousarray(system.stiffness_r / m_r[:, None]),
        np.ascontiguousarray(system.damping_r / m_r[:, None]),
        np.ascontiguousarray(system.stiffness_s / m_s[:, None]),
        np.ascontiguousarray(system.damping_s / m_s[:, None]),
        np.ascontiguousarray(system.unbalance.real / m_r),
        i_r,
        i_s,
        1.0 / m_r[i_r],
        1.0 / m_s[i_s],
        system.gap,
        system.friction,
        system.contact_stiffness,
        system.contact_damping,
        float(speed[0]),
        float((speed[1] - speed[0]) / (time[1] - time[0])),
    )
    parts = (start.rotor, start.stator, start.rotor_velocity, start.stator_velocity)
    state = np.concatenate([np.concatenate([part.real, part.imag]) for part in parts])
    return Problem(name, scene, matrices, np.ascontiguousarray(state), float(time[1] - time[0]))


def displacements(rows, problem):
    """Complex displacements (samples, N + M) from rows of the yardstick's state."""
    n, m = problem.matrices.stiffness_r.shape[0], problem.matrices.stiffness_s.shape[0]
    rotor = rows[:, :n] + 1j * rows[:, n : 2 * n]
    stator = rows[:, 2 * n : 2 * n + m] + 1j * rows[:, 2 * n + m : 2 * (n + m)]
    return np.hstack([rotor, stator])
