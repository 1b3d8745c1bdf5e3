"""What a prediction says in words: no friction, free motions, walls, unstable whirls, undecided stability, refused speeds."""

import math

import numpy as np
import pytest

import rsc
from rsc.analysis.follow.branches import branches
from rsc.analysis.follow.least_friction import NO_LEAST, mu_min
from rsc.analysis.paper.predict import predict_system
from rsc.analysis.paper.receptance import free_motions
from rsc.analysis.paper.small_motions import Departure, damper_limits, small_motion, undecided
from rsc.analysis.paper.stability import whirl_growth
from rsc.analysis.several.predict import predict
from rsc.analysis.survey.remarks import branch_remarks, damper_warnings, departure_text, scene_remarks, whirl_remarks
from rsc.analysis.survey.survey import survey
from rsc.cli import main
from rsc.errors import SceneError
from rsc.scene.scene import Scene
from rsc.show.words.text import survey_text
from rsc.study.report.check import check
from rsc.system.assemble import assemble
from systems import REFERENCE, TWO_PI, changed, random_system, reference, reference_scene

NO_FRICTION = "no friction: no backward whirl"
WALL = "no stator moves: under constant friction no backward whirl of this scene is stable"


def free_rotor(speed=(20.0, 60.0)):
    """Two masses tied to each other only, in a one-mass stator."""
    rotor = {"model": "chain", "masses": [1.0, 1.0], "stiffnesses": [0.0, 4e4, 0.0], "dampings": [0.0, 5.0, 0.0]}
    return Scene.from_dict(
        {
            "rotor": {**rotor, "eccentricity": [5e-5, 0.0]},
            "stator": {"model": "laval", "mass": 0.5, "frequency": 100.0, "damping_ratio": 0.1},
            "contact": {"gap": 1e-3, "friction": 0.2, "stiffness": 1e6, "damping": 20.0},
            "drive": {"speed": list(speed), "duration": 2.0},
            "start": {"rest": True},
        }
    )


def on_wall(stiffness):
    """The laval scene with a rigid wall (a contact as stiff as this makes it a spring wall) for a stator."""
    content = reference_scene("laval").to_dict()
    contact = {"gap": 1e-3, "friction": 0.2, "stiffness": stiffness, "damping": 10.0}
    drive = {"speed": [20.0, 60.0], "duration": 2.0}
    return Scene.from_dict({**content, "stator": {"model": "rigid"}, "contact": contact, "drive": drive, "start": {"rest": True}})


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize("speed", [math.nan, math.inf, -2e6, [50.0, math.nan]])
def test_speeds_no_drive_may_have_are_refused_in_one_line(speed):
    with pytest.raises(SceneError, match=r"^predict: speed = .* must be a speed in Hz between .*$") as refused:
        predict(reference_scene("mdof_2x2"), speed)
    assert "\n" not in str(refused.value)


