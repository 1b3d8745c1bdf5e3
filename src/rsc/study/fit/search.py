"""Where a fit begins: predictions at many points of the ranges, and least squares on predictions from the best of them."""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from rsc.errors import SolverError
from rsc.study.fit.least import ROUGH, Residuals, ends, least, robust
from rsc.study.fit.models import Models, Values

POINTS, STARTS = 1024, 5  # of Sobol's sequence; the best of them from which least squares begin
WINDOWS, EDGE = 8, 0.15  # in which predictions are compared; part of a span at its ends where they are not
LARGEST = 0.01, 0.15  # median error of frequency and amplitude, relative, beyond which no point explains the run


def begin(models: Models) -> Values:
    """The point that predicts best what was measured.

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
    reached = [least(residuals, points[k], ROUGH) for k in best]
    point = min(reached, key=lambda pair: pair[1])[0]
    _refuse_impossible(models, windows, point)
    return point


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
    unstable = int((predicted.growth_rate[0] > 0.0).sum())
    if unstable > len(windows) // 2:
        raise SolverError(f"{where} and is stable: that of the nearest is unstable in {unstable} of {len(windows)} windows")
