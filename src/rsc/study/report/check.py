"""Simulate a scene, predict its whirls and compare both."""

import os
from collections.abc import Callable
from math import tau as TWO_PI

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.alone.at_rest import static_deflection
from rsc.analysis.alone.limits import acceptance_of
from rsc.analysis.alone.modes import controlled_frequencies
from rsc.analysis.follow.branch import Branch
from rsc.analysis.follow.branches import branches, set_branches
from rsc.analysis.follow.patience import Note, silent
from rsc.analysis.paper.anisotropy import rub_mirror_share, unbalance_ellipse
from rsc.analysis.paper.predict import refuse_backwards
from rsc.analysis.paper.receptance import coupled_frequencies, uncoupled_frequencies
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.paper.synchronous import forward_rub, synchronous_resonance, unbalance_response
from rsc.analysis.several.predict import refuse_unpredictable
from rsc.analysis.survey.remarks import body_remarks, damper_warnings, scene_remarks, set_remarks
from rsc.analysis.survey.survey import delays_of
from rsc.arguments import FLAG, FUNCTION, IMPULSE, PATH, RESULT, SCENE, optional, takes
from rsc.errors import DataError
from rsc.measure import window_length
from rsc.measure.catalogue import WHIRLING, Motions
from rsc.measure.changes import transitions
from rsc.measure.comparison import compare
from rsc.measure.course import Course, Windows, steepest, windows_of
from rsc.measure.kinds import Kind
from rsc.measure.resonances import resonances
from rsc.measure.several import hardest
from rsc.measure.stretches import at_contacts
from rsc.measure.verdict import Window
from rsc.measure.windows import LEAST_PERIODS, NEAR, ROLLS_PARTLY, Features, Rolls, Steady, followed
from rsc.measure.words import SYNCHRONOUS, TOLERANCES
from rsc.results.budget import foresee_report
from rsc.results.trajectory import Trajectory
from rsc.scene.scene import Scene
from rsc.show.words.headline import summary
from rsc.study.motions.impact import with_smallest
from rsc.study.motions.random_impacts import read_largest
from rsc.study.motions.release import with_held
from rsc.study.motions.search import Search
from rsc.study.prediction.reductions import coefficient_remarks, reduction_remarks
from rsc.study.report.alone import moving_lines, settling_rates
from rsc.study.report.best import best_predictions, no_predictions, rolling_motion
from rsc.study.report.letters import lettered
from rsc.study.report.report import Report, border_of_run, course_of, measured, sag_of, window_speeds
from rsc.study.run.simulate import simulate, tolerance_remark
from rsc.system.assemble import assemble
from rsc.system.system import System

# a T^2 above which a swept line loses more than 3 % of its amplitude in a Hann window
SWEEP_WARNING = 2.0
RELEASED = 400_000  # steps of the run that tells what a drive with a torque makes of a motion
STANDING = 0.5  # of the middle of the last window: a run that ends slower has its list at that middle
MOST_LISTS, STARTS = 2, 16  # speeds at which motions are looked for, and random starts at each: `rsc motions` has more
LEAST_SAMPLES = 9  # a window of eight and one more


@takes(scene=SCENE, progress=FLAG, path=optional(PATH), note=FUNCTION, overwrite=FLAG, largest=optional(IMPULSE))
def check(
    scene: Scene,
    progress: bool = False,
    path: str | os.PathLike[str] | None = None,
    note: Callable[[str], object] = lambda text: None,
    overwrite: bool = False,
    largest: float | str | None = None,
) -> Report:
    """Simulate a scene, predict its whirls and compare them in every window of the run.

    Parameters
    ----------
    scene : Scene
    progress : bool, show the simulation's progress on standard error
    path : str or Path, optional, file for the result
    note : callable, as in `simulate`; called first with one line on the memory of run and report together
    overwrite : bool, write the result also in the place of a file that rsc did not write, or that was changed since
    largest : float or str, N s, optional; of the random impacts of its lists, as in `rsc.motions`

    Returns
    -------
    Report

    Raises
    ------
    SceneError, DataError
        As `simulate`.
    SolverError
        An impulse that cannot be.

    Examples
    --------
    >>> report = rsc.check(rsc.load_scene("laval.toml"))
    >>> report.agreement
    'frequency agrees within 0.5 % in 97 of 97 windows with a backward line, amplitude within 2 % in 97'
    """
    size = read_largest(largest)
    return report(run_for_report(scene, progress, path, note, overwrite), note, largest=size)


