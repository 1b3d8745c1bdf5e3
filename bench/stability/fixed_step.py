"""What engineers use: a plain right-hand side that ignores the kinks; RK4 and Newmark with fixed steps; scipy's solvers.

Nothing of rsc's kernel is shared but the scene's matrices (`rsc.system.assemble`). The state is complex:
z = (r_R, r_S, r_R', r_S').
"""

import math
import time
import warnings
from typing import NamedTuple

import numba
import numpy as np
import scipy.integrate

SCIPY = ("RK45", "DOP853", "Radau", "LSODA")
CHUNK = 50_000


class Plain(NamedTuple):
    """A System as acceleration per mass; n = N + M complex coordinates."""

    stiffness: np.ndarray  # (n, n) M^-1 K
    damping: np.ndarray  # (n, n)
    gyroscopic: np.ndarray  # (n, n) M^-1 G
    row: np.ndarray  # (n,) d = row . r + ring e^{i phi}
    push: np.ndarray  # (n,) M^-1 row, 1/kg
    unbalance: np.ndarray  # (n,) complex m, times phi'^2
    euler: np.ndarray  # (n,) complex m, times -i phi''
    load: np.ndarray  # (n,) complex m/s^2
    gap: float
    friction: float
    k_c: float
    b_c: float
    ring: complex
    radius: float  # m, 0: one-sided friction
    slip_velocity: float  # m/s
    corner_time: np.ndarray  # s
    corner_speed: np.ndarray  # rad/s
    corner_phase: np.ndarray  # rad


def plain(system):
    """Plain of a System (any mass matrix)."""
    n, m = system.n_rotor, system.n_stator
    zero = np.zeros((n + m, n + m))

    def joined(rotor, stator):
        out = zero.copy()
        out[:n, :n], out[n:, n:] = rotor, stator
        return out

    rotor, stator, law, contact = system.rotor, system.stator, system.law, system.contact
    inverse = np.linalg.inv(joined(rotor.mass, stator.mass))
    row = system.relative
    imposed = [np.concatenate([v, np.zeros(m)]).astype(complex) for v in (rotor.unbalance, rotor.unbalance_euler, rotor.load)]
    gyroscopic = np.zeros((n, n)) if rotor.gyroscopic is None else rotor.gyroscopic
    speed, corners = np.array(system.schedule_speed), np.array(system.schedule_time)
    phase = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(corners))])
    return Plain(
        inverse @ joined(rotor.stiffness, stator.stiffness),
        inverse @ joined(rotor.damping, stator.damping),
        inverse @ joined(gyroscopic, np.zeros((m, m))),
        row,
        inverse @ row,
        *(inverse @ v for v in imposed),
        float(contact.gap),
        float(law.friction),
        float(law.stiffness),
        float(law.damping),
        complex(contact.ring),
        0.0 if law.diameter is None else 0.5 * float(law.diameter),
        1.0 if law.slip_velocity is None else float(law.slip_velocity),
        corners,
        speed,
        phase,
    )


@numba.njit(error_model="numpy", cache=True)
def rotation(p, t):
    """(phi, phi', phi'') at a time."""
    i = 0
    while i < p.corner_time.shape[0] - 2 and t >= p.corner_time[i + 1]:
        i += 1
    rise = (p.corner_speed[i + 1] - p.corner_speed[i]) / (p.corner_time[i + 1] - p.corner_time[i])
    s = t - p.corner_time[i]
    return p.corner_phase[i] + p.corner_speed[i] * s + 0.5 * rise * s * s, p.corner_speed[i] + rise * s, rise


@numba.njit(error_model="numpy", cache=True)
def contact_force(p, d, d_dot, omega):
    """F_C of the pseudolinear law, complex N (real arithmetic: Numba's complex division and abs are slow)."""
    distance = math.sqrt(d.real * d.real + d.imag * d.imag)
    if distance <= p.gap:
        return 0j
    rate = (d.real * d_dot.real + d.imag * d_dot.imag) / distance
    normal = max(0.0, p.k_c * (distance - p.gap) + p.b_c * min(rate, 0.0)) / distance
    sigma = p.friction
    if p.radius > 0.0:
        slip = omega * p.radius + (d.real * d_dot.imag - d.imag * d_dot.real) / distance
        sigma *= min(1.0, max(-1.0, slip / p.slip_velocity))
    return complex(normal * (d.real - sigma * d.imag), normal * (d.imag + sigma * d.real))


