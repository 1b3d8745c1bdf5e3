"""Casings whose axial and lateral motion are coupled, which therefore have no complex coordinates of their own.

The contact asks of a stator only its receptance H: the displacement of its contact place for a force there. Where it is the same
in x and y, and a force in x gives nothing in y, the complex displacement for a complex force F is H F, H of one direction. So the
real model of that direction, all of its coordinates included, stands for both: it is taken once for x and as i times the same
for y. After reduction only what the contact moves is left of it.

Where the directions differ the casing is refused, with how much they differ. A model of both directions with the matrix of four
receptances is what then would be needed.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError
from rsc.machine.formats import Matrix
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.model.model import DISPLACEMENT, OTHER, TILT, FiniteElementModel

ALIKE = 0.01  # difference of both directions at the contact, of their mean
_SAME, _MOST_BLOCKS = 1e-4, 40  # change of the receptances that ends their series of motions; the most of it, for each force
_STEPS = 3  # frequencies from 0 to the end of the band
Solver = Callable[[NDArray[Any]], NDArray[Any]]
ComplexArray = NDArray[np.complex128]
_KINDS = {"x": DISPLACEMENT, "ry": TILT, "y": OTHER, "rx": OTHER, "other": OTHER}


def one_direction(
    matrices: dict[str, Matrix], coordinates: Coordinates, source: str, seen: tuple[int | str, float], solve: Solver
) -> FiniteElementModel:
    """Model that takes every real coordinate once, after a comparison of both directions at the contact.

    Parameters
    ----------
    matrices, coordinates, source
        As of `rsc.machine.imports.build.stator_model`.
    seen : (node of the contact, Hz)
        Where both directions are compared, and the band's end.
    solve : function (n, k) -> (n, k)
        Displacements under forces at rest.

    Raises
    ------
    DataError
        The contact's node has no x or y, or its receptances in x and y differ by more than 1 % of their mean somewhere up to the
        band's end (at three frequencies), or a force in x moves it in y by more.
    """
    (contact, band), zero = seen, 0.0 * matrices["mass"]
    model = FiniteElementModel(
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
    worst, where, frequencies = 0.0, 0.0, np.linspace(0.0, band, _STEPS)
    for frequency, h in zip(frequencies, receptances(model, np.concatenate(rows), frequencies, solve), strict=True):
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
    return FiniteElementModel(**{**vars(model), "notes": (note,)})


def receptances(
    model: FiniteElementModel, rows: NDArray[np.int64], frequencies: NDArray[np.float64], solve: Solver
) -> ComplexArray:
    """Displacement of some coordinates for a force at each, (frequencies, n, n), m/N, at frequencies in Hz.

    From the motions K^-1 f, K^-1 M K^-1 f, ..., which match the receptances and their derivatives at rest, as many as make no
    difference any more: one factorisation serves all frequencies.
    """
    omega = 2.0 * np.pi * frequencies[:, None, None]
    block = np.zeros((model.n, len(rows)))
    block[rows, np.arange(len(rows))] = 1.0
    basis, before = np.zeros((model.n, 0)), np.full((len(frequencies), len(rows), len(rows)), np.inf + 0j)
    for _ in range(min(_MOST_BLOCKS, model.n // len(rows))):
        block = solve(block)
        for _ in range(2):
            block = np.linalg.qr(block - basis @ (basis.T @ block))[0]
        basis = np.column_stack([basis, block])
        mass, damping, stiffness = (basis.T @ (matrix @ basis) for matrix in (model.mass, model.damping, model.stiffness))
        seen = basis[rows]
        values = seen @ np.linalg.solve(stiffness + 1j * omega * damping - omega**2 * mass, seen.T[None])
        if np.abs(values - before).max() <= _SAME * np.abs(values).max():
            break
        before, block = values, model.mass @ block
    return np.asarray(values, complex)
