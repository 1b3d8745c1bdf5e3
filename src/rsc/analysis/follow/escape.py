"""The least friction with which a motion runs away under one-sided friction, where nothing makes the contact roll.

Far beyond the gap s the contact force (1 + i mu) k_C (|d| - s) e^{i gamma} is that of a spring (1 + i mu) k_C, and the machine is
linear:

    A_R(Psi) r_R + (1 + i mu) k_C l_R d = 0,   A_S(Psi) r_S - (1 + i mu) k_C l_S d = 0,   d = l_R . r_R - l_S . r_S.

A motion that is large enough grows without bound where one of these frequencies has Im Psi < 0; the damper of the contact does
not act on what grows. On the border of stability Psi is real and the force of the whirl condition (24), (27) is unbounded.
"""

from math import tau as TWO_PI

import numpy as np

from rsc.analysis.follow.events import Event
from rsc.analysis.paper.law import law_of
from rsc.analysis.paper.states import first_order
from rsc.system.system import FloatOrArray, System

ESCAPES = "it runs away (12)"
_FRICTIONS = np.geomspace(1e-6, 5.0, 34)
_EXACT = 1e-9  # share of a friction that is located
_ROUNDING = 1e-12  # of the largest frequency, below which a growth is none


def least_escape(system: System, Omega: FloatOrArray, band):
    """The Event from which on a backward motion runs away; None with a contact diameter, or where none does up to friction 5.

    system : System at the rotor speed Omega in rad/s, forward; band : lowest and highest Psi in rad/s that its bodies hold for
    """
    if law_of(system).diameter is not None:
        return None
    growing = next((i for i, mu in enumerate(_FRICTIONS) if _fastest(system, Omega, band, mu)), None)
    if growing is None:
        return None
    high, low = float(_FRICTIONS[growing]), float(_FRICTIONS[growing - 1]) if growing else 0.0
    while high - low > _EXACT * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _fastest(system, Omega, band, middle) else (middle, high)
    return Event(ESCAPES, high, _fastest(system, Omega, band, high) / TWO_PI, "above")


def escapes(system: System, Omega: FloatOrArray, band):
    """Whether a backward motion that is large enough runs away at the friction of the system; arguments as `least_escape`."""
    law = law_of(system)
    return law.diameter is None and _fastest(system, Omega, band, law.friction) != 0.0


def _fastest(system: System, Omega: FloatOrArray, band, friction):
    """Psi in rad/s of the pressed motion that grows fastest backward, 0.0 where none does."""
    Psi = pressed_frequencies(system, Omega, friction)
    Psi = Psi[(Psi.real < 0.0) & (Psi.real >= band[0]) & (Psi.real <= band[1]) & (Psi.imag < -_ROUNDING * np.abs(Psi).max())]
    return float(Psi[np.argmin(Psi.imag)].real) if len(Psi) else 0.0


def pressed_frequencies(system: System, Omega: FloatOrArray, friction):
    """(2 (N + M) + p,) complex rad/s: Psi of the motions e^{i Psi t} of rotor and stator joined by a spring (1 + i mu) k_C at the
    contact; a motion with Im Psi < 0 grows."""
    whole, contact = system.at_speed(Omega).joined(), system.contact
    bodies, row = whole.without_states(), np.concatenate([contact.rotor, -contact.stator])
    stiffness = bodies.static + (1.0 + 1j * friction) * law_of(system).stiffness * np.outer(row, row)
    if whole.n_states:
        return -1j * np.linalg.eigvals(first_order(whole, bodies.mass, -1j * bodies.by_frequency(Omega), stiffness))
    n = len(row)
    pencil = np.zeros((2 * n, 2 * n), complex)
    pencil[:n, n:] = np.eye(n)
    pencil[n:, :n] = np.linalg.solve(bodies.mass, stiffness)
    pencil[n:, n:] = np.linalg.solve(bodies.mass, bodies.by_frequency(Omega))
    return np.linalg.eigvals(pencil)
