"""Machines whose coefficients follow the rotor speed: one model of those that a program gives at several speeds."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from rsc.errors import DataError
from rsc.machine.model.model import FiniteElementModel
from rsc.system.knots import FOLLOWING, Knots

MOST_KNOTS = 100
_SAME = 1e-9  # of a matrix against its largest entry: what does not follow the speed
_CONSTANT = {"mass": "mass", "gyroscopic": "gyroscopic", "anisotropic_mass": "mass", "rotating_damping": "rotating damping"}


def over_speed(models: Sequence[FiniteElementModel]) -> FiniteElementModel:
    """The model whose coefficients are those of the models at their speeds, and linear in between: that of the first with knots.

    Raises
    ------
    DataError
        Fewer than two, speeds that do not rise, other coordinates, or masses or gyroscopics that change.
    """
    first, source = models[0], models[0].source
    speeds = [model.speed for model in models if model.speed is not None]
    if not 2 <= len(models) == len(speeds) <= MOST_KNOTS:
        raise DataError(source, f"coefficients that follow the speed need 2 to {MOST_KNOTS} speeds, one for each model")
    for slower, faster in pairwise(speeds):
        if not faster > slower:
            raise DataError(source, f"rotor speed {faster:g} Hz must be more than {slower:g} Hz, the one before")
    for model in models[1:]:
        if not (np.array_equal(model.node, first.node) and np.array_equal(model.kind, first.kind)):
            raise DataError(source, f"its coordinates are not those of {model.source}")
        for name, word in _CONSTANT.items():
            if not _same(getattr(first, name), getattr(model, name)):
                raise DataError(source, f"the {word} is another one at {model.speed:g} Hz: it may not follow the rotor speed")
    parts = {}
    for name in FOLLOWING:
        matrices = [getattr(model, name) for model in models]
        if not all(_same(matrices[0], matrix, 0.0) for matrix in matrices):
            zero = 0.0 * first.mass
            known = [zero if matrix is None else matrix for matrix in matrices]
            differences = [matrix - known[0] for matrix in known]
            parts[name] = differences if first.is_sparse else np.array(differences)
    return replace(first, knots=Knots(2.0 * np.pi * np.array(speeds), parts), speed=None)


def _same(one, other, share=_SAME):
    """Whether two matrices, or none, are the same to a share of the largest entry."""
    if one is None or other is None:
        return one is other or not abs(other if one is None else one).max()
    return abs(one - other).max() <= share * abs(one).max()
