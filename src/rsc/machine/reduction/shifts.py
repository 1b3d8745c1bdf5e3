"""Difference between receptances of a reduced and the full body: one full solution per contact.

The error of a reduced receptance is not bounded but computed: the full dynamic stiffness is solved where it matters.
"""

import numpy as np

from rsc.machine.reduction.body import ComplexArray, n_contacts, slope, solutions
from rsc.machine.reduction.reduction import Reduced


def receptance_error(reduced: Reduced, Psi: float, Omega: float) -> tuple[ComplexArray, ComplexArray]:
    """(H - H_r, dH/dPsi) between the contacts at a frequency and a rotor speed in rad/s, (c, c), in m/N and m s/N; rows are
    the contacts that move."""
    c = n_contacts(reduced.full)
    at = np.full(c, Psi), np.full(c, Omega)
    x, y = (solutions(body, *at, body.inputs[:, :c]) for body in (reduced.full, reduced.body))
    forces = reduced.full.inputs[:, :c]
    by_row = solutions(reduced.full, *at, forces, left=True) if reduced.full.n_states else x
    moved = -by_row @ (slope(reduced.full, Psi, Omega) @ x.T)
    return (x @ np.atleast_2d(reduced.full.contact).T - y @ np.atleast_2d(reduced.body.contact).T).T, moved
