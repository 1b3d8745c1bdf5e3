"""Assembly of a `FiniteElementModel` from a shaft and the positions of its nodes."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.linalg

from rsc.errors import DataError
from rsc.machine.imports.bearings import Bearing, with_bearings
from rsc.machine.imports.supports import Coefficients, with_supports
from rsc.machine.model.model import DISPLACEMENT, TILT, FiniteElementModel
from rsc.machine.shaft.element import element
from rsc.machine.shaft.parts import Shaft

MOST_NODES = 1000
_FULL = ("mass", "damping", "gyroscopic", "stiffness")


def model_of(shaft: Shaft, nodes: Sequence[float], source: str) -> FiniteElementModel:
    """The model of a shaft with its bearings.

    Parameters
    ----------
    shaft : Shaft
    nodes : sequence of float
        Node positions in m, increasing, including all `Shaft.stations`. Node i of the model is at nodes[i]; nodes of massless
        pieces without supports or named places are eliminated by static condensation.
    source : str
        For messages.

    Raises
    ------
    DataError
        Bearings with an indefinite stiffness.
    """
    bare = _condensed(bare_model(shaft, nodes, source), _busy(shaft, nodes))
    supports = [(i, support) for support in shaft.supports for i in [nearest(nodes, support.place)]]
    if any(len(support.speeds) > 1 for _, support in supports):
        tables: list[Coefficients] = [(i, support.speeds, support.coefficients) for i, support in supports]
        return with_supports(bare, tables, required=False)
    coefficients = [(i, support.coefficients[0].tolist()) for i, support in supports]
    bearings = [Bearing(i, tuple(eight[:4]), tuple(eight[4:])) for i, eight in coefficients]
    return with_bearings(bare, bearings, required=False)


def nearest(nodes: Sequence[float], place: float) -> int:
    """Number of the node at or nearest to a position in m."""
    return int(np.abs(np.asarray(nodes) - place).argmin())


def bare_model(shaft: Shaft, nodes: Sequence[float], source: str = "shaft") -> FiniteElementModel:
    """The shaft with its disks and tilt springs, without bearings; deflection and slope at every node."""
    n = 2 * len(nodes)
    mass, stiffness, gyroscopic, own_mass = (np.zeros((n, n)) for _ in range(4))
    for i, (start, end) in enumerate(pairwise(nodes)):
        rows = slice(2 * i, 2 * i + 4)
        for piece in shaft.pieces(start, end):
            for whole, matrix in zip((own_mass, stiffness, gyroscopic), element(piece, shaft.shear), strict=True):
                whole[rows, rows] += matrix
    alpha, beta = shaft.rayleigh
    damping, rotating = alpha * own_mass + beta * stiffness, shaft.rotating_damping * stiffness
    mass += own_mass
    for disk in shaft.disks:
        i = 2 * nearest(nodes, disk.place)
        mass[i, i] += disk.mass
        mass[i + 1, i + 1] += disk.diametral_inertia
        gyroscopic[i + 1, i + 1] += disk.polar_inertia
    for support in shaft.supports:
        i = 2 * nearest(nodes, support.place) + 1
        stiffness[i, i] += support.tilt_stiffness
        damping[i, i] += support.tilt_damping
    at = {node: float(place) for node, place in enumerate(nodes)}
    named = [*((one.name, one.place) for one in shaft.supports), *((disk.name, disk.place) for disk in shaft.disks)]
    return FiniteElementModel(
        source=source,
        node=np.repeat(np.arange(len(nodes)), 2),
        kind=np.array([DISPLACEMENT, TILT] * len(nodes)),
        mass=mass,
        damping=damping,
        gyroscopic=gyroscopic,
        stiffness=stiffness,
        rotating_damping=rotating if shaft.rotating_damping else None,
        free=True,
        names={name: nearest(nodes, place) for name, place in (*named, *shaft.places.items()) if name},
        position=at,
        diameter={node: shaft.diameter_at(place) for node, place in at.items()},
        shaft=shaft,
    )


def _busy(shaft: Shaft, nodes: Sequence[float]) -> set[int]:
    """Nodes with supports or named places (contacts, observers, ...)."""
    return {nearest(nodes, place) for place in (*(one.place for one in shaft.supports), *shaft.places.values())}


def _condensed(model: FiniteElementModel, busy: set[int]) -> FiniteElementModel:
    """The model with massless coordinates condensed statically, except displacements of `busy` nodes.

    x_m = -K_mm^-1 K_mk x_k, and every matrix becomes T^T (...) T.
    """
    massless = ~model.mass.any(axis=1) & ~model.gyroscopic.any(axis=1)
    massless &= (model.kind == TILT) | ~np.isin(model.node, list(busy))
    if not massless.any():
        return model
    gone, kept = np.flatnonzero(massless), np.flatnonzero(~massless)
    if not len(kept):
        raise DataError(model.source, "it has no mass")
    turn = np.zeros((model.n, len(kept)))
    turn[kept] = np.eye(len(kept))
    try:
        turn[gone] = -scipy.linalg.solve(model.stiffness[np.ix_(gone, gone)], model.stiffness[np.ix_(gone, kept)], assume_a="pos")
    except np.linalg.LinAlgError:
        raise DataError(model.source, "a massless piece is not supported") from None
    matrices: dict[str, Any] = {}
    for name in (*_FULL, "rotating_damping"):
        matrix: Any = getattr(model, name)
        if matrix is not None:
            matrices[name] = turn.T @ matrix @ turn
            matrices[name] = 0.5 * (matrices[name] + matrices[name].T)
    return replace(model, node=model.node[kept], kind=model.kind[kept], **matrices)
