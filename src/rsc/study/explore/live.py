"""What the page of `rsc explore` asks for: values to move, and what follows from them, as descriptions and words."""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from threading import Event
from typing import Any

import numpy as np

from rsc.analysis.paper.predict import Whirl
from rsc.analysis.paper.predict_many import predict_many
from rsc.analysis.paper.rolling import rolling_whirls
from rsc.analysis.several.whirl import SeveralWhirl
from rsc.errors import RscError, SceneError, SolverError
from rsc.measure.spectra import waterfall
from rsc.results.trajectory import Trajectory
from rsc.scene.scene import Scene
from rsc.scene.values import physical_values, value_of
from rsc.show.pictures.of_results import reach_of, spectrum, whirl_picture
from rsc.show.pictures.paths import traces_of_orbit
from rsc.show.pictures.traces import axes, numbers
from rsc.show.words.lasting import lasting_text
from rsc.show.words.motions import motions_text
from rsc.show.words.several import several_text
from rsc.show.words.text import whirls_text
from rsc.show.words.units import largest_finite, unit_for
from rsc.study.motions.motions import motions
from rsc.study.prediction.predictions import predictions
from rsc.study.run.simulate import simulate
from rsc.system.assemble import assemble
from rsc.system.border import border_of

# moved most, the first of each row that a scene has
FIRST = (
    ("contact.friction",), ("contact.gap",), ("rotor.damping_ratio", "rotor.damping", "rotor.supports[0].damping"),
    ("stator.frequency", "stator.stiffness"), ("rotor.eccentricity",),
)  # fmt: skip
SPEED = "speed"  # Hz, of the whole page; of the scene's drive nothing else is kept
WIDEST = 4.0  # times and parts of its value, between which one is moved
SPEEDS, FEWEST, ROWS, COLUMNS = 61, 13, 15, 21
AT_ONCE = 0.06  # s that the whirls over the speed may take
TURNS, LONGEST = 25.0, 0.5  # of the short run; s
STARTS = 16  # of the list of motions


@dataclass(frozen=True)
class Handle:
    """A value that can be moved: its name and meaning, its value and the range it is moved in (SI), the unit in which it is shown
    and the factor to that from SI."""

    name: str
    unit: str
    factor: float
    meaning: str
    value: float
    low: float
    high: float
    first: bool


