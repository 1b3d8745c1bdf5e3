"""What is computed of the cases of a part: predictions of stacks of scenes, runs, reports; a case fails alone."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from rsc.analysis.follow.least_friction import mu_min
from rsc.analysis.follow.one_whirl import delay
from rsc.analysis.paper.predict_many import predict_many
from rsc.analysis.several.predict import predict
from rsc.analysis.several.whirl import SeveralWhirl
from rsc.errors import RscError, SceneError, SolverError, one_line
from rsc.measure.catalogue import WHIRLING, LastingMotion, Motions
from rsc.measure.final import FinalMotion, final_motion
from rsc.measure.kinds import Kind
from rsc.measure.severity import severity_of, verdict_of
from rsc.measure.stretches import Stretches, at_contacts
from rsc.measure.words import FREQUENCY, VERDICTS
from rsc.results.trajectory import Trajectory
from rsc.scene.scene import Scene
from rsc.scene.values import with_entries
from rsc.simulation.run import versions
from rsc.study.motions.motions import list_of
from rsc.study.report.check import report
from rsc.study.run.ensemble import NoRun, simulate_many
from rsc.study.sweep.rows import COLUMNS, FAILED, FINISHED, IMPOSSIBLE, Rows, empty, joined, number_of_set, texts
from rsc.system.assemble import assemble
from rsc.system.border import Border, border_of
from rsc.system.system import System

STARTS = 16  # random impacts of a case whose motions are listed
LONGEST_REASON = 400
KINDS = tuple(COLUMNS)
OF_ONE_CONTACT = ("mu_min", "jump")  # what is not known of several
own_versions = lru_cache(maxsize=1)(versions)


@dataclass(frozen=True)
class Part:
    """Some cases of a sweep and what is computed of them: all that a worker needs.

    kind : str, a key of `COLUMNS`
    scene : str, the resolved scene before anything is varied, as TOML; source : str, its name for messages
    keys : tuple of str; values : tuple of tuples, those of each case
    versions : str, of the client (`rsc.simulation.run.versions`)
    """

    kind: str
    scene: str
    source: str
    keys: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...]
    versions: str


def compute_part(part: Part) -> Rows:
    """The rows of a part.

    Raises
    ------
    SolverError
        This process has other versions than the client.
    """
    if part.versions != own_versions():
        raise SolverError(f"a worker has {own_versions()}, the sweep {part.versions}: must be the same, for the same bits")
    scenes, pieces = scenes_of(part), []
    groups: dict[tuple[int, int], list[int]] = {}
    for i, scene in enumerate(scenes):
        if isinstance(scene, Scene):
            groups.setdefault((scene.rotor.n_coordinates, scene.stator.n_coordinates), []).append(i)
        else:
            pieces.append(([i], _nothing(part.kind, IMPOSSIBLE, scene)))
    for places in groups.values():
        pieces += [([places[k] for k in inner], rows) for inner, rows in _rows(part.kind, [scenes[i] for i in places])]
    rows = joined(part.kind, len(scenes), pieces)
    rows["scene_hash"] = texts([scene_hash(scene) if isinstance(scene, Scene) else "" for scene in scenes])
    return rows


def scenes_of(part: Part) -> list[Scene | SceneError]:
    """The scenes of a part; in the place of one that cannot be right the error."""
    base = base_of(part.scene, part.source)
    return [_scene(base, dict(zip(part.keys, values, strict=True))) for values in part.values]


def scene_hash(scene: Scene) -> str:
    """SHA-256 of the resolved scene."""
    return hashlib.sha256(scene.to_toml().encode()).hexdigest()


@lru_cache(maxsize=4)
def base_of(text: str, source: str) -> Scene:
    """The scene of a plan before anything is varied."""
    return Scene.from_stored(text, source)  # a plan may come from a stranger, and names no files


def _scene(base: Scene, values: dict[str, Any]) -> Scene | SceneError:
    try:
        return with_entries(base, values).turning_forward()
    except SceneError as error:
        return error


def _rows(kind: str, scenes: list[Any]) -> list[tuple[Sequence[int], Rows]]:
    """Pieces of rows of scenes of one shape, computed together or, where that raises an error, each alone."""
    try:
        return [(range(len(scenes)), _COMPUTED[kind](scenes))]
    except Exception as error:  # whatever it is, it must not cost the other cases
        if len(scenes) == 1:
            return [([0], _nothing(kind, IMPOSSIBLE if isinstance(error, SceneError) else FAILED, error))]
    return [([i], rows) for i, scene in enumerate(scenes) for _, rows in _rows(kind, [scene])]


def _nothing(kind: str, status: str, error: Exception) -> Rows:
    """The row of a case that has only a reason."""
    reason = str(error) if isinstance(error, RscError) else f"{type(error).__name__}: {one_line(error)}"
    if isinstance(error, SceneError):
        reason = reason.removeprefix(f"{error.file}: ")  # the values are those of the row
    return empty(kind, 1) | {"status": texts([status]), "reason": texts([reason[:LONGEST_REASON]])}


def _predicted(scenes: list[Scene]) -> Rows:
    """Whirls at the first speed of every scene's drive."""
    if len(scenes[0].contacts) > 1:
        return _predicted_at_several(scenes)
    arrays = predict_many(scenes, np.array([[scene.drive.speed[0]] for scene in scenes]))
    rows = empty("predict", len(scenes), arrays.frequency.shape[-1]) | {"status": texts([FINISHED] * len(scenes))}
    for name in COLUMNS["predict"]:
        if name == "pressed":
            rows[name] = np.where(arrays.exists[:, 0], 1, -1)
        elif name == "clearance":
            rows[name] = np.nan_to_num(arrays.clearance[:, 0], nan=-1.0).astype("i1")
        elif not name.startswith("holds_"):
            rows[name] = np.asarray(getattr(arrays, name)[:, 0]).astype(rows[name].dtype)
    for name, holds in arrays.conditions.items():
        rows[f"holds_{name}"] = holds[:, 0].astype("i1")
    return rows


