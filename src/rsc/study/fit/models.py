"""What a scene with other values predicts and simulates of the whirl that was measured, in the windows of the measurement."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rsc.analysis.paper.predict_many import predict_many, unbalance_lines
from rsc.errors import SceneError
from rsc.measure.features import turned
from rsc.results.trajectory import Trajectory
from rsc.scene.scene import Scene
from rsc.scene.tables.drive import Drive
from rsc.scene.values import with_entries
from rsc.study.fit.free import Free
from rsc.study.fit.seen import FEATURES, FittedWindows, Span, WindowLines, lines_of
from rsc.study.run.ensemble import simulate_many

SAMPLES = 4_000_000  # of runs that are held at a time
OTHER = 0.1  # of its frequency, from which a simulated whirl is not the measured one

SLOW = 1 / 6, 1 / 2, 5 / 6  # quantiles of the speeds at slow roll, at which unbalance is taken off with the runout

Values = NDArray[np.float64]  # (n_free,) coordinates of the free values


@dataclass(frozen=True)
class PredictedFeatures:
    """features : (k, n_w, 4), NaN where there is no whirl; growth_rate : (k, n_w), over the frequency of the whirl in rad/s."""

    features: NDArray[np.float64]
    growth_rate: NDArray[np.float64]


def features_of(lines: WindowLines) -> NDArray[np.float64]:
    """(n_w, 4) features of lines."""
    sizes = np.log(np.abs(lines.frequency)), np.log(lines.amplitude)
    return np.column_stack([*sizes, lines.order.real, lines.order.imag])


class Models:
    """Scenes with free values for a measured run; `runs` counts the simulations."""

    def __init__(self, scene: Scene, seen: FittedWindows, free: Sequence[Free], threads: int | None = None) -> None:
        self.scene, self.seen, self.free, self._threads = scene, seen, list(free), threads
        self.runs = 0
        self._slow: NDArray[np.float64] | None = None  # speeds in Hz at which runout was seen
        if seen.run.slow_roll is not None:
            low, high = seen.run.slow_roll
            speed = seen.run.speed[(seen.run.speed >= low) & (seen.run.speed <= high)]
            self._slow = np.quantile(speed, SLOW)

    def scene_of(self, values: Values) -> Scene:
        """The scene with values at some coordinates, turning as it was given; SceneError where there is none."""
        return with_entries(self.scene, {one.name: one.value(u) for one, u in zip(self.free, values.tolist(), strict=True)})

    def _forward(self, values: Values) -> Scene:
        """The same as it is measured: turning forward."""
        return self.scene_of(values).turning_forward()

    def predicted(self, points: NDArray[np.float64], windows: NDArray[np.intp]) -> PredictedFeatures:
        """What scenes at points (k, n_free) predict in some windows: of their whirls those next to the measured frequencies."""
        features = np.full((len(points), len(windows), FEATURES), np.nan)
        growth_rate = np.full(features.shape[:2], np.nan)
        places, scenes = [], []
        for i, values in enumerate(points):
            try:
                scenes.append(self._forward(values))
            except SceneError:  # values that do not go together
                continue
            places.append(i)
        if not scenes:
            return PredictedFeatures(features, growth_rate)
        whirls = predict_many(scenes, self.seen.speed[windows])
        backward = np.where(whirls.frequency < 0.0, np.abs(whirls.frequency), np.nan)
        away = np.abs(np.log(backward / np.abs(self.seen.lines.frequency[windows])[:, None]))
        if away.shape[2] == 0:
            return PredictedFeatures(features, growth_rate)
        chosen = np.nan_to_num(away, nan=np.inf).argmin(axis=2)[..., None]
        frequency, amplitude, order, rate = (
            np.take_along_axis(values, chosen, axis=2)[..., 0]
            for values in (backward, whirls.rotor_amplitude, whirls.line, whirls.growth_rate)
        )
        order = self.seen.order_of(order - self._taken_off(scenes)[:, None])
        features[places] = np.stack([np.log(frequency), np.log(amplitude), order.real, order.imag], axis=-1)
        growth_rate[places] = rate / (2.0 * np.pi * frequency)
        return PredictedFeatures(features, growth_rate)

    def _taken_off(self, scenes: Sequence[Scene]) -> NDArray[np.complex128]:
        """(k,) complex m, the lines by the unbalance of scenes that were taken off with the runout."""
        if self._slow is None:
            return np.zeros(len(scenes), dtype=complex)
        return np.asarray(unbalance_lines(scenes, self._slow).mean(axis=1))

    def simulated(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k, n_w, 4) features of runs at points (k, n_free), NaN in windows without the whirl that was measured."""
        features = np.full((len(points), len(self.seen.starts), FEATURES), np.nan)
        jobs = [(i, span) for i in range(len(points)) for span in self.seen.spans]
        longest = max(span.last - span.first + self.seen.size for span in self.seen.spans)
        together = max(SAMPLES // longest, 1)
        for first in range(0, len(jobs), together):
            own = jobs[first : first + together]
            scenes, made = [], []
            for i, span in own:
                try:
                    scenes.append(self._run_of(points[i], span))
                except SceneError:
                    continue
                made.append((i, span))
            if not scenes:
                continue
            for (i, span), run in zip(made, simulate_many(scenes, threads=self._threads, on_error="keep"), strict=True):
                self.runs += 1
                if isinstance(run, Trajectory):
                    features[i, span.own] = self._features(run, span)
        return features

    def _run_of(self, values: Values, span: Span) -> Scene:
        """The scene of a run over a span, which starts a window before it on the whirl next to the measured one."""
        seen = self.seen
        measured, rate, lead = seen.run.scene, seen.run.scene.output.rate, seen.size / seen.run.scene.output.rate
        begin, end = span.first / rate, span.last / rate
        corners = [time for time in measured.drive.time if begin < time < end]
        speeds = np.interp([begin, *corners, end], measured.drive.time, measured.drive.speed).tolist()
        times = [0.0] + [time - begin + lead for time in (begin, *corners, end)]
        frequency = float(seen.lines.frequency[span.own][0])
        scene = self._forward(values)
        start = scene.start.on_whirl(frequency)
        return replace(scene, drive=Drive.along(tuple(times), (speeds[0], *speeds)), start=start, output=measured.output)

    def _features(self, run: Trajectory, span: Span) -> NDArray[np.float64]:
        seen = self.seen
        starts = seen.starts[span.own] - span.first + seen.size
        features = np.full((len(starts), FEATURES), np.nan)
        recorded = starts + seen.size <= run.n_time  # a run may have ended before
        motion = run.contact_rotor()  # a load's deflection is no line
        lines = lines_of(motion - motion.mean(), turned(run, run.time), starts[recorded], seen.size, run.scene.output.rate)
        order = self.seen.order_of(lines.order - self._taken_off([run.scene]))
        features[recorded] = features_of(replace(lines, order=order))
        expected = np.log(np.abs(seen.lines.frequency[span.own]))
        features[~(np.abs(features[:, 0] - expected) < OTHER)] = np.nan
        return features
