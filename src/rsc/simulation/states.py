"""First-order states for the kernel (`rsc.kernel.states`): one coordinate each, after those of the bodies.

A state is scaled by a power of two, which loses no bits, so that it stays far below every velocity. It is integrated to rtol
times its amplitude for a motion of one gap at the rotor's frequency.
"""

import numpy as np

from rsc.kernel.states import StateData
from rsc.simulation.lines import on_lines, widened

SMALL = 2.0**-20  # of the rotor's velocity at one gap


def stiffness_at(body, omega):
    """Complex stiffness (n, n) in N/m that the states add to a body at a frequency in rad/s."""
    states = 1j * omega * np.eye(body.n_states) - body.state_matrix
    return -body.state_force @ np.linalg.solve(states, body.state_displacement + 1j * omega * body.state_velocity)


def with_states(model, system, modes, gap, omega):
    """(the model with a coordinate for every state, (p,) what the kernel multiplies the states with).

    modes : `RealModes` of rotor and stator; gap in m and omega in rad/s: size and frequency of a typical motion
    """
    bodies, n = system.bodies, model.stiffness.size // 2
    total = sum(body.n_states for body in bodies)
    if not total:
        return model, np.zeros(0)
    shapes = (total, total), (total, n), (total, n), (n, total), (n, n)
    matrix, sensed, moved, force, direct = (np.zeros(shape) for shape in shapes)
    i = k = 0
    for body, own in zip(bodies, modes, strict=True):
        p, at = body.n_states, slice(i, i + body.n_coordinates)
        if p:
            z = slice(k, k + p)
            matrix[z, z] = body.state_matrix
            sensed[z, at], moved[z, at] = (part @ own.shape for part in (body.state_displacement, body.state_velocity))
            force[at, z] = own.shape.T @ body.state_force / own.reference_mass
            direct[at, at] = -own.shape.T @ body.state_stiffness @ own.shape / own.reference_mass
        i, k = i + body.n_coordinates, k + p
    amplitude = _amplitudes(matrix, sensed, moved, omega) * gap
    size = SMALL * 2.0 ** np.round(np.log2(gap * omega / amplitude))
    on_v, on_x = np.zeros((2, n + total, n + total))
    on_v[n:, n:], on_v[n:, :n], on_v[:n, n:] = size[:, None] * matrix / size, size[:, None] * moved, force / size
    on_x[n:, :n], on_x[:n, :n] = size[:, None] * sensed, direct
    wide = widened(model, n + total)
    scale_x, scale_v, mark = wide.scale_x.copy(), wide.scale_v.copy(), np.zeros(2 * (n + total))
    mark[2 * n :] = 1.0
    scale_x[2 * n :], scale_v[2 * n :] = gap**2, ((amplitude * size) ** 2).repeat(2)
    columns = np.array([part.T.repeat(2, axis=1) for part in (on_v, on_x)])
    data = StateData(
        columns=on_lines(columns.reshape(-1, columns.shape[-1])).reshape(1, *columns.shape),
        interval=np.zeros(len(model.corner_time)),
        mark=mark,
        weight=wide.weight.copy(),
    )
    return wide._replace(scale_x=scale_x, scale_v=scale_v, states=data), size


def _amplitudes(matrix, sensed, moved, omega):
    """(p,) amplitudes of the states for a unit motion of every coordinate at a frequency; of one that nothing drives, as the
    others."""
    driven = abs(np.linalg.solve(omega * np.eye(len(matrix)) - matrix, sensed + omega * moved)).sum(axis=1)
    return np.where(driven > 0.0, driven, driven.max(initial=0.0) or 1.0)