def _predicted_at_several(scenes: list[Scene]) -> Rows:
    """The same of scenes with several contacts: the whirls of every pressed set; what the theory of one contact alone asks of a
    whirl does not hold."""
    lists = [list(predict(scene)) for scene in scenes]
    rows = empty("predict", len(scenes), max(map(len, lists))) | {"status": texts([FINISHED] * len(scenes))}
    same = ("frequency", "normal_force", "rotor_amplitude", "stator_amplitude", "growth_rate", "growth_frequency", "stable")
    for i, (scene, whirls) in enumerate(zip(scenes, lists, strict=True)):
        names = [contact.name or "" for contact in scene.contacts]
        for k, whirl in enumerate(whirls):
            assert isinstance(whirl, SeveralWhirl)
            for name in (*same, "admissible"):
                rows[name][i, k] = getattr(whirl, name)
            rows["pressed"][i, k] = number_of_set(whirl.pressed, names)
            for name in whirl.conditions:
                rows[f"holds_{name}"][i, k] = name not in whirl.violated
            if scene.clearances:
                shares = [whirl.clearances[place.name] for place in scene.clearances]
                rows["clearance_share"][i, k], rows["clearance"][i, k] = max(shares), int(np.argmax(shares))
    return rows


def _least_frictions(scenes: list[Scene]) -> Rows:
    rows = empty("mu_min", len(scenes)) | {"status": texts([FINISHED] * len(scenes))}
    for i, scene in enumerate(scenes):
        # friction does not matter, so that a map over it asks once
        rows["mu_min"][i], rows["mu_min_frequency"][i] = _least_friction(scene.with_values({"contact.friction": 0.0}).to_toml())
    return rows


@lru_cache(maxsize=65536)
def _least_friction(text: str) -> tuple[float, float]:
    event = mu_min(Scene.from_toml(text))
    return (event.value, event.frequency) if event is not None else (np.nan, np.nan)


def _jumps(scenes: list[Scene]) -> Rows:
    """Where runs leave the whirl that they start on, or else the stable backward one of largest amplitude."""
    rows = empty("jump", len(scenes)) | {"status": texts([FINISHED] * len(scenes))}
    for i, scene in enumerate(scenes):
        near = scene.start.whirl if isinstance(scene.start.whirl, float) else _largest_stable(scene)
        if near is None:
            wanted = "a speed at which a backward whirl is stable, for the run to start on"
            raise SceneError(scene.source, "drive.speed", scene.drive.speed[0], wanted)
        jump = delay(scene, near)
        values = near, jump.crossing, jump.first_seen, jump.jump
        for name, value in zip(COLUMNS["jump"], values, strict=True):
            rows[name][i] = value
    return rows


