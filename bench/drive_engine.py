"""A third engine, for drives with a torque: y and z of all coordinates, the angle phi and the speed Omega by the classical method
of Runge and Kutta with steps of one length, real numbers throughout, the accelerations of all at once from one linear system
(physics.md section 2). It has no tolerance, no switches and shares no line with rsc."""

from typing import NamedTuple

import numpy as np
from numba import njit

STEPS = 40.0  # of the fastest motion's period


class Machine(NamedTuple):
    """Real matrices on q = [y, z] of the coordinates of both bodies at knots of the speed, and constants of one contact.

    knots (k,) rad/s; stiffness, damping (k, 2 n, 2 n), linear between; mass, gyroscopic, sliding, turning (2 n, 2 n): sliding is
    rotating damping on velocities, turning that on places, times Omega; row (n,); unbalance, euler (n,) complex; load (2 n,)
    """

    knots: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    mass: np.ndarray
    gyroscopic: np.ndarray
    sliding: np.ndarray
    turning: np.ndarray
    row: np.ndarray
    unbalance: np.ndarray
    euler: np.ndarray
    load: np.ndarray
    gap: float
    friction: float
    k: float
    b: float
    radius: float
    slip: float
    ring: complex


def machine_of(system):
    """The Machine of a rsc.system.System with one contact that has a diameter."""
    n, m, law = system.n_rotor, system.n_stator, system.law
    side = n + m
    knots = np.unique(np.concatenate([[0.0], np.asarray(system.knot_speed, dtype=float)]))

    def whole(rotor, stator):
        block = np.zeros((side, side), complex)
        block[:n, :n] = 0.0 if rotor is None or not len(rotor) else rotor
        block[n:, n:] = 0.0 if stator is None or not len(stator) else stator
        return block

    def real(turned, conjugate):
        """[[.]] of q for r -> turned r + conjugate r*."""
        plus, minus = turned + conjugate, turned - conjugate
        return np.block([[plus.real, -minus.imag], [plus.imag, minus.real]])

    def of(name, rotor):
        parts = [whole(getattr(rotor, key), getattr(system.stator, key)) for key in (name, f"skew_{name}", f"anisotropic_{name}")]
        return real(parts[0] + 1j * parts[1], parts[2])

    bodies = [system.rotor.at_knots(knot) for knot in knots]
    none = np.zeros((side, side))
    padded = [np.concatenate([vector, np.zeros(m, complex)]) for vector in (system.rotor.unbalance, system.rotor.unbalance_euler)]
    load = np.concatenate([system.rotor.load, np.zeros(m, complex)])
    rotating = whole(system.rotor.rotating_damping, None)
    return Machine(
        knots, np.array([of("stiffness", body) for body in bodies]), np.array([of("damping", body) for body in bodies]),
        real(whole(system.rotor.mass, system.stator.mass), none), real(-1j * whole(system.rotor.gyroscopic, None), none),
        real(rotating, none), real(-1j * rotating, none), np.concatenate([system.rotor.contact, -system.stator.contact]),
        *padded, np.concatenate([load.real, load.imag]), system.contact.gap, law.friction, law.stiffness, law.damping,
        0.5 * law.diameter, law.slip_velocity, complex(system.contact.ring),
    )  # fmt: skip


@njit(error_model="numpy", cache=True)
def _between(knots, tables, speed):
    i = min(max(np.searchsorted(knots, speed), 1), len(knots) - 1)
    if len(knots) == 1 or speed <= knots[0]:
        return tables[0].copy()
    if speed >= knots[-1]:
        return tables[-1].copy()
    share = (speed - knots[i - 1]) / (knots[i] - knots[i - 1])
    return (1.0 - share) * tables[i - 1] + share * tables[i]


@njit(error_model="numpy", cache=True)
def rates(m, inertia, torque, q, v, phi, speed):
    """(accelerations of q and phi, what friction takes in N m)."""
    n = len(m.row)
    turn = np.exp(1j * phi)
    ring = m.ring * turn
    d = complex(m.row @ q[:n], m.row @ q[n:]) + ring
    rate = complex(m.row @ v[:n], m.row @ v[n:]) + 1j * speed * ring
    force, rub = 0j, 0.0
    distance = abs(d)
    if distance > m.gap:
        along = (rate * d.conjugate()).real / distance
        normal = max(m.k * (distance - m.gap) + m.b * min(along, 0.0), 0.0)
        slip = speed * m.radius + (rate * d.conjugate()).imag / distance
        rub = m.friction * min(max(slip / m.slip, -1.0), 1.0) * normal
        force = complex(normal, rub) * d / distance
    stiffness = _between(m.knots, m.stiffness, speed) + speed * m.turning
    damping = _between(m.knots, m.damping, speed) + speed * m.gyroscopic + m.sliding
    right, u, euler = m.load - stiffness @ q - damping @ v, m.unbalance * turn, m.euler * turn
    right[:n] += speed**2 * u.real - m.row * force.real
    right[n:] += speed**2 * u.imag - m.row * force.imag
    slid = m.sliding @ v + speed * (m.turning @ q)
    net = torque - rub * m.radius - (ring.conjugate() * force).imag + q[:n] @ slid[n:] - q[n:] @ slid[:n]
    net += speed * ((euler - u).real @ v[:n] + (euler - u).imag @ v[n:])
    whole = np.zeros((2 * n + 1, 2 * n + 1))
    whole[:-1, :-1], whole[-1, -1] = m.mass, inertia
    whole[:n, -1], whole[n:-1, -1] = -euler.imag, euler.real
    whole[-1, :n], whole[-1, n:-1] = -euler.imag, euler.real
    return np.linalg.solve(whole, np.append(right, net)), rub * m.radius


