"""Runs of machines with several contacts beside their predictions: which set whirls, what each contact does, page, JSON."""

import copy
import json
import re
from dataclasses import replace

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.measure.kinds import Kind
from rsc.measure.several import hardest, name_of, together
from rsc.measure.windows import branches_of
from rsc.results.at_contact import at_contact
from rsc.show.page import page
from rsc.show.words.answer import answer
from rsc.show.words.plain import report_plain
from rsc.show.words.reasons import percent
from rsc.show.words.text import report_text
from rsc.study.report.check import report
from scenes import TWO
from two_seals import PUMP, pump

BLOW = {"rotor_velocity": [[0.0, 0.0], [0.0, -0.5], [0.0, 0.0]]}


def whirling(seal=None, bush=None, **values):
    """The pump after a blow that starts its whirl."""
    content = pump(seal, bush, **values).to_dict()
    return rsc.Scene.from_dict(content | {"start": BLOW, "drive": content["drive"] | {"duration": 4.0}})


@pytest.fixture(scope="module")
def told():
    return rsc.check(whirling())


def test_the_run_settles_on_the_whirl_predicted_at_both_contacts(told):
    (whirl,) = [whirl for whirl in rsc.predict(pump()) if whirl.stable]
    last = told.windows[-1]
    (branch,) = [branch for branch in told.branches if branch.label == last.branch]
    assert branch.pressed == told.features.sets[-1] == whirl.pressed == ("seal", "bush")
    assert told.lead == "seal" and told.contact.name == "seal"
    assert last.frequency.verdict == last.amplitude.verdict == last.synchronous.verdict == "agrees"
    assert last.frequency.predicted == whirl.frequency and abs(last.frequency.difference) < 1e-4
    assert last.amplitude.predicted == pytest.approx(abs(whirl.rotor_shape[1])) and abs(last.amplitude.difference) < 2e-3
    for name, own in told.contacts.items():
        assert own.share[-1] == 1.0 and own.kind[-1] == Kind.SLIDING
        assert own.force[-1] == pytest.approx(whirl.contacts[name].normal_force, rel=2e-3)
        assert own.over_gap[-1] == pytest.approx(whirl.contacts[name].over_gap, rel=0.02)
    assert told.features.names[0].startswith("bouncing") and told.features.names[-1] == "backward whirl, sliding at seal and bush"


def test_the_answer_names_the_set_and_tells_each_contact(told):
    lines = dict(answer(told))
    assert lines["whirl"].startswith("backward whirl, sliding at seal and bush at a rotor speed of 50.00 Hz")
    assert "sliding at seal and bush, at a rotor speed of 50.00 Hz, whirl A, predicted to be stable at all" in lines["at the end"]
    assert "vibration" not in lines and "force" not in lines
    for contact in told.result.scene.contacts:
        whole = told.result.stretches(contact.name).whole()
        share = percent(whole.deflection_max / contact.gap - 1.0)
        assert f"{share} of the clearance; up to " in lines[contact.name]
        most = told.contacts[contact.name].peak_to_peak.max()
        assert lines[contact.name].startswith(f"vibration up to {1e6 * most:.0f} um pk-pk from ")
        ends = re.search(r"from ([\d.]+) to ([\d.]+) s; penetration up to ", lines[contact.name]).groups()
        begin, end = map(float, ends)
        assert told.result.stretches(contact.name).between(begin, end).peak_to_peak == most
        assert end - begin < 1.5 * told.features.window < told.result.stretches(contact.name).end[-1]
        assert f"in contact for {100 * whole.share:.1f} %" in lines[contact.name]
    # the drive pays at both
    paid = sum(0.1 * contact.diameter * told.contacts[contact.name].force[-1] for contact in told.result.scene.contacts)
    torque = float(re.match(r"rub torque on the shaft up to ([\d.]+) N m", lines["drive"])[1])
    assert torque == pytest.approx(paid, rel=0.02)
    assert "is not known" in lines["mu_min"] and "in 13 of" in lines["check"]
    assert "no contact (seal 0.12 gaps; bush 0.13 gaps, 7 of 16 impacts)" in lines["after an impact"]
    verbose = report_text(told, verbose=True)
    assert "lengths over the gap, at seal" in verbose and "seal: |d|/gap, N" in verbose


def test_page_and_json_hold_every_set_and_every_contact(told):
    text, plain = page(told), json.loads(json.dumps(report_plain(told)))
    assert "seal and bush" in text and "at seal, which takes the largest impulse" in text and "the same at bush" in text
    assert plain["lead"] == "seal" and [own["name"] for own in plain["contacts"]] == ["seal", "bush"]
    assert {tuple(branch["pressed"]) for branch in plain["branches"]} == {("bush",), ("seal",), ("seal", "bush")}
    for branch in plain["branches"]:
        for name, own in branch["at_contacts"].items():
            assert (own["normal_force"][0] > 0.0) == (name in branch["pressed"])
    for own, contact in zip(plain["contacts"], told.result.scene.contacts, strict=True):
        whole = told.result.stretches(contact.name).whole()
        assert (own["force_max"], own["share"]) == (whole.force_max, whole.share)
        assert len(own["windows"]["force"]) == len(told.windows)


