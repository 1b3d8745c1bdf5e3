"""Slow plain twins of compiled code: physics.md section 2 written down once more, in complex numbers, nothing reused."""

import numpy as np
from scipy.integrate import solve_ivp

from once import once


def phase(system, t):
    """Rotation angle phi(t) in rad: the integral of the piecewise linear speed."""
    times, speeds = system.schedule_time, system.schedule_speed
    total = 0.0
    for t0, t1, s0, s1 in zip(times[:-1], times[1:], speeds[:-1], speeds[1:], strict=True):
        if t <= t0:
            break
        tau = min(t, t1) - t0
        total += s0 * tau + 0.5 * (s1 - s0) / (t1 - t0) * tau**2
    return total


def speed_rate(system, t):
    """phi''(t) in rad/s^2, of the segment that starts at or before t."""
    i = np.searchsorted(system.schedule_time, t, side="right") - 1
    i = min(max(i, 0), len(system.schedule_time) - 2)
    return np.diff(system.schedule_speed)[i] / np.diff(system.schedule_time)[i]


def contact_force(system, r, r_dot, s, s_dot, t):
    """Complex contact force F_C and F_N by (4)-(11)."""
    omega = system.speed_at(t)
    ring = system.contact.ring * np.exp(1j * phase(system, t))
    d = system.rotor.contact @ r - system.stator.contact @ s + ring
    d_dot = system.rotor.contact @ r_dot - system.stator.contact @ s_dot + 1j * omega * ring
    delta = system.contact.gap - abs(d)
    if delta >= 0.0:
        return 0.0, 0.0
    delta_dot = -(d_dot * d.conjugate()).real / abs(d)
    normal = max(0.0, system.law.stiffness * -delta - system.law.damping * max(delta_dot, 0.0))
    sigma = next((np.sign(speed) for speed in system.schedule_speed if speed), 1.0)
    if system.law.diameter is not None:
        slip = omega * system.law.diameter / 2 + (d_dot * d.conjugate()).imag / abs(d)
        sigma = np.clip(slip / system.law.slip_velocity, -1.0, 1.0)
    return (1 + 1j * system.law.friction * sigma) * normal * d / abs(d), normal


def followed(rotor, omega, r, r_dot):
    """Force on the left side of what the rotor's matrices have besides at a speed, each entry by linear interpolation."""
    if rotor.knots is None:
        return 0.0
    total = np.zeros(len(r), complex)
    for name, values in rotor.knots.parts.items():
        entries = values.reshape(len(values), -1).T
        matrix = np.array([np.interp(omega, rotor.knots.speed, entry) for entry in entries]).reshape(len(r), len(r))
        moved = r_dot if "damping" in name else r
        moved = moved.conj() if "anisotropic" in name else 1j * moved if "skew" in name else moved
        total += matrix @ moved
    return total


def rhs(system):
    """f(t, y) of the first-order system, y = [r, s, r', s', z of the rotor, z of the stator] complex."""
    n, m, rotor = system.n_rotor, system.n_stator, system.rotor
    inverses = [np.linalg.inv(body.mass) for body in (rotor, system.stator)] if m else [np.linalg.inv(rotor.mass), None]

    def directed(body, r, r_dot):
        """Skew and anisotropic forces on the left side of a body's equation."""
        total = 0.0
        for name, times, moved in (("stiffness", 1j, r), ("damping", 1j, r_dot)):
            for kind, vector in (("skew", times * moved), ("anisotropic", moved.conjugate())):
                matrix = getattr(body, f"{kind}_{name}")
                total = total if matrix is None else total + matrix @ vector
        return total

    def first_order(body, z, r, r_dot):
        """(force on the right side of a body's equation, z') of its first-order states."""
        if body.state_matrix is None:
            return 0.0, z
        return body.state_force @ z, body.state_matrix @ z + body.state_displacement @ r + body.state_velocity @ r_dot

    def f(t, y):
        r, s, r_dot, s_dot, z_r, z_s = np.split(y, np.cumsum([n, m, n, m, rotor.n_states]))
        pull, z_r_dot = first_order(rotor, z_r, r, r_dot)
        pull_s, z_s_dot = first_order(system.stator, z_s, s, s_dot)
        omega, omega_dot = system.speed_at(t), speed_rate(system, t)
        force, _ = contact_force(system, r, r_dot, s, s_dot, t)
        turn = np.exp(1j * phase(system, t))
        imposed = (system.rotor.unbalance * omega**2 - 1j * system.rotor.unbalance_euler * omega_dot) * turn + system.rotor.load
        damping = system.rotor.damping - 1j * omega * system.rotor.gyroscopic
        if rotor.rotating_damping is not None:
            imposed = imposed - rotor.rotating_damping @ (r_dot - 1j * omega * r)
        imposed = imposed - followed(rotor, omega, r, r_dot)
        right = imposed + pull - damping @ r_dot - rotor.stiffness @ r - rotor.contact * force - directed(rotor, r, r_dot)
        r_acc = inverses[0] @ right
        s_acc = s_dot
        if m:
            right = system.stator.contact * force + pull_s - system.stator.damping @ s_dot - system.stator.stiffness @ s
            s_acc = inverses[1] @ (right - directed(system.stator, s, s_dot))
        return np.concatenate([r_dot, s_dot, r_acc, s_acc, z_r_dot, z_s_dot])

    return f


@once
def integrate(system, start, times, rtol=1e-10):
    """(rotor, stator) at the times by scipy's DOP853, kinks passed over with small steps."""
    p, moving = system.rotor.n_states + system.stator.n_states, system.n_rotor + system.n_stator
    states = np.zeros(p) if start.states is None else start.states
    y0 = np.concatenate([start.rotor, start.stator, start.rotor_velocity, start.stator_velocity, states])
    atol = rtol * system.contact.gap * np.repeat([1e-2, 1.0], [moving, moving + p])
    solution = solve_ivp(
        rhs(system), (times[0], times[-1]), y0, "DOP853", times, rtol=rtol, atol=atol, max_step=1e-3
    )
    n = system.n_rotor
    return solution.y[:n].T, solution.y[n : n + system.n_stator].T
