"""What a torque-limited drive makes of motions: simulated, and judged by another integration; lists and impacts at a prescribed
speed."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[3] / "bench"))
import rsc
from drive_outcomes import judged
from rsc.cli import main
from rsc.measure.kinds import Kind
from rsc.show.page import write_page
from rsc.show.words.answer import answer_text
from rsc.show.words.held import held_text
from rsc.study.motions.release import Release
from rsc.study.motions.settle import Settling
from rsc.study.prediction.predictions import predictions
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from rsc.system.held import BRAKES, CAPTURED, HOLDS, SPEEDS_UP, STOPS, UNKNOWN, Held, balance_above, loads
from tiers import first
from two_seals import pump as two_seals

PUMP = {
    "rotor": {"model": "laval", "mass": 12.0, "frequency": 2600 / 60, "damping_ratio": 0.02, "eccentricity": 1e-7},
    "stator": {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1},
    "contact": {"gap": 2.5e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05, "diameter": 0.08},
}
DRAG = [[0.0, -2.0], [100.0, -2.0]]
SEEDS = first(range(6))  # the machine itself, and some like it


def pump(torque=DRAG, **drive):
    own = {"inertia": 0.05, "torque": torque, "speed": 50.0, "duration": 3.0, **drive}
    return rsc.Scene.from_dict({**PUMP, "drive": own, "output": {"rate": 2000.0}})


def motion_of(listed, kind):
    return next(motion for motion in listed.motions if motion.motion == kind)


def sommerfeld(seed):
    """A motor so weak that the unbalance takes all of its torque below the critical speed."""
    vary = np.random.default_rng(seed).uniform(0.9, 1.1, 5) if seed else np.ones(5)
    return rsc.Scene.from_dict({
        "rotor": {"model": "laval", "mass": 6.0, "frequency": 30.0 * vary[0], "damping_ratio": 0.05 * vary[1],
                  "eccentricity": 1.5e-5 * vary[2]},
        "stator": {"model": "laval", "mass": 2.0, "frequency": 120.0, "damping_ratio": 0.05},
        "contact": {"gap": 3e-4, "friction": 0.15, "stiffness": 1e7, "damping_ratio": 0.1, "diameter": 0.05},
        "drive": {"speed": 25.0 * vary[0], "duration": 2.0, "inertia": 2e-5 * vary[3],
                  "torque": [[0.0, 2e-4 * vary[4]], [60.0, 2e-4 * vary[4]], [61.0, -2e-4]]},
    })  # fmt: skip


def rubbing(seed):
    """A seal that a coasting rotor rubs forward until it has become too slow for that."""
    vary = np.random.default_rng(seed).uniform(0.95, 1.05, 5) if seed else np.ones(5)
    return rsc.Scene.from_dict({
        "rotor": {"model": "laval", "mass": 7.3, "frequency": 34.0 * vary[0], "damping_ratio": 0.035 * vary[1],
                  "eccentricity": 4e-5 * vary[2]},
        "stator": {"model": "laval", "mass": 3.8, "frequency": 86.0, "damping_ratio": 0.045},
        "contact": {"gap": 1.2e-4, "friction": 0.1 * vary[3], "stiffness": 9.5e6, "damping_ratio": 0.3, "diameter": 0.025},
        "drive": {"speed": 41.6, "duration": 2.0, "inertia": 1e-3 * vary[4], "torque": [[0.0, -0.003], [41.6, -0.016]]},
    })  # fmt: skip


@pytest.mark.parametrize("seed", SEEDS)
def test_a_weak_motor_is_captured_below_the_critical_speed(seed):
    scene = sommerfeld(seed)
    told = list(judged(scene, scene.drive.speed[0], starts=0))
    assert not [false for *_, false, skipped in told if false and not skipped]
    ((outcome, words, *_),) = [own for own in told if own[1].startswith("no contact")]
    assert outcome == CAPTURED
    speed = float(re.search(r"captured at ([\d.]+) Hz \(Sommerfeld effect\)", words)[1])
    assert scene.drive.speed[0] < speed < scene.rotor.frequency
    if not seed:
        assert speed == pytest.approx(28.498, abs=2e-3)  # of a run of 25 s by another program


@pytest.mark.parametrize("seed", SEEDS)
def test_a_rub_is_left_before_the_rotor_stops(seed):
    scene = rubbing(seed)
    told = list(judged(scene, scene.drive.speed[0], starts=4))
    assert not [false for *_, false, skipped in told if false and not skipped]
    (rub,) = [words for _, words, *_ in told if words.startswith("forward rub")]
    left, time, stops = map(float, re.search(r"leaves it at ([\d.]+) Hz after ([\d.]+) s, stops after ([\d.]+) s", rub).groups())
    assert 20.0 < left < 41.0 and 0.2 < time < 0.5 * stops


def test_a_rotor_that_rubs_stops():
    """On a whirl that slides: nearly as by a constant torque, until it rolls and takes less."""
    listed = rsc.motions(pump(), starts=0)
    (own,) = motion_of(listed, Kind.SLIDING).held
    constant = 0.05 * 2.0 * np.pi * 50.0 / (2.0 + own.torque)
    assert own.outcome == STOPS and own.speed == 0.0 and own.drive == -2.0 and constant < own.time < 1.06 * constant


def test_a_motor_brakes_to_a_speed_that_it_holds():
    listed = rsc.motions(pump([[0.0, 30.0], [45.0, 20.0], [50.0, 0.0]]), starts=0)
    (own,) = motion_of(listed, Kind.SLIDING).held
    assert own.outcome == BRAKES and own.motion == Kind.SLIDING and 45.0 < own.speed < 49.5
    assert np.interp(own.speed, [45.0, 50.0], [20.0, 0.0]) == pytest.approx(own.torque, rel=0.03)


def test_a_strong_motor_speeds_the_whirl_up():
    listed = rsc.motions(pump([[0.0, 90.0], [52.0, 90.0], [53.0, 0.0]]), starts=0)
    (own,) = motion_of(listed, Kind.SLIDING).held
    assert own.outcome == SPEEDS_UP and 52.0 < own.speed < 53.0


def test_what_takes_too_long_is_said_to_be_unknown():
    scene = pump([[0.0, -1e-4], [100.0, -1e-4]])
    settling = Settling(scene.steady(50.0), 50.0)
    ((own,),) = Release(scene, settling, 4000).held(settling.ends([initial_state(scene, settling.system)]), [0.0])
    assert own.outcome == UNKNOWN and own.motion == Kind.NO_CONTACT and np.isnan(own.left_time)
    assert own.speed == pytest.approx(50.0 - 1e-4 / 0.05 / (2.0 * np.pi) * own.time, rel=1e-4)
    assert re.fullmatch(r"the rotor is at [\d.]+ Hz after [\d.]+ s, not settled", held_text((own,)).partition(": ")[2])


@pytest.mark.nightly  # half a minute, most of it for the kernel
def test_a_race_goes_on_turning_when_its_motion_is_released():
    """A rotor that lies in its bearing and has spun the race up: nothing jumps."""
    contact = {"gap": 2.5e-4, "friction": 0.1, "stiffness": 3e7, "damping_ratio": 0.1, "diameter": 0.03, "race_inertia": 2e-5,
               "race_drag": 1e-4}  # fmt: skip
    scene = rsc.Scene.from_dict({
        **PUMP, "rotor": {"model": "laval", "mass": 6.0, "stiffness": 0.0, "gravity": 9.81, "eccentricity": 1e-6},
        "contact": contact, "start": {"centre": True},
        "drive": {"speed": 50.0, "duration": 1.0, "inertia": 0.01, "torque": [[0.0, 0.0], [50.0, 0.0]]},
    })  # fmt: skip
    settling = Settling(scene, 50.0)
    (end,) = settling.ends([initial_state(scene, settling.system)])
    radius, slower = 0.015 + 2.5e-4, 2.0 * np.pi * 50.0 * 0.015
    assert end.state.races[0] == pytest.approx(slower, rel=0.01)
    ((own,),) = Release(scene, settling, 40_000).held([end], [0.0])
    lost = 1e-4 * (end.state.races[0] / radius) * 0.015 / radius * own.time  # N m s, of the race's drag alone
    assert 2.0 * np.pi * (50.0 - own.speed) * (0.01 + 2e-5 * (0.015 / radius) ** 2) == pytest.approx(lost, rel=0.05)


def test_loads_of_the_run_and_behind_its_trip():
    torque = [[10.0, -1.0], [20.0, -4.0], [40.0, 3.0], [60.0, -2.0]]
    drive = assemble(pump(torque, trip=1.0, coast=[[0.0, 0.0], [50.0, -1.0]])).drive
    motor, coast = loads(drive, 50.0, 0.4)
    assert (motor.drive, coast.drive) == pytest.approx((0.5, -1.0)) and coast.coasting and not motor.coasting
    assert balance_above(drive, 0, 50.0, 0.4) == pytest.approx(50.4) and balance_above(drive, 0, 50.0, 2.0) == 50.0
    assert balance_above(drive, 0, 50.0, -3.0) == np.inf and loads(drive, 50.0, np.nan) == loads(None, 50.0, 1.0) == ()


NOTHING = {"left_speed": np.nan, "left_time": np.nan, "passed": "", "rate": 0.0, "frequency": np.nan, "coasting": False}


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"outcome": HOLDS, "speed": 50.01, "time": 0.0, "motion": "forward rub"}, "the drive holds it"),
        ({"outcome": BRAKES, "speed": 44.0, "time": 3.21, "motion": "forward rub"}, "the rotor brakes to 44.00 Hz after 3.2 s"),
        ({"outcome": STOPS, "speed": 0.0, "time": 3.21, "motion": "no contact", "left_speed": 28.8, "left_time": 1.5},
         "the rotor leaves it at 28.80 Hz after 1.5 s, stops after 3.2 s"),
        ({"outcome": BRAKES, "speed": 45.93, "time": 3.0, "motion": "forward rub", "left_speed": 60.0, "left_time": 0.0},
         "the rotor leaves it at once, settles in forward rub at 45.93 Hz after 3 s"),
        ({"outcome": SPEEDS_UP, "speed": 45.93, "time": 3.0, "motion": Kind.SLIDING, "frequency": -60.0, "left_speed": 40.0,
          "left_time": 1.0, "passed": "partial rub"},
         "the rotor leaves it at 40.00 Hz after 1 s, settles in backward whirl, sliding (-60.00 Hz) at 45.93 Hz after 3 s "
         "(on the way partial rub)"),
        ({"outcome": UNKNOWN, "speed": 20.0, "time": 4.0, "motion": "forward rub", "rate": -1.0},
         "the rotor is at 20.00 Hz after 4 s, still slowing down"),
        ({"outcome": CAPTURED, "speed": 28.5, "time": 4.0, "motion": "no contact"},
         "the rotor is captured at 28.50 Hz (Sommerfeld effect) after 4 s"),
    ],
)  # fmt: skip
def test_words_of_outcomes(fields, words):
    told = held_text((Held(begin=50.0, torque=2.0, drive=0.5, **(NOTHING | fields)),))
    assert told == f"friction takes 2 N m (628 W), the drive gives 500 mN m: {words}"


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
        assert driven.outcome == STOPS
    assert listed.table().columns[-1] == "drive"


def test_an_impact_is_that_of_the_prescribed_speed():
    scene = pump(trip=0.5)
    ours, theirs = (rsc.smallest_impulse(one, directions=1) for one in (scene, scene.steady(50.0)))
    assert ours.impulse == theirs.impulse and ours.impulse > 0.0


def test_commands_say_what_the_drive_holds(tmp_path, capsys):
    path = tmp_path / "pump.toml"
    path.write_text(pump(trip=0.5).to_toml())
    predicted = "the drive gives -2 N m, too little for this speed; after the trip the drive gives 0 N m, too little", "loads"
    simulated = "the drive gives -2 N m: the rotor leaves it at", "held"
    listing = ["motions", "--speed", "45", "--starts", "0"]
    for command, (told, key) in ((["predict"], predicted), (["predict", "--speed", "50"], predicted), (listing, simulated)):
        assert main([command[0], str(path), *command[1:]]) == 0
        assert told in capsys.readouterr().out
        assert main([command[0], str(path), *command[1:], "--json"]) == 0
        assert f'"{key}"' in json.dumps(json.loads(capsys.readouterr().out))
    assert main(["impact", str(path), "--speed", "45", "--directions", "1"]) == 0


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
    assert "after the trip" in " ".join(answer_text(report).split())
    assert "the drive gives -2 N m: the rotor leaves it at" in page


@pytest.mark.nightly  # half a minute, most of it for the kernel
def test_a_whirl_at_two_seals_takes_the_torque_of_both():
    """What is predicted of the whirl is what the run takes from the drive at first: P = torque Omega."""
    content = two_seals().to_dict() | {
        "drive": {"speed": 50.0, "duration": 0.2, "inertia": 50.0, "torque": [[0.0, 0.0], [100.0, 0.0]]},
    }
    scene = rsc.Scene.from_dict(content)
    at = predictions(scene, [50.0])[0]
    whirl, taken = next((whirl, own) for whirl, own in zip(at.whirls, at.loads, strict=True) if whirl.stable)
    torque = sum(0.5 * one.friction * one.diameter * whirl.contacts[one.name].normal_force for one in scene.contacts)
    assert taken[0].torque == pytest.approx(torque, rel=1e-12)
    turning, start = 2j * np.pi * whirl.frequency, {"allow_penetration": True}
    for name in ("rotor", "stator"):
        shape = getattr(whirl, f"{name}_shape")
        start |= {name: [[z.real, z.imag] for z in shape.tolist()]}
        start |= {f"{name}_velocity": [[z.real, z.imag] for z in (turning * shape).tolist()]}
    result = rsc.simulate(rsc.Scene.from_dict(content | {"start": start}))
    slowed = 2.0 * np.pi * (result.speed[0] - result.speed[-1]) * 50.0 / (result.time[-1] - result.time[0])
    assert slowed == pytest.approx(torque, rel=0.02)
