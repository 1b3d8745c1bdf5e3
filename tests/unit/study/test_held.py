"""What the drive can hold: predicted beside runs in which it gives way; lists and knocks at a prescribed speed."""

import json

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.measure.kinds import Kind
from rsc.show.page import write_page
from rsc.show.words.answer import answer_text
from rsc.show.words.held import held_text
from rsc.study.prediction.predictions import predictions
from rsc.system.assemble import assemble
from rsc.system.held import BRAKES, HOLDS, SLOWS, STOPS, held
from two_seals import pump as two_seals

PUMP = {
    "rotor": {"model": "laval", "mass": 12.0, "frequency": 2600 / 60, "damping_ratio": 0.02, "eccentricity": 1e-7},
    "stator": {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1},
    "contact": {"gap": 2.5e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05, "diameter": 0.08},
}
DRAG = [[0.0, -2.0], [100.0, -2.0]]


def pump(torque=DRAG, **drive):
    own = {"inertia": 0.05, "torque": torque, "speed": 50.0, "duration": 3.0, **drive}
    return rsc.Scene.from_dict({**PUMP, "drive": own, "output": {"rate": 2000.0}})


def on_its_whirl(scene):
    """(what is predicted of the stable whirl, the run that begins on it)."""
    (at,) = predictions(scene, [50.0])
    ((whirl, own),) = [(whirl, own) for whirl, own in zip(at.whirls, at.held, strict=True) if whirl.stable]
    return own, rsc.simulate(scene.with_values({"start.whirl": whirl.frequency}))


def test_a_rotor_that_rubs_stops_when_it_is_predicted_to():
    (own,), run = on_its_whirl(pump())
    assert own.outcome == STOPS and own.speed == 0.0 and own.drive == -2.0
    # it slides down to 0.5 Hz, and rolls, which takes less, while it turns slower than that
    slides = run.speed > 1.0
    assert abs(run.speed[slides] - 50.0 * (1.0 - run.time[slides] / own.time)).max() < 0.05
    assert run.status == "stopped" and own.time < run.summary.end_time < 1.06 * own.time


def test_a_motor_brakes_to_the_speed_that_is_predicted():
    torque = [[0.0, 30.0], [45.0, 20.0], [50.0, 0.0]]
    (own,), run = on_its_whirl(pump(torque, duration=4.0))
    assert own.outcome == BRAKES and 45.0 < own.speed < 49.5 and np.isnan(own.time)
    assert run.speed[-1] == pytest.approx(own.speed, rel=2e-3)


def test_a_strong_motor_holds_the_whirl():
    (own,), run = on_its_whirl(pump([[0.0, 90.0], [52.0, 90.0], [53.0, 0.0]], duration=4.0))
    assert own.outcome == HOLDS and 52.0 < own.speed < 53.0
    assert run.speed[-1] == pytest.approx(own.speed, rel=2e-3)


def test_speeds_and_times_of_torques_with_knots():
    torque = [[10.0, -1.0], [20.0, -4.0], [40.0, 3.0], [60.0, -2.0]]
    drive = assemble(pump(torque, trip=1.0, coast=[[0.0, 0.0], [50.0, -1.0]])).drive
    motor, coast = held(drive, 50.0, 0.4)
    assert motor.outcome == HOLDS and not motor.coasting
    assert motor.drive == pytest.approx(0.5) and motor.speed == pytest.approx(50.4)
    # torque left 0.4 + Omega/Omega_0 from Omega_0 = 50 Hz down
    assert coast.outcome == STOPS and coast.coasting
    assert coast.time == pytest.approx(0.05 * 2.0 * np.pi * 50.0 * np.log(1.4 / 0.4), rel=1e-12)
    motor, coast = held(drive, 50.0, 2.0)
    assert motor.outcome == BRAKES and motor.speed == pytest.approx(44.0)
    # through knots: 7 - 4.5 at 50 Hz ... by a sum of a million pieces
    motor, _ = held(drive, 50.0, 3.5)
    Omega = 2.0 * np.pi * (np.arange(1_000_000) + 0.5) * 50e-6
    assert motor.time == pytest.approx(0.05 * np.sum(1.0 / (3.5 - drive.torque(Omega))) * 2.0 * np.pi * 50e-6, rel=1e-9)
    assert held(drive, 50.0, 0.0)[1].outcome == BRAKES  # a torque that ends at rest never stops it
    assert held(drive, 50.0, 9.0, constant=False)[0].outcome == SLOWS
    assert held(drive, 50.0, np.nan) == held(None, 50.0, 1.0) == ()
    told = held_text(held(drive, 50.0, 2.0))
    assert told.startswith("takes 2 N m (628 W), the drive gives 500 mN m: brakes to 44.00 Hz; after")


