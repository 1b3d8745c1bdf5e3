"""Scenes with several contacts: their tables, names and values, what is refused, and who treats one contact only."""

import copy

import numpy as np
import pytest

import rsc
from rsc.analysis.follow.least_friction import mu_min
from rsc.analysis.survey.survey import survey
from rsc.errors import RscError, SceneError, SolverError
from rsc.scene.scene import Scene
from rsc.scene.values import physical_values, value_of, with_entries
from rsc.system.assemble import assemble
from scenes import TWO


def scene(**second):
    """The scene with two contacts, the second one changed."""
    content = copy.deepcopy(TWO)
    changed = content["contact"][1] | second
    content["contact"][1] = {key: value for key, value in changed.items() if value is not None}
    return Scene.from_dict(content)


def test_round_trips_as_dict_and_text():
    own = scene()
    assert [contact.name for contact in own.contacts] == ["seal", "ring"]
    assert Scene.from_dict(own.to_dict()) == own
    assert Scene.from_toml(own.to_toml()) == own
    assert own.to_toml().count("[[contact]]") == 2


def test_one_table_in_a_list_is_one_contact():
    content = copy.deepcopy(TWO)
    alone = Scene.from_dict({**content, "contact": content["contact"][1:]})
    assert alone == Scene.from_dict({**content, "contact": content["contact"][1]})
    assert alone.contact.name == "ring" and isinstance(alone.to_dict()["contact"], dict)
    assert alone.with_values({"contact.friction": 0.3}) == alone.with_values({"contact.ring.friction": 0.3})


def test_a_whole_number_with_a_point_is_a_coordinate():
    own = scene(rotor_coordinate=2.0, stator_coordinate=1.0)
    assert own == scene() and isinstance(own.contacts[1].stator_coordinate, int)


def test_every_contact_has_its_rows_and_offset_in_the_system():
    system = assemble(scene(offset=[2e-5, -1e-5]))
    seal, ring = system.contacts
    assert np.array_equal(seal.rotor, [1, 0, 0]) and np.array_equal(ring.rotor, [0, 0, 1])
    assert np.array_equal(seal.stator, [1, 0]) and np.array_equal(ring.stator, [0, 1])
    assert seal.offset == 0.0 and ring.offset == 2e-5 - 1e-5j and ring.name == "ring"
    assert system.mirrored().contacts[1].offset == -2e-5 - 1e-5j
    assert np.isnan(system.rotor.contact).all()  # so that nobody takes one of them for the only one


def test_the_mirror_image_of_the_mirror_image():
    own = scene(offset=[2e-5, -1e-5], ring_eccentricity=[1e-5, 30.0])
    assert own.mirrored().contacts[1].offset == -2e-5 - 1e-5j
    assert own.mirrored().mirrored() == own


def test_values_have_the_name_of_their_contact():
    own = scene()
    changed = own.with_values({"contact.seal.friction": 0.3, "contact.ring.damping": 5.0})
    assert changed.contacts[0].friction == 0.3 and changed.contacts[1].friction == own.contacts[1].friction
    assert changed.contacts[1].damping == 5.0 and changed.contacts[1].damping_ratio is None
    assert value_of(own, "contact.ring.stiffness").unit == "N/m"
    moved = with_entries(scene(offset=[1e-5, 0.0]), {"contact.ring.offset[1]": 2e-5})
    assert moved.contacts[1].offset == 1e-5 + 2e-5j
    names = physical_values(own)
    assert {"contact.seal.friction", "contact.ring.friction"} <= set(names) and "contact.friction" not in names


@pytest.mark.parametrize(
    ("name", "told"),
    {
        "contact.friction": "contact.seal or contact.ring",
        "contact.sael.friction": "contact.seal or contact.ring",
        "contact.seal.frction": "friction",
        "contact.seal": "contact.seal or contact.ring",
    }.items(),
)
def test_a_value_of_no_contact_is_refused(name, told):
    for ask in (lambda: scene().with_values({name: 0.1}), lambda: value_of(scene(), name)):
        with pytest.raises(SceneError) as refusal:
            ask()
        assert told in str(refusal.value) and "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("second", "told"),
    [
        ({"name": "seal"}, "contact[1].name = 'seal': must be different from that of contact[0]"),
        ({"name": None}, "contact[1].name = (missing): must be given"),
        ({"name": "2nd"}, "a name of at most 40 letters"),
        ({"name": "a.b"}, "a name of at most 40 letters"),
        ({"offset": [2e-4, 0.0]}, "contact.ring.offset = [0.0002, 0.0]: must be shorter than the gap"),
        ({"offset": [0.0, -1.5e-4]}, "shorter than the gap"),
        ({"rotor_coordinate": 3}, "contact.ring.rotor_coordinate = 3: must be a whole number from 0 to 2"),
        ({"slip_velocity": 0.1}, "it needs contact.diameter"),
        ({"sping": 1.0}, "a key of [contact.ring]"),
    ],
)
def test_a_contact_that_cannot_be_is_one_line(second, told):
    with pytest.raises(SceneError) as refusal:
        scene(**second)
    assert told in str(refusal.value) and "\n" not in str(refusal.value)


@pytest.mark.parametrize("contacts", [[], 100, [3.0, {}], "seal", 3])
def test_other_contents_than_tables_are_one_line(contacts):
    many = [{**TWO["contact"][0], "name": f"c{i}"} for i in range(contacts)] if contacts == 100 else contacts
    with pytest.raises(SceneError, match=r"one to 8 tables|a table") as refusal:
        Scene.from_dict({**TWO, "contact": many})
    assert "\n" not in str(refusal.value)


def test_a_start_in_the_wall_of_one_of_them_names_it():
    with pytest.raises(SceneError, match="inside the wall of ring"):
        Scene.from_dict({**TWO, "start": {"rotor": [[0, 0], [0, 0], [3e-4, 0]]}})
    with pytest.raises(SceneError, match="impulse"):
        Scene.from_dict({**TWO, "start": {"impulse": [1.0, 0.0]}})


FOR_ONE = {
    "predict": lambda own: rsc.predict(own, 60.0),
    "predict_many": lambda own: rsc.predict_many([own, own], [50.0, 60.0]),
    "crossing": lambda own: rsc.crossing(own, -50.0, [20.0, 100.0]),
    "delay": lambda own: rsc.delay(own, -50.0),
    "fold": lambda own: rsc.fold(own, -50.0, [20.0, 100.0]),
    "force_ratios": rsc.force_ratios,
    "smallest_impulse": lambda own: rsc.smallest_impulse(own, 60.0),
    "sensitivity": rsc.sensitivity,
    "survey": survey,
    "mu_min": lambda own: mu_min(own, 60.0),
    "a start on a whirl": lambda own: rsc.simulate(own.with_values({"start.whirl": "backward"})),
}


SEVERAL = "predict", "smallest_impulse", "sensitivity"  # these take several contacts, but none away from the bearing centre


@pytest.mark.parametrize("ask", [ask for name, ask in FOR_ONE.items() if name not in SEVERAL])
def test_what_treats_one_contact_refuses_several_in_one_line(ask):
    with pytest.raises(SolverError, match=r"2 contacts \(seal, ring\)") as refusal:
        ask(scene())
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("ask", FOR_ONE.values())
def test_what_is_predicted_around_the_bearing_centre_refuses_an_offset(ask):
    alone = Scene.from_dict({**TWO, "contact": {**TWO["contact"][0], "offset": [2e-5, 0.0]}})
    with pytest.raises(RscError, match=r"contact\.offset") as refusal:
        ask(alone)
    assert "\n" not in str(refusal.value)
