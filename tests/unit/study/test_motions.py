"""Every motion that lasts: the pump of the tutorial, whose lists were found by another program as well."""

import json
import os
import signal
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.measure.kinds import Kind
from rsc.show.words.motions import claim, motions_text
from rsc.study.motions.search import Search
from rsc.study.motions.settle import Settling
from tiers import first

PUMP = {
    "rotor": {"model": "laval", "mass": 12.0, "frequency": 2600 / 60, "damping_ratio": 0.02, "eccentricity": 2e-5},
    "stator": {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1},
    "contact": {"gap": 2.5e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05, "diameter": 0.08},
    "drive": {"speed": 50.0, "duration": 1.0},
}


def pump(**values):
    return rsc.Scene.from_dict(PUMP).with_values(values)


def kinds(listed):
    return [motion.motion for motion in listed.motions]


def test_the_stable_whirl_the_rolling_one_and_no_contact_are_found():
    listed = rsc.motions(pump(), starts=16)
    assert kinds(listed) == [Kind.ROLLING, Kind.SLIDING, Kind.NO_CONTACT]
    rolling, sliding, free = listed.motions
    (whirl,) = [whirl for whirl in rsc.predict(pump()) if whirl.stable]
    assert sliding.predicted.frequency == whirl.frequency == pytest.approx(sliding.frequency, rel=1e-3)
    assert sliding.amplitude_max == pytest.approx(whirl.rotor_amplitude, rel=0.1) and not sliding.modulated
    assert rolling.frequency == pytest.approx(-708.42, abs=0.1) and rolling.share == 0.0  # no impact starts it
    assert sliding.share + free.share == pytest.approx(1.0) and not (listed.ended < 0).any()
    # the drive pays mu F_N d/2 at the contact
    assert sliding.torque == pytest.approx(0.2 * sliding.force_mean * 0.04, rel=0.01)
    assert sliding.power == pytest.approx(2.0 * np.pi * 50.0 * sliding.torque, rel=1e-9)


def test_where_no_whirl_is_stable_a_bouncing_one_lasts():
    """At friction 0.3 no sliding whirl is stable; 36 of 64 impacts up to 8 N s end in a bouncing one of 3.2 gaps at -74 Hz."""
    scene = pump(**{"contact.friction": 0.3})
    assert not any(whirl.stable for whirl in rsc.predict(scene))
    listed = rsc.motions(scene, starts=24, largest=8.0, smallest=True)
    bouncing = next(motion for motion in listed.motions if motion.motion == Kind.BOUNCING)
    assert bouncing.frequency == pytest.approx(-73.5, abs=0.5)
    assert bouncing.amplitude_max / 2.5e-4 == pytest.approx(3.2, abs=0.1)
    assert bouncing.force_max == pytest.approx(3.9e3, rel=0.05) and 0.25 < bouncing.share < 0.85
    assert bouncing.predicted is not None and not bouncing.predicted.stable
    turn = bouncing.smallest_impulse
    assert 0.0 < turn < 3.0
    impacts = np.hypot(*listed.impulse.T)
    assert (impacts[listed.ended == kinds(listed).index(Kind.NO_CONTACT)].min(initial=9.0)) < 8.0


@pytest.mark.parametrize("seed", first([2, 4, 8, 10], 2))
def test_chaos_that_every_run_leaves_in_the_end_does_not_last(seed):
    """A heavy rotor that touches below: half of all runs are at rest in the forward rub after 30 s, others only later."""
    scene = rsc.Scene.from_dict({
        "rotor": {"model": "laval", "mass": 2.972, "frequency": 12.936, "damping_ratio": 3.38e-3, "eccentricity": 7.03e-5,
                  "gravity": 7.666},
        "stator": {"model": "chain", "masses": [3.306, 2.72], "stiffnesses": [4.331e6, 1.5832e6, 0.0], "damping_ratio": 0.02},
        "contact": {"gap": 5.587e-4, "friction": 0.0727, "stiffness": 2.55e6, "damping_ratio": 0.02, "diameter": 6.575e-3,
                    "slip_velocity": 0.0824},
        "drive": {"speed": 32.35, "duration": 1.0},
    })  # fmt: skip
    assert kinds(rsc.motions(scene, starts=8, seed=seed)) == [Kind.ROLLING, Kind.FORWARD_RUB]


def test_the_seed_alone_decides_and_not_the_threads():
    one, two, other = (rsc.motions(pump(), starts=6, seed=seed, threads=n) for seed, n in ((3, 1), (3, 2), (4, 2)))
    assert one.impulse.tobytes() == two.impulse.tobytes() != other.impulse.tobytes()
    assert repr([*map(asdict, one.motions)]) == repr([*map(asdict, two.motions)]) and one.ended.tolist() == two.ended.tolist()


def test_a_machine_that_turns_backwards_has_the_mirrored_list():
    forward, backward = rsc.motions(pump(), starts=6), rsc.motions(pump().mirrored(), starts=6)
    assert kinds(forward) == kinds(backward) and backward.speed == -50.0
    assert [m.frequency for m in backward.motions[:2]] == [-m.frequency for m in forward.motions[:2]]


@pytest.mark.parametrize(("largest", "least"), [("8 N s", True), (0.1, False)])
def test_impacts_go_from_what_just_touches_to_the_largest_or_from_nothing_where_that_is_less(largest, least):
    listed = rsc.motions(pump(**{"contact.friction": 0.0}), starts=12, largest=largest)
    touching = 12.0 * 2.0 * np.pi * 2600.0 / 60.0 * 2.5e-4  # of an undamped rotor
    sizes = np.hypot(*listed.impulse.T)
    assert listed.largest == (8.0 if least else 0.1) and (sizes.min() > touching) == least
    assert listed.touched.all() == least and listed.touched.any() == least and sizes.max() > 0.8 * listed.largest


