"""A finite-element machine in magnetic bearings, its closed loop of all coordinates by NumPy and SciPy alone."""

import numpy as np
from scipy.integrate import solve_ivp

TWO_PI = 2.0 * np.pi


class FullLoop:
    """The unreduced machine in its magnetic bearings at a rotor speed in Hz: one first-order equation of [r, r', a, q, u, ...].

    model : FiniteElementModel without magnetic bearings; bearings : (row of the actuator, row of the sensor, keys), all with an
    integral and a derivative, in SI; failed : numbers of those that exert no force any more
    """

    def __init__(self, model, bearings, speed, failed=()):
        model = model.at_speed(speed)
        n, p = model.n, 3 * len(bearings)
        self.n, self.Omega, self.mass = n, TWO_PI * speed, model.mass
        stiffness = model.stiffness.astype(complex)
        if model.skew_stiffness is not None:
            stiffness = stiffness + 1j * model.skew_stiffness
        damping = model.damping - 1j * self.Omega * model.gyroscopic
        force, own = np.zeros((n, p)), np.zeros((p, 2 * n + p))
        for i, (actuator, sensor, keys) in enumerate(bearings):
            a, q, u = 3 * i, 3 * i + 1, 3 * i + 2
            corner, lag = keys["derivative_filter"], TWO_PI * keys["amplifier"]
            if i not in failed:
                stiffness -= keys["negative_stiffness"] * np.outer(actuator, actuator)
                force[:, u] -= actuator
            own[a, :n], own[a, 2 * n + a] = corner * sensor, -corner
            own[q, :n] = sensor
            own[u, :n] = lag * (keys["proportional"] + keys["derivative"] * corner) * sensor
            own[u, 2 * n + a] = -lag * keys["derivative"] * corner
            own[u, 2 * n + q], own[u, 2 * n + u] = lag * keys["integral"], -lag
        self.matrix = np.zeros((2 * n + p,) * 2, complex)
        self.matrix[:n, n : 2 * n] = np.eye(n)
        self.matrix[n : 2 * n] = np.linalg.solve(model.mass, np.hstack([-stiffness, -damping, force]))
        self.matrix[2 * n :] = own

    def eigenvalues(self):
        """1/s and rad/s."""
        return np.linalg.eigvals(self.matrix)

    def receptance(self, row, Psi):
        """m/N of the place with this row, at frequencies in rad/s, in the closed loop."""
        push = np.zeros(len(self.matrix), complex)
        push[self.n : 2 * self.n] = np.linalg.solve(self.mass, row)
        one = np.eye(len(self.matrix))
        return np.array([row @ np.linalg.solve(1j * w * one - self.matrix, push)[: self.n] for w in np.atleast_1d(Psi)])

    def levitated(self, unbalance, load):
        """[r, r', z] at time 0 of the steady motion without contact, from (n,) kg m and N."""
        still, turning = (np.zeros(len(self.matrix), complex) for _ in range(2))
        still[self.n : 2 * self.n] = np.linalg.solve(self.mass, load)
        turning[self.n : 2 * self.n] = np.linalg.solve(self.mass, unbalance * self.Omega**2)
        once = 1j * self.Omega * np.eye(len(self.matrix)) - self.matrix
        return np.linalg.solve(once, turning) - np.linalg.solve(self.matrix, still)

    def motion(self, imposed, contact, times, state):
        """Displacements (times, n) with contact at one place against a spring-mounted mass, from a state at times[0].

        imposed : (unbalance (n,) kg m, load (n,) N); contact : row, gap, stiffness, friction, slip_velocity, diameter, and the
        stator's mass, spring and damper; state : [r, r', z, s, s'], complex
        """
        inverse, n = np.linalg.inv(self.mass), self.n
        unbalance, load = inverse @ imposed[0], inverse @ imposed[1]
        pushed = inverse @ contact["row"]

        def rates(t, y):
            w, s, s_dot = y[:-2], y[-2], y[-1]
            rate = self.matrix @ w
            rate[n : 2 * n] += unbalance * self.Omega**2 * np.exp(1j * self.Omega * t) + load
            apart, moving = contact["row"] @ w[:n] - s, contact["row"] @ w[n : 2 * n] - s_dot
            distance, force = abs(apart), 0j
            if distance > contact["gap"]:
                out = apart / distance
                slip = self.Omega * contact["diameter"] / 2.0 + (moving * out.conjugate()).imag
                sliding = contact["friction"] * np.clip(slip / contact["slip_velocity"], -1.0, 1.0)
                force = contact["stiffness"] * (distance - contact["gap"]) * out * (1.0 + 1j * sliding)
            rate[n : 2 * n] -= pushed * force
            carried = (force - contact["spring"] * s - contact["damper"] * s_dot) / contact["mass"]
            return np.concatenate([rate, [s_dot, carried]])

        return solve_ivp(rates, (times[0], times[-1]), state, "DOP853", times, rtol=1e-9, atol=1e-13).y[:n].T


