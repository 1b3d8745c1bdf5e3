"""The problem "pump": two seals that switch by themselves, a motor with a torque curve, a bearing whose coefficients follow the
speed. Its scene, its right-hand side for other programs, and its reference.

The state is (angle, y, z; speed, rates of y, z) of all coordinates, rotor before stator; angle and speed are multiplied by the
gap, so that all entries have one size. A step of the reference holds the state of every contact and the intervals of both curves,
and ends where one of them ends; it is DOP853 with some steps from one output time to the next, bisected on real steps.
"""

import math
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
from scipy.integrate._ivp import dop853_coefficients as dop

from rsc import load_scene
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from third_engine import DRAG, FRICTION, GAP, INERTIA, RADIUS, SLIP, B, K, machine_of

N_STAGES = 12
STAGES = np.ascontiguousarray(dop.A[:N_STAGES, :N_STAGES])
WEIGHTS = np.ascontiguousarray(dop.B)
OPEN, CLOSING, OPENING, CLIPPED = range(4)
HALVINGS = 60
SCENE = Path(__file__).with_name("pump.toml")


class DrivenMatrices(NamedTuple):
    """Constants of the pump; knots in rad/s, tables at the knots, torque in N m."""

    knots: np.ndarray  # (k,)
    stiffness: np.ndarray  # (k, 2n, 2n)
    damping: np.ndarray
    per_mass: np.ndarray  # (n,) 1/kg, masses are diagonal
    rows: np.ndarray  # (c, n)
    unbalance: np.ndarray  # (n,) kg m, real
    surfaces: np.ndarray  # (c, ...) as third_engine.SURFACE has them
    torque_knots: np.ndarray  # (j,)
    torque: np.ndarray  # (j,)
    inertia: float
    gap: float


class Driven:
    """The problem, or the first part of its span, as the other programs take it."""

    name = "pump"

    def __init__(self, share=1.0):
        scene = load_scene(SCENE)
        self.scene = scene.with_values({"drive.duration": share * scene.drive.duration}) if share < 1.0 else scene
        self.system = assemble(self.scene)
        self.duration = float(self.scene.drive.duration)
        machine = machine_of(self.system)
        assert not machine.surfaces[:, [INERTIA, DRAG]].any() and (machine.surfaces[:, SLIP] > 0.0).all()
        assert not (machine.unbalance.imag.any() or (machine.euler - machine.unbalance).any() or machine.gyroscopic.any())
        per_mass = np.diag(machine.inverse)[: machine.rows.shape[1]].copy()
        assert not (machine.inverse - np.diag(np.tile(per_mass, 2))).any() and not machine.load.any()
        curve = np.asarray(self.scene.drive.torque) * [2.0 * np.pi, 1.0]
        self.matrices = DrivenMatrices(
            machine.knots, machine.stiffness, machine.damping, per_mass, machine.rows, machine.unbalance.real.copy(),
            machine.surfaces, curve[:, 0].copy(), curve[:, 1].copy(), float(self.system.drive.inertia),
            float(machine.surfaces[:, GAP].min()),
        )  # fmt: skip
        first, gap = initial_state(self.scene, self.system), self.matrices.gap
        places = np.concatenate([first.rotor, first.stator])
        moving = np.concatenate([first.rotor_velocity, first.stator_velocity])
        speed = 2.0 * np.pi * float(self.scene.drive.speed[0]) * gap
        self.start = np.concatenate([[0.0], places.real, places.imag, [speed], moving.real, moving.imag])

    @cached_property
    def times(self):
        """The output grid, s."""
        rate = self.scene.output.rate
        return np.arange(round(self.duration * rate) + 1) / rate

    def displacements(self, rows):
        """Complex displacements (samples, N + M) of rows of the state."""
        n = self.matrices.rows.shape[1]
        return rows[:, 1 : 1 + n] + 1j * rows[:, 1 + n : 1 + 2 * n]


@numba.njit(error_model="numpy")
def _place(knots, i, at):
    """(first knot, last knot, share of the last) of interval i of a table, continued to any place; outer ones are constant."""
    if i == 0:
        return 0, 0, 0.0
    if i == len(knots):
        return i - 1, i - 1, 0.0
    return i - 1, i, (at - knots[i - 1]) / (knots[i] - knots[i - 1])


@numba.njit(error_model="numpy")
def _of_contact(row, y, first):
    """A displacement (first 1) or velocity at a contact, complex."""
    n, along_y, along_z = len(row), 0.0, 0.0
    for j in range(n):
        along_y += row[j] * y[first + j]
        along_z += row[j] * y[first + n + j]
    return complex(along_y, along_z)


@numba.njit(error_model="numpy")
def _quantities(m, i, y):
    """(deflection less gap, its rate, slip velocity, direction) of a contact."""
    half, own = len(y) // 2, m.surfaces[i]
    d, rate = _of_contact(m.rows[i], y, 1), _of_contact(m.rows[i], y, half + 1)
    distance = abs(d)
    direction = d / distance if distance > 0.0 else 0j
    moved = rate * direction.conjugate()
    return distance - own[GAP], moved.real, y[half] / m.gap * own[RADIUS] + moved.imag, direction


