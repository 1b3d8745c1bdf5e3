"""A finite-element machine in magnetic bearings, its closed loop of all coordinates by NumPy and SciPy alone."""

import numpy as np
from scipy.integrate import solve_ivp

TWO_PI = 2.0 * np.pi


class FullLoop:
    """The unreduced machine in its magnetic bearings at a rotor speed in Hz: one first-order equation of [r, r', a, q, u, ...].

    model : FiniteElementModel without magnetic bearings; bearings : (row of the actuator, row of the sensor, keys), all with an
    integral and a derivative, in SI
    """

    def __init__(self, model, bearings, speed):
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
