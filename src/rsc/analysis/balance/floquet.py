"""Stability of a whirl with its unbalance: Floquet exponents of small motions over one beat (docs/maintainers/analysis.md)."""

from math import tau as TWO_PI

import numpy as np
import scipy

from rsc.analysis.algebra.eigenvalues import eigenvalues
from rsc.analysis.balance.balance import beat_of
from rsc.analysis.paper.receptance import in_both_directions, pushed
from rsc.analysis.paper.stability import growth_of, put_states, without_phase
from rsc.analysis.paper.states import amplitudes, states_of
from rsc.analysis.paper.synchronous import unbalance_response
from rsc.system.blas import one_thread
from rsc.system.system import FloatOrArray, System


@one_thread
def balance_growth(system: System, balance):
    """Growth rate of small disturbances of a whirl with unbalance.

    In the frame turning with Psi small motions obey the equations of `rsc.analysis.paper.stability` with the contact law
    linearised at each instant of the beat. The state is carried over one beat by the exponential of the matrix of each sample.
    The multiplier 1 of the whirl's free phase is removed.

    Parameters
    ----------
    system : System
    balance : Balance

    Returns
    -------
    Growth
        `rate` 1/s; `frequency` rad/s, modulo the beat; `eigenvalues` the 4 (N + M) - 1 Floquet exponents.
    """
    period = 1.0 / (balance.speed - balance.frequency)
    over_beat, phase = _over_beat(system, balance)
    multipliers = eigenvalues(without_phase(over_beat[None], phase[None])[0]).astype(complex)
    with np.errstate(divide="ignore"):
        return growth_of(np.log(multipliers) / period)


def _over_beat(system: System, balance):
    """Matrix (4n, 4n) that carries the scaled state over one beat, and its eigenvector (4n,) of the whirl's free phase."""
    Psi, Omega = TWO_PI * balance.frequency, TWO_PI * balance.speed
    force = beat_of(system, balance)
    free, push, pick = _free_matrices(system, Psi, Omega)
    period = TWO_PI / (Omega - Psi)
    matrices = free - push @ _law(force) @ pick
    scale = _scale(matrices[0], system.at_speed(Omega).joined())
    steps = scipy.linalg.expm(scale[:, None] * matrices / scale * (period / len(matrices)))
    over_beat = np.eye(len(scale))
    for step in steps:
        over_beat = step @ over_beat
    return over_beat, scale * _phase_shift(system, balance, len(steps))


def _phase_shift(system: System, balance, n_time):
    """Direction of the whirl's free phase in the state (4n,): another phase turns line k by (1 - k) times it.

    Taken where the first step begins, half a sample before the beat does.
    """
    Omega, w = TWO_PI * balance.speed, TWO_PI * balance.lines
    k = np.arange(len(w)) - len(w) // 2
    rotor, stator = pushed(system, w, Omega, balance.forces)
    rotor[k == 1] += unbalance_response(system, Omega)[0]
    lines = np.hstack([rotor, stator]) * (1j * (1 - k) * np.exp(-1j * np.pi * k / n_time))[:, None]
    x = lines.sum(axis=0)
    v = (1j * k * (Omega - TWO_PI * balance.frequency)) @ lines
    parts, bodies = [x, v], system.at_speed(Omega).joined()
    if bodies.n_states:
        parts.append(states_of(bodies, w, lines).sum(axis=0))
    return np.concatenate([part for own in parts for part in (own.real, own.imag)])


def _free_matrices(system: System, Psi: FloatOrArray, Omega: FloatOrArray):
    """State matrix without contact (4n + 2p, 4n + 2p) of [Re x, Im x, Re x', Im x', Re z, Im z], the force's push (4n + 2p, 2)
    and its view (4, 4n + 2p); z are the p first-order states."""
    whole = system.at_speed(Omega).joined()
    bodies = whole.without_states()
    n, size = len(bodies.mass), 4 * len(bodies.mass) + 2 * whole.n_states
    inverse = np.linalg.inv(bodies.mass)
    damping = inverse @ (bodies.damping - 1j * bodies.turning(Omega))
    stiffness = inverse @ bodies.static - Psi**2 * np.eye(n) + 1j * Psi * damping
    matrix, moving = np.zeros((size, size)), slice(2 * n, 4 * n)
    matrix[: 2 * n, moving] = np.eye(2 * n)
    matrix[moving, : 2 * n] = -in_both_directions(stiffness, None)
    matrix[moving, moving] = -in_both_directions(damping + 2j * Psi * np.eye(n), None)
    if whole.n_states:
        put_states(matrix[None], whole, inverse, Psi)
    push = np.zeros((size, 2))
    push[2 * n : 3 * n, 0] = push[3 * n : 4 * n, 1] = inverse @ system.relative
    pick = np.zeros((4, size))
    for row in range(4):
        pick[row, row * n : (row + 1) * n] = system.relative
    return matrix, push, pick


def _law(force):
    """Derivative of [Re F, Im F] by [Re d, Im d, Re v, Im v] at each sample, (n_time, 2, 4)."""
    columns = []
    for direct, mirrored in ((force.by_d, force.by_d_conj), (force.by_v, force.by_v_conj)):
        columns += [direct + mirrored, 1j * (direct - mirrored)]
    table = np.stack(columns, axis=-1)
    return np.stack([table.real, table.imag], axis=1)


def _scale(matrix, bodies):
    """Factors (4n + 2p,) that make displacements, velocities and first-order states comparable."""
    half = 2 * bodies.n_coordinates
    typical = np.sqrt(np.linalg.norm(matrix[half : 2 * half, :half], 2))
    states = np.tile(1.0 / amplitudes(bodies, typical), 2) if bodies.n_states else np.zeros(0)
    return np.concatenate([np.ones(half), np.full(half, 1.0 / typical), states])
