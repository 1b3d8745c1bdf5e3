"""The main job: simulate a scene, predict it, compare the two."""

import os
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.anisotropy import unbalance_ellipse
from rsc.analysis.branches import Branch, branches
from rsc.analysis.receptance import coupled_frequencies, uncoupled_frequencies
from rsc.analysis.remarks import damper_warnings, scene_remarks
from rsc.analysis.rolling import rolling_whirls
from rsc.analysis.survey import delays_of
from rsc.analysis.synchronous import forward_rub, synchronous_resonance, unbalance_response
from rsc.arguments import FLAG, FUNCTION, PATH, RESULT, SCENE, optional, takes
from rsc.errors import DataError
from rsc.measure import spectra
from rsc.measure.changes import Transition, transitions
from rsc.measure.features import contact_turning, envelope, rolling_share, waterfall, window_means
from rsc.measure.headline import Resonance, headline, resonances, summary
from rsc.measure.verdict import Row, compare
from rsc.measure.windows import LEAST_PERIODS, NEAR, ROLLS_PARTLY, Best, Features, Rolls, Steady, followed
from rsc.measure.words import TOLERANCES
from rsc.results.trajectory import Trajectory
from rsc.scene.scene import Scene
from rsc.study.best import best_predictions, rolling_motion
from rsc.study.reductions import reduction_remarks
from rsc.study.simulate import simulate, tolerance_remark
from rsc.system.assemble import assemble
from rsc.system.system import System

TWO_PI = 2.0 * np.pi
# a T^2 above which a swept line loses more than 3 % of its amplitude in a Hann window
SWEEP_WARNING = 2.0
LEAST_SAMPLES = 9  # a window of eight and one more


@dataclass(frozen=True)
class Report:
    """Simulation, prediction and their comparison.

    result : Trajectory; fall : spectra.Waterfall; envelope : spectra.Envelope
    features : windows.Features, one entry a window; best : windows.Best, the predictions it is compared with
    branches : list of branches.Branch, the predicted backward whirls over the run's speeds
    natural : dict, "coupled" and "uncoupled" -> (speed (n,), frequency (n, k)) Hz, signed
    rows : list of verdict.Row; transitions : list of changes.Transition
    rub : (speed (n,) Hz, amplitude (n,) m) of the forward rub, NaN where it does not exist
    resonances : list of headline.Resonance, where the unbalance line is largest on each whirl of the run
    resonance : float Hz, speed at which the forward rub is largest, in closed form (NaN where it does not exist)
    warnings : list of str; remarks : list of str, on supports whose directions differ and on bodies that were reduced
    headline : list of str, three lines: does it whirl, what changes, and the verdict
    verdict : str, one sentence
    """

    result: Trajectory = field(repr=False)
    fall: spectra.Waterfall = field(repr=False)
    envelope: spectra.Envelope = field(repr=False)
    features: Features = field(repr=False)
    best: Best = field(repr=False)
    branches: list[Branch] = field(repr=False)
    natural: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = field(repr=False)
    rows: list[Row] = field(repr=False)
    transitions: list[Transition]
    rub: tuple[NDArray[np.float64], NDArray[np.float64]] = field(repr=False)
    resonances: list[Resonance]
    resonance: float
    warnings: list[str]
    remarks: list[str]
    headline: list[str]
    verdict: str


@takes(scene=SCENE, progress=FLAG, path=optional(PATH), note=FUNCTION)
def check(
    scene: Scene,
    progress: bool = False,
    path: str | os.PathLike[str] | None = None,
    note: Callable[[str], object] = lambda text: None,
) -> Report:
    """Simulate a scene, predict its whirls and compare them in every window of the run.

    Parameters
    ----------
    scene : Scene
    progress : bool, show the simulation's progress on standard error
    path : str or Path, optional, file for the result
    note : callable, as in `simulate`

    Returns
    -------
    Report

    Raises
    ------
    SceneError, DataError
        As `simulate`.
    """
    return report(simulate(scene, progress=progress, path=path, note=note))


