"""A third engine, for all terms: y and z of all coordinates, the angle phi and the speed Omega of the shaft and the speeds of
inner races by the classical method of Runge and Kutta with steps of one length, real numbers throughout (physics.md section 2).
It has no tolerance, no switches and shares no line with rsc."""

from typing import NamedTuple

import numpy as np
from numba import njit

STEPS = 40.0  # of the fastest motion's period
CREEP, MOST_STEPS = 1.0, 2_000_000  # of a decay of slip that a step may take; steps of a run at most


class TooStiff(Exception):
    """Friction takes small slip away so fast that a run would need more than MOST_STEPS steps."""


class Machine(NamedTuple):
    """Real matrices on q = [y, z] of the coordinates of both bodies at knots of the speed, and constants of c contacts.

    knots (k,) rad/s; stiffness, damping (k, 2 n, 2 n), linear between; inverse: of the mass, gyroscopic, sliding, turning
    (2 n, 2 n): sliding is rotating damping on velocities, turning that on places, times Omega; rows (c, n); unbalance, euler (n,)
    complex; load (2 n,); surfaces (c, 10): `SURFACE`; ring (c,) complex
    """

    knots: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    inverse: np.ndarray
    gyroscopic: np.ndarray
    sliding: np.ndarray
    turning: np.ndarray
    rows: np.ndarray
    unbalance: np.ndarray
    euler: np.ndarray
    load: np.ndarray
    surfaces: np.ndarray
    ring: np.ndarray


# columns of `Machine.surfaces`; radius 0 and slip 0: friction of one side; inertia 0: no race
SURFACE = ("gap", "friction", "k", "b", "radius", "slip", "inertia", "drag")
GAP, FRICTION, K, B, RADIUS, SLIP, INERTIA, DRAG = range(len(SURFACE))


class Shaft(NamedTuple):
    """What turns the shaft: with an inertia (kg m^2) above 0 a torque (k, 2) in rad/s and N m, from the time `trip` on `coast`;
    else a speed that is linear between corners (k, 2) in s and rad/s."""

    inertia: float
    torque: np.ndarray
    coast: np.ndarray
    trip: float
    corners: np.ndarray


def machine_of(system):
    """The Machine of a rsc.system.System."""
    n, m = system.n_rotor, system.n_stator
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
        np.linalg.inv(real(whole(system.rotor.mass, system.stator.mass), none)),
        real(-1j * whole(system.rotor.gyroscopic, None), none), real(rotating, none), real(-1j * rotating, none),
        np.array([np.concatenate([contact.rotor, -contact.stator]) for contact in system.contacts]),
        *padded, np.concatenate([load.real, load.imag]), np.array([_surface(contact) for contact in system.contacts]),
        np.array([complex(contact.ring) for contact in system.contacts]),
    )  # fmt: skip


def _surface(contact):
    law = contact.law
    radius = 0.0 if law.diameter is None else 0.5 * law.diameter
    return [contact.gap, law.friction, law.stiffness, law.damping, radius, law.slip_velocity or 0.0, law.race_inertia or 0.0,
            law.race_drag or 0.0]  # fmt: skip


def prescribed(corners):
    """The Shaft of a speed: corners (k, 2) in s and rad/s."""
    none = np.zeros((1, 2))
    return Shaft(0.0, none, none, np.inf, np.asarray(corners, dtype=float))