def run_for_report(
    scene: Scene, progress: bool, path: str | os.PathLike[str] | None, note: Note, overwrite: bool = False
) -> Trajectory:
    """The run that `check` compares with predictions; as `check`."""
    scene = scene.turning_forward()
    _refuse_unpredicted(assemble(scene))
    note(foresee_report(scene, path))
    return simulate(scene, progress=progress, path=path, note=note, overwrite=overwrite)


def _refuse_unpredicted(system: System) -> None:
    """SolverError for contacts of a System that nothing can be predicted for, before it is simulated."""
    if len(system.contacts) > 1:
        refuse_unpredictable(system)
    else:
        _ = system.contact


@takes(result=RESULT, note=FUNCTION, lists=FLAG, largest=optional(IMPULSE))
def report(result: Trajectory, note: Note = silent, lists: bool = True, largest: float | str | None = None) -> Report:
    """Compare a run that exists with the predictions for its scene; returns a Report.

    Parameters
    ----------
    result : Trajectory
    note : callable, called every two seconds of a long search for whirls with a line of text
    lists : bool, whether to look for what else can last at its end and where its motion changed, `rsc.motions`
    largest : float or str, N s, optional; of the random impacts of these lists

    Raises
    ------
    DataError
        The run ended before it had samples enough for a spectrum; says how it ended.
    """
    torque, result = result.scene, result.scheduled
    system = assemble(result.scene)
    with result.kept_open():
        return compared(result, system, *observed(result, system, note), lists, torque, read_largest(largest))


def compared(
    result: Trajectory,
    system: System,
    seen: Course,
    grid: NDArray[np.float64],
    whirl_branches: list[Branch],
    lists: bool = True,
    torque: Scene | None = None,
    largest: float | None = None,
) -> Report:
    """The Report of a run and of its predictions, as `observed` returns them; torque: the scene with the drive of the run;
    largest: impulse in N s of the lists."""
    scene, features, fall = result.scene, seen.features, seen.fall
    several = bool(seen.lead)
    one = system.at_contact(seen.lead) if several else system  # of which all is told that is of one contact
    rolls = None if several else rolls_of(system, features)
    pairs = followed(features, whirl_branches, rolls)
    best = no_predictions(len(pairs)) if several else best_predictions(system, features, pairs)
    alone = np.array([_alone(one.at_time(time), speed) for speed, time in zip(fall.speed, fall.time, strict=True)])
    rub = np.full(len(alone), np.nan) if several else np.array([_rub_amplitude(system, speed) for speed in fall.speed])
    steady = Steady(alone, rub, moving_lines(one, features, alone), settling_rates(system, features))
    windows = compare(features, whirl_branches, steady, rolls, best, _load_deflection(one))
    changes = transitions(features, whirl_branches, {} if several else delays_of(scene, system, whirl_branches), best)
    listed = [lettered(own, whirl_branches) for own in _motions(scene, seen, torque or scene, largest)] if lists else []
    limits = np.sort(np.abs(scene.drive.speed))[[0, -1]] * TWO_PI
    closed = limits[1] > limits[0] and not several
    resonance = synchronous_resonance(system, limits) / TWO_PI if closed else float("nan")
    return Report(
        result=result,
        **measured(seen),
        alone=steady.alone,
        best=best,
        branches=whirl_branches,
        natural=_natural(system, grid),
        windows=windows,
        transitions=changes,
        rub=(fall.speed, steady.rub),
        resonances=resonances(windows, _first_order_lines(windows, whirl_branches)),
        resonance=float(resonance),
        warnings=[
            *_warnings(result, seen),
            *_unseen(scene.output.rate, whirl_branches, listed),
            *_of_predictions(system, whirl_branches),
            *coefficient_remarks(scene),
        ],
        limits=acceptance_of(scene, system),
        sag=sag_of(system, seen.lead),
        remarks=_directions_remarks(whirl_branches) + _of_reductions(scene, whirl_branches),
        motions=listed,
        border=None if seen.stretches is None else border_of_run(result, system, features),
        agreement=summary(windows, changes, result.status, "measurement" if seen.stretches is None else "simulation"),
    )


def _of_predictions(system: System, whirl_branches: list[Branch]) -> list[str]:
    """Remarks on the predictions for a system."""
    whirls = [whirl for branch in whirl_branches for whirl in branch.whirls]
    if len(system.contacts) > 1:
        return body_remarks(system, whirls) + set_remarks(system)
    return scene_remarks(system, whirls) + damper_warnings(system, whirl_branches)


