"""heyoka: Taylor series, its right-hand side in sparse form, every switch of the contact a terminal event.

Two integrators take turns, open and pressed; the damper of the pressed one is a parameter that its events switch without
leaving the integrator. The clip of the tension is an event of the pressed one as well (an integrator of its own would never
run for more than a few steps). heyoka compiles for each tolerance anew; that time is reported apart.
"""

import math
import time

import numpy as np

from peers.common import Outcome, imported, motion_of, refuse_driven

PIECE = 2000  # output times
# gaps: onset and release this little behind the switch, for an integrator that begins on a root of its event misses the next one
BESIDE = 1e-12


def _expressions(hy, m):
    """(state variables, accelerations without contact, d, d', all as expressions in the yardstick's order)."""
    n, k = m.stiffness_r.shape[0], m.stiffness_s.shape[0]
    half = 2 * (n + k)
    names = [f"x{i}" for i in range(half)] + [f"v{i}" for i in range(half)]
    symbols = hy.make_vars(*names)
    x, v = symbols[:half], symbols[half:]
    phi, omega = (m.omega + 0.5 * m.omega_dot * hy.time) * hy.time, m.omega + m.omega_dot * hy.time
    c, s = hy.cos(phi), hy.sin(phi)
    square = omega * omega

    def linear(matrix, values, first, row):
        return [float(matrix[row, j]) * values[first + j] for j in range(matrix.shape[0]) if matrix[row, j] != 0.0]

    a = []
    for plane, forced in ((0, (c, s)), (1, (s, -c))):
        for i in range(n):
            terms = [-term for term in linear(m.stiffness_r, x, plane * n, i) + linear(m.damping_r, v, plane * n, i)]
            other = (1 - plane) * n
            terms += [(2 * plane - 1) * omega * term for term in linear(m.gyroscopic_r, v, other, i)]
            if m.unbalance[i] != 0.0:
                terms += [float(m.unbalance[i]) * square * forced[0], float(m.euler[i]) * m.omega_dot * forced[1]]
            a.append(hy.sum(terms))
    for plane in range(2):
        first = 2 * n + plane * k
        for i in range(k):
            terms = linear(m.stiffness_s, x, first, i) + linear(m.damping_s, v, first, i)
            a.append(-hy.sum(terms))
    pairs = []
    for values in (x, v):
        r_y, r_z = values[m.i_r], values[n + m.i_r]
        pairs.append((r_y - values[2 * n + m.i_s], r_z - values[2 * n + k + m.i_s]) if k else (r_y, r_z))
    return symbols, a, pairs[0], pairs[1]


class Heyoka:
    """The Taylor integrator of a problem."""

    def __init__(self, problem):
        heyoka = imported("heyoka")
        refuse_driven(problem)
        self.hy, self.problem, self.made, self.tol = heyoka, problem, None, None

    def _integrators(self, tol):
        """{pressed: integrator}; the pressed one's parameters: spring on, damper on."""
        hy, m = self.hy, self.problem.matrices
        n, k = m.stiffness_r.shape[0], m.stiffness_s.shape[0]
        symbols, a, d, d_dot = _expressions(hy, m)
        half = len(symbols) // 2
        distance = hy.sqrt(d[0] * d[0] + d[1] * d[1])
        penetration, product = distance - m.gap, d[0] * d_dot[0] + d[1] * d_dot[1]
        force = m.k_c * penetration + m.b_c * product / distance
        # the force with spring and damper switched by parameters, over the distance
        over = hy.par[0] * (m.k_c * penetration + hy.par[1] * m.b_c * product / distance) / distance
        f = (over * (d[0] - m.friction * d[1]), over * (d[1] + m.friction * d[0]))
        pressed = list(a)
        for plane in range(2):
            pressed[plane * n + m.i_r] = pressed[plane * n + m.i_r] - m.per_mass_r * f[plane]
            if k:
                i = 2 * n + plane * k + m.i_s
                pressed[i] = pressed[i] + m.per_mass_s * f[plane]

        def turned(integrator, sign):
            integrator.pars[:] = (1.0, 0.0) if sign > 0 else (1.0, 1.0)
            return True

        def clipped(integrator, sign):
            integrator.pars[:] = (0.0, 1.0) if sign < 0 else (1.0, 1.0)
            return True

        up, down = hy.event_direction.positive, hy.event_direction.negative
        events = {
            False: [hy.t_event((d[0] * d[0] + d[1] * d[1]) / m.gap**2 - (1.0 + BESIDE), direction=up)],
            True: [hy.t_event(distance / m.gap - (1.0 - BESIDE), direction=down)],
        }
        if m.b_c > 0.0:
            events[True] += [
                hy.t_event(product / m.gap**2, callback=turned),
                hy.t_event(force / (m.k_c * m.gap), callback=clipped),
            ]
        made = {}
        for touching, accelerations in ((False, a), (True, pressed)):
            system = list(zip(symbols, [*symbols[half:], *accelerations], strict=True))
            compact = half > 12  # as heyoka's documentation advises for large systems
            options = {"t_events": events[touching], "tol": tol, "compact_mode": compact}
            made[touching] = hy.taylor_adaptive(system, self.problem.start, pars=[1.0, 0.0] if touching else [], **options)
        return made

    def _press(self, integrator):
        """Spring and damper of the pressed integrator at an onset."""
        m = self.problem.matrices
        n, k = m.stiffness_r.shape[0], m.stiffness_s.shape[0]
        y, half, q = integrator.state, 2 * (n + k), 2 * n + m.i_s
        d_y, d_z, v_y, v_z = y[m.i_r], y[n + m.i_r], y[half + m.i_r], y[half + n + m.i_r]
        if k:
            d_y, d_z, v_y, v_z = d_y - y[q], d_z - y[q + k], v_y - y[half + q], v_z - y[half + q + k]
        integrator.pars[:] = (1.0, 0.0 if d_y * v_y + d_z * v_z >= 0.0 else 1.0)
        return math.hypot(d_y, d_z) > m.gap

    def __call__(self, tol, limit=1e9):
        begun = time.process_time()
        if tol != self.tol:  # repeats take the integrators that are there
            self.made, self.tol = self._integrators(tol), tol
        setup, made = time.process_time() - begun, self.made
        for integrator in made.values():
            integrator.state[:] = self.problem.start
            integrator.time = 0.0
            integrator.reset_cooldowns()
        times, rows = self.problem.times[1:], [self.problem.start[None, :]]
        touching = self._press(made[True])
        active, done, calls = made[touching], 0, 0
        begun = time.process_time()
        while done < times.size:
            # pieces of the grid, so that the limit is looked at; a grid must begin at the integrator's own time
            part = times[done : done + PIECE]
            outcome, *_, steps, _, found = active.propagate_grid(np.concatenate([[active.time], part]))
            calls += steps * (active.order + 1)
            rows.append(found[1:])
            done += found.shape[0] - 1
            cause = "T" if time.process_time() - begun > limit else ""
            if outcome == self.hy.taylor_outcome.err_nf_state:
                cause = "N"
            if cause:
                return Outcome(time.process_time() - begun, None, calls, cause, setup)
            if outcome == self.hy.taylor_outcome.time_limit:
                continue
            touching = not touching
            other = made[touching]
            other.state[:] = active.state
            other.dtime = active.dtime
            other.reset_cooldowns()
            if touching:
                self._press(other)
            active = other
        return Outcome(time.process_time() - begun, motion_of(np.vstack(rows), self.problem), calls, "", setup)