@numba.njit(error_model="numpy", cache=True)
def imposed(p, t):
    """(phi'^2 e^{i phi}, -i phi'' e^{i phi}, ring, ring', phi')."""
    phi, omega, rise = rotation(p, t)
    turn = complex(math.cos(phi), math.sin(phi))
    ring = p.ring * turn
    return omega * omega * turn, -1j * rise * turn, ring, 1j * omega * ring, omega


@numba.njit(error_model="numpy", cache=True)
def derivative(p, t, z, out):
    """z' into out."""
    n = p.row.shape[0]
    square, euler, d, d_dot, omega = imposed(p, t)
    for i in range(n):
        d += p.row[i] * z[i]
        d_dot += p.row[i] * z[n + i]
    force = contact_force(p, d, d_dot, omega)
    for i in range(n):
        a = p.unbalance[i] * square + p.euler[i] * euler + p.load[i]
        a_y, a_z = a.real - p.push[i] * force.real, a.imag - p.push[i] * force.imag
        for j in range(n):
            r, v = z[j], z[n + j]
            a_y -= p.stiffness[i, j] * r.real + p.damping[i, j] * v.real + omega * p.gyroscopic[i, j] * v.imag
            a_z -= p.stiffness[i, j] * r.imag + p.damping[i, j] * v.imag - omega * p.gyroscopic[i, j] * v.real
        out[i] = z[n + i]
        out[n + i] = complex(a_y, a_z)


