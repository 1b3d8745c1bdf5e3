"""Builds the `Body` to be reduced from a `FiniteElementModel` and its contacts, unbalances and loads."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.errors import DataError
from rsc.machine.model.model import DISPLACEMENT, TILT, FiniteElementModel
from rsc.system.body import Body
from rsc.system.knots import ANISOTROPIC
from rsc.units import eccentricity_of_grade


class Against(NamedTuple):
    """Two places of one body that may touch each other, each given as a Place."""

    node: int | str | Sequence[int | str | float]
    against: int | str | Sequence[int | str | float]


# a node by number or name, or [node, node, fraction of the distance], or two places that may touch
Place = int | str | Sequence[int | str | float] | Against


@dataclass(frozen=True)
class Unbalance:
    """Unbalance at a node: `amount` in kg m, or "G 6.3", a balance grade of ISO 21940 for the whole rotor; phase in degrees."""

    node: int | str
    amount: float | str
    phase: float = 0.0


def row_at(model: FiniteElementModel, place: Place) -> NDArray[np.float64]:
    """Row (n,) of the displacement at a node or between two nodes; for an `Against` that of the first minus the second place.

    Raises
    ------
    DataError
        No such place.
    """
    if isinstance(place, Against):
        row = row_at(model, place.node) - row_at(model, place.against)
        if not row.any():
            raise DataError(model.source, "a node cannot touch itself")
        return row
    if isinstance(place, (int, str)):
        return model.row_at(place)
    if len(place) != 3:
        raise DataError(model.source, "a place between two nodes is [node, node, fraction of the distance]")
    first, second, share = place
    return model.row_between(first, second, float(share))  # type: ignore[arg-type]


def total_mass(model: FiniteElementModel) -> float:
    """Mass of the whole body in kg."""
    moving = (model.kind == DISPLACEMENT).astype(float)
    return float(moving @ (model.mass @ moving))


def amounts_of(model: FiniteElementModel, unbalances: Sequence[Unbalance], speed: float) -> list[float]:
    """Unbalances m e in kg m.

    A balance grade means e Omega in mm/s at the speed (Hz) for the mass of the whole rotor; in two planes it is divided as in ISO
    21940-11, in inverse proportion to their distances from the centre of mass between them.

    Raises
    ------
    ValueError
        A text that is not a grade, a grade without a speed, or grades that cannot be divided.
    """
    graded = [item for item in unbalances if isinstance(item.amount, str)]
    if not graded:
        return [float(item.amount) for item in unbalances]
    eccentricity = eccentricity_of_grade(str(graded[0].amount), speed)
    if eccentricity is None:
        raise ValueError("an amount in kg m, or for a rotor that turns a grade such as \"G 6.3\" or \"G 6.3 at 3000 rpm\"")
    whole = total_mass(model) * eccentricity
    shares = iter(_shares(model, graded, whole))
    return [next(shares) * whole if isinstance(item.amount, str) else float(item.amount) for item in unbalances]


def _shares(model: FiniteElementModel, graded: Sequence[Unbalance], whole: float) -> list[float]:
    """Fractions of the permissible unbalance of the whole rotor (`whole`, kg m) in one or two planes."""
    if len(graded) == 1:
        return [1.0]
    instead = f"amounts in kg m instead of grades: for the whole rotor it is {whole:.4g} kg m"
    if len(graded) > 2 or graded[0].amount != graded[1].amount:
        raise ValueError(f"one grade in at most two planes, or {instead}")
    try:
        arms = np.array([model.position[model.node_of(item.node)] for item in graded]) - _centre_of_mass(model)
    except KeyError:
        raise ValueError(f"{instead}; without node positions it cannot be divided") from None
    if not arms[0] * arms[1] < 0.0:
        raise ValueError(f"on both sides of the centre of mass, or {instead}")
    first, second = np.abs(arms).tolist()
    return [second / (first + second), first / (first + second)]


def _centre_of_mass(model: FiniteElementModel) -> float:
    """Position in m of the centre of mass; KeyError if a node has no position."""
    pushed = model.mass @ (model.kind == DISPLACEMENT).astype(float)
    turned = [float(kind == TILT) if kind != DISPLACEMENT else model.position[node]
              for kind, node in zip(model.kind.tolist(), model.node.tolist(), strict=True)]  # fmt: skip
    return float(pushed @ turned) / total_mass(model)


def body_of(
    model: FiniteElementModel,
    contacts: Sequence[Place],
    unbalances: Sequence[Unbalance] = (),
    loads: Sequence[tuple[int | str, complex]] = (),
    gravity: float = 0.0,
    observers: Sequence[Place] = (),
    speed: float = 0.0,
) -> Body:
    """The Body of a model. Terms that act on the conjugate are not included.

    Parameters
    ----------
    model : FiniteElementModel
    contacts : sequence of Place, at least one
    unbalances : sequence of Unbalance
    loads : sequence of (node, force in N)
    gravity : float, m/s^2, along -z: every mass gets its weight, -i gravity M 1 on the displacements
    observers : sequence of Place
    speed : float, Hz, for balance grades

    Raises
    ------
    DataError, ValueError
        A place that does not exist in the model; an invalid unbalance.
    """
    rows = np.array([row_at(model, place) for place in contacts])
    vector = np.zeros(model.n, dtype=complex)
    for item, amount in zip(unbalances, amounts_of(model, unbalances, speed), strict=True):
        vector = vector + amount * np.exp(1j * np.deg2rad(item.phase)) * model.row_at(item.node)
    moving = (model.kind == DISPLACEMENT).astype(float)
    load = -1j * gravity * (model.mass @ moving)
    for node, force in loads:
        load = load + force * model.row_at(node)
    return Body(
        mass=model.mass,
        damping=model.damping,
        stiffness=model.stiffness,
        contact=rows if len(rows) > 1 else rows[0],
        gyroscopic=model.gyroscopic if abs(model.gyroscopic).max() > 0.0 else None,
        skew_stiffness=model.skew_stiffness,
        skew_damping=model.skew_damping,
        rotating_damping=model.rotating_damping,
        knots=None if model.knots is None else model.knots.without(ANISOTROPIC),
        unbalance=vector[:, None] if vector.any() else np.zeros((model.n, 0), dtype=complex),
        load=load,
        observers=np.array([row_at(model, place) for place in observers]).reshape(len(observers), model.n),
    )
