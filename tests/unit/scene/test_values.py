"""Single values of a scene by their names."""

import pytest

import rsc
from rsc.scene.values import physical_values, value_of, with_entries
from scenes import LAVAL, SCENES

DISK, CHAINS = rsc.Scene.from_dict(SCENES["gyroscopic disk"]), rsc.Scene.from_dict(SCENES["chains"])
SCENE = rsc.Scene.from_dict(LAVAL, "laval.toml")


@pytest.mark.parametrize(
    ("scene", "name", "unit", "dimension"),
    [
        (SCENE, "contact.gap", "m", "length"),
        (SCENE, "contact.friction", "1", "dimensionless"),
        (SCENE, "drive.speed", "Hz", "frequency"),
        (SCENE, "rotor.eccentricity", "m", "length"),
        (SCENE, "start.rotor[0][1]", "m", "length"),
        (SCENE, "start.rotor_velocity[0][0]", "m/s", "velocity"),
        (SCENE, "solver.max_steps", "1", ""),
        (SCENE, "solver.method", "", ""),
        (DISK, "rotor.stiffness[0][1]", "N/rad", "cross stiffness"),
        (DISK, "rotor.eccentricity[1]", "deg", "angle in degrees"),
        (CHAINS, "rotor.masses[2]", "kg", "mass"),
        (CHAINS, "rotor.eccentricity[0]", "m", "length"),
        (SCENE, "drive.schedule[1][0]", "s", "time"),
    ],
)
def test_a_value_has_its_unit(scene, name, unit, dimension):
    value = value_of(scene, name)
    assert (value.unit, value.dimension) == (unit, dimension) and value.meaning.endswith(".")


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("contact.fricton", 'did you mean "contact.friction"'),
        ("fricton", "contact.friction"),
        ("rotor.masses", "rotor.mass"),
        ("drive.schedule", "drive.schedule[0][0]"),
        ("rotor.mass[0]", "no list"),
        ("start.rotor[0][2]", "single number"),
        ("title", "key of a scene"),
        ("rotor.mass]", "key of a scene"),
        ("contact.__class__", "key of [contact]"),
    ],
)
def test_a_name_that_is_none_is_refused_in_one_line(name, hint):
    with pytest.raises(rsc.SceneError) as refusal:
        value_of(SCENE, name)
    message = str(refusal.value)
    assert message.startswith("laval.toml: ") and "\n" not in message
    assert hint in message


def test_a_value_is_read_with_its_unit_and_range():
    assert value_of(SCENE, "contact.gap").read("0.2 mm") == 0.0002
    assert value_of(SCENE, "drive.speed").read("3000 rpm") == 50.0
    assert value_of(SCENE, "start.whirl").read("backward") == "backward" and value_of(SCENE, "start.whirl").read(-60) == -60.0
    for name, raw in (("contact.friction", -1.0), ("contact.gap", "1 kg"), ("solver.method", "rk4"), ("start.whirl", "forward")):
        with pytest.raises(rsc.SceneError, match=name):
            value_of(SCENE, name).read(raw)


def test_entries_of_lists_change_alone_and_of_matrices_with_their_mirror_image():
    changed = with_entries(CHAINS, {"rotor.masses[1]": 2.5, "rotor.masses[2]": 1.25, "contact.gap": 2e-3})
    assert changed.rotor.masses == (1.0, 2.5, 1.25) and changed.contact.gap == 2e-3
    assert with_entries(DISK, {"rotor.stiffness[1][0]": -3000.0}).rotor.stiffness[0][1] == -3000.0
    hit = with_entries(SCENE.with_values({"start.rest": True}), {"start.rotor_velocity[0][1]": 0.5})
    assert hit.start.rotor_velocity == (0.5j,) and hit.start.rotor == (0j,)
    with pytest.raises(rsc.SceneError, match=r"rotor.masses\[7\]"):
        with_entries(CHAINS, {"rotor.masses[7]": 1.0})


@pytest.mark.parametrize("name", ["whirl, unbalance, run-up", "gyroscopic disk", "chains", "rigid wall", "eccentric ring"])
def test_every_physical_value_can_be_changed_by_its_name(name):
    scene = rsc.Scene.from_dict(SCENES[name])
    values = physical_values(scene)
    assert {"contact.gap", "contact.friction", "contact.stiffness"} <= set(values)
    for key, number in values.items():
        assert with_entries(scene, {key: number}) == scene
        assert with_entries(scene, {key: number * 1.0001}) != scene