def torque_of(inertia, torque, coast=None, trip=np.inf):
    """The Shaft of torques (k, 2) in Hz and N m."""
    tables = [np.asarray(table, dtype=float) * [2.0 * np.pi, 1.0] for table in (torque, torque if coast is None else coast)]
    return Shaft(float(inertia), *tables, float(trip), np.zeros((1, 2)))


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
def rates(m, shaft, t, y, out):
    """Write the rates of a state y = (phi, speed, races, q, v) at time t into out; returns what friction takes in N m."""
    n, c = m.rows.shape[1], len(m.rows)
    phi, speed, races, q, v = y[0], y[1], y[2 : 2 + c], y[2 + c : 2 + c + 2 * n], y[2 + c + 2 * n :]
    turn, taken = np.exp(1j * phi), 0.0
    stiffness = _between(m.knots, m.stiffness, speed) + speed * m.turning
    damping = _between(m.knots, m.damping, speed) + speed * m.gyroscopic + m.sliding
    right, u, euler = m.load - stiffness @ q - damping @ v, m.unbalance * turn, m.euler * turn
    right[:n] += speed**2 * u.real
    right[n:] += speed**2 * u.imag
    net = 0.0
    for i in range(c):
        own, ring = m.surfaces[i], m.ring[i] * turn
        d = complex(m.rows[i] @ q[:n], m.rows[i] @ q[n:]) + ring
        rate = complex(m.rows[i] @ v[:n], m.rows[i] @ v[n:]) + 1j * speed * ring
        force, rub, distance = 0j, 0.0, abs(d)
        if distance > own[GAP]:
            along = (rate * d.conjugate()).real / distance
            normal = max(own[K] * (distance - own[GAP]) + own[B] * min(along, 0.0), 0.0)
            slip = speed * own[RADIUS] + (rate * d.conjugate()).imag / distance - races[i] * (own[RADIUS] + own[GAP])
            rub = own[FRICTION] * normal * (min(max(slip / own[SLIP], -1.0), 1.0) if own[SLIP] > 0.0 else 1.0)
            force = complex(normal, rub) * d / distance
        right[:n] -= m.rows[i] * force.real
        right[n:] -= m.rows[i] * force.imag
        net -= rub * own[RADIUS] + (ring.conjugate() * force).imag
        taken += rub * own[RADIUS]
        drives = rub * (own[RADIUS] + own[GAP]) - own[DRAG] * races[i]
        out[2 + i] = drives / own[INERTIA] if own[INERTIA] > 0.0 else 0.0
    coupling = np.concatenate((-euler.imag, euler.real))
    if shaft.inertia > 0.0:
        table = shaft.torque if t < shaft.trip else shaft.coast
        slid = m.sliding @ v + speed * (m.turning @ q)
        net += np.interp(speed, table[:, 0], table[:, 1]) + q[:n] @ slid[n:] - q[n:] @ slid[:n]
        net += speed * ((euler - u).real @ v[:n] + (euler - u).imag @ v[n:])
        yields = m.inverse @ coupling
        rise = (net - yields @ right) / (shaft.inertia - coupling @ yields)
    else:
        i = min(max(np.searchsorted(shaft.corners[:, 0], t, side="right"), 1), len(shaft.corners) - 1)
        change = shaft.corners[i] - shaft.corners[i - 1]
        rise = change[1] / change[0]
    out[0], out[1], out[2 + c : 2 + c + 2 * n], out[2 + c + 2 * n :] = speed, rise, v, m.inverse @ (right - rise * coupling)
    return taken


@njit(error_model="numpy", cache=True)
def march(m, shaft, step, state, out):
    """Write [time, phi, speed, torque of friction, speeds of races, q, v] of every step into out (count, 4 + c + 4 n); how many
    there are until the shaft stands or all is lost. state: (phi, speed, races, q, v)."""
    y, slope, sums = state.copy(), np.zeros(len(state)), np.zeros(len(state))
    weights, shares = (1.0, 2.0, 2.0, 1.0), (0.0, 0.5, 0.5, 1.0)
    for i in range(len(out)):
        out[i, 0], out[i, 1:3], out[i, 4:] = i * step, y[:2], y[2:]
        sums[:] = 0.0
        for s in range(4):
            at = y + shares[s] * step * slope if s else y.copy()
            taken = rates(m, shaft, (i + shares[s]) * step, at, slope)
            if s == 0:
                out[i, 3] = taken
            sums += weights[s] * slope / 6.0
        if shaft.inertia > 0.0 and y[1] <= 0.0:
            return i + 1
        y += step * sums
        if not np.abs(y).max() < 1e12:
            return i + 1
    return len(out)


class Path(NamedTuple):
    """A run: time (n,) s, turns of the shaft, its speed in Hz, torque of friction N m; d (n, c) complex m; speeds of races (n, c)
    rad/s; q, v (n, 2 n_c); machine and last state."""

    machine: Machine
    time: np.ndarray
    turns: np.ndarray
    speed: np.ndarray
    torque: np.ndarray
    races: np.ndarray
    q: np.ndarray
    v: np.ndarray
    state: np.ndarray

    @property
    def d(self):
        """Deflections, complex m."""
        return self.along(self.q, self.machine.rows) + np.exp(2j * np.pi * self.turns)[:, None] * self.machine.ring

    def along(self, values, rows):
        """Places or velocities in the direction of rows (c, n), complex."""
        y, z = np.split(values, 2, axis=1)
        return y @ rows.T + 1j * (z @ rows.T)

    def mean(self, begin, end):
        """Mean speed in Hz between two times."""
        first, last = np.interp([begin, end], self.time, self.turns)
        return (last - first) / (end - begin)


