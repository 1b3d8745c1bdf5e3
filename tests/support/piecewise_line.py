"""Exact motion on one line between two walls, mu = 0: the equations are piecewise linear (nothing of rsc is imported here).

Inside a mode of the contact (no contact; pressing; separating with the damper acting; separating and clipped at zero force) the
state y = (x_R, [x_S], v_R, [v_S]) obeys y' = A y + b and is written down by the eigenvalues of A; a mode ends at a root of a
linear function of y. Forty digits; the earliest root is found on a fine grid in doubles and refined to all digits.
"""

import mpmath as mp
import numpy as np

DIGITS = 40
OPEN, PRESSING, SEPARATING, CLIPPED = "open", "pressing", "separating", "clipped"


class Line:
    """rotor and stator = (mass, damping, stiffness), stator None for a rigid wall; contact = (gap, stiffness, damping)."""

    def __init__(self, rotor, stator, contact, load=0.0):
        self.bodies = [rotor] if stator is None else [rotor, stator]
        self.gap, self.k, self.b = (mp.mpf(v) for v in contact)
        self.load, self.flows = mp.mpf(load), {}

    def flow(self, kind, side):
        """Eigen-solution of one mode: (rates, modes, inverse modes, rest state)."""
        if (kind, side) not in self.flows:
            n = len(self.bodies)
            rate, push = mp.zeros(2 * n), mp.zeros(2 * n, 1)
            stiff = self.k if kind in (PRESSING, SEPARATING) else mp.mpf(0)
            damp = self.b if kind == SEPARATING else mp.mpf(0)
            for i, body in enumerate(self.bodies):
                mass, damping, stiffness = (mp.mpf(v) for v in body)
                rate[i, n + i] = 1
                rate[n + i, i], rate[n + i, n + i] = -stiffness / mass, -damping / mass
                sign = mp.mpf(1 - 2 * i)
                for j in range(n):  # d = x_R - x_S
                    rate[n + i, j] -= sign * (1 - 2 * j) * stiff / mass
                    rate[n + i, n + j] -= sign * (1 - 2 * j) * damp / mass
                push[n + i] = sign * stiff * side * self.gap / mass + (self.load / mass if i == 0 else 0)
            values, modes = mp.eig(rate)
            self.flows[kind, side] = values, modes, modes**-1, mp.lu_solve(rate, -push)
        return self.flows[kind, side]

    def exits(self, kind, side):
        """Functions (row, constant, next kind) of the state, positive inside the mode."""
        n = len(self.bodies)
        d = np.array([1.0, -1.0][:n])
        p, p_dot = side * np.concatenate([d, 0 * d]), side * np.concatenate([0 * d, d])
        gap = self.gap
        if kind == OPEN:
            return [(-p, gap, PRESSING)]
        if kind == PRESSING:
            return [(p_dot, 0, SEPARATING)] if self.b > 0 else [(p, -gap, OPEN)]
        force = self.k * mp.matrix(p) + self.b * mp.matrix(p_dot), -self.k * gap
        if kind == SEPARATING:
            return [(-p_dot, 0, PRESSING), (*force, CLIPPED)]
        return [(p, -gap, OPEN), (-force[0], -force[1], SEPARATING)]

    def march(self, start, times):
        """States at the times (sorted, from 0), shape (n_time, 2n), and the switches as (time, mode left, mode entered)."""
        with mp.workdps(DIGITS):
            now, state, kind, side = mp.mpf(0), mp.matrix([mp.mpf(v) for v in start]), OPEN, 1
            rows, switches, k = [], [], 0
            end = mp.mpf(times[-1])
            while k < len(times):
                motion = Motion(self.flow(kind, side), state)
                length, kind_new, side_new = self._next_switch(motion, kind, side, end - now)
                while k < len(times) and mp.mpf(times[k]) - now <= length:
                    rows.append([float(v) for v in motion.at(mp.mpf(times[k]) - now)])
                    k += 1
                if kind_new is not None:
                    state, now = mp.matrix(motion.at(length)), now + length
                    switches.append((float(now), kind, kind_new))
                    kind, side = kind_new, side_new
            return np.array(rows), switches

    def _next_switch(self, motion, kind, side, left):
        grid = np.arange(1, 20_001) * float(mp.mpf(1) / (200 * motion.fastest))
        grid = np.append(grid[grid < float(left)], float(left))
        sides = (1, -1) if kind == OPEN else (side,)
        found = []
        for s in sides:
            for row, constant, after in self.exits(kind, s):
                row = mp.matrix(row)
                negative = np.flatnonzero(motion.seen(row, constant, grid) < 0.0)
                if negative.size:
                    i = negative[0]
                    assert i > 0, "a switch within the first grid step: refine the grid"
                    bracket = mp.mpf(grid[i - 1]), mp.mpf(grid[i])
                    root = mp.findroot(
                        lambda t, r=row, c=constant: motion.value(r, c, t), bracket, solver="anderson", tol=1e-60
                    )
                    found.append((root, after, s))
        return min(found, key=lambda f: f[0]) if found else (left, None, side)


class Motion:
    """The solution inside one mode from a state on."""

    def __init__(self, flow, state):
        self.rates, self.modes, inverse, self.rest = flow
        self.parts = inverse * (state - self.rest)
        self.fastest = max(abs(v) for v in self.rates)

    def at(self, t):
        """Real state at time t after the start of the mode."""
        parts = mp.matrix([mp.exp(rate * t) * part for rate, part in zip(self.rates, self.parts, strict=True)])
        return [mp.re(v) for v in self.modes * parts + self.rest]

    def value(self, row, constant, t):
        """row . state(t) + constant."""
        return mp.fsum(a * b for a, b in zip(row, self.at(t), strict=True)) + constant

    def seen(self, row, constant, grid):
        """The same on a grid in doubles."""
        size = range(len(row))
        weights = [complex(mp.fsum(row[i] * self.modes[i, j] for i in size) * self.parts[j]) for j in size]
        shift = float(mp.fsum(a * b for a, b in zip(row, self.rest, strict=True)) + constant)
        return sum((w * np.exp(complex(r) * grid)).real for w, r in zip(weights, self.rates, strict=True)) + shift
