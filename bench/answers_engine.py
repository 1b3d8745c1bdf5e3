"""The second engine of bench/answers.py: a textbook Dormand-Prince 5(4) pair on docs/users/physics.md section 2, in physical
coordinates, complex, with no knowledge of contact switches. It lands on every sample of a grid that resolves the contact, so that
its steps meet a kink at most a twentieth of a contact period late, and nothing is interpolated. It shares no line with rsc."""

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.integrate import RK45

from answers_limits import JudgeTooLong

RTOL = 1e-8
SAMPLES = 24.0  # a contact period
MOST_SAMPLES, MOST_STEPS = 1_500_000, 20_000_000  # of one march; no signal interrupts compiled code
LOST, FAR = 1e8, 1e5  # gaps: a run stops, and has diverged
A, B, C, E = np.zeros((7, 6)), RK45.B, np.append(RK45.C, 1.0), RK45.E
A[:6, :5], A[6] = RK45.A, B


class Machine(NamedTuple):
    """Matrices of u = [r, s] divided by the masses, complex; vectors; constants of the contact; what acts on the conjugate."""

    stiffness: np.ndarray
    damping: np.ndarray
    gyroscopic: np.ndarray
    stiffness_conj: np.ndarray
    damping_conj: np.ndarray
    unequal: bool
    row: np.ndarray  # d = row . u + ring
    push: np.ndarray  # accelerations by a unit contact force
    unbalance: np.ndarray
    euler: np.ndarray
    load: np.ndarray
    gap: float
    friction: float
    k: float
    b: float
    radius: float  # m; negative: friction of one side
    slip: float
    ring: complex
    n_rotor: int

    @property
    def contact_rate(self):
        """rad/s, of the contact spring between the two bodies as free masses."""
        return float(np.sqrt(self.k * abs(self.row @ self.push)))


class Drive(NamedTuple):
    """Speed in rad/s, linear between corners in s, and the angle of the shaft at each corner, rad."""

    time: np.ndarray
    speed: np.ndarray
    angle: np.ndarray

    @classmethod
    def of(cls, time, speed, angle=0.0):
        """From corners."""
        time, speed = np.array(time, dtype=float), np.array(speed, dtype=float)
        return cls(time, speed, np.concatenate([[angle], angle + np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))]))

    def angle_at(self, t):
        """Angle of the shaft, rad, at times (n,)."""
        i = np.clip(np.searchsorted(self.time, t, side="right") - 1, 0, len(self.time) - 2)
        speed = np.interp(t, self.time, self.speed)
        return self.angle[i] + 0.5 * (self.speed[i] + speed) * (t - self.time[i])


def machine_of(system):
    """The Machine of a rsc.system.System."""
    n, m, rotor, law = system.n_rotor, system.n_stator, system.rotor, system.law
    side = n + m
    inverse = np.zeros((side, side))
    inverse[:n, :n] = np.linalg.inv(system.rotor.mass)
    if m:
        inverse[n:, n:] = np.linalg.inv(system.stator.mass)

    def of_both(name, factor=1.0):
        whole = np.zeros((side, side), complex)
        for body, place in zip(system.bodies, (slice(0, n), slice(n, side)), strict=True):
            own = getattr(body, name)
            if own is not None and len(own):
                whole[place, place] = factor * own
        return inverse @ whole

    row = np.concatenate([system.rotor.contact, -system.stator.contact])
    vectors = (inverse[:, :n] @ vector.astype(complex) for vector in (rotor.unbalance, rotor.unbalance_euler, rotor.load))
    conjugate = of_both("anisotropic_stiffness"), of_both("anisotropic_damping")
    return Machine(
        of_both("stiffness") + of_both("skew_stiffness", 1j), of_both("damping") + of_both("skew_damping", 1j),
        of_both("gyroscopic"), *conjugate, bool(np.any(conjugate)), row, inverse @ row, *vectors,
        system.contact.gap, law.friction, law.stiffness, law.damping,
        -1.0 if law.diameter is None else 0.5 * law.diameter, law.slip_velocity or 1.0, complex(system.contact.ring), n,
    )  # fmt: skip


