"""Undamped critical speeds of a shaft on bearings of any stiffness."""

from collections.abc import Collection, Sequence

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from rsc.machine.shaft.assembly import bare_model, nearest
from rsc.machine.shaft.parts import Shaft, Support

_ROUNDING = 1e-12  # of the largest 1/Omega^2: a smaller one is none


def undamped_criticals(
    shaft: Shaft, nodes: Sequence[float], stiffness: NDArray[np.float64], varied: Collection[int], most: int
) -> NDArray[np.float64]:
    """Speeds in Hz at which the undamped shaft whirls forward as fast as it turns, (k, most), increasing, NaN beyond the last.

    K phi = Omega^2 (M - G) phi, with the bearings isotropic. A disk with more polar than diametral inertia takes one away.

    Parameters
    ----------
    shaft : Shaft
    nodes : sequence of float
        Positions of the nodes in m.
    stiffness : (k,) N/m
        Of every varied support, in turn; the others keep the mean of both directions.
    varied : collection of int
        Numbers of the varied supports.
    most : int
        Number of speeds, the lowest.
    """
    model = bare_model(shaft, nodes)
    fixed, varying = np.array(model.stiffness), np.zeros(model.n)
    for i, support in enumerate(shaft.supports):
        row = 2 * nearest(nodes, support.place)
        if i in varied:
            varying[row] += 1.0
        else:
            fixed[row, row] += mean_stiffness(support)[0]
    speeds = np.full((len(stiffness), most), np.nan)
    for own, value in zip(speeds, stiffness, strict=True):
        inverse = scipy.linalg.eigh(model.mass - model.gyroscopic, fixed + value * np.diag(varying), eigvals_only=True)[::-1]
        lowest = inverse[inverse > _ROUNDING * abs(inverse[0])][:most]
        own[: len(lowest)] = 1.0 / np.sqrt(lowest) / (2.0 * np.pi)
    return speeds


def mean_stiffness(support: Support) -> NDArray[np.float64]:
    """Mean of both direct stiffnesses in N/m at every one of its speeds, (k,)."""
    mean: NDArray[np.float64] = 0.5 * (support.coefficients[:, 0] + support.coefficients[:, 3])
    return mean
