"""Determined and undetermined values of a fit: singular directions of its slopes, a profile for each value."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rsc.study.fit.free import Free
from rsc.study.fit.least import FINE, Residuals, ends, least
from rsc.study.fit.models import Values

TOLD = float(np.log(1.5))  # largest length of an interval in coordinates, a factor of 1.5
LINEAR = 0.03  # half of an interval, up to which slopes alone tell it
NAMED = 0.1  # least share of a value that is named in a direction
SMALLEST = 1e-6  # singular value, as that of a direction of which nothing is known
NEAR, LOOKS = 0.05, 8  # of the wanted rise of the sum of squares; points of a profile on a side at most


@dataclass(frozen=True)
class Fitted:
    """One value of a fit.

    name, unit : str; guess : float, of the scene; value : float, the best one; low, high : float, its 68 % interval
    told : bool, whether the interval is narrower than a factor 1.5 and ends inside the range that was allowed
    at_end : bool, whether the best value is an end of its range
    """

    name: str
    unit: str
    guess: float
    value: float
    low: float
    high: float
    told: bool
    at_end: bool


@dataclass(frozen=True)
class Direction:
    """A combination of relative changes of the values, and how well the run tells it.

    parts : dict, name -> its share, of unit length together; deviation : float, its standard deviation, relative; told : bool
    """

    parts: dict[str, float]
    deviation: float
    told: bool

    @property
    def words(self) -> str:
        """The combination as a product of powers; powers below a tenth are omitted."""
        return " ".join(f"{name}^{share:.2g}" for name, share in self.parts.items() if abs(share) >= NAMED)


def directions(free: list[Free], slopes: NDArray[np.float64], scale: float) -> tuple[Direction, ...]:
    """The directions of a fit, the best determined first; `scale`: standard deviation of the residuals."""
    _, sizes, axes = np.linalg.svd(slopes, full_matrices=True)
    sizes = np.concatenate([sizes, np.zeros(len(free) - len(sizes))])
    told = []
    for size, axis in zip(sizes, axes, strict=True):
        axis = axis * np.sign(axis[np.argmax(np.abs(axis))])
        deviation = scale / max(float(size), SMALLEST)
        parts = {one.name: float(share) for one, share in zip(free, axis, strict=True)}
        told.append(Direction(parts, deviation, 2.0 * deviation <= TOLD))
    return tuple(told)


def fitted(
    residuals: Residuals, point: Values, slopes: NDArray[np.float64], scale: float, by_slopes: bool = False
) -> tuple[Fitted, ...]:
    """The values of a fit with their intervals; `by_slopes`: without the profiles of wide ones, which take long."""
    _, sizes, axes = np.linalg.svd(slopes, full_matrices=True)
    sizes = np.maximum(np.concatenate([sizes, np.zeros(len(point) - len(sizes))]), SMALLEST)
    covariance = scale**2 * (axes.T / sizes**2) @ axes
    low_end, high_end = ends(residuals.models)
    best, values = residuals.cost(point), []
    for k, one in enumerate(residuals.models.free):
        half = float(np.sqrt(covariance[k, k]))
        sides = [point[k] - half, point[k] + half]
        if half > LINEAR and by_slopes:
            sides = [max(sides[0], low_end[k]), min(sides[1], high_end[k])]
        elif half > LINEAR:
            step = covariance[k] / covariance[k, k]
            sides = [_side(residuals, (point, best, scale), (k, end, half), step) for end in (low_end[k], high_end[k])]
        inside = low_end[k] < sides[0] and sides[1] < high_end[k]
        at_end = min(point[k] - low_end[k], high_end[k] - point[k]) < 1e-6
        low, high = (one.value(side) for side in sides)
        told = inside and sides[1] - sides[0] <= TOLD
        values.append(Fitted(one.name, one.unit, one.guess, one.value(float(point[k])), low, high, bool(told), bool(at_end)))
    return tuple(values)


def _side(
    residuals: Residuals, fit: tuple[Values, float, float], value: tuple[int, float, float], step: NDArray[np.float64]
) -> float:
    """Where a coordinate ends on one side: the least sum of squares with it held there is larger by the square of the scale.

    fit : best point, its sum of squares, scale; value : number of the coordinate, end of its range, half its interval by slopes
    step : change of the point by a unit of the coordinate, by slopes
    """
    (point, best, scale), (k, end, half) = fit, value
    reach = end - point[k]
    if reach == 0.0:
        return end

    def rise(away: float) -> float:
        """Root of the rise of the sum of squares over the scale: 1 is wanted, and it is nearly straight."""
        start = point + away * step
        start[k] = point[k] + away
        return float(np.sqrt(max(least(residuals, start, FINE, fixed=k)[1] - best, 0.0))) / scale

    inside, outside, low, high = 0.0, reach, 0.0, rise(reach)
    if high < 1.0:
        return end
    away = np.sign(reach) * min(half, 0.9 * abs(reach))
    for _ in range(LOOKS):
        rises = rise(away)
        if abs(rises - 1.0) < NEAR:
            break
        if rises < 1.0:
            inside, low = away, rises
        else:
            outside, high = away, rises
        share = np.clip((1.0 - low) / (high - low), 0.1, 0.9)
        away = inside + share * (outside - inside)
    return float(point[k] + away)