@takes(result=RESULT)
def report(result: Trajectory) -> Report:
    """Compare a run that exists with the predictions for its scene; returns a Report.

    Raises
    ------
    DataError
        The run ended before it had samples enough for a spectrum; says how it ended.
    """
    scene, system = result.scene, assemble(result.scene)
    fall, grid, whirl_branches = observed(result, system)
    features = measure(result, fall, bool(system.load.any()))
    rolls = rolls_of(system, features)
    best = best_predictions(system, features, followed(features, whirl_branches, system.gap, rolls))
    steady = Steady(*(np.array([motion(system, speed) for speed in fall.speed]) for motion in (_alone, _rub_amplitude)))
    rows = compare(features, whirl_branches, steady, system.gap, rolls, best, _load_deflection(system))
    changes = transitions(features, whirl_branches, system.gap, delays_of(scene, system, whirl_branches), best)
    remarks = scene_remarks(system, [whirl for branch in whirl_branches for whirl in branch.whirls])
    limits = np.sort(np.abs(scene.drive.speed))[[0, -1]] * TWO_PI
    resonance = synchronous_resonance(system, limits) / TWO_PI if limits[1] > limits[0] else float("nan")
    largest_force = float(result.normal_force.max())
    return Report(
        result=result,
        fall=fall,
        envelope=envelope(result, fall.window),
        features=features,
        best=best,
        branches=whirl_branches,
        natural=_natural(system, grid),
        rows=rows,
        transitions=changes,
        rub=(fall.speed, steady.rub),
        resonances=resonances(rows, _first_order_lines(rows, whirl_branches)),
        resonance=float(resonance),
        warnings=[
            *_warnings(result, fall),
            *remarks,
            *damper_warnings(system, whirl_branches),
        ],
        remarks=_directions_remarks(whirl_branches) + _of_reductions(scene, whirl_branches),
        headline=headline(rows, changes, result.status, system.gap, largest_force),
        verdict=summary(rows, changes, result.status),
    )


def observed(result: Trajectory, system: System) -> tuple[spectra.Waterfall, NDArray[np.float64], list[Branch]]:
    """The waterfall of a run, the speeds (n,) Hz to predict at, and the predicted branches.

    Raises
    ------
    DataError
        The run ended before it had samples enough for a spectrum; says how it ended.
    """
    scene = result.scene
    _refuse_too_short(result)
    fall = waterfall(result, f_max=0.5 * scene.output.rate)
    grid = _speed_grid(np.concatenate([[scene.drive.speed[0]], fall.speed, [scene.drive.speed[-1]]]))
    whirl_branches = branches(system, grid)
    return _resolving(result, fall, whirl_branches), grid, whirl_branches


def _resolving(result: Trajectory, fall: spectra.Waterfall, whirl_branches: list[Branch]) -> spectra.Waterfall:
    """The waterfall, with windows that hold three periods of every stable whirl where the run allows it."""
    slowest = min((float(np.abs(b.frequency[b.stable]).min()) for b in whirl_branches if b.stable.any()), default=np.inf)
    needed = 1.1 * LEAST_PERIODS / slowest  # a little more, since a window is a whole number of samples
    duration = float(result.time[-1] - result.time[0])
    if needed <= fall.window or needed > 0.5 * duration or _steepest(result) * needed**2 > SWEEP_WARNING:
        return fall
    return waterfall(result, window=needed, f_max=0.5 * result.scene.output.rate)


def _steepest(result: Trajectory) -> float:
    """Largest run-up rate at the samples, Hz/s."""
    return float(np.abs(np.diff(result.speed)).max(initial=0.0)) * result.scene.output.rate


def _load_deflection(system: System) -> float:
    """Deflection of the rotor at the contact by its constant load, m."""
    if not system.load.any():
        return 0.0
    deflection, *_ = np.linalg.lstsq(system.stiffness_r, system.load, rcond=None)
    return float(abs(deflection @ system.contact_r))


