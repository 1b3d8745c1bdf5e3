"""Whatever is given to a public function is used, or refused by an error of rsc in one line; no TypeError from inside."""

import inspect
import itertools
from datetime import date
from fractions import Fraction

import numpy as np
import pytest

import rsc
from probes import pulses_of, written
from rsc.scene.files.templates import template
from rsc.study.explore.server import Explorer
from scenes import SCENES, changed
from tiers import first

SCENE = rsc.Scene.from_dict(changed(drive={"duration": 0.3}))
WRONG = (
    *(
        None,
        True,
        -1,
        3,
        2**40,
        2**70,
        0.5,
        -0.0,
        1e308,
        float("nan"),
        float("inf"),
        1j,
        "",
        "x",
        "\0",
        "a\nb",
        "scene.toml",
        b"x",
    ),
    *([], [None], [True], [2**70], [[1.0], [1.0, 2.0]], (), set(), {}, {"speed": 3}, {1: 2}, iter([1]), range(3)),
    *(object(), object, int, len, lambda: None, date(2026, 1, 1), Fraction(1, 3), SCENE, [SCENE, 1]),
    *(np.float32(2.0), np.int64(2), np.bool_(True), np.datetime64("2026-01-01")),
    *(np.array(["x"]), np.array([object()]), np.array([np.nan, 1.0]), np.zeros((2, 2, 2)), np.zeros(0)),
)

PARTS = 5  # into which all wrong arguments are dealt in turn; no divisor of the number of WRONG


def ended(made):
    """Close the page that a function has opened."""
    if isinstance(made, Explorer):
        made.close()


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    """public function -> arguments with which it works."""
    file = tmp_path_factory.mktemp("files") / "scene.toml"
    file.write_text(SCENE.to_toml())
    result = rsc.simulate(SCENE)
    time = np.arange(0.0, 1.0, 1e-3)
    measured = written(file.parent, time, 1e-4 * np.exp(-60j * time), pulses_of(30.0 * time))
    result.save(file.with_name("run.h5"))
    speed, near = 50.0, rsc.predict(SCENE, 50.0)[0].frequency
    line = {"scene": SCENE, "near": near, "speeds": (speed, speed + 1.0)}
    short = {"scene": rsc.Scene.from_dict(changed(drive={"duration": 0.01})), "integrator": len, "settings": [1e-3]}
    return {
        rsc.simulate: {"scene": SCENE},
        rsc.check: {"scene": SCENE},
        rsc.simulate_many: {"scenes": [SCENE, SCENE]},
        rsc.cases: {"scene": SCENE, "vary": {"contact.friction": [0.1, 0.2]}},
        rsc.sweep: {"scene": SCENE, "vary": {"contact.friction": [0.1]}, "compute": "mu_min"},
        rsc.plot_sweep: {"data": rsc.sweep(SCENE, {"contact.friction": [0.1, 0.2]})},
        rsc.smallest_impulse: {"scene": SCENE.with_values({"drive.speed": speed}), "directions": 1, "largest": 0.01},
        rsc.motions: {"scene": SCENE, "speed": speed, "starts": 1, "largest": 0.01},
        rsc.equations: {"scene": SCENE},
        rsc.benchmark: {**short, "beside": rsc.benchmark(**short)},
        rsc.explore: {"scene": SCENE},
        rsc.remedy: {"scene": SCENE.with_values({"contact.friction": 0.0}), "speed": speed, "starts": 1},
        rsc.sensitivity: {"scene": SCENE, "speed": speed, "values": ["contact.friction"]},
        rsc.predict: {"scene": SCENE, "speed": speed},
        rsc.limits: {"scene": rsc.Scene.from_dict(SCENE.to_dict() | {"limits": {"maximum_continuous": 50.0}})},
        rsc.modes: {"scene": SCENE, "speed": speed},
        rsc.critical_map: {"scene": rsc.Scene.from_toml(template("pump")), "stiffness": [1e7, 1e8]},
        rsc.predict_many: {"scenes": [SCENE], "speeds": [speed]},
        rsc.force_ratios: {"scene": SCENE, "speed": speed},
        rsc.fold: line,
        rsc.crossing: line,
        rsc.delay: {"scene": SCENE.with_values({"drive.speed": [40.0, 60.0]}), "near": near},
        rsc.waterfall: {"result": result, "window": 0.1},
        rsc.spectral_peaks: {"result": result, "window": 0.1},
        rsc.envelope: {"result": result, "window": 0.1},
        rsc.track_lines: {"result": result, "window": 0.1},
        rsc.transitions: {"result": result},
        rsc.read_measured: {"path": measured},
        rsc.write_measured: {"result": result, "path": file.with_name("probes.toml")},
        rsc.compare: {"measured": rsc.read_measured(measured), "scene": SCENE},
        rsc.fit: {"measured": rsc.read_measured(measured), "scene": SCENE, "free": "contact.gap"},
        rsc.load: {"path": file.with_name("run.h5")},
        rsc.load_scene: {"path": file},
        rsc.Scene.from_dict: {"mapping": SCENE.to_dict()},
        rsc.Scene.from_toml: {"text": SCENE.to_toml()},
        SCENE.with_values: {"values": {"contact.friction": 0.1}},
        result.save: {"path": file.with_name("again.h5")},
    }