@njit(error_model="numpy", cache=True)
def shaft(drive, t):
    """(angle, speed, acceleration) of the shaft."""
    i = 0
    while i < len(drive.time) - 2 and t >= drive.time[i + 1]:
        i += 1
    slope = (drive.speed[i + 1] - drive.speed[i]) / (drive.time[i + 1] - drive.time[i])
    after = t - drive.time[i]
    return drive.angle[i] + drive.speed[i] * after + 0.5 * slope * after * after, drive.speed[i] + slope * after, slope


@njit(error_model="numpy", cache=True)
def contact_force(m, d, v, speed):
    """Force of the stator on the rotor, turned round: F_C = F_N (1 + i mu sigma) d/|d|, from d and its rate v."""
    distance = abs(d)
    if distance <= m.gap:
        return 0j
    along = (v * d.conjugate()).real / distance
    normal = m.k * (distance - m.gap) + (m.b * along if along < 0.0 else 0.0)
    if normal <= 0.0:
        return 0j
    sigma = 1.0
    if m.radius >= 0.0:
        slip = speed * m.radius + (v * d.conjugate()).imag / distance
        sigma = min(max(slip / m.slip, -1.0), 1.0)
    return normal * complex(1.0, m.friction * sigma) * d / distance


@njit(error_model="numpy", cache=True)
def accelerations(m, drive, t, x, v, out):
    """out (n,) = u'' at a time."""
    n = len(x)
    phi, speed, rise = shaft(drive, t)
    turn = complex(np.cos(phi), np.sin(phi))
    d, rate = m.ring * turn, 1j * speed * m.ring * turn
    for i in range(n):
        d += m.row[i] * x[i]
        rate += m.row[i] * v[i]
    force = contact_force(m, d, rate, speed)
    for i in range(n):
        a = (m.unbalance[i] * speed * speed - 1j * rise * m.euler[i]) * turn + m.load[i] - m.push[i] * force
        for j in range(n):
            a -= m.stiffness[i, j] * x[j] + (m.damping[i, j] - 1j * speed * m.gyroscopic[i, j]) * v[j]
        if m.unequal:
            for j in range(n):
                a -= m.stiffness_conj[i, j] * x[j].conjugate() + m.damping_conj[i, j] * v[j].conjugate()
        out[i] = a


@njit(error_model="numpy", cache=True)
def _sample(m, x, v, out):
    """out (4,) = r, s, r', s' at the contact."""
    out[:] = 0j
    for i in range(len(x)):
        body, sign = (0, 1.0) if i < m.n_rotor else (1, -1.0)
        out[body] += sign * m.row[i] * x[i]
        out[2 + body] += sign * m.row[i] * v[i]