def _largest_stable(scene: Scene) -> float | None:
    whirls = predict_many([scene], scene.drive.speed[:1])
    wanted = whirls.decays & (whirls.frequency < 0.0)
    if not wanted.any():
        return None
    return float(whirls.frequency.flat[np.argmax(np.where(wanted, whirls.rotor_amplitude, -1.0))])


def _ran(scenes: list[Scene]) -> Rows:
    """The ends of runs."""
    results = simulate_many(scenes, threads=1, on_error="keep")
    rows, runs, places = _with_status("run", results)
    words = [""] * len(scenes)
    for i, result in zip(places, runs, strict=True):
        summary, ledger, stretches, system = result.summary, result.ledger, result.stretches(), assemble(result.scene)
        motion = final_motion(result, system.driven)
        values = vars(motion) | {
            "turning_frequency": motion.frequency,
            "touched": _touched(motion, result.scene),
            "end_severity": severity_of(motion.motion, _border(motion, result.scene, system)).level,
            "force_max": max((own.force_max for own in motion.contacts.values()), default=motion.force_max),
            **_largest(result),
            **_watched(result.scene, stretches),
            "end_time": summary.end_time,
            "contact_time": summary.contact_time,
            "steps": summary.steps,
            "energy_residual": ledger.residual / ledger.turnover if ledger.turnover > 0.0 else 0.0,
        }
        for name in COLUMNS["run"]:
            if name != "motion":
                rows[name][i] = values[name]
        words[i] = motion.motion
    return rows | {"motion": texts(words)}


def _border(motion: FinalMotion, scene: Scene, system: System) -> Border | None:
    """How far the motion at the end of a run is towards what the contact law and any machine can bear; None without contact and
    of what runs away, whose numbers mean nothing."""
    if motion.motion in (Kind.NO_CONTACT, Kind.RUNNING_AWAY):
        return None
    forces = [own.force_max for own in motion.contacts.values()] or [motion.force_max]
    speed, mass = scene.drive.speed[-1], scene.rotor.total_mass
    return border_of(system, speed, forces, motion.amplitude_max, motion.frequency, motion.power, mass)


def _touched(motion: FinalMotion, scene: Scene) -> int:
    """The set of the contacts that a motion touches."""
    if not motion.contacts:
        return int(motion.contact_share > 0.0)
    return number_of_set(motion.touched, [contact.name or "" for contact in scene.contacts])


def _largest(result: Trajectory) -> dict[str, float]:
    """The largest amplitude, share of a gap and force of a whole run, at any of its contacts, and the contact of that force."""
    wholes = [own.whole() for own in at_contacts(result) if len(own)]
    if not wholes:
        return {"largest_amplitude": np.nan, "largest_over_gap": np.nan, "largest_force": np.nan, "largest_contact": -1}
    forces = [own.force_max for own in wholes]
    return {
        "largest_amplitude": max(own.rotor_max for own in wholes),
        "largest_over_gap": max(own.deflection_max / at.gap for own, at in zip(wholes, result.scene.contacts, strict=True)),
        "largest_force": max(forces),
        "largest_contact": int(np.argmax(forces)) if max(forces) > 0.0 else -1,
    }


def _watched(scene: Scene, stretches: Stretches) -> dict[str, float]:
    """How far a run comes to its clearances."""
    if not scene.clearances or not len(stretches):
        return {"run_clearance_share": np.nan, "run_clearance": -1, "passed_time": np.nan}
    over_gap = stretches.deflections.max(axis=0) / [place.gap for place in scene.clearances]
    passed = stretches.passed.min(axis=0)
    first = int(passed.argmin() if np.isfinite(passed).any() else over_gap.argmax())
    time = float(passed.min())
    share = float(over_gap.max())
    return {"run_clearance_share": share, "run_clearance": first, "passed_time": time if time < np.inf else np.nan}


