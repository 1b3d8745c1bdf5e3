"""Changes of single values that take a lasting backward motion away."""

import json
import math
import os
import signal

import pytest

import rsc
from rsc.cli import main
from rsc.measure.kinds import Kind
from rsc.show.words.remedies import remedies_text
from rsc.study.motions import remedy as remedying
from rsc.study.motions.settle import Settling
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
    assert f"contact.friction 0.2 -> {own.changed:.4g} ({100.0 * own.change:+.3g} %); remains: no contact" in told
    assert told.index("remedies, each by itself") < told.index("does not help:") < told.index("rotor.damping_ratio 0.02 -> 0.1")


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


def test_the_command(few, tmp_path, capsys):
    path = tmp_path / "pump.toml"
    path.write_text(PUMP.to_toml())
    assert main(["remedy", str(path), "--starts", "2", "--speed", "50"]) == 0
    assert "contact.friction 0.2 -> " in capsys.readouterr().out
    assert main(["remedy", str(path), "--starts", "2", "--json"]) == 0
    (own,) = json.loads(capsys.readouterr().out)["helping"]
    assert own["name"] == "contact.friction" and own["helps"] and own["remains"]
    assert main(["remedy", str(path), "--starts", "-1"]) == 2