class Drop:
    """The unreduced machine in its magnetic bearings, which fail one after the other, above auxiliary bearings.

    loops : FullLoop of each part of the run; ends : s, of each part; imposed : (unbalance (n,) kg m, load (n,) N)
    rows : (c, n) of the contacts, each with a mass, spring and damper of its own and the law of one of them: gap, stiffness,
    damping, friction, diameter, slip_velocity
    """

    def __init__(self, loops, ends, imposed, rows, law, held):
        self.loops, self.ends, self.rows, self.law, self.held = loops, ends, rows, law, held
        inverse = np.linalg.inv(loops[0].mass)
        self.n, self.Omega = loops[0].n, loops[0].Omega
        self.unbalance, self.load, self.pushed = inverse @ imposed[0] * self.Omega**2, inverse @ imposed[1], inverse @ rows.T
        self.start = loops[0].levitated(*imposed)

    def apart(self, y):
        """(..., c) complex m, of rotor and stator at the contacts, from states [r, r', z, s, s']."""
        c = len(self.rows)
        return y[..., : self.n] @ self.rows.T - y[..., -2 * c : -c]

    def forces(self, y):
        """(c,) complex N on the stator."""
        law, n, c = self.law, self.n, len(self.rows)
        d, moving = self.apart(y), self.rows @ y[n : 2 * n] - y[-c:]
        out = d / np.maximum(np.abs(d), 1e-30)
        depth, closing = np.abs(d) - law["gap"], (moving * out.conj()).real
        normal = np.where(depth > 0.0, np.maximum(law["stiffness"] * depth + law["damping"] * np.minimum(closing, 0.0), 0.0), 0.0)
        slip = self.Omega * law["diameter"] / 2.0 + (moving * out.conj()).imag
        return normal * out * (1.0 + 1j * law["friction"] * np.clip(slip / law["slip_velocity"], -1.0, 1.0))

    def rates(self, t, y, matrix):
        n, c = self.n, len(self.rows)
        force, s, s_dot = self.forces(y), y[-2 * c : -c], y[-c:]
        rate = matrix @ y[: -2 * c]
        rate[n : 2 * n] += self.unbalance * np.exp(1j * self.Omega * t) + self.load - self.pushed @ force
        carried = (force - self.held["stiffness"] * s - self.held["damping"] * s_dot) / self.held["mass"]
        return np.concatenate([rate, s_dot, carried])

    def motion(self, times):
        """Rotor less stator at the contacts (times, c), and the times at which each of them closes; from the levitated motion."""
        c = len(self.rows)
        events = [lambda t, y, matrix, i=i: np.abs(self.apart(y)[i]) - self.law["gap"] for i in range(c)]
        for event in events:
            event.direction = 1.0
        y = np.concatenate([self.start, np.zeros(2 * c)])
        seen, closed, begin = [], [[] for _ in range(c)], 0.0
        for loop, end in zip(self.loops, self.ends, strict=True):
            inside = times[(times >= begin) & ((times < end) | (end == self.ends[-1]))]
            part = solve_ivp(self.rates, (begin, end), y, "DOP853", np.union1d(inside, end), events=events, args=(loop.matrix,),
                             rtol=1e-10, atol=1e-14)  # fmt: skip
            seen.append(part.y[:, : len(inside)].T)
            for own, new in zip(closed, part.t_events, strict=True):
                own.extend(new)
            begin, y = end, part.y[:, -1]
        return self.apart(np.concatenate(seen)), closed
