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


def with_states(model, full, modes, gap, omega):
    """(the model with a coordinate for every state, (p,) what the kernel multiplies the states with). The states of bearings that
    are switched off go on without a force on the rotor.

    full : System; modes : `RealModes` of rotor and stator; gap in m and omega in rad/s: size and frequency of a typical motion
    """
    bodies, n = full.at_start.bodies, model.stiffness.size // 2
    total = sum(body.n_states for body in bodies)
    if not total:
        return model, np.zeros(0)
    matrix, sensed, moved = np.zeros((total, total)), np.zeros((total, n)), np.zeros((total, n))
    for body, own, at, z in _places(bodies, modes):
        matrix[z, z] = body.state_matrix
        sensed[z, at], moved[z, at] = (part @ own.shape for part in (body.state_displacement, body.state_velocity))
    amplitude = _amplitudes(matrix, sensed, moved, omega) * gap
    size = SMALL * 2.0 ** np.round(np.log2(gap * omega / amplitude))
    offs = [one.time for one in full.switched]
    columns = np.zeros((len(offs) + 1, 2, n + total, n + total))
    for i, (force, direct) in enumerate(_forces(full, modes, n, total)):
        on_v, on_x = columns[i]
        on_v[n:, n:], on_v[n:, :n], on_v[:n, n:] = size[:, None] * matrix / size, size[:, None] * moved, force / size
        on_x[n:, :n], on_x[:n, :n] = size[:, None] * sensed, direct
    wide = widened(model, n + total)
    scale_x, scale_v, mark = wide.scale_x.copy(), wide.scale_v.copy(), np.zeros(2 * (n + total))
    mark[2 * n :] = 1.0
    scale_x[2 * n :], scale_v[2 * n :] = gap**2, ((amplitude * size) ** 2).repeat(2)
    columns = columns.swapaxes(2, 3).repeat(2, axis=3)
    data = StateData(
        columns=on_lines(columns.reshape(-1, columns.shape[-1])).reshape(columns.shape),
        interval=np.searchsorted(offs, model.corner_time, side="right").astype(float),
        mark=mark,
        weight=wide.weight.copy(),
    )
    return wide._replace(scale_x=scale_x, scale_v=scale_v, states=data), size


def _places(bodies, modes):
    """(body, its modes, its coordinates, its states) of bodies with first-order states, among those of all bodies."""
    i = k = 0
    for body, own in zip(bodies, modes, strict=True):
        if body.n_states:
            yield body, own, slice(i, i + body.n_coordinates), slice(k, k + body.n_states)
        i, k = i + body.n_coordinates, k + body.n_states


def _forces(full, modes, n, total):
    """(force of the states (n, total), direct force of the displacements (n, n)) per mass in modes: from the start, then after
    each time at which bearings are switched off."""
    states = full.at_start.rotor.n_states
    left = [np.arange(states), *(one.left for one in full.switched)]
    for numbers, time in zip(left, (-np.inf, *(one.time for one in full.switched)), strict=True):
        force, direct = np.zeros((n, total)), np.zeros((n, n))
        acting = np.concatenate([numbers, np.arange(states, total)])
        whole = np.zeros((n, len(acting)))
        for body, own, at, z in _places(full.at_time(time).bodies, modes):
            whole[at, z] = own.shape.T @ body.state_force / own.reference_mass
            direct[at, at] = -own.shape.T @ body.state_stiffness @ own.shape / own.reference_mass
        force[:, acting] = whole
        yield force, direct


def _amplitudes(matrix, sensed, moved, omega):
    """(p,) amplitudes of the states for a unit motion of every coordinate at a frequency; of one that nothing drives, as the
    others."""
    driven = abs(np.linalg.solve(omega * np.eye(len(matrix)) - matrix, sensed + omega * moved)).sum(axis=1)
    return np.where(driven > 0.0, driven, driven.max(initial=0.0) or 1.0)
