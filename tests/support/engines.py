"""Two engines that share nothing with the kernel: an extrapolated midpoint rule in extended precision, and scipy's Radau.

Both follow the modes of the pseudolinear contact of physics.md (4)-(11) by switch functions of their own: inside a mode the
equations are smooth, and a mode ends at a root of a function that is positive inside it.
"""

import numpy as np
from scipy.integrate import solve_ivp

OPEN, PRESSING, SEPARATING, CLIPPED = "open", "pressing", "separating", "clipped"
FORWARD, CREEPING, BACKWARD = "forward", "creeping", "backward"


class Rub:
    """Equations of motion of a System (one straight piece of speed schedule) in a precision; state y = [r, s, r', s']."""

    def __init__(self, system, real=np.float64, kind=np.complex128):
        self.system, self.real = system, real
        n, m = system.n_rotor, system.n_stator
        self.n, self.m, self.size = n, m, n + m
        block = np.zeros((5, n + m, n + m))
        for i, name in enumerate(("mass", "damping", "stiffness")):
            block[i, :n, :n], block[i, n:, n:] = (getattr(body, name) for body in system.bodies)
        mass, damping, stiffness = (b.astype(real) for b in block[:3])
        gyroscopic = np.zeros((n + m, n + m), real)
        gyroscopic[:n, :n] = system.rotor.gyroscopic
        inverse = _inverse(mass)
        self.damping, self.stiffness, self.gyroscopic = inverse @ damping, inverse @ stiffness, inverse @ gyroscopic
        rotor = inverse[:, :n].astype(kind)
        forced = system.rotor
        self.imposed = [rotor @ np.asarray(v, kind) for v in (forced.unbalance, forced.unbalance_euler, forced.load)]
        self.relative = np.concatenate([system.rotor.contact, -system.stator.contact]).astype(real)
        self.push = inverse @ self.relative
        two_pi = 8 * np.arctan(real(1))
        speed = np.array(system.schedule_speed, real) / real(2 * np.pi) * two_pi
        self.speed, self.rise = speed[0], (speed[1] - speed[0]) / real(system.schedule_time[1])

    def contact(self, t, y):
        """(d, |d|, p, p', v_rel, Omega, e^{i phi}) of a state."""
        omega = self.speed + self.rise * t
        phi = self.speed * t + self.rise * t * t / 2
        turn = np.cos(phi) + 1j * np.sin(phi)
        ring = self.system.contact.ring * turn
        d = self.relative @ y[: self.size] + ring
        d_dot = self.relative @ y[self.size :] + 1j * omega * ring
        distance = abs(d)
        along = d_dot * d.conjugate() / distance
        radius = 0.0 if self.system.law.diameter is None else self.system.law.diameter / 2
        return d, distance, distance - self.system.contact.gap, along.real, omega * radius + along.imag, omega, turn

    def rate(self, t, y, mode):
        """y' inside a mode."""
        d, distance, p, p_dot, slip, omega, turn = self.contact(t, y)
        normal, friction = mode
        force = self.system.law.stiffness * p if normal in (PRESSING, SEPARATING) else 0 * p
        if normal == SEPARATING:
            force = force + self.system.law.damping * p_dot
        sigma = {FORWARD: 1, BACKWARD: -1}.get(friction)
        if sigma is None:
            sigma = slip / self.system.law.slip_velocity
        unbalance, euler, load = self.imposed
        acceleration = (unbalance * omega**2 - 1j * euler * self.rise) * turn + load
        acceleration = acceleration - self.damping @ y[self.size :] + 1j * omega * (self.gyroscopic @ y[self.size :])
        acceleration = acceleration - self.stiffness @ y[: self.size]
        acceleration = acceleration - self.push * ((1 + 1j * self.system.law.friction * sigma) * force * d / distance)
        return np.concatenate([y[self.size :], acceleration])

    def exits(self, mode):
        """[(function of (t, y), next mode)], each positive inside the mode."""
        normal, friction = mode
        k, b = self.system.law.stiffness, self.system.law.damping

        def part(i, scale=1):
            return lambda t, y: scale * self.contact(t, y)[i]

        def force(t, y):
            _, _, p, p_dot, *_ = self.contact(t, y)
            return k * p + b * p_dot

        if normal == OPEN:
            return [(part(2, -1), (PRESSING, None))]
        if normal == PRESSING:
            found = [(part(3), (SEPARATING, friction))] if b > 0 else [(part(2), (OPEN, FORWARD))]
        elif normal == SEPARATING:
            found = [(part(3, -1), (PRESSING, friction)), (force, (CLIPPED, friction))]
        else:
            found = [(part(2), (OPEN, FORWARD)), (lambda t, y: -force(t, y), (SEPARATING, friction))]
        return found + self._slides(normal, friction)

    def _slides(self, normal, friction):
        if self.system.law.diameter is None:
            return []
        width = self.system.law.slip_velocity

        def above(sign, edge):
            return lambda t, y: sign * (self.contact(t, y)[4] - edge)

        if friction == CREEPING:
            return [(above(-1, width), (normal, FORWARD)), (above(1, -width), (normal, BACKWARD))]
        return [(above(1, width) if friction == FORWARD else above(-1, -width), (normal, CREEPING))]

    def mode_at(self, t, y, wish=None):
        """Mode of a state; a wish (normal, None) only lacks its friction."""
        _, _, p, p_dot, slip, *_ = self.contact(t, y)
        friction = FORWARD
        if self.system.law.diameter is not None and abs(slip) < self.system.law.slip_velocity:
            friction = CREEPING
        elif self.system.law.diameter is not None and slip < 0:
            friction = BACKWARD
        if wish is not None:
            return (wish[0], friction if wish[1] is None else wish[1])
        if p <= 0:
            return OPEN, friction
        if p_dot >= 0 or self.system.law.damping == 0:
            return PRESSING, friction
        force = self.system.law.stiffness * p + self.system.law.damping * p_dot
        return SEPARATING if force >= 0 else CLIPPED, friction