def test_without_friction_nothing_but_a_forward_rub_and_free_motion_last():
    listed = rsc.motions(pump(**{"contact.friction": 0.0}), starts=8)
    assert kinds(listed) == [Kind.FORWARD_RUB, Kind.NO_CONTACT]
    assert sum(motion.share for motion in listed.motions) == 1.0 and listed.excluded == pytest.approx(1.0 - 0.05 ** (1.0 / 8.0))


def test_a_rotor_that_runs_away_is_told_so():
    """A rigid wall and friction without a diameter, which never stops."""
    wall = {"stator": {"model": "rigid"}, "contact": {"gap": 2.5e-4, "friction": 0.3, "stiffness": 5e7}}
    scene = rsc.Scene.from_dict(PUMP | wall)
    listed = rsc.motions(scene, starts=8)
    assert kinds(listed)[0] == Kind.RUNNING_AWAY


def test_a_rotor_that_lies_on_its_stator_rests():
    scene = pump(**{"rotor.gravity": 9.81, "rotor.frequency": 8.0, "contact.friction": 0.05, "drive.speed": 5.0})
    assert Kind.RESTING in kinds(rsc.motions(scene, starts=4))


def test_ctrl_c_keeps_what_was_listed(monkeypatch):
    original, count = Settling._end, iter(range(100))

    def end(self, *arguments):
        if next(count) == 5:
            os.kill(os.getpid(), signal.SIGINT)
        return original(self, *arguments)

    monkeypatch.setattr(Settling, "_end", end)
    with pytest.raises(KeyboardInterrupt) as stop:
        rsc.motions(pump(), starts=40, threads=1)
    listed = stop.value.result
    assert listed.interrupted and 0 < listed.starts < 40 and listed.motions and "which excludes nothing" in claim(listed)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"starts": -1}, "starts = -1: must be a whole number from 0"),
        ({"largest": -1.0}, "largest = -1.0: must be an impulse"),
        ({"largest": "8 mm"}, "largest"),
        ({"threads": 0}, "threads = 0: must be a whole number from 1"),
        ({"speed": 1e9}, "drive.speed"),
    ],
)
def test_what_cannot_be_is_refused(more, message):
    with pytest.raises(rsc.RscError, match=message):
        rsc.motions(pump(), **more)


def test_the_command(tmp_path, capsys):
    path = tmp_path / "pump.toml"
    path.write_text(pump().to_toml())
    picture = tmp_path / "starts.png"
    assert main(["motions", str(path), "--speed", "3000 rpm", "--starts", "6", "-o", str(picture)]) == 0
    told = capsys.readouterr().out
    assert "motions that last at 50.00 Hz (3000 rpm)" in told and "backward whirl, sliding; predicted: whirl B -67.93 Hz" in told
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main(["motions", str(path), "--starts", "6", "--json"]) == 0
    assert [motion["motion"] for motion in json.loads(capsys.readouterr().out)["motions"]][-1] == "no contact"


def test_a_run_that_is_stopped_on_its_way_counts_for_the_motion_that_it_is_in(monkeypatch):
    scene = pump(**{"contact.friction": 0.4})
    whole = Search(scene, 50.0).motions(12, 5)
    original = Search.after

    def stopped_early(*arguments):
        with monkeypatch.context() as patched:
            patched.setattr("rsc.study.motions.settle.MOST_STEPS", 800_000)
            return original(*arguments)

    monkeypatch.setattr(Search, "after", stopped_early)
    stopped = Search(scene, 50.0).motions(12, 5)
    assert not (whole.ended < 0).any() and kinds(stopped) == kinds(whole)
    own = [kinds(stopped)[i] if i >= 0 else None for i in stopped.ended]
    known = [kinds(whole)[i] for i in whole.ended]
    assert all(one in (None, other) for one, other in zip(own, known, strict=True))
    assert own.count(Kind.ROLLING) == known.count(Kind.ROLLING) > 0


def disk(**values):
    """A rotor whose whirl at -50 Hz becomes stable at 31.8 Hz, as slowly as 0.02 1/s a Hz."""
    scene = rsc.load_scene(Path(__file__).parents[3] / "data" / "reference" / "gyroscopic_disk_light.toml")
    return scene.with_values({"start.rest": True, "contact.gap": 1.0, **values})


@pytest.mark.parametrize("speed", first(np.random.default_rng(5).uniform(28.0, 31.2, 4).tolist(), 2))
def test_a_whirl_that_grows_slowly_is_left_however_long_that_takes(speed):
    listed = rsc.motions(disk(), speed, starts=0)
    slow = next(one for one in listed.not_reached if -51.0 < one.frequency < -50.0)
    assert 0.0 < slow.rate < 0.2 and not listed.leaving
    assert not any(-51.0 < motion.frequency < -50.0 for motion in listed.motions)
    stable = rsc.motions(disk(), speed + 4.0, starts=0)  # the same whirl beyond its crossing lasts
    assert any(-51.0 < motion.frequency < -50.0 for motion in stable.motions)


def test_a_whirl_that_grows_too_slowly_to_wait_for_is_not_said_to_last(monkeypatch):
    monkeypatch.setattr("rsc.study.motions.search.MOST_BLOCKS", 30)
    listed = rsc.motions(disk(), 31.0, starts=0)
    (slow,) = listed.leaving
    assert slow.label == "B" and 0.0 < slow.rate < 0.1 and slow not in listed.not_reached
    assert not any(-51.0 < motion.frequency < -50.0 for motion in listed.motions)
    assert "does not last, but is left slowly: whirl B -50.40 Hz" in motions_text(listed)
    assert listed.mirrored().leaving[0].frequency == -slow.frequency