@njit(error_model="numpy", cache=True)
def march(m, drive, interval, x, v, scale, rtol, out):
    """Samples (n, 4) of r, s, r', s' at the contact, the first at time 0; x and v become the last state. Number of samples that
    are finite and not LOST gaps away; -1 where it takes more than MOST_STEPS steps."""
    n, tries = len(x), 0
    kx, kv = np.empty((7, n), np.complex128), np.empty((7, n), np.complex128)
    xs, vs = np.empty(n, np.complex128), np.empty(n, np.complex128)
    t, h = 0.0, interval
    for row in range(out.shape[0]):
        goal = row * interval
        accelerations(m, drive, t, x, v, kv[0])
        while t < goal - 1e-9 * interval:
            tries += 1
            if tries > MOST_STEPS:
                return -1
            last = h >= goal - t
            step = goal - t if last else h
            kx[0] = v
            for s in range(1, 7):
                for i in range(n):
                    dx, dv = 0j, 0j
                    for j in range(s):
                        dx += A[s, j] * kx[j, i]
                        dv += A[s, j] * kv[j, i]
                    xs[i], vs[i] = x[i] + step * dx, v[i] + step * dv
                kx[s] = vs
                accelerations(m, drive, t + C[s] * step, xs, vs, kv[s])
            worst = 0.0
            for i in range(n):
                ex, ev = 0j, 0j
                for j in range(7):
                    ex += E[j] * kx[j, i]
                    ev += E[j] * kv[j, i]
                worst = max(worst, step * abs(ex) / (rtol * (scale[0, i] + abs(xs[i]))))
                worst = max(worst, step * abs(ev) / (rtol * (scale[1, i] + abs(vs[i]))))
            if worst <= 1.0:
                t = goal if last else t + step
                x[:], v[:], kv[0] = xs, vs, kv[6]
            elif not worst < 1e300 or step < 1e-9 * interval:
                return row
            grown = step * min(4.0, max(0.2, 0.9 * worst**-0.2)) if worst > 0.0 else 4.0 * step
            h = max(grown, h) if worst <= 1.0 and last else grown
            h = min(h, interval)
        _sample(m, x, v, out[row])
        if not abs(out[row, 0] - out[row, 1]) < LOST * m.gap:
            return row
    return out.shape[0]


class State(NamedTuple):
    """Displacements and rates of all coordinates, and the angle of the shaft."""

    x: np.ndarray
    v: np.ndarray
    angle: float = 0.0

    @classmethod
    def of(cls, start, angle=0.0):
        """From displacements and velocities of rotor and stator."""
        parts = ((start.rotor, start.stator), (start.rotor_velocity, start.stator_velocity))
        return cls(*(np.concatenate(part).astype(complex) for part in parts), angle)

    def beside(self, dice, share):
        """A state whose numbers are changed by about a share of each."""
        changes = [1.0 + share * (dice.normal(size=len(self.x)) + 1j * dice.normal(size=len(self.x))) for _ in range(2)]
        return self._replace(x=self.x * changes[0], v=self.v * changes[1])


class Samples(NamedTuple):
    """Samples of the motion at the contact, arrays (n,), and the machine and drive that made them.

    time s; rotor, stator, rotor_rate, stator_rate complex; state : State at the end; diverged : bool
    surface : m/s, speed of the surface of an inner race
    """

    machine: Machine
    drive: Drive
    time: np.ndarray
    rotor: np.ndarray
    stator: np.ndarray
    rotor_rate: np.ndarray
    stator_rate: np.ndarray
    state: State
    diverged: bool
    surface: np.ndarray | float = 0.0


def integrate(machine, drive, state, duration, finer=1.0):
    """Samples of a run from a state; finer: samples and tolerance so many times closer."""
    interval = 2.0 * np.pi / machine.contact_rate / SAMPLES / finer
    count = int(np.ceil(duration / interval)) + 1
    count = min(max(count, 400), int(MOST_SAMPLES * finer))
    out, x, v = np.empty((count, 4), complex), state.x.copy(), state.v.copy()
    interval = duration / (count - 1)
    scale = machine.gap * np.repeat([[1.0], [machine.contact_rate]], len(x), axis=1)
    # a coordinate may be an angle: then the gap is no scale of it, but its part of the contact's motion is
    scale *= np.maximum(abs(machine.push) / abs(machine.push).max(), 1e-6)
    done = march(machine, drive, interval, x, v, scale, RTOL / finer, out)
    if done < 0:
        raise JudgeTooLong
    time = interval * np.arange(done)
    end = State(x, v, float(drive.angle_at(np.array([time[-1]]))[0])) if done else state
    r, s = out[:done, :2].T
    far = done and max(abs(r - s).max(), abs(r).max()) > FAR * machine.gap  # a soft stator may go with the rotor
    return Samples(machine, drive, time, *np.ascontiguousarray(out[:done].T), end, bool(done < count or far))


def at_speed(speed, duration, angle=0.0):
    """The Drive of a constant speed in rad/s."""
    return Drive.of([0.0, duration], [speed, speed], angle)