@numba.njit(error_model="numpy", cache=True)
def rk4_steps(p, z, first, steps, h, every, out):
    """`steps` steps of RK4 from number `first` on, in place; every `every`-th state into out. Returns the steps done."""
    k1, k2, k3, k4, w = np.empty_like(z), np.empty_like(z), np.empty_like(z), np.empty_like(z), np.empty_like(z)
    for step in range(first, first + steps):
        t = step * h
        derivative(p, t, z, k1)
        for i in range(z.shape[0]):
            w[i] = z[i] + 0.5 * h * k1[i]
        derivative(p, t + 0.5 * h, w, k2)
        for i in range(z.shape[0]):
            w[i] = z[i] + 0.5 * h * k2[i]
        derivative(p, t + 0.5 * h, w, k3)
        for i in range(z.shape[0]):
            w[i] = z[i] + h * k3[i]
        derivative(p, t + h, w, k4)
        for i in range(z.shape[0]):
            z[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
        if (step + 1) % every == 0:
            out[(step + 1) // every] = z
        if not abs(z[0]) < 1e100:
            return step + 1 - first
    return steps


@numba.njit(error_model="numpy", cache=True)
def newton_force(p, d, d_dot, omega, spring, dashpot, start):
    """F of F = contact_force(d - spring F, d' - dashpot F) by Newton's method on its two parts (at most 30 iterations)."""
    force, scale = start, 1e-6 * p.k_c * (p.gap + abs(d))
    for _ in range(30):
        miss = force - contact_force(p, d - spring * force, d_dot - dashpot * force, omega)
        size = 1e-7 * (abs(force) + scale)
        by_y = size - contact_force(p, d - spring * (force + size), d_dot - dashpot * (force + size), omega) + (force - miss)
        turned = force + 1j * size
        by_z = 1j * size - contact_force(p, d - spring * turned, d_dot - dashpot * turned, omega) + (force - miss)
        det = (by_y.real * by_z.imag - by_y.imag * by_z.real) / size
        if det == 0.0 or not abs(miss) < 1e200:
            return force
        change_y = (miss.real * by_z.imag - miss.imag * by_z.real) / det
        change_z = (by_y.real * miss.imag - by_y.imag * miss.real) / det
        change = complex(change_y, change_z)
        force -= change
        if abs(change) <= 1e-12 * (abs(force) + scale):
            return force
    return force


@numba.njit(error_model="numpy", cache=True)
def newmark_steps(p, inverse, state, first, steps, h, every, out):
    """Average acceleration (beta 1/4, gamma 1/2), contact by Newton's method; state (3, n) = r, r', r''. Without gyroscopics."""
    n = p.row.shape[0]
    r, v, a = state[0], state[1], state[2]
    shove = inverse @ p.push.astype(np.complex128)
    compliance = 0j
    for i in range(n):
        compliance += p.row[i] * shove[i]
    spring, dashpot, force = 0.25 * h * h * compliance.real, 0.5 * h * compliance.real, 0j
    right = np.empty(n, dtype=np.complex128)
    for step in range(first, first + steps):
        square, euler, d, d_dot, omega = imposed(p, (step + 1) * h)
        for i in range(n):
            r[i] += h * v[i] + 0.25 * h * h * a[i]
            v[i] += 0.5 * h * a[i]
        for i in range(n):
            right[i] = p.unbalance[i] * square + p.euler[i] * euler + p.load[i]
            for j in range(n):
                right[i] -= p.stiffness[i, j] * r[j] + p.damping[i, j] * v[j]
        for i in range(n):
            a[i] = 0j
            for j in range(n):
                a[i] += inverse[i, j] * right[j]
            d += p.row[i] * (r[i] + 0.25 * h * h * a[i])
            d_dot += p.row[i] * (v[i] + 0.5 * h * a[i])
        force = newton_force(p, d, d_dot, omega, spring, dashpot, force)
        for i in range(n):
            a[i] -= shove[i] * force
            r[i] += 0.25 * h * h * a[i]
            v[i] += 0.5 * h * a[i]
        if (step + 1) % every == 0:
            out[(step + 1) // every, :n] = r
            out[(step + 1) // every, n:] = v
        if not abs(r[0]) < 1e100:
            return step + 1 - first
    return steps


class Attempt(NamedTuple):
    """What a method did: `end` is "finished", "time limit", "blow-up" (fixed step: beyond 1e100 m) or a solver's own words."""

    end: str
    states: np.ndarray  # (rows, 2n) complex on the output grid, as far as it came
    calls: int  # of the right-hand side (Newmark: steps)
    seconds: float
    note: str = ""


def fixed_step(method, p, start, h, grid, limit):
    """RK4 or Newmark from `start` (2n,) on; grid = (rate in Hz, rows), a multiple of h apart; limit in s of processor time."""
    rate, rows = grid
    every = round(1.0 / (rate * h))
    assert abs(every * h * rate - 1.0) < 1e-9, "the output grid must be a multiple of the step"
    out = np.zeros((rows, start.size), dtype=complex)
    out[0] = start
    n = start.size // 2
    z, total, done = start.astype(complex), (rows - 1) * every, 0
    if method == "Newmark":
        assert not p.gyroscopic.any()
        k = np.empty_like(z)
        derivative(p, 0.0, z, k)
        state = np.array([z[:n], z[n:], k[n:]])
        inverse = np.linalg.inv(np.eye(n) + 0.5 * h * p.damping + 0.25 * h * h * p.stiffness).astype(complex)
    begun, end = time.process_time(), "finished"
    while done < total:
        steps = min(CHUNK, total - done)
        if method == "RK4":
            made = rk4_steps(p, z, done, steps, h, every, out)
        else:
            made = newmark_steps(p, inverse, state, done, steps, h, every, out)
        done += made
        if made < steps or not np.isfinite(out[done // every]).all():
            end = "blow-up"
            break
        if time.process_time() - begun > limit and done < total:
            end = "time limit"
            break
    return Attempt(end, out[: done // every + 1], (4 if method == "RK4" else 1) * done, time.process_time() - begun)


@numba.njit(error_model="numpy", cache=True)
def _real(p, t, y, out):
    derivative(p, t, y.view(np.complex128), out.view(np.complex128))


def scipy_run(method, p, start, rtol, grid, limit, scale):
    """One of scipy's solvers with the compiled right-hand side: kinks and corners of the schedule are not told to it.

    scale : m, the length whose rtol-th part is the absolute tolerance (300 times that, in m/s, for velocities).
    """
    rate, rows = grid
    out = np.zeros((rows, start.size), dtype=complex)
    work, calls = np.empty(2 * start.size), 0

    def f(t, y):
        nonlocal calls
        calls += 1
        _real(p, t, np.ascontiguousarray(y), work)
        return work.copy()

    atol = rtol * scale * np.repeat([1.0, 300.0], start.size)
    y = np.ascontiguousarray(start, dtype=complex).view(float)
    f(0.0, y.copy())
    begun, end, row, note = time.process_time(), "finished", 0, ""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        solver = getattr(scipy.integrate, method)(f, 0.0, y.copy(), (rows - 1) / rate, rtol=rtol, atol=atol)
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                end, note = "failed", str(message)
                break
            if row < rows and row / rate <= solver.t:
                last = min(int(solver.t * rate * (1.0 + 1e-15)), rows - 1)
                wanted = np.arange(row, last + 1)
                out[wanted] = np.ascontiguousarray(solver.dense_output()(wanted / rate).T).view(complex)
                row = last + 1
            if not np.isfinite(solver.y).all():
                end = "NaN"
                break
            if time.process_time() - begun > limit and solver.status == "running":
                end = "time limit"
                break
        note = note or "; ".join(dict.fromkeys(str(w.message) for w in said))
    return Attempt(end, out[:row], calls, time.process_time() - begun, note[:200])
