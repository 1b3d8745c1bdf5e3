"""Motions that last and impacts of machines with several contacts: which set is pressed, and the whirl that predicts it."""

import json

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.measure.kinds import Kind, Motion, of_contacts
from rsc.measure.stretches import COLUMNS, Facts
from rsc.show.words.impulses import impulses_text
from rsc.show.words.motions import motions_text
from two_seals import PUMP, pump


@pytest.fixture(scope="module")
def listed():
    return rsc.motions(pump(), starts=8)


def at_both(listed):
    """The sliding whirl that is pressed at both contacts."""
    (found,) = [each for each in listed if each.motion == Kind.SLIDING and each.pressed == ("seal", "bush")]
    return found


def test_the_whirl_at_both_contacts_is_found_as_it_is_predicted(listed):
    whirling, free = at_both(listed), listed.motions[-1]
    assert free.motion == Kind.NO_CONTACT
    (whirl,) = [whirl for whirl in rsc.predict(pump()) if whirl.stable]
    assert whirling.pressed == whirling.predicted.pressed == whirl.pressed == ("seal", "bush")
    assert whirling.frequency == pytest.approx(whirl.frequency, rel=3e-4)
    for name, own in whirling.contacts.items():
        assert own.force_mean == pytest.approx(whirl.contacts[name].normal_force, rel=0.005)
        assert own.over_gap == pytest.approx(whirl.contacts[name].over_gap, rel=0.02)
        assert own.share == 1.0 and own.force_max >= own.force_mean
    frequency, force = whirling.off
    assert 0.0 < frequency < 3e-4 and 0.0 < force < 0.005
    # the drive pays mu F_N d/2 at each
    paid = sum(0.1 * contact.diameter * whirling.contacts[contact.name].force_mean for contact in pump().contacts)
    assert whirling.torque == pytest.approx(paid, rel=1e-3)
    assert sum(motion.share for motion in listed) == pytest.approx(1.0)


def test_what_is_not_reached_names_its_set_and_nothing_is_claimed_of_the_least_friction(listed):
    assert {one.pressed for one in listed.not_reached} == {("bush",), ("seal",), ("seal", "bush")}
    text = motions_text(listed)
    assert "backward whirl, sliding at seal and bush; predicted: whirl C at seal and bush -89.82 Hz" in text
    assert "whirl B at seal -90.60 Hz, 16.1 kN, growth -1.81 1/s, touches bush" in text
    seal, bush = (listed.largest_at[name] for name in ("seal", "bush"))
    assert f"random impacts at seal up to {seal:.3g} N s and at bush up to {bush:.3g} N s" in text
    assert "is not known" in text and "no backward whirl is predicted" not in text


def test_a_contact_that_is_far_away_changes_no_motion():
    """The same list as of the pump with its other seal alone, but for what is told of the far one."""
    both = rsc.motions(pump(bush={"gap": 1.0}), starts=0)
    alone = rsc.motions(rsc.Scene.from_dict({**PUMP, "contact": PUMP["contact"][0]}), starts=0)
    assert [m.motion for m in both.motions] == [m.motion for m in alone.motions][: len(both.motions)]
    one, other = both.motions[0], alone.motions[0]
    assert one.pressed == ("seal",) and one.contacts["bush"].motion == Kind.NO_CONTACT
    assert one.frequency == pytest.approx(other.frequency, rel=1e-6)
    assert (one.amplitude_max, one.force_max, one.torque) != (0.0, 0.0, 0.0)
    assert one.amplitude_max == pytest.approx(other.amplitude_max, rel=1e-5)
    assert one.force_max == pytest.approx(other.force_max, rel=1e-4)


def test_a_whirl_at_one_contact_is_told_from_one_at_both():
    """With a wider bush the seal's whirl is there alone, and beside it one that slides at the seal and rolls at the bush."""
    listed = rsc.motions(pump(bush={"gap": 1.45e-3}), starts=0)
    alone, mixed, *_ = listed.motions
    assert alone.motion == mixed.motion == Kind.SLIDING and alone.pressed == mixed.pressed == ("seal",)
    assert mixed.touched == ("seal", "bush") and mixed.predicted is None  # no whirl at the seal alone
    assert "sliding at seal, with backward whirl, rolling at bush" in motions_text(listed)
    assert alone.contacts["bush"].motion == Kind.NO_CONTACT and alone.contacts["bush"].over_gap < 1.0
    assert alone.predicted.pressed == ("seal",) and alone.off[0] < 3e-4 and alone.off[1] < 0.01


