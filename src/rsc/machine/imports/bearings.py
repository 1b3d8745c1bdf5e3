"""Bearings and seals that a scene adds at nodes of a model: springs and dashpots to ground."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from rsc.machine.checks.rank import held, lowest_motions
from rsc.machine.model.model import FiniteElementModel

_MISSING = "bearings are missing"


@dataclass(frozen=True)
class Bearing:
    """Coefficients at a node: a force -(k_xx x + k_xy y) - (c_xx x' + c_xy y') in x, and so on in y.

    node : int or str
    stiffness, damping : [xx, xy, yx, yy] in N/m and N s/m
    """

    node: int | str
    stiffness: tuple[float, float, float, float]
    damping: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


def with_bearings(model: FiniteElementModel, bearings: Sequence[Bearing], required: bool = True) -> FiniteElementModel:
    """The model with bearings added; required: whether they must hold it.

    With u = x + i y their force is -(mean + i skew) u - anisotropic conj(u) with

        mean = (k_xx + k_yy) / 2,   skew = (k_yx - k_xy) / 2,   anisotropic = (k_xx - k_yy + i (k_xy + k_yx)) / 2.

    Raises
    ------
    DataError
        No such node, or rigid-body motions or an indefinite stiffness remain.
    """
    fields: dict[str, Any] = {}
    for bearing in bearings:
        row = model.row_at(bearing.node)
        place = scipy.sparse.csc_array(row[:, None]) if model.is_sparse else row[:, None]
        place = place @ place.T
        for name, (xx, xy, yx, yy) in (("stiffness", bearing.stiffness), ("damping", bearing.damping)):
            parts = {
                name: 0.5 * (xx + yy),
                f"skew_{name}": 0.5 * (yx - xy),
                f"anisotropic_{name}": 0.5 * (xx - yy + 1j * (xy + yx)),
            }
            for part, value in parts.items():
                if value:
                    before = fields.get(part, getattr(model, part))
                    fields[part] = value * place if before is None else before + value * place
    if not bearings and not model.free:
        return model
    model = replace(model, **fields)
    if not required and lowest_motions(model.mass, model.stiffness, model.source, model.rounding).free:
        return replace(model, free=True)
    for speed in () if model.knots is None else model.knots.speed[1:]:  # the first knot is the model itself
        held(model.mass, model.at_speed(speed / (2.0 * np.pi)).stiffness, model.source, _MISSING, model.rounding)
    held(model.mass, model.stiffness, model.source, _MISSING, model.rounding)
    return replace(model, free=False)


def refuse_loose(model: FiniteElementModel, rows: Sequence[NDArray[np.float64]]) -> None:
    """DataError for a free model with motions that its contacts, (n,) rows, do not catch."""
    stiffness = model.stiffness
    for row in rows:
        place = scipy.sparse.csc_array(row[:, None]) if model.is_sparse else row[:, None]
        stiffness = stiffness + float(stiffness.diagonal().max()) * (place @ place.T)
    advice = f"{_MISSING}; without them contacts at two or more places must hold the rotor"
    held(model.mass, stiffness, model.source, advice, model.rounding)
