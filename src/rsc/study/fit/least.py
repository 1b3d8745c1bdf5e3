"""Least squares between a measured run and predictions, corrected by simulations."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import least_squares

from rsc.study.fit.models import Models, PredictedFeatures, Values, features_of
from rsc.study.fit.seen import PHASE

STEP = 1e-4  # of the coordinates, for derivatives of predictions
SIMULATED_STEP = 0.005  # for those of what simulations add, which is small but known less exactly
FARTHEST = 0.3  # from where simulations were made, to which their addition is continued on a straight line
MISSING = 1e3  # residual of a whirl that a model does not have
UNSTABLE = 3e-3  # growth rate over frequency in rad/s that counts as much as a deviation of one: a whirl outlives its stability
PULL = 1e-3  # deviations by a relative change of 1
# least deviations of a prediction, relative: it knows neither the run-up nor the second order of the unbalance
PREDICTED = 1e-3, 1e-2, 0.1
OUTLIER = 3.0  # residual from which one counts by its size alone in robust least squares


@dataclass(frozen=True)
class Added:
    """What simulations about a point add to its prediction.

    at : (n_free,); offset : (n_w, 4); slope : (n_free, n_w, 4)
    lost : (n_w,) bool, windows in which a simulation does not show the whirl: nothing is added there
    """

    at: Values
    offset: NDArray[np.float64]
    slope: NDArray[np.float64]
    lost: NDArray[np.bool_]

    def to(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k, n_w, 4) corrections at points (k, n_free)."""
        away = np.clip(points - self.at, -FARTHEST, FARTHEST)
        return np.asarray(self.offset + np.tensordot(away, self.slope, 1))


def added_about(models: Models, point: Values) -> Added:
    """Corrections of predictions by simulations at a point and its neighbours in every coordinate."""
    points = point + SIMULATED_STEP * np.eye(len(point) + 1, len(point), -1)
    predicted = models.predicted(points, np.arange(len(models.seen.starts))).features
    beyond = models.simulated(points) - predicted
    lost = np.asarray(~np.isfinite(beyond).all(axis=(0, 2)))
    beyond[:, lost] = 0.0
    return Added(point, beyond[0], (beyond[1:] - beyond[0]) / SIMULATED_STEP, lost)


class How(NamedTuple):
    """How least squares are made: relative change at which they end, steps at most, and whether large residuals count by their
    size, not its square, so that some windows cannot rule the rest."""

    change: float
    steps: int
    robust: bool


ROUGH, PATIENT = How(1e-3, 30, True), How(1e-5, 300, True)
ROBUST, FINE = How(1e-6, 60, True), How(1e-9, 60, False)


