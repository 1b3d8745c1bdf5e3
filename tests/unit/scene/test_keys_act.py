"""Every key of [drive], [start] and [contact] changes the equations or the state at time 0; one that does not has no effect."""

from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import pytest

from rsc.errors import SceneError
from rsc.scene.keys.keys import known_keys
from rsc.scene.scene import Scene
from rsc.scene.tables.contacts import Contact
from rsc.scene.tables.drive import Drive
from rsc.scene.tables.start import Start
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from scenes import DRIVEN, LAVAL, SCENES, changed

ROOT = Path(__file__).parents[3]
CHAINS = changed(SCENES["chains"], contact={"diameter": 0.05})
SLIDING = changed(contact={"diameter": 0.05, "slip_velocity": 0.02, "race_inertia": 1e-3, "race_drag": 1e-4})
WALLS = changed(contact={"gap": None, "diameter": 0.05, "stator_diameter": 0.052})
SCHEDULED = changed(drive={"speed": None, "duration": None, "schedule": [[0.0, 50.0], [0.2, 60.0], [0.4, 55.0]]})
RUNNING = changed(rotor={"eccentricity": 1e-5}, start={"running": True})
HUNG = changed(rotor={"gravity": 9.81}, start={"rest": True})
STEADY = changed(drive={"speed": 50.0}, start={"whirl": "backward"})
BEARING = {"negative_stiffness": 2e4, "proportional": 6e4, "integral": 1e5, "derivative": 40.0, "derivative_filter": 1e4,
           "amplifier": 500.0}  # fmt: skip
FLOATING = changed(rotor={"magnetic_bearings": [[0, BEARING]]}, start={"rotor": [[3e-4, 0.0]], "rotor_states": [[1e-4, 0.0]] * 3})


def started(scene, **keys):
    """A scene with other keys in its [start]."""
    return changed(scene, start={**scene["start"], **keys})


def pair(scene, table, key, value):
    """A scene with a key, and the same with another value of it."""
    other = {**scene[table], key: value}
    return scene, {**scene, table: other}


# (scene, the same with another value of the key), or the file of the tests that show it
EXAMPLES = {
    Drive: {
        "speed": pair(LAVAL, "drive", "speed", [50.0, 61.0]),
        "duration": pair(LAVAL, "drive", "duration", 0.5),
        "schedule": pair(SCHEDULED, "drive", "schedule", [[0.0, 50.0], [0.2, 60.0], [0.4, 56.0]]),
        "inertia": pair(DRIVEN, "drive", "inertia", 0.06),
        "torque": pair(DRIVEN, "drive", "torque", [[0.0, 2.0], [50.0, 1.1], [60.0, 0.0]]),
        "trip": pair(DRIVEN, "drive", "trip", 0.2),
        "coast": pair(DRIVEN, "drive", "coast", [[0.0, -1.0], [80.0, -2.0]]),
    },
    Start: {
        "rest": (HUNG, {**HUNG, "start": {"centre": True}}),
        "centre": ({**HUNG, "start": {"centre": True}}, HUNG),
        "running": (RUNNING, {**RUNNING, "start": {"rest": True}}),
        "whirl": (STEADY, {**STEADY, "start": {"rest": True}}),
        "rotor": (LAVAL, started(LAVAL, rotor=[[2.5e-3, 0.0]])),
        "rotor_velocity": (LAVAL, started(LAVAL, rotor_velocity=[[0.0, -0.9]])),
        "stator": (LAVAL, started(LAVAL, stator=[[1.4e-3, 0.0]])),
        "stator_velocity": (LAVAL, started(LAVAL, stator_velocity=[[0.0, -0.5]])),
        "rotor_states": (FLOATING, started(FLOATING, rotor_states=[[2e-4, 0.0]] * 3)),
        "stator_states": "test_first_order_states.py",
        "impulse": (LAVAL, started(LAVAL, impulse=[0.1, 0.0])),
        "allow_penetration": (started(LAVAL, stator=[[0.0, 0.0]]), started(LAVAL, stator=[[0.0, 0.0]], allow_penetration=False)),
    },
    Contact: {
        "name": (changed(contact={"name": "seal"}), changed(contact={"name": "ring"})),
        "rotor_coordinate": pair(CHAINS, "contact", "rotor_coordinate", 2),
        "stator_coordinate": pair(CHAINS, "contact", "stator_coordinate", 0),
        "rotor_node": "test_several_machine.py",
        "stator_node": "test_several_machine.py",
        "at": "test_shaft_scene.py",
        "stator_at": "test_shaft_scene.py",
        "gap": pair(LAVAL, "contact", "gap", 1.1e-3),
        "stator_diameter": pair(WALLS, "contact", "stator_diameter", 0.0521),
        "friction": pair(LAVAL, "contact", "friction", 0.21),
        "stiffness": pair(LAVAL, "contact", "stiffness", 3.6e6),
        "damping_ratio": pair(LAVAL, "contact", "damping_ratio", 0.06),
        "damping": (changed(contact={"damping_ratio": None, "damping": 9.0}), changed(contact={"damping_ratio": None})),
        "diameter": pair(SLIDING, "contact", "diameter", 0.06),
        "ring_eccentricity": pair(LAVAL, "contact", "ring_eccentricity", [2e-4, 70.0]),
        "offset": pair(LAVAL, "contact", "offset", [1e-4, 5e-5]),
        "slip_velocity": pair(SLIDING, "contact", "slip_velocity", 0.03),
        "race_inertia": pair(SLIDING, "contact", "race_inertia", 2e-3),
        "race_drag": pair(SLIDING, "contact", "race_drag", 2e-4),
        "yield_force": pair(LAVAL, "contact", "yield_force", 1e4),
    },
}  # fmt: skip
DRIVEN_KEYS = ("inertia", "torque", "trip", "coast")  # such a drive turns forward only
CASES = [(section, key) for section, keys in EXAMPLES.items() for key, example in keys.items() if not isinstance(example, str)]


