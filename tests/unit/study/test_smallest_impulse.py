"""Starts on the steady motion without contact, impacts, and the smallest impulse that starts a whirl."""

import json

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.measure.catalogue import WHIRLING
from rsc.measure.final import final_motion
from rsc.show.words.impulses import impulses_text
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from scenes import LAVAL, changed

STEADY = changed(LAVAL, drive={"speed": 50.0, "duration": 2.0}, start={"running": True})


def scene_of(**tables):
    return rsc.Scene.from_dict(changed(STEADY, **tables))


@pytest.mark.parametrize(
    "tables",
    [
        {},
        {"rotor": {"load": [[3.0, -30.0]]}},
        {"contact": {"ring_eccentricity": [2e-4, 70.0]}},
        {"rotor": {"supports": [[0, [4e3, 1e3, 1e3, -2e3], [2.0, 0.0, 0.0, 1.0]]]}},
    ],
)
def test_a_run_from_its_steady_motion_stays_there(tables):
    """No transient: one turn later everything is where it was."""
    result = rsc.simulate(scene_of(**tables))
    turns = result.rotor[:: round(result.scene.output.rate / 50.0)]
    assert abs(turns - turns[0]).max() < 1e-5 * abs(result.rotor).max()
    assert not result.normal_force.any()


def test_a_running_rotor_that_would_touch_is_refused():
    with pytest.raises(rsc.SceneError, match=r"start\.running = True: must be a motion without contact .* \(it may reach 0"):
        rsc.simulate(scene_of(drive={"speed": 30.0}))


def test_an_impact_adds_its_impulse_to_whatever_the_rotor_does():
    chain = {"model": "chain", "masses": [1.0, 2.0], "stiffnesses": [3e4, 2e4, 4e4], "eccentricity": [0.0, 0.0]}
    for start in ({"rest": True}, {"running": True}, {"rotor": [[1e-4, 0.0], [0.0, 0.0]]}):
        states = []
        for impact in ({}, {"impulse": [0.3, -0.4]}):
            scene = rsc.Scene.from_dict(changed(STEADY, rotor=chain, contact={"rotor_coordinate": 1}, start=start | impact))
            assert rsc.Scene.from_toml(scene.to_toml()).start == scene.start
            states.append(initial_state(scene, assemble(scene)))
        assert (states[1].rotor == states[0].rotor).all()
        assert abs(states[1].rotor_velocity - states[0].rotor_velocity - [0.0, 0.15 - 0.2j]).max() < 1e-15


def test_the_smallest_impulse_starts_a_whirl_and_a_little_less_does_not():
    scene = scene_of()
    impacts = rsc.smallest_impulse(scene, directions=4)
    assert impacts.undisturbed == "no contact" and impacts.runs < 1 + 4 * 25 + 4 * 6 and not impacts.unsettled
    for direction, impulse, below in zip(impacts.direction, impacts.impulse, impacts.below, strict=True):
        assert 0.0 < 0.99 * impulse < below < impulse
        turn = np.exp(1j * np.deg2rad(direction))
        for size, whirls in ((impulse, True), (below, False)):
            again = scene.with_values({"start.impulse": [size * turn.real, size * turn.imag]})
            assert (final_motion(rsc.simulate(again)).motion in WHIRLING) == whirls
    assert impacts.impulse[impacts.weakest] == impacts.impulse.min()
    for velocity in (impacts.velocity, impacts.rotor_velocity):  # of a mass of 1 kg
        assert velocity == pytest.approx(impacts.impulse)


def test_a_turned_heavy_spot_turns_all_impacts_with_it(tmp_path):
    """A round machine does not know directions: only the angle between impact and heavy spot counts; also in the mirror image."""
    here, turned = (rsc.smallest_impulse(scene_of(rotor={"eccentricity": [1e-4, angle]}), directions=4) for angle in (0.0, 90.0))
    assert (here.heavy_spot, turned.heavy_spot) == (0.0, 90.0) and np.ptp(here.impulse) > 0.0
    assert turned.impulse == pytest.approx(np.roll(here.impulse, 1), rel=1e-6)
    assert turned.ahead.tolist() == [270.0, 0.0, 90.0, 180.0]
    (row,) = (row for row in turned.table().rows if row[1] == 0.0)
    assert row[2] == pytest.approx(here.impulse[0], rel=1e-6) and "ahead of the heavy spot" in turned._repr_html_()
    mirror = rsc.smallest_impulse(scene_of(rotor={"eccentricity": [1e-4, 90.0]}).mirrored(), directions=4)
    assert mirror.heavy_spot == 90.0 and np.array_equal(mirror.impulse, turned.impulse)
    assert np.array_equal(mirror.ahead, turned.ahead)
    told = impulses_text(turned)
    assert f"from y, {turned.ahead[turned.weakest]:.0f} degrees ahead of the heavy spot" in told


