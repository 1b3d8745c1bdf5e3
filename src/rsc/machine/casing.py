"""Casings whose axial and lateral motion are coupled, which therefore have no complex coordinates of their own.

The contact asks of a stator only its receptance H: the displacement of its contact place for a force there. Where it is the same
in x and y, and a force in x gives nothing in y, the complex displacement for a complex force F is H F, H of one direction. So the
real model of that direction, all of its coordinates included, stands for both: it is taken once for x and as i times the same
for y. After reduction only what the contact moves is left of it.

Where the directions differ the casing is refused, with how much they differ. A model of both directions with the matrix of four
receptances is what then would be needed.
"""

import numpy as np
import scipy.linalg

from rsc.errors import DataError
from rsc.machine.checks import factors_of
from rsc.machine.coordinates import Coordinates
from rsc.machine.model import DISPLACEMENT, OTHER, TILT, Model

ALIKE = 0.01  # difference of both directions at the contact, of their mean
_STEPS = 3  # frequencies from 0 to the end of the band
_KINDS = {"x": DISPLACEMENT, "ry": TILT, "y": OTHER, "rx": OTHER, "other": OTHER}


def one_direction(matrices, coordinates: Coordinates, source: str, contact: int | str, band: float) -> Model:
    """Model that takes every real coordinate once, after a comparison of both directions at the contact.

    Raises
    ------
    DataError
        The contact's node has no x or y, or its receptances in x and y differ by more than 1 % of their mean somewhere up to the
        band's end (at three frequencies), or a force in x moves it in y by more.
    """
    zero = 0.0 * matrices["mass"]
    model = Model(
        source=source,
        node=coordinates.node,
        kind=np.array([_KINDS[direction] for direction in coordinates.direction.tolist()]),
        mass=matrices["mass"],
        damping=matrices.get("damping", zero),
        gyroscopic=zero,
        stiffness=matrices["stiffness"],
        names=coordinates.names,
        position=coordinates.position,
    )
    node = model.node_of(contact)
    rows = [np.flatnonzero((coordinates.node == node) & (coordinates.direction == direction)) for direction in ("x", "y")]
    if any(row.size == 0 for row in rows):
        raise DataError(source, f"node {node} of the contact must have the directions x and y")
    worst, where = 0.0, 0.0
    for frequency in np.linspace(0.0, band, _STEPS):
        h = receptances(model, np.concatenate(rows), frequency)
        mean = abs(h[0, 0] + h[1, 1]) / 2.0
        difference = max(abs(h[0, 0] - h[1, 1]), abs(h[0, 1]), abs(h[1, 0])) / mean if mean > 0.0 else np.inf
        if difference > worst:
            worst, where = float(difference), float(frequency)
    if worst > ALIKE:
        raise DataError(
            source,
            f"x and y are coupled with other directions, and at node {node} they differ by {100 * worst:.3g} % of their mean "
            f"receptance at {where:.4g} Hz; such a stator is read where they are alike to {100 * ALIKE:.0f} %",
        )
    note = f"x stands for both directions; at node {node} they differ by {100 * worst:.2g} % at most up to {band:g} Hz."
    return Model(**{**vars(model), "notes": (note,)})


def receptances(model: Model, rows, frequency: float):
    """Displacement of some coordinates for a force at each, (n, n) complex, m/N, at a frequency in Hz.

    To first order in the damping: H = X_rows - i omega X^T C X with (K - omega^2 M) X = 1 at the rows. For a comparison of two
    directions that is enough, and SuperLU takes many times as long for complex matrices.
    """
    omega = 2.0 * np.pi * frequency
    dynamic = model.stiffness - omega**2 * model.mass
    forces = np.zeros((model.n, len(rows)))
    forces[rows, np.arange(len(rows))] = 1.0
    solve = (lambda f: factors_of(dynamic).solve(f)) if model.is_sparse else (lambda f: scipy.linalg.solve(dynamic, f))
    try:
        answer = solve(forces)
    except (RuntimeError, np.linalg.LinAlgError):
        raise DataError(model.source, f"nothing holds it against a force at node {model.node[rows[0]]}: fix its feet") from None
    return answer[rows] - 1j * omega * (answer.T @ (model.damping @ answer))
