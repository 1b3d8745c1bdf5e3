"""Casings with coupled axial and lateral motion, which have no complex coordinates.

The contact depends on a stator only through its receptance H, the displacement of the contact point per force there. If H is the
same in x and y and a force in x causes no displacement in y, the complex displacement for a complex force F is H F, with H of one
direction. The real model with all its coordinates then serves both directions: it is used once for x and, times i, for y. The
reduction keeps only what moves the contact.

If the directions differ the casing is refused, with the difference found; it would need a model of both directions with the
matrix of four receptances.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError
from rsc.machine.formats import Matrix
from rsc.machine.imports.coordinates import Coordinates
from rsc.machine.model.model import DISPLACEMENT, OTHER, TILT, FiniteElementModel

ALIKE = 0.01  # largest difference of both directions at the contact, relative to their mean
# relative change of the receptances at which the series of motions ends; largest number of its terms per force
_SAME, _MOST_BLOCKS = 1e-4, 40
_STEPS = 3  # number of frequencies from 0 to the end of the band
Solver = Callable[[NDArray[Any]], NDArray[Any]]
ComplexArray = NDArray[np.complex128]
_KINDS = {"x": DISPLACEMENT, "ry": TILT, "y": OTHER, "rx": OTHER, "other": OTHER}


def one_direction(
    matrices: dict[str, Matrix], coordinates: Coordinates, source: str, seen: tuple[int | str, float], solve: Solver
) -> FiniteElementModel:
    """Model that uses every real coordinate once, after comparing both directions at the contact.

    Parameters
    ----------
    matrices, coordinates, source
        As for `rsc.machine.imports.build.stator_model`.
    seen : (node of the contact, Hz)
        Where, and up to which frequency, both directions are compared.
    solve : function (n, k) -> (n, k)
        Displacements due to static forces.

    Raises
    ------
    DataError
        The contact node has no x or y, or its receptances in x and y differ by more than 1 % of their mean at one of three
        frequencies up to the end of the band, or a force in x moves it in y by more.
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
            f"receptance at {where:.4g} Hz; such a stator can be used only if they agree within {100 * ALIKE:.0f} %",
        )
    note = f"x is used for both directions; at node {node} they differ by at most {100 * worst:.2g} % up to {band:g} Hz."
    return FiniteElementModel(**{**vars(model), "notes": (note,)})


def receptances(
    model: FiniteElementModel, rows: NDArray[np.int64], frequencies: NDArray[np.float64], solve: Solver
) -> ComplexArray:
    """Displacements of some coordinates for a unit force at each, (frequencies, n, n), m/N, at frequencies in Hz.

    From the motions K^-1 f, K^-1 M K^-1 f, ..., which match the receptances and their derivatives at zero frequency, until more
    of them make no difference: a single factorisation serves all frequencies.
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