def _first_order_lines(rows: list[Row], whirl_branches: list[Branch]) -> list[float]:
    """The synchronous line to first order in the unbalance of every window, m; NaN off the whirls."""
    by_label = {b.label: b for b in whirl_branches}
    lines = []
    for row in rows[:: len(TOLERANCES)]:
        whirl = by_label[row.branch].at(row.speed) if row.branch in by_label else None
        lines.append(float("nan") if whirl is None else whirl.synchronous.consistent.amplitude)
    return lines


def _refuse_too_short(result: Trajectory) -> None:
    if len(result.time) >= LEAST_SAMPLES:
        return
    end, rate = result.summary.end_time, result.scene.output.rate
    why = f" ({result.summary.advice})" if result.summary.advice else ""
    wish = f"a spectrum needs {LEAST_SAMPLES}" + (f": raise output.rate above {LEAST_SAMPLES / end:.3g} Hz" if end > 0.0 else "")
    problem = f"run {result.status} after {end:.4g} s{why}; output.rate = {rate:g} Hz leaves {len(result.time)} samples, {wish}"
    raise DataError(result.scene.source, problem)


def measure(result: Trajectory, fall: spectra.Waterfall, loaded: bool) -> Features:
    """Features of a run in the windows of its waterfall; `loaded`: a constant load deflects it."""
    rotor, stator = result.contact_rotor(), result.contact_stator()
    falls = {"rotor": fall}
    if loaded:  # the line at 0 Hz would hide slow lines beside it
        rotor, stator = rotor - rotor.mean(), stator - stator.mean()
        falls["rotor"] = _spectra_of(result, rotor, fall)
    if result.scene.stator.n_coordinates:
        falls |= {"relative": _spectra_of(result, rotor - stator, fall), "stator": _spectra_of(result, stator, fall)}
    peaks = [spectra.spectral_peaks(each, side="negative", count=3) for each in falls.values()]
    frequency, size = (np.array([getattr(peak, name) for peak in peaks]) for name in ("frequency", "amplitude"))
    windows = np.arange(len(fall.speed))
    body = np.nan_to_num(size[:, :, 0]).argmax(axis=0)
    strongest = frequency[body, windows, 0]
    nothing = np.zeros(len(windows))
    at_line = {name: np.nan_to_num(spectra.line_at(each, strongest).amplitude) for name, each in falls.items()}
    synchronous = np.array([spectra.line_at(each, fall.speed).amplitude for each in falls.values()])
    return Features(
        window=fall.window,
        rate=result.scene.output.rate,
        speed=fall.speed,
        time=fall.time,
        share=window_means(result.time, result.normal_force > 0.0, fall),
        frequency=strongest,
        size=np.nan_to_num(size[body, windows, 0]),
        amplitude=at_line["rotor"],
        stator_amplitude=at_line.get("stator", nothing),
        other_frequency=frequency[body, windows, 1:],
        other_size=size[body, windows, 1:],
        synchronous=synchronous[0],
        synchronous_size=synchronous[body, windows],
        turning=contact_turning(result, result.contact_rotor() - result.contact_stator(), fall),
        rolling=rolling_share(result, fall),
    )


def _spectra_of(result: Trajectory, signal: NDArray[np.complex128], fall: spectra.Waterfall) -> spectra.Waterfall:
    """The waterfall of another motion of the run in the same windows."""
    return spectra.waterfall(result.time, signal, result.speed, window=fall.window, f_max=0.5 * result.scene.output.rate)


