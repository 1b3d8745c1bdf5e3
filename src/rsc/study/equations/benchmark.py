"""`rsc.benchmark`: an integrator from outside in the chart of error against time, beside rsc's two methods."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsc.arguments import FUNCTION, LINE, SCENE, TEXT, ArgumentKind, optional, takes
from rsc.errors import SolverError
from rsc.files.tables import Table
from rsc.presented import Brief, drawing
from rsc.scene.scene import Scene
from rsc.study.equations.equations import Equations
from rsc.study.equations.reference import reference
from rsc.study.run.start import run_of

OWN = ("rk45", "taylor8")
TOLERANCES = tuple(10.0**-i for i in range(4, 11))
TOO_CLOSE = 3.0  # times the error of the reference: an error below says nothing

# (equations, times (n_times,) in s, a tolerance or step) -> states (n_times, n_state)
Integrator = Callable[[Equations, NDArray[np.float64], float], Any]


@dataclass(frozen=True)
class Point:
    """One run: method, its tolerance or step, largest error of any displacement in gaps, processor time in s; error and time are
    NaN where it failed, and `cause` says why."""

    method: str
    setting: float
    error: float
    seconds: float
    cause: str = ""


@dataclass(frozen=True, repr=False)
class Benchmark(Brief):
    """Error against time of some methods on one scene.

    points : tuple of Point; scene : Scene; reference_error : float, of the reference solution, in gaps
    reference : (n_times, n_coordinates) complex m, the reference solution
    """

    points: tuple[Point, ...]
    scene: Scene
    reference_error: float
    reference: NDArray[np.complex128]

    def seconds_at(self, error: float) -> dict[str, float]:
        """Processor time in s that each method needs for an error in gaps, between its points; NaN where it was not that exact,
        or nowhere so coarse."""
        return {method: self._at(method, error) for method in dict.fromkeys(point.method for point in self.points)}

    def _at(self, method: str, error: float) -> float:
        known = sorted((p.error, p.seconds) for p in self.points if p.method == method and p.error > 0.0)
        errors, seconds = np.log(np.array(known).reshape(-1, 2)).T
        if not len(errors) or not errors[0] <= np.log(error) <= errors[-1]:
            return float("nan")
        return float(np.exp(np.interp(np.log(error), errors, seconds)))

    def plot(self, ax: Any = None, **style: Any) -> Any:
        """Draw processor time over error, a line for each method.

        ax : matplotlib axes, by default those of a new figure; style : properties of lines of matplotlib. Returns the axes.
        """
        return drawing().benchmark(self, ax, style)

    def table(self) -> Table:
        """A `rsc.files.tables.Table`, a row for each run, for pandas (`to_dataframe`) and CSV (`to_csv`)."""
        rows: list[list[object]] = [[p.method, p.setting, p.error, p.seconds, p.cause] for p in self.points]
        return Table(("method", "tolerance or step", "error in gaps", "processor time in s", "cause"), rows)

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


SETTINGS = ArgumentKind("a list of numbers", lambda value: LINE.fits(value) and hasattr(value, "__len__"))
EARLIER = ArgumentKind("a Benchmark", lambda value: isinstance(value, Benchmark))


@takes(scene=SCENE, integrator=FUNCTION, settings=SETTINGS, name=TEXT, beside=optional(EARLIER))
def benchmark(
    scene: Scene,
    integrator: Integrator,
    settings: Sequence[float] = TOLERANCES,
    name: str = "",
    beside: Benchmark | None = None,
) -> Benchmark:
    """Run a scene with an integrator of your own and with rsc's methods, against a reference that shares no code with either.

    Parameters
    ----------
    scene : Scene
        What `rsc.equations` takes, short: the reference is Python and takes some 60 ms for each switch of a contact, twice. The
        motion should not magnify errors.
    integrator : callable (equations, times, setting) -> (n_times, n_state)
        Integrates `rsc.Equations` from their start and returns the states at the times.
    settings : sequence of float
        Tolerances or steps that it is run with, one after the other.
    name : str
        Its name in the chart, by default that of the function.
    beside : Benchmark of the same scene
        Whose points and reference are kept; only the integrator is run.

    Returns
    -------
    Benchmark
        Points of the integrator, of rk45 and of taylor8, these at relative tolerances from 1e-4 to 1e-10. Time is processor time
        of the second of two runs, so that compilation does not count; a run that raises, or whose result has another shape or is
        not finite, is kept with its cause.

    Raises
    ------
    SolverError
        As `rsc.equations`; no settings; or a Benchmark of another scene.

    Examples
    --------
    >>> from scipy.integrate import solve_ivp
    >>> def dop853(equations, times, tolerance):
    ...     return solve_ivp(equations.rhs, (0.0, times[-1]), equations.start, "DOP853", times, rtol=tolerance).y.T
    >>> short = rsc.load_scene("laval.toml").with_values({"drive.duration": 0.1})
    >>> chart = rsc.benchmark(short, dop853, [1e-6, 1e-8])
    """
    if not len(settings):
        raise SolverError("benchmark: settings must hold at least one tolerance or step")
    if beside is not None and beside.scene != scene:
        raise SolverError("benchmark: beside must be a Benchmark of the same scene")
    equations, name = Equations(scene), name or getattr(integrator, "__name__", "integrator")
    times = np.arange(int(equations.duration * scene.output.rate * (1.0 + 1e-12)) + 1) / scene.output.rate
    exact, own_error = reference(equations, times) if beside is None else (beside.reference, beside.reference_error)
    gap = float(equations.constants.gap.min())

    def of(method: str, setting: float, run: Callable[[], Any]) -> Point:
        return _timed(method, setting, run, exact, gap)

    points = [of(name, s, partial(_states, integrator, equations, times, s)) for s in settings]
    if beside is not None:
        return Benchmark((*beside.points, *points), scene, own_error, exact)
    for method in OWN:
        runs = [(rtol, scene.with_values({"solver.rtol": rtol, "solver.method": method})) for rtol in TOLERANCES]
        points += [of(f"rsc {method}", rtol, partial(_by_rsc, own, len(times))) for rtol, own in runs]
    return Benchmark(tuple(points), scene, own_error, exact)


def _timed(method: str, setting: float, run: Callable[[], Any], exact: NDArray[np.complex128], gap: float) -> Point:
    """The second run of a method at a setting."""
    try:
        run()
        begun = time.process_time()
        made = run()
        seconds = time.process_time() - begun
    except Exception as error:  # of a foreign integrator: it stands in the chart with what it said
        return Point(method, float(setting), float("nan"), float("nan"), f"{type(error).__name__}: {error}")
    return Point(method, float(setting), float(np.abs(made - exact).max() / gap), max(seconds, 1e-6))


def _states(integrator: Integrator, equations: Equations, times: NDArray[np.float64], s: float) -> NDArray[np.complex128]:
    """The displacements that an integrator makes at a setting."""
    states = np.asarray(integrator(equations, times, s), dtype=float)
    wanted = (len(times), len(equations.start))
    if states.shape != wanted:
        raise ValueError(f"states have the shape {states.shape} and not {wanted}")
    if not np.isfinite(states).all():
        raise ValueError("states are not finite")
    return equations.displacements(states)


def _by_rsc(scene: Scene, n_times: int) -> NDArray[np.complex128]:
    run = run_of(scene)
    blocks = [np.hstack([block["rotor"], block["stator"]]) for block, _ in run.chunks() if len(block["time"])]
    made = np.concatenate(blocks)[:n_times]
    if len(made) != n_times:
        raise ValueError("the run did not reach its end")
    return made
