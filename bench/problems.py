"""The problems every measurement uses, each once: scene, matrices in physical coordinates, start and span.

| name | what it is |
|---|---|
| P1 | Laval rotor in steady backward whirl, run-up 20 to 100 Hz in 30 s; 8,300 damper switches |
| P1c | the same rotor bouncing, 306 onsets in 10 s, regular |
| P2 | chain of ten disks and three stator masses in whirl, 10 s |
| P3 | a thousand variants of P1, 2 s each (`variants`) |
| gyro | the paper's gyroscopic run-up (reconstructed scene), 10 s through the synchronous resonance on whirl A |
| ROSS | a two-disc finite-element rotor of 12 modes rubbing on a rigid ring, run-up 0 to 1200 rpm in 20 s (ross_rotor.py) |
| pump | a pump in whirl at two seals, run up by its motor's torque, with a bearing that follows the speed, 5 s (driven.py) |

gyro is cut from the scene of Figure 3 (right), 20 to 150 Hz in 120 s, to 36 to 46.8 Hz at the same rate: there whirl A is
stable (it loses stability at 68.6 Hz), so errors do not grow and a reference exists; after that the delayed jump magnifies every
error by e^(integral of the growth rate), and its place is physics that depends on the tolerance, not an error to be measured.
"""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from driven import SCENE, Driven
from ross_rotor import ross_scene
from rsc import load_scene
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble

DATA = Path(__file__).parents[1] / "data" / "reference"
FILES = {"P1": "laval.toml", "P1c": "bouncing.toml", "P2": "chain_10.toml", "gyro": "gyroscopic_transition.toml"}
NAMES = (*FILES, "ROSS", "pump")
RESULTS, QUICK_RESULTS = Path(__file__).parent / "results", Path(__file__).parents[1] / "out" / "bench"
RATE = 2000.0  # output grid, 1/s
VARIANTS, VARIANT_SEED = 1000, 20260101


def results_folder(quick):
    """Where a script writes: what a short run finds is no result and never goes among the tracked files."""
    folder = QUICK_RESULTS if quick else RESULTS
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def pictures_folder(quick):
    """Where a script writes a picture of the documents."""
    return results_folder(quick) if quick else Path(__file__).parents[1] / "docs" / "images"


class Matrices(NamedTuple):
    """Equations of motion divided by the (diagonal) masses; state of the yardstick: y, z of rotor, y, z of stator, then rates."""

    stiffness_r: np.ndarray  # (N, N) M^-1 K
    damping_r: np.ndarray
    stiffness_s: np.ndarray  # (M, M), M = 0 for a rigid stator
    damping_s: np.ndarray
    unbalance: np.ndarray  # (N,) multiplies Omega^2 e^(i phi), m, real
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
    gyroscopic_r: np.ndarray  # (N, N) M^-1 G: the rotor feels i Omega M^-1 G r'
    euler: np.ndarray  # (N,) multiplies -i Omega' e^(i phi), m, real

    @property
    def plain(self):
        """Whether there are neither gyroscopics nor a rigid stator, so that the short right-hand sides serve."""
        return self.stiffness_s.size > 0 and not self.gyroscopic_r.any()


class Problem(NamedTuple):
    """A scene with its matrices, initial state (8 numbers per 1+1 coordinates) and duration."""

    name: str
    scene: object
    system: object  # matrices as the scene has them
    matrices: Matrices
    start: np.ndarray
    duration: float

    @property
    def times(self):
        """The output grid, s."""
        return np.arange(round(self.duration * RATE) + 1) / RATE


