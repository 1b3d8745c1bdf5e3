"""Speed-dependent coefficients: combines models given at several rotor speeds into one."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from rsc.errors import DataError
from rsc.machine.model.model import FiniteElementModel
from rsc.system.knots import FOLLOWING, Knots

MOST_KNOTS = 100
_SAME = 1e-9  # relative to the largest entry: smaller changes of a matrix count as constant
_CONSTANT = {"mass": "mass", "gyroscopic": "gyroscopic", "anisotropic_mass": "mass", "rotating_damping": "rotating damping"}

_ADDED = "; of a seal's added mass keep one value, and give its change m at the whirl frequency w as a stiffness -m w^2"


def over_speed(models: Sequence[FiniteElementModel]) -> FiniteElementModel:
    """The first model with knots: coefficients equal those of the models at their speeds and are linear in between.

    Raises
    ------
    DataError
        Fewer than two models, speeds that do not increase, different coordinates, or masses or gyroscopics that change.
    """
    first, source = models[0], models[0].source
    speeds = [model.speed for model in models if model.speed is not None]
    if not 2 <= len(models) == len(speeds) <= MOST_KNOTS:
        raise DataError(source, f"speed-dependent coefficients need 2 to {MOST_KNOTS} speeds, one per model")
    for slower, faster in pairwise(speeds):
        if not faster > slower:
            raise DataError(source, f"rotor speed {faster:g} Hz must be above the previous one, {slower:g} Hz")
    for model in models[1:]:
        if not (np.array_equal(model.node, first.node) and np.array_equal(model.kind, first.kind)):
            raise DataError(source, f"its coordinates differ from those of {model.source}")
        for name, word in _CONSTANT.items():
            if not _same(getattr(first, name), getattr(model, name)):
                problem = f"the {word} differs at {model.speed:g} Hz: it must not depend on the rotor speed"
                raise DataError(source, f"{problem}{_ADDED if name == 'mass' else ''}")
    parts = {}
    for name in FOLLOWING:
        matrices = [getattr(model, name) for model in models]
        if not all(_same(matrices[0], matrix, 0.0) for matrix in matrices):
            zero = 0.0 * first.mass
            known = [zero if matrix is None else matrix for matrix in matrices]
            differences = [matrix - known[0] for matrix in known]
            parts[name] = differences if first.is_sparse else np.array(differences)
    return replace(first, knots=Knots(2.0 * np.pi * np.array(speeds), parts), speed=None)


def _same(one: Any, other: Any, share: float = _SAME) -> bool:
    """Whether two matrices (None: zero) are equal up to a fraction of the largest entry."""
    if one is None or other is None:
        return one is other or not abs(other if one is None else one).max()
    return abs(one - other).max() <= share * abs(one).max()
