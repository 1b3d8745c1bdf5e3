"""Names that are more than a key: a key of every contact, amount and angle of the eccentricities of a rotor."""

from dataclasses import replace

import pytest

import rsc
from dropped import dropped
from rsc.scene.values import value_of, with_entries
from scenes import LAVAL, SCENES

DROP, DISK, SINGLE = dropped(), rsc.Scene.from_dict(SCENES["gyroscopic disk"]), rsc.Scene.from_dict(LAVAL, "laval.toml")
COUPLE = DROP.with_values({"rotor.eccentricity": [[1e-6, 10.0], [2e-6, 190.0]]})


def polar(scene):
    """Amounts and angles of the eccentricities of a rotor."""
    each = scene.rotor.eccentricity
    return [(one.amount, one.angle) for one in (each if isinstance(each, tuple) else [each])]


def test_an_angle_turns_every_eccentricity_and_an_amount_scales_it():
    assert polar(DROP.with_values({"rotor.eccentricity.angle": 40.0})) == [(2e-6, 40.0), (2e-6, 40.0)]
    assert polar(COUPLE.with_values({"rotor.eccentricity.angle": 90.0})) == [(1e-6, 90.0), (2e-6, 270.0)]
    assert polar(COUPLE.with_values({"rotor.eccentricity.amount": "3 um"})) == [(3e-6, 10.0), (6e-6, 190.0)]
    both = {"rotor.eccentricity.angle": "0.5 rad", "rotor.eccentricity.amount": 0.0}
    assert polar(COUPLE.with_values(both))[0] == (0.0, pytest.approx(28.6478897565))
    assert polar(SINGLE.with_values({"rotor.eccentricity.angle": -30.0})) == [(5e-5, -30.0)]
    assert polar(DISK.with_values({"rotor.eccentricity.amount": 1e-6})) == [(1e-6, 30.0)]
    tilted = DISK.with_values({"rotor.angular_eccentricity.angle": 10.0}).rotor
    assert tilted == replace(DISK.rotor, angular_eccentricity=replace(DISK.rotor.angular_eccentricity, angle=10.0))


def test_a_tilt_and_a_zero_do_not_lead():
    rotor = {"mass": [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]], "stiffness": [[9e4, 0, 0], [0, 9e4, 0], [0, 0, 9e4]]}
    rotor |= {"model": "matrices", "tilt_coordinates": [0], "eccentricity": [1e-3, 0.0, [2e-5, 30.0]]}
    scene = rsc.Scene.from_dict(LAVAL | {"rotor": rotor, "contact": LAVAL["contact"] | {"rotor_coordinate": 1}, "start": {}})
    changed = scene.with_values({"rotor.eccentricity.angle": 50.0, "rotor.eccentricity.amount": 1e-5})
    assert polar(changed) == [(5e-4, 20.0), (0.0, 20.0), (1e-5, 50.0)]


@pytest.mark.parametrize("scene", [DROP, COUPLE, SINGLE, DISK], ids=["two alike", "couple", "laval", "disk"])
def test_what_the_scene_has_leaves_it_as_it_is(scene):
    amount, angle = polar(scene)[0]
    own = {"rotor.eccentricity.amount": amount, "rotor.eccentricity.angle": angle}
    assert scene.with_values(own) == with_entries(scene, own) == scene
    turned = scene.with_values({"rotor.eccentricity.angle": angle + 64.0})
    assert turned != scene and turned.with_values({"rotor.eccentricity.angle": angle}) == scene
    assert rsc.Scene.from_toml(turned.to_toml()) == turned


def test_units_and_what_a_message_says():
    units = {"rotor.eccentricity.angle": "deg", "contact.*.ring_eccentricity.amount": "m", "contact.*.friction": "1"}
    for name, unit in units.items():
        value = value_of(DROP, name)
        assert (value.name, value.unit) == (name, unit) and value.meaning.endswith(".")
    with pytest.raises(rsc.SceneError, match=r"rotor\.eccentricity\.angle = '3 kg'"):
        value_of(DROP, "rotor.eccentricity.angle").read("3 kg")
    turned = SINGLE.with_values({"rotor.eccentricity.angle": 40.0})
    assert turned.source == "laval.toml with rotor.eccentricity.angle = 40.0"