class Live:
    """A scene whose values are moved.

    scene : Scene, as it is before anything is moved
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        known = {name: value for name, value in physical_values(scene).items() if value != 0.0 and math.isfinite(value)}
        if scene.rotor.model == "reduced":  # entries of its matrices, hundreds, of which nobody moves one alone
            known = {name: value for name, value in known.items() if not (name.startswith("rotor.") and "[" in name)}
        first = [next((name for name in row if name in known), "") for row in FIRST]
        top = max(map(abs, scene.drive.speed)) or 50.0
        low, high = self._speeds(top)
        speed = min(max(abs(scene.drive.speed[0]) or 0.5 * (low + high), low), high)
        self.handles = [Handle(SPEED, "Hz", 1.0, "rotor speed", speed, low, high, True)]
        for name in sorted(known, key=lambda name: (first.index(name) if name in first else len(first), name)):
            own = value_of(scene, name)
            low, high = sorted((known[name] / WIDEST, known[name] * WIDEST))
            factor, unit = unit_for(abs(known[name]), "m") if own.unit == "m" else (1.0, "" if own.unit == "1" else own.unit)
            self.handles.append(Handle(name, unit, factor, own.meaning, known[name], low, high, name in first))
        self._n_speeds = SPEEDS
        self._known = {handle.name: handle for handle in self.handles}

    def _speeds(self, top: float) -> tuple[float, float]:
        if self.scene.rotor.model == "reduced":  # for these alone the rotor was reduced
            low, high = getattr(self.scene.rotor, "speeds", (0.1 * top, 1.5 * top))
            return max(float(low), 0.02 * float(high)), float(high)
        return 0.1 * top, 1.5 * top

    def moved(self, values: Mapping[str, Any]) -> tuple[Scene, float]:
        """The scene with values moved, at a constant speed, and this speed in Hz; SceneError for other names."""
        for name, value in values.items():
            if name not in self._known:
                raise SceneError("explore", str(name)[:80], None, "the name of a value of this scene")
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
                raise SceneError("explore", name, str(value)[:80], "a finite number")
        speed = float(values.get(SPEED, self._known[SPEED].value))
        changes: dict[str, Any] = {name: float(value) for name, value in values.items() if name != SPEED}
        duration = min(LONGEST, TURNS / max(abs(speed), 1.0))
        if self.scene.drive.inertia is None:
            changes |= {"drive.speed": speed, "drive.duration": duration}
        return self.scene.with_values(changes), speed

    def whirls(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The predicted whirls over the rotor speed, at fewer speeds where a machine takes long."""
        scene, _ = self.moved(values)
        if len(scene.contacts) > 1:
            return {"picture": None}
        handle, begun = self._known[SPEED], time.perf_counter()
        many = predict_many([scene], np.linspace(handle.low, handle.high, self._n_speeds))
        if time.perf_counter() - begun > AT_ONCE:
            self._n_speeds = max(FEWEST, self._n_speeds // 2)
        picture = whirl_picture(many.speed[0][:, None], many.frequency[0], many.stable[0])
        picture["layout"]["xaxis"] = {"title": "rotor speed in Hz", "range": [handle.low, handle.high]}
        return {"picture": picture}

    def words(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """What lasts at the speed in a sentence, the predicted whirls in words, and how many of them are stable."""
        scene, speed = self.moved(values)
        (told,) = predictions(scene, [speed])
        system, rolling = assemble(scene), []
        if len(scene.contacts) > 1:
            words = several_text(told.whirls, speed, told.remarks, told.loads)
        else:
            words = whirls_text(told.whirls, scene.contact.gap, told.remarks, told.ratios, told.loads)
            rolling = rolling_whirls(system, math.tau * speed)
        sizes = [("sliding", w.frequency, w.rotor_amplitude, _forces(w)) for w in told.whirls if w.stable]
        sizes += [("rolling", w.Psi / math.tau, w.rotor_amplitude, [w.normal_force]) for w in rolling if w.stable]
        lasting = [
            (kind, frequency, amplitude, max(forces), border_of(system, speed, forces, amplitude, frequency))
            for kind, frequency, amplitude, forces in sizes
        ]
        verdict = lasting_text(speed, lasting, len(told.whirls) + len(rolling) - len(lasting))
        return {"verdict": verdict, "words": words, "stable": sum(bool(whirl.stable) for whirl in told.whirls)}

    def run(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Orbit and full spectrum of a short run at the speed."""
        scene, _ = self.moved(values)
        result, start = self._simulated(scene)
        rotor, stator, contact = result.contact_rotor(), result.contact_stator(), scene.contacts[0]
        last = slice(len(rotor) // 2, None)
        factor, unit = unit_for(max(largest_finite(np.abs(rotor)), contact.gap), "m")
        touching = np.reshape(result.normal_force, (len(rotor), -1))[last, 0] > 0.0
        data = traces_of_orbit(factor * rotor[last], factor * stator[last], touching, np.zeros(0, int), factor * contact.gap)
        moving = rotor[last] - rotor[last].mean()
        fall = waterfall(result.time[last], moving, result.speed[last], window=0.5 * float(result.time[-1]))
        frequencies = spectrum(fall.frequency, fall.amplitude[-1], float(fall.speed[-1]), reach_of(fall))
        return {
            "orbit": {"data": data, "layout": axes(f"y in {unit}", f"z in {unit}", 340, equal=True)},
            "spectrum": frequencies,
            "words": f"{start}{result.status}: {result.summary.end_time:.3g} s, in contact {result.summary.contact_time:.3g} s",
        }

    def _simulated(self, scene: Scene) -> tuple[Trajectory, str]:
        """A run from the start of the scene, or without contact where that start is no more; and a word on the latter."""
        try:
            return simulate(scene), ""
        except SceneError:
            if scene.start.kind != "whirl":
                raise
            running = replace(scene, start=replace(scene.start, whirl=None, running=True))
            return simulate(running), "the whirl to start on is no more; started without contact: "

    def map(self, values: Mapping[str, Any], x: str, y: str) -> dict[str, Any]:
        """Amplitude of the largest stable whirl over two values."""
        scene, speed = self.moved(values)
        if len(scene.contacts) > 1:
            raise SolverError("the map is not live: whirls at several contacts are not predicted as arrays")
        if x == y or x not in self._known or y not in self._known:
            raise SceneError("explore", "map", f"{x}, {y}"[:80], "two different values of this scene")
        xs, ys = (np.linspace(self._known[name].low, self._known[name].high, n) for name, n in ((x, COLUMNS), (y, ROWS)))
        if SPEED in (x, y):
            other, others, speeds = (y, ys, xs) if x == SPEED else (x, xs, ys)
            grid = predict_many([self._with(scene, {other: value}) for value in others.tolist()], speeds)
        else:
            cases = [{x: first, y: second} for second in ys.tolist() for first in xs.tolist()]
            grid = predict_many([self._with(scene, case) for case in cases], [speed])
        largest = np.where(grid.stable, grid.rotor_amplitude, 0.0).max(axis=-1, initial=0.0)
        largest = largest.reshape(ROWS, COLUMNS) if SPEED not in (x, y) else largest if x == SPEED else largest.T
        top = largest_finite(largest) or 1e-3
        factor, unit = unit_for(top, "m")
        across, upwards = (self._known[name] for name in (x, y))
        heat = {"type": "heatmap", "x": numbers(across.factor * xs), "y": numbers(upwards.factor * ys),
                "z": [numbers(factor * row) for row in largest],
                "colorbar": {"title": {"text": unit}}, "zmin": 0.0, "zmax": factor * top,
                "colorscale": [[0.0, "#ffffff"], [0.02, "#ffe9a8"], [0.5, "#f08a3c"], [1.0, "#9e1b1b"]]}  # fmt: skip
        right, up = (f"{each.name} in {each.unit}" if each.unit else each.name for each in (across, upwards))
        return {"picture": {"data": [heat], "layout": axes(right, up, 340)}}

    def _with(self, scene: Scene, values: dict[str, float]) -> Scene:
        return scene.with_values({name: value for name, value in values.items() if name != SPEED})

    def toml(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The text of a scene with the values moved and with the drive as it was."""
        self.moved(values)
        own = {name: float(value) for name, value in values.items() if name != SPEED}
        return {"text": (self.scene.with_values(own) if own else self.scene).to_toml()}

    def listed(self, values: Mapping[str, Any], note: Callable[[int, int], object]) -> str:
        """The list of motions at the speed in words; takes seconds to minutes."""
        scene, speed = self.moved(values)
        return motions_text(motions(scene, speed, STARTS, note=note), scene.title)


def _forces(whirl: Whirl) -> list[float]:
    """Normal forces at all contacts in N."""
    return [each.normal_force for each in whirl.contacts.values()] if isinstance(whirl, SeveralWhirl) else [whirl.normal_force]


class Job:
    """The one list of motions that is made in the background; another one ends it."""

    def __init__(self) -> None:
        self.told: dict[str, Any] = {"state": "none"}
        self._stop = Event()

    def run(self, live: Live, values: Mapping[str, Any]) -> None:
        """Make the list; to be called in a thread of its own."""
        self._stop.set()
        stop = self._stop = Event()
        self.told = told = {"state": "running", "ended": 0, "of": 0}

        def note(ended: int, of: int) -> None:
            if stop.is_set():
                raise _Stopped
            told.update(ended=ended, of=of)

        try:
            text = live.listed(values, note)
            told.update(state="done", words=text)
        except _Stopped:
            told.update(state="stopped")
        except RscError as error:
            told.update(state="failed", words=str(error))
        except Exception as error:
            told.update(state="failed", words=f"{type(error).__name__}: {error}"[:500])


class _Stopped(Exception):
    """Another list is wanted."""


