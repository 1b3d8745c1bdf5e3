"""The verdict of whole runs and lists: machines whose run is quiet while an impact wrecks them, and their random siblings."""

import json

import numpy as np
import pytest

import rsc
from rsc.analysis.survey.remarks import scene_remarks
from rsc.measure.kinds import Kind
from rsc.measure.severity import Severity, verdict_of
from rsc.show.words.answer import answer
from rsc.show.words.motions import motions_text
from rsc.show.words.verdict import sentences, verdict_text
from rsc.study.motions.smallest_impulse import smallest_impulse
from rsc.study.report.check import report as compared
from rsc.study.report.check import run_for_report
from rsc.study.report.stored import report_of, write_stored
from rsc.system.assemble import assemble
from tiers import first

# a generator rotor in an oil seal ring on a soft end shield
GENSET = {
    "rotor": {"model": "laval", "mass": 8000.0, "frequency": 1150 / 60, "damping_ratio": 0.03, "eccentricity": 8e-6,
              "gravity": 9.81},
    "stator": {"model": "laval", "mass": 1500.0, "frequency": 11.0, "damping_ratio": 0.02},
    "contact": {"gap": 1.2e-3, "friction": 0.18, "stiffness": 2e8, "damping_ratio": 0.05, "diameter": 0.45},
    "drive": {"speed": 49.5, "duration": 2.0},
    "start": {"running": True},
}  # fmt: skip
# a light rotor in a stiff ring, whose dry whip turns thirty times as fast as the shaft
WHIP = {
    "rotor": {"model": "laval", "mass": 19.49, "frequency": 70.43, "damping_ratio": 0.01363, "eccentricity": 1.8e-6},
    "stator": {"model": "laval", "mass": 1.911, "frequency": 436.7, "damping_ratio": 0.05237},
    "contact": {"gap": 2.027e-4, "friction": 0.3543, "stiffness": 9.763e8, "damping_ratio": 0.15, "diameter": 0.1806},
    "drive": {"speed": 115.2, "duration": 0.5},
    "start": {"rest": True},
    "output": {"rate": 2000.0},
}
# a gyroscopic disk in a very light stator without a contact diameter
DISK = {
    "rotor": {"model": "disk", "mass": 1.0, "diametral_inertia": 1.0, "polar_inertia": 1.877, "eccentricity": 5e-5,
              "stiffness": [[47650.0, 9000.0], [9000.0, 214400.0]], "damping": [[0.878, 0.0], [0.0, 2.649]]},
    "stator": {"model": "laval", "mass": 0.199, "stiffness": 62790.0, "damping": 37.12},
    "contact": {"gap": 1e-3, "friction": 0.286, "stiffness": 4.66e7, "damping": 2050.0},
    "drive": {"speed": 149.5, "duration": 1.0},
}  # fmt: skip

PUMP = {
    "rotor": {"model": "laval", "mass": 12.0, "frequency": 43.3, "damping_ratio": 0.02, "eccentricity": 2e-5},
    "contact": {"gap": 2.5e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05, "diameter": 0.08},
    "drive": {"speed": 50.0, "duration": 1.0},
}


def sibling(scene, seed):
    """The scene with its masses, friction and gap up to a tenth larger or smaller; 0: as it is."""
    dice = np.random.default_rng(seed)
    scene = rsc.Scene.from_dict(scene)
    keys = ("rotor.mass", "stator.mass", "contact.friction", "contact.gap") if seed else ()
    old = {key: getattr(getattr(scene, key.split(".")[0]), key.split(".")[1]) for key in keys}
    return scene.with_values({key: float(value * dice.uniform(0.9, 1.1)) for key, value in old.items()})


@pytest.mark.parametrize("seed", first(range(6), 3))
def test_a_quiet_run_does_not_hide_what_an_impact_starts(seed):
    scene = sibling(GENSET, seed)
    report = rsc.check(scene)
    verdict = report.verdict
    assert verdict.run.severity == Severity.SAFE and not verdict.run.touched
    assert verdict.severity == Severity.DESTRUCTIVE and verdict.impact.motion == Kind.ROLLING
    assert verdict.impact.hits > 4 and "penetration" in verdict.impact.border.passed
    topic, text = answer(report)[0]
    assert topic == "verdict" and "No contact in this run" in text and "impact starts backward whirl, rolling" in text
    assert "Severity: destructive" in text and " MN" not in text and "an upper bound" in text
    smallest, exact = verdict.impact.smallest, smallest_impulse(scene, 12)
    least = exact.impulse[exact.weakest]
    assert 0.97 * least < smallest.impulse < 1.15 * least and smallest.below < smallest.impulse
    assert smallest.velocity == pytest.approx(smallest.impulse / scene.rotor.mass)
    assert 0.0 < smallest.first_penetration < 1.0
    (listed,) = (one for one in report.motions if one.smallest is smallest)
    started = np.hypot(*listed.impulse.T)[listed.ended == smallest.motion]
    wanted = [min(smallest.impulse, *started) if i == smallest.motion else np.nan for i in range(len(listed.motions))]
    assert [motion.smallest_impulse for motion in listed.motions] == pytest.approx(wanted, nan_ok=True)