def test_one_name_is_that_of_every_contact():
    values = {"contact.*.friction": 0.3, "contact.*.ring_eccentricity.amount": 1e-6, "contact.free_end.gap": 3e-4}
    changed = with_entries(DROP, values)
    assert [(own.friction, own.ring_eccentricity.amount) for own in changed.contacts] == [(0.3, 1e-6)] * 2
    assert [own.gap for own in changed.contacts] == [2.5e-4, 3e-4]
    assert SINGLE.with_values({"contact.*.friction": 0.3}) == SINGLE.with_values({"contact.friction": 0.3})


def test_an_entry_may_be_an_angle_that_the_scene_leaves_out():
    assert polar(with_entries(DROP, {"rotor.eccentricity[1][1]": 30.0})) == [(2e-6, 0.0), (2e-6, 30.0)]
    assert polar(with_entries(SINGLE, {"rotor.eccentricity[1]": 30.0})) == [(5e-5, 30.0)]


@pytest.mark.parametrize(
    ("name", "told"),
    {
        "rotor.eccentricity.angel": 'did you mean "rotor.eccentricity.angle"?',
        "rotor.eccentrcity.amount": 'did you mean "rotor.eccentricity.amount"?',
        "rotor.mass.angle": "did you mean",
        "rotor.angle": "a key of [rotor]",
        "contact.*.frction": "friction",
        "contact.friction": "contact.* means every contact",
        "contact.free.ring_eccentricity.angle": "contact.drive_end or contact.free_end",
        "contact.drive_end.angle": "contact.drive_end or contact.free_end",
        "start.*.rotor": "a key of a scene",
    }.items(),
)
def test_a_name_that_is_none_is_refused_in_one_line(name, told):
    for ask in (lambda: value_of(DROP, name), lambda: DROP.with_values({name: 1.0}), lambda: rsc.sweep(DROP, {name: [1, 2]})):
        with pytest.raises(rsc.SceneError) as refusal:
            ask()
        assert told in str(refusal.value) and "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"contact.*.friction": 0.1, "contact.free_end.friction": 0.2}, "contact.free_end.friction = 0.2: must be given once"),
        ({"rotor.eccentricity": [0, 0], "rotor.eccentricity.angle": 1.0}, "left out beside its angle"),
        ({"rotor.eccentricity.angle": 1e7}, "rotor.eccentricity.angle = 10000000.0"),
        ({"contact.*.ring_eccentricity.amount": "1 N"}, "contact.drive_end.ring_eccentricity.amount = '1 N'"),
    ],
)
def test_values_that_cannot_be_are_refused_in_one_line(values, told):
    with pytest.raises(rsc.SceneError) as refusal:
        DROP.with_values(values)
    assert told in str(refusal.value) and "\n" not in str(refusal.value)


def test_a_rotor_without_eccentricity_has_none_that_leads():
    balanced, name = DROP.with_values({"rotor.eccentricity": [0.0, 0.0]}), "rotor.eccentricity.angle"
    for ask in (lambda: value_of(balanced, name), lambda: balanced.with_values({name: 1.0})):
        with pytest.raises(rsc.SceneError, match=r"rotor\.eccentricity = .*: must be other than zero at some displacement"):
            ask()


@pytest.mark.parametrize("name", SCENES)
def test_names_of_tables_are_known_without_what_is_in_them(name):
    scene = rsc.Scene.from_dict(SCENES[name])
    assert scene.table_names == list(scene.tables)


def test_a_table_that_a_scene_need_not_have_is_given_by_its_keys():
    speeds = {"limits.maximum_continuous": "6000 rpm", "limits.trip": "6600 rpm"}
    scene = DROP.with_values({**speeds, "report.units": "us"})
    assert (scene.limits.maximum_continuous, scene.limits.trip) == (100.0, 110.0) and scene.report.units == "us"
    with pytest.raises(rsc.SceneError, match="maximum_continuous"):
        DROP.with_values({"limits.trip": 110.0})


def test_names_of_tables_are_those_of_contacts_clearances_and_limits():
    watched = {**DROP.to_dict(), "limits": {"maximum_continuous": 100.0}}
    watched["clearance"] = [{"name": "probe", "rotor_coordinate": 0, "gap": 1e-3}]
    scene = rsc.Scene.from_dict(watched)
    assert scene.table_names == list(scene.tables)
    assert scene.table_names[-2:] == ["clearance.probe", "limits"]
