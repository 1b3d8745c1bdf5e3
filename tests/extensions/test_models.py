"""A rotor and a stator model from outside: nothing but their classes, and scenes, runs and predictions follow from those."""

import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import rsc
from rsc.scene.bodies.body_model import RotorModel
from rsc.scene.bodies.models import ROTORS, STATORS
from rsc.scene.values import value_of
from rsc.system.assemble import assemble
from scenes import LAVAL, changed
from systems import quantities

sys.path.append(str(Path(__file__).parents[2] / "tools"))

HELD = {
    "model": "held", "mass": 2.0, "diametral_inertia": 0.02, "polar_inertia": 0.03, "places": [-0.2, 0.3],
    "stiffnesses": ["40 kN/m", "30 kN/m"], "dampings": [4.0, 5.0], "eccentricity": [5e-5, 30.0],
}  # fmt: skip
TWIN = {"model": "twin", "mass": 0.25, "frequency_y": 150.0, "frequency_z": 170.0, "damping_ratio": 0.1}
START = {"rotor": [[0.9e-3, 0.0], [0.0, 1e-3]], "rotor_velocity": [[0.0, -0.5], [0.0, 0.0]]}


@pytest.fixture(scope="module", autouse=True)
def registered():
    """Both models for this file only: the reference of scenes is written from all that are registered."""
    import held_rotor
    import twin_stator

    yield
    del ROTORS[held_rotor.HeldRotor.model], STATORS[twin_stator.TwinStator.model]


def held(**tables):
    return rsc.Scene.from_dict(changed(LAVAL, rotor=HELD, start=START, drive={"duration": 0.1}, **tables))


def as_matrices():
    """The same rotor by model "matrices": springs and dashpots added up by hand."""
    def matrix(first, second):
        cross = -0.2 * first + 0.3 * second
        return [[first + second, cross], [cross, 0.04 * first + 0.09 * second]]

    rotor = {
        "model": "matrices", "mass": [[2.0, 0.0], [0.0, 0.02]], "stiffness": matrix(4e4, 3e4), "damping": matrix(4.0, 5.0),
        "gyroscopic": [[0.0, 0.0], [0.0, 0.03]], "tilt_coordinates": [1], "eccentricity": [[5e-5, 30.0], 0.0],
    }  # fmt: skip
    return rsc.Scene.from_dict(changed(LAVAL, rotor=rotor, start=START, drive={"duration": 0.1}))


def alike(found, wanted, rtol=1e-14):
    for place, value in quantities(found).items():
        other = quantities(wanted)[place]
        assert (value is None) == (other is None), place
        if value is not None:
            np.testing.assert_allclose(value, other, rtol=rtol, atol=1e-14 * np.abs(other).max(initial=0.0), err_msg=str(place))


def test_a_rotor_model_is_simulated_and_predicted_as_its_matrices():
    scene, wanted = held(), as_matrices()
    alike(assemble(scene), assemble(wanted))
    own, other = rsc.simulate(scene), rsc.simulate(wanted)
    assert np.abs(own.rotor - other.rotor).max() < 1e-6 * scene.contact.gap and own.contact_onsets == other.contact_onsets > 0
    pairs = zip(rsc.predict(scene, 50.0), rsc.predict(wanted, 50.0), strict=True)
    assert all(abs(one.frequency / two.frequency - 1.0) < 1e-12 for one, two in pairs) and rsc.predict(scene, 50.0)


def test_its_scene_is_stored_and_changed_by_name_and_mirrored(tmp_path):
    scene = held()
    assert rsc.Scene.from_toml(scene.to_toml()) == scene and rsc.Scene.from_dict(scene.to_dict()) == scene
    rsc.simulate(scene, path=tmp_path / "run.h5")
    assert rsc.load(tmp_path / "run.h5").scene == scene
    softer = scene.with_values({"rotor.mass": "3 kg"})
    assert assemble(softer).rotor.mass[0, 0] == 3.0 and value_of(scene, "rotor.stiffnesses[1]").unit == "N/m"
    alike(assemble(scene.mirrored()), assemble(scene).mirrored())
    assert scene.mirrored().mirrored() == scene


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"places": [0.1, 0.1]}, "rotor.places"), ({"mass": -1.0}, "rotor.mass"), ({"stifness": 1.0}, "rotor.stifness"),
        ({"dampings": [1.0]}, "rotor.dampings"), ({"load": [[0.0, 1.0]]}, "rotor.load"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_line(keys, told):
    with pytest.raises(rsc.SceneError) as refused:
        rsc.Scene.from_dict(changed(LAVAL, rotor={**HELD, **keys}, start=START))
    assert told in str(refused.value) and "\n" not in str(refused.value)


def test_a_model_without_a_matrix_says_which():
    class Massless(RotorModel):
        n_coordinates = 1

        def stiffness_matrix(self):
            return [[1.0]]

    with pytest.raises(TypeError, match=r"damping_matrix.*mass_matrix"):
        Massless()


def test_a_stator_model_is_simulated_as_a_ring_with_such_supports():
    twin = rsc.Scene.from_dict(changed(LAVAL, stator=TWIN, drive={"duration": 0.1}))
    y, z = (0.25 * (2.0 * np.pi * each) ** 2 for each in (150.0, 170.0))
    supports = [[0, [0.5 * (y - z), 0.0, 0.0, 0.5 * (z - y)]]]
    ring = {"model": "laval", "mass": 0.25, "stiffness": 0.5 * (y + z), "damping_ratio": 0.1, "supports": supports}
    wanted = rsc.Scene.from_dict(changed(LAVAL, stator=ring, drive={"duration": 0.1}))
    alike(assemble(twin), assemble(wanted))
    own, other = rsc.simulate(twin), rsc.simulate(wanted)
    assert np.abs(own.stator - other.stator).max() < 1e-6 * twin.contact.gap
    assert {item.name for item in fields(type(twin.stator))} == set(TWIN) - {"model"}


def test_the_reference_of_scenes_has_both():
    import scene_reference

    text = scene_reference.tables()
    assert '### `model = "held"` (rotor)' in text and "Where along the shaft the two springs are" in text
    assert '### `model = "twin"` (stator)' in text and "A ring with one natural frequency in y and another in z." in text