def test_a_page_from_the_stored_analysis_is_the_same(tmp_path, capsys):
    path, folder = tmp_path / "pump.toml", tmp_path / "out"
    path.write_text(whirling(**{"drive.duration": 1.0}).to_toml())
    assert main(["check", str(path), "-o", str(folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["lead"] == "seal"
    first = (folder / "report.html").read_text(encoding="utf-8")
    assert main(["report", str(folder / "result.h5"), "-o", str(tmp_path)]) == 0
    assert main(["plot", str(folder / "result.h5"), "-o", str(tmp_path / "plots")]) == 0
    again = (tmp_path / "report.html").read_text(encoding="utf-8")
    # the minute of writing and the sum over it
    dated = "report of [^<]* UTC|sha256 [0-9a-f]{64}"
    assert re.sub(dated, "", again) == re.sub(dated, "", first)
    assert (tmp_path / "plots" / "contact.png").stat().st_size > 10_000


def test_with_a_contact_far_away_it_is_the_report_of_the_other_one():
    """Verdicts, predicted whirls and what is told of the contact, but for what is not predicted at several."""
    far = whirling(bush={"gap": 1.0}, **{"drive.duration": 2.0})
    content = far.to_dict()
    both, one = rsc.check(far), rsc.check(rsc.Scene.from_dict({**content, "contact": content["contact"][0]}))
    assert [window.frequency.verdict for window in both.windows] == [window.frequency.verdict for window in one.windows]
    for own, other in zip(both.rows, one.rows, strict=True):
        assert own.simulated == pytest.approx(other.simulated, rel=1e-4, abs=1e-9)
        assert own.predicted == pytest.approx(other.predicted, rel=2e-3, abs=1e-9, nan_ok=True)  # first order beside balance
    seal, alone = both.branches[0], one.branches[0]
    assert (seal.frequency[0], seal.growth_rate[0]) == pytest.approx((alone.frequency[0], alone.growth_rate[0]), rel=1e-6)
    assert (seal.amplitude[0], seal.normal_force[0]) == pytest.approx((alone.amplitude[0], alone.normal_force[0]), rel=1e-6)
    assert seal.envelope(1)[0] == pytest.approx(alone.envelope(1)[0], rel=1e-6)
    assert dict(answer(both))["bush"].endswith("gaps (1.45 mm), never touched") or "never touched" in dict(answer(both))["bush"]


def test_a_run_up_through_forward_rubs_has_no_whirl_and_no_line_predicted_in_contact():
    told = rsc.check(rsc.Scene.from_dict(copy.deepcopy(TWO) | {"drive": {"speed": [10.0, 120.0], "duration": 2.0}}))
    lines, features = dict(answer(told)), told.features
    assert "no backward whirl" in lines["whirl"] and "forward rub at seal and ring" in lines["whirl"]
    for window, share in zip(told.windows, features.share, strict=True):
        assert np.isnan(window.synchronous.predicted) == (share > 0.0)
    assert np.isnan(told.rub[1]).all() and np.isnan(told.resonance)


def test_the_run_at_a_contact_is_that_contact_s_part_of_it(tmp_path):
    result = rsc.simulate(whirling(**{"drive.duration": 0.5}), path=tmp_path / "run.h5")
    for i, name in enumerate(("seal", "bush")):
        own = at_contact(result, i)
        assert own.scene.contact.name == name and np.array_equal(own.normal_force, result.normal_force[:, i])
        assert np.array_equal(own.stretches().rows, result.stretches(name).rows)
        part = own.samples(100, 300)
        assert np.array_equal(part.contact_rotor(), result.rotor[100:300, i + 1])
        assert np.array_equal(part.contact_stator(), result.stator[100:300, i])
        assert np.array_equal(part.friction_force, result.friction_force[100:300, i])
    assert hardest(result) == 0
    one = rsc.simulate(rsc.Scene.from_dict({**PUMP, "contact": PUMP["contact"][0]}).with_values({"drive.duration": 0.1}))
    assert at_contact(one, 0) is one


def test_a_window_is_compared_with_whirls_of_its_own_set_only(told):
    features = told.features
    last = len(features.speed) - 1
    assert {branch.pressed for branch in branches_of(features, told.branches, last)} == {("seal", "bush")}
    mixed = replace(features, sets=((),) * len(features.sets))
    assert branches_of(mixed, told.branches, last) == []
    rolling = replace(features, kind=np.full(len(features.kind), str(Kind.ROLLING)))
    assert branches_of(rolling, told.branches, last) == []


def test_names_of_motions_and_sets():
    kinds = {"a": Kind.SLIDING, "b": Kind.NO_CONTACT, "c": Kind.ROLLING, "d": Kind.SLIDING}
    assert name_of(kinds) == "backward whirl, sliding at a and d, with backward whirl, rolling at c"
    assert name_of({"a": Kind.NO_CONTACT, "b": Kind.NO_CONTACT}) == "no contact"
    assert together(["a"]) == "a" and together(["a", "b", "c"]) == "a, b and c"


@pytest.mark.parametrize("both", [True, False])
def test_what_cannot_be_predicted_is_refused_before_it_is_simulated(both, tmp_path, capsys):
    content = pump(bush={"offset": [1e-5, 0.0]}).to_dict()
    scene = rsc.Scene.from_dict(content if both else {**content, "contact": content["contact"][1]})
    path = tmp_path / "pump.toml"
    path.write_text(scene.to_toml())
    assert main(["check", str(path), "-o", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.strip().splitlines()[-1].startswith("error: contact.")
    assert not (tmp_path / "out" / "result.h5").exists()


def test_a_run_that_is_reported_without_a_file_is_the_same(told):
    again = report(told.result, lists=False)
    assert again.agreement == told.agreement and again.motions == []
