"""`fit(scene, measured, free)`: fit values of a scene to a measured run, with intervals."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from rsc.analysis.follow.patience import Note, silent
from rsc.arguments import FUNCTION, NAMED, RUN, SCENE, TEXTS, WHOLE, optional, takes
from rsc.measured.measured import Measured
from rsc.measured.run import measured_run
from rsc.presented import Brief
from rsc.scene.scene import Scene
from rsc.study.fit.free import free_values
from rsc.study.fit.least import FINE, ROBUST, Residuals, added_about, least
from rsc.study.fit.models import Models, Values
from rsc.study.fit.search import begin
from rsc.study.fit.seen import FEATURES, seen_of
from rsc.study.fit.told import Direction, Fitted, directions, fitted
from rsc.system.blas import one_thread
from rsc.system.system import only_one

ROUNDS = 12  # of simulations about a point
MOVED = 0.1  # deviations, together: a step that changes the residuals by less is none
SETTLED = 1.0  # deviations in a window: a step that changes less ends the robust least squares
FAR = 4.0  # times as much as most windows, and deviations, from which a window at the end of a span is left out
WORSE = 1.0  # rise of the sum of squares from which a step was too long
RISES = 2  # one after another, from which robust least squares end
MISSED = 0.0027  # share of windows that three standard deviations leave out
USED, HELD, LEFT_OUT = "fitted", "held back", "left out"
STOPPED = "interrupted: the best values until then, with intervals by slopes alone"
LOST = 0.5  # share of windows whose whirl the simulation does not show, from which a fit has not converged


@dataclass(frozen=True, repr=False)
class Fit(Brief):
    """A scene fitted to a measured run.

    scene : Scene, with the best values, also of those that are not told
    values : tuple of Fitted; directions : tuple of Direction, the best told first
    converged : bool, whether the last step changed nothing any more
    speed, time : (n_w,) Hz, s, of the windows that were compared
    use : (n_w,) of str, "fitted", "held back", or "left out" where the run comes to a whirl or leaves it
    residual : (n_w, 4) of frequency, amplitude and the two parts of the line at the rotor speed, over their standard deviations
    missed : (n_w,) bool, whether they are larger together than three standard deviations allow
    misfit : float, root of the sum of squares over the degrees of freedom: about 1, or smaller, of a scene that explains the run
    runs : int, simulations; warnings : tuple of str, first those of the measurement
    """

    scene: Scene
    values: tuple[Fitted, ...]
    directions: tuple[Direction, ...]
    converged: bool
    speed: NDArray[np.float64] = field(repr=False)
    time: NDArray[np.float64] = field(repr=False)
    use: NDArray[np.str_] = field(repr=False)
    residual: NDArray[np.float64] = field(repr=False)
    missed: NDArray[np.bool_] = field(repr=False)
    misfit: float
    runs: int
    warnings: tuple[str, ...]


@takes(scene=SCENE, measured=RUN, free=TEXTS, priors=optional(NAMED), threads=optional(WHOLE), note=FUNCTION)
@one_thread
def fit(
    scene: Scene,
    measured: Measured,
    free: str | Sequence[str],
    priors: Mapping[str, Any] | None = None,
    threads: int | None = None,
    note: Note = silent,
) -> Fit:
    """Fit values of a scene to the backward whirl of a measured run.

    Compared are its frequency, its amplitude and the line at the rotor speed against the mark of the shaft, in windows of which
    every third is held back. First the predictions of 1,024 scenes over the ranges of the values, then least squares on
    predictions from the best of them, then on simulations of the run.

    Parameters
    ----------
    scene : Scene
        With one contact; the rotor speed over time is the measured one.
    measured : Measured
        Of `rsc.read_measured`. Its probes stand at the contact.
    free : str or sequence of str
        Names of the values to fit, as `rsc.sweep` takes them: "contact.friction".
    priors : mapping
        Name of a free value -> the range it may lie in, (low, high) in SI or "0.1 mm:0.4 mm"; by default from a quarter to four
        times of what the scene has.
    threads : int, optional
        Of the simulations; the fit does not depend on it.
    note : callable, called with a line of text after each round of simulations

    Returns
    -------
    Fit

    Raises
    ------
    SceneError
        A value or range that the scene cannot have.
    SolverError
        Several contacts, or no scene in the ranges has a stable whirl like the measured one.
    DataError
        The measurement has too few windows on a backward whirl.
    KeyboardInterrupt
        Ctrl-C; once there are values its attribute `result` is the Fit of the best ones until then.

    Examples
    --------
    >>> scene = rsc.load_scene("laval.toml")
    >>> measured = rsc.read_measured(rsc.write_measured(rsc.simulate(scene), "bench.toml"))
    >>> found = rsc.fit(scene.with_values({"contact.friction": 0.18}), measured, "contact.friction")
    >>> round(found.scene.contacts[0].friction, 2)
    0.2
    """
    only_one(scene.contacts)
    names = (free,) if isinstance(free, str) else tuple(free)
    values = free_values(scene, names, priors or {})
    run: Any = measured_run(measured, scene.turning_forward())
    models = Models(scene, seen_of(run), values, threads)
    return fitted_models(models, note)


def fitted_models(models: Models, note: Note) -> Fit:
    """The Fit of models to a measured run; a KeyboardInterrupt carries that of the best values so far."""
    seen, best = models.seen, list[_FitEnd]()
    note(f"{len(seen.starts)} windows on a backward whirl, {int(seen.held.sum())} of them held back")
    try:
        start = begin(models, lambda point: best.append(_begun(models, point)))
        best.append(_refined(models, start, note, best.append))
        return _told(models, best[-1], note)
    except KeyboardInterrupt as stop:
        if best:
            fit = _told(models, best[-1], note, quickly=True)
            stop.result = replace(fit, converged=False, warnings=(STOPPED, *fit.warnings))  # type: ignore[attr-defined]
        raise


def _begun(models: Models, point: Values) -> "_FitEnd":
    """A point that only predictions have led to."""
    kept = np.ones(len(models.seen.starts), dtype=bool)
    return _FitEnd(point, Residuals(models, np.flatnonzero(~models.seen.held)), kept, converged=False)


def _told(models: Models, end: "_FitEnd", note: Note, quickly: bool = False) -> Fit:
    """The Fit at an end; quickly: with intervals by slopes alone."""
    seen, point, residuals = models.seen, end.point, end.residuals
    # what is measured alone: that a whirl which lasts is stable is a bound, and tells no direction by its slope
    slopes = residuals.slopes(point)[: len(residuals.windows) * FEATURES]
    misfit = float(np.sqrt(residuals.cost(point) / max(len(residuals.windows) * seen.told - len(point), 1)))
    scale = max(misfit, 1.0)
    if not quickly:
        note("intervals")
    told = fitted(residuals, point, slopes, scale, quickly)
    residual = _all_missed(residuals, point)
    missed = ((residual**2).sum(axis=1) > chi2.isf(MISSED, seen.told)) & end.kept
    use = np.where(~end.kept, LEFT_OUT, np.where(seen.held, HELD, USED))
    added = residuals.added
    lost = end.kept & added.lost if added is not None else ~end.kept
    return Fit(
        scene=models.scene_of(point),
        values=told,
        directions=directions(models.free, slopes, scale),
        converged=end.converged and float(lost.mean()) <= LOST,
        speed=seen.speed,
        time=seen.time,
        use=use,
        residual=residual,
        missed=missed,
        misfit=misfit,
        runs=models.runs,
        warnings=(*seen.run.warnings, *_warnings(seen.speed, use, missed, lost), *_at_ends(told)),
    )


class _FitEnd(NamedTuple):
    """Where least squares end: the point, its residuals, (n_w,) bool whether a window was kept, whether they converged."""

    point: Values
    residuals: Residuals
    kept: NDArray[np.bool_]
    converged: bool


def _refined(models: Models, start: Values, note: Note, better: Callable[[_FitEnd], object]) -> _FitEnd:
    """The end of least squares on simulations from a start; `better` gets the best point after each round that betters it.

    Robust ones first; then plain ones without the windows in which the run comes to a whirl or leaves it. These are also left out
    where steps go wrong `RISES` times one after another: slopes in such windows lead nowhere.
    """
    windows, held = np.arange(len(models.seen.starts)), models.seen.held
    kept = np.ones(len(windows), dtype=bool)
    point, best, cost_before, how, rises, whole = start, start, np.inf, ROBUST, 0, Residuals(models, windows)
    for number in range(ROUNDS):
        added = added_about(models, point)
        residuals = Residuals(models, windows[kept & ~held], added)
        cost = residuals.cost(point, how)
        note(f"round {number + 1}: {models.runs} runs, sum of squares {cost:.4g}")
        if cost > cost_before + WORSE:
            rises += 1
            steady = kept & _steady(models, whole, best) & _steady(models, Residuals(models, windows, added), point)
            if rises < RISES or (how is FINE and (steady == kept).all()):
                point = 0.5 * (best + point)
            else:
                point, kept, how, cost_before, rises = best, steady, FINE, np.inf, 0
            continue
        best, cost_before, rises = point, cost, 0
        better(_FitEnd(best, residuals, kept, converged=False))
        whole = Residuals(models, windows, added)
        point, _ = least(residuals, best, how)
        step = float(np.linalg.norm(residuals.slopes(point) @ (point - best)))
        if step < (MOVED * max(1.0, np.sqrt(cost / len(residuals.windows))) if how is FINE else SETTLED * np.sqrt(len(windows))):
            steady = kept & _steady(models, whole, point)
            if how is FINE and (steady == kept).all():
                return _FitEnd(point, residuals, kept, converged=True)
            kept, how, cost_before = steady, FINE, np.inf
    return _FitEnd(best, Residuals(models, windows[kept & ~held], added_about(models, best)), kept, converged=False)


def _steady(models: Models, residuals: Residuals, point: Values) -> NDArray[np.bool_]:
    """(n_w,) bool, windows that are kept: not those, one after another from the ends of a span on, that are missed far more than
    most windows are, or in which the simulation has no whirl. There the run comes to its whirl or leaves it, which hangs on where
    it came from and on noise."""
    size = np.sqrt((residuals.missed(residuals.features(point[None]))[0] ** 2).sum(axis=1))
    away = (size > FAR * np.median(size)) & (size > FAR)
    lost = np.zeros(len(size), dtype=bool) if residuals.added is None else residuals.added.lost
    if lost.mean() <= LOST:
        away |= lost
    kept = np.ones(len(size), dtype=bool)
    for span in models.seen.spans:
        own = ~away[span.own]
        begin, end = (int(np.argmax(own)), len(own) - int(np.argmax(own[::-1]))) if own.any() else (0, 0)
        kept[span.own] = (np.arange(len(own)) >= begin) & (np.arange(len(own)) < end)
    return kept


def _all_missed(residuals: Residuals, point: Values) -> NDArray[np.float64]:
    """(n_w, 4) residuals of all windows, also of those that were held back, without the common errors that the others show."""
    models = residuals.models
    whole = Residuals(models, np.arange(len(models.seen.starts)), residuals.added)
    missed = whole.missed(whole.features(point[None]))[0]
    return whole.without(missed, residuals.common(missed[residuals.windows]))


def _warnings(speed: NDArray[np.float64], use: NDArray[np.str_], missed: NDArray[np.bool_], lost: NDArray[np.bool_]) -> list[str]:
    lines, held = [], use == HELD
    if (missed & held).any():
        where = f"{int((missed & held).sum())} of {int(held.sum())} windows that were held back, {_speeds(speed[missed & held])}"
        but = "the scene does not explain the run, and its values may be wrong beyond their intervals"
        lines.append(f"missed by more than three standard deviations: {where}: {but}")
    left = use == LEFT_OUT
    if left.any():
        where = f"{int(left.sum())} of {len(use)} windows, {_speeds(speed[left])}"
        lines.append(f"left out: {where}, where the run comes to its whirl or leaves it")
    if lost.any():
        where = f"{int(lost.sum())} of {len(use)} windows, {_speeds(speed[lost])}"
        lines.append(f"the simulation does not show the whirl in {where}: compared with the prediction there")
    return lines


def _speeds(speed: NDArray[np.float64]) -> str:
    low, high = f"{speed.min():.4g}", f"{speed.max():.4g}"
    return f"at {low} Hz" if low == high else f"between {low} and {high} Hz"


def _at_ends(values: tuple[Fitted, ...]) -> list[str]:
    ended = [value.name for value in values if value.at_end]
    return [f"at an end of its range: {', '.join(ended)}"] if ended else []