def _motions(scene: Scene, seen: Course, torque: Scene, largest: float | None) -> list[Motions]:
    """What can last at the end of a run and where its motion changed, the last first."""
    features, run = seen.features, _speeds_of_lists(seen, scene)
    changes = np.flatnonzero(features.kind[1:] != features.kind[:-1])[::-1] + 1
    places = [len(features.speed) - 1, *changes.tolist()]
    slowest, fastest = min(scene.drive.speed), max(scene.drive.speed)  # beyond which a reduced machine is not known
    speeds = list(dict.fromkeys(min(max(float(f"{run[i]:.4g}"), slowest), fastest) for i in places))
    return [_listed(scene, speed, features, torque, largest) for speed in speeds[:MOST_LISTS] if speed]


def _speeds_of_lists(seen: Course, scene: Scene) -> NDArray[np.float64]:
    """Rotor speeds in Hz of the windows, the last one that of the end of the run unless the rotor hardly turns there."""
    middle, end = np.array(seen.features.speed, float), window_speeds(seen.fall, scene.drive)[-1]
    middle[-1] = end if abs(end) > STANDING * abs(middle[-1]) else middle[-1]
    return middle


def _listed(scene: Scene, speed: float, features: Features, torque: Scene, largest: float | None) -> Motions:
    """What can last at a speed and what the drive makes of it; with the smallest impact that starts a whirl where the run itself
    is in none."""
    search = Search(scene, speed, largest)
    listed = with_held(search, search.motions(STARTS, 0), torque, RELEASED)
    whirls = [str(kind) for kind in WHIRLING]
    return listed if np.isin(features.kind, whirls).any() else with_smallest(search, listed)


def observed(result: Trajectory, system: System, note: Note = silent) -> tuple[Course, NDArray[np.float64], list[Branch]]:
    """The course of a run, the speeds (n,) Hz to predict at, and the predicted branches.

    Raises
    ------
    DataError
        The run ended before it had samples enough for a spectrum; says how it ended.
    """
    drive = result.scene.drive
    refuse_backwards(f"{result.scene.source}, report", min(drive.speed))
    _refuse_too_short(result)
    windows = windows_of(result)
    grid = _speed_grid(np.concatenate([[drive.speed[0]], windows.speed, [drive.speed[-1]]]))
    if len(system.contacts) > 1:
        whirl_branches: list[Branch] = list(set_branches(system, grid, hardest(result), note))
    else:
        whirl_branches = branches(system, grid, note)
    windows = _resolving(result, windows, whirl_branches)
    return course_of(result, windows, system), grid, whirl_branches


def _resolving(result: Trajectory, windows: Windows, whirl_branches: list[Branch]) -> Windows:
    """Windows that hold three periods of every stable whirl where the run allows it."""
    slowest = min((float(np.abs(b.frequency[b.decays]).min()) for b in whirl_branches if b.decays.any()), default=np.inf)
    needed = 1.1 * LEAST_PERIODS / slowest  # a little more, since a window is a whole number of samples
    duration = (result.n_time - 1) / windows.rate
    if needed <= windows.window or needed > 0.5 * duration or steepest(result) * needed**2 > SWEEP_WARNING:
        return windows
    return windows_of(result, needed)


def _load_deflection(system: System) -> float:
    """Deflection of the rotor at the contact by its constant load, m."""
    if not system.rotor.load.any():
        return 0.0
    if system.n_states:
        deflection = static_deflection(system.at_first_speed)
        return float(abs(deflection @ system.rotor.contact)) if np.isfinite(deflection).all() else 0.0
    deflection, *_ = np.linalg.lstsq(system.at_first_speed.rotor.stiffness, system.rotor.load, rcond=None)
    return float(abs(deflection @ system.rotor.contact))


def _first_order_lines(windows: list[Window], whirl_branches: list[Branch]) -> list[float]:
    """The synchronous line to first order in the unbalance of every window, m; NaN off the whirls."""
    by_label = {b.label: b for b in whirl_branches}
    lines = []
    for window in windows:
        whirl = by_label[window.branch].at(window.frequency.speed) if window.branch in by_label else None
        lines.append(float("nan") if whirl is None else whirl.synchronous.consistent.amplitude)
    return lines


def _refuse_too_short(result: Trajectory) -> None:
    if result.n_time >= LEAST_SAMPLES:
        return
    end, rate = result.summary.end_time, result.scene.output.rate
    why = f" ({result.summary.advice})" if result.summary.advice else ""
    wish = f"a spectrum needs {LEAST_SAMPLES}" + (f": raise output.rate above {LEAST_SAMPLES / end:.3g} Hz" if end > 0.0 else "")
    problem = f"run {result.status} after {end:.4g} s{why}; output.rate = {rate:g} Hz leaves {result.n_time} samples, {wish}"
    raise DataError(result.scene.source, problem)