def _inverse(mass):
    """Inverse in any precision: Newton's iteration from the double one."""
    x = np.linalg.inv(np.asarray(mass, float)).astype(mass.dtype)
    for _ in range(2):
        x = x @ (2 * np.eye(len(mass), dtype=mass.dtype) - mass @ x)
    return x


def extrapolated(f, t, y, h, columns=7):
    """One step of Gragg's method: midpoint rules of 2, 4, 6, ... substeps extrapolated in h^2 to order 2 * columns."""
    table, first = [], f(t, y)
    for j in range(columns):
        steps = 2 * (j + 1)
        tau = h / steps
        before, now = y, y + tau * first
        for i in range(1, steps):
            before, now = now, before + 2 * tau * f(t + i * tau, now)
        row = [(now + before + tau * f(t + h, now)) / 2]
        for k in range(j):
            ratio = ((j + 1) / y.real.dtype.type(j - k)) ** 2
            row.append(row[k] + (row[k] - table[k]) / (ratio - 1))
        table = row
    return table[-1]


def by_extrapolation(system, start, times, h_max=2e-4):
    """(rotor, stator) at the times in extended precision, and the number of switches."""
    rub = Rub(system, np.longdouble, np.clongdouble)
    y = np.concatenate([start.rotor, start.stator, start.rotor_velocity, start.stator_velocity]).astype(np.clongdouble)
    t, mode, rows, switches = np.longdouble(0), rub.mode_at(0.0, y), [y], 0
    for goal in np.asarray(times[1:], np.longdouble):
        while t < goal:
            h = min(np.longdouble(h_max), goal - t)
            new, left, entered = _step_to_switch(rub, t, y, mode, h)
            t, y = (goal if left == goal - t else t + left), new
            if entered is not None:
                mode, switches = rub.mode_at(t, y, entered), switches + 1
        rows.append(y)
    rows = np.array(rows).astype(complex)
    return rows[:, : rub.n], rows[:, rub.n : rub.size], switches


def _step_to_switch(rub, t, y, mode, h):
    """(state, length, mode entered or None) of a step that ends at h or at the first switch (by regula falsi on whole steps)."""

    def ahead(length):
        return extrapolated(lambda t_, y_: rub.rate(t_, y_, mode), t, y, length)

    new, entered, length = ahead(h), None, h
    for exits, after in rub.exits(mode):
        if exits(t + length, new) >= 0:
            continue
        a, b = np.longdouble(0), length
        g_a, g_b = max(exits(t, y), np.longdouble(0)), exits(t + length, new)
        for _ in range(60):
            middle = b - g_b * (b - a) / (g_b - g_a)
            at = ahead(middle)
            g = exits(t + middle, at)
            if abs(g) <= 1e-17 * abs(g_b - g_a) or b - a < 1e-19:
                break
            if g > 0:
                a, g_a, g_b = middle, g, g_b / 2
            else:
                b, g_b, g_a = middle, g, g_a / 2
        new, entered, length = at, after, middle
    return new, length, entered


def by_radau(system, start, times, rtol=1e-10):
    """(rotor, stator) at the times by scipy's Radau, restarted at each switch it locates; and the number of switches."""
    rub = Rub(system)
    y = np.concatenate([start.rotor, start.stator, start.rotor_velocity, start.stator_velocity]).astype(complex)
    half = len(y)

    def joined(u):
        return u[:half] + 1j * u[half:]

    t, u, rows, switches = 0.0, np.concatenate([y.real, y.imag]), [], 0
    mode = rub.mode_at(t, y)
    atol = rtol * system.contact.gap * np.tile(np.repeat([1e-2, 1.0], half // 2), 2)
    while t < times[-1]:
        events, afters = [], []
        for exits, after in rub.exits(mode):
            events.append(_event(exits, joined))
            afters.append(after)

        def rate(t_, u_, mode=mode):
            moved = rub.rate(t_, joined(u_), mode)
            return np.concatenate([moved.real, moved.imag])

        wanted = times[(times >= t) & (times <= times[-1])]
        piece = solve_ivp(rate, (t, times[-1]), u, "Radau", wanted, events=events, rtol=rtol, atol=atol, max_step=1e-3)
        rows += [*np.reshape(piece.y, (2 * half, -1)).T]  # an empty list where no time is wanted
        if piece.status != 1:
            break
        hit = min((e[0], i) for i, e in enumerate(piece.t_events) if len(e))
        t, u = hit[0], piece.y_events[hit[1]][0]
        mode, switches = rub.mode_at(t, joined(u), afters[hit[1]]), switches + 1
    rows = np.array([joined(row) for row in rows])
    return rows[:, : rub.n], rows[:, rub.n : rub.size], switches


def _event(exits, joined):
    def event(t, u):
        return exits(t, joined(u))

    event.terminal, event.direction = True, -1
    return event
