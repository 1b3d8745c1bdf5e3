"""How far a whirl stays behind while the rotor speed moves it: small motions driven by its own slow change.

In the frame that turns with Psi(t) a whirl is an equilibrium x_0 that moves along the run. With the state matrix J of small
motions (`rsc.analysis.paper.stability.state_matrices`) the distance z from it, a state [Re x, Im x, Re x', Im x'], obeys

    z' = J z - [x_0', i Psi' x_0],

since the frame itself turns faster or slower (Euler's term). z is found mode by mode; modes that grow and the free phase are left
out: what grows leaves the whirl and is told by `rsc.analysis.follow.delayed_jump`.
"""

from dataclasses import dataclass
from math import tau as TWO_PI

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.paper.stability import state_matrices
from rsc.analysis.paper.states import states_of
from rsc.analysis.paper.whirls import whirl_shapes
from rsc.system.system import System

# an eigenvalue below this share of the largest frequency of the whirl belongs to the free phase
_PHASE = 1e-7


@dataclass(frozen=True, eq=False)
class Lag:
    """What a moving whirl has more than the steady one of the moment; arrays (n,).

    rotor, stator : relative difference of the amplitudes at the contact (stator: 0 for a rigid one)
    frequency : Hz, difference of the frequency
    """

    rotor: NDArray[np.float64]
    stator: NDArray[np.float64]
    frequency: NDArray[np.float64]


def lag(system: System, time: NDArray[np.float64], speed: NDArray[np.float64], Psi: NDArray[np.float64],
        F_N: NDArray[np.float64], shift: NDArray[np.float64] | None = None) -> Lag:  # fmt: skip
    """Lag of one whirl along a run, from its steady state at the first instant on.

    Parameters
    ----------
    system : System
        With finite contact stiffness.
    time : (n,) s, rising
    speed, Psi : (n,) rad/s
        Rotor speed and whirl frequency, `rsc.analysis.paper.roots.whirl_roots`.
    F_N : (n,) N
    shift : (n,) 1/s, optional
        What the unbalance adds to the growth rate of the slowest small motion.

    Returns
    -------
    Lag
    """
    n = len(time)
    shift = np.zeros(n) if shift is None else shift
    if n < 2:
        return Lag(*np.zeros((3, n)))
    shapes = [np.concatenate(whirl_shapes(system, Psi[i], F_N[i], speed[i])) for i in range(n)]
    equilibrium = np.array(shapes)
    moving = np.gradient(equilibrium, time, axis=0)
    euler = 1j * np.gradient(Psi, time)[:, None] * equilibrium
    parts = [moving, euler]
    if system.n_states:
        bodies = [system.at_speed(Omega).joined() for Omega in speed]
        held = [states_of(own, w, shape) for own, w, shape in zip(bodies, Psi, shapes, strict=True)]
        parts.append(np.gradient(np.array(held), time, axis=0))
    drive = -np.concatenate([part for own in parts for part in (own.real, own.imag)], axis=1)
    states = np.zeros((n, drive.shape[1]))
    for i in range(1, n):
        step = time[i] - time[i - 1]
        states[i] = _after(system, (Psi[i], F_N[i], speed[i], shift[i]), states[i - 1], 0.5 * (drive[i] + drive[i - 1]), step)
    return _measured(system, equilibrium, states)


def _after(system: System, whirl, state, drive, step):
    """State after a step with constant drive: modes of the state matrix, those that decay only."""
    Psi, F_N, Omega, shift = whirl
    matrix = state_matrices(system, np.array([Psi]), np.array([F_N]), Omega)[0]
    values, vectors = np.linalg.eig(matrix)
    state, drive = np.linalg.solve(vectors, np.array([state, drive]).T).T
    decays = values.real < -_PHASE * abs(Psi)
    if decays.any():
        slowest = values.real[decays].max()
        values = np.where(decays & (values.real >= slowest + _PHASE * slowest), values + shift, values)
        decays &= values.real < 0.0
    values = np.where(decays, values, -1.0)
    kept = np.exp(values * step) * state + np.expm1(values * step) / values * drive
    return (vectors @ np.where(decays, kept, 0.0)).real


def _measured(system: System, equilibrium, states):
    """`Lag` of states (n, 4 (N + M) + 2 p) beside the equilibrium (n, N + M)."""
    size = equilibrium.shape[1]
    change = states[:, :size] + 1j * states[:, size : 2 * size]
    rate = states[:, 2 * size : 3 * size] + 1j * states[:, 3 * size : 4 * size]
    n_rotor = system.n_rotor
    place, change_there = equilibrium[:, :n_rotor] @ system.rotor.contact, change[:, :n_rotor] @ system.rotor.contact
    rotor = (place.conj() * change_there).real / np.abs(place) ** 2
    turning = (place.conj() * (rate[:, :n_rotor] @ system.rotor.contact)).imag / np.abs(place) ** 2
    if not system.n_stator:
        return Lag(rotor, np.zeros_like(rotor), turning / TWO_PI)
    place, change_there = equilibrium[:, n_rotor:] @ system.stator.contact, change[:, n_rotor:] @ system.stator.contact
    return Lag(rotor, (place.conj() * change_there).real / np.abs(place) ** 2, turning / TWO_PI)