def matrices_of(system):
    """`Matrices` of a System with diagonal masses and a straight run-up."""
    m_r, m_s = np.diag(system.rotor.mass), np.diag(system.stator.mass)
    assert not (system.rotor.mass - np.diag(m_r)).any(), "the yardsticks divide by diagonal masses"
    i_r = int(np.argmax(system.rotor.contact))
    i_s = int(np.argmax(system.stator.contact)) if m_s.size else 0
    speed, time = system.schedule_speed, system.schedule_time
    return Matrices(
        np.ascontiguousarray(system.rotor.stiffness / m_r[:, None]),
        np.ascontiguousarray(system.rotor.damping / m_r[:, None]),
        np.ascontiguousarray(system.stator.stiffness / m_s[:, None]),
        np.ascontiguousarray(system.stator.damping / m_s[:, None]),
        np.ascontiguousarray(system.rotor.unbalance.real / m_r),
        i_r,
        i_s,
        1.0 / m_r[i_r],
        1.0 / m_s[i_s] if m_s.size else 0.0,
        system.contact.gap,
        system.law.friction,
        system.law.stiffness,
        system.law.damping,
        float(speed[0]),
        float((speed[1] - speed[0]) / (time[1] - time[0])),
        np.ascontiguousarray(system.rotor.gyroscopic / m_r[:, None]),
        np.ascontiguousarray(system.rotor.unbalance_euler.real / m_r),
    )


def state_of(parts):
    """The yardstick's state of (rotor, stator, rotor velocity, stator velocity), all complex."""
    return np.ascontiguousarray(np.concatenate([np.concatenate([part.real, part.imag]) for part in parts]))


@cache
def problem(name, share=1.0):
    """One of NAMES as `Problem` or `Driven`; `share` < 1 keeps only the first part of its span (the same run, ended earlier)."""
    if name == "pump":
        return Driven(share)
    scene = scene_of(name)
    if share < 1.0:
        scene = shortened(scene, share)
    return problem_of(name, scene)


def scene_of(name):
    """The scene of one of NAMES."""
    scene = ross_scene() if name == "ROSS" else load_scene(SCENE if name == "pump" else DATA / FILES[name])
    if name == "gyro":
        speeds = [36.0, 36.0 + 10.0 * 130.0 / 120.0]
        scene = scene.with_values({"drive.speed": speeds, "drive.duration": 10.0, "start.whirl": -37.1})
    return scene


def problem_of(name, scene):
    """Any scene with diagonal masses and a straight run-up as `Problem`."""
    system = assemble(scene)
    start = initial_state(scene, system)
    state = state_of((start.rotor, start.stator, start.rotor_velocity, start.stator_velocity))
    return Problem(name, scene, system, matrices_of(system), state, float(scene.drive.time[-1]))


def shortened(scene, share):
    """The first part of a straight run-up, whole samples long."""
    whole, speed = scene.drive.time[-1], scene.drive.speed
    duration = max(round(share * whole * RATE), 1) / RATE
    return scene.with_values(
        {"drive.speed": [speed[0], speed[0] + (speed[-1] - speed[0]) * duration / whole], "drive.duration": duration}
    )


def variants(count=VARIANTS):
    """P3: the first `count` of a thousand variants of P1 of 2 s: friction, damping and first speed drawn with a fixed seed."""
    base = problem("P1").scene
    rng = np.random.default_rng(VARIANT_SEED)
    draws = rng.uniform([0.12, 0.02, 20.0], [0.2, 0.03, 80.0], size=(VARIANTS, 3))[:count]
    rate = 80.0 / 30.0  # Hz/s, as P1
    keys = "contact.friction", "rotor.damping_ratio", "drive.speed", "drive.duration"
    values = ((friction, damping, [speed, speed + 2.0 * rate], 2.0) for friction, damping, speed in draws.tolist())
    return [base.with_values(dict(zip(keys, each, strict=True))) for each in values]


def displacements(rows, problem):
    """Complex displacements (samples, N + M) from rows of the yardstick's state."""
    if isinstance(problem, Driven):
        return problem.displacements(rows)
    n, m = problem.matrices.stiffness_r.shape[0], problem.matrices.stiffness_s.shape[0]
    rotor = rows[:, :n] + 1j * rows[:, n : 2 * n]
    stator = rows[:, 2 * n : 2 * n + m] + 1j * rows[:, 2 * n + m : 2 * (n + m)]
    return np.hstack([rotor, stator])