def robust(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Squares of residuals, of large ones twice `OUTLIER` times their size."""
    return np.asarray(2.0 * OUTLIER**2 * (np.sqrt(1.0 + (values / OUTLIER) ** 2) - 1.0))


class Residuals:
    """Residuals of points (k, n_free) in some windows, over their deviations.

    Those of a window are its four features, those of all windows then how unstable their whirls are, in the end the values, which
    are pulled to those of the scene so weakly that only what nothing else tells stays there. What is left of the runout
    and the angle of the mark are wrong in the same way in all lines at the rotor speed: `of` has these in the axes in which their
    errors are independent, by Cholesky's factor of their covariance.

    added : Added, or None for predictions alone, whose deviations are larger
    """

    def __init__(self, models: Models, windows: NDArray[np.intp], added: Added | None = None) -> None:
        self.models, self.windows, self.added = models, windows, added
        seen = models.seen
        size = seen.lines.amplitude
        order = PREDICTED[2] * np.abs(seen.lines.order) / size
        least = np.column_stack([np.full((len(size), 2), PREDICTED[:2]), order, order])
        if added is not None:
            least *= added.lost[:, None]
        deviation = np.hypot(seen.deviation, least)
        deviation[:, 2:] *= size[:, None]
        self._guess = np.array([one.coordinate(one.guess) for one in models.free])
        self._deviation, self._measured = deviation[windows], features_of(seen.lines)[windows]
        line, nothing = seen.lines.order[windows], np.zeros(len(windows))
        common = [[nothing + seen.runout, nothing], [nothing, nothing + seen.runout], [-PHASE * line.imag, PHASE * line.real]]
        shapes = np.array(common).transpose(2, 1, 0) / self._deviation[:, 2:, None]
        self._common = shapes.reshape(2 * len(windows), len(common))  # deviations of the common errors, over those of each line
        self._factor = np.linalg.cholesky(np.eye(len(self._common)) + self._common @ self._common.T)

    def of(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k, 5 n_w + n_free) residuals in independent axes."""
        predicted, k = self.models.predicted(points, self.windows), len(points)
        missed = self.missed(self._with_added(points, predicted))
        lines = solve_triangular(self._factor, missed[..., 2:].reshape(k, -1).T, lower=True).T
        pull = PULL * (points - self._guess)
        return np.concatenate([missed[..., :2].reshape(k, -1), lines, _instability(predicted), pull], axis=1)

    def features(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k, n_w, 4) features of points."""
        return self._with_added(points, self.models.predicted(points, self.windows))

    def _with_added(self, points: NDArray[np.float64], predicted: PredictedFeatures) -> NDArray[np.float64]:
        return predicted.features + (0.0 if self.added is None else self.added.to(points)[:, self.windows])

    def missed(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k, n_w, 4) residuals of features (k, n_w, 4)."""
        return np.asarray(np.nan_to_num((features - self._measured) / self._deviation, nan=MISSING))

    def common(self, missed: NDArray[np.float64]) -> NDArray[np.float64]:
        """(3,) the common errors that residuals (n_w, 4) show, over their deviations."""
        normal = np.eye(self._common.shape[1]) + self._common.T @ self._common
        return np.asarray(np.linalg.solve(normal, self._common.T @ missed[:, 2:].ravel()))

    def without(self, missed: NDArray[np.float64], common: NDArray[np.float64]) -> NDArray[np.float64]:
        """Residuals (n_w, 4) without common errors."""
        return np.concatenate([missed[:, :2], missed[:, 2:] - (self._common @ common).reshape(-1, 2)], axis=1)

    def cost(self, point: Values, how: How = FINE) -> float:
        """Sum of the squares at a point, plain or robust ones."""
        values = self.of(point[None])[0]
        return float((robust(values) if how.robust else values**2).sum())

    def slopes(self, point: Values) -> NDArray[np.float64]:
        """(m, n_free) derivatives at a point."""
        steps = STEP * np.eye(len(point))
        up, down = np.split(self.of(np.concatenate([point + steps, point - steps])), 2)
        return np.asarray((up - down).T / (2.0 * STEP))


def _instability(predicted: PredictedFeatures) -> NDArray[np.float64]:
    return np.maximum(np.nan_to_num(predicted.growth_rate, nan=0.0), 0.0) / UNSTABLE


def ends(models: Models) -> tuple[Values, Values]:
    """Coordinates of the lowest and the highest values."""
    low, high = zip(*((one.coordinate(one.low), one.coordinate(one.high)) for one in models.free), strict=True)
    return np.array(low), np.array(high)


def least(residuals: Residuals, start: Values, how: How = FINE, fixed: int | None = None) -> tuple[Values, float]:
    """(point, sum of squares there) of the least squares from a start, inside the ranges.

    fixed : number of a coordinate that stays as it is
    """
    low, high = ends(residuals.models)
    margin = 1e-9 * (high - low)
    begin = np.clip(start, low + margin, high - margin)
    if fixed is not None:
        begin[fixed] = start[fixed]
    own = np.array([k for k in range(len(start)) if k != fixed], dtype=int)
    if not len(own):
        return begin, residuals.cost(begin)

    def whole(part: Values) -> Values:
        point = begin.copy()
        point[own] = part
        return point

    optimum = least_squares(
        lambda part: residuals.of(whole(part)[None])[0],
        begin[own],
        jac=lambda part: residuals.slopes(whole(part))[:, own],
        bounds=(low[own], high[own]),
        max_nfev=how.steps,
        ftol=how.change,
        xtol=how.change,
        gtol=None,
        loss="soft_l1" if how.robust else "linear",
        f_scale=OUTLIER,
    )
    return whole(optimum.x), 2.0 * float(optimum.cost)