def _listed(scenes: list[Scene]) -> Rows:
    """The most dangerous of the motions that last at the first speed of every scene's drive, and the most dangerous whirl."""
    rows = empty("motions", len(scenes)) | {"status": texts([FINISHED] * len(scenes))}
    words, whirls = [""] * len(scenes), [""] * len(scenes)
    for i, scene in enumerate(scenes):
        listed = list_of(scene, scene.drive.speed[0], STARTS, threads=1)
        rows["n_motions"][i], rows["n_unsettled"][i] = len(listed.motions), (listed.ended < 0).sum()
        rows["lasting_severity"][i] = verdict_of(None, None, (), [listed]).severity.level
        if not listed.motions:
            continue
        worst = listed.motions[0]
        sizes = worst.frequency, worst.amplitude_max, _largest_force(worst), worst.power
        values = *(sizes if worst.bounded else [np.nan] * len(sizes)), *_started(listed, [0])
        for name, value in zip(("frequency", "amplitude", "force", "power", "share", "impulse"), values, strict=True):
            rows[f"lasting_{name}"][i] = value
        rows["lasting_touched"][i] = _touched(worst, scene)
        rows["lasting_clearance_share"][i] = max(worst.clearances.values(), default=np.nan)
        words[i] = worst.motion
        if numbers := [k for k, motion in enumerate(listed.motions) if motion.motion in WHIRLING]:
            whirl = listed.motions[numbers[0]]
            own = whirl.frequency, whirl.amplitude_max, _largest_force(whirl)
            told = *(own if whirl.bounded else [np.nan] * len(own)), *_started(listed, numbers)
            for name, value in zip(("frequency", "amplitude", "force", "share", "impulse"), told, strict=True):
                rows[f"lasting_whirl_{name}"][i] = value
            whirls[i] = whirl.motion
    return rows | {"lasting": texts(words), "lasting_whirl": texts(whirls)}


def _largest_force(motion: LastingMotion) -> float:
    """The largest normal force of a motion in N, at any contact."""
    return max((own.force_max for own in motion.contacts.values()), default=motion.force_max)


def _started(listed: Motions, numbers: Sequence[int]) -> tuple[float, float]:
    """Share of the random impacts that start one of these motions of a list, and the smallest of them in N s; NaN for none."""
    started = np.isin(listed.ended, numbers)
    smallest = np.hypot(*listed.impulse[started].T).min() if started.any() else np.nan
    return float(started.mean()) if len(started) else np.nan, float(smallest)


def _checked(scenes: list[Scene]) -> Rows:
    """Comparisons of runs with their predictions."""
    results = simulate_many(scenes, threads=1, on_error="keep")
    rows, runs, places = _with_status("check", results)
    verdicts = [""] * len(scenes)
    for i, result in zip(places, runs, strict=True):
        whole = report(result, lists=False)
        verdicts[i] = whole.agreement
        rows["windows"][i] = len(whole.rows)
        for word in VERDICTS:
            rows[f"n_{word.replace(' ', '_')}"][i] = sum(row.verdict == word for row in whole.rows)
        errors = np.array([row.difference for row in whole.rows if row.quantity == FREQUENCY])
        rows["largest_frequency_error"][i] = np.nan if np.isnan(errors).all() else np.nanmax(np.abs(errors))
        if whole.transitions:
            first = whole.transitions[0]
            rows["transition_speed"][i], rows["transition_predicted"][i] = first.taken_over, first.predicted_jump
    return rows | {"verdict": texts(verdicts)}


def _with_status(kind: str, results: list[Trajectory | NoRun]) -> tuple[Rows, list[Trajectory], list[int]]:
    """Rows with the statuses and reasons of results; the runs among them, and their places."""
    reasons = [
        result.reason.removeprefix(f"{result.scene.source}: ") if isinstance(result, NoRun) else result.summary.advice
        for result in results
    ]
    rows = empty(kind, len(results)) | {
        "status": texts([str(result.status) for result in results]),
        "reason": texts([reason[:LONGEST_REASON] for reason in reasons]),
    }
    places = [i for i, result in enumerate(results) if not isinstance(result, NoRun)]
    return rows, [result for result in results if not isinstance(result, NoRun)], places


_COMPUTED: dict[str, Callable[[list[Scene]], Rows]] = {
    "predict": _predicted,
    "mu_min": _least_frictions,
    "jump": _jumps,
    "run": _ran,
    "motions": _listed,
    "check": _checked,
}