@numba.njit(error_model="numpy")
def states_of(m, y, held):
    """Write the states of the contacts, of their slip (-1, 0, 1), and the intervals of both tables into held (2 c + 2,)."""
    c = len(m.rows)
    for i in range(c):
        depth, rate, slip, _ = _quantities(m, i, y)
        own = m.surfaces[i]
        if depth <= 0.0:
            held[i] = OPEN
        elif rate >= 0.0:
            held[i] = CLOSING
        else:
            held[i] = OPENING if own[K] * depth + own[B] * rate >= 0.0 else CLIPPED
        held[c + i] = 0 if held[i] == OPEN or abs(slip) < own[SLIP] else np.sign(slip)
    speed = y[len(y) // 2] / m.gap
    held[2 * c] = np.searchsorted(m.knots, speed, side="right")
    held[2 * c + 1] = np.searchsorted(m.torque_knots, speed, side="right")


@numba.njit(error_model="numpy")
def _springs(m, interval, speed, y, out):
    """Write the forces of springs and dampers into the last entries of out."""
    half, (i, j, share) = len(y) // 2, _place(m.knots, interval, speed)
    for row in range(half - 1):
        total = 0.0
        for column in range(half - 1):
            k = m.stiffness[i, row, column] + share * (m.stiffness[j, row, column] - m.stiffness[i, row, column])
            b = m.damping[i, row, column] + share * (m.damping[j, row, column] - m.damping[i, row, column])
            total -= k * y[1 + column] + b * y[half + 1 + column]
        out[half + 1 + row] = total


@numba.njit(error_model="numpy")
def _contacts(m, held, y, out):
    """Add the forces of the contacts to the last entries of out; returns what friction takes from the drive, N m."""
    c, n, half, taken = len(m.rows), m.rows.shape[1], len(y) // 2, 0.0
    for i in range(c):
        if held[i] == OPEN or held[i] == CLIPPED:
            continue
        depth, rate, slip, direction = _quantities(m, i, y)
        own = m.surfaces[i]
        normal = own[K] * depth + (own[B] * rate if held[i] == OPENING else 0.0)
        rub = own[FRICTION] * normal * (slip / own[SLIP] if held[c + i] == 0 else held[c + i])
        force = complex(normal, rub) * direction
        for j in range(n):
            out[half + 1 + j] -= m.rows[i, j] * force.real
            out[half + 1 + n + j] -= m.rows[i, j] * force.imag
        taken += rub * own[RADIUS]
    return taken


@numba.njit(error_model="numpy")
def slope(m, held, y, out):
    """dy/dt while the states `held` last, continued smoothly beyond: (M + coupling) (v', Omega') = forces, masses diagonal."""
    c, n, half = len(m.rows), m.rows.shape[1], len(y) // 2
    speed, cos, sin = y[half] / m.gap, math.cos(y[0] / m.gap), math.sin(y[0] / m.gap)
    _springs(m, held[2 * c], speed, y, out)
    i, j, share = _place(m.torque_knots, held[2 * c + 1], speed)
    net = m.torque[i] + share * (m.torque[j] - m.torque[i]) - _contacts(m, held, y, out)
    inertia = m.inertia
    for j in range(n):
        u_y, u_z = m.unbalance[j] * cos, m.unbalance[j] * sin
        f_y, f_z = out[half + 1 + j] + speed * speed * u_y, out[half + 1 + n + j] + speed * speed * u_z
        net += m.per_mass[j] * (u_z * f_y - u_y * f_z)
        inertia -= m.per_mass[j] * (u_z * u_z + u_y * u_y)
        out[half + 1 + j], out[half + 1 + n + j] = f_y, f_z
    rise = net / inertia
    for j in range(n):
        u_y, u_z = m.unbalance[j] * cos, m.unbalance[j] * sin
        out[half + 1 + j] = m.per_mass[j] * (out[half + 1 + j] + rise * u_z)
        out[half + 1 + n + j] = m.per_mass[j] * (out[half + 1 + n + j] - rise * u_y)
    out[:half] = y[half:]
    out[half] = rise * m.gap


@numba.njit(error_model="numpy")
def right_hand_side_driven(m, t, y, out):
    """dy/dt; the time acts by the angle alone."""
    held = np.zeros(2 * len(m.rows) + 2, np.int64)
    states_of(m, y, held)
    slope(m, held, y, out)


@numba.njit(error_model="numpy")
def _step(m, held, y, h, k, out):
    for s in range(N_STAGES):
        out[:] = y
        for j in range(s):
            out += h * STAGES[s, j] * k[j]
        slope(m, held, out, k[s])
    out[:] = y
    for j in range(N_STAGES):
        out += h * WEIGHTS[j] * k[j]


@numba.njit(error_model="numpy")
def _run(m, start, rate, substeps, rows):
    """Fill rows with the states on the grid; returns the number of switches."""
    y, new, k, switches = start.copy(), start.copy(), np.zeros((N_STAGES, len(start))), 0
    held = np.zeros(2 * len(m.rows) + 2, np.int64)
    other = held.copy()
    states_of(m, y, held)
    rows[0] = y
    for row in range(1, len(rows)):
        for _ in range(substeps):
            left = 1.0 / (rate * substeps)
            while left > 0.0:
                _step(m, held, y, left, k, new)
                states_of(m, new, other)
                h = left
                if (other != held).any():
                    near, far = 0.0, left
                    for _ in range(HALVINGS):  # the switch to the last bit, and the step to its far side
                        middle = 0.5 * (near + far)
                        _step(m, held, y, middle, k, new)
                        states_of(m, new, other)
                        if (other != held).any():
                            far = middle
                        else:
                            near = middle
                    h = far
                    _step(m, held, y, h, k, new)
                    states_of(m, new, held)
                    switches += 1
                y[:] = new
                left -= h
        rows[row] = y
    return switches


def reference_run(problem, substeps):
    """(states on the output grid, switches) by so many steps between two output times."""
    rows = np.zeros((problem.times.size, problem.start.size))
    return rows, _run(problem.matrices, problem.start, problem.scene.output.rate, substeps, rows)