def rolls_of(system: System, features: Features) -> Rolls:
    """Rolling whirls near windows that roll; with the full unbalance if such a motion is found."""
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
    loss = [window_length.sweep_loss(move, features.window) if move == move else np.nan for move in moves]
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
        return float(abs(unbalance_response(system, TWO_PI * speed)[0] @ system.rotor.contact))
    return float(abs(unbalance_ellipse(system, TWO_PI * speed)[0] @ system.rotor.contact))


def _directions_remarks(whirl_branches: list[Branch]) -> list[str]:
    """How far each stable whirl is from a circle, where directions differ."""
    remarks = []
    for branch in whirl_branches:
        shares = [whirl.mirror.share for whirl in branch.whirls if whirl.mirror is not None]
        if shares:
            remarks.append(
                f"whirl {branch.label}: elliptical, its counter-rotating component has {100 * min(shares):.1f} to "
                f"{100 * max(shares):.1f} % of it; above 10 % it is not circular and its stability is not assessed"
            )
    return remarks


def _rub_amplitude(system: System, speed: float) -> float:
    """|r_R| of the forward rub; of two that one which presses more: the other is the saddle between it and no contact.

    NaN where there is none, and where directions differ so much that the isotropic mean is not good enough to be compared with:
    its error is about the share of the mirror line.
    """
    rubs = forward_rub(system, TWO_PI * speed)
    if not rubs or rub_mirror_share(system, rubs[-1], TWO_PI * speed) > TOLERANCES[SYNCHRONOUS]:
        return np.nan
    return rubs[-1].amplitude


def _natural(system: System, speeds: NDArray[np.float64]) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    if system.n_states:  # a controller is no spring: those of the closed loop, damped
        return {name: (speeds, controlled_frequencies(system, speeds, name == "coupled")) for name in ("coupled", "uncoupled")}
    of = {"coupled": coupled_frequencies, "uncoupled": uncoupled_frequencies}
    return {name: (speeds, frequencies(system, TWO_PI * speeds) / TWO_PI) for name, frequencies in of.items()}


def _of_reductions(scene: Scene, whirl_branches: list[Branch]) -> list[str]:
    """Remarks on reduced bodies, with the shift of every whirl that can be stable."""
    return reduction_remarks(scene, (branch.whirls[0] for branch in whirl_branches if branch.stable.any()))


def _unseen(rate: float, whirl_branches: list[Branch], lists: list[Motions]) -> list[str]:
    """A remark on whirls, predicted to be stable or listed, that turn too fast for the samples."""
    fast = {f"whirl {b.label}": float(np.abs(b.frequency[b.decays]).max()) for b in whirl_branches if b.decays.any()}
    lasting = [motion for listed in lists for motion in listed.motions if motion.motion != Kind.RUNNING_AWAY]
    fast |= {motion.motion: abs(motion.frequency) for motion in lasting}
    told = [f"{name} ({frequency:.4g} Hz)" for name, frequency in fast.items() if frequency > 0.5 * rate]
    if not told:
        return []
    text = f"samples of output.rate = {rate:g} Hz cannot show {', '.join(told)}: their spectra and orbits need more than"
    return [f"{text} {2.0 * max(fast.values()):.4g} Hz; kind, turning, amplitude and force come from the steps and do not"]


def _warnings(result: Trajectory, seen: Course) -> list[str]:
    if seen.stretches is None:
        return []  # of a measured run those of its reader
    warnings = []
    rate, window = steepest(result), seen.fall.window
    if rate * window**2 > SWEEP_WARNING:
        loss = 100.0 * window_length.sweep_loss(rate, window)
        warnings.append(f"the run-up smears a synchronous line over its window: {loss:.0f} % of its amplitude is lost")
    if result.summary.advice:
        warnings.append(result.summary.advice)
    each = [(contact, own.whole()) for contact, own in zip(result.scene.contacts, at_contacts(result), strict=True)]
    for contact, whole in each:
        pressed_in = whole.force_max / contact.stiffness / contact.gap
        if pressed_in > 1.0:
            name, table = (f"contact {contact.name}", f"contact.{contact.name}") if seen.lead else ("the contact", "contact")
            text = f"{name} is penetrated by up to {pressed_in:.3g} gaps: no machine withstands that"
            warnings.append(f"{text}; the motion would destroy it, or see whether {table}.stiffness is right")
    contact, whole = max(each, key=lambda own: own[1].rotor_max / own[0].gap)
    remark = tolerance_remark(whole.rotor_max, contact.gap, result.summary.rtol)
    return [*warnings, remark] if remark else warnings
