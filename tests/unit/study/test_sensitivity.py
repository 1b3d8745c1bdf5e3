"""Derivatives of predicted whirls: laws of scale, an implicit derivative, values that cannot be changed."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import rsc
from rsc.analysis.follow.least_friction import mu_min
from rsc.analysis.paper.receptance import receptance
from rsc.cli import main
from rsc.scene.values import with_entries
from rsc.show.words.sensitivities import sensitivity_text
from rsc.study.prediction.sensitivity import QUANTITIES
from rsc.system.assemble import assemble
from scenes import LAVAL, SCENES
from two_seals import pump

SPEED = 55.0
FIGURE = Path(__file__).parents[3] / "data" / "reference" / "gyroscopic_figure3_right.toml"


@pytest.fixture(scope="module", params=["laval", "figure"])
def case(request):
    scene = rsc.Scene.from_dict(LAVAL) if request.param == "laval" else rsc.load_scene(FIGURE)
    return scene, rsc.sensitivity(scene, SPEED), [whirl for whirl in rsc.predict(scene, SPEED) if whirl.frequency < 0.0]


def test_it_is_about_the_backward_whirls_at_the_speed(case):
    _, result, whirls = case
    assert result.whirl.tolist() == [whirl.frequency for whirl in whirls] and result.speed == SPEED
    assert result.stable.tolist() == [whirl.stable for whirl in whirls] and result.stable.any()
    assert all(getattr(result, name).shape == (len(result.name), len(whirls)) for name in (*QUANTITIES, "good"))


def test_a_larger_gap_makes_everything_larger_in_proportion(case):
    """Without unbalance the gap is the only length: frequency and growth do not depend on it."""
    _, result, whirls = case
    row = result.name.index("contact.gap")
    for name in ("rotor_amplitude", "normal_force"):
        assert getattr(result, name)[row] == pytest.approx([getattr(whirl, name) for whirl in whirls], rel=1e-8)
    assert result.frequency[row] == pytest.approx(0.0, abs=1e-6)
    assert result.growth_rate[row] == pytest.approx(0.0, abs=1e-4)
    assert result.good[row].all()


def test_heavier_and_stiffer_in_proportion_changes_forces_alone(case):
    """All inertias, stiffnesses and dampings, those of the contact too, by one factor: the equations of motion times that.

    Frequencies and damping ratios, which some scenes give instead, stay.
    """
    _, result, whirls = case
    kinds = ("mass", "inertia", "stiffness", "damping")
    rows = [i for i, name in enumerate(result.name) if any(kind in name for kind in kinds) and "ratio" not in name]
    good = result.good[rows].all(axis=0)
    assert good.any()
    scale = abs(result.frequency[rows]).max()
    assert result.frequency[rows].sum(axis=0)[good] == pytest.approx(0.0, abs=1e-5 * scale)
    forces = np.array([whirl.normal_force for whirl in whirls])
    assert result.normal_force[rows].sum(axis=0)[good] == pytest.approx(forces[good], rel=1e-4)


def test_the_derivative_by_friction_is_that_of_the_whirl_condition(case):
    """Im[(1 + i mu) H(Psi)] = 0 along a root: mu dPsi/dmu = -mu Re H / Im[(1 + i mu) H']."""
    scene, result, whirls = case
    system, turn = assemble(scene), 2.0 * np.pi
    Psi, step = turn * np.array([whirl.frequency for whirl in whirls]), 1e-4
    H = receptance(system, Psi, turn * SPEED)
    slope = (receptance(system, Psi + step, turn * SPEED) - receptance(system, Psi - step, turn * SPEED)) / (2.0 * step)
    expected = -system.law.friction * H.real / ((1.0 + 1j * system.law.friction) * slope).imag / turn
    row = result.name.index("contact.friction")
    assert result.frequency[row] == pytest.approx(expected, rel=1e-8)


def test_a_whirl_at_its_fold_is_told():
    """Two roots merge where the friction is least: just above, a step of 0.1 % finds none."""
    scene = rsc.Scene.from_dict(LAVAL).with_values({"stator.frequency": 150.0})
    least = mu_min(scene, 50.0).value
    result = rsc.sensitivity(scene.with_values({"contact.friction": 1.0002 * least}), 50.0, ["contact.friction"])
    assert result.name == ("contact.friction",) and len(result.whirl) and not result.good.all()


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["contact.fraction"], r"contact\.fraction: must be a key of \[contact\]"),
        (["solver.method"], r"solver\.method: must be a number of rotor, stator or contact"),
    ],
)
def test_values_that_cannot_be_changed_are_refused(names, message):
    with pytest.raises(rsc.SceneError, match=message.replace(": must", ".*: must")):
        rsc.sensitivity(rsc.Scene.from_dict(LAVAL), 50.0, names)


