"""What the models of [rotor] and [stator] made of masses have in common: one mass, a chain, matrices.

Input is kept as given (a frequency stays a frequency, a damping ratio a ratio), so that a sweep over the mass does what is
expected; `rsc.system.assemble` gets the matrices from a model.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from rsc.scene.bodies.body_model import (
    MASS,
    RATIO,
    RATIO_MEANING,
    RAYLEIGH,
    RAYLEIGH_MEANING,
    STIFFNESS,
    SUPPORTS,
    SUPPORTS_MEANING,
    BodyModel,
)
from rsc.scene.bodies.states import HasStates
from rsc.scene.files.matrix_files import MatrixReader, is_definite, refuse_asymmetric
from rsc.scene.keys import mirror
from rsc.scene.keys.keys import RawTable, declare
from rsc.scene.keys.readers import MAX_COORDINATES, Number, Sequence


@dataclass(frozen=True, kw_only=True)
class LavalBody(HasStates, BodyModel):
    """One mass on an isotropic spring and dashpot."""

    mass: float = declare(MASS, meaning="Mass of the body.")
    frequency: float | None = declare(
        Number("frequency", above=0.0), None, meaning="Undamped natural frequency, instead of the stiffness."
    )
    stiffness: float | None = declare(STIFFNESS, None, meaning="Isotropic stiffness.")
    damping_ratio: float | None = declare(RATIO, None, meaning="Damping ratio of the body.")
    damping: float | None = declare(Number("damping"), None, meaning="Damping constant of the dashpot.")
    supports: tuple = declare(SUPPORTS, (), meaning=SUPPORTS_MEANING, mirror=mirror.supports)

    one_of = ((("frequency", "stiffness"), None), (("damping_ratio", "damping"), ("damping", 0.0)))
    model = "laval"
    n_coordinates = 1

    def mass_matrix(self) -> Any:
        """[[mass]]."""
        return [[self.mass]]

    @property
    def total_mass(self) -> float:
        """Its mass in kg."""
        return self.mass

    def stiffness_matrix(self) -> Any:
        """[[stiffness]], given or from the natural frequency."""
        frequency: Any = self.frequency
        return [[self.mass * (2.0 * math.pi * frequency) ** 2 if self.stiffness is None else self.stiffness]]

    def damping_matrix(self) -> Any:
        """[[damping]]."""
        return [[self.damping]]


@dataclass(frozen=True, kw_only=True)
class ChainBody(HasStates, BodyModel):
    """Masses in a row between two walls, with springs (and dashpots) wall-1, 1-2, ..., N-wall."""

    masses: tuple = declare(Sequence(MASS), meaning="Masses in order, one coordinate each.")
    stiffnesses: tuple = declare(
        Sequence(STIFFNESS), meaning="Springs wall-1, 1-2, ..., N-wall, one more than masses; 0 for a free end."
    )
    damping_ratio: float | None = declare(RATIO, None, meaning=RATIO_MEANING)
    dampings: tuple | None = declare(Sequence(Number("damping")), None, meaning="Dashpots parallel to the springs.")
    rayleigh: tuple | None = declare(RAYLEIGH, None, meaning=RAYLEIGH_MEANING)
    supports: tuple = declare(SUPPORTS, (), meaning=SUPPORTS_MEANING, mirror=mirror.supports)

    one_of = ((("damping_ratio", "dampings", "rayleigh"), ("dampings", ())),)
    model = "chain"

    @property
    def n_coordinates(self) -> int:
        """Number of masses."""
        return len(self.masses)

    def mass_matrix(self) -> Any:
        """The masses on the diagonal."""
        return np.diag(self.masses)

    @property
    def total_mass(self) -> float:
        """The sum of the masses in kg."""
        return float(sum(self.masses))

    def stiffness_matrix(self) -> Any:
        """Tridiagonal matrix of the springs."""
        return links(self.stiffnesses)

    def damping_matrix(self) -> Any:
        """Tridiagonal matrix of the dashpots."""
        return links(self.dampings)

    @staticmethod
    def resolve(values: Any, table: RawTable) -> None:
        """Check list lengths; dampings default to zeros."""
        count = len(values["masses"])
        if not 0 < count <= MAX_COORDINATES:
            table.refuse("masses", values["masses"], f"a list of 1 to {MAX_COORDINATES} masses")
        if values["dampings"] == () and "dampings" not in table.values:
            values["dampings"] = (0.0,) * (count + 1)
        for key in ("stiffnesses", "dampings"):
            refuse_other_links(values, table, key)


def refuse_other_links(values: Any, table: RawTable, key: str) -> None:
    """SceneError unless there is one number for each spring of a chain."""
    count = len(values["masses"])
    if values[key] is not None and len(values[key]) != count + 1:
        hint = "wall-1, 1-2, ..., N-wall; 0 for a free end"
        table.refuse(key, values[key], f"a list of {count + 1} numbers for {count} masses", hint)


def links(constants: Any) -> Any:
    """Matrix of springs or dashpots wall-1, 1-2, ..., N-wall (N + 1 numbers)."""
    links = np.array(constants)
    inner = links[1:-1]
    return np.diag(links[:-1] + links[1:]) - np.diag(inner, 1) - np.diag(inner, -1)


@dataclass(frozen=True, kw_only=True)
class MatricesBody(HasStates, BodyModel):
    """Any mass, damping and stiffness matrices."""

    mass: tuple = declare(MatrixReader(), meaning="Mass matrix, symmetric and positive definite.")
    stiffness: tuple = declare(
        MatrixReader(), meaning="Stiffness matrix, symmetric and positive semidefinite (of a stator: definite)."
    )
    damping: tuple | None = declare(MatrixReader(), None, meaning="Damping matrix, symmetric and positive semidefinite.")
    damping_ratio: float | None = declare(RATIO, None, meaning=RATIO_MEANING)
    rayleigh: tuple | None = declare(RAYLEIGH, None, meaning=RAYLEIGH_MEANING)
    skew_stiffness: tuple | None = declare(
        MatrixReader(),
        None,
        meaning="Cross-coupled stiffness S, symmetric, k_zy = -k_yz = S: K + i S in y + i z.",
        mirror=mirror.negative,
    )
    skew_damping: tuple | None = declare(
        MatrixReader(), None, meaning="Cross-coupled damping Q, symmetric: B + i Q.", mirror=mirror.negative
    )
    supports: tuple = declare(SUPPORTS, (), meaning=SUPPORTS_MEANING, mirror=mirror.supports)

    one_of = ((("damping", "damping_ratio", "rayleigh"), ("damping", ())),)
    model = "matrices"

    @property
    def n_coordinates(self) -> int:
        """Number of rows."""
        return len(self.mass)

    def mass_matrix(self) -> Any:
        """As given."""
        return self.mass

    def stiffness_matrix(self) -> Any:
        """As given."""
        return self.stiffness

    def damping_matrix(self) -> Any:
        """As given."""
        return self.damping

    @staticmethod
    def resolve(values: Any, table: RawTable) -> None:
        """Check sizes, symmetry and definiteness; damping and gyroscopic default to zeros."""
        count = len(values["mass"])
        for key in ("damping", "gyroscopic"):
            if values.get(key) == () and key not in table.values:
                values[key] = ((0.0,) * count,) * count
        for key in ("mass", "stiffness", "damping", "gyroscopic", "skew_stiffness", "skew_damping"):
            if values.get(key) is not None:
                refuse_asymmetric(table, key, values[key], count)
        if not is_definite(values["mass"], strictly=True):
            table.refuse("mass", values["mass"], "positive definite")
        refuse_indefinite_stiffness(values, table)


def refuse_indefinite_stiffness(values: Any, table: RawTable) -> None:
    if not is_definite(values["stiffness"], strictly=False):
        hint = "it is statically unstable"
        table.refuse("stiffness", values["stiffness"], "positive semidefinite", hint)
