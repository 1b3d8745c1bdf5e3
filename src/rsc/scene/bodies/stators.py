"""The models of [stator]: their keys, defaults, checks and matrices, as frozen dataclasses."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from rsc.scene.bodies.body_model import BodyModel
from rsc.scene.bodies.lumped import ChainBody, LavalBody, MatricesBody
from rsc.scene.files.matrix_files import is_definite
from rsc.scene.keys.keys import RawTable


@dataclass(frozen=True, kw_only=True)
class RigidStator(BodyModel):
    """[stator] model = "rigid": a rigid wall."""

    model = "rigid"
    n_coordinates = 0

    def mass_matrix(self) -> Any:
        """Empty matrix, no coordinates."""
        return np.zeros((0, 0))

    stiffness_matrix = damping_matrix = mass_matrix


@dataclass(frozen=True, kw_only=True)
class LavalStator(LavalBody):
    """[stator] model = "laval": one elastically held ring."""

    @staticmethod
    def resolve(values: Any, table: RawTable) -> None:
        """Check that the ring has a stiffness."""
        if values["stiffness"] == 0.0:
            table.refuse("stiffness", 0.0, "> 0 N/m", "the stator must be supported")


@dataclass(frozen=True, kw_only=True)
class ChainStator(ChainBody):
    """[stator] model = "chain": masses in a row."""

    @staticmethod
    def resolve(values: Any, table: RawTable) -> None:
        """Check the lists of a chain; each mass must be connected to a wall."""
        ChainBody.resolve(values, table)
        springs = values["stiffnesses"]
        breaks = [i for i, spring in enumerate(springs) if spring == 0.0]
        # masses between two breaks are connected to neither wall
        if len(breaks) > 1:
            table.refuse("stiffnesses", springs, "with at most one 0", "the stator must be supported")


@dataclass(frozen=True, kw_only=True)
class MatricesStator(MatricesBody):
    """[stator] model = "matrices": any symmetric stator."""

    @staticmethod
    def resolve(values: Any, table: RawTable) -> None:
        """Check the matrices; the stator must not have rigid-body motions."""
        MatricesBody.resolve(values, table)
        if not is_definite(values["stiffness"], strictly=True):
            table.refuse("stiffness", values["stiffness"], "positive definite", "the stator must be supported")