def step_of(m, speed):
    """Length of a step of a Machine from a speed in Hz, s."""
    n = m.rows.shape[1]
    pressed = np.max(m.stiffness, axis=0)
    for row, own in zip(m.rows, m.surfaces, strict=True):
        block = own[K] * np.outer(row, row)
        pressed = pressed + np.block([[block, np.zeros((n, n))], [np.zeros((n, n)), block]])
    fastest = np.sqrt(np.abs(np.linalg.eigvals(m.inverse @ pressed)).max())
    return 2.0 * np.pi / STEPS / max(fastest, 2.0 * np.pi * speed)


def state_of(start, turns, speed, n_contacts):
    """A state of `march` from an InitialState, turns of the shaft and a speed in Hz."""
    places = np.concatenate([start.rotor, start.stator])
    moving = np.concatenate([start.rotor_velocity, start.stator_velocity])
    races = np.zeros(n_contacts) if start.races is None else np.asarray(start.races)
    parts = [part for own in (places, moving) for part in (own.real, own.imag)]
    return np.concatenate([[2.0 * np.pi * turns, 2.0 * np.pi * speed], races, *parts])


def run(m, shaft, state, duration, finer=1.0):
    """A Path from a state; `finer` times shorter steps, and still shorter ones where friction at small slip asks for them.
    TooStiff where these would be too many."""
    step = step_of(m, max(state[1], np.abs(shaft.corners[:, 1]).max()) / (2.0 * np.pi)) / finer
    path = _marched(m, shaft, step, state, duration)
    share = step * _creep(path)
    if share <= CREEP:
        return path
    if share / CREEP * duration / step > MOST_STEPS:
        raise TooStiff
    return _marched(m, shaft, step * CREEP / share, state, duration)


def _marched(m, shaft, step, state, duration):
    """A Path with steps of a length in s."""
    c, each = len(m.rows), 2 * m.rows.shape[1]
    out = np.zeros((int(duration / step) + 2, 4 + c + 2 * each))
    out = out[: march(m, shaft, step, np.asarray(state, dtype=float), out)]
    columns = np.split(out[:, 4:], [c, c + each], axis=1)
    state = np.concatenate([out[-1, 1:3], out[-1, 4:]])
    return Path(m, out[:, 0], out[:, 1] / (2.0 * np.pi), out[:, 2] / (2.0 * np.pi), out[:, 3], *columns, state)


def _creep(path):
    """The fastest rate in 1/s at which friction takes small slip away in a Path, by what it moves: the bodies and a race."""
    m, n, fastest = path.machine, path.machine.rows.shape[1], 0.0
    for d, row, own in zip(path.d.T, m.rows, m.surfaces, strict=True):
        force, light = own[K] * max(np.abs(d).max() - own[GAP], 0.0), float(row @ m.inverse[:n, :n] @ row)
        light += (own[RADIUS] + own[GAP]) ** 2 / own[INERTIA] if own[INERTIA] > 0.0 else 0.0
        fastest = max(fastest, own[FRICTION] * force / own[SLIP] * light if own[SLIP] > 0.0 else 0.0)
    return fastest


DISTURBED = 1e-4  # share of the velocities, and of the gap, by which runs from beside a start differ


def beside(state, machine, number):
    """A state of `march` beside another: its velocities changed by a small share, its places by a small part of the gap."""
    if not number:
        return state
    dice, c, each = np.random.default_rng(number), len(machine.rows), 2 * machine.rows.shape[1]
    changed = state.copy()
    changed[2 + c : 2 + c + each] += DISTURBED * machine.surfaces[:, GAP].min() * dice.normal(size=each)
    changed[2 + c + each :] *= 1.0 + DISTURBED * dice.normal(size=each)
    return changed


def release(system, start, turns, speed, table, duration, finer=1.0, number=0):
    """The Path of the third engine that starts in an InitialState.

    start, turns, speed : the state, turns of the shaft, and Hz; table : (k, 2) torque in N m over Hz; duration : s
    finer : steps are shorter by this factor; number : 0, or the seed of a small disturbance of the start
    """
    m = machine_of(system)
    radii = m.surfaces[:, RADIUS] + m.surfaces[:, GAP]  # InitialState has the speeds of surfaces
    state = state_of(start, turns, speed, len(m.rows))
    state[2 : 2 + len(radii)] /= np.where(radii > 0.0, radii, 1.0)
    return run(m, torque_of(system.drive.inertia, table), beside(state, m, number), duration, finer)