def test_the_verdict_stands_in_report_json_and_is_read_again(tmp_path):
    result = run_for_report(sibling(GENSET, 0), False, tmp_path / "result.h5", lambda text: None)
    made = compared(result)
    write_stored(made, tmp_path / "report.json")
    stored = json.loads((tmp_path / "report.json").read_text())["verdict"]
    assert stored["severity"] == "destructive" and stored["sentences"] == sentences(made.verdict)
    assert set(stored["facts"]) == {"severity", "run", "impact", "coverage", "not_reached"}
    assert stored["facts"]["impact"]["smallest"]["impulse"] == made.verdict.impact.smallest.impulse
    again = report_of(result, tmp_path / "result.h5")
    assert type(again.branches[0]).__name__ == "StoredBranch" and verdict_text(again.verdict) == verdict_text(made.verdict)


@pytest.mark.parametrize("seed", first(range(6)))
def test_a_dry_whip_that_impacts_start_is_reached_by_check_as_by_motions(seed):
    scene = sibling(WHIP, seed)
    report = rsc.check(scene)
    told = dict(answer(report))
    assert "not reached" not in told and report.verdict.impact.motion == Kind.ROLLING
    assert report.verdict.impact.hits > 2 and report.motions[0].unsettled == 0
    other = rsc.motions(scene, starts=16)
    assert [motion.motion for motion in other.motions] == [motion.motion for motion in report.motions[0].motions]
    assert other.ended.tolist() == report.motions[0].ended.tolist()


@pytest.mark.parametrize("seed", first(range(6), 3))
def test_what_runs_away_has_no_figures_and_asks_for_the_diameter(seed):
    listed = rsc.motions(sibling(DISK, seed), starts=6)
    away = listed.motions[0]
    assert away.motion == Kind.RUNNING_AWAY and [one.diameter for one in listed.assumed] == pytest.approx(
        [2.0 * listed.gap / clearance for clearance in (0.0025, 0.05)]
    )
    text = motions_text(listed)
    assert f"{away.frequency:.0f}" not in text and "e+10" not in text and "running away" in text
    facts = verdict_of(None, None, (), [listed])
    if facts.impact.motion == Kind.RUNNING_AWAY:
        assert "contact.diameter" in text and "rolls at" in text and "condition (12)" in text
    assert listed.mu_min < 0.2 * listed.mu_whirl  # what escapes counts


def test_an_assumed_diameter_is_that_of_the_scene_that_has_it():
    scene = rsc.Scene.from_dict(DISK)
    wide = rsc.motions(scene, starts=2).assumed[1]
    own = rsc.motions(scene.with_values({"contact.diameter": wide.diameter}), starts=2)
    rolling = next(motion for motion in own.motions if motion.motion == Kind.ROLLING)
    assert rolling.frequency == pytest.approx(wide.roll.frequency, rel=1e-3)
    assert rolling.force_mean == pytest.approx(wide.roll.normal_force, rel=0.02)


@pytest.mark.parametrize("friction", [0.05, 0.2])
def test_of_a_body_that_touches_itself_nothing_is_said_of_rigid_stators(friction):
    scene = rsc.Scene.from_dict({
        "rotor": {"model": "matrices", "mass": [[12.0, 0.0], [0.0, 3.0]], "stiffness": [[888205.0, 0.0], [0.0, 3031920.0]],
                  "damping": [[130.6, 0.0], [0.0, 603.2]], "eccentricity": [2e-5, 0.0], "tilt_coordinates": []},
        "contact": {"rotor_coordinate": [0, 1], "gap": 2.5e-4, "friction": friction, "stiffness": 5e7, "damping_ratio": 0.05},
        "drive": {"speed": 50.0, "duration": 1.0},
    })  # fmt: skip
    whirls = rsc.predict(scene)
    assert not any("no stator moves" in text for text in scene_remarks(assemble(scene), whirls))
    wall = rsc.Scene.from_dict(PUMP | {"stator": {"model": "rigid"}})
    assert any("no stator moves" in text for text in scene_remarks(assemble(wall), rsc.predict(wall)))
