"""Small motions about a whirl the long way: the nonlinear equations linearised by differences, and integrated."""

import numpy as np
from scipy.integrate import solve_ivp

from rsc.analysis.paper.whirls import whirl_shapes
from systems import accelerations, changed, fixed_frame_rate


def numerical_eigenvalues(system, Psi, F_N, Omega, b_star, traction=None):
    """Eigenvalues of the nonlinear equations in the turning frame, linearised by central differences; traction: of a whirl that
    rolls."""
    held = system if traction is None else changed(system, friction=traction)
    shape = np.concatenate(whirl_shapes(held, Psi, F_N, Omega))
    n = len(shape)

    def rate(real_state):
        x, x_dot = np.split(real_state[: 2 * n] + 1j * real_state[2 * n :], 2)
        fixed = np.concatenate([x, x_dot + 1j * Psi * x])  # r = x e^{i Psi t} at t = 0
        acceleration = accelerations(system, fixed, Omega, b_star, rolls=traction is not None) - 2j * Psi * x_dot + Psi**2 * x
        change = np.concatenate([x_dot, acceleration])
        return np.concatenate([change.real, change.imag])

    state = np.concatenate([shape, np.zeros(n)])
    state = np.concatenate([state.real, state.imag])
    # far below the penetration, so that the square of the step does not show
    step = 1e-4 * F_N / system.law.stiffness
    columns = []
    for i in range(4 * n):
        move = np.zeros(4 * n)
        move[i] = step * (1.0 if i % (2 * n) < n else abs(Psi))
        columns.append((rate(state + move) - rate(state - move)) / (2.0 * move[i]))
    residual = np.abs(rate(state)).max() / (Psi**2 * np.abs(shape).max())
    return np.linalg.eigvals(np.array(columns).T), residual


def distance_between(found, wanted):
    """Largest distance of any of `found` to its nearest in `wanted`, in units of the largest."""
    return np.abs(found[:, None] - wanted).min(axis=1).max() / np.abs(wanted).max()


def integrated(system, Psi, F_N, Omega, duration):
    """|d| over time of the full nonlinear equations, started 0.1 % of the penetration off the whirl."""
    shape = np.concatenate(whirl_shapes(system, Psi, F_N, Omega))
    n = len(shape)
    penetration = F_N / system.law.stiffness
    shape[0] += 1e-3 * penetration
    time = np.linspace(0.0, duration, 20001)
    start = np.concatenate([shape, 1j * Psi * shape])
    rate = fixed_frame_rate(system, Omega)
    solution = solve_ivp(rate, (0.0, duration), start, "DOP853", time, rtol=1e-10, atol=1e-15)
    relative = np.concatenate([system.rotor.contact, -system.stator.contact])
    return time, np.abs(relative @ solution.y[:n]) - (system.contact.gap + penetration)
