"""Every list and table of a scene and of a command at sizes where something could change: none, one, 64 and beyond, very many."""

import json

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.errors import RscError, SceneError
from rsc.scene.scene import Scene
from rsc.study.sweep.vary import cases
from scenes import DRIVEN, LAVAL, changed

SIZES = (0, 1, 2, 63, 64, 65, 10_000)
SLOW_IF_MANY = (*SIZES[:-1], pytest.param(SIZES[-1], marks=pytest.mark.nightly))
KNOTS = ("supports_by_speed", "schedule", "torque", "coast")
FOUR = [1e3, 0.0, 0.0, 2e3]


def rising(low, high, n):
    return np.linspace(low, high, n).tolist()


# name of the list -> a scene in which it has n items
LISTS = {
    "supports": lambda n: changed(rotor={"supports": [[0, FOUR]] * n}),
    "places by speed": lambda n: changed(rotor={"supports_by_speed": [[0, [[0.0, FOUR], [90.0, FOUR]]]] * n}),
    "supports_by_speed": lambda n: changed(
        rotor={"supports_by_speed": [[0, [[speed, [1e3 + speed, 0.0, 0.0, 2e3]] for speed in rising(45.0, 65.0, n)]]]}
    ),
    "schedule": lambda n: changed(
        drive={"speed": None, "duration": None,
               "schedule": [[time, 50.0 + 5.0 * (k % 2)] for k, time in enumerate(rising(0.0, 0.4, n))]}
    ),
    "torque": lambda n: changed(DRIVEN, drive={"torque": [[speed, 60.0 - speed] for speed in rising(0.0, 90.0, n)]}),
    "coast": lambda n: changed(DRIVEN, drive={"coast": [[speed, -0.1 * speed] for speed in rising(0.0, 90.0, n)]}),
    "clearance": lambda n: changed(clearance=[{"name": f"c{i}", "rotor_coordinate": 0, "gap": 1e-3} for i in range(n)]),
    "contact": lambda n: {**LAVAL, "start": {}, "contact": [{**LAVAL["contact"], "name": f"c{i}"} for i in range(n)]},
    "masses": lambda n: changed(
        rotor={"model": "chain", "masses": [1.0] * n, "stiffnesses": [1e5] * (n + 1), "damping_ratio": 0.02}, start={}
    ),
    "stiffnesses": lambda n: changed(stator={"model": "chain", "masses": [1.0, 2.0], "stiffnesses": [1e5] * n}, start={}),
    "speed": lambda n: changed(drive={"speed": [50.0] * n}),
    "start.rotor": lambda n: changed(start={"rotor": [[1e-4, 0.0]] * n}),
    "eccentricity": lambda n: changed(rotor={"eccentricity": [1e-5] * n}),
    "load": lambda n: changed(rotor={"load": [[1.0, 0.0]] * n}),
}  # fmt: skip


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("name", LISTS)
def test_a_list_of_any_size_is_read_and_comes_back_or_is_refused_in_one_line(name, size):
    if name == "masses" and size == 10_000:
        size = 1001  # one more than may be
    try:
        scene = Scene.from_dict(LISTS[name](size))
    except SceneError as refusal:
        assert "\n" not in str(refusal) and len(str(refusal)) < 500
        assert size < 2 or name not in KNOTS
        return
    assert Scene.from_toml(scene.to_toml()) == scene


@pytest.mark.parametrize("size", SLOW_IF_MANY[2:])
@pytest.mark.parametrize("name", KNOTS)
def test_knots_and_corners_of_any_number_are_run_and_predicted(name, size):
    """A schedule across many intervals between knots: their shortest steps are not found by `np.choose`, which takes 64."""
    scene = Scene.from_dict(LISTS[name](size))
    if name == "supports_by_speed":
        scene = scene.with_values({"drive.speed": [45.0, 65.0]})
    assert rsc.simulate(scene.with_values({"start.centre": True, "contact.gap": 1.0})).status == "finished"
    rsc.predict(scene, speed=50.0)


@pytest.mark.parametrize("size", SLOW_IF_MANY[2:])
@pytest.mark.parametrize("name", ["supports_by_speed", "schedule", "torque"])
def test_knots_and_corners_of_any_number_are_checked_and_their_motions_listed(name, size):
    """A short run, and the motions at 50 Hz from what is predicted and one random impact."""
    scene = Scene.from_dict(LISTS[name](size))
    if name == "supports_by_speed":
        scene = scene.with_values({"drive.speed": [49.0, 51.0], "drive.duration": 0.3})
    assert rsc.check(scene).result.status in ("finished", "steps exhausted")
    if name != "torque":
        assert rsc.motions(scene, 50.0, starts=1).motions


@pytest.mark.parametrize("size", (1, 2, 16))  # at most
def test_clearances_of_any_number_are_watched(size):
    scene = Scene.from_dict(LISTS["clearance"](size)).with_values({"drive.duration": 0.2})
    report = rsc.check(scene)
    assert report.result.stretches().deflections.shape[-1] == size


@pytest.mark.parametrize("size", SIZES)
def test_values_of_a_sweep_and_rows_of_its_table_are_cases_or_refused(size, tmp_path):
    scene = Scene.from_dict(LAVAL)
    values, table = rising(0.1, 0.2, size), tmp_path / "cases.csv"
    table.write_text("contact.friction\n" + "".join(f"{value!r}\n" for value in values))
    forms = (values, ",".join(map(repr, values)), f"0.1:0.2:{size}")
    for how in (*({"vary": {"contact.friction": form}} for form in forms), {"table": table}):
        try:
            assert len(cases(scene, **how)) == size
        except RscError as refusal:
            assert size < 2 and "\n" not in str(refusal)


@pytest.mark.parametrize("size", SLOW_IF_MANY)
def test_speeds_of_the_campbell_table_are_shown_or_refused(size, tmp_path, capsys):
    file = tmp_path / "scene.toml"
    file.write_text(Scene.from_dict(LAVAL).to_toml())
    code = main(["modes", str(file), "--speeds", f"600:6000 rpm:{size}", "--json"])
    told, refused = capsys.readouterr()
    if size < 2:
        assert code == 2 and refused.count("\n") == 1
    else:
        assert code == 0 and len(json.loads(told)["modes"]) == size


@pytest.mark.parametrize("size", [1, 2, 63, 64, 65])
def test_speeds_of_predictions_of_any_number(size):
    scene = Scene.from_dict(LAVAL)
    assert len(rsc.predict(scene, speed=rising(40.0, 60.0, size))) >= size > 0
