"""A user's script, read by mypy and never run: `make lint` fails where an `assert_type` and a hint of the public API differ."""

from pathlib import Path
from typing import assert_type

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import rsc
from rsc import cli
from rsc.analysis.follow.branch import Branch
from rsc.analysis.follow.events import Event
from rsc.measure import envelopes, spectra
from rsc.measure.changes import Transition
from rsc.measure.verdict import Row
from rsc.measure.windows import Steady
from rsc.results.summary import Ledger, Status, Summary
from rsc.show.pictures import plots
from rsc.study.report.report import Report

Floats = NDArray[np.float64]

# scenes
scene = rsc.load_scene(Path("scene.toml"))
assert_type(scene, rsc.Scene)
assert_type(rsc.load_scene("scene.toml").with_values({"contact.friction": 0.1, "contact.gap": "0.2 mm"}), rsc.Scene)
assert_type(rsc.Scene.from_toml(scene.to_toml()), rsc.Scene)
assert_type(scene.title, str)
assert_type(scene.contact.gap, float)
assert_type(scene.drive.duration, float)

# runs
run = rsc.simulate(scene, path="run.h5", resume=True)
assert_type(run, rsc.Trajectory)
assert_type(rsc.simulate_many([scene, scene], threads=2), list[rsc.Trajectory])
assert_type(rsc.load("run.h5"), rsc.Trajectory)
assert_type(run.time, Floats)
assert_type(run.normal_force, Floats)
assert_type(run.rotor, NDArray[np.complex128])
assert_type(run.contact_rotor(), NDArray[np.complex128])
assert_type(run.status, Status)
assert_type(run.steps, int)
assert_type(run.summary, Summary)
assert_type(run.summary.advice, str)
assert_type(run.ledger, Ledger)
assert_type(run.ledger.turnover, float)

# predictions
whirls = rsc.predict(scene, speed=50.0)
assert_type(whirls, rsc.Whirls)
assert_type(rsc.predict(scene), rsc.Whirls)
assert_type(rsc.predict(scene, speed=[50.0, 60.0]), list[rsc.Whirls])
assert_type(rsc.predict(scene, speed=np.linspace(50.0, 60.0, 11)), list[rsc.Whirls])
assert_type(rsc.predict_many([scene, scene], speeds=[50.0, 60.0], near=[-30.0]), rsc.WhirlArrays)
assert_type(rsc.predict_many([scene], np.linspace(50.0, 60.0, 11)).growth_rate, Floats)
assert_type(rsc.fold(scene, near=-30.0, speeds=(20.0, 60.0)), Event | None)
assert_type(rsc.crossing(scene, near=-30.0, speeds=(60.0, 20.0)), Event | None)
assert_type(rsc.delay(scene, near=-30.0).jump, float)
assert_type(whirls[0].frequency, float)
assert_type(whirls[0].stable, bool)
assert_type(whirls[0].rotor_shape, NDArray[np.complex128])
assert_type(whirls[0].conditions, dict[str, float])
assert_type(whirls[0].synchronous.consistent.envelope, tuple[float, float])
ratios = rsc.force_ratios(scene, speed=50.0)
assert_type(ratios, list[rsc.ForceRatio])
assert_type(ratios[0].mirror_share, float)

# spectra
fall = rsc.waterfall(run, window=0.5, f_max=200.0)
assert_type(fall, spectra.Waterfall)
assert_type(fall.amplitude, Floats)
assert_type(rsc.spectral_peaks(run, side="positive", count=2), spectra.Peaks)
assert_type(rsc.envelope(run), envelopes.Envelope)
assert_type(rsc.track_lines(run, window=0.5)[0], spectra.Line)
assert_type(spectra.line_at(fall, fall.speed).amplitude, Floats)

# the comparison
report = rsc.check(scene, progress=True)
assert_type(report, Report)
assert_type(report.result, rsc.Trajectory)
assert_type(report.rows, list[Row])
assert_type(report.rows[0].difference, float)
assert_type(report.transitions, list[Transition])
assert_type(report.branches, list[Branch])
assert_type(report.branches[0].at(50.0), rsc.Whirl | None)
assert_type(report.agreement, str)
assert_type(rsc.transitions(run), list[Transition])
assert_type(Steady(*[fall.speed] * 4).alone, Floats)

# pictures and the command line
figure = plots.stacked([{"data": [], "layout": {}}], scene.title)
assert_type(figure, Figure)
plots.save(figure, Path("campbell.png"))
assert_type(cli.main(["check", "scene.toml"]), int)

# errors
try:
    rsc.load_scene("scene.toml")
except rsc.SceneError as error:
    assert_type(error.key, str)
    assert_type(error.hint, str)
except rsc.DataError as error:
    assert_type(error.problem, str)

# calls that a checker must refuse: `warn_unused_ignores` fails when it does not
rsc.predict("scene.toml")  # type: ignore[call-overload]
rsc.simulate(run)  # type: ignore[arg-type]
rsc.waterfall(scene)  # type: ignore[arg-type]
rsc.spectral_peaks(run, side="backward")  # type: ignore[arg-type]
