"""The equations of motion with several contacts and races, written down once more and integrated by DOP853 with events."""

import functools

import numpy as np
from scipy.integrate import solve_ivp

from once import once
from rsc.system.assemble import assemble


class Witness:
    """The equations of motion in y + i z with all contacts, straight from the matrices; no code of the kernel. The state is
    [r, s, r', s', speeds of the races in rad/s], complex, of a contact without a race 0."""

    rtol, atol = 1e-12, 1e-17

    def __init__(self, scene):
        self.system, self.start = assemble(scene), scene.start
        system = self.system
        self.n = system.n_rotor
        self.mass = [body.mass for body in system.bodies]
        self.speed, self.rate = system.schedule_speed[0], np.diff(system.schedule_speed)[0] / system.schedule_time[-1]

    def parts(self, state):
        """[r, s, r', s', speeds of the races] of the numbers that are integrated."""
        return np.split(state.view(complex), np.cumsum([self.n, self.system.n_stator] * 2))

    def forces(self, t, r, s, r_dot, s_dot, races):
        """(n_contacts,) complex F_C, friction forces, and margins that change sign where the law changes."""
        phase, omega = self.speed * t + 0.5 * self.rate * t * t, self.speed + self.rate * t
        forces, friction, margins = [], [], []
        for contact, race in zip(self.system.contacts, races.real, strict=True):
            ring = contact.ring * np.exp(1j * phase)
            d = contact.rotor @ r - contact.stator @ s + ring - contact.offset
            d_dot = contact.rotor @ r_dot - contact.stator @ s_dot + 1j * omega * ring
            law, size = contact.law, abs(d)
            p, p_dot, v_t = size - contact.gap, (d_dot * d.conjugate()).real / size, (d_dot * d.conjugate()).imag / size
            normal = max(0.0, law.stiffness * p + law.damping * min(p_dot, 0.0)) if p > 0.0 else 0.0
            slip = np.inf
            if law.diameter is not None:
                slip = (0.5 * omega * law.diameter - race * (0.5 * law.diameter + contact.gap) + v_t) / law.slip_velocity
            friction.append(law.friction * np.clip(slip, -1.0, 1.0) * normal)
            forces.append((normal + 1j * friction[-1]) * d / size)
            margins += [p / contact.gap, p_dot, law.stiffness * p + law.damping * p_dot]
            margins += np.clip((slip - 1.0, slip + 1.0), -9.0, 9.0).tolist()
        return np.array(forces), np.array(friction), np.array(margins)

    def __call__(self, t, state):
        r, s, r_dot, s_dot, races = self.parts(state)
        F, friction, _ = self.forces(t, r, s, r_dot, s_dot, races)
        rotor, stator, omega = *self.system.bodies, self.speed + self.rate * t
        turn = np.exp(1j * (self.speed * t + 0.5 * self.rate * t * t))
        imposed = (rotor.unbalance * omega**2 - 1j * rotor.unbalance_euler * self.rate) * turn + rotor.load
        rows = [np.array([contact.rotor for contact in self.system.contacts]), np.array([c.stator for c in self.system.contacts])]
        gyroscopic = -1j * omega * rotor.gyroscopic
        a = np.linalg.solve(rotor.mass, imposed - rotor.stiffness @ r - (rotor.damping + gyroscopic) @ r_dot - rows[0].T @ F)
        b = np.linalg.solve(stator.mass, -stator.stiffness @ s - stator.damping @ s_dot + rows[1].T @ F)
        turned = [
            0.0 if own.law.race_inertia is None
            else (force * (0.5 * own.law.diameter + own.gap) - own.law.race_drag * race) / own.law.race_inertia
            for own, force, race in zip(self.system.contacts, friction, races, strict=True)
        ]
        return np.concatenate([r_dot, s_dot, a, b, turned]).view(float)

    def motion(self, time):
        """(n_time, N) rotor, (n_time, M) stator and (n_time, n_contacts) speeds of the races in rad/s at times from 0 on, in
        pieces that end where a law changes."""
        start = self.start
        parts = start.rotor, start.stator or (0j,) * self.system.n_stator, start.rotor_velocity, start.stator_velocity
        size = (self.n, self.system.n_stator) * 2
        m = len(self.system.contacts)
        state = [np.array(part or (0j,) * n, complex) for part, n in zip(parts, size, strict=True)]
        state = np.concatenate([*state, np.zeros(m, complex)]).view(float)

        @functools.lru_cache(maxsize=1)  # all margins at once: every event asks at the same instant
        def margins(t, y):
            return self.forces(t, *self.parts(np.frombuffer(y)))[2]

        def margin(i):
            def value(t, y):
                return margins(t, y.tobytes())[i]

            value.terminal = True
            return value

        events = [margin(i) for i in range(5 * m)]
        t, end, times, states = 0.0, time[-1], [0.0], [state]
        while t < end:
            answer = solve_ivp(self, (t, end), state, "DOP853", rtol=self.rtol, atol=self.atol, events=events, dense_output=True)
            inside = time[(time > t) & (time <= answer.t[-1])]
            times += inside.tolist()
            states += list(answer.sol(inside).T) if len(inside) else []
            t, state = answer.t[-1], answer.y[:, -1]
            if t < end:  # a little further, past the event
                step = solve_ivp(self, (t, min(t + 1e-9, end)), state, "DOP853", rtol=self.rtol, atol=self.atol)
                t, state = step.t[-1], step.y[:, -1]
        reached = np.array(states)[np.searchsorted(times, time)].view(complex)
        n, both = self.n, self.n + self.system.n_stator
        return reached[:, :n], reached[:, n:both], reached[:, 2 * both :].real


@once
def motion_of(scene, time):
    """What `Witness.motion` says of a scene."""
    return Witness(scene).motion(time)