def rolls_of(system: System, features: Features) -> Rolls:
    """Rolls of a run, looked for where a window or its neighbour rolls; with the whole unbalance where such a motion is found."""
    values = np.full((5, len(features.speed)), np.nan)
    padded = np.pad(features.rolling > ROLLS_PARTLY, 1)
    rolling = padded[:-2] | padded[1:-1] | padded[2:]
    for i in np.flatnonzero(rolling & np.isfinite(features.frequency)):
        line = TWO_PI * features.frequency[i]
        near = rolling_whirls(system, TWO_PI * features.speed[i], (abs(line) * (1.0 - NEAR), abs(line) * (1.0 + NEAR)))
        if near:
            roll = min(near, key=lambda roll: abs(roll.Psi - line))
            values[:, i] = (*rolling_motion(system, roll, features.speed[i]), roll.growth_rate)
    ends = np.clip(np.arange(len(rolling))[:, None] + [-1, 1], 0, len(rolling) - 1)
    moves = np.diff(values[0][ends])[:, 0] / np.diff(features.time[ends])[:, 0] if len(rolling) > 1 else np.zeros(1)
    loss = [spectra.sweep_loss(move, features.window) if move == move else np.nan for move in moves]
    frequency, amplitude, stator_amplitude, synchronous, growth_rate = values
    return Rolls(frequency, amplitude, stator_amplitude, synchronous, growth_rate, np.array(loss))


def _speed_grid(speed: NDArray[np.float64]) -> NDArray[np.float64]:
    """Speeds to predict at, in the direction of the run: those of the windows and of its ends; one for a constant speed."""
    distinct = np.unique(speed)
    if np.ptp(distinct) <= 1e-9 * np.abs(distinct).max(initial=1.0):
        return np.array([distinct[0]])
    return distinct if speed[-1] >= speed[0] else distinct[::-1]


def _alone(system: System, speed: float) -> float:
    """The rotor's line at its speed without contact, m."""
    if system.isotropic:
        return float(abs(unbalance_response(system, TWO_PI * speed)[0] @ system.contact_r))
    return float(abs(unbalance_ellipse(system, TWO_PI * speed)[0] @ system.contact_r))


def _directions_remarks(whirl_branches: list[Branch]) -> list[str]:
    """How far each stable whirl is from a circle, where directions differ."""
    remarks = []
    for branch in whirl_branches:
        shares = [whirl.mirror.share for whirl in branch.whirls if whirl.mirror is not None]
        if shares:
            remarks.append(
                f"whirl {branch.label}: directions differ, its mirror line has {100 * min(shares):.1f} to "
                f"{100 * max(shares):.1f} % of it; above 10 % it is no circle, and nothing is claimed of it"
            )
    return remarks


def _rub_amplitude(system: System, speed: float) -> float:
    return max((rub.amplitude for rub in forward_rub(system, TWO_PI * speed)), default=np.nan)


def _natural(system: System, speeds: NDArray[np.float64]) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    coupled = [np.sort(coupled_frequencies(system, TWO_PI * s)) / TWO_PI for s in speeds]
    uncoupled = [np.sort(uncoupled_frequencies(system, TWO_PI * s)) / TWO_PI for s in speeds]
    return {"coupled": (speeds, np.array(coupled)), "uncoupled": (speeds, np.array(uncoupled))}


def _of_reductions(scene: Scene, whirl_branches: list[Branch]) -> list[str]:
    """Remarks on reduced bodies, with the shift of every whirl that can be stable."""
    return reduction_remarks(scene, (branch.whirls[0] for branch in whirl_branches if branch.stable.any()))


def _warnings(result: Trajectory, fall: spectra.Waterfall) -> list[str]:
    warnings = []
    steepest = _steepest(result)
    if steepest * fall.window**2 > SWEEP_WARNING:
        loss = 100.0 * spectra.sweep_loss(steepest, fall.window)
        warnings.append(f"the run-up smears a synchronous line over its window: {loss:.0f} % of its amplitude is lost")
    if result.summary.advice:
        warnings.append(result.summary.advice)
    largest = float(np.abs(result.contact_rotor()).max())
    remark = tolerance_remark(largest, result.scene.contact.gap, result.summary.rtol)
    return [*warnings, remark] if remark else warnings

