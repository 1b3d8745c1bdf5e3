"""The right-hand side of a scene for integrators from outside, physics.md section 2 in real numbers, written to be read.

It shares no code with the kernel: what rsc integrates itself is in modal coordinates, scaled, and cut at every switch. The same
functions run as NumPy and, by Numba, compiled.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

OPEN, CLOSING, OPENING, CLIPPED = range(4)  # no contact; pressed harder; less, with the damper; less, and the damper lets go
PRESSED, SLIDING = range(2)  # columns of the states of contacts


class Constants(NamedTuple):
    """Constants of a scene; n coordinates of rotor and stator, c contacts. State: y and z of all, then their velocities."""

    n: int
    stiffness: NDArray[np.float64]  # (2n, 2n) 1/s^2, M^-1 K with what is skew or anisotropic
    damping: NDArray[np.float64]  # (2n, 2n) 1/s, M^-1 B, that which turns with the rotor included
    turning_stiffness: NDArray[np.float64]  # (2n, 2n) 1/s, times the rotor speed: rotating damping
    turning_damping: NDArray[np.float64]  # (2n, 2n), times the rotor speed: gyroscopics
    unbalance: NDArray[np.complex128]  # (n,) m, M^-1 of the unbalance
    euler: NDArray[np.complex128]  # (n,) m
    load: NDArray[np.float64]  # (2n,) m/s^2
    time: NDArray[np.float64]  # (k,) s, corners of the speed
    speed: NDArray[np.float64]  # (k,) rad/s
    angle: NDArray[np.float64]  # (k,) rad
    rows: NDArray[np.float64]  # (c, n), the relative displacement at a contact is its row times y, and times z
    per_force: NDArray[np.float64]  # (c, n) 1/kg, M^-1 of the row
    gap: NDArray[np.float64]  # (c,) m
    spring: NDArray[np.float64]  # (c,) N/m
    damper: NDArray[np.float64]  # (c,) N s/m
    friction: NDArray[np.float64]  # (c,)
    radius: NDArray[np.float64]  # (c,) m, half the contact diameter; 0 with one-sided friction
    slip_velocity: NDArray[np.float64]  # (c,) m/s; 0 with one-sided friction
    ring: NDArray[np.complex128]  # (c,) m
    offset: NDArray[np.complex128]  # (c,) m
    sense: float


def turned(t: float, p: Constants) -> tuple[float, float, float]:
    """Angle in rad, speed in rad/s and its rate at a time."""
    i = min(max(int(np.searchsorted(p.time, t, side="right")) - 1, 0), len(p.time) - 2)
    rate = (p.speed[i + 1] - p.speed[i]) / (p.time[i + 1] - p.time[i])
    tau = t - p.time[i]
    return p.angle[i] + p.speed[i] * tau + 0.5 * rate * tau * tau, p.speed[i] + rate * tau, rate


def relative(c: int, y: NDArray[np.float64], angle: float, omega: float, p: Constants) -> tuple[complex, complex]:
    """Relative displacement d and velocity of rotor and stator at contact c, complex m and m/s."""
    n, d, v = p.n, 0.0j, 0.0j
    for j in range(n):
        d += p.rows[c, j] * (y[j] + 1j * y[n + j])
        v += p.rows[c, j] * (y[2 * n + j] + 1j * y[3 * n + j])
    ring = p.ring[c] * np.exp(1j * angle)
    return d + ring - p.offset[c], v + 1j * omega * ring


def quantities(c: int, y: NDArray[np.float64], angle: float, omega: float, p: Constants) -> tuple[float, float, float, float]:
    """(delta, delta', force with the damper, slip) at contact c: m, m/s, N, m/s; what the states switch on."""
    d, v = relative(c, y, angle, omega, p)
    distance = abs(d)
    turn = v * np.conj(d) / distance if distance > 0.0 else 0.0j
    delta, delta_dot = p.gap[c] - distance, -turn.real
    return delta, delta_dot, -p.spring[c] * delta - p.damper[c] * delta_dot, omega * p.radius[c] + turn.imag


def states_at(t: float, y: NDArray[np.float64], p: Constants) -> NDArray[np.int64]:
    """(c, 2) the states of the contacts: OPEN to CLIPPED, and which way they slide (-1, 0 between, 1)."""
    angle, omega, _ = turned(t, p)
    states = np.zeros((len(p.gap), 2), np.int64)
    for c in range(len(p.gap)):
        delta, delta_dot, force, slip = quantities(c, y, angle, omega, p)
        if delta < 0.0:
            states[c, 0] = 1 if delta_dot <= 0.0 else 2 if force > 0.0 else 3
        limit = p.slip_velocity[c]
        states[c, 1] = (1 if slip > limit else -1 if slip < -limit else 0) if limit > 0.0 else 0
    return states


def contact_force(c: int, y: NDArray[np.float64], angle: float, omega: float, states: NDArray[np.int64], p: Constants) -> complex:
    """F_C of contact c in N, continued beyond the borders of its state."""
    pressed, sliding = states[c, 0], states[c, 1]
    if pressed == 0 or pressed == 3:
        return 0.0j
    delta, _, force, slip = quantities(c, y, angle, omega, p)
    if pressed == 1:
        force = -p.spring[c] * delta
    limit = p.slip_velocity[c]
    sigma = p.sense if limit == 0.0 else slip / limit if sliding == 0 else float(sliding)
    d = relative(c, y, angle, omega, p)[0]
    return (1.0 + 1j * p.friction[c] * sigma) * force * d / abs(d)


def slope(t: float, y: NDArray[np.float64], states: NDArray[np.int64], p: Constants) -> NDArray[np.float64]:
    """y' of the first-order system."""
    n = p.n
    angle, omega, rate = turned(t, p)
    x, v = y[: 2 * n], y[2 * n :]
    out = np.empty(4 * n)
    out[: 2 * n] = v
    a = p.load - np.dot(p.stiffness, x) - np.dot(p.damping, v)
    a += omega * (np.dot(p.turning_stiffness, x) + np.dot(p.turning_damping, v))
    imposed = (p.unbalance * omega**2 - 1j * p.euler * rate) * np.exp(1j * angle)
    for c in range(len(p.gap)):
        imposed = imposed - p.per_force[c] * contact_force(c, y, angle, omega, states, p)
    out[2 * n : 3 * n] = a[:n] + imposed.real
    out[3 * n :] = a[n:] + imposed.imag
    return out


def contact_jacobian(c: int, y: Any, angle: float, omega: float, states: Any, p: Constants) -> NDArray[np.float64]:
    """(2, 4): of F_C as (y, z) by d and its velocity as (y, z)."""
    out = np.zeros((2, 4))
    pressed, sliding = states[c]
    if pressed in (OPEN, CLIPPED):
        return out
    delta, _, force, slip = quantities(c, y, angle, omega, p)
    d, w = (np.array([value.real, value.imag]) for value in relative(c, y, angle, omega, p))
    distance, damper = np.hypot(*d), p.damper[c] if pressed == OPENING else 0.0
    e = d / distance
    t = np.array([-e[1], e[0]])
    force = force if pressed == OPENING else -p.spring[c] * delta
    limit = p.slip_velocity[c]
    sigma = p.sense if limit == 0.0 else slip / limit if sliding == 0 else float(sliding)
    by_d, by_v = p.spring[c] * e + damper * (w @ t) * t / distance, damper * e
    along = e + p.friction[c] * sigma * t
    out[:, :2] = np.outer(along, by_d) + force / distance * np.outer(t - p.friction[c] * sigma * e, t)
    out[:, 2:] = np.outer(along, by_v)
    if limit > 0.0 and sliding == 0:
        share = force * p.friction[c] / limit
        out[:, :2] -= share * (w @ e) / distance * np.outer(t, t)
        out[:, 2:] += share * np.outer(t, t)
    return out