def test_every_public_function_is_tried(right):
    functions = {getattr(rsc, name) for name in rsc.__all__ if inspect.isfunction(getattr(rsc, name))}
    assert functions - right.keys() == set()
    for function, arguments in right.items():
        if function not in (rsc.delay, rsc.fit):  # which need a whirl that ends, a measured one that lasts
            ended(function(**arguments))


@pytest.mark.parametrize("part", first(range(PARTS)))
@pytest.mark.filterwarnings("error")
def test_wrong_arguments_are_refused_in_one_line(right, part, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # what is a name for a file becomes one
    refused = 0
    for function, arguments in right.items():
        tried = itertools.product(inspect.signature(function).parameters, WRONG)
        for name, value in itertools.islice(tried, part, None, PARTS):
            try:
                ended(function(**arguments | {name: value}))
            except rsc.RscError as error:
                refused += 1
                text = str(error)
                assert text.isprintable() and len(text) < 700, (function, name, value, text)
            except Exception as error:
                if name == "note" and callable(value):
                    continue  # its own error
                error.add_note(f"{function.__qualname__}({name}={value!r})")
                raise
    assert refused > 1500 / PARTS


def test_numbers_of_numpy_count_as_numbers(right):
    assert [w.frequency for w in rsc.predict(SCENE, np.int64(50))] == [w.frequency for w in rsc.predict(SCENE, 50.0)]
    assert rsc.Scene.from_dict(changed(drive={"speed": np.float64(50.0), "duration": np.int64(1)})).drive.duration == 1.0
    assert rsc.spectral_peaks(**right[rsc.spectral_peaks], count=np.int64(2)).frequency.shape[1] == 2
    assert len(rsc.simulate_many([SCENE], threads=np.int64(1))) == 1


def test_a_speed_may_have_its_unit(right):
    """As on the command line; the number is exactly that of the scene."""
    near = rsc.predict(SCENE, 50.0)[0].frequency
    for function, text, number in (
        (rsc.predict, "3000 rpm", 50.0), (rsc.predict, ["50 Hz", 60.0], [50.0, 60.0]), (rsc.modes, "3000 rpm", 50.0),
        (rsc.modes, ("3000 rpm", "3600 rpm"), (50.0, 60.0)), (rsc.force_ratios, "3000 1/min", 50.0),
    ):  # fmt: skip
        assert repr(function(SCENE, text)) == repr(function(SCENE, number))
    assert rsc.sensitivity(SCENE, "3000 rpm").speed == rsc.sensitivity(SCENE, 50.0).speed == 50.0
    assert rsc.motions(SCENE, "3000 rpm", 1, largest=0.01).speed == 50.0
    for function in (rsc.fold, rsc.crossing):
        assert repr(function(SCENE, near, ("3000 rpm", "85 Hz"))) == repr(function(SCENE, near, (50.0, 85.0)))
    found = rsc.predict_many([SCENE], ["3000 rpm", "60 Hz"]), rsc.predict_many([SCENE], [["3000 rpm", "60 Hz"]])
    wanted = rsc.predict_many([SCENE], [50.0, 60.0])
    assert all(np.array_equal(each.frequency, wanted.frequency, equal_nan=True) for each in found)
    for text, hint in (("3000 um", "rpm or rad"), ("50", "without quotes"), ("fast", "3000 rpm"), (["3000 rp"], "unknown")):
        with pytest.raises(rsc.SceneError, match=hint):
            rsc.predict(SCENE, text)


def test_python_tells_of_arguments_that_no_function_has():
    with pytest.raises(TypeError, match=r"predict\(\) got an unexpected keyword"):
        rsc.predict(SCENE, speeds=3.0)


@pytest.mark.parametrize("scenes", ["x", None, 3, SCENE, [SCENE, None], SCENES])
def test_what_is_no_list_of_scenes_is_refused(scenes):
    for call in (lambda: rsc.simulate_many(scenes), lambda: rsc.predict_many(scenes, [50.0])):
        with pytest.raises(rsc.SceneError, match="must be a sequence"):
            call()
