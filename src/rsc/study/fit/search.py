"""Where a fit begins: predictions at many points of the ranges, and least squares on predictions from the best of them."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from rsc.errors import SolverError
from rsc.study.fit.least import PATIENT, ROUGH, Residuals, ends, least, robust
from rsc.study.fit.models import Models, Values

POINTS, STARTS = 1024, 8  # of Sobol's sequence; the best of them from which rough least squares begin
PATIENTLY = 4  # of what these reach, the best, from which least squares go on until one explains the run
EXPLAINS = 1.0  # mean square of residuals, below which a point does
WINDOWS, EDGE = 8, 0.15  # in which predictions are compared; part of a span at its ends where they are not
LARGEST = 0.01, 0.15  # median error of frequency and amplitude, relative, beyond which no point explains the run


def begin(models: Models, better: Callable[[Values], object] = lambda point: None) -> Values:
    """The point that predicts best what was measured; `better` gets the best one so far whenever there is a better one.

    Raises
    ------
    SolverError
        None predicts a stable whirl like the measured one.
    """
    windows = _inner(models)
    residuals, (low, high) = Residuals(models, windows), ends(models)
    points = low + (high - low) * qmc.Sobol(len(low), seed=0).random(POINTS)
    scores = robust(residuals.of(points)).mean(axis=1)
    best = np.argsort(scores, kind="stable")[:STARTS]
    better(points[best[0]])
    rough = sorted((least(residuals, points[k], ROUGH) for k in best), key=lambda reached: reached[1])
    better(rough[0][0])
    point = _patiently(models, residuals, [one for one, _ in rough[:PATIENTLY]])
    better(point)
    _refuse_impossible(models, windows, point)
    return point


def _patiently(models: Models, residuals: Residuals, starts: list[Values]) -> Values:
    """The best that least squares reach from some starts, a stable one before others; the first that explains the run.

    The valleys of many free values are long, narrow and bent: rough least squares end on their way down.
    """
    reached: list[tuple[bool, float, Values]] = []
    for start in starts:
        point, cost = least(residuals, start, PATIENT)
        reached.append((_unstable(models, residuals.windows, point) > len(residuals.windows) // 2, cost, point))
        if not reached[-1][0] and cost < EXPLAINS * len(residuals.of(point[None])[0]):
            break
    return min(reached, key=lambda one: one[:2])[2]


def _unstable(models: Models, windows: NDArray[np.intp], point: Values) -> int:
    """In how many windows the whirl of a point is unstable."""
    return int((models.predicted(point[None], windows).growth_rate[0] > 0.0).sum())


def _inner(models: Models) -> NDArray[np.intp]:
    """Some windows away from where the run comes to a whirl or leaves it, which it may do later than predicted."""
    inner = []
    for span in models.seen.spans:
        places = np.arange(span.own.start, span.own.stop)
        edge = int(EDGE * len(places))
        inner.append(places[edge : len(places) - edge])
    places = np.concatenate(inner)
    return np.asarray(places[np.unique(np.linspace(0, len(places) - 1, WINDOWS).round().astype(int))])


def _refuse_impossible(models: Models, windows: NDArray[np.intp], point: Values) -> None:
    seen, predicted = models.seen, models.predicted(point[None], windows)
    measured = np.log(np.abs(seen.lines.frequency[windows])), np.log(seen.lines.amplitude[windows])
    missed = [np.abs(predicted.features[0, :, i] - measured[i]) for i in range(2)]
    ranges = ", ".join(f"{one.name} from {one.low:.4g} to {one.high:.4g}" for one in models.free)
    where = f"{models.scene.source}: no scene with {ranges} has the measured whirl"
    if not np.isfinite(missed).any(axis=1).all():
        raise SolverError(f"{where}: the nearest has none")
    off = [float(np.nanmedian(part)) for part in missed]
    if off[0] > LARGEST[0] or off[1] > LARGEST[1]:
        frequency, amplitude = (f"{100.0 * part:.3g} %" for part in off)
        raise SolverError(f"{where}: the nearest misses its frequency by {frequency}, its amplitude by {amplitude}")
    unstable = _unstable(models, windows, point)
    if unstable > len(windows) // 2:
        raise SolverError(f"{where} as a stable one: it is unstable in {unstable} of {len(windows)} windows of the nearest scene")
