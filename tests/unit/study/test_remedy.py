"""Changes of single values that take a lasting backward motion away."""

import json
import math
import os
import signal

import pytest

import rsc
from rsc.analysis.follow.least_friction import mu_min
from rsc.cli import main
from rsc.measure.kinds import HARMFUL, Kind
from rsc.measure.severity import Severity
from rsc.scene.files.templates import template
from rsc.show.words.remedies import remedies_text
from rsc.study.motions import remedy as remedying
from rsc.study.motions.settle import Settling
from rsc.study.motions.shaft_levers import shown_name
from rsc.system.assemble import assemble
from two_seals import pump as two_seals

PUMP = rsc.Scene.from_dict({
    "rotor": {"model": "laval", "mass": 12.0, "frequency": 2600 / 60, "damping_ratio": 0.02, "eccentricity": 5e-6},
    "stator": {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1},
    "contact": {"gap": 2.5e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05, "diameter": 0.08},
    "drive": {"speed": 50.0, "duration": 1.0},
})  # fmt: skip
FEW = (("contact", "friction", False, True), ("rotor", "damping_ratio", True, False))


@pytest.fixture
def few(monkeypatch):
    """Friction and damping of the rotor alone."""
    monkeypatch.setattr(remedying, "LEVERS", FEW)
    monkeypatch.setattr(remedying, "SPEED_RANGE", ())


def test_less_friction_helps_from_where_it_is_predicted_and_more_damping_does_not(few):
    found = rsc.remedy(PUMP, starts=8)
    assert {Kind.SLIDING, Kind.ROLLING} <= {motion.motion for motion in found.harmful}
    ((own,), (damping,)) = found.helping, found.others
    assert own.name == "contact.friction" and own.value == 0.2 and own.helps and not found.interrupted
    assert own.predicted * 0.2 == pytest.approx(found.motions.mu_min, rel=0.03)
    assert 0.8 * own.predicted < own.factor < own.predicted
    changed = PUMP.with_values({own.name: own.changed})
    assert not remedying.harmful_of(rsc.motions(changed, starts=16, seed=1))
    assert not damping.helps and math.isnan(damping.predicted) and damping.remains[0].motion == Kind.ROLLING
    told = remedies_text(found, "pump")
    by = f"divided by {1.0 / own.factor:.3g}; requires a lubricating film"
    assert f"contact.friction 0.2 -> {own.changed:.4g} ({by}); remains: no contact; severity {own.severity}" in told
    assert told.startswith("pump\n\nat 50.00 Hz: severity whirl; ") and own.severity == Severity.SAFE
    assert told.index("remedies, each by itself") < told.index("does not help") < told.index("0.02 -> 0.2 (times 10)")


def test_a_change_is_as_large_up_as_down_and_what_the_furthest_leaves_is_said(monkeypatch):
    """With friction divided by more than four nothing lasts, with three times the damping nothing either: that comes first."""
    monkeypatch.setattr(remedying, "LEVERS", (*FEW, ("stator", "mass", True, False)))
    monkeypatch.setattr(remedying, "SPEED_RANGE", ())
    (left,) = harmful = (rsc.motions(PUMP, starts=2).motions[0],)

    def left_by(self, lever, factor, states):
        helps = {"contact.friction": factor < 0.25, "rotor.damping_ratio": factor > 3.0, "stator.mass": False}[lever.name]
        return ("safe", ()) if helps else ("", harmful)

    monkeypatch.setattr(remedying._Remedying, "_left", left_by)
    found = rsc.remedy(PUMP, starts=2)
    assert [own.name for own in found.helping] == ["rotor.damping_ratio", "contact.friction"]
    damping, friction = found.helping
    assert 3.0 < damping.size < 3.0 * 3.0**0.3  # two bisections of a factor of ten's half
    assert 1.0 / friction.predicted < friction.size < 1.2 / friction.predicted
    (mass,) = found.others
    assert mass.factor == remedying.FURTHEST and mass.remains == (left,)


def test_less_friction_also_cures_what_runs_away():
    """The state of a motion that runs away is none to begin in: it is millions of newtons from any other."""
    away = rsc.Scene.from_dict({
        "rotor": {"model": "laval", "mass": 8.0, "frequency": 20.0, "damping_ratio": 0.015, "eccentricity": 2e-5},
        "stator": {"model": "rigid"},
        "contact": {"gap": 2e-4, "friction": 0.1, "stiffness": 1e6, "damping_ratio": 0.05},
        "drive": {"speed": 25.0, "duration": 1.0},
    })  # fmt: skip
    found = rsc.remedy(away, starts=4)
    assert [motion.motion for motion in found.harmful] == [Kind.RUNNING_AWAY, Kind.BOUNCING]
    assert {"contact.friction", "rotor.damping_ratio"} <= {own.name for own in found.helping}
    assert all(own.remains for own in found.others)  # what lasts there is said
    for own in found.helping:  # four impacts need not have one that is large enough to run away
        changed, speed = remedying.with_remedy(away, found.speed, own)
        least = mu_min(changed, speed)
        assert least is None or least.value > changed.contact.friction