def test_the_table_shows_no_rounding(case):
    """The frequency does not depend on the gap; a difference of two of them may leave the last bits of a number."""
    _, result, _ = case
    row = result.name.index("contact.gap")
    noise = np.where(np.arange(len(result.name))[:, None] == row, 1e-10 * np.abs(result.growth_rate).max(axis=0), 0.0)
    text = sensitivity_text(replace(result, frequency=result.frequency + 1e-9 * noise, growth_rate=result.growth_rate + noise))
    cells = [line.split() for line in text.splitlines() if "contact.gap " in line]
    assert cells and all((own[3], own[6]) == ("+0", "+0") for own in cells)


def test_the_command(tmp_path, capsys):
    path = tmp_path / "laval.toml"
    path.write_text(rsc.Scene.from_dict(SCENES["whirl, unbalance, run-up"]).to_toml())
    assert main(["predict", str(path), "--speed", "50", "--sensitivity"]) == 0
    told = capsys.readouterr().out
    assert "changes\n" in told and "contact.friction" in told
    assert main(["predict", str(path), "--speed", "50", "--sensitivity", "--json"]) == 0
    ((whirls, change),) = [(item["whirls"], item["sensitivity"]) for item in json.loads(capsys.readouterr().out)]
    assert len(change["frequency"]) == len(change["name"]) and whirls
    assert main(["predict", str(path), "--sensitivity"]) == 2
    assert "--sensitivity: requires rotor speeds" in capsys.readouterr().err


def test_at_several_contacts_they_are_those_of_predictions_at_changed_values():
    """Of every pressed set, by a step of another size; a whirl at one contact alone has those of the scene with one contact."""
    scene = pump()
    names = ["contact.seal.friction", "contact.bush.gap", "rotor.masses[1]", "rotor.damping_ratio"]
    result = rsc.sensitivity(scene, 50.0, names)
    whirls = [whirl for whirl in rsc.predict(scene, 50.0) if whirl.frequency < 0.0]
    assert [pressed for pressed in result.pressed] == [whirl.pressed for whirl in whirls] and len(set(result.pressed)) == 3
    assert result.good.all()
    for i, name in enumerate(names):
        value = result.value[i]
        near = [rsc.predict(with_entries(scene, {name: value * (1.0 + step)}), 50.0) for step in (2e-4, -2e-4)]
        for k, whirl in enumerate(whirls):
            up, down = (min(one, key=lambda other: distance(other, whirl)) for one in near)
            for quantity in ("frequency", "growth_rate"):
                wanted = (getattr(up, quantity) - getattr(down, quantity)) / 4e-4
                assert getattr(result, quantity)[i, k] == pytest.approx(wanted, rel=1e-3, abs=1e-3)
            hardest = max(whirl.contacts, key=lambda at: whirl.contacts[at].normal_force)
            wanted = (up.contacts[hardest].normal_force - down.contacts[hardest].normal_force) / 4e-4
            assert result.normal_force[i, k] == pytest.approx(wanted, rel=1e-3, abs=1e-3)
    assert "of seal and bush at 50 Hz" in sensitivity_text(result)


def distance(one, other):
    return abs(one.frequency - other.frequency) if one.pressed == other.pressed else np.inf