def flat(value):
    """Every number of nested dataclasses, comparable."""
    if is_dataclass(value):
        return {item.name: flat(getattr(value, item.name)) for item in fields(value)}
    if isinstance(value, np.ndarray):
        return value.shape, value.tolist()
    return [flat(each) for each in value] if isinstance(value, tuple | list) else value


def outcome(content):
    """The equations of a scene and the state at their start, or the refusal."""
    try:
        scene = Scene.from_dict(content)
        system = assemble(scene)
        return flat(system), flat(initial_state(scene, system))
    except SceneError as refusal:
        return str(refusal)


@pytest.mark.parametrize("section", EXAMPLES)
def test_every_key_has_an_example(section):
    assert set(EXAMPLES[section]) == set(known_keys(section)), "a new key is shown here to change the equations"
    for key, where in EXAMPLES[section].items():
        if isinstance(where, str):
            (path,) = (ROOT / "tests").rglob(where)
            assert key in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(("section", "key"), CASES, ids=[f"{section.__name__}.{key}" for section, key in CASES])
def test_a_key_changes_the_equations_or_their_start(section, key):
    one, other = EXAMPLES[section][key]
    told = outcome(one)
    assert told == outcome(one) != outcome(other)
    refused = [each for each in (told, outcome(other)) if isinstance(each, str)]
    assert not refused or key == "allow_penetration", refused


def test_a_key_that_changes_nothing_is_noticed():
    """The check of these tests: a title is read and kept, and no equation has it."""
    assert outcome(LAVAL) == outcome({**LAVAL, "title": "another"})


def reflected(value):
    """The image of numbers, of a vector y + i z that is -y + i z."""
    if is_dataclass(value):
        return {item.name: reflected(getattr(value, item.name)) for item in fields(value)}
    return -np.conj(value) if np.iscomplexobj(value) else value


@pytest.mark.parametrize(("section", "key"), [(section, key) for section, key in CASES if key not in DRIVEN_KEYS])
def test_a_key_has_its_sign_in_the_mirror_image(section, key):
    """The equations and the start of the mirrored scene are the mirrored ones: `mirror` of `declare`."""
    for content in EXAMPLES[section][key]:
        if isinstance(outcome(content), str):
            continue
        scene = Scene.from_dict(content)
        image, system = assemble(scene.mirrored()), assemble(scene)
        assert flat(image) == flat(system.mirrored())
        state = reflected(initial_state(scene, system))
        for name, found in vars(initial_state(scene.mirrored(), image)).items():
            assert found is state[name] is None or np.allclose(found, state[name], rtol=1e-9, atol=1e-15), name