@njit(error_model="numpy", cache=True)
def march(m, drive, step, state, out):
    """Write [time, Re d, Im d, phi, speed, torque of friction] of every step into out (count, 6); how many there are until it
    stands. drive = inertia and knots of the torque, state = (q, v, phi, speed)."""
    (inertia, table), (q, v, phi, speed) = drive, state
    n, each = len(m.row), 2 * len(m.row)
    for i in range(len(out)):
        turned = m.ring * np.exp(1j * phi)
        out[i, :5] = i * step, (m.row * q[:n]).sum() + turned.real, (m.row * q[n:]).sum() + turned.imag, phi, speed
        if speed <= 0.0:
            return i + 1
        place, moving, angle, pace = q.copy(), v.copy(), phi, speed
        sums, weights, shares = np.zeros(2 * each + 2), (1.0, 2.0, 2.0, 1.0), (0.0, 0.5, 0.5, 1.0)
        slope = np.zeros(2 * each + 2)
        for s in range(4):
            at = shares[s] * step * slope
            x, w = place + at[:each], moving + at[each : 2 * each]
            torque = np.interp(pace + at[-1], table[:, 0], table[:, 1])
            a, rub = rates(m, inertia, torque, x, w, angle + at[-2], pace + at[-1])
            if s == 0:
                out[i, 5] = rub
            slope = np.concatenate((w, a[:each], np.array([pace + at[-1], a[each]])))
            sums += weights[s] * slope / 6.0
        q, v = place + step * sums[:each], moving + step * sums[each : 2 * each]
        phi, speed = angle + step * sums[-2], pace + step * sums[-1]
        if not abs(speed) < 1e9:
            return i + 1
    return len(out)


class Path(NamedTuple):
    """A run: arrays (n,) of time s, deflection m complex, turns of the shaft, speed Hz, torque of friction N m."""

    time: np.ndarray
    d: np.ndarray
    turns: np.ndarray
    speed: np.ndarray
    torque: np.ndarray

    def mean(self, begin, end):
        """Mean speed in Hz between two times."""
        first, last = np.interp([begin, end], self.time, self.turns)
        return (last - first) / (end - begin)

    def share(self, begin, end, gap):
        """Share of the time in contact."""
        own = abs(self.d[np.searchsorted(self.time, begin) : max(np.searchsorted(self.time, end), 1)])
        return float((own > gap).mean())


def step_of(m, speed):
    """Length of a step of a Machine from a speed in Hz, s."""
    elastic = np.linalg.eigvals(np.linalg.solve(m.mass, np.max(m.stiffness, axis=0)))
    contact = m.k * (m.row**2 / np.diag(m.mass)[: len(m.row)]).sum()
    return 2.0 * np.pi / STEPS / max(np.sqrt(abs(elastic).max() + contact), 2.0 * np.pi * speed)


def release(system, start, turns, speed, table, duration, finer=1.0):
    """A Path from an InitialState and turns of the shaft, at a speed in Hz, under a torque (k, 2) of Hz and N m."""
    m = machine_of(system)
    step = step_of(m, speed) / finer
    places = np.concatenate([start.rotor, start.stator])
    moving = np.concatenate([start.rotor_velocity, start.stator_velocity])
    state = [np.concatenate([part.real, part.imag]) for part in (places, moving)]
    table = np.asarray(table, dtype=float) * [2.0 * np.pi, 1.0]
    out = np.zeros((int(duration / step) + 2, 6))
    done = march(m, (system.drive.inertia, table), step, (*state, 2.0 * np.pi * turns, 2.0 * np.pi * speed), out)
    time, y, z, phi, omega, torque = out[:done].T
    return Path(time, y + 1j * z, phi / (2.0 * np.pi), omega / (2.0 * np.pi), torque)