def test_the_mirrored_pump_has_the_mirrored_list(listed):
    backward = rsc.motions(pump().mirrored(), starts=8)
    assert [own.frequency for own in backward][:-1] == [-own.frequency for own in listed][:-1]
    assert [own.contacts for own in backward][:-1] == [own.contacts for own in listed][:-1]
    assert at_both(backward).predicted.frequency > 0.0


def facts(**values):
    return Facts(begin=0.0, **(dict.fromkeys(COLUMNS, 0.0) | {"end": 1.0} | values))


def test_the_motion_is_the_most_dangerous_one_and_of_equal_ones_the_hardest():
    rub = Motion(Kind.PARTIAL_RUB, "", np.nan, facts(normal_impulse=9.0))
    light, hard = (Motion(Kind.BOUNCING, "", -40.0, facts(normal_impulse=force)) for force in (1.0, 2.0))
    whole = of_contacts([rub, light, hard])
    assert (whole.kind, whole.facts, whole.at) == (Kind.BOUNCING, hard.facts, (rub, light, hard))
    assert of_contacts([rub]) is rub


def test_the_smallest_impulse_is_found_at_each_contact():
    scene = pump(bush={"gap": 1e-4})
    at_seal, at_bush = (rsc.smallest_impulse(scene, directions=2, contact=name) for name in ("seal", "bush"))
    assert (at_seal.contact, at_bush.contact) == ("seal", "bush")
    assert set(at_seal.at) == {"seal and bush"} and set(at_seal.motion) == {Kind.SLIDING}
    assert at_seal.velocity == pytest.approx(at_seal.impulse / 30.0)
    assert set(at_bush.motion) == {Kind.SLIDING} and at_bush.velocity == pytest.approx(at_bush.impulse / 8.0)
    text = impulses_text(at_seal)
    assert "impacts at seal" in text and "backward whirl, sliding at seal and bush" in text
    # what it finds is true of runs from those states
    for place, found in ((1, at_seal), (2, at_bush)):
        velocity = [[0.0, 0.0] for _ in range(3)]
        velocity[place][0] = float(found.velocity[0])
        again = scene.with_values({"start.rotor_velocity": velocity})
        assert rsc.simulate(again).stretches("bush").tail(0.2).share == 1.0


def test_the_smallest_impulse_of_a_list_is_that_at_the_contact_which_needs_least():
    scene = pump(bush={"gap": 1e-4})
    listed = rsc.motions(scene, starts=4, smallest=True)
    (found,) = (motion.smallest_impulse for motion in listed.motions if motion.motion == Kind.SLIDING)
    at_seal = rsc.smallest_impulse(scene, directions=8, contact="seal").impulse.min()
    assert 0.9 * at_seal < found < 1.1 * at_seal


@pytest.mark.parametrize("command", ["motions", "impact"])
def test_the_commands_tell_each_contact(command, tmp_path, capsys):
    path = tmp_path / "pump.toml"
    path.write_text(pump().to_toml())
    picture = tmp_path / "starts.png"
    more = {"motions": ["--starts", "4", "-o", str(picture)], "impact": ["--directions", "1", "--contact", "bush"]}[command]
    assert main([command, str(path), "--json", *more]) == 0
    told = json.loads(capsys.readouterr().out)
    if command == "impact":
        assert told["contact"] == "bush" and told["motion"] == [Kind.SLIDING]
    else:
        assert set(told["motions"][0]["contacts"]) == {"seal", "bush"} and told["mu_min"] is None
        assert picture.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (["impact", "--contact", "sael"], "contact = 'sael': must be one of seal, bush"),
    ],
)
def test_what_cannot_be_asked_is_one_line(command, message, tmp_path, capsys):
    path = tmp_path / "pump.toml"
    path.write_text(pump().to_toml())
    assert main([command[0], str(path), *command[1:]]) == 2
    told = capsys.readouterr().err.strip().splitlines()[-1]
    assert told.startswith("error: ") and message in told