def test_where_planes_cancel_or_are_unknown_the_mark_is_told_alone():
    balanced = rsc.smallest_impulse(scene_of(rotor={"eccentricity": 0.0}), directions=1)
    told = impulses_text(balanced)
    assert np.isnan(balanced.heavy_spot) and " degrees from y (" in told and "heavy" not in told.splitlines()[2]


def test_all_directions_are_alike_without_unbalance():
    impacts = rsc.smallest_impulse(scene_of(rotor={"eccentricity": 0.0}), directions=3)
    assert np.ptp(impacts.impulse) < 1e-9 * impacts.impulse[0]


def test_a_machine_without_friction_cannot_be_hit_into_a_whirl():
    impacts = rsc.smallest_impulse(scene_of(contact={"friction": 0.0}), directions=3, largest=1.0)
    assert impacts.weakest is None and np.isnan(impacts.impulse).all() and (impacts.below == impacts.largest).all()
    assert not impacts.motion.any()


@pytest.mark.parametrize(
    ("tables", "arguments", "message"),
    [
        ({"drive": {"speed": [50.0, 60.0]}}, (4,), r"drive\.speed = .* must be constant"),
        ({}, (0,), "directions = 0: must be a whole number from 1"),
        ({}, (4, -1.0), "largest = -1.0: must be an impulse"),
        ({}, (4, float("nan")), "largest = nan: must be an impulse"),
    ],
)
def test_what_cannot_be_hit_is_refused(tables, arguments, message):
    with pytest.raises(rsc.RscError, match=message):
        rsc.smallest_impulse(scene_of(**tables), None, *arguments)


def test_the_command(tmp_path, capsys):
    path = tmp_path / "laval.toml"
    path.write_text(rsc.Scene.from_dict(LAVAL).to_toml())  # a run-up from another start
    assert main(["impact", str(path), "--speed", "3000 rpm", "--directions", "2"]) == 0
    told, on_the_way = capsys.readouterr()
    assert not on_the_way  # progress is for terminals
    assert "50 Hz; without an impact: no contact" in told and "smallest impulse that starts a whirl: " in told
    assert main(["impact", str(path), "--speed", "50", "--directions", "2", "--json"]) == 0
    impacts = json.loads(capsys.readouterr().out)
    assert f"{min(impacts['impulse']):.4g} N s (the momentum" in told
    assert main(["impact", str(path), "--speed", "50", "--directions", "2", "--largest", "0.01"]) == 0
    assert "no impact up to 0.01 N s starts a whirl" in capsys.readouterr().out
    assert main(["impact", str(path)]) == 2
    assert "must be constant" in capsys.readouterr().err


def test_the_default_of_the_largest_impulse_of_a_rotor_that_nothing_holds():
    """Ten times what lets it drift to the stator in a quarter of the period of its slowest vibration joined to the stator, or
    in a rigid wall of a turn of the shaft."""
    free = {"model": "laval", "mass": 1.0, "stiffness": 0.0, "damping": 10.0}
    for stator, omega in (
        (LAVAL["stator"], 2 * np.pi * 150.0 * np.sqrt(0.25 / 1.25)),
        ({"model": "rigid"}, 2 * np.pi * 50.0),
    ):
        scene = scene_of(rotor=free, stator=stator, drive={"duration": 0.05})
        drifted = (1.0 - np.exp(-10.0 * 0.5 * np.pi / omega)) / 10.0
        assert rsc.smallest_impulse(scene, directions=1).largest == pytest.approx(10.0 * scene.contact.gap / drifted, rel=1e-9)