def test_a_change_after_which_large_impacts_run_away_is_no_remedy(monkeypatch):
    """Of the lists of a few small impacts none shows it; the linear motion far beyond the gap grows."""
    monkeypatch.setattr(remedying, "LEVERS", (("stator", "mass", False, True), FEW[0]))
    monkeypatch.setattr(remedying, "SPEED_RANGE", ())
    one_sided = rsc.Scene.from_dict({
        "rotor": {"model": "laval", "mass": 6.0, "frequency": 30.0, "damping_ratio": 0.03, "eccentricity": 3e-5},
        "stator": {"model": "laval", "mass": 2.6, "frequency": 82.0, "damping_ratio": 0.11},
        "contact": {"gap": 3e-4, "friction": 0.3, "stiffness": 5e6, "damping_ratio": 0.05},
        "drive": {"speed": 11.0, "duration": 1.0},
    })  # fmt: skip
    found = rsc.remedy(one_sided, starts=4, largest=0.05)
    assert found.harmful and [own.name for own in found.helping] == ["contact.friction"]
    (mass,) = found.others
    assert not set(motion.motion for motion in mass.remains) & set(HARMFUL)
    assert "a motion that is large enough still runs away" in remedies_text(found)


def test_nothing_is_taken_away_where_nothing_lasts(few):
    found = rsc.remedy(PUMP.with_values({"contact.friction": 0.01}), starts=4)
    assert found.helping == found.others == () and "no remedy needed" in remedies_text(found)


def test_ctrl_c_keeps_what_was_found(few, monkeypatch):
    original, lists = remedying._Remedying._search, []

    def search(self, scene, speed):
        lists.append(speed)
        if len(lists) == 3:
            os.kill(os.getpid(), signal.SIGINT)
        return original(self, scene, speed)

    monkeypatch.setattr(remedying._Remedying, "_search", search)
    with pytest.raises(KeyboardInterrupt) as stop:
        rsc.remedy(PUMP, starts=2)
    found = stop.value.result
    assert found.interrupted and [own.name for own in found.helping] == ["contact.friction"] and not found.others
    assert remedies_text(found).endswith("other values were not examined")


def test_ctrl_c_in_a_list_is_no_remedy(few, monkeypatch):
    original, runs = Settling._end, []

    def end(self, *arguments):
        runs.append(1)
        if len(runs) == 12:
            os.kill(os.getpid(), signal.SIGINT)
        return original(self, *arguments)

    monkeypatch.setattr(Settling, "_end", end)
    with pytest.raises(KeyboardInterrupt) as stop:
        rsc.remedy(PUMP, starts=2)
    assert stop.value.result.interrupted and not stop.value.result.helping


def test_every_value_that_may_help_is_looked_at():
    levers = {(lever.name, lever.furthest > 1.0): lever.values for lever in remedying._levers(two_seals(), 50.0)}
    for name, ways in (("contact.seal.friction", {False}), ("contact.*.friction", {False}), ("contact.*.gap", {True, False}),
                       ("stator.stiffnesses", {True, False}), ("drive.speed", {True, False})):  # fmt: skip
        assert {up for other, up in levers if other == name} == ways, name
    assert set(levers["contact.*.friction", False]) == {"contact.seal.friction", "contact.bush.friction"}


def test_a_shaft_changes_all_its_bearings_and_unbalances_under_names_that_its_scene_knows():
    scene = rsc.Scene.from_toml(template("generator")).steady(25.0)  # bearings whose directions differ
    levers = {lever.name: lever for lever in remedying._levers(scene, 25.0) if lever.furthest != 0.1 or "unbalance" in lever.name}
    softer, _ = levers["rotor.damping"].applied(scene, 25.0, 3.0)
    before, after = assemble(scene).rotor, assemble(softer).rotor
    assert after.damping == pytest.approx(3.0 * before.damping) and after.stiffness == pytest.approx(before.stiffness)
    assert after.anisotropic_damping == pytest.approx(3.0 * before.anisotropic_damping) and before.anisotropic_damping.any()
    lighter, _ = levers["rotor.unbalance"].applied(scene, 25.0, 0.5)
    assert assemble(lighter).rotor.unbalance == pytest.approx(0.5 * before.unbalance)
    assert shown_name(scene, "rotor.damping") == "damping of all rotor bearings"
    assert shown_name(scene, "rotor.unbalance") == "all unbalances of the rotor"
    assert shown_name(scene, "stator.mass") == "stator.mass" and shown_name(PUMP, "rotor.damping") == "rotor.damping"


def test_the_command(few, tmp_path, capsys):
    path = tmp_path / "pump.toml"
    path.write_text(PUMP.to_toml())
    assert main(["remedy", str(path), "--starts", "2", "--speed", "50"]) == 0
    assert "contact.friction 0.2 -> " in capsys.readouterr().out
    assert main(["remedy", str(path), "--starts", "2", "--json"]) == 0
    (own,) = json.loads(capsys.readouterr().out)["helping"]
    assert own["name"] == "contact.friction" and own["helps"] and own["remains"]
    assert main(["remedy", str(path), "--starts", "-1"]) == 2
