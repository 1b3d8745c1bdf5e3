"""Where a system rests under its load: without contact, or lying on the stator.

With K + i S + E conj of rotor and stator as one real matrix K of [y, z], its load f, and the deflection d = l^T x + eps_A of the
contact at the rotor's angle 0, the system rests where

    K x + l k_C max(|d| - s, 0) d/|d| = f.

Friction is none: surfaces that were set down without sliding leave its direction open, and a rotor that starts to turn drags its
friction force along at once.
"""

import numpy as np

from rsc.analysis.paper.anisotropy import anisotropic_part
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.receptance import in_both_directions
from rsc.analysis.paper.states import amplitudes, typical
from rsc.system.system import System

_FREE = 1e-13  # share of the largest omega^2 up to which nothing opposes a motion: the rounding of a stiffness
_BALANCED = 1e-6  # share of a load that springs may leave over where they hold it
_STEPS = 100
_TURN = 0.2  # gaps that the contact may move in one step: its direction changes the equations
_SETTLED = 1e-12  # of a gap


def at_rest(system: System):
    """Displacements in which everything rests under the load, the rotor at the angle 0.

    Parameters
    ----------
    system : System

    Returns
    -------
    rotor (N,), stator (M,) : ndarray of complex, m (tilts: rad)
        The static deflection, if it leaves the rotor inside the gap; else in contact without friction. None where springs and
        contact do not hold the load.
    """
    place = _resting(system)
    n, m = system.n_rotor, system.n_stator
    return None if place is None else (place[:n], place[n : n + m])


def states_at_rest(system: System):
    """First-order states (p,) of rotor and stator `at_rest`, complex; None where there is no rest."""
    return _states_in(system, _resting(system))


def static_states(system: System):
    """First-order states (p,) of rotor and stator with the `static_deflection`; None where nothing holds the load."""
    return _states_in(system, _hanging(system))


def _states_in(system: System, place):
    return None if place is None else place[system.n_rotor + system.n_stator :]


def _resting(system: System):
    """Displacements of rotor and stator and first-order states `at_rest`, in one vector; None without."""
    free = _hanging(system)
    if free is None or abs(free[: system.n_rotor] @ system.rotor.contact + system.contact.ring) > law_of(system).gap:
        return _lying(system) if system.rotor.load.any() else free
    return free


def _hanging(system: System):
    """As `_resting`, without contact; None where the load acts on a motion that nothing opposes."""
    if not system.rotor.load.any():
        return np.zeros(system.n_rotor + system.n_stator + system.n_states, complex)
    stiffness, force, size = _statics(system)
    x = _solved(stiffness, force, size)
    return _complex(x) if _balanced(stiffness @ x - force, force, size) else None


def static_deflection(system: System):
    """Deflection of the rotor at rest by its load without contact, exactly.

    Parameters
    ----------
    system : System

    Returns
    -------
    ndarray of complex, (N,), m (tilts: rad)
        Infinite where the load acts on a motion that no spring opposes; a free motion that it leaves alone does not move.
    """
    place = _hanging(system)
    return np.full(system.n_rotor, np.inf + 0j) if place is None else place[: system.n_rotor]


def _lying(system: System):
    """As `_resting`, in contact, by Newton's method from where the load presses; None where it does not converge."""
    stiffness, force, size = _statics(system)
    contact = np.kron(np.eye(2), np.append(system.relative, np.zeros(system.n_states)))  # (2, 2 n), [y, z] of d
    ring, law = np.array([system.contact.ring.real, system.contact.ring.imag]), law_of(system)
    k_c, gap = law.stiffness, law.gap

    def sprung(centre):
        """Deflection with a spring k_C from d to a point, in all directions."""
        return _solved(stiffness + k_c * contact.T @ contact, force - k_c * contact.T @ (ring - centre), size)

    pressed = contact @ sprung(np.zeros(2)) + ring
    x = sprung(gap * pressed / np.linalg.norm(pressed))
    for _ in range(_STEPS):
        d = contact @ x + ring
        distance = np.linalg.norm(d)
        normal = d / distance
        turning = law.secant(distance)
        missing = force - stiffness @ x - turning * contact.T @ d
        spring = k_c * np.outer(normal, normal) + turning * (np.eye(2) - np.outer(normal, normal))
        step = _solved(stiffness + contact.T @ spring @ contact, missing, size)
        moved = np.linalg.norm(contact @ step)
        x = x + min(1.0, _TURN * gap / max(moved, 1e-300)) * step
        if moved <= _SETTLED * gap:
            return _complex(x) if _balanced(missing, force, size) else None
    return None


def _statics(system: System):
    """Stiffness (2 n, 2 n) and load (2 n,) of [y, z] of rotor, stator and first-order states, and the roots of their masses (m
    beside rad), for states what makes them comparable."""
    bodies, p = system.joined(), system.n_states
    plain = bodies.with_states().static
    size = np.sqrt(bodies.mass.diagonal())
    if p:
        n, omega = len(size), typical(bodies)
        size = np.append(size, size.mean() / amplitudes(bodies, omega))
        largest = np.abs(plain[n:] / np.outer(size[n:], size)).max(axis=1, keepdims=True)
        plain[n:] *= omega**2 / largest
    stiffness = in_both_directions(plain, np.pad(anisotropic_part(system, "stiffness"), (0, p)))
    load = np.concatenate([system.rotor.load, np.zeros(system.n_stator + p)])
    return stiffness, np.concatenate([load.real, load.imag]), np.tile(size, 2)


def _solved(stiffness, force, size):
    """Displacements (2 n,) under a force; of a free motion none."""
    return np.linalg.lstsq(stiffness / np.outer(size, size), force / size, rcond=_FREE)[0] / size


def _balanced(missing, force, size):
    """Whether next to nothing of a force is missing; the rows of first-order states are no forces, but comparable by `size`."""
    return np.abs(missing / size).max() <= _BALANCED * np.abs(force / size).max()


def _complex(x):
    y, z = np.split(x, 2)
    return y + 1j * z