def test_motions_are_those_of_the_prescribed_speed_and_say_what_the_drive_holds():
    scene = pump(trip=0.5)
    listed, steady = rsc.motions(scene, starts=4), rsc.motions(scene.steady(50.0), starts=4)
    plain = [motion.motion for motion in steady.motions]
    assert [motion.motion for motion in listed.motions] == plain and {Kind.SLIDING, Kind.ROLLING, Kind.NO_CONTACT} <= set(plain)
    for ours, theirs in zip(listed.motions, steady.motions, strict=True):
        assert ours.frequency == theirs.frequency or np.isnan(ours.frequency)
        assert ours.power == pytest.approx(2.0 * np.pi * 50.0 * ours.torque, rel=1e-3)
        driven, coasting = ours.held
        assert theirs.held == () and driven.torque == ours.torque and coasting.drive == 0.0 and coasting.coasting
        assert driven.outcome == (SLOWS if ours.motion == Kind.ROLLING else STOPS)
    assert listed.table().columns[-1] == "drive"


def test_a_knock_is_that_of_the_prescribed_speed():
    scene = pump(trip=0.5)
    ours, theirs = (rsc.smallest_knock(one, directions=1) for one in (scene, scene.steady(50.0)))
    assert ours.impulse == theirs.impulse and ours.impulse > 0.0


def test_commands_say_what_the_drive_holds(tmp_path, capsys):
    path = tmp_path / "pump.toml"
    path.write_text(pump(trip=0.5).to_toml())
    told = "N m: stops after about"
    for command in (["predict"], ["predict", "--speed", "50"], ["motions", "--speed", "45", "--starts", "0"]):
        assert main([command[0], str(path), *command[1:]]) == 0
        assert told in capsys.readouterr().out
        assert main([command[0], str(path), *command[1:], "--json"]) == 0
        assert '"held"' in json.dumps(json.loads(capsys.readouterr().out))
    assert main(["knock", str(path), "--speed", "45", "--directions", "1"]) == 0


def test_sweeps_run_a_drive_with_a_torque_and_refuse_a_jump_along_it():
    swept = rsc.sweep(pump([[0.0, -30.0], [100.0, -30.0]], duration=1.0), {"drive.inertia": "0.05:0.15:2"}, "run")
    assert swept["status"].values.tolist() == ["stopped", "finished"]
    assert swept["end_time"].values[0] == pytest.approx(2.0 * np.pi * 50.0 * 0.05 / 30.0, rel=1e-3)
    with pytest.raises(rsc.errors.SceneError, match=r"drive\.torque.*prescribed"):
        rsc.delay(pump(), -67.9)


def test_answer_and_page_say_what_the_drive_holds(tmp_path):
    scene = pump([[0.0, -2.0], [100.0, -2.0]], duration=0.5, trip=0.25, coast=[[0.0, -1.0]])
    report = rsc.check(scene)
    assert report.motions and all(motion.held for listed in report.motions for motion in listed.motions)
    (free,) = [motion for motion in report.motions[0].motions if motion.motion == Kind.NO_CONTACT]
    assert [one.drive for one in free.held] == [-2.0, -1.0]
    write_page(report, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "the drive does not hold it" in " ".join(answer_text(report).split())
    assert "the drive gives -2 N m: stops after" in page


def test_a_whirl_at_two_seals_takes_the_torque_of_both():
    """What is predicted of the whirl is what the run takes from the drive at first: P = torque Omega."""
    content = two_seals().to_dict() | {
        "drive": {"speed": 50.0, "duration": 0.2, "inertia": 50.0, "torque": [[0.0, 0.0], [100.0, 0.0]]},
    }
    scene = rsc.Scene.from_dict(content)
    at = predictions(scene, [50.0])[0]
    (whirl, held) = next((whirl, own) for whirl, own in zip(at.whirls, at.held, strict=True) if whirl.stable)
    torque = sum(0.5 * one.friction * one.diameter * whirl.contacts[one.name].normal_force for one in scene.contacts)
    assert held[0].torque == pytest.approx(torque, rel=1e-12)
    turning, start = 2j * np.pi * whirl.frequency, {"allow_penetration": True}
    for name in ("rotor", "stator"):
        shape = getattr(whirl, f"{name}_shape")
        start |= {name: [[z.real, z.imag] for z in shape.tolist()]}
        start |= {f"{name}_velocity": [[z.real, z.imag] for z in (turning * shape).tolist()]}
    result = rsc.simulate(rsc.Scene.from_dict(content | {"start": start}))
    slowed = 2.0 * np.pi * (result.speed[0] - result.speed[-1]) * 50.0 / (result.time[-1] - result.time[0])
    assert slowed == pytest.approx(torque, rel=0.02)
