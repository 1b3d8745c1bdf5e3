"""Drives with a torque that cannot be: each refused in one line, when the scene is read or before it runs."""

import math

import pytest

import rsc
from rsc.errors import SceneError
from rsc.system.assemble import assemble
from scenes import LAVAL, changed

DRIVE = {"inertia": 0.15, "torque": [[0.0, 2.0], [50.0, 0.0]], "speed": 20.0, "duration": 1.0}
GOOD = {**changed(LAVAL, contact={"diameter": 0.05, "slip_velocity": 0.02}), "drive": DRIVE}


def with_drive(**keys):
    return changed(GOOD, drive=keys)


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (with_drive(schedule=[[0.0, 20.0], [1.0, 30.0]]), r"drive\.schedule = .*must be left out"),
        (with_drive(torque=[[0.0, 2.0]]), r"drive\.torque = .*at least two knots"),
        (with_drive(torque=[[50.0, 0.0], [0.0, 2.0]]), r"drive\.torque\[1\]\[0\] = 0\.0: must be more than 50 Hz \(knots must"),
        (with_drive(torque=[[0.0, 2.0], [0.0, 1.0]]), r"drive\.torque\[1\]\[0\] = 0\.0: must be more than 0 Hz"),
        (with_drive(torque=[[0.0, 2.0, 1.0], [50.0, 0.0]]), r"drive\.torque\[0\] = .*\[speed in Hz, torque in N m\]"),
        (with_drive(torque=[[-5.0, 2.0], [50.0, 0.0]]), r"drive\.torque\[0\]\[0\] = -5\.0"),
        (with_drive(torque=7.0), r"drive\.torque = 7\.0"),
        (with_drive(torque=None), r"drive\.torque = \(missing\)"),
        (with_drive(inertia=None), r"drive\.inertia = \(missing\)"),
        (with_drive(speed=None), r"drive\.speed = \(missing\)"),
        (with_drive(duration=None), r"drive\.duration = \(missing\)"),
        (with_drive(inertia=0.0), r"drive\.inertia = 0\.0: must be a number > 0"),
        (with_drive(speed=[20.0, 30.0]), r"drive\.speed = .*one number, the initial speed"),
        (with_drive(speed=-20.0), r"drive\.speed = -20\.0: must be >= 0 Hz"),
        (with_drive(speed=0.0, torque=[[0.0, -1.0], [50.0, 2.0]]), r"drive\.torque = .*the rotor would never start"),
        (with_drive(speed=0.0, torque=[[0.0, 0.0], [50.0, 2.0]]), r"drive\.torque = .*the rotor would never start"),
        (with_drive(trip=1.5), r"drive\.trip = 1\.5: must be between 0 s and drive\.duration = 1 s"),
        (with_drive(coast=[[0.0, -1.0], [50.0, -2.0]]), r"drive\.trip = \(missing\): must be given: .* go together"),
        (with_drive(trip=0.5, coast=[[50.0, -1.0], [0.0, -2.0]]), r"drive\.coast\[1\]\[0\]"),
        (changed(GOOD, contact={"diameter": None, "slip_velocity": None}), r"drive\.torque.*without contact\.diameter"),
    ],
)
def test_each_is_refused_in_one_line(tables, message):
    with pytest.raises(SceneError, match=message) as refusal:
        rsc.Scene.from_dict(tables)
    assert "\n" not in str(refusal.value)


def test_an_inertia_less_than_that_of_the_unbalance():
    scene = rsc.Scene.from_dict(changed(GOOD, rotor={"eccentricity": 0.02}, drive={"inertia": 1e-4}))
    least = assemble(rsc.Scene.from_dict(changed(GOOD, rotor={"eccentricity": 0.02}))).unbalance_inertia
    assert least == pytest.approx(scene.rotor.mass * 0.02**2)
    with pytest.raises(SceneError, match=rf"drive\.inertia = 0\.0001: must be > {least:.6g} kg m\^2"):
        rsc.simulate(scene)


def test_a_drive_comes_back_from_its_text():
    for keys in ({}, {"trip": 0.4}, {"trip": 0.4, "coast": [[0.0, -1.0], [50.0, -2.0]], "speed": 0.0}):
        scene = rsc.Scene.from_dict(with_drive(**keys))
        assert rsc.Scene.from_dict(scene.to_dict()) == scene and scene.drive.inertia == 0.15
    assert scene.with_values({"drive.inertia": 0.3}).drive.inertia == 0.3
    with pytest.raises(SceneError, match=r"drive\.speed"):
        scene.with_values({"drive.speed": 10.0}).mirrored()


def test_speeds_that_a_torque_gives():
    """Where the torque ends, where it is still positive what it gives in the time, and never less than the first."""
    per_torque = 1.0 / 0.15 / (2.0 * math.pi)
    for keys, expected in (
        ({"speed": 45.0, "duration": 9.0}, 50.0),
        ({"speed": 60.0}, 60.0),
        ({"torque": [[0.0, 0.3], [50.0, 0.3]]}, 20.0 + 0.3 * per_torque),
        ({"torque": [[0.0, 2.0], [40.0, 1.0], [60.0, -1.0]], "duration": 99.0}, 50.0),
    ):
        assert rsc.Scene.from_dict(with_drive(**keys)).drive.fastest == pytest.approx(expected)
