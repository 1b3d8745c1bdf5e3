"""Whatever a scene holds, nothing is written that is not read again as the same: over the product of all terms."""

import copy
import pickle
import tomllib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

import rsc
from any_scene import scenes
from rsc.errors import SceneError
from rsc.scene.files.toml_text import toml_text, toml_value
from rsc.scene.scene import Scene
from rsc.scene.values import physical_values, with_entries

SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]


def is_plain(value):
    """Whether a value is made of Python's own numbers, texts, lists and dicts."""
    if type(value) in (list, dict):
        return all(map(is_plain, value.values() if isinstance(value, dict) else value))
    return type(value) in (bool, int, float, str)


def comes_back(content):
    """Every way in which a scene is written and read."""
    try:
        scene = Scene.from_dict(content)
    except SceneError as refusal:  # bodies and starts drawn at random do not all fit together
        assert "\n" not in str(refusal)
        return False
    written = scene.to_dict()
    assert is_plain(written), written
    text = scene.to_toml()
    assert tomllib.loads(text) == written
    assert Scene.from_dict(written) == Scene.from_toml(text) == Scene.from_stored(text, "result") == scene
    assert scene.with_values({}) == pickle.loads(pickle.dumps(scene)) == copy.deepcopy(scene) == scene
    speed = scene.drive.speed[0]  # a reduced rotor is known for the speeds of its run alone
    assert scene.steady(speed).steady(speed) == scene.steady(speed)
    if scene.drive.inertia is None:
        twice = scene.mirrored().mirrored()
        assert (twice.drive, twice.contacts, twice.start) == (scene.drive, scene.contacts, scene.start)
    for name, number in list(physical_values(scene).items())[:4]:
        assert with_entries(scene, {name: number}).to_toml() == text
    return True


@settings(max_examples=40, deadline=None, suppress_health_check=SLOW, derandomize=True)
@given(content=scenes())
def test_a_scene_of_any_terms_comes_back_equal(content):
    comes_back(content)


@pytest.mark.nightly
def test_a_thousand_scenes_of_any_terms_come_back_equal():
    equal = []

    @settings(max_examples=1300, deadline=None, suppress_health_check=SLOW, derandomize=True, database=None)
    @given(content=scenes())
    def each(content):
        equal.append(comes_back(content))

    each()
    assert sum(equal) >= 1000


def test_numbers_and_texts_of_numpy_become_plain():
    content = {
        "rotor": {"model": np.str_("laval"), "mass": np.float64(2.0), "frequency": np.float32(30.0), "damping_ratio": 0.02},
        "stator": {"model": "rigid"},
        "contact": {"gap": np.float64(1e-3), "friction": np.float64(0.2), "stiffness": np.int64(10**6), "name": np.str_("seal")},
        "drive": {"speed": np.array([10.0, 20.0]), "duration": np.float64(0.5)},
        "solver": {"method": np.str_("rk45"), "max_steps": np.int64(10**6)},
        "output": {"velocities": np.True_},
        "clearance": [{"name": np.str_("oil"), "gap": np.float64(1e-3), "rotor_coordinate": np.int64(0)}],
    }
    assert comes_back(content)
    scene = Scene.from_dict(content).with_values({"contact.gap": np.float64(2e-3), "drive.speed": np.float64(50.0)})
    assert is_plain(scene.to_dict())


@pytest.mark.parametrize("value", [np.float64(1.0), np.str_("a"), None, float("nan"), float("inf"), (1.0, 2.0), {"a": None}, 1j])
def test_the_writer_refuses_what_would_not_be_read(value):
    for place, content in (("rotor.mass", {"rotor": {"mass": value}}), (r"rotor.load\[1\]", {"rotor": {"load": [1.0, value]}})):
        with pytest.raises(TypeError, match=rf"{place}(\.a)? = "):
            toml_text(content)


@pytest.mark.parametrize("text", ["", 'a "quoted" name', "back\\slash", "tab\t\nline", "\x00\x7f", "µ – 轴", "😀"])
def test_texts_are_written_as_toml(text):
    assert tomllib.loads(f"key = {toml_value(text)}") == {"key": text}


def test_a_text_that_cannot_be_written_is_refused():
    content = {"rotor": {"model": "machine", "file": "a\ud800.npz", "contact": 1}, "stator": {"model": "rigid"},
               "contact": {"gap": 1e-3, "friction": 0.1, "stiffness": 1e6}, "drive": {"speed": 1.0, "duration": 1.0}}  # fmt: skip
    with pytest.raises(rsc.SceneError, match=r"rotor\.file"):
        Scene.from_dict(content)