def test_the_command_refuses_such_a_speed(capsys):
    assert main(["predict", str(REFERENCE / "laval.toml"), "--speed", "nan"]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("error: predict: speed = nan") and err.count("\n") == 1


def test_without_friction_it_says_so(capsys, tmp_path):
    scene = reference_scene("laval").with_values({"contact.friction": 0.0})
    assert scene_remarks(assemble(scene), []) == [NO_FRICTION]
    assert NO_FRICTION in survey_text(survey(scene)).splitlines()
    assert NO_FRICTION not in survey_text(survey(reference_scene("laval")))
    path = tmp_path / "scene.toml"
    path.write_text(_at_rest(scene).to_toml())
    assert main(["predict", str(path), "--speed", "50"]) == 0
    assert capsys.readouterr().out == f"no whirl is predicted\n{NO_FRICTION}\n"


def _at_rest(scene):
    return Scene.from_dict({**scene.to_dict(), "start": {"rest": True}})


@pytest.mark.parametrize("first", [0.0, 20.0])
def test_free_motions_are_named_and_break_nothing(first):
    scene = free_rotor((first, 60.0))
    system = assemble(scene)
    assert free_motions(system) == 1 and free_motions(reference("chain_10")) == 0
    found = survey(scene)
    assert "free motions of the rotor (singular stiffness): 1; without contact nothing brings it back" in found.remarks
    assert mu_min(scene, 50.0).cause == NO_LEAST
    at_rest = found.attractors[first]
    # without contact the growth rate is 0, not below
    assert at_rest[0].kind == "no contact" and not at_rest[0].stable
    whirls = predict(scene, first)
    assert len(whirls) > 0 and np.isfinite([[w.growth_rate, *w.synchronous.consistent.envelope] for w in whirls]).all()
    # a little stiffness gives nearly the same whirls
    held = changed(system, stiffness_r=system.rotor.stiffness + np.eye(2))
    free, other = ([w.frequency for w in predict_system(s, 50.0) if w.frequency < -5.0] for s in (system, held))
    assert len(free) == 4 and other == pytest.approx(free, rel=1e-3)


@pytest.mark.parametrize("stiffness", [4e6, 5e4])
def test_a_rigid_or_spring_wall_has_no_stable_whirl_for_a_laval_rotor(stiffness):
    found = survey(on_wall(stiffness))
    assert len(found.branches) == 1 and WALL in found.remarks
    assert any("without oscillation" in line and "loses contact" in line for line in found.remarks)


@pytest.mark.parametrize("pressing", [True, False])
def test_dry_whirl_on_a_wall_runs_away_or_loses_contact_in_the_simulation(pressing):
    scene = on_wall(4e6).with_values({"rotor.eccentricity": 0.0})
    system = assemble(scene)
    [whirl] = predict_system(system, 50.0)
    Psi = TWO_PI * whirl.frequency
    mode = small_motion(system, Psi, whirl.normal_force, TWO_PI * 50.0)
    # a thousandth of the penetration, outwards or inwards
    scale = (1.0 if pressing else -1.0) * 1e-3 * whirl.normal_force / system.law.stiffness / mode.lines[0].real
    x = whirl.rotor_shape + scale * mode.lines[0]
    v = scale * mode.eigenvalue.real * mode.lines[0] + 1j * Psi * x
    rotor, velocity = ([[float(z.real), float(z.imag)] for z in part] for part in (x, v))
    start = {"rotor": rotor, "rotor_velocity": velocity, "allow_penetration": True}
    content = {**scene.to_dict(), "start": start, "drive": {"speed": 50.0, "duration": 0.6}}
    result = rsc.simulate(Scene.from_dict(content))
    if pressing:
        assert result.summary.status == "diverged" and result.normal_force[-1] > 1e6 * whirl.normal_force
    else:
        assert result.summary.status == "finished" and not result.normal_force[-100:].any()


def test_the_wall_is_not_blamed_where_a_whirl_is_stable():
    rng = np.random.default_rng(1)
    system = [random_system(rng, most=4) for _ in range(55)][54]
    whirls = predict_system(system, 50.0)
    assert system.n_stator == 0 and {w.stable for w in whirls if w.frequency < 0.0} == {True, False}
    assert scene_remarks(system, whirls) == []


# ---------------------------------------------------------------- what unstable whirls do


def test_unstable_whirls_at_a_speed():
    system = reference("mdof_2x2")
    whirls = predict_system(system, 10.0)
    said = whirl_remarks(system, whirls)
    assert len(said) == sum(not w.stable for w in whirls)
    first = next(line for line in said if line.startswith("whirl -9.47"))
    assert first == (
        "whirl -9.4700 Hz is unstable, without oscillation (real eigenvalue): pushed outwards it leaves towards -12.9000 Hz, "
        "inwards it loses contact"
    )


def test_departures_in_words():
    near = departure_text(Departure("oscillatory", -50.0, False, -49.0))
    assert near == "flutter (Hopf) at -49.0000 Hz, leaves towards -50.0000 Hz"
    for towards in (-50.0, math.nan):
        assert "no stable whirl near" in departure_text(Departure("oscillatory", towards, False, -187.0))
    assert "runs away" in departure_text(Departure("creeping", math.nan, True, -33.0))


def test_unstable_stretches_of_branches():
    system = reference("gyroscopic_transition")
    found = branches(system, np.linspace(20.0, 150.0, 66))
    said = branch_remarks(system, found)
    lost = next(line for line in said if line.startswith("whirl A at"))
    # at the first speed of the grid beyond the crossing at 68.6 Hz
    assert lost.startswith("whirl A at 70 Hz (-33.6985") and "flutter (Hopf) at -49.8" in lost and "leaves towards -49.7" in lost
    assert not any(line.startswith(("whirl B", "whirl E")) for line in said)  # stable; below the gap


def test_where_the_damper_decides():
    system = reference("gyroscopic_transition")
    found = branches(system, np.linspace(60.0, 80.0, 5))
    lost = next(b for b in found if b.lost)
    [(low, high)] = undecided(system, lost)
    assert low < lost.lost[0] < high and high - low == pytest.approx(0.02, abs=0.003)

    def rate(speed, b_star):
        whirl = min(predict_system(system, speed), key=lambda w: abs(w.frequency + 33.8))
        return whirl_growth(system, TWO_PI * whirl.frequency, whirl.normal_force, TWO_PI * speed, b_star).rate

    # each limit crosses zero at one end
    rates = [abs(rate(low, 0.0)), abs(rate(high, system.law.damping))]
    assert max(rates) < 1e-6 * abs(rate(60.0, 0.0))
    assert undecided(changed(system, contact_damping=0.0), lost) == []
    [line] = damper_warnings(system, found)
    assert line.startswith(f"whirl {lost.label}: linear stability is undecided between {low:.6g} and {high:.6g} Hz")


def test_a_range_that_no_drive_holds_is_no_warning():
    # both limits of the damper cross zero within 1.4e-4 Hz
    system = reference("gyroscopic_figure3_right")
    found = branches(system, np.linspace(60.0, 64.0, 5))
    lost = next(b for b in found if b.events and b.events[0].value == pytest.approx(61.8505, abs=1e-4))
    crossings = [
        next(e.value for b in branches(changed(system, contact_damping=b_c), lost.speed) if b.lost for e in b.events)
        for b_c in (0.0, 2.0 * system.law.damping)
    ]
    assert 1e-5 < abs(crossings[1] - crossings[0]) < 2e-4
    assert undecided(system, lost) == [] and damper_warnings(system, found) == []


def test_undecided_at_one_speed():
    # over the friction the laval whirl loses stability at 0.2076 for b_C / 2
    system = changed(reference("laval"), friction=0.2076)
    whirls = predict_system(system, 50.0)
    [line] = [line for line in whirl_remarks(system, whirls) if "undecided" in line]
    whirl = min(whirls, key=lambda w: abs(w.frequency + 61.0))
    limits = damper_limits(system, TWO_PI * whirl.frequency, whirl.normal_force, TWO_PI * 50.0)
    assert f"growth {limits.off.rate:+.4g} 1/s with the contact damper off, {limits.on.rate:+.4g} on" in line
    [branch] = [b for b in branches(system, [50.0]) if abs(b.frequency[0] - whirl.frequency) < 1e-6]
    assert undecided(system, branch) == [(50.0, 50.0)]


def test_a_report_of_a_run_up_from_rest_with_free_motions():
    assert any("free motions" in warning for warning in check(free_rotor((0.0, 30.0))).warnings)


def test_a_report_warns_where_stability_is_undecided():
    scene = reference_scene("gyroscopic_transition").with_values({"drive.speed": [67.0, 70.0], "drive.duration": 6.0})
    warnings = check(rsc.Scene.from_dict({**scene.to_dict(), "start": {"rest": True}})).warnings
    assert any("linear stability is undecided between 68.59" in warning for warning in warnings)
    without = rsc.Scene.from_dict({**scene.with_values({"contact.friction": 0.0}).to_dict(), "start": {"rest": True}})
    assert NO_FRICTION in check(without).warnings


def test_without_gyroscopics_undecided_stability_is_so_at_all_speeds():
    """Looked at the ends only, against every speed of the branches of two rotors, one of which has an undecided one."""
    said = []
    for seed in (10, 11):
        system = random_system(np.random.default_rng(seed), 2, 1)
        system = changed(system, gyroscopic_r=0.0 * system.rotor.gyroscopic, contact_damping=1e4)
        for branch in branches(system, np.linspace(20.0, 60.0, 9)):
            limits = [damper_limits(system, TWO_PI * w.frequency, w.normal_force, TWO_PI * w.speed) for w in branch.whirls]
            assert len({limit.signs_agree for limit in limits}) == 1
            said.append(undecided(system, branch))
            assert said[-1] == ([] if limits[0].signs_agree else [(20.0, 60.0)])
    assert [] in said and [(20.0, 60.0)] in said
